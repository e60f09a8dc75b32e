//! Contacts, walls and loads that are missing, were cut, or are not among what was selected.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::run_folder::folder_with_run;
use glam::DVec3;
use mercury_common::frames::{
    ContactColumns, ContactWriter, FramesHeader, TriangleLoadFrame, TriangleLoadWriter,
};

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

/// Takes the last `bytes` of a file away.
fn cut(folder: &Path, file: &str, bytes: usize) {
    let path = folder.join(file);
    let whole = fs::read(&path).unwrap();
    fs::write(&path, &whole[..whole.len() - bytes]).unwrap();
}

const DAMAGE: &str = "a frame that goes beyond the end of the file behind 3 whole frames\n\
    help: the frames before it can be used; the file was cut or changed after it was written\n";

#[test]
fn tables_that_were_cut_are_reported_once() {
    let place = folder_with_run();
    let run = |arguments: &[&str]| {
        let (code, said) = export(place.path(), arguments);
        assert_eq!(code, Some(0), "{said}");
        said
    };
    assert_eq!(run(&["vtu", "run"]), "");
    cut(place.path(), "run/run.contacts.arrow", 100);
    let warning = format!(
        "warning: only the first 3 frames of contacts could be used, up to t = 1 s; later ones are left out\nrun/run.contacts.arrow: {DAMAGE}"
    );
    assert_eq!(run(&["vtu", "run", "--force", "--quiet"]), warning);
    assert_eq!(run(&["vtu", "run", "--force", "--frames", "..3"]), "");
    assert!(place.path().join("run/vtu/run.contacts.pvd").exists());
    assert_eq!(run(&["vtu", "run", "--force", "--frames", "last"]), warning);
    // No list that names no file, and none of the export before.
    for name in ["pvd", "0000.vtu"] {
        let file = format!("run/vtu/run.contacts.{name}");
        assert!(!place.path().join(&file).exists(), "{file}");
    }
    let script = fs::read_to_string(place.path().join("run/vtu/run.paraview.py")).unwrap();
    assert!(!script.contains("series(\"contacts\")"));
    let small = ["png", "run", "--contacts", "--size", "160x120", "--force"];
    assert_eq!(
        run(&small),
        warning.replace("later ones are left out", "later pictures are without them")
    );
    cut(place.path(), "run/run.walls.arrow", 100);
    let walls = format!(
        "warning: only the first 3 frames of walls could be used, up to t = 1 s; walls are left out of later frames\nrun/run.walls.arrow: {DAMAGE}"
    );
    let no_contacts = ["vtu", "run", "--no-contacts", "--force"];
    assert_eq!(run(&no_contacts), walls);
}

#[test]
fn loads_that_were_cut_are_reported_once() {
    let place = folder_with_run();
    let path = place.path().join("run/run.triangle_loads.arrow");
    let mut writer = TriangleLoadWriter::create(&path, &FramesHeader::default(), &()).unwrap();
    for k in 0..4u32 {
        let frame = TriangleLoadFrame {
            time: 0.5 * f64::from(k),
            step: 50 * u64::from(k),
            wall: vec![0],
            triangle: vec![1],
            pressure: vec![2.5e3],
            shear: vec![DVec3::X],
            force: vec![-DVec3::Z],
            slip_power: vec![0.125],
        };
        writer.append(frame).unwrap();
    }
    drop(writer);
    cut(place.path(), "run/run.triangle_loads.arrow", 100);
    let warning = format!(
        "warning: only the first 3 frames of loads on triangles could be used, up to t = 1 s; later walls are without them\nrun/run.triangle_loads.arrow: {DAMAGE}"
    );
    assert_eq!(export(place.path(), &["vtu", "run"]), (Some(0), warning));
    let without = ["vtu", "run", "--no-walls", "-o", "out"];
    assert_eq!(export(place.path(), &without), (Some(0), String::new()));
}

#[test]
fn what_cannot_be_opened_can_be_left_out() {
    let place = folder_with_run();
    fs::write(place.path().join("run/run.walls.arrow"), "walls").unwrap();
    let found = "run/run.walls.arrow: a message that goes beyond the end of the file, expected an Arrow IPC stream that begins with its schema\n";
    for command in ["vtu", "png"] {
        let (code, said) = export(place.path(), &[command, "run", "--frames", "0"]);
        assert_eq!(code, Some(2));
        assert_eq!(said, format!("{found}help: --no-walls leaves walls out\n"));
        let without = [command, "run", "--frames", "0", "--no-walls"];
        assert_eq!(export(place.path(), &without), (Some(0), String::new()));
    }
    // A reader that does not need the tables can ignore them.
    let csv = ["csv", "run"];
    assert_eq!(export(place.path(), &csv), (Some(0), String::new()));
}

#[test]
fn pictures_of_contacts_need_contacts() {
    let place = folder_with_run();
    fs::remove_file(place.path().join("run/run.contacts.arrow")).unwrap();
    let message = "run/run.particles.arrow: no file of contacts beside the particles\n\
        help: fstat = true in [output] of the scene writes them; without --contacts the particles are drawn\n";
    assert_eq!(
        export(place.path(), &["png", "run", "--contacts"]),
        (Some(2), message.to_owned())
    );
}

#[test]
fn contacts_of_other_times_are_reported() {
    let place = folder_with_run();
    let path = place.path().join("run/run.contacts.arrow");
    ContactWriter::create(&path, &FramesHeader::default(), &ContactColumns::default()).unwrap();
    let start = "note: run/run.contacts.arrow: no contacts were written at the times of";
    for (arguments, end) in [
        (["vtu", "run", "--frames", "all"], "these frames"),
        (["png", "run", "--contacts", "--frames=..3"], "3 frames"),
    ] {
        let expected = (Some(0), format!("{start} {end}\n"));
        assert_eq!(export(place.path(), &arguments), expected);
    }
    assert!(!place.path().join("run/vtu/run.contacts.pvd").exists());
}

#[test]
fn a_selection_of_nothing_is_reported() {
    let place = folder_with_run();
    for command in ["csv", "vtu"] {
        let (code, said) = export(place.path(), &[command, "run", "--region", "x=50..60"]);
        assert_eq!(code, Some(0));
        assert_eq!(said, "warning: no particle is selected in any frame\n");
    }
}

#[test]
fn negative_numbers_are_refused_for_what_they_are() {
    let place = folder_with_run();
    for (arguments, message) in [
        (
            ["gif", "run", "--duration", "-1"],
            "--duration -1: expected seconds above 0\n",
        ),
        (
            ["vtu", "run", "--frames", "-1"],
            "error: invalid value '-1' for '--frames <FRAMES>': expected all, last, a number, A..B (without B), A.., ..B, \"every N\", or a range with a stride, A..B/N\n\nFor more information, try '--help'.\n",
        ),
        (
            ["png", "run", "--strip", "-1"],
            "error: invalid value '-1' for '--strip <N>': expected 1 to 64 frames\n\nFor more information, try '--help'.\n",
        ),
    ] {
        let (code, said) = export(place.path(), &arguments);
        assert_eq!((code, said.as_str()), (Some(2), message), "{arguments:?}");
    }
}

#[test]
fn a_strip_counts_the_frames_that_it_shows() {
    let place = folder_with_run();
    for (number, line) in [
        ("2", "2 frames in run/png\n"),
        ("1", "1 frame in run/png\n"),
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_mercury-export"))
            .current_dir(place.path())
            .args([
                "png", "run", "--strip", number, "--size", "320x120", "--force",
            ])
            .output()
            .unwrap();
        let said = String::from_utf8(output.stdout).unwrap();
        assert_eq!(said, format!("{line}  run.strip.png\n"));
    }
}
