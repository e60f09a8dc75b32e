//! The scenes of the project through the library, each against what theory says of it.

use mercury_tests::scene_checks::all;

#[test]
fn every_scene_check_holds() {
    let outcomes: Vec<_> = all().iter().map(|case| case.run()).collect();
    let failures: Vec<_> = outcomes.iter().filter(|outcome| !outcome.holds()).collect();
    assert!(failures.is_empty(), "{failures:#?}");
}
