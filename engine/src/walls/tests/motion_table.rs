//! The table of a motion: interpolation, and the CSV file with everything that can be wrong in it.

use crate::walls::{Component, Motion, MotionTable};
use glam::{DQuat, DVec3};
use proptest::prelude::*;
use std::path::Path;

fn parse(text: &str) -> Result<MotionTable, String> {
    MotionTable::parse(Path::new("m.csv"), text).map_err(|e| e.to_string())
}

fn motion(text: &str, origin: DVec3) -> Motion {
    let table = parse(text).unwrap();
    Motion::new(vec![Component::Table { table, origin }]).unwrap()
}

#[test]
fn rows_are_joined_by_lines_and_held_outside() {
    let motion = motion("t,x,y,z\n0.5,0,0,0.01\n1,0,0,0.03\n", DVec3::ZERO);
    let height = |t| motion.pose(t).translation.z;
    assert_eq!(
        [height(0.0), height(0.5), height(1.0), height(9.0)],
        [0.01, 0.01, 0.03, 0.03]
    );
    assert!((height(0.75) - 0.02).abs() < 1e-17);
    let speed = |t| motion.velocity(t).velocity.z;
    assert_eq!([speed(0.4), speed(1.0)], [0.0, 0.0]);
    assert!((speed(0.5) - 0.04).abs() < 1e-16);
}

#[test]
fn rotation_vectors_turn_about_the_origin() {
    let text = "angle_z,angle_x,angle_y,t,x,y,z\r\n\r\n0,0,0,0,0,0,0\n# half way\n2,0,0,1,5,0,0\n";
    let motion = motion(text, DVec3::X);
    let expected = DVec3::X + DQuat::from_rotation_z(1.0) * DVec3::Y + DVec3::X * 2.5;
    let found = motion.pose(0.5).to_global(DVec3::new(1.0, 1.0, 0.0));
    assert!((found - expected).length() < 1e-15);
    let field = motion.velocity(0.5);
    assert!((field.angular_velocity - DVec3::Z * 2.0).length() < 1e-15);
    assert!((field.at(DVec3::X * 3.5) - DVec3::X * 5.0).length() < 1e-14);
}

/// Where the series of the Jacobian takes over from the closed form, the angular velocity must not
/// jump.
#[test]
fn the_angular_velocity_is_continuous_in_the_angle() {
    for border in [1e-4, 0.1_f64] {
        let at = |angle: f64| {
            // The vector is (angle, 0, 0) at t = 0 and changes across it.
            let text = format!(
                "t,x,y,z,angle_x,angle_y,angle_z\n-1,0,0,0,{angle},-1,0\n1,0,0,0,{angle},1,0\n"
            );
            motion(&text, DVec3::ZERO).velocity(0.0).angular_velocity
        };
        let (below, above) = (at(border * (1.0 - 1e-14)), at(border * (1.0 + 1e-14)));
        // p = a x, p' = y: (sin a)/a y + (1 - cos a)/a z.
        let sine = (0.5 * border).sin();
        let exact = DVec3::new(0.0, border.sin() / border, 2.0 * sine * sine / border);
        assert!((below - above).length() < 1e-14, "{below} {above}");
        assert!((below - exact).length() < 1e-14, "{below} {exact}");
    }
}

#[test]
fn every_mistake_is_named_with_its_place() {
    let header = "the columns t,x,y,z or t,x,y,z,angle_x,angle_y,angle_z";
    let cases = [
        ("", format!("m.csv: no header, expected {header}")),
        ("# only\n\n", format!("m.csv: no header, expected {header}")),
        (
            "t,x,y,z\n",
            "m.csv: no rows, expected at least one row below the header".into(),
        ),
        (
            "t,x,z\n0,0,0\n",
            format!("m.csv:1: no column \"y\", expected {header}"),
        ),
        (
            "t,x,y,z,w\n",
            format!("m.csv:1:9: the column \"w\", expected {header}"),
        ),
        (
            "t,x, x\n",
            format!("m.csv:1:6: the column \"x\" a second time, expected {header}"),
        ),
        (
            "t,x,y,z,angle_x\n",
            format!("m.csv:1: no column \"angle_y\", expected {header}"),
        ),
        (
            "t,x,y,z\n0,0,0\n",
            "m.csv:2: 3 fields, expected 4, as in the header".into(),
        ),
        (
            "t,x,y,z\n0,0,0,0,7\n",
            "m.csv:2:9: one more field, \"7\", expected 4 fields, as in the header".into(),
        ),
        (
            "t,x,y,z\n0,0,ä1,0\n",
            "m.csv:2:5: \"ä1\" in column y, expected a finite number".into(),
        ),
        (
            "t,x,y,z\n0,,0,0\n",
            "m.csv:2:3: \"\" in column x, expected a finite number".into(),
        ),
        (
            "t,x,y,z\n0,0,0,nan\n",
            "m.csv:2:7: \"nan\" in column z, expected a finite number".into(),
        ),
        (
            "t,x,y,z\n0,0,0,1e999\n",
            "m.csv:2:7: \"1e999\" in column z, expected a finite number".into(),
        ),
        (
            "x,t,y,z\n0,1,0,0\n\n0,1,0,0\n",
            "m.csv:4:3: t = 1, expected a time after that of the row before, 1".into(),
        ),
    ];
    for (text, expected) in cases {
        assert_eq!(parse(text), Err(expected), "{text:?}");
    }
}

#[test]
fn files_that_are_not_there_or_not_text_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("motion.csv");
    let error = MotionTable::read(&path).unwrap_err();
    assert!(error.to_string().contains("the file cannot be opened"));
    std::fs::write(&path, b"t,x,y,z\n0,0,0,\xff\n").unwrap();
    let error = MotionTable::read(&path).unwrap_err();
    assert_eq!(error.line, Some(2));
    std::fs::write(&path, b"\xef\xbb\xbft,x,y,z\n0,0,0,1\n").unwrap();
    assert_eq!(
        MotionTable::read(&path)
            .unwrap()
            .displacement()
            .rows()
            .len(),
        1
    );
}

proptest! {
    #[test]
    fn any_text_is_a_table_or_an_error(text in "[t,xyz0-9.e\n\r#\"a-]{0,60}") {
        if let Ok(table) = parse(&text) {
            prop_assert!(table.displacement().rows().windows(2).all(|r| r[0].0 < r[1].0));
        }
    }

    #[test]
    fn written_rows_are_read_back(
        steps in prop::collection::vec((0.001..1.0_f64, -1.0..1.0_f64, -1.0..1.0_f64), 1..20),
    ) {
        let mut text = String::from("t,x,y,z\n");
        let mut time = 0.0;
        let mut expected = Vec::new();
        for (step, x, y) in steps {
            time += step;
            text += &format!("{time},{x},{y},0\n");
            expected.push((time, DVec3::new(x, y, 0.0)));
        }
        let table = parse(&text).unwrap();
        prop_assert_eq!(table.displacement().rows(), expected);
    }
}
