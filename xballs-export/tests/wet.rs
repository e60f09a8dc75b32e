//! Liquid bridges and droplets of a run.

#[expect(dead_code, reason = "the other tests read .data files too")]
mod run_folder;

use std::fs;
use std::path::Path;
use std::process::Command;

use glam::DVec3;
use mercury_common::frames::{
    ColumnKind, ColumnSpec, ContactColumns, ContactReader, ContactWriter, DropletFrame,
    DropletWriter, FramesHeader, ParticleColumns, ParticleReader, ParticleWriter,
};
use run_folder::folder_with_run;

/// Exit code and standard error.
fn export(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_mercury-export"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    (output.status.code(), said)
}

/// The run of the other tests with a liquid bridge at the pair, none at the wall, and three droplets in flight.
fn wet_run() -> tempfile::TempDir {
    let place = folder_with_run();
    let path = |kind: &str| place.path().join(format!("run/run.{kind}.arrow"));
    let dry = ContactReader::open(path("contacts")).unwrap();
    let frames: Vec<_> = (0..4).map(|number| dry.frame(number).unwrap()).collect();
    let columns = ContactColumns {
        bridge: true,
        ..ContactColumns::default()
    };
    let header = FramesHeader::default();
    let mut contacts = ContactWriter::create(path("contacts"), &header, &columns).unwrap();
    let mut droplets = DropletWriter::create(path("droplets"), &header, &()).unwrap();
    for mut frame in frames {
        let (time, step) = (frame.time, frame.step);
        frame.bridge_volume = Some(vec![1e-3, 0.0]);
        frame.bridge_normal = Some(vec![-2.0, 0.0]);
        frame.bridge_shear = Some(vec![DVec3::ZERO; 2]);
        contacts.append(frame).unwrap();
        let at = |x: f64| DVec3::new(x, 0.5, 1.5 - 0.1 * time);
        let flying = DropletFrame {
            time,
            step,
            id: vec![0, 1, 2],
            spray: vec![0; 3],
            position: vec![at(1.0), at(2.0), at(3.0)],
            velocity: vec![-DVec3::Z; 3],
            radius: vec![0.05; 3],
        };
        droplets.append(flying).unwrap();
    }
    place
}

#[test]
fn bridges_and_droplets_are_series_of_their_own() {
    let place = wet_run();
    assert_eq!(
        export(place.path(), &["vtu", "run", "--compression", "none"]),
        (Some(0), String::new())
    );
    let file = |name: &str| {
        let bytes = fs::read(place.path().join("run/vtu").join(name)).unwrap();
        String::from_utf8_lossy(&bytes).into_owned()
    };
    for (name, points, array) in [
        // A line has two points.
        ("run.bridges.0003.vtu", 2, "bridge_volume"),
        ("run.contacts.0003.vtu", 4, "bridge_normal"),
        ("run.droplets.0003.vtu", 3, "diameter"),
    ] {
        let text = file(name);
        assert!(
            text.contains(&format!("NumberOfPoints=\"{points}\"")),
            "{name}"
        );
        assert!(text.contains(array), "{name}");
    }
    let script = file("run.paraview.py");
    assert!(script.contains("series(\"bridges\")") && script.contains("series(\"droplets\")"));
    // Without contacts there are no bridges, and none of the export before.
    let without = ["vtu", "run", "--force", "--no-contacts"];
    assert_eq!(export(place.path(), &without), (Some(0), String::new()));
    assert!(!file("run.paraview.py").contains("bridges"));
}

#[test]
fn pictures_show_bridges_and_droplets() {
    let place = wet_run();
    let draw = |folder: &str, more: &[&str]| {
        let mut arguments = vec!["png", "run", "--frames", "last", "--size", "320x240"];
        arguments.extend(["--output", folder]);
        arguments.extend(more);
        assert_eq!(export(place.path(), &arguments), (Some(0), String::new()));
        let file = fs::read_dir(place.path().join(folder)).unwrap();
        let png = file
            .map(|entry| entry.unwrap().path())
            .find(|path| path.extension().is_some_and(|ending| ending == "png"));
        fs::read(png.unwrap()).unwrap()
    };
    let all = [
        draw("plain", &["--opacity", "0.15"]),
        draw("bridges", &["--bridges"]),
        draw("contacts", &["--contacts"]),
        draw("droplets", &["--droplets", "--opacity", "0.15"]),
    ];
    for (k, one) in all.iter().enumerate() {
        assert!(all[..k].iter().all(|other| other != one), "{k}");
    }
}

#[test]
fn dry_runs_have_neither() {
    let place = folder_with_run();
    let no_bridges = "run/run.contacts.arrow: these contacts have no liquid bridges\n\
        help: --contacts draws all contacts; bridges need a `liquid` law at the materials of the scene\n";
    let no_droplets = "run/run.particles.arrow: no file of droplets beside the particles\n\
        help: a scene with [[sprays]] and droplets = true in [output] writes them; without --droplets the particles are drawn\n";
    for (flag, message) in [("--bridges", no_bridges), ("--droplets", no_droplets)] {
        assert_eq!(
            export(place.path(), &["png", "run", flag]),
            (Some(2), message.to_owned())
        );
    }
    let (code, said) = export(place.path(), &["png", "run", "--bridges", "--contacts"]);
    assert_eq!(code, Some(2));
    assert!(said.contains("--contacts"), "{said}");
}

/// The table of particles has the liquid of bridges in its films; of frames that do not have it, the lines for a scene mention
/// it.
#[test]
fn particles_take_the_liquid_of_bridges_along() {
    for has_all in [true, false] {
        let place = folder_with_run();
        let path = place.path().join("run/run.particles.arrow");
        let dry = ParticleReader::open(&path).unwrap();
        let frames: Vec<_> = (0..4).map(|number| dry.frame(number).unwrap()).collect();
        let spec = |name: &str| ColumnSpec::new(name, ColumnKind::F64, "m3");
        let mut more = vec![spec("film_volume")];
        let mut values = vec![vec![1e-3, 2e-3, 0.0]];
        if has_all {
            more.push(spec("liquid_volume"));
            values.push(vec![1.5e-3, 2.25e-3, 0.0]);
        }
        let columns = ParticleColumns {
            body: true,
            angular_velocity: true,
            force: true,
            more,
            ..ParticleColumns::default()
        };
        let header = FramesHeader {
            materials: vec!["glass".to_owned(), "steel".to_owned()],
            domain: Some((DVec3::ZERO, DVec3::new(4.0, 1.0, 2.0))),
            ..FramesHeader::default()
        };
        let mut wet = ParticleWriter::create(&path, &header, &columns).unwrap();
        for mut frame in frames {
            frame.more.clone_from(&values);
            wet.append(frame).unwrap();
        }
        drop(wet);
        let arguments = [
            "particles",
            "run",
            "--region",
            "x=0.5..2.5",
            "--frames",
            "last",
        ];
        let output = Command::new(env!("CARGO_BIN_EXE_mercury-export"))
            .current_dir(place.path())
            .args(arguments)
            .output()
            .unwrap();
        let both = [output.stdout, output.stderr].map(|said| String::from_utf8(said).unwrap());
        assert_eq!(output.status.code(), Some(0), "{both:?}");
        let table = place.path().join("run/particles/run.0003.csv");
        let rows = mercury_common::formats::particle_csv::read_particle_csv(&table).unwrap();
        let films: Vec<f64> = rows.iter().map(|row| row.properties[0].1).collect();
        let expected = if has_all {
            [1.5e-3, 2.25e-3]
        } else {
            [1e-3, 2e-3]
        };
        assert_eq!(films, expected);
        let is_said = both.concat().contains("no column liquid_volume");
        assert_eq!(is_said, !has_all, "{both:?}");
    }
}
