use std::path::Path;

use glam::{DMat3, DQuat, DVec3};
use proptest::prelude::*;

use super::*;
use crate::reference_data::shared;

const ROD: &str = r#"name = "rod"
density = 2500.0
mass = 3.9269908169872414e-3
volume = 1.5707963267948967e-6
centre_of_mass = [0.0, 0.0, 0.0]
principal_moments = [3.926990816987241e-8, 3.010692959690218e-7, 3.010692959690218e-7]
rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
inertia_method = "pebbles"
pebbles = [
  { position = [-0.01, 0.0, 0.0], radius = 0.005 },
  { position = [0.0, 0.0, 0.0], radius = 0.005 },
  { position = [0.01, 0.0, 0.0], radius = 0.005 },
]
"#;

fn parse(text: &str) -> Result<ClumpFile, String> {
    parse_clump(Path::new("rod.clump.toml"), text).map_err(|errors| errors.to_string())
}

/// Error of the reader when `from` in the file of the rod is replaced by `to`.
fn complaint(from: &str, to: &str) -> String {
    assert!(ROD.contains(from), "{from}");
    parse(&ROD.replacen(from, to, 1)).expect_err(to)
}

#[test]
fn the_shared_rod_reads() {
    let Some(path) = shared("scenes/rod.clump.toml") else {
        return;
    };
    let rod = read_clump(path).unwrap();
    assert_eq!(rod, parse(ROD).unwrap());
    assert_eq!(rod.name, "rod");
    assert_eq!(rod.pebbles.len(), 3);
    assert_eq!(rod.pebbles[2].position, DVec3::new(0.01, 0.0, 0.0));
    assert_eq!(rod.rotation, DMat3::IDENTITY);
}

#[test]
fn pebbles_may_be_tables_and_what_a_hand_written_file_lacks_has_defaults() {
    let text = "name = \"pea\"\ndensity = 1\nmass = 4.19e0\nvolume = 4.19\nprincipal_moments = [1.676, 1.676, 1.676]\n[[pebbles]]\nposition = [0, 0, 0]\nradius = 1\n[checks]\nsound = true\n";
    let pea = parse(text).unwrap();
    assert_eq!(pea.inertia_method, "given");
    assert_eq!(pea.centre_of_mass, DVec3::ZERO);
    assert_eq!(pea.rotation, DMat3::IDENTITY);
    assert_eq!(pea.checks, [("sound".to_owned(), Remark::Flag(true))]);
}

#[test]
fn the_surface_is_found_beside_the_clump_file() {
    let named = ROD.replace("pebbles = [", "surface = \"shapes/rod.stl\"\npebbles = [");
    let rod = parse(&named).unwrap();
    assert_eq!(rod.surface.as_deref(), Some("shapes/rod.stl"));
    let path = rod.surface_path(Path::new("grains/rod.clump.toml"));
    assert_eq!(path.as_deref(), Some(Path::new("grains/shapes/rod.stl")));
    let path = rod.surface_path(Path::new("rod.clump.toml"));
    assert_eq!(path.as_deref(), Some(Path::new("shapes/rod.stl")));
    // Files of earlier versions name none.
    let rod = parse(ROD).unwrap();
    assert_eq!(rod.surface_path(Path::new("rod.clump.toml")), None);
    assert_eq!(
        complaint("pebbles = [", "surface = \"\"\npebbles = ["),
        "rod.clump.toml:9:11: surface: must not be empty\n    surface = \"\"\n              ^^"
    );
}

#[test]
fn rows_of_the_rotation_are_rows() {
    let turned = ROD.replace(
        "[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]",
        "[[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]",
    );
    // The first principal axis is the first column: y.
    assert_eq!(parse(&turned).unwrap().rotation.x_axis, DVec3::Y);
}

#[test]
fn every_mistake_has_its_place_and_its_words() {
    for (from, to, expected) in [
        (
            "density = 2500.0",
            "density = -2500.0",
            "rod.clump.toml:2:11: density: must be > 0, got -2500\n    density = -2500.0\n              ^^^^^^^",
        ),
        (
            "mass = 3.9269908169872414e-3",
            "mass = 3.9269908169872414",
            "rod.clump.toml:3:8: mass: must be density times volume, 0.003926990816987242 kg, got 3.9269908169872414\n    mass = 3.9269908169872414\n           ^^^^^^^^^^^^^^^^^^",
        ),
        (
            "volume = 1.5707963267948967e-6\n",
            "",
            "rod.clump.toml:1:1: volume: is missing\n    name = \"rod\"\n    ^",
        ),
        (
            "[3.926990816987241e-8, 3.010692959690218e-7, 3.010692959690218e-7]",
            "[3.0, 2.0, 4.0]",
            "rod.clump.toml:6:21: principal_moments: must be ascending\n    principal_moments = [3.0, 2.0, 4.0]\n                        ^^^^^^^^^^^^^^^",
        ),
        (
            "[3.926990816987241e-8, 3.010692959690218e-7, 3.010692959690218e-7]",
            "[1.0, 2.0, 4.0]",
            "rod.clump.toml:6:21: principal_moments: the largest, 4, must not exceed the sum of the others, 3: no body has such moments\n    principal_moments = [1.0, 2.0, 4.0]\n                        ^^^^^^^^^^^^^^^",
        ),
        (
            "[3.926990816987241e-8, 3.010692959690218e-7, 3.010692959690218e-7]",
            "[0.0, 1.0, 1.0]",
            "rod.clump.toml:6:21: principal_moments: must all be > 0, got 0\n    principal_moments = [0.0, 1.0, 1.0]\n                        ^^^^^^^^^^^^^^^",
        ),
        (
            "rotation = [[1.0, 0.0, 0.0]",
            "rotation = [[-1.0, 0.0, 0.0]",
            "rod.clump.toml:7:12: rotation: must be right-handed (determinant +1): this one is a reflection\n    rotation = [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]\n               ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^",
        ),
        (
            "rotation = [[1.0, 0.0, 0.0]",
            "rotation = [[1.0, 0.1, 0.0]",
            "rod.clump.toml:7:12: rotation: its columns must be perpendicular and of length 1, they are off by 1.0e-1\n    rotation = [[1.0, 0.1, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]\n               ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^",
        ),
        (
            "rotation = [[1.0, 0.0, 0.0], ",
            "rotation = [",
            "rod.clump.toml:7:12: rotation: expected 3 rows of 3 numbers, got 2\n    rotation = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]\n               ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^",
        ),
        (
            "{ position = [0.0, 0.0, 0.0], radius = 0.005 }",
            "{ position = [0.0, 0.0, 0.0], radius = 0 }",
            "rod.clump.toml:11:42: pebbles[1].radius: must be > 0, got 0\n      { position = [0.0, 0.0, 0.0], radius = 0 },\n                                             ^",
        ),
        (
            "{ position = [0.0, 0.0, 0.0], radius = 0.005 }",
            "{ position = [0.0, nan, 0.0], radius = 0.005 }",
            "rod.clump.toml:11:22: pebbles[1].position[1]: must be finite, got nan\n      { position = [0.0, nan, 0.0], radius = 0.005 },\n                         ^^^",
        ),
        (
            "{ position = [0.0, 0.0, 0.0], radius = 0.005 }",
            "{ position = [0.0, 0.0, 0.0], diameter = 0.01 }",
            "rod.clump.toml:11:33: pebbles[1].diameter: is not a known key\n      { position = [0.0, 0.0, 0.0], diameter = 0.01 },\n                                    ^^^^^^^^\nhelp: half of it is the radius: radius = 0.005",
        ),
        (
            "density",
            "densty",
            "rod.clump.toml:2:1: densty: is not a known key\n    densty = 2500.0\n    ^^^^^^\nhelp: did you mean `density`?",
        ),
        (
            "name = \"rod\"",
            "name = \" \"",
            "rod.clump.toml:1:8: name: must not be empty\n    name = \" \"\n           ^^^",
        ),
    ] {
        let found = complaint(from, to);
        let trimmed = |text: &str| {
            text.lines()
                .map(str::trim_end)
                .collect::<Vec<_>>()
                .join("\n")
        };
        assert_eq!(trimmed(&found), trimmed(expected), "{to}");
    }
    let start = ROD.find("pebbles = ").unwrap();
    assert_eq!(
        parse(&format!("{}pebbles = []\n", &ROD[..start])).unwrap_err(),
        "rod.clump.toml:9:11: pebbles: at least one is needed\n    pebbles = []\n              ^^"
    );
}

#[test]
fn a_missing_file_and_other_bytes_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("none.clump.toml");
    let error = read_clump(&path).unwrap_err().to_string();
    assert!(
        error.contains("none.clump.toml: the clump file cannot be read: "),
        "{error}"
    );
    std::fs::write(&path, b"name = \"\xff\"").unwrap();
    let error = read_clump(&path).unwrap_err().to_string();
    assert!(error.contains("this is not UTF-8 text"), "{error}");
    assert!(parse("").unwrap_err().contains("name: is missing"));
}

#[test]
fn what_would_not_read_back_is_not_written() {
    let rod = parse(ROD).unwrap();
    let mut out = Vec::new();
    for (wrong, message) in [
        (
            ClumpFile {
                mass: f64::NAN,
                ..rod.clone()
            },
            "mass: must be finite, got NaN",
        ),
        (
            ClumpFile {
                surface: Some("rod\n.stl".into()),
                ..rod.clone()
            },
            "surface: must not hold line breaks or other control characters",
        ),
        (
            ClumpFile {
                checks: vec![("error".into(), Remark::Number(f64::INFINITY))],
                ..rod.clone()
            },
            "checks.error: must be finite, got inf",
        ),
        (
            ClumpFile {
                checks: vec![("a".into(), 1.0.into()), ("a".into(), 2.0.into())],
                ..rod.clone()
            },
            "checks.a: is given twice",
        ),
    ] {
        assert_eq!(
            push_clump(&wrong, &mut out).unwrap_err().to_string(),
            message
        );
    }
    assert!(out.is_empty());
}

fn magnitude() -> impl Strategy<Value = f64> {
    prop_oneof![1e-30..1e-20, 1e-6..1e-3, 0.5..2.0, 1e3..1e9]
}

fn point() -> impl Strategy<Value = DVec3> {
    let coordinate = || prop_oneof![-1.0..1.0, -1e9..1e9, Just(-0.0), Just(1e22), Just(5e-324)];
    [coordinate(), coordinate(), coordinate()].prop_map(DVec3::from_array)
}

fn remark() -> impl Strategy<Value = Remark> {
    let leaf = prop_oneof![
        prop::num::f64::NORMAL.prop_map(Remark::Number),
        any::<i64>().prop_map(Remark::Whole),
        any::<bool>().prop_map(Remark::Flag),
        any::<String>().prop_map(Remark::Text),
    ];
    leaf.prop_recursive(3, 20, 4, |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..4).prop_map(Remark::List),
            prop::collection::btree_map(any::<String>(), inner, 0..4)
                .prop_map(|table| Remark::Table(table.into_iter().collect())),
        ]
    })
}

prop_compose! {
    fn any_clump()(
        name in "[a-z\"\\\\'é#]{1,8}",
        (density, volume, largest) in (magnitude(), magnitude(), magnitude()),
        (b, share) in (0.5..=1.0f64, 0.0..=1.0f64),
        centre_of_mass in point(),
        turn in [-1.0..1.0f64, -1.0..1.0, -1.0..1.0, 0.1..1.0],
        method in any::<String>(),
        pebbles in prop::collection::vec((point(), magnitude()), 1..6),
        checks in prop::collection::btree_map(any::<String>(), remark(), 0..4),
        surface in prop::option::of("[a-z ./\"\\\\'é#]{1,12}"),
        source in prop::collection::btree_map("[a-z_]{1,5}", remark(), 0..3),
    ) -> ClumpFile {
        // Ascending, and the largest at most the sum of the others.
        let middle = b * largest;
        let smallest = (largest - middle) + share * (middle - (largest - middle));
        ClumpFile {
            name,
            density,
            mass: density * volume,
            volume,
            centre_of_mass,
            principal_moments: DVec3::new(smallest.max(largest * 1e-3), middle, largest),
            rotation: DMat3::from_quat(DQuat::from_array(turn).normalize()),
            inertia_method: if method.trim().is_empty() || method.chars().any(char::is_control) { "union".into() } else { method },
            pebbles: pebbles.into_iter().map(|(position, radius)| Pebble { position, radius }).collect(),
            surface: surface.filter(|surface| !surface.trim().is_empty()),
            source: source.into_iter().collect(),
            checks: checks.into_iter().collect(),
        }
    }
}

proptest! {
    #[test]
    fn the_round_trip_is_exact(clump in any_clump()) {
        let mut out = Vec::new();
        push_clump(&clump, &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        let back = parse(&text).unwrap();
        prop_assert_eq!(&back, &clump);
        // Equality of numbers does not see the sign of a zero, the text does.
        let mut again = Vec::new();
        push_clump(&back, &mut again).unwrap();
        prop_assert_eq!(String::from_utf8(again).unwrap(), text);
    }

    #[test]
    fn garbage_never_panics(cut in 0..ROD.len(), at in 0..ROD.len(), byte in any::<char>()) {
        let mut text = ROD[..cut].to_owned();
        let _ = parse(&text);
        if ROD.is_char_boundary(at) {
            text = ROD.to_owned();
            text.insert(at, byte);
            let _ = parse(&text);
        }
    }
}
