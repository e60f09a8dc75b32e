use std::path::Path;

use proptest::prelude::*;

use super::*;
use crate::error::FormatError;
use crate::formats::number::NumberStyle;
use crate::particle_properties::FILM_VOLUME;
use crate::reference_data::shared;

fn read(text: &str) -> Result<Vec<ParticleRow>, FormatError> {
    parse_particle_csv(Path::new("p.csv"), text)
}

fn written(rows: &[ParticleRow]) -> String {
    let mut out = Vec::new();
    push_particle_csv(rows, NumberStyle::Shortest, &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

#[test]
fn columns_in_any_order_with_any_separator() {
    let expected = ParticleRow {
        position: DVec3::new(1.0, 2.0, 3.0),
        clump: None,
        radius: 0.5,
        material: Some("glass".into()),
        velocity: DVec3::new(0.0, -4.0, 0.0),
        angular_velocity: DVec3::new(0.0, 0.0, 5.0),
        properties: vec![(&FILM_VOLUME, 1e-12)],
        line: 4,
    };
    let table = "# a comment, with comma\n\nradius,z,film_volume,y,x,vy,wz,material\n0.5,3,1e-12,2,1,-4,5,glass\n  # end\n\n";
    assert_eq!(read(table).unwrap(), std::slice::from_ref(&expected));
    for other in [
        table.replace(',', ";"),
        table.replace(',', "\t"),
        table.replace(',', " , "),
        table.replace('\n', "\r\n"),
        format!("\u{feff}{table}"),
        table.replace("glass", "\"glass\""),
        table.trim_end().to_owned(),
    ] {
        assert_eq!(
            read(&other).unwrap(),
            std::slice::from_ref(&expected),
            "{other:?}"
        );
    }
}

#[test]
fn optional_columns_default_to_zero() {
    let row = &read("x,y,z,radius\n1,2,3,4\n").unwrap()[0];
    assert_eq!(
        (row.velocity, row.angular_velocity),
        (DVec3::ZERO, DVec3::ZERO)
    );
    assert_eq!((&row.properties, &row.material), (&vec![], &None));
    assert_eq!(row.line, 2);
    let row = &read("x,y,z,radius,material\n1,2,3,4,\n").unwrap()[0];
    assert_eq!(row.material, None);
    assert!(read("x,y,z,radius\n").unwrap().is_empty());
}

#[test]
fn units_stand_in_the_header() {
    let text = "x [mm],y (um),z[m],radius [cm],vx [mm/s],wz [rpm],film_volume [mm3],mass [kg],qw\n\
        2.1,300,7,0.3,-5,30,2,1,1\n";
    let row = &read(&text.replace(",qw\n", "\n").replace(",1,1\n", ",1\n")).unwrap()[0];
    let [(_, film)] = row.properties[..] else {
        panic!("{row:?}")
    };
    // Half a turn in a second is pi. Units and products are rounded.
    let found = [
        row.position.x,
        row.position.y,
        row.position.z,
        row.radius,
        row.velocity.x,
        row.angular_velocity.z,
        film,
    ];
    let expected = [2.1e-3, 3e-4, 7.0, 3e-3, -5e-3, std::f64::consts::PI, 2e-9];
    for (found, expected) in found.iter().zip(expected) {
        assert!(
            (found / expected - 1.0).abs() < 4.0 * f64::EPSILON,
            "{found} {expected}"
        );
    }
    for (from, to, column, part) in [
        (
            "x [mm]",
            "x [kg]",
            1,
            "the unit \"kg\" of column x, expected a length",
        ),
        (
            "x [mm]",
            "x [furlong]",
            1,
            "the unit \"furlong\" of column x, expected a length",
        ),
        (
            "wz [rpm]",
            "wz [Hz]",
            42,
            "the unit \"Hz\" of column wz, expected an angular velocity",
        ),
        (
            ",qw",
            ",qw [m],qx,qy,qz",
            79,
            "the unit \"m\" of column qw, expected no unit",
        ),
        (
            "radius [cm]",
            "Radius [cm]",
            20,
            "unknown column \"Radius\"",
        ),
    ] {
        let error = read(&text.replace(from, to)).unwrap_err();
        assert_eq!(error.column, Some(column), "{error}");
        assert!(error.to_string().contains(part), "{error}");
    }
}

#[test]
fn all_mistakes_of_a_header_and_of_rows_are_reported() {
    let new = |text: &'static str| ParticleTableReader::new(text.as_bytes(), Path::new("p.csv"));
    let errors = new("x,x,raduis,y [s],spin\n").err().unwrap();
    let columns: Vec<_> = errors.iter().map(|error| error.column.unwrap()).collect();
    assert_eq!(columns, [3, 5, 12, 18]);
    let found: Vec<bool> = new("x,y,z,radius\n1,2,3,4\n1,2,3,x\n1,2\n1,2,3,4\n")
        .unwrap()
        .map(|row| row.is_ok())
        .collect();
    assert_eq!(found, [true, false, false, true]);
    let many = format!("{}x,y,z,radius\n", "colour,".repeat(1000));
    let reader = ParticleTableReader::new(many.as_bytes(), Path::new("p.csv"));
    assert_eq!(reader.err().unwrap().len(), 20);
}

#[test]
fn columns_that_are_not_needed_are_named() {
    let text = "id,x,mass,y,z,type,radius\n7,1,?,2,3,b,4\n";
    let table = ParticleTableReader::new(text.as_bytes(), Path::new("p.csv")).unwrap();
    assert!(table.ignored().eq(["id", "mass", "type"]));
    let rows: Vec<ParticleRow> = table.map(Result::unwrap).collect();
    assert_eq!(
        (rows[0].position, rows[0].radius),
        (DVec3::new(1.0, 2.0, 3.0), 4.0)
    );
}

#[test]
fn clumps_stand_beside_spheres() {
    let rows =
        read("clump,x,y,z,radius,scale,qw,qx,qy,qz,vx\nrod,1,2,3,,2,0,0,1,0,5\n,1,2,3,4,,,,,,0\n")
            .unwrap();
    let clump = rows[0].clump.as_ref().unwrap();
    assert_eq!((clump.name.as_str(), clump.scale), ("rod", 2.0));
    assert_eq!(clump.orientation, [0.0, 0.0, 1.0, 0.0]);
    assert_eq!((rows[0].radius, rows[0].velocity.x), (0.0, 5.0));
    assert_eq!((&rows[1].clump, rows[1].radius), (&None, 4.0));
    // Of clumps alone: no radii, and a value that is not given is the identity.
    let rows = read("x,y,z,clump\n1,2,3,rod\n").unwrap();
    let clump = rows[0].clump.as_ref().unwrap();
    assert_eq!(
        (clump.scale, clump.orientation),
        (1.0, [1.0, 0.0, 0.0, 0.0])
    );
    for (text, part) in [
        ("x,y,z,clump\n1,2,3,\n", "a sphere without a radius"),
        ("x,y,z,clump,qw\n1,2,3,rod,1\n", "an orientation in part"),
        (
            "x,y,z,clump,qw,qx,qy,qz\n1,2,3,rod,0,0,0,0\n",
            "an orientation of length 0",
        ),
        ("x,y,z,clump,scale\n1,2,3,rod,0\n", "\"0\" in column scale"),
        ("x,y,z,clump,scale\n1,2,3,rod,\n", "\"\" in column scale"),
    ] {
        let error = read(text).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
    assert!(push_particle_csv(&rows, NumberStyle::Shortest, &mut Vec::new()).is_err());
}

#[test]
fn bad_input_is_located_and_explained() {
    // Text, line, column, part of the message, part of the help.
    for (text, line, column, part, help) in [
        (
            "x,y,z,raduis\n",
            1,
            7,
            "unknown column \"raduis\"",
            "did you mean radius?",
        ),
        (
            "X,y,z,radius\n",
            1,
            1,
            "unknown column \"X\"",
            "did you mean x?",
        ),
        (
            "x,y,z,r\n",
            1,
            7,
            "unknown column \"r\"",
            "did you mean radius?",
        ),
        (
            "x,y,z,diameter\n",
            1,
            7,
            "unknown column \"diameter\"",
            "halve",
        ),
        (
            "x,y,z,radius,colour\n",
            1,
            14,
            "unknown column",
            "remove the column",
        ),
        (
            "x y z radius\n",
            1,
            1,
            "unknown column",
            "separate the columns by comma",
        ),
        (
            "\n# c\nx,y,z,radius, x\n",
            3,
            15,
            "column x a second time",
            "",
        ),
        ("x,y,radius\n1,2,3\n", 1, 1, "no column z", "add it"),
        ("x,y,z,radius;vx\n", 1, 13, "several separators", ""),
        (
            "1,2,3,4\n",
            1,
            1,
            "numbers in the first line",
            "x,y,z,radius",
        ),
        (
            "x,y,z,radius\n1,2,3\n",
            2,
            6,
            "3 cells",
            "separated by comma",
        ),
        ("x,y,z,radius\n1,2,3,4,\n", 2, 9, "5 cells", ""),
        (
            "x;y;z;radius\n1,2,3,4\n",
            2,
            8,
            "1 cell",
            "separated by semicolon",
        ),
        (
            "x;y;z;radius\n1,5;2;3;4\n",
            2,
            1,
            "\"1,5\" in column x",
            "decimal point",
        ),
        (
            "x,y,z,radius\n1,2,3,4\n1, two,3,4\n",
            3,
            4,
            "\"two\" in column y",
            "",
        ),
        (
            "x,y,z,radius\n1,,3,4\n",
            2,
            3,
            "\"\" in column y",
            "fill it",
        ),
        ("x,y,z,radius\n1,nan,3,4\n", 2, 3, "\"nan\" in column y", ""),
        (
            "x,y,z,radius\n1,2,1e999,4\n",
            2,
            5,
            "\"1e999\" in column z",
            "",
        ),
        (
            "x,y,z,radius\n1,2,3,0\n",
            2,
            7,
            "\"0\" in column radius",
            "in m",
        ),
        (
            "x,y,z,radius\n1,2,3,-0.5\n",
            2,
            7,
            "\"-0.5\" in column radius",
            "in m",
        ),
        (
            "x,y,z,radius,film_volume\n1,2,3,4,-1\n",
            2,
            9,
            "in column film_volume",
            "",
        ),
    ] {
        let error = read(text).unwrap_err();
        assert_eq!(
            (error.line, error.column),
            (Some(line), Some(column)),
            "{text:?}: {error}"
        );
        assert!(error.found.contains(part), "{error}");
        assert!(
            error.help.as_deref().unwrap_or_default().contains(help),
            "{error}"
        );
        assert!(!error.expected.is_empty(), "{error}");
    }
    for empty in ["", "\n \n", "# only\n"] {
        let error = read(empty).unwrap_err();
        assert!(error.to_string().contains("the table is empty"), "{error}");
    }
}

#[test]
fn files_that_cannot_be_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.csv");
    assert!(
        read_particle_csv(&path)
            .unwrap_err()
            .found
            .contains("cannot be opened")
    );
    std::fs::write(&path, b"x,y,z,radius,material\n1,2,3,4,gr\xfcn\n").unwrap();
    let error = read_particle_csv(&path).unwrap_err();
    assert_eq!((error.line, error.column), (Some(2), Some(11)));
    assert!(error.help.unwrap().contains("UTF-8"));
}

#[test]
fn tables_of_the_examples() {
    for (name, count) in [
        ("scenes/particles.csv", 2),
        ("data/bench/dense-2k.csv", 2000),
        ("data/bench/mesh-drum-6k.csv", 6000),
    ] {
        let Some(path) = shared(name) else { return };
        let rows = read_particle_csv(path).unwrap();
        assert_eq!(rows.len(), count, "{name}");
    }
}

#[test]
fn a_material_that_would_not_read_back_is_refused() {
    let mut row = read("x,y,z,radius\n1,2,3,4\n").unwrap().remove(0);
    for bad in ["", " a", "a\"b", "a\nb"] {
        row.material = Some(bad.into());
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.csv");
        assert!(write_particle_csv(&path, std::slice::from_ref(&row)).is_err());
        assert!(!path.exists());
    }
}

/// 100,000 rows take a fraction of a second.
#[test]
fn large_tables_are_read() {
    let row = read("x,y,z,radius\n0.123456789012345,2e-5,3.3333333333333335,0.002\n")
        .unwrap()
        .remove(0);
    let text = written(&vec![row; 100_000]);
    assert_eq!(read(&text).unwrap().len(), 100_000);
}

fn finite() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<u64>()
            .prop_map(f64::from_bits)
            .prop_filter("finite", |value| value.is_finite()),
        Just(-0.0),
        -1.0..1.0,
    ]
}

prop_compose! {
    fn any_particle()(
        x in [finite(), finite(), finite()], v in [finite(), finite(), finite()],
        w in [finite(), finite(), finite()], radius in 5e-324..1e300,
        material in prop::option::of("[a-z#;\u{e4}][a-z, ;#\u{e4}]{0,5}[a-z]"), film_volume in prop_oneof![Just(0.0), 0.0..1.0_f64],
    ) -> ParticleRow {
        ParticleRow {
            position: DVec3::from_array(x), clump: None, radius, material, velocity: DVec3::from_array(v),
            angular_velocity: DVec3::from_array(w), line: 0,
            properties: (film_volume != 0.0).then_some((&FILM_VOLUME, film_volume)).into_iter().collect(),
        }
    }
}

proptest! {
    #[test]
    fn round_trip_is_exact(mut rows in prop::collection::vec(any_particle(), 0..6)) {
        let back = read(&written(&rows)).unwrap();
        for (index, row) in rows.iter_mut().enumerate() {
            row.line = index + 2;
        }
        // The debug text distinguishes -0 from 0, which == does not.
        prop_assert_eq!(format!("{back:?}"), format!("{rows:?}"));
    }

    #[test]
    fn garbage_never_panics(text in "(x,y,z,radius\n)?([0-9a-z.,;\"# \\-\u{e4}]|\n|\t|\r){0,100}") {
        if let Err(error) = read(&text) {
            prop_assert!(error.line.is_some() || error.found.contains("empty"));
        }
    }
}
