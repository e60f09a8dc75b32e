//! Tables and laws: statistics, conversion, fits, Parquet.

use super::*;

#[test]
fn stats_of_a_table_a_law_and_a_list() {
    let folder = folder();
    let at = folder.path();
    let report = done(at, &["stats", "grain.psd.csv", LOGNORMAL]);
    assert!(
        report.contains("grain.psd.csv: 5 classes by volume, number-uniform inside"),
        "{report}"
    );
    assert!(report.contains("lognormal by volume"), "{report}");
    let value = json(at, &["stats", "grain.psd.csv", "--json", "--mean", "5,2"]);
    let by = &value["grain.psd.csv"]["by"];
    // 8 % below 3.5 mm, 31 % below 4 mm: the tenth part lies (2/23 of the volume) into the class 3.5 ... 4 mm, where
    // the volume goes with d^4: d^4 = 3.5^4 + 2/23 (4^4 - 3.5^4).
    let expected = 1e-3 * (3.5_f64.powi(4) + 2.0 / 23.0 * (256.0 - 3.5_f64.powi(4))).powf(0.25);
    let d10 = by["volume"]["d10"].as_f64().expect("a number");
    assert!((d10 / expected - 1.0).abs() < 1e-14, "{d10} {expected}");
    assert!(value["grain.psd.csv"]["mean_diameters"]["D[5,2]"].is_number());
    // Each of the requested means once, whether or not it is among those that are always printed.
    let report = done(
        at,
        &words("stats grain.psd.csv --mean 5,2 --mean 4,3 --mean 5,2"),
    );
    for mean in ["D[5,2]", "D[4,3]", "D[3,2]"] {
        assert_eq!(report.matches(mean).count(), 1, "{mean}: {report}");
    }
    // In-class models: visible for sieves.
    let other = json(
        at,
        &words("stats grain.psd.csv --in-class quantity-uniform --json"),
    );
    let other = other["grain.psd.csv"]["by"]["volume"]["d10"]
        .as_f64()
        .expect("a number");
    assert!((other / (1e-3 * (3.5 + 0.5 * 2.0 / 23.0)) - 1.0).abs() < 1e-14);
}

#[test]
fn convert_writes_what_all_readers_take() {
    let folder = folder();
    let at = folder.path();
    done(
        at,
        &words("convert grain.psd.csv --to fraction-number -o number.csv"),
    );
    let back = done(
        at,
        &words("convert number.csv --to cumulative-volume --percent"),
    );
    let shares: Vec<f64> = back
        .lines()
        .skip(2)
        .map(|line| {
            line.split(',')
                .nth(1)
                .expect("a share")
                .parse()
                .expect("a number")
        })
        .collect();
    for (share, expected) in shares.iter().zip([0.0, 8.0, 31.0, 63.0, 88.0, 100.0]) {
        assert!((share - expected).abs() < 1e-10, "{back}");
    }
    let report = done(
        at,
        &words("convert grain.psd.csv --cut 0.1,0.9 --scale 2 -o cut.toml"),
    );
    assert!(
        report.contains("removed:") && report.contains("% of the volume"),
        "{report}"
    );
    assert!(report.contains("scaled by 2"), "{report}");
    let law = std::fs::read_to_string(at.join("cut.toml")).expect("a law");
    assert!(law.starts_with("kind = \"classes\""), "{law}");
    done(at, &["stats", "cut.toml"]);
    // The table goes to standard output, what was changed to standard error.
    let output = psd(
        at,
        &["convert", LOGNORMAL, "--squeeze", "0.5", "--classes", "10"],
    );
    assert!(text(&output.stderr).contains("divided into 1000 classes"));
    assert!(
        text(&output.stdout)
            .starts_with("# in-class: number-uniform\ndiameter [mm],cumulative volume [-]\n")
    );
}

#[test]
fn fits_write_a_law_that_scenes_take() {
    let folder = folder();
    let at = folder.path();
    let report = done(
        at,
        &words("fit grain.psd.csv --count 2000 --bootstrap 19 -o grain"),
    );
    assert!(
        report.contains("lognormal: AIC") && report.contains("bootstrap p ="),
        "{report}"
    );
    for name in ["grain.psd.toml", "grain.svg", "grain.png"] {
        assert!(at.join(name).metadata().expect(name).len() > 100);
    }
    let report = done(at, &["compare", "grain.psd.csv", "grain.psd.toml"]);
    assert!(report.contains("d50"), "{report}");
    let value = json(
        at,
        &["fit", "grain.psd.csv", "--family", "lognormal", "--json"],
    );
    assert!(
        value["number_from"]
            .as_str()
            .expect("text")
            .starts_with("estimated")
    );
    let message = refused(at, &["fit", LOGNORMAL]);
    assert!(
        message.contains("a law has its parameters already"),
        "{message}"
    );
}

#[test]
fn parquet_is_read_and_written() {
    let folder = folder();
    let at = folder.path();
    done(
        at,
        &words("convert grain.psd.csv --to fraction-number -o number.parquet"),
    );
    done(
        at,
        &words("convert grain.psd.csv --to fraction-number -o number.csv"),
    );
    let [parquet, csv] = ["number.parquet", "number.csv"]
        .map(|name| json(at, &["stats", name, "--json"])[name].clone());
    assert!(parquet["by"]["volume"]["d50"].is_number());
    assert_eq!(parquet, csv);
    done(
        at,
        &words("sample grain.psd.csv --number 4000 -o sizes.parquet"),
    );
    let report = done(
        at,
        &["check", "sizes.parquet", "--target", "number.parquet"],
    );
    assert!(report.contains("PASSED"), "{report}");
    std::fs::write(
        at.join("cut.parquet"),
        &std::fs::read(at.join("sizes.parquet")).expect("bytes")[..200],
    )
    .expect("written");
    let message = refused(at, &["stats", "cut.parquet"]);
    assert!(message.contains("cut.parquet"), "{message}");
}
