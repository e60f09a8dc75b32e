//! Bonds of a run: pictures, lines for ParaView, tables, queries.

use std::fs;
use std::path::Path;
use std::process::Command;

use glam::DVec3;
use mercury_common::frames::{
    BondFrame, BondNames, BondWriter, FramesHeader, ParticleColumns, ParticleFrame, ParticleWriter,
};

/// Exit code, standard output and standard error.
fn export(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_mercury-export"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap();
    let [out, said] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    (output.status.code(), out, said)
}

/// Exports without a word on standard error; returns standard output.
fn exported(folder: &Path, arguments: &[&str]) -> String {
    let (code, out, said) = export(folder, arguments);
    assert_eq!((code, said.as_str()), (Some(0), ""), "{arguments:?}");
    out
}

/// A folder with the run `run/`: four beads of diameter 1 in a row at x = 0.5 to 3.5, z = 1, periodic along x. Beads 0 and 1, 1 and 2 are bonded, 0
/// with the image of 3 at x = -0.5, and 3 with the floor. Bond 1-2, which is compressed and sheared, is broken in the second frame.
fn bonded_run() -> tempfile::TempDir {
    let place = particles_alone();
    let header = FramesHeader {
        walls: vec!["floor".to_owned()],
        ..FramesHeader::default()
    };
    let names = BondNames(vec!["glue".to_owned(), "mortar".to_owned()]);
    let path = place.path().join("run/run.bonds.arrow");
    let mut bonds = BondWriter::create(path, &header, &names).unwrap();
    let at = |x: f64| DVec3::new(x, 1.0, 1.0);
    let whole = BondFrame {
        time: 0.0,
        step: 0,
        i: vec![0, 1, 0, 3],
        j: vec![Some(1), Some(2), Some(3), None],
        wall: vec![None, None, None, Some(0)],
        bond: vec![0, 0, 1, 1],
        force: vec![DVec3::X, -DVec3::X, DVec3::ZERO, DVec3::ZERO],
        couple: vec![DVec3::Z; 4],
        tension: vec![4e5, -3e5, 0.0, 0.0],
        shear: vec![1e5, 2e5, 0.0, 0.0],
        middle: vec![at(1.0), at(2.0), at(0.0), at(3.5) - 0.5 * DVec3::Z],
        branch: vec![-DVec3::X, -DVec3::X, DVec3::X, DVec3::Z],
    };
    let without = |list: &[f64]| vec![list[0], list[2], list[3]];
    let broken = BondFrame {
        time: 0.5,
        step: 50,
        i: vec![0, 0, 3],
        j: vec![Some(1), Some(3), None],
        wall: vec![None, None, Some(0)],
        bond: vec![0, 1, 1],
        force: vec![DVec3::X, DVec3::ZERO, DVec3::ZERO],
        couple: vec![DVec3::Z; 3],
        tension: without(&whole.tension),
        shear: without(&whole.shear),
        middle: vec![whole.middle[0], whole.middle[2], whole.middle[3]],
        branch: vec![whole.branch[0], whole.branch[2], whole.branch[3]],
    };
    bonds.append(whole).unwrap();
    bonds.append(broken).unwrap();
    let breaks = "time [s],i,j,bond,mode,x [m],y [m],z [m],energy [J],wall\n\
                  0.25,1,2,glue,shear,2,1,1,0.125,\n";
    fs::write(place.path().join("run/run.breaks.csv"), breaks).unwrap();
    place
}

/// The beads of [`bonded_run`] without bonds.
fn particles_alone() -> tempfile::TempDir {
    let place = tempfile::tempdir().unwrap();
    fs::create_dir(place.path().join("run")).unwrap();
    let header = FramesHeader {
        title: "chain".to_owned(),
        materials: vec!["glass".to_owned()],
        domain: Some((DVec3::ZERO, DVec3::new(4.0, 2.0, 2.0))),
        periodic: [true, false, false],
        dimensions: Some(3),
        gravity: Some(DVec3::new(0.0, 0.0, -9.81)),
        ..FramesHeader::default()
    };
    let path = place.path().join("run/run.particles.arrow");
    let columns = ParticleColumns::default();
    let mut particles = ParticleWriter::create(path, &header, &columns).unwrap();
    for (time, step) in [(0.0, 0), (0.5, 50)] {
        let frame = ParticleFrame {
            time,
            step,
            id: vec![0, 1, 2, 3],
            material: vec![0; 4],
            flags: vec![0; 4],
            mass: vec![1.0; 4],
            volume: vec![0.5; 4],
            radius: vec![0.5; 4],
            position: (0..4)
                .map(|k| DVec3::new(0.5 + f64::from(k), 1.0, 1.0))
                .collect(),
            velocity: vec![DVec3::ZERO; 4],
            ..ParticleFrame::default()
        };
        particles.append(frame).unwrap();
    }
    place
}

/// A picture and where the scene lies in it.
struct Picture {
    rgb: Vec<[u8; 3]>,
    width: usize,
    /// Column of x = 0, row of z = 1 and pixels per metre.
    place: [f64; 3],
}

impl Picture {
    /// The run from the front with faint beads, in a view that is the same whatever lines there are.
    fn of(folder: &Path, frame: &str, more: &[&str]) -> Self {
        let draw = |more: &[&str]| {
            let mut arguments = vec!["png", "run", "--frames", frame, "-o", "one.png"];
            arguments.extend(["--view", "front", "--bare", "--colour", "none", "--force"]);
            arguments.extend(["--no-domain", "--framing", "particles", "--zoom", "0.7"]);
            arguments.extend(["--size", "900x450", "--quiet"]);
            arguments.extend(more);
            exported(folder, &arguments);
            let file = fs::File::open(folder.join("one.png")).unwrap();
            let mut reader = png::Decoder::new(file).read_info().unwrap();
            let mut bytes = vec![0; reader.output_buffer_size()];
            let info = reader.next_frame(&mut bytes).unwrap();
            let samples = info.color_type.samples();
            let rgb: Vec<[u8; 3]> = bytes.chunks(samples).map(|p| [p[0], p[1], p[2]]).collect();
            (rgb, info.width as usize)
        };
        // Opaque beads reach from x = 0 to 4 m and z = 0.5 to 1.5 m.
        let (solid, width) = draw(&["--opacity", "1"]);
        let beads = |k: &usize| solid[*k] != solid[0];
        let columns = || (0..solid.len()).filter(beads).map(|k| (k % width) as f64);
        let rows = || (0..solid.len()).filter(beads).map(|k| (k / width) as f64);
        let (left, right) = (
            columns().fold(f64::MAX, f64::min),
            columns().fold(0.0, f64::max),
        );
        let (top, bottom) = (rows().fold(f64::MAX, f64::min), rows().fold(0.0, f64::max));
        let scale = (right + 1.0 - left) / 4.0;
        assert!(
            (bottom + 1.0 - top - scale).abs() < 4.0,
            "the view is not straight"
        );
        let (rgb, width) = draw(more);
        Self {
            rgb,
            width,
            place: [left, 0.5 * (top + bottom), scale],
        }
    }

    /// Pixels that differ from those of another picture in the column of x (m), within half a metre of z (m).
    fn changed(&self, other: &Self, x: f64, z: f64) -> usize {
        let [left, middle, scale] = self.place;
        let column = (left + x * scale) as usize;
        let row = (middle - (z - 1.0) * scale) as usize;
        let half = (0.45 * scale) as usize;
        let pixels = (row - half..row + half).map(|row| row * self.width + column);
        pixels.filter(|&k| self.rgb[k] != other.rgb[k]).count()
    }
}

#[test]
fn pictures_show_lines_where_bonds_are() {
    let place = bonded_run();
    let faint = ["--opacity", "0.15"];
    let plain = Picture::of(place.path(), "0", &faint);
    let lines = |frame: &str, more: &[&str]| {
        let picture = Picture::of(place.path(), frame, more);
        // Middles of the bonds 0-1, 1-2, 0-3 (in front of the periodic face); half a metre behind the last bead is nothing.
        [(1.0, 1.0), (2.0, 1.0), (-0.25, 1.0), (4.25, 1.0)]
            .map(|(x, z)| picture.changed(&plain, x, z))
    };
    let [first, second, across, nothing] = lines("0", &["--bonds"]);
    assert!(
        first > second && second > across && across > 0,
        "{first} {second} {across}"
    );
    assert_eq!(nothing, 0);
    // The floor's bond is upright: a column beside it shows none of it, its own column all.
    let whole = Picture::of(place.path(), "0", &["--bonds"]);
    assert_eq!(whole.changed(&plain, 3.4, 0.4), 0);
    let upright = whole.changed(&plain, 3.5, 0.4) as f64;
    assert!(
        (upright / (0.85 * whole.place[2]) - 1.0).abs() < 0.1,
        "{upright}"
    );

    let [first_after, second_after, ..] = lines("1", &["--bonds"]);
    assert_eq!((first_after, second_after), (first, 0));
    // Compression counts as no tension; shear is larger in 1-2.
    let [first, second, across, _] = lines("0", &["--bonds=tension"]);
    assert!(
        first > second && second == across,
        "{first} {second} {across}"
    );
    let [first, second, ..] = lines("0", &["--bonds=shear"]);
    assert!(first < second, "{first} {second}");
    // All stresses are small on a scale that ends at 400 MPa.
    let [first, second, across, _] = lines("0", &["--bonds", "--bond-range", "0..4e8"]);
    assert!(
        first == across && second == across,
        "{first} {second} {across}"
    );
    // Bonds of beads that are not selected are left out.
    let [first, ..] = lines("0", &["--bonds", "--region", "x=2..4"]);
    let [bare, ..] = lines("0", &["--opacity", "0.15", "--region", "x=2..4"]);
    assert_eq!(first, bare);
}

#[test]
fn a_heading_and_a_legend_name_bonds() {
    let place = bonded_run();
    let arguments = ["svg", "run", "--frames", "0", "--bonds", "-o", "one.svg"];
    exported(place.path(), &arguments);
    let text = fs::read_to_string(place.path().join("one.svg")).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    let texts: Vec<&str> = document
        .descendants()
        .filter_map(|node| node.text())
        .collect();
    assert!(
        texts.iter().any(|text| text.contains("4 bonds")),
        "{texts:?}"
    );
    let legend = texts.iter().any(|text| text.contains("stress in bonds"));
    assert!(legend, "{texts:?}");
}

#[test]
fn bonds_are_a_series_of_lines() {
    let place = bonded_run();
    exported(place.path(), &["vtu", "run", "--compression", "none"]);
    let file = |name: &str| {
        let bytes = fs::read(place.path().join("run/vtu").join(name)).unwrap();
        String::from_utf8_lossy(&bytes).into_owned()
    };
    for (number, bonds) in [(0, 4), (1, 3)] {
        let text = file(&format!("run.bonds.000{number}.vtu"));
        let size = format!("NumberOfPoints=\"{}\" NumberOfCells=\"{bonds}\"", 2 * bonds);
        assert!(text.contains(&size), "{text}");
        for array in ["stress", "tension", "shear", "bond", "couple"] {
            assert!(text.contains(&format!("Name=\"{array}\"")), "{array}");
        }
    }
    assert!(file("run.paraview.py").contains("series(\"bonds\")"));
    assert!(file("run.bonds.pvd").contains("run.bonds.0001.vtu"));
    // Beads 2 and 3 have the bond to the floor between them.
    exported(
        place.path(),
        &[
            "vtu",
            "run",
            "--force",
            "--compression",
            "none",
            "--region",
            "x=2..4",
        ],
    );
    let text = file("run.bonds.0000.vtu");
    assert!(
        text.contains("NumberOfPoints=\"2\" NumberOfCells=\"1\""),
        "{text}"
    );
}

#[test]
fn tables_and_queries_have_bonds_and_breaks() {
    let place = bonded_run();
    let sql = "SELECT frame, bond, COUNT(*) AS n, MAX(tension) AS tension FROM bonds GROUP BY frame, bond ORDER BY frame, bond";
    let expected = "frame  bond    n  tension\n\
                    0      glue    2  400000\n\
                    0      mortar  2  0\n\
                    1      glue    1  400000\n\
                    1      mortar  2  0\n";
    assert_eq!(exported(place.path(), &["query", "run", sql]), expected);
    let sql = "SELECT wall, i FROM bonds WHERE wall IS NOT NULL AND frame = 0";
    assert_eq!(
        exported(place.path(), &["query", "run", sql]),
        "wall   i\nfloor  3\n"
    );
    let sql = "SELECT mode, energy FROM breaks WHERE bond = 'glue'";
    assert_eq!(
        exported(place.path(), &["query", "run", sql]),
        "mode   energy\nshear  0.125\n"
    );

    exported(
        place.path(),
        &["csv", "run", "--table", "bonds", "--frames", "last"],
    );
    let text = fs::read_to_string(place.path().join("run/csv/run.bonds.0001.csv")).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(
        lines[0],
        "time [s],i,j,wall,bond,fx [N],fy [N],fz [N],tx [N m],ty [N m],tz [N m],tension [Pa],shear [Pa],px [m],py [m],pz [m],bx [m],by [m],bz [m]"
    );
    assert_eq!(lines.len(), 4);
    assert_eq!(lines[3], "0.5,3,,0,1,0,0,0,0,0,1,0,0,3.5,1,0.5,0,0,1");
    let (code, _, said) = export(
        place.path(),
        &["csv", "run", "--table", "bonds", "--region", "x=0..1"],
    );
    let expected = "--region and --material select particles; bonds have neither\n";
    assert_eq!((code, said.as_str()), (Some(2), expected));

    exported(place.path(), &["parquet", "run", "--table", "breaks"]);
    let table =
        mercury_tables::Table::read_parquet(&place.path().join("run/parquet/run.breaks.parquet"))
            .unwrap();
    assert_eq!(table.values::<String>("mode").unwrap(), ["shear"]);
    assert_eq!(table.values::<f64>("energy").unwrap(), [0.125]);
}

#[test]
fn runs_without_bonds_say_so() {
    let place = particles_alone();
    let no_bonds = "run/run.particles.arrow: no file of bonds beside the particles\n\
        help: [[bonds]] in the scene and bonds = true in [output] make a run write them";
    let drawn = "; without --bonds the particles are drawn\n";
    for (arguments, more) in [
        (&["png", "run", "--bonds"][..], drawn),
        (&["csv", "run", "--table", "bonds"], "\n"),
        (&["parquet", "run", "--table", "bonds"], "\n"),
    ] {
        let (code, _, said) = export(place.path(), arguments);
        assert_eq!(
            (code, said),
            (Some(2), format!("{no_bonds}{more}")),
            "{arguments:?}"
        );
    }
    let (code, _, said) = export(place.path(), &["csv", "run", "--table", "breaks"]);
    let expected = "run/run.breaks.csv: there is no such table\n\
        help: [[bonds]] in the scene, without bonds = false in [output], makes a run write it\n";
    assert_eq!((code, said.as_str()), (Some(2), expected));
    let (code, _, said) = export(place.path(), &["query", "run", "SELECT * FROM bonds"]);
    assert!(
        code == Some(2) && said.contains("bonds") && said.contains("particles"),
        "{said}"
    );
    exported(place.path(), &["vtu", "run"]);
    assert!(!place.path().join("run/vtu/run.bonds.pvd").exists());
}

#[test]
fn wrong_options_and_damaged_files_are_named() {
    let place = bonded_run();
    for (arguments, expected) in [
        (&["png", "run", "--bonds", "--contacts"][..], "--contacts"),
        (&["png", "run", "--bonds", "--bridges"], "--bridges"),
        (&["png", "run", "--bonds=twist"], "twist"),
        (&["png", "run", "--bond-range", "0..1"], "--bonds"),
        (
            &["png", "run", "--bonds", "--bond-range", "2..1"],
            "expected LOW..HIGH",
        ),
    ] {
        let (code, _, said) = export(place.path(), arguments);
        assert!(
            code == Some(2) && said.contains(expected),
            "{arguments:?}: {said}"
        );
    }
    // The second frame is cut: the first is drawn, with a warning.
    let path = place.path().join("run/run.bonds.arrow");
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() - 100]).unwrap();
    let (code, _, said) = export(place.path(), &["vtu", "run"]);
    assert_eq!(code, Some(0), "{said}");
    assert!(
        said.contains("only the first 1 frame of bonds could be used"),
        "{said}"
    );
    let (code, _, said) = export(
        place.path(),
        &["png", "run", "--bonds", "--size", "100x100"],
    );
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("later pictures are without them"), "{said}");
    fs::write(&path, "no frames").unwrap();
    for arguments in [
        &["vtu", "run", "--force"][..],
        &["png", "run", "--bonds", "--force"],
    ] {
        let (code, _, said) = export(place.path(), arguments);
        assert!(
            code == Some(2) && said.contains("run.bonds.arrow"),
            "{said}"
        );
        assert!(said.contains("help: "), "{said}");
    }
}
