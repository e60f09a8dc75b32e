use proptest::prelude::*;

use super::*;
use crate::error::FormatError;
use crate::formats::number::NumberStyle;
use crate::formats::test_support::{any_number, any_vector, assert_same_numbers};
use crate::reference_data::shared;

const HEADER: &str = "# 0 1\n# -1 -1 0 1 1 3\n# 0.5 0.5 0 0 0 0\n";

fn read(text: &str) -> Result<Vec<FstatFrame>, FormatError> {
    FstatReader::new(text.as_bytes(), "t.fstat").collect()
}

fn written(frames: &[FstatFrame], style: NumberStyle) -> String {
    let mut out = Vec::new();
    for frame in frames {
        write_frame(frame, style, &mut out);
    }
    String::from_utf8(out).unwrap()
}

/// Two spheres of weight 2 stacked on a floor: the forces of the rows must balance gravity.
#[test]
fn forces_have_physical_signs() {
    let text = format!(
        "{HEADER}0 0 1 0 0 0.995 0.002 0 2 0 0 0 -1 0 0 0\n0 1 0 0 0 0.995 0.002 0 2 0 0 0 1 0 0 0\n\
         0 0 -1 0 0 -0.002 0.004 0 4 0 0 0 -1 0 0 0\n"
    );
    let frames = read(&text).unwrap();
    let rows = &frames[0].contacts;
    let total = |i| {
        rows.iter()
            .filter(|row| row.i == i)
            .map(ContactRow::force)
            .sum::<DVec3>()
    };
    assert_eq!(total(0), DVec3::new(0.0, 0.0, 2.0));
    assert_eq!(total(1), DVec3::new(0.0, 0.0, 2.0));
    assert_eq!(
        rows.iter().map(ContactRow::wall).collect::<Vec<_>>(),
        [None, None, Some(0)]
    );
    assert_eq!(ContactRow::j_of_wall(0), -1);
    assert_eq!(
        (frames[0].radius_min, frames[0].has_contact_points),
        (0.5, true)
    );
    assert_eq!(written(&frames, NumberStyle::Shortest), text);
    assert_eq!(written(&frames, NumberStyle::Digits(10)), text);
}

#[test]
fn empty_frames_nan_radii_and_surplus_columns() {
    let frames = read(
        "# 0 1\n# 0 0 0 1 1 1\n# nan -nan 0 0 0 0\n\n# 1 0\n# 0 0 0 1 1 1\n# 1 2\n\
         1 0 -9223372036854775808 1 2 3 4 5 6 7 8 9 10 11 12 13 99 99\n",
    )
    .unwrap();
    assert_eq!(frames.len(), 2);
    assert!(frames[0].radius_min.is_nan() && frames[0].contacts.is_empty());
    assert!(!frames[1].has_contact_points);
    assert_eq!(frames[1].contacts[0].wall(), Some(i64::MAX));
    assert_eq!(frames[1].contacts[0].tangent, DVec3::new(11.0, 12.0, 13.0));
    assert!(read("").unwrap().is_empty());
}

#[test]
fn bad_input_is_located() {
    let row = |row: &str| format!("{HEADER}{row}\n# 1 1\n# 0 0 0 1 1 1\n# 1 1 0 0 0 0\n");
    for (text, line, column, part) in [
        ("1 2 3\n".into(), 1, Some(1), "does not start with #"),
        ("#t 1\n".into(), 1, Some(1), "\"#t\""),
        ("# t 1\n".into(), 1, Some(3), "\"t\" for time"),
        (
            "# 0 1\n".into(),
            1,
            None,
            "ends within the header of the frame at t = 0",
        ),
        (
            "# 0 1\n# 0 0 0 1 1\n# 1 1\n".into(),
            2,
            Some(12),
            "in place of zMax",
        ),
        (
            "# 0 1\n# 0 0 0 1 1 1\n0 0 1\n".into(),
            3,
            Some(1),
            "\"0\" for the beginning",
        ),
        (
            row("0 1.5 2 0 0 0 0 0 0 0 0 0 1 0 0 0"),
            4,
            Some(3),
            "\"1.5\" for i",
        ),
        (
            row("0 1 2 0 0 0 0 0 0 0 0 0 1 0 0"),
            4,
            Some(30),
            "in place of tangent z",
        ),
        (
            row("0 1 2 0 0 0 x 0 0 0 0 0 1 0 0 0"),
            4,
            Some(13),
            "\"x\" for overlap",
        ),
    ] {
        let error = read(&text).unwrap_err();
        assert_eq!((error.line, error.column), (Some(line), column), "{error}");
        assert!(error.found.contains(part), "{error}");
        assert!(
            error.help.is_none() || line != 4,
            "only a last line is suspected to be cut"
        );
    }
    let cut = read(&format!("{HEADER}0 1 2 0 0 0 0.0")).unwrap_err();
    assert!(cut.help.as_deref().unwrap().contains("unfinished"), "{cut}");
}

/// MercuryDPM's own files survive reading and writing with its precision.
#[test]
fn files_of_mercury_dpm() {
    for (name, digits) in [
        ("chute-legacy/chute_periodic.fstat", 13),
        ("chute-legacy/hopper_3d_demo.fstat", 13),
        ("interactions/LiquidMigrationTwoSpeciesSelfTest.fstat", 10),
        ("interactions/ObliqueImpactSelfTest.fstat", 10),
        ("unittests/MindlinSelfTestLoading.fstat", 10),
        (
            "unittests/MindlinSelfTestNormalAndTangentialLoading.fstat",
            10,
        ),
    ] {
        let Some(path) = shared(&format!("data/selftest/{name}")) else {
            return;
        };
        let text = std::fs::read_to_string(&path).unwrap();
        let frames: Vec<_> = FstatReader::open(&path)
            .unwrap()
            .collect::<Result<_, _>>()
            .unwrap();
        assert_eq!(
            frames.len(),
            text.lines().filter(|line| line.starts_with('#')).count() / 3
        );
        let different =
            assert_same_numbers(&written(&frames, NumberStyle::Digits(digits)), &text, name);
        assert!(
            digits != 10 || different == 0,
            "{name}: {different} tokens differ as text"
        );
        assert_eq!(
            read(&written(&frames, NumberStyle::Shortest)).unwrap(),
            frames,
            "{name}"
        );
    }
}

prop_compose! {
    fn any_contact()(
        time in any_number(), i: i64, j: i64, contact_point in any_vector(), overlap in any_number(),
        tangential_overlap in any_number(), normal_force in any_number(),
        tangential_force in any_number(), normal in any_vector(), tangent in any_vector(),
    ) -> ContactRow {
        ContactRow {
            time, i, j, contact_point, overlap, tangential_overlap, normal_force, tangential_force, normal,
            tangent,
        }
    }
}

prop_compose! {
    fn any_frame()(
        time in any_number(), has_contact_points: bool, min in any_vector(), max in any_vector(),
        radii in [any_number(), any_number()], contacts in prop::collection::vec(any_contact(), 0..4),
    ) -> FstatFrame {
        FstatFrame {
            time, has_contact_points, min, max, radius_min: radii[0], radius_max: radii[1], contacts,
        }
    }
}

proptest! {
    #[test]
    fn shortest_round_trip_is_exact(frames in prop::collection::vec(any_frame(), 1..4)) {
        let back = read(&written(&frames, NumberStyle::Shortest)).unwrap();
        // The debug text distinguishes -0 from 0, which == does not, and prints numbers uniquely.
        prop_assert_eq!(format!("{back:?}"), format!("{frames:?}"));
    }

    #[test]
    fn garbage_never_panics(text in "([0-9a-z.# \\-]|\n){0,200}") {
        if let Err(error) = read(&text) {
            prop_assert!(error.line.is_some());
        }
    }
}
