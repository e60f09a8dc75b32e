//! Surfaces that change: a mesh whose corners moved is the mesh that would be made of them.

use glam::DVec3;
use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::random::Stream;
use proptest::prelude::*;

use super::random::{kind, pose, side};
use super::touches;
use crate::walls::{Mesh, NearMeshes, Plane, Scratch, Shape, Touches, WallError};

/// A square sheet from -1 to 1 of twice `cells` squared triangles.
fn sheet(cells: u32) -> TriangleMesh {
    let mut sheet = TriangleMesh::default();
    for j in 0..=cells {
        for i in 0..=cells {
            let [x, y] = [i, j].map(|k| 2.0 * f64::from(k) / f64::from(cells) - 1.0);
            sheet.vertices.push(DVec3::new(x, y, 0.0));
            if i < cells && j < cells {
                let k = j * (cells + 1) + i;
                let above = k + cells + 1;
                sheet.triangles.push([k, k + 1, above + 1]);
                sheet.triangles.push([k, above + 1, above]);
            }
        }
    }
    sheet
}

fn mesh(triangles: &TriangleMesh, front: bool) -> Mesh {
    Mesh::new(triangles, |x| x, front).unwrap()
}

fn draw(random: &mut Stream) -> DVec3 {
    DVec3::from([0; 3].map(|_| random.uniform_in(-1.0, 1.0)))
}

/// A smooth wave of this height through every place.
fn wave(x: DVec3, height: f64, phase: f64) -> DVec3 {
    let bend = DVec3::new(
        0.3 * (2.0 * x.y).cos(),
        0.2 * (3.0 * x.x).sin(),
        (2.5 * x.x + x.y).sin(),
    );
    x + height * (bend + phase * DVec3::new(0.1, 0.0, x.x * x.y))
}

/// Contacts with distance, normal and the corners of their features; in one order.
type Reported = Vec<(f64, DVec3, Vec<DVec3>)>;

fn reported(mesh: &Mesh, found: &Touches) -> Reported {
    let mut reported: Reported = found
        .iter()
        .map(|touch| (touch.distance, touch.normal, mesh.places_of(touch.feature)))
        .collect();
    reported.sort_by(|a, b| a.0.total_cmp(&b.0));
    reported
}

/// Whether two lists of contacts are the same but for round-off of places of size `scale` (m).
fn same(one: &Reported, other: &Reported, scale: f64) -> bool {
    // A distance is made of sums of products of coordinates; a normal is off by that over the height of a triangle or the distance.
    let near = 1e-12 * scale;
    one.len() == other.len()
        && one.iter().zip(other).all(|(one, other)| {
            (one.0 - other.0).abs() <= near
                && (one.1 - other.1).length() <= 1e3 * near / one.0.abs().min(1.0)
                && one.2 == other.2
        })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// A mesh that was deformed in steps, smoothly or roughly, touches spheres as a mesh made anew of the same triangles does: by
    /// lists that outlive the changes and by fresh queries, to the bit as when every triangle is tested.
    #[test]
    fn a_reshaped_mesh_is_a_mesh_made_anew(
        seed in any::<u64>(),
        cells in 1u32..20,
        front in any::<bool>(),
        height in 0.0..0.4f64,
        rough in prop_oneof![Just(0.0), 0.0..0.2f64],
        reach in 0.05..0.4f64,
        small in any::<bool>(),
    ) {
        let mut random = Stream::new(seed, "reshape", 0);
        let flat = mesh(&sheet(cells), front);
        let mut bent = flat.clone();
        let (mut lists, mut scratch) = (NearMeshes::default(), Scratch::default());
        let (mut listed, mut asked, mut all) = (Touches::new(), Touches::new(), Touches::new());
        let mut spheres: Vec<DVec3> = (0..12).map(|_| draw(&mut random) * 1.1).collect();
        let edge = 2.0 / f64::from(cells);
        for step in 0..8 {
            // Sometimes by less than the skins of the lists.
            let part = if small { 1e-3 * f64::from(step) } else { f64::from(step) / 8.0 };
            let places: Vec<DVec3> = flat
                .corners()
                .iter()
                .map(|&x| wave(x, part * height, part) + draw(&mut random) * (rough * edge * part))
                .collect();
            let before = bent.corners().to_vec();
            let Ok(moved) = bent.reshape(&places) else {
                prop_assert_eq!(bent.corners(), &before[..]);
                continue;
            };
            let farthest = before.iter().zip(&places).map(|(a, b)| a.distance(*b));
            prop_assert_eq!(moved, farthest.fold(0.0, f64::max));
            let fresh = bent.made_anew();
            prop_assert_eq!(bent.bounds(), fresh.bounds());
            let in_one = {
                let mut mesh = flat.clone();
                mesh.place(&places).unwrap();
                mesh
            };
            for (index, centre) in spheres.iter_mut().enumerate() {
                *centre += draw(&mut random) * (0.02 * reach);
                if index % 3 == 0 {
                    // Where contacts are.
                    let of = bent.corners()[(seed as usize + index) % places.len()];
                    *centre = of + draw(&mut random) * reach;
                }
                lists.touches(index, &bent, *centre, reach, &mut scratch, &mut listed);
                bent.touches(*centre, reach, &mut asked);
                bent.touches_of_all(*centre, reach, &mut all);
                prop_assert_eq!(listed.as_slice(), all.as_slice());
                prop_assert_eq!(asked.as_slice(), all.as_slice());
                prop_assert!(all.is_empty() || bent.may_be_near(*centre, reach, &mut scratch));
                // The way to the shape does not matter.
                in_one.touches(*centre, reach, &mut asked);
                prop_assert_eq!(asked.as_slice(), all.as_slice());
                let mut anew = Touches::new();
                fresh.touches(*centre, reach, &mut anew);
                let (reported, expected) = (reported(&bent, &all), reported(&fresh, &anew));
                prop_assert!(same(&reported, &expected, 3.0), "{:?} {:?}", reported, expected);
            }
        }
    }

    /// Other surfaces than meshes: their numbers restore them to the bit, and no point moves farther than the returned bound.
    #[test]
    fn numbers_give_a_shape_back(
        kind in kind(),
        place in pose(3.0, 1.0),
        side in side(),
        shift in prop::array::uniform3(-0.3..0.3f64),
        seed in any::<u64>(),
    ) {
        let shape = kind.build(&place, side).unwrap();
        prop_assert_eq!(&shape.with_numbers(&shape.numbers()).unwrap(), &shape);
        prop_assert_eq!(shape.way_to(&shape).unwrap(), 0.0);
        let mut beside = place;
        beside.translation += DVec3::from(shift);
        let moved = kind.build(&beside, side).unwrap();
        let way = shape.way_to(&moved).unwrap();
        prop_assert!(way <= 2.0 * DVec3::from(shift).length() + 1e-12);
        let mut random = Stream::new(seed, "numbers", 0);
        for _ in 0..50 {
            let centre = draw(&mut random) * 2.0;
            let depth = |shape: &Shape| {
                let found = touches(shape, centre, 10.0);
                found.iter().map(|touch| touch.distance.abs()).fold(f64::INFINITY, f64::min)
            };
            let (before, after) = (depth(&shape), depth(&moved));
            let both = before.is_finite() && after.is_finite();
            prop_assert!(!both || (before - after).abs() <= way + 1e-12, "{before} {after} {way}");
        }
        let mut numbers = shape.numbers();
        numbers.pop();
        prop_assert!(shape.with_numbers(&numbers).is_err());
        numbers.push(f64::NAN);
        prop_assert!(shape.with_numbers(&numbers).is_err());
    }
}

#[test]
fn what_a_mesh_cannot_become_is_refused_by_name_and_changes_nothing() {
    let flat = mesh(&sheet(2), false);
    let mut bent = flat.clone();
    let places = flat.corners().to_vec();
    let middle = places.iter().position(|x| *x == DVec3::ZERO).unwrap();
    let refused = |bent: &mut Mesh, places: &[DVec3]| {
        let error = bent.reshape(places).unwrap_err();
        assert_eq!(*bent, flat);
        error
    };
    let with = |bent: &mut Mesh, place: DVec3| {
        let mut places = places.clone();
        places[middle] = place;
        refused(bent, &places)
    };
    // The middle is pushed onto the rim, and beyond it.
    assert!(matches!(
        with(&mut bent, DVec3::X),
        WallError::LostArea { .. }
    ));
    assert!(matches!(
        with(&mut bent, 1.5 * DVec3::X),
        WallError::TurnedOver { .. }
    ));
    assert!(matches!(
        with(&mut bent, DVec3::NAN),
        WallError::NotFinite { .. }
    ));
    let few = refused(&mut bent, &places[1..]);
    assert_eq!(
        few.to_string(),
        "corners: the mesh has 9, 8 places were given"
    );
    let message = with(&mut bent, 1.5 * DVec3::X).to_string();
    assert!(
        message.starts_with("corners: triangle ") && message.contains("right angle"),
        "{message}"
    );
    bent.reshape(&places).unwrap();
}

/// Edges and corners of a surface that acts on one side decide the sides by the normals around them as they are now.
#[test]
fn a_fold_has_the_sides_of_its_faces() {
    let roof = TriangleMesh {
        vertices: vec![DVec3::Y, DVec3::X, -DVec3::Y, -DVec3::X],
        triangles: vec![[0, 3, 2], [2, 1, 0]],
        ..TriangleMesh::default()
    };
    let mut folded = mesh(&roof, true);
    let mut found = Touches::new();
    for degrees in [60.0f64, 120.0, 160.0] {
        let angle = degrees.to_radians();
        let fall = DVec3::new(angle.cos(), 0.0, -angle.sin());
        let places: Vec<DVec3> = mesh(&roof, true)
            .corners()
            .iter()
            .map(|x| if x.x > 0.0 { fall } else { *x })
            .collect();
        folded.reshape(&places).unwrap();
        // Beside the ridge, in front of both faces, as far as their normals are apart.
        for part in [0.1, 0.5, 0.9] {
            let (sine, cosine) = (part * angle).sin_cos();
            folded.touches(0.1 * DVec3::new(sine, 0.0, cosine), 0.2, &mut found);
            assert_eq!(found.len(), 1);
            let distance = found.as_slice()[0].distance;
            assert!(
                (distance - 0.1).abs() < 1e-15,
                "{degrees} {part}: {distance}"
            );
        }
    }
}

#[test]
fn triangles_are_named_as_the_file_counts_them() {
    let mut triangles = sheet(6);
    triangles.triangles.reverse();
    let flat = mesh(&triangles, false);
    for (index, corners) in triangles.triangles.iter().enumerate() {
        // All corners of one triangle in one place: of its neighbours those that share an edge lose their area too.
        let at = corners.map(|k| triangles.vertices[k as usize]);
        let places: Vec<DVec3> = flat
            .corners()
            .iter()
            .map(|x| {
                if at.contains(x) {
                    (at[0] + at[1] + at[2]) / 3.0
                } else {
                    *x
                }
            })
            .collect();
        let Err(WallError::LostArea { triangle }) = flat.clone().reshape(&places) else {
            panic!("triangle {index} has no area");
        };
        let named = triangles.triangles[triangle as usize];
        assert!(named.iter().filter(|k| corners.contains(k)).count() >= 2);
    }
}

#[test]
fn a_mesh_that_goes_on_for_ever_stays_the_same_at_its_faces() {
    let flat = mesh(&sheet(8), false);
    let endless = flat.continued(&[(0, -1.0, 2.0)], 0.5).unwrap();
    let hills = |x: &DVec3| {
        let along = std::f64::consts::PI * x.x;
        *x + DVec3::Z * (0.2 * along.cos() + 0.1 * x.y)
    };
    let places: Vec<DVec3> = endless.corners().iter().map(hills).collect();
    let mut bent = endless.clone();
    bent.reshape(&places).unwrap();
    // As a mesh that was drawn so.
    let mut drawn = sheet(8);
    drawn.vertices.iter_mut().for_each(|x| *x = hills(x));
    let drawn = mesh(&drawn, false)
        .continued(&[(0, -1.0, 2.0)], 0.5)
        .unwrap();
    let mut random = Stream::new(3, "hills", 0);
    let (mut one, mut other) = (Touches::new(), Touches::new());
    let mut met = 0;
    for _ in 0..2000 {
        let centre = draw(&mut random) * DVec3::new(1.0, 0.9, 0.5);
        bent.touches(centre, 0.2, &mut one);
        drawn.touches(centre, 0.2, &mut other);
        let distances = |found: &Touches| {
            let mut all: Vec<f64> = found.iter().map(|touch| touch.distance).collect();
            all.sort_by(f64::total_cmp);
            all
        };
        let (one, other) = (distances(&one), distances(&other));
        assert_eq!(one.len(), other.len(), "{centre}");
        assert!(one.iter().zip(&other).all(|(a, b)| (a - b).abs() < 1e-14));
        met += one.len();
    }
    assert!(met > 300, "{met}");
    // One end alone, and all along the axis.
    let lifted = |x: &DVec3| {
        *x + if x.x == 1.0 {
            1e-3 * DVec3::Z
        } else {
            DVec3::ZERO
        }
    };
    let along = |x: &DVec3| *x + 0.1 * DVec3::X;
    let ways: [&dyn Fn(&DVec3) -> DVec3; 2] = [&lifted, &along];
    for way in ways {
        let places: Vec<DVec3> = endless.corners().iter().map(way).collect();
        let error = bent.reshape(&places).unwrap_err();
        assert!(
            matches!(error, WallError::OffPeriod { axis: 0, .. }),
            "{error}"
        );
    }
}

#[test]
fn a_surface_becomes_one_of_its_kind_only() {
    let floor = Shape::Plane(Plane::new(DVec3::ZERO, DVec3::Z).unwrap());
    let higher = Shape::Plane(Plane::new(DVec3::new(3.0, 4.0, 0.5), DVec3::Z).unwrap());
    let tilted = Shape::Plane(Plane::new(DVec3::ZERO, DVec3::X + DVec3::Z).unwrap());
    assert_eq!(floor.way_to(&higher).unwrap(), 0.5);
    assert_eq!(floor.way_to(&tilted).unwrap(), f64::INFINITY);
    let sheet = Shape::Mesh(std::sync::Arc::new(mesh(&sheet(1), false)));
    assert_eq!(floor.way_to(&sheet), Err(WallError::OtherShape));
}
