//! The stress cases, short. The long ones, and what stands behind each expectation: `docs/stability.csv`.
//!
//! `MERCURY_BLESS=1 cargo test -p tests --test scenes stress` writes the list of checks anew. Read what it wrote.

use std::path::Path;

use mercury_tests::stress::{CASES, Length, Outcome, compare_with_list, names};

#[test]
fn short_runs_meet_what_theory_expects() {
    let mut failed = String::new();
    let mut outcomes: Vec<Outcome> = Vec::new();
    for case in CASES {
        match case.run(Length::Short) {
            Ok(outcome) => outcomes.push(outcome),
            Err(error) => failed += &format!("{error:#}\n"),
        }
    }
    for (name, check) in outcomes.iter().flat_map(Outcome::failed) {
        failed += &format!("{name}: {} instead of {}\n", check.measured, check.expected);
    }
    for case in &outcomes {
        println!("{:20} {:8.2} s", case.scene, case.seconds);
    }
    assert!(failed.is_empty(), "{failed}");
    if std::env::var_os("MERCURY_BLESS").is_some() {
        let list = names(&outcomes).join("\n") + "\n";
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/stress/checks.txt");
        std::fs::write(path, list).expect("the list can be written");
    } else {
        compare_with_list(&outcomes).unwrap();
    }
}

/// A scene that no case runs stresses nothing.
#[test]
fn every_scene_has_its_case() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/stress");
    let index = std::fs::read_to_string(folder.join("README.md")).expect("an index");
    let mut count = 0;
    for entry in std::fs::read_dir(&folder).expect("the folder can be listed") {
        let path = entry.expect("the folder can be listed").path();
        if path.extension().is_some_and(|ending| ending == "toml") {
            let name = path.file_stem().unwrap_or_default().to_string_lossy();
            assert!(CASES.iter().any(|case| case.scene == name), "{name}");
            assert!(
                index.contains(&format!("`{name}.toml`")),
                "{name} is not in the index"
            );
            count += 1;
        }
    }
    assert_eq!(count, CASES.len());
}
