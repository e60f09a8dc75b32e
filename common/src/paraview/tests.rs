use std::collections::HashMap;

use glam::{DQuat, DVec3};

use super::*;
use crate::formats::mesh::TriangleMesh;
use crate::formats::vtu::{VtuCells, VtuGrid, VtuOptions, VtuValues};
use crate::frames::{
    BondFrame, Column, ColumnKind, ColumnSpec, ContactColumns, ContactFrame, Frame,
    ParticleColumns, ParticleFrame, Table, TriangleLoadFrame, WallFrame, WearFrame,
};
use crate::particle_properties::FILM_VOLUME;
use crate::surfaces::{Placement, Surface};

fn point<'a>(grid: &'a VtuGrid, name: &str) -> &'a VtuValues<'a> {
    let found = grid.point_data.iter().find(|array| array.name == name);
    &found.unwrap_or_else(|| panic!("no array {name}")).values
}

fn cell<'a>(grid: &'a VtuGrid, name: &str) -> &'a VtuValues<'a> {
    let found = grid.cell_data.iter().find(|array| array.name == name);
    &found.unwrap_or_else(|| panic!("no array {name}")).values
}

fn numbers(values: &VtuValues) -> Vec<f64> {
    match values {
        VtuValues::F64(v) => v.to_vec(),
        other => panic!("{other:?}"),
    }
}

fn vectors_of(values: &VtuValues) -> Vec<DVec3> {
    match values {
        VtuValues::Vectors(v) => v.to_vec(),
        other => panic!("{other:?}"),
    }
}

fn frame() -> ParticleFrame {
    ParticleFrame {
        time: 0.25,
        step: 7,
        id: vec![3, 5],
        material: vec![0, 1],
        flags: vec![0, 1],
        mass: vec![1.0, 2.0],
        volume: vec![0.1, 0.2],
        radius: vec![0.5, 0.25],
        position: vec![DVec3::ZERO, DVec3::new(0.7, 0.0, 0.0)],
        velocity: vec![DVec3::new(3.0, 4.0, 0.0), DVec3::Z],
        body: Some(vec![None, Some(9)]),
        orientation: Some(vec![DQuat::IDENTITY, DQuat::from_rotation_x(1.0)]),
        angular_velocity: Some(vec![DVec3::X, DVec3::Y]),
        force: Some(vec![DVec3::ONE, -DVec3::ONE]),
        torque: Some(vec![DVec3::Y, DVec3::Z]),
        more: vec![vec![1e-9, 0.0]],
    }
}

#[test]
fn particles_come_with_every_column_and_what_glyphs_need() {
    let columns = ParticleColumns::all().with_properties([&FILM_VOLUME]);
    let expected = frame();
    let grid = particles(&ParticleFrame::specs(&columns), frame().into_frame()).unwrap();
    assert_eq!(grid.time, Some(0.25));
    assert_eq!(*grid.points, *expected.position);
    assert!(matches!(grid.cells, VtuCells::Vertices));
    let names: Vec<&str> = grid.point_data.iter().map(|array| &*array.name).collect();
    let all = "diameter speed id material body state mass volume radius velocity orientation angular_velocity force torque film_volume";
    assert_eq!(names.join(" "), all);
    assert_eq!(numbers(point(&grid, "diameter")), [1.0, 0.5]);
    assert_eq!(numbers(point(&grid, "speed")), [5.0, 1.0]);
    assert_eq!(vectors_of(point(&grid, "velocity")), expected.velocity);
    let spin = vectors_of(point(&grid, "angular_velocity"));
    assert_eq!(Some(spin), expected.angular_velocity);
    assert!(matches!(point(&grid, "body"), VtuValues::I64(v) if **v == [-1, 9]));
    assert!(matches!(point(&grid, "orientation"), VtuValues::Quaternions(v) if v.len() == 2));
}

#[test]
fn columns_of_a_later_version_become_arrays_too() {
    let number = |name: &str| ColumnSpec::new(name, ColumnKind::F64, "1");
    let names = [
        "x", "y", "z", "heat", "wear_x", "wear_y", "wear_z", "ex", "ey", "mark",
    ];
    let mut specs: Vec<ColumnSpec> = names.iter().map(|name| number(name)).collect();
    specs[9].kind = ColumnKind::Text;
    let mut columns: Vec<Column> = (0..9).map(|k| Column::F64(vec![f64::from(k)])).collect();
    columns.push(Column::Text(vec![
        "words have no place in a grid".to_owned(),
    ]));
    let frame = Frame {
        time: 0.0,
        step: 0,
        columns,
    };
    let grid = particles(&specs, frame.clone()).unwrap();
    let names: Vec<&str> = grid.point_data.iter().map(|array| &*array.name).collect();
    assert_eq!(names, ["heat", "wear", "ex", "ey"]);
    assert_eq!(
        vectors_of(point(&grid, "wear")),
        [DVec3::new(4.0, 5.0, 6.0)]
    );
    assert_eq!(
        particles(&specs[1..], frame).unwrap_err(),
        "no columns x, y, z of positions"
    );
}

/// Particle 3 with 5, and 5 with wall 2.
fn contact_frame() -> ContactFrame {
    ContactFrame {
        time: 0.25,
        step: 7,
        i: vec![3, 5],
        j: vec![Some(5), None],
        wall: vec![None, Some(2)],
        point: vec![DVec3::new(0.475, 0.0, 0.0), DVec3::new(0.7, 0.0, -0.2)],
        branch: vec![DVec3::new(-0.7, 0.0, 0.0), DVec3::new(0.0, 0.0, 0.2)],
        normal: vec![-DVec3::X, DVec3::Z],
        force: vec![DVec3::new(-3.0, 4.0, 0.0), DVec3::new(0.0, 0.0, 2.0)],
        overlap: vec![0.05, 0.05],
        ..ContactFrame::default()
    }
}

#[test]
fn contacts_join_centres_and_carry_their_forces() {
    let specs = ContactFrame::specs(&ContactColumns::default());
    let centre: HashMap<u32, DVec3> = [(3, DVec3::ZERO), (5, DVec3::new(0.7, 0.0, 0.0))].into();
    let grid = contacts(&specs, contact_frame().into_frame(), &centre).unwrap();
    let expected = [
        DVec3::ZERO,
        DVec3::new(0.7, 0.0, 0.0),
        DVec3::new(0.7, 0.0, 0.0),
        DVec3::new(0.7, 0.0, -0.2),
    ];
    for (found, expected) in grid.points.iter().zip(expected) {
        assert!(found.distance(expected) < 1e-15, "{found} {expected}");
    }
    assert!(matches!(&grid.cells, VtuCells::Lines(lines) if **lines == [[0, 1], [2, 3]]));
    assert_eq!(numbers(cell(&grid, "force_magnitude")), [5.0, 2.0]);
    assert_eq!(numbers(cell(&grid, "normal_force")), [3.0, 2.0]);
    assert_eq!(numbers(cell(&grid, "tangential_force")), [4.0, 0.0]);
    assert_eq!(
        numbers(point(&grid, "force_magnitude")),
        [5.0, 5.0, 2.0, 2.0]
    );
    assert!(matches!(cell(&grid, "j"), VtuValues::I64(v) if **v == [5, -1]));
    assert!(matches!(cell(&grid, "wall"), VtuValues::I64(v) if **v == [-1, 2]));

    // Without positions the line lies centrally about the contact point.
    let grid = contacts(&specs, contact_frame().into_frame(), &HashMap::new()).unwrap();
    let middle = 0.5 * (grid.points[0] + grid.points[1]);
    assert!(middle.distance(DVec3::new(0.475, 0.0, 0.0)) < 1e-15);
}

#[test]
fn bonds_are_lines_between_their_ends_with_the_larger_stress() {
    // Particle 3 with the image of 5 behind a periodic face, and 5 with wall 2.
    let frame = BondFrame {
        time: 0.25,
        step: 7,
        i: vec![3, 5],
        j: vec![Some(5), None],
        wall: vec![None, Some(2)],
        bond: vec![1, 0],
        force: vec![DVec3::X, DVec3::Y],
        couple: vec![DVec3::Z, DVec3::ZERO],
        tension: vec![-3.0, 5.0],
        shear: vec![2.0, 4.0],
        middle: vec![DVec3::ZERO, DVec3::new(1.0, 0.0, 0.25)],
        branch: vec![DVec3::X, DVec3::new(0.0, 0.0, 0.5)],
    };
    let grid = bonds(&frame);
    let expected = [
        0.5 * DVec3::X,
        -0.5 * DVec3::X,
        DVec3::new(1.0, 0.0, 0.5),
        DVec3::X,
    ];
    assert_eq!(*grid.points, expected);
    assert!(matches!(&grid.cells, VtuCells::Lines(lines) if **lines == [[0, 1], [2, 3]]));
    assert_eq!(numbers(cell(&grid, "stress")), [2.0, 5.0]);
    assert_eq!(numbers(point(&grid, "stress")), [2.0, 2.0, 5.0, 5.0]);
    assert_eq!(numbers(cell(&grid, "tension")), frame.tension);
    assert_eq!(numbers(cell(&grid, "shear")), frame.shear);
    assert_eq!(numbers(cell(&grid, "length")), [1.0, 0.5]);
    assert_eq!(vectors_of(cell(&grid, "couple")), frame.couple);
    assert!(matches!(cell(&grid, "j"), VtuValues::I64(v) if **v == [5, -1]));
    assert!(matches!(cell(&grid, "wall"), VtuValues::I64(v) if **v == [-1, 2]));
    assert!(matches!(cell(&grid, "bond"), VtuValues::U32(v) if **v == [1, 0]));
}

#[test]
fn walls_stand_where_their_motion_brought_them_and_absent_ones_are_left_out() {
    let plane = |z: f64| Surface::Plane {
        point: DVec3::new(0.0, 0.0, z),
        normal: DVec3::Z,
    };
    let names = ["floor", "lid", "later"].map(str::to_owned);
    let surfaces = [plane(0.0), plane(0.5), plane(0.1)];
    let scene = WallScene {
        names: &names,
        surfaces: &surfaces,
        domain: (DVec3::ZERO, DVec3::ONE),
    };
    let lifted = Placement {
        translation: DVec3::new(0.0, 0.0, 0.25),
        ..Placement::default()
    };
    let frame = WallFrame {
        time: 1.0,
        step: 1,
        present: vec![true, true, false],
        placement: vec![Placement::default(), lifted, Placement::default()],
    };
    let grid = walls(&scene, &frame, None, None).unwrap();
    let heights: Vec<f64> = grid.points.iter().map(|x| x.z).collect();
    assert_eq!(heights, [0.0, 0.0, 0.0, 0.0, 0.75, 0.75, 0.75, 0.75]);
    assert!(matches!(cell(&grid, "wall"), VtuValues::U32(v) if **v == [0, 0, 1, 1]));
    assert_eq!(grid.cell_data.len(), 1);
}

#[test]
fn loads_stand_on_their_triangles_and_those_of_absent_walls_nowhere() {
    let plate = |z: f64| {
        let at = |x: f64, y: f64| DVec3::new(x, y, z);
        let one = [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0)];
        let other = [at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
        Surface::Mesh(TriangleMesh::from_corners(&[one, other]))
    };
    let names = ["gone", "first", "second"].map(str::to_owned);
    let surfaces = [plate(0.0), plate(0.1), plate(0.2)];
    let scene = WallScene {
        names: &names,
        surfaces: &surfaces,
        domain: (DVec3::ZERO, DVec3::ONE),
    };
    let frame = WallFrame {
        time: 1.0,
        step: 1,
        present: vec![false, true, true],
        placement: vec![Placement::default(); 3],
    };
    // Worn walls are as they are worn, each point with its depth.
    let wear = WearFrame {
        wall: vec![0, 2],
        vertex: vec![0, 0],
        first: vec![DVec3::ZERO, DVec3::new(0.0, 0.0, 0.2)],
        displacement: vec![DVec3::NEG_Z; 2],
        depth: vec![1.0, 0.5],
        owed: vec![0.0; 2],
        ..WearFrame::default()
    };
    let grid = walls(&scene, &frame, None, Some(&wear)).unwrap();
    let mut depths = vec![0.0; 8];
    depths[4] = 0.5;
    assert_eq!(numbers(point(&grid, "depth")), depths);
    assert_eq!(grid.points[4], DVec3::new(0.0, 0.0, -0.8));
    let mut loads = TriangleLoadFrame {
        wall: vec![0, 1, 2],
        triangle: vec![0, 1, 0],
        pressure: vec![7.0, 8.0, 9.0],
        shear: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        force: vec![DVec3::ZERO, -DVec3::Z, DVec3::Z],
        slip_power: vec![1.0, 2.0, 3.0],
        ..TriangleLoadFrame::default()
    };
    let grid = walls(&scene, &frame, Some(&loads), None).unwrap();
    assert!(matches!(cell(&grid, "wall"), VtuValues::U32(v) if **v == [1, 1, 2, 2]));
    assert_eq!(numbers(cell(&grid, "pressure")), [0.0, 8.0, 9.0, 0.0]);
    assert_eq!(numbers(cell(&grid, "slip_power")), [0.0, 2.0, 3.0, 0.0]);
    let zero = DVec3::ZERO;
    assert_eq!(
        vectors_of(cell(&grid, "shear")),
        [zero, DVec3::X, DVec3::Y, zero]
    );
    assert_eq!(
        vectors_of(cell(&grid, "force")),
        [zero, -DVec3::Z, DVec3::Z, zero]
    );
    for (wall, triangle) in [(1, 2), (3, 0)] {
        (loads.wall[1], loads.triangle[1]) = (wall, triangle);
        let error = walls(&scene, &frame, Some(&loads), None).unwrap_err();
        assert_eq!(error, format!("no triangle {triangle} of wall {wall}"));
    }
}

#[test]
fn a_series_lists_its_frames_and_removes_only_those_of_an_earlier_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    for name in [
        "run.particles.0009.vtu",
        "run.particles.vtu",
        "run.walls.0000.vtu",
        "a.vtu",
    ] {
        std::fs::write(path(name), "old").unwrap();
    }
    let options = VtuOptions::DEFAULT;
    let mut series = Series::create(folder.path(), "run.particles", options).unwrap();
    assert!(!path("run.particles.0009.vtu").exists());
    for kept in ["run.particles.vtu", "run.walls.0000.vtu", "a.vtu"] {
        assert!(path(kept).exists(), "{kept}");
    }
    let specs = ParticleFrame::specs(&ParticleColumns::default());
    for number in [0, 4, 12_345] {
        let frame = ParticleFrame {
            time: number as f64,
            ..ParticleFrame::default()
        };
        let grid = particles(&specs, frame.into_frame()).unwrap();
        series.write(number, &grid).unwrap();
    }
    let list = std::fs::read_to_string(path("run.particles.pvd")).unwrap();
    for (time, file) in [("0.0", "0000"), ("4.0", "0004"), ("12345.0", "12345")] {
        let entry =
            format!("timestep=\"{time}\" group=\"\" part=\"0\" file=\"run.particles.{file}.vtu\"");
        assert!(list.contains(&entry), "{list}");
        assert!(path(&format!("run.particles.{file}.vtu")).exists());
    }
    drop(series);
    Series::resume(folder.path(), "run.particles", options, 2).unwrap();
    let list = std::fs::read_to_string(path("run.particles.pvd")).unwrap();
    assert!(list.contains("0004.vtu") && !list.contains("12345.vtu"));
}

#[test]
fn the_script_names_the_series_that_there_are() {
    let all = ScriptParts {
        particles: true,
        contacts: true,
        walls: true,
        bodies: true,
        clumps: true,
        bridges: true,
        bonds: true,
        droplets: true,
        membranes: true,
    };
    let text = script("my \"run\"", all);
    assert!(text.contains(r#"prefix = "my \"run\"""#));
    // As Python reads it back.
    assert!(script("a\tb\n\\c", all).contains(r#"prefix = "a\x09b\x0a\\c""#));
    for kind in [
        "particles",
        "contacts",
        "walls",
        "bodies",
        "clumps",
        "bridges",
        "bonds",
        "droplets",
        "membranes",
    ] {
        assert!(text.contains(&format!("series(\"{kind}\")")));
    }
    let text = script(
        "run",
        ScriptParts {
            clumps: true,
            ..ScriptParts::default()
        },
    );
    assert!(!text.contains("shown") && text.contains("clump_display.SetScalarBarVisibility"));
    let few = script("run", ScriptParts::default());
    assert!(!few.contains("series(\"walls\")") && !few.contains("series(\"contacts\")"));
}
