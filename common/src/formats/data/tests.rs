use proptest::prelude::*;

use super::*;
use crate::error::FormatError;
use crate::formats::number::NumberStyle;
use crate::formats::test_support::{any_number, any_vector, assert_same_numbers};
use crate::reference_data::shared;

fn read(text: &str) -> Result<Vec<DataFrame>, FormatError> {
    DataReader::new(text.as_bytes(), "t.data").collect()
}

fn error(text: &str) -> FormatError {
    read(text).unwrap_err()
}

fn written(frames: &[DataFrame], style: NumberStyle) -> String {
    let mut out = Vec::new();
    for frame in frames {
        write_frame(frame, style, &mut out);
    }
    String::from_utf8(out).unwrap()
}

#[test]
fn three_dimensions() {
    let text = "1 0.5 -1 -2 -3 1 2 3 \n1 2 3 4 5 6 0.5 0.1 0.2 0.3 7 8 9 2.5\n";
    let frames = read(text).unwrap();
    assert_eq!(
        frames,
        [DataFrame {
            time: 0.5,
            dimensions: 3,
            min: DVec3::new(-1.0, -2.0, -3.0),
            max: DVec3::new(1.0, 2.0, 3.0),
            particles: vec![DataRow {
                position: DVec3::new(1.0, 2.0, 3.0),
                velocity: DVec3::new(4.0, 5.0, 6.0),
                radius: 0.5,
                angles: DVec3::new(0.1, 0.2, 0.3),
                angular_velocity: DVec3::new(7.0, 8.0, 9.0),
                info: 2.5,
            }],
        }]
    );
    assert_eq!(written(&frames, NumberStyle::Shortest), text);
}

#[test]
fn two_dimensions_flip_the_rotation() {
    let text = "1 0 0 0 1 1 \n0.25 0.5 1 -1 0.1 -0.5 -2 0\n";
    let frames = read(text).unwrap();
    let row = frames[0].particles[0];
    // A positive rotation about +z is written with a minus sign.
    assert_eq!((row.angles.z, row.angular_velocity.z), (0.5, 2.0));
    assert_eq!(row.velocity, DVec3::new(1.0, -1.0, 0.0));
    assert_eq!(written(&frames, NumberStyle::Digits(10)), text);
}

#[test]
fn layouts_that_are_only_read() {
    let seven = read("1 0 0 0 0 1 1 1\n1 3 2 4 6 5 0.5 7\n").unwrap()[0].particles[0];
    assert_eq!(seven.position, DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(seven.velocity, DVec3::new(4.0, 5.0, 6.0));
    assert_eq!((seven.radius, seven.info), (0.5, 7.0));

    let mut reader = DataReader::new(
        &b"1 0 0 0 0 1 1 1\n1 2 3 4 5 6 7 8 9 10 11 12 13 99 14\n"[..],
        "t.data",
    );
    let fifteen = reader.next().unwrap().unwrap().particles[0];
    assert_eq!(reader.layout(), Some(DataLayout::Format15));
    assert_eq!(fifteen.angular_velocity, DVec3::new(11.0, 12.0, 13.0));
    assert_eq!(fifteen.info, 14.0);
}

#[test]
fn surplus_columns_comments_and_blank_lines_are_ignored() {
    let frames = read(
        "# comment\n\n1 0 0 0 1 1\n# again\n1 2 3 4 5 6 7 8 0 1\r\n\n\
         1 1 0 0 0 1 1 1\n1 2 3 4 5 6 7 8 9 10 11 12 13 14 0 0\n0 2 0 0 1 1\n",
    )
    .unwrap();
    assert_eq!(frames[0].particles[0].info, 8.0);
    assert_eq!(frames[1].particles[0].info, 14.0);
    assert!(frames[2].particles.is_empty());
    assert!(read("").unwrap().is_empty());
}

#[test]
fn an_unfinished_frame_comes_after_the_good_ones() {
    let good = "1 0 0 0 1 1 \n1 2 3 4 5 6 7 8\n";
    for tail in [
        "2 1 0 0 1 1 \n1 2 3 4 5 6 7 8\n",
        "2 1 0 0 1 1 \n1 2 3 4 5 6 7 8\n1 2 3 4",
    ] {
        let text = format!("{good}{tail}");
        let mut reader = DataReader::new(text.as_bytes(), "t.data");
        assert!(reader.next().unwrap().is_ok());
        let error = reader.next().unwrap().unwrap_err();
        assert!(error.found.contains("1 of 2 particles"), "{error}");
        assert!(
            error.help.as_deref().unwrap().contains("remove line 3"),
            "{error}"
        );
        assert!(reader.next().is_none());
    }
}

#[test]
fn bad_input_is_located() {
    for (text, line, column, part) in [
        (
            "x 0 0 0 1 1\n",
            1,
            Some(1),
            "\"x\" for the number of particles",
        ),
        (
            "1.5 0 0 0 1 1\n",
            1,
            Some(1),
            "\"1.5\" for the number of particles",
        ),
        ("-1 0 0 0 1 1\n", 1, Some(1), "\"-1\""),
        ("nan 0 0 0 1 1\n", 1, Some(1), "\"nan\""),
        ("1e300 0 0 0 1 1\n", 1, Some(1), "\"1e300\""),
        ("1 0 0 0 1\n", 1, Some(1), "5 columns"),
        (
            "1 zero 0 0 1 1\n1 2 3 4 5 6 7 8\n",
            1,
            Some(3),
            "\"zero\" for time",
        ),
        (
            "2 0 0 0 1 1\n1 2 3 4 5 6 7 8\n1 2 3 four 5 6 7 8\n0 0 0 0 1 1\n",
            3,
            Some(7),
            "for vy",
        ),
        (
            "2 0 0 0 1 1\n1 2 3 4 5 6 7 8\n1 2 3 4 5\n0 0 0 0 1 1\n",
            3,
            Some(10),
            "in place of angle",
        ),
        (
            "1 0 0 0 0 1 1 1\n1 2 3 4 5 6 7 8 9 10 11 12 13\n",
            2,
            Some(1),
            "13 columns",
        ),
        ("1 0 0 0 1 1\n1 2 3 4 5 6 7\n", 2, Some(1), "7 columns"),
        // One particle more than announced.
        (
            "1 0 0 0 0 1 1 1\n1 2 3 4 5 6 7 8 9 10 11 12 13 14\n1 2 3 4 5 6 7 8 9 10 11 12 13 14\n",
            3,
            Some(1),
            "14 columns",
        ),
    ] {
        let error = error(text);
        assert_eq!((error.line, error.column), (Some(line), column), "{error}");
        assert!(error.found.contains(part), "{error}");
    }
}

#[test]
fn a_huge_count_does_not_take_all_memory() {
    let error = error("9007199254740991 0 0 0 1 1\n1 2 3 4 5 6 7 8\n");
    assert!(error.found.contains("1 of 9007199254740991"), "{error}");
}

#[test]
fn a_missing_file_is_named() {
    let error = DataReader::open("no/such.data").unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("no/such.data: the file cannot be opened"),
        "{error}"
    );
}

/// MercuryDPM's own files survive reading and writing with its precision.
#[test]
fn files_of_mercury_dpm() {
    // The second entry is whether the file was written with the present digits (10 and 15),
    // so that the texts are equal; the chute files have 13 digits.
    for (name, digits, same_text) in [
        (
            "selftest/boundaries/DeletionBoundarySelfTest.data",
            10,
            true,
        ),
        (
            "selftest/chute-legacy/chute_demo_no_restart.data",
            13,
            false,
        ),
        ("selftest/chute-legacy/chute_demo_restart.data", 13, false),
        ("selftest/interactions/ForceSelfTest0.data", 10, true),
        ("selftest/interactions/ForceSelfTest1.data", 10, true),
        ("selftest/interactions/ForceSelfTest2.data", 10, true),
        ("selftest/interactions/ForceSelfTest3.data", 10, true),
        ("selftest/interactions/ForceSelfTest4.data", 10, true),
        ("selftest/unittests/ExtremeOverlapUnitTest.data", 10, true),
        (
            "selftest/walls/ContactDetectionIntersectionOfWallsSelfTest.data",
            10,
            true,
        ),
        ("cg-dense2k/dense2k.data", 10, true),
    ] {
        let Some(path) = shared(&format!("data/{name}")) else {
            return;
        };
        let text = std::fs::read_to_string(&path).unwrap();
        let frames: Vec<_> = DataReader::open(&path)
            .unwrap()
            .collect::<Result<_, _>>()
            .unwrap();
        assert!(!frames.is_empty());
        let back = written(&frames, NumberStyle::Digits(digits));
        let different = assert_same_numbers(&back, &text, name);
        assert!(
            !same_text || different == 0,
            "{name}: {different} tokens differ as text"
        );
        let exact = written(&frames, NumberStyle::Shortest);
        assert_eq!(read(&exact).unwrap(), frames, "{name}");
    }
}

prop_compose! {
    fn any_row()(
        position in any_vector(), velocity in any_vector(), radius in any_number(),
        angles in any_vector(), angular_velocity in any_vector(), info in any_number(),
    ) -> DataRow {
        DataRow { position, velocity, radius, angles, angular_velocity, info }
    }
}

prop_compose! {
    fn any_frame()(
        time in any_number(), two in any::<bool>(), min in any_vector(), max in any_vector(),
        rows in prop::collection::vec(any_row(), 0..4),
    ) -> DataFrame {
        let flat = |v: DVec3| if two { DVec3::new(v.x, v.y, 0.0) } else { v };
        let about_z = |v: DVec3| if two { DVec3::new(0.0, 0.0, v.z) } else { v };
        let particles = rows.into_iter().map(|row| DataRow {
            position: flat(row.position),
            velocity: flat(row.velocity),
            angles: about_z(row.angles),
            angular_velocity: about_z(row.angular_velocity),
            ..row
        }).collect();
        DataFrame { time, dimensions: if two { 2 } else { 3 }, min: flat(min), max: flat(max), particles }
    }
}

/// `-0 == 0`, so equality of values is not enough.
fn bits(frame: &DataFrame) -> Vec<u64> {
    let mut all = vec![frame.time.to_bits(), u64::from(frame.dimensions)];
    let mut add = |v: DVec3| all.extend(v.to_array().map(f64::to_bits));
    add(frame.min);
    add(frame.max);
    for row in &frame.particles {
        add(row.position);
        add(row.velocity);
        add(row.angles);
        add(row.angular_velocity);
        add(DVec3::new(row.radius, row.info, 0.0));
    }
    all
}

proptest! {
    #[test]
    fn shortest_round_trip_is_exact(frames in prop::collection::vec(any_frame(), 1..4)) {
        let back = read(&written(&frames, NumberStyle::Shortest)).unwrap();
        prop_assert_eq!(back.len(), frames.len());
        for (a, b) in back.iter().zip(&frames) {
            prop_assert_eq!(bits(a), bits(b));
        }
    }

    /// Whatever stands in a file, the answer is frames or one located error, never a panic.
    #[test]
    fn garbage_never_panics(text in "([0-9a-z.#\\- ]|\n|\t|\u{e4}){0,200}") {
        if let Err(error) = read(&text) {
            prop_assert!(error.line.is_some());
        }
    }

    #[test]
    fn binary_garbage_never_panics(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = DataReader::new(&bytes[..], "t.data").count();
    }
}
