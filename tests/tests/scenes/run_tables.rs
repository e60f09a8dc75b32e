//! The pages of formats have the columns of the tables of runs as these are declared.

use std::fs;
use std::path::Path;

use mercury_common::run_tables::{ALL, ENERGIES};

#[test]
fn pages_describe_every_table_as_it_is_declared() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/formats");
    let entries = fs::read_dir(folder).expect("the folder can be listed");
    let pages: Vec<String> = entries
        .filter_map(|entry| fs::read_to_string(entry.ok()?.path()).ok())
        .collect();
    for table in ALL.into_iter().chain([&ENERGIES]) {
        let text = table.markdown();
        assert!(
            pages.iter().any(|page| page.contains(&text)),
            "no page in docs/formats has the columns of {}; replace them by\n{text}",
            table.file
        );
    }
}
