//! The program as its users meet it: what it prints, which files it writes, how it ends.

use std::path::Path;
use std::process::{Command, Output};

use glam::DVec3;
use mercury_common::frames::{
    BodyFrame, BodyWriter, ClumpKind, FLAG_FIXED, FramesHeader, ParticleColumns, ParticleFrame,
    ParticleWriter,
};
use mercury_common::scene::parse_psd;
use mercury_common::sizes::SizeDistribution;
use mercury_psd::draw::{Method, draw};
use serde_json::Value;

/// Arguments, as typed on one line.
fn words(line: &str) -> Vec<&str> {
    line.split_whitespace().collect()
}

fn psd(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mercury-psd"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the program runs")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Standard output of a run that succeeds.
fn done(folder: &Path, arguments: &[&str]) -> String {
    let output = psd(folder, arguments);
    assert!(
        output.status.success(),
        "{arguments:?}: {}",
        text(&output.stderr)
    );
    text(&output.stdout)
}

/// Message of a run whose input is wrong.
fn refused(folder: &Path, arguments: &[&str]) -> String {
    let output = psd(folder, arguments);
    assert_eq!(
        output.status.code(),
        Some(2),
        "{arguments:?}: {}",
        text(&output.stdout)
    );
    text(&output.stderr)
}

fn json(folder: &Path, arguments: &[&str]) -> Value {
    serde_json::from_str(&done(folder, arguments)).expect("JSON")
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let grain = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/grain.psd.csv");
    std::fs::copy(grain, folder.path().join("grain.psd.csv")).expect("copied");
    folder
}

const LOGNORMAL: &str =
    "{ kind = \"lognormal\", median_diameter = 3e-3, sigma = 0.2, weighting = \"volume\" }";

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

/// A run folder as the solver leaves it: spheres and clumps by random sizes, one sphere that was there at the start, one fixed.
fn run_folder(at: &Path, spheres: &SizeDistribution, rods: &SizeDistribution) {
    std::fs::create_dir(at).expect("a folder");
    let header = FramesHeader {
        materials: vec!["grain".into(), "sand".into()],
        ..FramesHeader::default()
    };
    let columns = ParticleColumns::default();
    let mut writer =
        ParticleWriter::create(at.join("x.particles.arrow"), &header, &columns).expect("a file");
    let sizes = draw(spheres, 2000, Method::Random, 7);
    for (step, number) in [(0_u32, 1200), (1, 2000)] {
        // Those that come first leave first: the check must see all.
        let from = if step == 1 { 300 } else { 0 };
        let mut frame = ParticleFrame {
            time: f64::from(step),
            step: step.into(),
            ..ParticleFrame::default()
        };
        let mut push = |id: u32, diameter: f64, flags: u8| {
            let volume = std::f64::consts::PI / 6.0 * diameter.powi(3);
            frame.id.push(id);
            frame.material.push(0);
            frame.flags.push(flags);
            frame.mass.push(1400.0 * volume);
            frame.volume.push(volume);
            frame.radius.push(0.5 * diameter);
            // Large ones lie below.
            frame.position.push(DVec3::new(0.0, 0.0, -diameter));
            frame.velocity.push(DVec3::ZERO);
        };
        push(0, 1.0, 0);
        push(1, 1.0, FLAG_FIXED);
        for (i, d) in sizes[from..number].iter().enumerate() {
            push((2 + from + i) as u32, *d, 0);
        }
        writer.append(frame).expect("written");
    }
    let kinds = vec![ClumpKind {
        name: "rod".into(),
        surface: None,
    }];
    let mut writer =
        BodyWriter::create(at.join("x.bodies.arrow"), &header, &kinds).expect("a file");
    let volumes: Vec<f64> = draw(rods, 1000, Method::Random, 8)
        .iter()
        .map(|d| std::f64::consts::PI / 6.0 * d.powi(3))
        .collect();
    let n = volumes.len();
    writer
        .append(BodyFrame {
            time: 1.0,
            step: 1,
            id: (0..n as u32).collect(),
            clump: vec![0; n],
            material: vec![1; n],
            flags: vec![0; n],
            mass: volumes.iter().map(|v| 2600.0 * v).collect(),
            volume: volumes,
            scale: vec![1.0; n],
            radius: vec![1.0; n],
            position: vec![DVec3::ZERO; n],
            velocity: vec![DVec3::ZERO; n],
            orientation: vec![glam::DQuat::IDENTITY; n],
            angular_velocity: vec![DVec3::ZERO; n],
            principal_moments: vec![DVec3::ONE; n],
            force: vec![DVec3::ZERO; n],
            torque: vec![DVec3::ZERO; n],
        })
        .expect("written");
    drop(writer);
    let part = |name: &str, clump: &str, sizes: &SizeDistribution, share: f64| {
        let psd: String = sizes
            .statement()
            .to_string()
            .lines()
            .map(|line| format!("{line}\n"))
            .collect();
        format!(
            "[[insertions.mixture]]\nmaterial = \"{name}\"\n{clump}number_share = {share:?}\n[insertions.mixture.psd]\n{psd}"
        )
    };
    let plan = format!(
        "[particles]\nat_start = 2\n[[materials]]\nname = \"grain\"\ndensity = 1400.0\n[[materials]]\nname = \"sand\"\ndensity = 2600.0\n\
         [[insertions]]\nname = \"feed\"\n[insertions.total]\nnumber = 3000.0\n{}{}",
        part("grain", "", spheres, 2.0 / 3.0),
        part("sand", "clump = \"rod\"\n", rods, 1.0 / 3.0),
    );
    std::fs::write(at.join("plan.toml"), plan).expect("written");
}

fn law(text: &str) -> SizeDistribution {
    SizeDistribution::from_scene(&parse_psd("law", text, None).expect("a law")).expect("sizes")
}

#[test]
fn runs_are_checked_against_their_plan() {
    let folder = folder();
    let at = folder.path();
    let spheres =
        law("kind = \"uniform\"\nmin_diameter = 1e-3\nmax_diameter = 2e-3\nweighting = \"volume\"");
    let rods =
        law("kind = \"lognormal\"\nmedian_diameter = 3e-3\nsigma = 0.2\nweighting = \"volume\"");
    run_folder(&at.join("x"), &spheres, &rods);
    let value = json(at, &["check", "x", "--json"]);
    assert_eq!(value["passed"], true);
    assert_eq!(value["kinds"]["grain"]["number"], 2000);
    assert_eq!(value["kinds"]["rod"]["number"], 1000);
    // 2000 of 2000 grains: their mass is that of the request up to the spread of 2000 random ones (some per cent).
    let masses = ["mass", "requested_mass"]
        .map(|key| value["kinds"]["grain"][key].as_f64().expect("a mass"));
    assert!((masses[0] / masses[1] - 1.0).abs() < 0.1, "{masses:?}");
    let report = done(at, &["check", "x"]);
    assert!(report.contains("expected for the total"), "{report}");
    // At the end 300 have left; above 1.5 mm deep lie the large ones.
    let value = json(at, &["check", "x", "--of", "grain", "--at", "1", "--json"]);
    assert_eq!(value["kinds"]["grain"]["number"], 1700);
    let split = [
        "check",
        "x",
        "--of",
        "grain",
        "--where",
        "z<-1.5e-3",
        "--versus-where",
        "z>=-1.5e-3",
    ];
    let output = psd(at, &split);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("the two differ"));
    let report = done(at, &words("check x --of grain --at 0 --versus-at 1"));
    assert!(report.contains("1200 against 1700 particles"), "{report}");
    // Against a wrong target.
    let output = psd(
        at,
        &["check", "x", "--of", "rod", "--target", "grain.psd.csv"],
    );
    assert_eq!(output.status.code(), Some(1));
    done(at, &["stats", "x"]);
    for (arguments, message) in [
        (
            &["check", "x", "--of", "glass"][..],
            "no particles of \"glass\"",
        ),
        (
            &["check", "x", "--target", "grain.psd.csv"],
            "choose one with --of",
        ),
        (
            &["check", "x", "--at", "7"],
            "no frame at 7 s: the run goes from 0 to 1 s",
        ),
        (&["check", "x", "--where", "r<1"], "is no condition"),
        (
            &["check", "."],
            "no run: there is no file *.particles.arrow",
        ),
        (&["check", "missing"], "cannot be read"),
        (&["convert", "x"], "several kinds of particles"),
    ] {
        let found = refused(at, arguments);
        assert!(found.contains(message), "{arguments:?}: {found}");
    }
    std::fs::remove_file(at.join("x/plan.toml")).expect("removed");
    let message = refused(at, &["check", "x", "--of", "grain"]);
    assert!(message.contains("no single distribution"), "{message}");
}

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
