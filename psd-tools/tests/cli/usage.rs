//! Messages about wrong usage and about input that has no effect.

use super::*;

#[test]
fn wrong_usage_says_what_to_do() {
    let folder = folder();
    let at = folder.path();
    std::fs::write(at.join("two-metres.csv"), "diameter [m],Q3\n1,0\n2,1\n").expect("written");
    let report = done(at, &["stats", "two-metres.csv"]);
    assert!(
        report.contains("the largest diameter is 2 m: is the unit right?"),
        "{report}"
    );
    std::fs::write(
        at.join("bad.csv"),
        "diameter [mm],Q3\n1,0\n2,0.5\n3,0.4\n4,1\n",
    )
    .expect("written");
    let message = refused(at, &["stats", "bad.csv"]);
    assert!(
        message.contains("bad.csv:4: the share 0.4 below 0.5"),
        "{message}"
    );
    for (arguments, message) in [
        (&["stats", "no.csv"][..], "the file cannot be read"),
        (
            &["stats", "{ kind = \"lognormal\" }"],
            "weighting: is missing",
        ),
        (&["stats", "{ kind = "], "{ kind = :"),
        (&["compare", "grain.psd.csv"], "give a second one"),
        (
            &["sample", "grain.psd.csv", "--number", "0"],
            "0 is not in 1..",
        ),
        (
            &["convert", "grain.psd.csv", "--cut", "0.9,0.1"],
            "0 <= LOW < HIGH <= 1",
        ),
        (
            &["convert", "grain.psd.csv", "--to-unit", "inch"],
            "expected one of m, cm",
        ),
        (
            &["convert", "grain.psd.csv", "--squeeze", "100"],
            "choose a factor below",
        ),
        (
            &["convert", "{ kind = \"monodisperse\", diameter = 1e-3 }"],
            "one size",
        ),
        (
            &["check", "grain.psd.csv", "--target", LOGNORMAL],
            "no list of sizes",
        ),
        (
            &["stats", "grain.psd.csv", "--in-class", "flat"],
            "quantity-uniform, log-uniform",
        ),
        (
            &["stats", "grain.psd.csv", "--mean", "2,2"],
            "two different whole numbers",
        ),
    ] {
        let found = refused(at, arguments);
        assert!(found.contains(message), "{arguments:?}: {found}");
    }
    let output = psd(at, &["--help"]);
    assert!(text(&output.stdout).contains("mercury-psd check hopper"));
    assert!(done(at, &["completions", "bash"]).contains("mercury-psd"));
}

#[test]
fn what_would_have_no_effect_is_refused() {
    let folder = folder();
    let at = folder.path();
    let by_alone = refused(at, &["convert", "grain.psd.csv", "--by", "number"]);
    assert!(
        by_alone.contains("--cut <LOW,HIGH>|--squeeze"),
        "{by_alone}"
    );
    for reshaping in [["--cut", "0.01,0.99"], ["--squeeze", "0.5"]] {
        let arguments = [
            "convert",
            "grain.psd.csv",
            "--by",
            "number",
            "-o",
            "out.csv",
        ];
        done(at, &[&arguments[..], &reshaping].concat());
    }
}

#[test]
fn shares_of_which_one_was_forgotten_are_named() {
    let folder = folder();
    let at = folder.path();
    let mixture = |shares: [&str; 2]| {
        let part = |share: &str, d: &str| {
            format!("{{ share = {share}, kind = \"monodisperse\", diameter = {d} }}")
        };
        let of = [part(shares[0], "1e-3"), part(shares[1], "2e-3")].join(", ");
        format!("{{ kind = \"mixture\", weighting = \"volume\", of = [{of}] }}")
    };
    for (shares, said) in [
        (
            ["60", "30"],
            "note: the shares of the mixture of distributions sum to 90, not to 100; they are scaled to 66.6667, 33.3333",
        ),
        (
            ["0.6", "0.3"],
            "note: the shares of the mixture of distributions sum to 0.9, not to 1; they are scaled to 0.666667, 0.333333",
        ),
    ] {
        let report = done(at, &["stats", &mixture(shares)]);
        assert!(report.contains(said), "{report}");
    }
    let report = done(at, &["stats", &mixture(["3", "1"])]);
    assert!(!report.contains("note:"), "{report}");
}

/// A check that does not mention a forgotten unit, or of shares that it divided, hides what it tested.
#[test]
fn a_check_says_what_was_noted_while_reading() {
    let folder = folder();
    let at = folder.path();
    let table = "diameter [mm],cumulative volume [%]\n1,0\n2,50\n4,99.5\n";
    std::fs::write(at.join("target.csv"), table).expect("written");
    let metres: String = (1..=20)
        .map(|i| format!("{}\n", 1.0 + 0.1 * f64::from(i)))
        .collect();
    std::fs::write(at.join("metres.csv"), format!("diameter [m]\n{metres}")).expect("written");
    let reported = [
        "divided by 99.5",
        "the largest diameter is 3 m: is the unit right?",
    ];
    let output = psd(at, &["check", "metres.csv", "--target", "target.csv"]);
    assert_eq!(output.status.code(), Some(1));
    let report = text(&output.stdout);
    for words in reported {
        assert!(report.contains(words), "{report}");
    }
    let output = psd(
        at,
        &["check", "metres.csv", "--target", "target.csv", "--json"],
    );
    let value: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(value["notes"].as_array().map(Vec::len), Some(2), "{value}");
    // Two samples.
    let output = psd(at, &["check", "metres.csv", "--versus", "metres.csv"]);
    assert_eq!(text(&output.stdout).matches(reported[1]).count(), 2);
}
