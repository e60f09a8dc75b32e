//! Samples of a distribution: how they are drawn, and checked against it.

use super::*;

#[test]
fn samples_of_a_law_pass_its_check_and_fail_that_of_another() {
    let folder = folder();
    let at = folder.path();
    done(
        at,
        &words("sample grain.psd.csv --number 3000 -o sizes.csv"),
    );
    let report = done(
        at,
        &words("check sizes.csv --target grain.psd.csv -o check"),
    );
    assert!(report.contains("PASSED"), "{report}");
    assert!(at.join("check.svg").exists() && at.join("check.png").exists());
    let output = psd(at, &["check", "sizes.csv", "--target", LOGNORMAL]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stdout).contains("FAILED"));
    // Two lists.
    done(
        at,
        &words("sample grain.psd.csv --number 2000 --seed 1 -o other.csv"),
    );
    let report = done(at, &["check", "sizes.csv", "--versus", "other.csv"]);
    assert!(report.contains("no difference is seen"), "{report}");
    let message = refused(at, &["check", "sizes.csv"]);
    assert!(message.contains("give --target FILE"), "{message}");
    done(
        at,
        &[
            "plot",
            "grain.psd.csv",
            "sizes.csv",
            LOGNORMAL,
            "--log",
            "--axis",
            "probability",
            "-o",
            "plot",
        ],
    );
    assert!(at.join("plot.svg").exists());
}

/// index.md: the rows of all four weightings, as the command line gives them.
#[test]
fn compat_mercury_gives_the_rows_of_the_reference_data() {
    let Some(data) = mercury_common::reference_data::shared("data/shapes/psd") else {
        return;
    };
    let read = |name: &str, unit: &str, kind: &str| {
        let arguments = [
            "stats", name, "--size", "radius", "--unit", unit, "--type", kind, "--compat",
            "mercury", "--json",
        ];
        json(&data, &arguments)[name]["by"].clone()
    };
    let apapm = read("APAPM.csv", "m", "cumulative-number");
    let lactose = read("CVDFLactose.csv", "um", "cumulative-volume");
    // In the digits of the page.
    for (by, word, rows, span) in [
        (
            &apapm,
            "number",
            [1.016_179_91e-3, 1.822_554_37e-3, 2.953_337_52e-3],
            1.062_881,
        ),
        (
            &apapm,
            "length",
            [1.142_596_76e-3, 2.177_713_31e-3, 3.307_872_41e-3],
            0.994_289,
        ),
        (
            &apapm,
            "area",
            [1.396_261_48e-3, 2.471_059_79e-3, 3.633_200_72e-3],
            0.905_255,
        ),
        (
            &apapm,
            "volume",
            [1.771_810_55e-3, 2.738_423_39e-3, 3.931_538_39e-3],
            0.788_676,
        ),
        (
            &lactose,
            "number",
            [1.083_907_28e-5, 2.561_977_59e-5, 9.599_086_62e-5],
            3.323_674,
        ),
        (
            &lactose,
            "length",
            [1.806_895_04e-5, 6.931_019_99e-5, 1.566_713_46e-4],
            1.999_740,
        ),
        (
            &lactose,
            "area",
            [4.441_452_60e-5, 1.093_447_13e-4, 2.178_390_28e-4],
            1.586_035,
        ),
        (
            &lactose,
            "volume",
            [7.426_692_58e-5, 1.494_331_29e-4, 2.861_555_68e-4],
            1.417_950,
        ),
    ] {
        for (key, expected) in ["d10", "d50", "d90"].into_iter().zip(rows) {
            let found = by[word][key].as_f64().expect("a number");
            let off = (found / expected - 1.0).abs();
            assert!(off < 0.51e-8, "{word} {key}: {found} {expected}");
        }
        let found = by[word]["span"].as_f64().expect("a number");
        assert!((found / span - 1.0).abs() < 0.51e-5, "{word} span: {found}");
    }
}

/// The reference data's folder; none where it is not installed.
fn reference() -> Option<std::path::PathBuf> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/shapes/psd");
    if !data.exists() {
        assert!(
            std::env::var_os("CI").is_none(),
            "{} is missing",
            data.display()
        );
        println!("skipped: {} is missing", data.display());
        return None;
    }
    Some(data)
}

/// index.md: MercuryDPM's random insertion is one of APAPM, its class-by-class one is not. Lists and target are files without header,
/// one of one column, one of two.
#[test]
fn lists_and_targets_without_header_have_flags_of_their_own() {
    let Some(data) = reference() else { return };
    let check = |list: &str, flags: &[&str]| {
        let mut arguments = vec!["check", list, "--target", "APAPM.csv", "--size", "radius"];
        arguments.extend(["--unit", "m", "--json"]);
        arguments.extend(flags);
        psd(&data, &arguments)
    };
    let typed = ["--target-type", "cumulative-number"];
    let random = "apapm_mercury_random_insertion_radii.csv";
    for flags in [
        &typed[..],
        // Of its own kind altogether, and by the flag that other commands have.
        &[
            "--target-size",
            "radius",
            "--target-unit",
            "m",
            "--target-type",
            "cumulative-number",
        ],
        &["--type", "cumulative-number"],
    ] {
        let output = check(random, flags);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let value: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        assert_eq!(value["passed"], true);
        let kind = &value["kinds"][random];
        assert_eq!(kind["number"], 7312);
        // The digits of the index: D = 0.0131.
        let near = |value: &Value, expected: f64, digit: f64| {
            let found = value.as_f64().expect("a number");
            assert!((found - expected).abs() <= 0.51 * digit, "{found}");
        };
        near(&kind["tests"]["Kolmogorov-Smirnov"]["value"], 0.0131, 1e-4);
        near(&kind["tests"]["Kolmogorov-Smirnov"]["p"], 0.164, 1e-3);
        let tests = kind["tests"].as_object().expect("an object");
        let names: Vec<&String> = tests.keys().collect();
        assert_eq!(names, ["Kolmogorov-Smirnov", "Anderson-Darling"]);
    }
    let manual = "apapm_mercury_manual_insertion_radii.csv";
    let output = check(manual, &typed);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    let value: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(value["kinds"][manual]["verdict"], "failed");
    // Another unit than the list's: grains of the target a thousand times too small.
    let output = check(random, &["--target-unit", "mm", typed[0], typed[1]]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stdout).contains("larger than the largest"));
    let message = refused(
        &data,
        &["check", random, "--target-type", "fraction-number"],
    );
    assert!(message.contains("--target"), "{message}");
}

#[test]
fn too_few_particles_leave_it_open() {
    let folder = folder();
    let at = folder.path();
    std::fs::write(at.join("one.csv"), "diameter [mm]\n4.2\n").expect("written");
    let output = psd(at, &["check", "one.csv", "--target", "grain.psd.csv"]);
    assert_eq!(output.status.code(), Some(1));
    let report = text(&output.stdout);
    assert!(
        report.contains("UNDETERMINED: too few particles (1): with fewer than 8 not even"),
        "{report}"
    );
    assert!(
        !report.contains("4.2 ... 4.2") && !report.contains("+-0,"),
        "{report}"
    );
    assert!(
        report.contains("too few to tell") && report.contains("no band"),
        "{report}"
    );
    let output = psd(at, &["check", "one.csv", "--versus", "one.csv"]);
    assert_eq!(output.status.code(), Some(1));
    let report = text(&output.stdout);
    assert!(
        report.contains("UNDETERMINED: too few particles (1 against 1)"),
        "{report}"
    );
    assert!(!report.contains("NaN"), "{report}");
    let output = psd(
        at,
        &["check", "one.csv", "--target", "grain.psd.csv", "--json"],
    );
    let value: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(value["kinds"]["one.csv"]["verdict"], "undetermined");
    assert_eq!(
        value["kinds"]["one.csv"]["quantiles"][0]["low"],
        Value::Null
    );
}

#[test]
fn lists_by_quota_say_so_and_are_checked_as_such() {
    let folder = folder();
    let at = folder.path();
    let by_quota = [
        "sample",
        "grain.psd.csv",
        "--number",
        "500",
        "--method",
        "quota",
        "-o",
    ];
    for name in ["quota.csv", "quota.parquet"] {
        done(at, &[&by_quota[..], &[name]].concat());
        let report = done(at, &["check", name, "--target", "grain.psd.csv"]);
        assert!(
            report.contains("note: sizes follow by quota, which fits better than chance"),
            "{report}"
        );
    }
    let list = std::fs::read_to_string(at.join("quota.csv")).expect("a list");
    assert!(
        list.starts_with("# sampling: quota\ndiameter [m]\n"),
        "{list}"
    );
    // Its first half is no quota any more, and is not called one.
    let half: String = list
        .lines()
        .take(252)
        .map(|line| format!("{line}\n"))
        .collect();
    std::fs::write(at.join("half.csv"), half).expect("written");
    let report = done(at, &["check", "half.csv", "--target", "grain.psd.csv"]);
    assert!(
        report.contains("note: the quota is not complete"),
        "{report}"
    );
    let random = [
        "sample",
        "grain.psd.csv",
        "--number",
        "500",
        "-o",
        "random.csv",
    ];
    done(at, &random);
    let report = done(at, &["check", "random.csv", "--target", "grain.psd.csv"]);
    assert!(!report.contains("quota"), "{report}");
}

#[test]
fn sizes_down_to_nothing_are_named_where_they_are_drawn() {
    let folder = folder();
    let at = folder.path();
    let table = "sieve [mm],retained [g]\n2,0\n1,30\npan,10\n";
    std::fs::write(at.join("pan.csv"), table).expect("written");
    let warning =
        "note: the class below 0.001 m (the pan, where sieves were used) holds 25 % by volume";
    let report = done(at, &["sample", "pan.csv", "-n", "100", "-o", "sizes.csv"]);
    assert!(
        report.contains(warning) && report.contains("--cut 0.01,1"),
        "{report}"
    );
    // Without a file the list has standard output for itself.
    let output = psd(at, &["sample", "pan.csv", "-n", "100"]);
    assert!(text(&output.stderr).contains(warning));
    assert!(text(&output.stdout).starts_with("diameter [m]\n"));
    done(
        at,
        &["convert", "pan.csv", "--cut", "0.01,1", "-o", "cut.csv"],
    );
    let report = done(at, &["sample", "cut.csv", "-n", "100", "-o", "sizes.csv"]);
    assert!(!report.contains("note:"), "{report}");
}
