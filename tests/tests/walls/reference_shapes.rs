//! Bodies that mclump makes of reference shapes behave as their shapes ask. Checks of many runs are made with the validation page.

use mercury_tests::shapes::{Shapes, quick};

#[test]
fn every_quick_check_of_a_reference_shape_holds() {
    let Some(shapes) = Shapes::find() else {
        assert!(
            std::env::var_os("CI").is_none(),
            "the reference data are missing"
        );
        println!("skipped: the reference data are not installed");
        return;
    };
    let outcomes: Vec<_> = quick(&shapes).iter().map(|case| case.run()).collect();
    let failures: Vec<_> = outcomes.iter().filter(|outcome| !outcome.holds()).collect();
    assert!(failures.is_empty(), "{failures:#?}");
}
