//! Every row of the table of contact cases, at its stated tolerance; and no row may vanish.

use std::collections::BTreeSet;

use mercury_tests::cases;

#[test]
fn every_case_holds() {
    let mut failures = Vec::new();
    for case in cases::all() {
        let outcome = case.run();
        let error = outcome.measured - outcome.expected;
        let line = format!(
            "{:<100} {:>24e} {:>24e} {:>10.2e} {:>10.2e}",
            outcome.name, outcome.expected, outcome.measured, error, outcome.allowed
        );
        println!("{} {line}", if outcome.holds() { "  " } else { "! " });
        if !outcome.holds() {
            failures.push(line);
        }
    }
    assert!(
        failures.is_empty(),
        "name, expected, measured, error, allowed:\n{}",
        failures.join("\n")
    );
}

/// The names of all rows. A new row needs its name in the file; a row that is removed has to be removed there, too.
#[test]
fn no_case_has_vanished() {
    let names: Vec<String> = cases::all().into_iter().map(|case| case.name).collect();
    let present: BTreeSet<&str> = names.iter().map(String::as_str).collect();
    assert_eq!(present.len(), names.len(), "a name stands for two rows");
    let frozen: BTreeSet<&str> = include_str!("contact_cases.txt").lines().collect();
    let vanished: Vec<_> = frozen.difference(&present).collect();
    let unlisted: Vec<_> = present.difference(&frozen).collect();
    assert!(
        vanished.is_empty(),
        "rows that have vanished: {vanished:#?}"
    );
    assert!(
        unlisted.is_empty(),
        "rows missing in contact_cases.txt: {unlisted:#?}"
    );
}
