//! Files of LAMMPS and LIGGGHTS: as their manuals show them, with mistakes of every kind, and those that we write.

use std::path::Path;

use mercury_common::formats::lines::LineReader;
use proptest::prelude::*;

use super::*;
use crate::sinks::{Density, push_data_file, push_dump};

const DATA: &str = "LIGGGHTS data file

2 atoms
2 atom types

-1 1 xlo xhi
0 2.5 ylo yhi
0 3 zlo zhi

Atoms # granular

7 2 0.02 2500 0.1 0.2 0.3 0 0 0
3 1 0.01 7800 -0.5 0.5 1.5

Velocities

3 1 2 3
7 -1 0 0.5 10 20 30
";

fn data(text: &str) -> Result<Grains, FormatError> {
    data_file::read(LineReader::new(text.as_bytes(), "bed.lmp"))
}

fn dumped(text: &str) -> Vec<Result<Grains, FormatError>> {
    dump::Frames::new(LineReader::new(text.as_bytes(), "bed.dump")).collect()
}

#[test]
fn a_data_file_is_read_by_ids() {
    let grains = data(DATA).unwrap();
    assert_eq!(grains.title, "LIGGGHTS data file");
    assert_eq!(
        (grains.ids.as_slice(), grains.types.as_slice()),
        (&[3, 7][..], &[1, 2][..])
    );
    assert_eq!(grains.radius, [0.005, 0.01]);
    assert_eq!(grains.position[0], DVec3::new(-0.5, 0.5, 1.5));
    assert_eq!(
        grains.domain,
        Some((DVec3::new(-1.0, 0.0, 0.0), DVec3::new(1.0, 2.5, 3.0)))
    );
    let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 1e-6;
    assert!((grains.mass.as_ref().unwrap()[1] / mass - 1.0).abs() < 1e-14);
    assert_eq!(
        grains.velocity.as_ref().unwrap()[0],
        DVec3::new(1.0, 2.0, 3.0)
    );
    assert_eq!(
        grains.angular_velocity.as_ref().unwrap()[1],
        DVec3::new(10.0, 20.0, 30.0)
    );
    // Without a title but an empty line, with another order of columns, and with sections about other things than spheres.
    let hybrid = DATA
        .replace("LIGGGHTS data file\n", "\n")
        .replace("# granular", "# hybrid sphere bond/gran")
        .replace("0.02 2500 0.1 0.2 0.3 0 0 0", "0.1 0.2 0.3 0.02 2500 0 1")
        .replace("0.01 7800 -0.5 0.5 1.5", "-0.5 0.5 1.5 0.01 7800 0 1")
        .replace("Velocities", "Pair Coeffs\n\n1 1.0\n\nVelocities");
    assert_eq!(
        data(&hybrid).unwrap(),
        Grains {
            title: String::new(),
            ..grains
        }
    );
}

#[test]
fn wrong_data_files_are_reported_where_and_why() {
    for (from, to, line, part) in [
        (
            "2 atoms\n",
            "3 atoms\n",
            15,
            "the end of Atoms, expected 3 lines",
        ),
        ("2 atoms\n", "-2 atoms\n", 3, "a number of atoms from 0"),
        ("2 atoms\n", "", 9, "Atoms before their number"),
        ("0.02 2500", "0 2500", 12, "the diameter 0"),
        ("0.02 2500", "0.02 -1", 12, "the density -1"),
        ("0.02 2500", "0.02 x", 12, "\"x\" for the density"),
        (
            "0.1 0.2 0.3 0 0 0",
            "0.1 0.2",
            12,
            "the end of the line in place of z",
        ),
        (
            "0.1 0.2 0.3 0 0 0",
            "nan 0.2 0.3",
            12,
            "a position that is no number",
        ),
        ("7 2 0.02", "0 2 0.02", 12, "an id out of range"),
        ("7 2 0.02", "7 0 0.02", 12, "a type out of range"),
        (
            "# granular",
            "# atomic",
            10,
            "Atoms of the style \"atomic\"",
        ),
        ("-1 1 xlo", "1 -1 xlo", 6, "two bounds, the lower one first"),
        (
            "0 3 zlo zhi",
            "0 3 zlo zhi\n0.1 0 0 xy xz yz",
            9,
            "a box that is not upright",
        ),
        ("2 atom types", "2 ellipsoids", 4, "spheres only"),
        ("3 1 2 3\n", "4 1 2 3\n", 17, "the velocity of atom 4"),
        ("3 1 2 3\n", "7 1 2 3\n", 18, "a second time"),
        (
            "3 1 2 3\n",
            "3 1 2 inf\n",
            17,
            "a velocity that is no number",
        ),
        ("\nVelocities", "\nAtoms", 15, "a second section Atoms"),
    ] {
        let text = DATA.replacen(from, to, 1);
        assert_ne!(text, DATA, "{from}");
        let error = data(&text).expect_err(to);
        assert!(error.to_string().contains(part), "{to}: {error}");
        assert_eq!(error.line, Some(line), "{to}: {error}");
    }
    for (from, to, part) in [
        ("7 2 0.02", "3 2 0.02", "the atom 3 occurs twice"),
        ("0 3 zlo zhi\n", "", "bounds of some axes"),
        ("Atoms # granular", "Masses", "Velocities before Atoms"),
    ] {
        let error = data(&DATA.replacen(from, to, 1)).expect_err(to).to_string();
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn a_data_file_without_atoms_is_none() {
    let error = data("title\n\n2 atoms\n0 1 xlo xhi\n")
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("no section Atoms") && error.contains("help: "),
        "{error}"
    );
}

const DUMP: &str = "ITEM: TIMESTEP
100
ITEM: TIME
0.5
ITEM: NUMBER OF ATOMS
2
ITEM: BOX BOUNDS pp ff ff
0 1
0 2
0 4
ITEM: ATOMS id type xs ys zs radius element vx vy vz f_force[1]
2 1 0.5 0.5 0.5 0.1 Si 1 2 3 9
1 3 0 0.25 1 0.2 C 0 0 -1 8
ITEM: TIMESTEP
200
ITEM: NUMBER OF ATOMS
0
ITEM: BOX BOUNDS ff ff ff
0 1
0 2
0 4
ITEM: ATOMS id type x y z diameter
";

#[test]
fn a_dump_is_read_frame_by_frame_and_by_names() {
    let mut frames = dumped(DUMP).into_iter().map(Result::unwrap);
    let first = frames.next().unwrap();
    assert_eq!((first.step, first.time), (100, Some(0.5)));
    assert_eq!(first.periodic, [true, false, false]);
    assert_eq!(
        (first.ids.as_slice(), first.types.as_slice()),
        (&[1, 2][..], &[3, 1][..])
    );
    // Scaled positions are those of the box.
    assert_eq!(
        first.position,
        [DVec3::new(0.0, 0.5, 4.0), DVec3::new(0.5, 1.0, 2.0)]
    );
    assert_eq!(first.radius, [0.2, 0.1]);
    assert_eq!(
        first.velocity.as_deref(),
        Some(&[DVec3::new(0.0, 0.0, -1.0), DVec3::new(1.0, 2.0, 3.0)][..])
    );
    assert_eq!(first.others, [("f_force[1]".to_owned(), vec![8.0, 9.0])]);
    let second = frames.next().unwrap();
    assert_eq!((second.step, second.time, second.ids.len()), (200, None, 0));
    assert!(frames.next().is_none());
}

#[test]
fn wrong_dumps_give_their_good_frames_and_say_what_is_wrong() {
    for (from, to, good, part) in [
        ("100\n", "-1\n", 0, "the step -1"),
        (
            "ITEM: NUMBER OF ATOMS\n2",
            "ITEM: NUMBER OF ATOMS\nx",
            0,
            "\"x\" for the number of atoms",
        ),
        (
            "ITEM: NUMBER OF ATOMS\n2",
            "ITEM: NUMBER OF ATOMS\n3",
            0,
            "only 2 atoms",
        ),
        (
            "ITEM: NUMBER OF ATOMS\n2\n",
            "",
            0,
            "before ITEM: NUMBER OF ATOMS",
        ),
        ("radius", "size", 0, "no column radius or diameter"),
        ("xs ys zs", "xs ys q", 0, "no columns x, y, z"),
        ("vx vy", "vx vx", 0, "the column vx a second time"),
        ("0.1 Si", "-0.1 Si", 0, "the radius -0.1"),
        ("0.1 Si", "nan Si", 0, "no number in the column radius"),
        ("2 1 0.5", "1 1 0.5", 0, "the atom 1 occurs twice"),
        ("2 1 0.5", "2.5 1 0.5", 0, "2.5 in the column id"),
        ("1 2 3 9", "1 2 3", 0, "10 columns"),
        ("0 1\n", "1 0\n", 0, "the bounds 1 and 0"),
        ("0 1\n", "0 1 0.5\n", 0, "not upright"),
        (
            "200\n",
            "200\nnonsense\n",
            1,
            "a line that begins with ITEM:",
        ),
        (
            "ITEM: ATOMS id type x y z diameter\n",
            "",
            1,
            "the end of the file within a frame",
        ),
    ] {
        let text = DUMP.replacen(from, to, 1);
        assert_ne!(text, DUMP, "{from}");
        let frames = dumped(&text);
        let error = frames.last().unwrap().as_ref().expect_err(to).to_string();
        assert!(error.contains(part), "{to}: {error}");
        assert_eq!(frames.len(), good + 1, "{to}");
    }
}

#[test]
fn files_are_recognised_by_what_is_in_them() {
    assert_eq!(kind_of(DATA), Some(Kind::DataFile));
    assert_eq!(kind_of(DUMP), Some(Kind::Dump));
    assert_eq!(
        kind_of("1 0 0 0 0 1 1 1\n0.5 0.5 0.5 0 0 0 0.1 0 0 0 0 0 0 0\n"),
        None
    );
    assert_eq!(kind_of(""), None);
}

/// A frame as ours are.
fn frame(spheres: &[(u32, [f64; 3], [f64; 6], f64)]) -> Snapshot {
    let grains = Grains {
        title: "some".to_owned(),
        step: 5,
        time: Some(0.25),
        domain: Some((DVec3::splat(-2.0), DVec3::splat(2.0))),
        periodic: [false; 3],
        ids: (1..=spheres.len() as u64).collect(),
        types: spheres.iter().map(|sphere| sphere.0).collect(),
        radius: spheres.iter().map(|sphere| sphere.3).collect(),
        position: spheres
            .iter()
            .map(|sphere| DVec3::from_array(sphere.1))
            .collect(),
        velocity: Some(
            spheres
                .iter()
                .map(|s| DVec3::new(s.2[0], s.2[1], s.2[2]))
                .collect(),
        ),
        angular_velocity: Some(
            spheres
                .iter()
                .map(|s| DVec3::new(s.2[3], s.2[4], s.2[5]))
                .collect(),
        ),
        ..Grains::default()
    };
    grains.snapshot(Path::new("a.lmp"), 0)
}

/// All that both formats hold.
fn spheres(grains: &Grains) -> String {
    format!(
        "{:?} {:?} {:?} {:?} {:?} {:?} {:?}",
        grains.ids,
        grains.types,
        grains.radius,
        grains.position,
        grains.velocity,
        grains.angular_velocity,
        grains.domain
    )
}

proptest! {
    #[test]
    fn what_we_write_we_read(
        rows in prop::collection::vec((1u32..5, prop::array::uniform3(-1.0..1.0), prop::array::uniform6(-1e3..1e3), 1e-6..1.0), 1..8)
    ) {
        let snapshot = frame(&rows);
        let mut text = Vec::new();
        push_data_file(&snapshot, Some(Density::new(2500.0).unwrap()), &mut text).unwrap();
        let read = data(std::str::from_utf8(&text).unwrap()).unwrap();
        let mut dump = Vec::new();
        push_dump(&snapshot, &mut dump).unwrap();
        let dumped = dumped(std::str::from_utf8(&dump).unwrap()).remove(0).unwrap();
        // To the last bit, though one holds diameters and the other radii.
        prop_assert_eq!(spheres(&read), spheres(&dumped));
        let radii: Vec<f64> = rows.iter().map(|row| row.3).collect();
        prop_assert_eq!(read.radius, radii);
        prop_assert_eq!(dumped.step, 5);
    }

    #[test]
    fn no_text_makes_a_panic(text in "(2 atoms\n|Atoms\n\n|ITEM: [A-Z ]{0,20}\n|ITEM: ATOMS id x y z radius\n|[0-9 .a-z-]{0,20}\n){0,12}") {
        let _ = data(&text);
        let _ = dumped(&text);
        let _ = kind_of(&text);
    }
}
