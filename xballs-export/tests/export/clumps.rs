//! Clumps as pebbles and as their own surfaces, on the command line.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use glam::{DQuat, DVec3};
use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::frames::{
    BodyFrame, BodyWriter, ClumpKind, FramesHeader, ParticleColumns, ParticleFrame, ParticleWriter,
};

/// Two frames of a sphere (id 0), a stone (id 1, pebbles 1 and 2), which has a surface of four triangles, and a bean (id 3, one
/// pebble), which has none.
fn folder_with_clumps(with_bodies: bool) -> tempfile::TempDir {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("run");
    fs::create_dir(&folder).unwrap();
    let header = FramesHeader {
        title: "a stone and a bean".to_owned(),
        materials: vec!["glass".to_owned(), "rock".to_owned()],
        domain: Some((DVec3::splat(-1.0), DVec3::splat(5.0))),
        ..FramesHeader::default()
    };
    let columns = ParticleColumns {
        body: true,
        ..ParticleColumns::default()
    };
    let path = |kind: &str| folder.join(format!("run.{kind}.arrow"));
    let mut particles = ParticleWriter::create(path("particles"), &header, &columns).unwrap();
    let corners = [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::ONE];
    let faces = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
    let kinds = [
        ClumpKind {
            name: "bean".to_owned(),
            surface: None,
        },
        ClumpKind {
            name: "stone".to_owned(),
            surface: Some(TriangleMesh::from_corners(
                &faces.map(|face| face.map(|k: usize| corners[k])),
            )),
        },
    ];
    let mut bodies =
        with_bodies.then(|| BodyWriter::create(path("bodies"), &header, &kinds.to_vec()).unwrap());
    for k in 0..2u32 {
        let (time, step) = (0.5 * f64::from(k), 50 * u64::from(k));
        let at = |x: f64| DVec3::new(x, 0.0, time);
        let particle_frame = ParticleFrame {
            time,
            step,
            id: vec![0, 1, 2, 3],
            material: vec![0, 1, 1, 1],
            flags: vec![0; 4],
            mass: vec![1.0, 2.0, 3.0, 4.0],
            volume: vec![0.5; 4],
            radius: vec![0.5; 4],
            position: vec![at(0.0), at(1.5), at(2.5), at(4.0)],
            velocity: vec![DVec3::new(0.0, 3.0, 4.0); 4],
            body: Some(vec![None, Some(1), Some(1), Some(3)]),
            ..ParticleFrame::default()
        };
        particles.append(particle_frame).unwrap();
        let Some(bodies) = &mut bodies else { continue };
        let body_frame = BodyFrame {
            time,
            step,
            id: vec![1, 3],
            clump: vec![1, 0],
            material: vec![1, 1],
            flags: vec![0, 0],
            mass: vec![5.0, 4.0],
            volume: vec![1.0, 0.5],
            scale: vec![0.5, 1.0],
            radius: vec![1.0, 0.5],
            position: vec![at(2.0), at(4.0)],
            velocity: vec![DVec3::new(0.0, 3.0, 4.0); 2],
            orientation: vec![DQuat::IDENTITY; 2],
            angular_velocity: vec![DVec3::Z; 2],
            principal_moments: vec![DVec3::ONE; 2],
            force: vec![-DVec3::Z; 2],
            torque: vec![DVec3::ZERO; 2],
        };
        bodies.append(body_frame).unwrap();
    }
    place
}

fn export(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mercury-export"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap()
}

/// Runs it and gives what it said on standard error.
fn notes(folder: &Path, arguments: &[&str]) -> String {
    let output = export(folder, arguments);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {said}");
    said
}

const NOTE: &str = "note: the run holds no surface of clump `bean`, so its pebbles are shown (its clump file names none, or the file \
    could not be read when the run began: its plan says); `mclump SURFACE PEBBLES` or `mclump SURFACE --generate ...` writes a \
    clump file with one\n";

/// Numbers of points and of cells.
fn counts(file: &Path) -> [usize; 2] {
    let bytes = fs::read(file).unwrap();
    let head = String::from_utf8_lossy(&bytes);
    ["NumberOfPoints=\"", "NumberOfCells=\""].map(|key| {
        let (_, rest) = head.split_once(key).unwrap();
        rest.split_once('"').unwrap().0.parse().unwrap()
    })
}

#[test]
fn clumps_become_pebbles_surfaces_or_both() {
    let place = folder_with_clumps(true);
    let vtu = |name: &str| place.path().join("out").join(name);
    let go = |more: &[&str]| {
        let _ = fs::remove_dir_all(place.path().join("out"));
        let mut all = vec!["vtu", "run", "-o", "out"];
        all.extend(more);
        notes(place.path(), &all)
    };
    assert_eq!(go(&[]), "");
    assert_eq!(counts(&vtu("run.particles.0001.vtu")), [4, 4]);
    assert_eq!(counts(&vtu("run.bodies.0001.vtu")), [2, 2]);
    assert!(vtu("run.bodies.pvd").exists() && !vtu("run.clumps.pvd").exists());
    let script = fs::read_to_string(vtu("run.paraview.py")).unwrap();
    assert!(script.contains("series(\"bodies\")") && !script.contains("series(\"clumps\")"));

    // The sphere and the bean stay spheres.
    assert_eq!(go(&["--clumps", "surface"]), NOTE);
    assert_eq!(counts(&vtu("run.particles.0001.vtu")), [2, 2]);
    assert_eq!(counts(&vtu("run.clumps.0001.vtu")), [4, 4]);
    let list = fs::read_to_string(vtu("run.clumps.pvd")).unwrap();
    assert!(list.contains("timestep=\"0.5\""), "{list}");
    let script = fs::read_to_string(vtu("run.paraview.py")).unwrap();
    assert!(script.contains("series(\"clumps\")"));

    assert_eq!(go(&["--clumps", "both"]), NOTE);
    assert_eq!(counts(&vtu("run.particles.0001.vtu")), [4, 4]);
    assert_eq!(counts(&vtu("run.clumps.0001.vtu")), [4, 4]);
    assert_eq!(go(&["--clumps", "both", "--quiet"]), "");

    // Bodies are selected by their own centres: the stone's is at x = 2, its pebbles' at 1.5 and 2.5.
    go(&["--clumps", "surface", "--region", "x=2.2.."]);
    assert_eq!(counts(&vtu("run.clumps.0000.vtu")), [0, 0]);
    assert_eq!(counts(&vtu("run.particles.0000.vtu")), [1, 1]);
    assert_eq!(counts(&vtu("run.bodies.0000.vtu")), [1, 1]);
    go(&["--clumps", "surface", "--material", "glass"]);
    assert_eq!(counts(&vtu("run.clumps.0000.vtu")), [0, 0]);
    assert_eq!(counts(&vtu("run.particles.0000.vtu")), [1, 1]);
}

/// Where a surface stands for every particle there is no list of particles, as a grid without cells cannot be read by meshio.
#[test]
fn particles_that_are_all_hidden_leave_no_empty_files() {
    let place = folder_with_clumps(true);
    let vtu = |name: &str| place.path().join("out").join(name);
    let stone = ["vtu", "run", "-o", "out", "--region", "x=1.2..2.8"];
    let all: Vec<&str> = stone.into_iter().chain(["--clumps", "surface"]).collect();
    // An earlier export into the same folder had them.
    notes(place.path(), &stone);
    assert_eq!(counts(&vtu("run.particles.0001.vtu")), [2, 2]);
    let again: Vec<&str> = all.iter().copied().chain(["--force"]).collect();
    let said = notes(place.path(), &again);
    assert!(!said.contains("particles.pvd"), "{said}");
    for name in [
        "run.particles.pvd",
        "run.particles.0000.vtu",
        "run.particles.0001.vtu",
    ] {
        assert!(!vtu(name).exists(), "{name}");
    }
    assert_eq!(counts(&vtu("run.clumps.0001.vtu")), [4, 4]);
    let script = fs::read_to_string(vtu("run.paraview.py")).unwrap();
    assert!(!script.contains("series(\"particles\")") && !script.contains("shown"));
    assert!(script.contains("series(\"clumps\")"));
}

#[test]
fn colours_show_the_kind_of_clump() {
    let place = folder_with_clumps(true);
    for clumps in ["pebbles", "surface"] {
        let all = [
            "svg", "run", "--clumps", clumps, "--colour", "clump", "-o", "out", "--force",
            "--quiet",
        ];
        notes(place.path(), &all);
        let picture = fs::read_to_string(place.path().join("out/run.0001.svg")).unwrap();
        for said in [">clump<", ">bean<", ">stone<"] {
            assert!(picture.contains(said), "{clumps}: {said}");
        }
    }
    notes(
        place.path(),
        &["vtu", "run", "-o", "grids", "--compression", "none"],
    );
    let bytes = fs::read(place.path().join("grids/run.particles.0001.vtu")).unwrap();
    let head = String::from_utf8_lossy(&bytes).into_owned();
    let (_, rest) = head.split_once("Name=\"clump\"").unwrap();
    let (_, rest) = rest.split_once("offset=\"").unwrap();
    let offset: usize = rest.split_once('"').unwrap().0.parse().unwrap();
    let mark = b"<AppendedData encoding=\"raw\">\n_";
    let data = bytes
        .windows(mark.len())
        .position(|part| part == mark)
        .unwrap()
        + mark.len();
    // The length, then the sphere, two pebbles of the stone, and the bean.
    let begin = data + offset + 8;
    let values: Vec<i64> = bytes[begin..begin + 32]
        .chunks_exact(8)
        .map(|bytes| i64::from_le_bytes(bytes.try_into().unwrap()))
        .collect();
    assert_eq!(values, [-1, 1, 1, 0]);

    let without = folder_with_clumps(false);
    let output = export(without.path(), &["png", "run", "--colour", "clump"]);
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        said.contains("no file of bodies beside the particles"),
        "{said}"
    );
}

#[test]
fn bodies_are_a_table_like_the_others() {
    let place = folder_with_clumps(true);
    let go = |command: &str, more: &[&str]| {
        let mut all = vec![
            command, "run", "--table", "bodies", "-o", "out", "--force", "--quiet",
        ];
        all.extend(more);
        assert_eq!(notes(place.path(), &all), "");
    };
    let text = |number: &str| {
        let file = format!("out/run.bodies.{number}.csv");
        fs::read_to_string(place.path().join(file)).unwrap()
    };
    go("csv", &[]);
    let expected = "time [s],id,clump,material,state,mass [kg],volume [m^3],scale,radius [m],x [m],y [m],z [m],vx [m/s],vy [m/s],vz [m/s],qw,qx,qy,qz,\
        wx [rad/s],wy [rad/s],wz [rad/s],ix [kg m^2],iy [kg m^2],iz [kg m^2],fx [N],fy [N],fz [N],tx [N m],ty [N m],tz [N m]\n\
        0.5,1,1,1,0,5,1,0.5,1,2,0,0.5,0,3,4,1,0,0,0,0,0,1,1,1,1,0,0,-1,0,0,0\n\
        0.5,3,0,1,0,4,0.5,1,0.5,4,0,0.5,0,3,4,1,0,0,0,0,0,1,1,1,1,0,0,-1,0,0,0\n";
    assert_eq!(text("0001").replace("-0,", "0,"), expected);
    go("csv", &["--frames", "last", "--region", "x=3.."]);
    assert_eq!(text("0001").lines().count(), 2);
    go("parquet", &[]);
    assert!(place.path().join("out/run.bodies.parquet").exists());
}

#[test]
fn pictures_show_surfaces_among_spheres() {
    let place = folder_with_clumps(true);
    let go = |clumps: &str, colour: &str| {
        let all = [
            "svg", "run", "--clumps", clumps, "--colour", colour, "-o", "out", "--force",
        ];
        let said = notes(place.path(), &all);
        assert_eq!(said, if clumps == "pebbles" { "" } else { NOTE });
        fs::read_to_string(place.path().join("out/run.0001.svg")).unwrap()
    };
    let pebbles = go("pebbles", "speed");
    assert!(pebbles.contains("4 spheres") && !pebbles.contains("grain"));
    let surface = go("surface", "speed");
    assert!(surface.contains("2 spheres") && surface.contains("1 grain"));
    // The scene is a picture inside, on a line of its own.
    let scene = |svg: &str| -> String {
        svg.lines()
            .filter(|line| line.starts_with("<image"))
            .collect()
    };
    assert!(!scene(&pebbles).is_empty() && scene(&pebbles) != scene(&surface));
    let both = go("both", "mass");
    assert!(both.contains("4 spheres") && both.contains("1 grain"));
    // Bodies keep the colour of their pebbles, and the stone is body 1.
    let body = go("surface", "body");
    assert!(body.contains(">body<") && body.contains(">1<") && body.contains(">3<"));
}

#[test]
fn surfaces_without_a_table_of_bodies_are_refused() {
    let place = folder_with_clumps(false);
    let message = "run/run.particles.arrow: no file of bodies beside the particles: the run has no clumps, or is of an earlier version\nhelp: ";
    for (arguments, help) in [
        (
            ["vtu", "run", "--clumps", "surface"],
            "--clumps pebbles shows what there is\n",
        ),
        (
            ["png", "run", "--clumps", "both"],
            "--clumps pebbles shows what there is\n",
        ),
        (
            ["csv", "run", "--table", "bodies"],
            "--table particles has the spheres\n",
        ),
    ] {
        let output = export(place.path(), &arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(said, format!("{message}{help}"));
        let folder = place.path().join("run").join(arguments[0]);
        let files = fs::read_dir(folder).map_or(0, Iterator::count);
        assert_eq!(files, 0, "nothing is written");
    }
    assert_eq!(notes(place.path(), &["vtu", "run"]), "");
    assert!(!place.path().join("run/vtu/run.bodies.pvd").exists());
}

/// The run after its table of bodies (or another) was cut behind `bytes`.
fn cut(place: &tempfile::TempDir, kind: &str, bytes: impl Fn(usize) -> usize) {
    let path = place.path().join(format!("run/run.{kind}.arrow"));
    let whole = fs::read(&path).unwrap();
    fs::write(&path, &whole[..bytes(whole.len())]).unwrap();
}

#[test]
fn bodies_that_were_cut_are_reported_once() {
    let place = folder_with_clumps(true);
    cut(&place, "bodies", |whole| whole - 100);
    let damage = "run/run.bodies.arrow: a frame that goes beyond the end of the file behind 1 whole frame\n\
        help: the frames before it can be used; the file was cut or changed after it was written\n";
    let start = "warning: only the first 1 frame of bodies could be used, up to t = 0 s; ";
    for (arguments, lost) in [
        (
            ["vtu", "run", "--clumps", "pebbles"],
            "later ones are left out",
        ),
        (
            ["vtu", "run", "--clumps", "surface"],
            "later clumps are shown by their pebbles",
        ),
        (
            ["png", "run", "--clumps", "both"],
            "surfaces of later clumps are left out",
        ),
    ] {
        let mut all = arguments.to_vec();
        all.extend(["--quiet", "--force"]);
        let said = notes(place.path(), &all);
        assert_eq!(said, format!("{start}{lost}\n{damage}"), "{arguments:?}");
    }
    // The requested files are whole.
    let first = ["vtu", "run", "--frames", "0", "--quiet", "--force"];
    assert_eq!(notes(place.path(), &first), "");
    // None of the requested files is there: no list that names no file, and none of before.
    let last = ["vtu", "run", "--frames", "last", "--quiet", "--force"];
    let said = notes(place.path(), &last);
    assert_eq!(said, format!("{start}later ones are left out\n{damage}"));
    assert!(!place.path().join("run/vtu/run.bodies.pvd").exists());
    assert!(!place.path().join("run/vtu/run.bodies.0000.vtu").exists());
}

#[test]
fn surfaces_that_cannot_be_read_leave_the_pebbles() {
    let place = folder_with_clumps(true);
    cut(&place, "clumps", |whole| whole - 100);
    let refused = |found: &str| {
        let output = export(place.path(), &["vtu", "run", "--clumps", "surface"]);
        assert_eq!(output.status.code(), Some(2));
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(said, found);
    };
    refused(
        "run/run.clumps.arrow: a frame that goes beyond the end of the file behind 0 whole frames\n\
         help: the file was cut or changed after it was written; --clumps pebbles shows what there is\n",
    );
    assert_eq!(notes(place.path(), &["vtu", "run"]), "");
    assert_eq!(
        counts(&place.path().join("run/vtu/run.bodies.0001.vtu")),
        [2, 2]
    );
    fs::remove_file(place.path().join("run/run.clumps.arrow")).unwrap();
    refused(
        "run/run.clumps.arrow: the file cannot be opened: No such file or directory (os error 2)\n\
         help: --clumps pebbles shows what there is\n",
    );
    notes(place.path(), &["csv", "run", "--table", "bodies"]);
    // The table of bodies itself: the pebbles are whole.
    cut(&place, "bodies", |_| 100);
    let said = notes(place.path(), &["vtu", "run", "--force"]);
    assert!(
        said.starts_with(
            "warning: bodies are left out\nrun/run.bodies.arrow: a message that goes beyond"
        ),
        "{said}"
    );
}

#[test]
fn a_data_file_says_where_its_bodies_are() {
    let place = folder_with_clumps(true);
    let data = "1 0 0 0 0 1 1 1\n0 0 0 0 0 0 1 0 0 0 0 0 0 0\n";
    for name in ["run/run.data", "alone.data"] {
        fs::write(place.path().join(name), data).unwrap();
    }
    for (file, message) in [
        (
            "run/run.data",
            "run/run.data: a .data file holds no bodies; those of this run lie in run/run.bodies.arrow\nhelp: give the run folder: run\n",
        ),
        (
            "alone.data",
            "alone.data: a .data file holds no bodies\nhelp: --clumps pebbles shows what there is\n",
        ),
    ] {
        let output = export(place.path(), &["vtu", file, "--clumps", "surface"]);
        assert_eq!(output.status.code(), Some(2));
        assert_eq!(String::from_utf8(output.stderr).unwrap(), message);
    }
}
