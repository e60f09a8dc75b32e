//! The checks of the validation page that are quick, each a test of its own: `cargo test -p tests --test validation oblique`
//! runs those with this word in their names. Checks of many runs are made with the page itself.

use std::collections::BTreeSet;
use std::process::ExitCode;

use libtest_mimic::{Arguments, Failed, Trial};
use mercury_tests::cases::{self, Case};
use mercury_tests::published::Published;
use mercury_tests::scene_checks;
use mercury_tests::selftests::{self, Comparison, Data};
use mercury_tests::shapes::{self, Shapes};

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let mut trials = tests_of("contacts", cases::all());
    trials.push(Trial::test(
        "contacts: no case has vanished",
        no_case_has_vanished,
    ));
    trials.extend(tests_of("scenes", scene_checks::quick()));
    trials.push(Trial::test("packing: energy beside other programs", || {
        compared(selftests::energy_of_a_packing())
    }));
    match (Shapes::find(), Published::find(), Data::find()) {
        (Some(shapes), Some(published), Some(data)) => {
            trials.extend(tests_of("shapes", shapes::quick(&shapes)));
            match published.quick() {
                Ok(cases) => trials.extend(tests_of("published", cases)),
                Err(error) => trials.push(Trial::test("published", move || {
                    Err(format!("{error:#}").into())
                })),
            }
            trials.extend(selftests::ALL.into_iter().map(|set_up| {
                let data = data.clone();
                let name = format!("MercuryDPM: set-up {}", set_up.number);
                Trial::test(name, move || compared((set_up.run)(&data)))
            }));
        }
        _ if std::env::var_os("CI").is_some() => {
            trials.push(Trial::test("reference data", || {
                Err("they are missing".into())
            }));
        }
        _ => println!("skipped what needs the reference data: they are not installed"),
    }
    libtest_mimic::run(&arguments, trials).exit_code()
}

/// A test for each row.
fn tests_of(subject: &str, cases: Vec<Case>) -> Vec<Trial> {
    let trial = |case: Case| {
        let name = format!("{subject}: {}", case.name);
        Trial::test(name, move || {
            let outcome = case.run();
            if outcome.holds() {
                Ok(())
            } else {
                Err(Failed::from(format!("{outcome:#?}")))
            }
        })
    };
    cases.into_iter().map(trial).collect()
}

/// Whether every number of a comparison agrees.
fn compared(comparison: anyhow::Result<Comparison>) -> Result<(), Failed> {
    let comparison = comparison.map_err(|error| format!("{error:#}"))?;
    if comparison.holds() {
        Ok(())
    } else {
        Err(Failed::from(format!("{comparison:#?}")))
    }
}

/// A new row needs its name in the file; a row that is removed has to be removed there, too.
fn no_case_has_vanished() -> Result<(), Failed> {
    let names: Vec<String> = cases::all().into_iter().map(|case| case.name).collect();
    let present: BTreeSet<&str> = names.iter().map(String::as_str).collect();
    let frozen: BTreeSet<&str> = include_str!("contact_cases.txt").lines().collect();
    let vanished: Vec<_> = frozen.difference(&present).collect();
    let unlisted: Vec<_> = present.difference(&frozen).collect();
    if present.len() != names.len() {
        return Err("a name stands for two rows".into());
    }
    if !vanished.is_empty() || !unlisted.is_empty() {
        return Err(format!("rows that have vanished: {vanished:#?}; rows missing in contact_cases.txt: {unlisted:#?}").into());
    }
    Ok(())
}
