//! The scenes of the project through the library, each against what theory says of it. Checks that need seconds are made with the
//! validation page.

use mercury_tests::scene_checks::quick;

#[test]
fn every_quick_scene_check_holds() {
    let outcomes: Vec<_> = quick().iter().map(|case| case.run()).collect();
    let failures: Vec<_> = outcomes.iter().filter(|outcome| !outcome.holds()).collect();
    assert!(failures.is_empty(), "{failures:#?}");
}
