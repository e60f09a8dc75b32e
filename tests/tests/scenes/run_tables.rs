//! The pages of formats have the columns of the tables of runs as these are declared.
//!
//! `MERCURY_BLESS=1 cargo test -p tests --test scenes run_tables` adds a section for a new table to `docs/formats/tables.md`. Read what it wrote.

use std::fs;
use std::path::Path;

use mercury_common::run_tables::{ALL, ENERGIES, TableSpec};

/// The page of tables with a section for a table that no page names.
fn with_section(page: &str, table: &TableSpec) -> String {
    let (file, name) = (format!("`<prefix>.{}`", table.file), table.name());
    let end = page.find("\n\n## ").expect("a list of tables");
    format!(
        "{}\n| {file} | [{name}](#{name}) |{}\n## {name}\n\n{file}.\n\n- Written by `mercury-solve` with {}: a row for each {}\n\n{}",
        &page[..end],
        &page[end..],
        table.from,
        table.row_of,
        table.markdown()
    )
}

#[test]
fn pages_describe_every_table_as_it_is_declared() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/formats");
    let entries = fs::read_dir(&folder).expect("the folder can be listed");
    let mut pages: Vec<String> = entries
        .filter_map(|entry| fs::read_to_string(entry.ok()?.path()).ok())
        .collect();
    for table in ALL.into_iter().chain([&ENERGIES]) {
        let text = table.markdown();
        let is_new = |page: &String| !page.contains(&format!("`<prefix>.{}`", table.file));
        if std::env::var_os("MERCURY_BLESS").is_some() && pages.iter().all(is_new) {
            let path = folder.join("tables.md");
            let page = fs::read_to_string(&path).expect("the page of tables");
            pages.push(with_section(&page, table));
            fs::write(&path, &pages[pages.len() - 1]).expect("the page can be written");
        }
        assert!(
            pages.iter().any(|page| page.contains(&text)),
            "no page in docs/formats has the columns of {}; replace them by\n{text}\nor, of a new table, add them by MERCURY_BLESS=1 cargo test -p tests --test scenes run_tables",
            table.file
        );
    }
}

/// The section goes behind the last one, and its line behind those of the list.
#[test]
fn a_new_table_gets_a_section_and_a_line() {
    let page = "# Tables\n\n| file | section |\n|---|---|\n| a | b |\n\n## Heads\n\nText.\n";
    let with = with_section(page, &ENERGIES);
    assert!(with.contains("| a | b |\n| `<prefix>.ene` | [ene](#ene) |\n\n## Heads\n"));
    let section = format!(
        "Text.\n\n## ene\n\n`<prefix>.ene`.\n\n- Written by `mercury-solve` with a scene without ene = false in [output]: a row for each output time\n\n{}",
        ENERGIES.markdown()
    );
    assert!(with.ends_with(&section), "{with}");
}
