//! The command line as a user meets it: files, messages, exit codes.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::run_folder::{DATA, folder_with_data, folder_with_run};
use glam::DVec3;
use mercury_common::frames::{FramesHeader, TriangleLoadFrame, TriangleLoadWriter};

fn export(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mercury-export"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap()
}

fn errors(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn succeeds(folder: &Path, arguments: &[&str]) -> String {
    let output = export(folder, arguments);
    assert_eq!(
        output.status.code(),
        Some(0),
        "{arguments:?}: {}",
        errors(&output)
    );
    assert_eq!(errors(&output), "");
    String::from_utf8(output.stdout).unwrap()
}

fn refused(folder: &Path, arguments: &[&str], message: &str) {
    let output = export(folder, arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    assert_eq!(errors(&output), message, "{arguments:?}");
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn a_run_becomes_series_for_paraview() {
    let place = folder_with_run();
    let said = succeeds(place.path(), &["vtu", "run"]);
    assert!(
        said.starts_with("4 frames in run/vtu\n  run.paraview.py\n  run.particles.pvd\n"),
        "{said}"
    );
    let mut expected = vec!["run.paraview.py".to_owned()];
    for kind in ["contacts", "particles", "walls"] {
        expected.push(format!("run.{kind}.pvd"));
        expected.extend((0..4).map(|k| format!("run.{kind}.{k:04}.vtu")));
    }
    expected.sort();
    assert_eq!(names(&place.path().join("run/vtu")), expected);
    let list = fs::read_to_string(place.path().join("run/vtu/run.walls.pvd")).unwrap();
    let tree = roxmltree::Document::parse(&list).unwrap();
    let times: Vec<&str> = tree
        .descendants()
        .filter_map(|node| node.attribute("timestep"))
        .collect();
    assert_eq!(times, ["0.0", "0.5", "1.0", "1.5"]);
}

#[test]
fn walls_show_the_loads_on_their_triangles() {
    let place = folder_with_run();
    let path = place.path().join("run/run.triangle_loads.arrow");
    let write = |triangle: u32| {
        let mut writer = TriangleLoadWriter::create(&path, &FramesHeader::default(), &()).unwrap();
        let frame = TriangleLoadFrame {
            time: 0.5,
            step: 50,
            wall: vec![0],
            triangle: vec![triangle],
            pressure: vec![2.5e3],
            shear: vec![DVec3::X],
            force: vec![-DVec3::Z],
            slip_power: vec![0.125],
        };
        writer.append(frame).unwrap();
    };
    write(1);
    succeeds(place.path(), &["vtu", "run", "--compression", "none"]);
    let frame =
        |k: u32| fs::read(place.path().join(format!("run/vtu/run.walls.{k:04}.vtu"))).unwrap();
    let has = |bytes: &[u8], part: &[u8]| bytes.windows(part.len()).any(|found| found == part);
    for name in ["pressure", "shear", "force", "slip_power"] {
        let name = format!("Name=\"{name}\"");
        assert!(has(&frame(1), name.as_bytes()), "{name}");
        assert!(
            !has(&frame(0), name.as_bytes()),
            "no loads were written then"
        );
    }
    // The floor is two triangles; the first bears nothing.
    let values: Vec<u8> = [0.0, 2.5e3f64]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    assert!(has(&frame(1), &values));
    write(2);
    refused(
        place.path(),
        &["vtu", "run", "--force"],
        "run/run.triangle_loads.arrow: at step 50: no triangle 2 of wall 0\n",
    );
}

#[test]
fn nothing_is_replaced_unless_requested() {
    let place = folder_with_run();
    for (command, file) in [
        ("vtu", "vtu/run.paraview.py"),
        ("xballs", "xballs/run.disp"),
        ("csv", "csv/run.particles.0000.csv"),
        ("parquet", "parquet/run.particles.parquet"),
        ("lammps", "lammps/run.lammpstrj"),
    ] {
        succeeds(place.path(), &[command, "run"]);
        let before = fs::read(place.path().join("run").join(file)).unwrap();
        refused(
            place.path(),
            &[command, "run"],
            &format!(
                "run/{file}: this file is there already\nhelp: --force replaces it, -o DIR writes elsewhere\n"
            ),
        );
        succeeds(place.path(), &[command, "run", "--force", "--quiet"]);
        assert_eq!(
            fs::read(place.path().join("run").join(file)).unwrap(),
            before,
            "{command}"
        );
        succeeds(place.path(), &[command, "run", "-o", "elsewhere"]);
    }
}

#[test]
fn frames_and_particles_can_be_selected() {
    let place = folder_with_run();
    let rows = |arguments: &[&str], file: &str| -> Vec<String> {
        let mut all = vec!["csv", "run", "--force", "-o", "out"];
        all.extend(arguments);
        succeeds(place.path(), &all);
        let text = fs::read_to_string(place.path().join("out").join(file)).unwrap();
        // Time and id.
        let ids = text.lines().skip(1).map(|line| {
            let mut fields = line.split(',');
            format!("{} {}", fields.next().unwrap(), fields.next().unwrap())
        });
        ids.collect()
    };
    let last = "run.particles.0003.csv";
    assert_eq!(
        rows(&["--frames", "last"], last),
        ["1.5 0", "1.5 4", "1.5 7"]
    );
    assert_eq!(names(&place.path().join("out")), [last]);
    assert_eq!(
        rows(&["--frames", "every 3", "--material", "steel"], last),
        ["1.5 7"]
    );
    assert_eq!(
        rows(&["--frames", "3", "--material", "0"], last),
        ["1.5 0", "1.5 4"]
    );
    assert_eq!(
        rows(&["--frames", "2..", "--region", "x=1.5..2.5"], last),
        ["1.5 4"]
    );
    refused(
        place.path(),
        &["csv", "run", "--material", "gold"],
        "run/run.particles.arrow: no material gold; the file knows glass, steel\n",
    );
    refused(
        place.path(),
        &["csv", "run", "--frames", "9"],
        "run/run.particles.arrow: no frame is selected; there are 0 to 3\n",
    );
    refused(
        place.path(),
        &["csv", "run", "--table", "contacts", "--region", "x=0..1"],
        "--region and --material select particles; contacts have neither\n",
    );
}

#[test]
fn a_table_that_the_run_wrote_as_text_is_exported_as_a_whole() {
    let place = folder_with_run();
    let table = "time [s],name,forward,mass [kg]\n0,gate,0,0\n0.5,\"a, b\",3,0.25\n";
    fs::write(place.path().join("run/run.flux.csv"), table).unwrap();
    let said = succeeds(place.path(), &["csv", "run", "--table", "flux"]);
    assert_eq!(said, "2 rows in run/csv/run.flux.csv\n");
    let text = |file: &str| fs::read_to_string(place.path().join(file)).unwrap();
    assert_eq!(text("run/csv/run.flux.csv"), table);
    // Numbers are numbers in Parquet, and the unit goes with the name.
    succeeds(place.path(), &["parquet", "run", "--table", "flux"]);
    let path = place.path().join("run/parquet/run.flux.parquet");
    let read = mercury_tables::Table::read_parquet(&path).unwrap();
    assert_eq!(read.values::<f64>("mass").unwrap(), [0.0, 0.25]);
    assert_eq!(read.values::<String>("name").unwrap(), ["gate", "a, b"]);
    assert_eq!(read.column("mass").unwrap().unit, "kg");
    // Messages for tables that are not there, and for rows that cannot be selected.
    for (arguments, expected) in [
        (
            &["csv", "run", "--table", "holds"][..],
            "run.holds.csv: there is no such table",
        ),
        (
            &["csv", "run", "--table", "wear_triangles"],
            "no file of wear_triangles beside the particles",
        ),
        (
            &[
                "csv", "run", "--table", "flux", "--frames", "last", "--force",
            ],
            "this one is written as a whole",
        ),
    ] {
        let output = export(place.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        let said = errors(&output);
        assert!(said.contains(expected), "{said}");
    }
}

#[test]
fn a_table_says_everything_that_the_frame_holds() {
    let place = folder_with_run();
    succeeds(place.path(), &["csv", "run", "--frames", "1"]);
    let text = fs::read_to_string(place.path().join("run/csv/run.particles.0001.csv")).unwrap();
    let mut lines = text.lines();
    assert_eq!(
        lines.next(),
        Some(
            "time [s],id,material,body,state,mass [kg],volume [m^3],radius [m],x [m],y [m],z [m],\
             vx [m/s],vy [m/s],vz [m/s],wx [rad/s],wy [rad/s],wz [rad/s],fx [N],fy [N],fz [N]"
        )
    );
    assert_eq!(
        lines.next(),
        Some("0.5,0,0,,0,0.1,0.2,0.5,1,0.1,0.3333333333333333,0,0.5,0,0,0,0,-0,-0,-1")
    );
    let said = succeeds(
        place.path(),
        &["csv", "run", "--table", "contacts", "-o", "c"],
    );
    assert!(said.starts_with("4 frames in c\n"), "{said}");
    let text = fs::read_to_string(place.path().join("c/run.contacts.0000.csv")).unwrap();
    assert!(
        text.starts_with("time [s],i,j,wall,px [m],py [m],pz [m],"),
        "{text}"
    );
    assert!(
        text.lines().nth(1).unwrap().starts_with("0,0,4,,"),
        "{text}"
    );
}

#[test]
fn data_goes_round_in_the_same_bytes() {
    let place = folder_with_data(DATA);
    succeeds(place.path(), &["xballs", "old.data", "-o", "out"]);
    assert_eq!(
        fs::read_to_string(place.path().join("out/old.data")).unwrap(),
        DATA
    );
    // And by way of the script that starts the viewer.
    succeeds(place.path(), &["xballs", "out/old.disp", "-o", "again"]);
    assert_eq!(
        fs::read_to_string(place.path().join("again/old.data")).unwrap(),
        DATA
    );
}

#[test]
fn a_damaged_data_file_gives_its_good_frames_and_one_message() {
    let cut = &DATA[..DATA.len() - 30];
    let place = folder_with_data(cut);
    for arguments in [
        vec!["vtu", "old.data", "--quiet"],
        vec!["xballs", "old.data", "-o", "x", "--quiet"],
        vec!["csv", "old.data", "--frames", "last", "--quiet"],
    ] {
        let output = export(place.path(), &arguments);
        assert_eq!(output.status.code(), Some(0));
        let frames = if arguments[0] == "csv" {
            "the input is damaged; of the requested frames 1 frame"
        } else {
            "only the first 2 frames"
        };
        let message = format!(
            "warning: {frames} could be used\n\
             old.data:8: the file ends after 0 of 1 particles of the frame at t = 0.2, expected 1 particle lines after the header in line 7\n\
             help: the frame is unfinished (the run was stopped while writing, or still runs); remove line 7 and all after it to use the frames before\n"
        );
        assert_eq!(errors(&output), message, "{arguments:?}");
    }
    let good: Vec<&str> = DATA.split_inclusive('\n').take(6).collect();
    assert_eq!(
        fs::read_to_string(place.path().join("x/old.data")).unwrap(),
        good.concat()
    );
    assert!(place.path().join("vtu/old.particles.0001.vtu").exists());
    assert!(place.path().join("csv/old.particles.0001.csv").exists());
}

#[test]
fn damaged_native_frames_give_their_good_ones_and_one_message() {
    let place = folder_with_run();
    let path = place.path().join("run/run.particles.arrow");
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() - 100]).unwrap();
    let output = export(place.path(), &["vtu", "run", "--quiet"]);
    assert_eq!(output.status.code(), Some(0));
    let reported = errors(&output);
    assert!(
        reported.starts_with(
            "warning: only the first 3 frames could be used\nrun/run.particles.arrow: "
        ),
        "{reported}"
    );
    assert!(reported.contains("behind 3 whole frames"), "{reported}");
    assert!(place.path().join("run/vtu/run.particles.0002.vtu").exists());
    assert!(!place.path().join("run/vtu/run.particles.0003.vtu").exists());
}

#[test]
fn inputs_that_are_none_are_refused_in_words() {
    let place = folder_with_data("");
    let expected = "expected a folder of mercury-solve, a .particles.arrow, .data, .disp or .xballs file, or a dump or data file of LAMMPS or LIGGGHTS";
    refused(
        place.path(),
        &["vtu", "nothing"],
        &format!("nothing: there is no such file or folder, {expected}\n"),
    );
    fs::write(place.path().join("notes.txt"), "notes").unwrap();
    refused(
        place.path(),
        &["vtu", "notes.txt"],
        &format!("notes.txt: neither a run folder nor a file of particles, {expected}\n"),
    );
    refused(
        place.path(),
        &["csv", "old.data"],
        "old.data: no frame is selected, or the input has none\n",
    );
    fs::create_dir(place.path().join("empty")).unwrap();
    refused(
        place.path(),
        &["csv", "empty"],
        "empty: no particles in this folder, expected a folder of mercury-solve, with a .particles.arrow or .data file\n",
    );
    for name in ["a.data", "b.data"] {
        fs::write(place.path().join("empty").join(name), DATA).unwrap();
    }
    refused(
        place.path(),
        &["csv", "empty"],
        "empty: several runs: empty/a.data, empty/b.data\nhelp: name the file instead of the folder\n",
    );
    fs::write(place.path().join("x.particles.arrow"), "no arrow").unwrap();
    let output = export(place.path(), &["csv", "x.particles.arrow"]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(
        errors(&output),
        "x.particles.arrow: no Arrow message at byte 0, expected an Arrow IPC stream that begins with its schema\n"
    );
    fs::write(place.path().join("x.disp"), "#!/bin/bash\nls\n").unwrap();
    refused(
        place.path(),
        &["csv", "x.disp"],
        "x.disp: no command for XBalls, expected a line that starts xballs with -f FILE.data\n",
    );
    fs::write(
        place.path().join("w.data"),
        "2 0 0 0 0 1 1 1\n1 2 3\n1 2 3\n",
    )
    .unwrap();
    let output = export(place.path(), &["csv", "w.data"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(errors(&output).starts_with("w.data:2:1: a particle of 3 columns after a 3D header"));
    // Nothing half-made is left behind.
    assert!(names(&place.path().join("csv")).is_empty());
}

#[test]
fn a_numbered_series_of_data_files_is_one_input() {
    let place = folder_with_data("");
    let frames: Vec<&str> = DATA.split_inclusive('\n').collect();
    let parts = [&frames[..3], &frames[3..6], &frames[6..]];
    for (k, part) in parts.iter().enumerate() {
        fs::write(place.path().join(format!("s.data.{k:04}")), part.concat()).unwrap();
    }
    succeeds(place.path(), &["xballs", "s.data.0000", "-o", "out"]);
    assert_eq!(
        fs::read_to_string(place.path().join("out/s.data")).unwrap(),
        DATA
    );
}

#[test]
fn frames_without_particles_go_through_every_command() {
    let place = folder_with_data("0 0 0 0 0 1 1 1 \n0 0.5 0 0 0 1 1 1 \n");
    for command in ["vtu", "xballs", "csv", "parquet", "particles", "lammps"] {
        let said = succeeds(place.path(), &[command, "old.data"]);
        assert!(said.starts_with("2 frames in "), "{command}: {said}");
    }
    succeeds(place.path(), &["liggghts", "old.data", "--density", "1000"]);
    assert_eq!(
        fs::read_to_string(place.path().join("csv/old.particles.0001.csv"))
            .unwrap()
            .lines()
            .count(),
        1
    );
}

#[test]
fn lammps_gets_a_dump_and_liggghts_a_data_file() {
    let place = folder_with_run();
    succeeds(place.path(), &["lammps", "run", "--frames", "1"]);
    let text = fs::read_to_string(place.path().join("run/lammps/run.lammpstrj")).unwrap();
    let expected = "ITEM: TIMESTEP\n50\nITEM: NUMBER OF ATOMS\n3\nITEM: BOX BOUNDS ff pp ff\n0 4\n0 1\n0 2\n\
        ITEM: ATOMS id type x y z vx vy vz radius omegax omegay omegaz mass fx fy fz mol\n\
        1 1 1 0.1 0.3333333333333333 0 0.5 0 0.5 0 0 0 0.1 -0 -0 -1 0\n";
    assert!(text.starts_with(expected), "{text}");
    // One of the three is a pebble of body 2.
    let pebbles = text
        .lines()
        .filter(|line| line.split(' ').count() == 17 && line.ends_with(" 3"));
    assert_eq!(pebbles.count(), 1, "{text}");
    succeeds(place.path(), &["liggghts", "run", "--frames", "last"]);
    let text = fs::read_to_string(place.path().join("run/liggghts/run.0003.lmp")).unwrap();
    let expected = "three spheres (t = 1.5 s, SI units)\n\n3 atoms\n2 atom types\n\n0 4 xlo xhi\n0 1 ylo yhi\n0 2 zlo zhi\n\nAtoms\n\n\
        1 1 1 0.5 1 0.1 0.3333333333333333\n";
    assert!(text.starts_with(expected), "{text}");
    assert!(text.contains("\nVelocities\n\n1 0 1.5 0 0 0 0\n"), "{text}");

    let place = folder_with_data(DATA);
    refused(
        place.path(),
        &["liggghts", "old.data"],
        "old.data: the input has no masses\nhelp: give the density of the particles with --density, in kg/m^3\n",
    );
    refused(
        place.path(),
        &["liggghts", "old.data", "--density", "-1"],
        "--density -1: expected a positive number, in kg/m^3\n",
    );
}

#[test]
fn a_scene_can_read_the_particles_of_a_run() {
    let place = folder_with_data(DATA);
    succeeds(place.path(), &["particles", "old.data", "--frames", "0"]);
    let path = place.path().join("particles/old.0000.csv");
    let rows = mercury_common::formats::particle_csv::read_particle_csv(&path).unwrap();
    assert_eq!(rows.len(), 2);
    assert_eq!(rows[1].position.to_array(), [0.5, -0.25, 0.125]);
    assert_eq!((rows[1].radius, rows[1].velocity.z), (0.01, 3.0));
    // The run has a sphere of a clump.
    let place = folder_with_run();
    refused(
        place.path(),
        &["particles", "run"],
        "run/run.particles.arrow: the frame has clumps (body 2), which a table of spheres cannot hold\n\
         help: `[[particles]]` with `run = \"FOLDER\"` starts from the last state of a run of mercury-solve, with its clumps and contacts\n",
    );
}

/// The laws that are printed are placeholders: of a run of our own the lines describe how to go on with its own.
#[test]
fn lines_for_a_scene_name_the_other_way_from_a_run() {
    let place = folder_with_run();
    // Without the sphere of a clump.
    let of_run = [
        "particles",
        "run",
        "--region",
        "x=0.5..2.5",
        "--frames",
        "last",
    ];
    let said = succeeds(place.path(), &of_run);
    assert!(said.contains("run = \"FOLDER\""), "{said}");
    let place = folder_with_data(DATA);
    let said = succeeds(place.path(), &["particles", "old.data"]);
    assert!(!said.contains("run = \"FOLDER\""), "{said}");
}

/// Out as LIGGGHTS reads it, back, and into a scene: the same spheres, and lines that are a scene with time and output.
/// A data file in mm and g/cm3: once a note, and none in SI.
#[test]
fn numbers_of_other_codes_that_are_hardly_si_are_noted() {
    let folder = tempfile::tempdir().unwrap();
    let noted = |diameter: f64, density: f64, size: f64| {
        let text = format!(
            "title\n\n2 atoms\n1 atom types\n\n0 {size} xlo xhi\n0 {size} ylo yhi\n0 {size} zlo zhi\n\nAtoms # sphere\n\n1 1 {diameter} {density} {} {} {}\n2 1 {diameter} {density} {} {} {}\n",
            0.2 * size,
            0.2 * size,
            0.2 * size,
            0.8 * size,
            0.8 * size,
            0.8 * size
        );
        fs::write(folder.path().join("old.data"), text).unwrap();
        let output = export(folder.path(), &["csv", "old.data", "-o", "out", "--force"]);
        assert_eq!(output.status.code(), Some(0), "{}", errors(&output));
        errors(&output)
    };
    let note = noted(4.0, 2.5, 60.0);
    assert_eq!(note.matches("note: ").count(), 1, "{note}");
    let expected = "old.data: grains of 4 m in diameter, a density of 2.5 kg/m3, a domain of 60 m: is a unit missing?";
    assert!(note.contains(expected), "{note}");
    assert_eq!(noted(4e-3, 2500.0, 0.06), "");
}

#[test]
fn files_of_liggghts_and_lammps_become_scenes() {
    let place = folder_with_data(DATA);
    let table = |path: &str| {
        let path = place.path().join(path);
        let rows = mercury_common::formats::particle_csv::read_particle_csv(path).unwrap();
        let spheres = rows
            .iter()
            .map(|row| (row.position.to_array(), row.radius, row.velocity.to_array()));
        spheres.collect::<Vec<_>>()
    };
    succeeds(place.path(), &["particles", "old.data", "-o", "direct"]);
    let density = ["liggghts", "old.data", "-o", "out", "--density", "2500"];
    succeeds(place.path(), &density);
    succeeds(place.path(), &["lammps", "old.data", "-o", "out"]);
    for (input, file) in [
        ("out/old.0000.lmp", "old.0000.0000.csv"),
        ("out/old.lammpstrj", "old.0000.csv"),
    ] {
        let said = succeeds(
            place.path(),
            &["particles", input, "-o", "back", "--frames", "0"],
        );
        assert_eq!(
            table(&format!("back/{file}")),
            table("direct/old.0000.csv"),
            "{input}"
        );
        let (_, lines) = said.split_once(":\n\n").unwrap_or_else(|| panic!("{said}"));
        assert!(lines.contains(&format!("file = \"{file}\"")), "{lines}");
        let stated = input.ends_with("lmp");
        assert_eq!(
            lines.contains("density = 2500.0   # kg/m3\n"),
            stated,
            "{lines}"
        );
        let scene = format!("time = {{ end = 1.0 }}\noutput = {{ interval = 0.1 }}\n{lines}");
        let path = place.path().join("back/scene.toml");
        let files = mercury_common::scene::Files::MustExist;
        mercury_common::scene::parse_scene(&path, &scene, &[], files)
            .unwrap_or_else(|e| panic!("{e}"));
    }
    // And a picture of a dump is one of its spheres.
    succeeds(
        place.path(),
        &[
            "png",
            "out/old.lammpstrj",
            "--frames",
            "0",
            "--size",
            "200x200",
            "-o",
            "png",
        ],
    );
    refused(
        place.path(),
        &["csv", "out/old.lammpstrj", "--table", "contacts"],
        "out/old.lammpstrj: this file holds no contacts\nhelp: fstat = true in [output] of the scene writes them\n",
    );
}

#[test]
fn help_shows_examples_and_bad_usage_exits_2() {
    let place = tempfile::tempdir().unwrap();
    let help = succeeds(place.path(), &["--help"]);
    assert!(
        help.contains("Examples:\n  mercury-export vtu drum"),
        "{help}"
    );
    assert!(succeeds(place.path(), &["--version"]).starts_with("mercury-export "));
    assert!(succeeds(place.path(), &["completions", "bash"]).contains("mercury-export"));
    for arguments in [
        &["vtu"][..],
        &["gif3"],
        &["vtu", "x", "--frames", "some"],
        &["vtu", "x", "--region", "x"],
        &["vtu", "x", "--compression", "12"],
    ] {
        assert_eq!(
            export(place.path(), arguments).status.code(),
            Some(2),
            "{arguments:?}"
        );
    }
}

/// `-o zz.jpg` made a folder of that name.
#[test]
fn an_ending_that_is_not_written_is_refused() {
    let place = folder_with_run();
    for (command, name) in [("png", "zz.jpg"), ("gif", "zz.mp4"), ("svg", "zz.TIF")] {
        let ending = name[3..].to_lowercase();
        refused(
            place.path(),
            &[command, "run", "--frames", "last", "-o", name],
            &format!(
                "{name}: no picture or film is written as .{ending}\nhelp: mercury-export png, svg, gif and apng write .png, .svg, .gif and .apng; \
                 a folder takes a name without such an ending\n"
            ),
        );
        assert!(!place.path().join(name).exists());
    }
}

/// `particles -o p.csv` and `vtu -o x.jpg` made folders of these names.
#[test]
fn a_file_where_a_folder_is_written_is_refused() {
    let place = folder_with_run();
    for (command, name) in [
        ("particles", "p.csv"),
        ("vtu", "x.jpg"),
        ("csv", "a.CSV"),
        ("lammps", "a.dump"),
        ("xballs", "a.data"),
        ("parquet", "a.csv"),
    ] {
        let ending = name[2..].to_lowercase();
        refused(
            place.path(),
            &[command, "run", "-o", name],
            &format!(
                "{name}: mercury-export {command} writes files of its own names into a folder, and this is the name of a file\n\
                 help: name a folder, without the ending .{ending}\n"
            ),
        );
        assert!(!place.path().join(name).exists());
    }
    // One table is one file. A name with a point is a folder, and so is one that is there.
    succeeds(place.path(), &["parquet", "run", "-o", "one.parquet"]);
    assert!(place.path().join("one.parquet").is_file());
    succeeds(place.path(), &["csv", "run", "-o", "of.today"]);
    fs::create_dir(place.path().join("mine.csv")).unwrap();
    succeeds(place.path(), &["csv", "run", "-o", "mine.csv"]);
    assert!(place.path().join("mine.csv").is_dir());
}

/// `-o x.png` made a folder of that name, with a numbered picture in it.
#[test]
fn one_picture_goes_into_the_file_that_is_named() {
    let place = folder_with_run();
    let png = ["png", "run", "--size", "120x90", "-o"];
    let png_to = |more: &[&'static str]| [&png[..], more].concat();
    succeeds(place.path(), &png_to(&["new/x.png", "--frames", "last"]));
    let file = place.path().join("new/x.png");
    assert!(fs::read(&file).unwrap().starts_with(b"\x89PNG"));
    assert_eq!(fs::read_dir(place.path().join("new")).unwrap().count(), 1);
    refused(
        place.path(),
        &png_to(&["new/x.png", "--frames", "last"]),
        "new/x.png: this file is there already\nhelp: --force replaces it, -o DIR writes elsewhere\n",
    );
    refused(
        place.path(),
        &png_to(&["many.png"]),
        "many.png: 4 frames make 4 pictures\nhelp: take one (--frames last), or name a folder\n",
    );
    refused(
        place.path(),
        &png_to(&["x.svg"]),
        "x.svg: this command writes .png\nhelp: mercury-export svg writes .svg\n",
    );
    assert!(!place.path().join("many.png").exists());
    // Films and strips are one file; a folder stays one, whatever its name.
    succeeds(
        place.path(),
        &["gif", "run", "--size", "120x90", "-o", "film.gif"],
    );
    assert!(
        fs::read(place.path().join("film.gif"))
            .unwrap()
            .starts_with(b"GIF")
    );
    succeeds(place.path(), &png_to(&["strip.png", "--strip", "2"]));
    assert!(place.path().join("strip.png").is_file());
    fs::create_dir(place.path().join("folder.png")).unwrap();
    succeeds(place.path(), &png_to(&["folder.png", "--frames", "last"]));
    assert_eq!(
        fs::read_dir(place.path().join("folder.png"))
            .unwrap()
            .count(),
        1
    );
}
