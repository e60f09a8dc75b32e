//! Published cases of the field that need a second each; the others are made with the validation page.

use mercury_tests::published::Published;

#[test]
fn every_quick_published_case_holds() {
    let Some(published) = Published::find() else {
        assert!(
            std::env::var_os("CI").is_none(),
            "the reference data are missing"
        );
        println!("skipped: the reference data are not installed");
        return;
    };
    let cases = published.quick().unwrap();
    let outcomes: Vec<_> = cases.iter().map(|case| case.run()).collect();
    let failures: Vec<_> = outcomes.iter().filter(|outcome| !outcome.holds()).collect();
    assert!(failures.is_empty(), "{failures:#?}");
}
