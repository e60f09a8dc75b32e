//! Dependencies that the crates which every user builds must not have.

use std::collections::{BTreeSet, HashMap};
use std::fs;
use std::path::Path;

/// Names of packages, and of those that they depend on.
fn lock_file() -> HashMap<String, Vec<String>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../Cargo.lock");
    let text = fs::read_to_string(path).unwrap();
    let mut packages = HashMap::<String, Vec<String>>::new();
    for package in text.split("[[package]]").skip(1) {
        let name = package.split_once("name = \"").unwrap().1;
        let (name, rest) = name.split_once('"').unwrap();
        let list = rest.split_once("dependencies = [");
        let list = list.map_or("", |(_, list)| list.split_once(']').unwrap().0);
        let names = list.split('"').skip(1).step_by(2);
        let names = names.map(|entry| entry.split(' ').next().unwrap().to_owned());
        // Several versions of a package count as one.
        packages.entry(name.to_owned()).or_default().extend(names);
    }
    packages
}

/// polars and Parquet take long to build; a newcomer's first `cargo run --bin mercury-solve` must not wait for them.
#[test]
fn solver_and_clump_maker_build_without_polars_and_parquet() {
    let packages = lock_file();
    for root in [
        "coarse-grain",
        "common",
        "engine",
        "pictures",
        "solver",
        "mclump",
    ] {
        let (mut open, mut seen) = (vec![root.to_owned()], BTreeSet::new());
        while let Some(name) = open.pop() {
            if seen.insert(name.clone()) {
                open.extend(packages[&name].iter().cloned());
            }
        }
        let heavy = |name: &&String| {
            ["parquet", "tables"].contains(&name.as_str()) || name.starts_with("polars")
        };
        let found: Vec<&String> = seen.iter().filter(heavy).collect();
        assert!(found.is_empty(), "{root} depends on {found:?}");
    }
    let tables = &packages["tables"];
    for library in ["parquet", "polars"] {
        assert!(tables.iter().any(|name| name == library), "{library}");
    }
}
