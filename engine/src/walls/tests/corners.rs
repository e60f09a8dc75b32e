//! Contacts at corners, rims, tips, on axes, and behind one-sided surfaces.

use super::random::Kind;
use super::{nearest, touches};
use crate::walls::{Cone, Cylinder, Disc, Pose, Revolution, Shape, Side, SphereShell, WallError};
use glam::DVec3;

const VESSEL: [[f64; 2]; 4] = [[0.0, 0.0], [0.2, 0.0], [0.3, 0.3], [0.3, 0.6]];
/// A ring of square section.
const RING: [[f64; 2]; 5] = [[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 0.0]];

fn revolution(profile: &[[f64; 2]], side: Side) -> Shape {
    Shape::Revolution(Revolution::new(DVec3::Z, DVec3::ZERO, profile, side).unwrap())
}

fn at(r: f64, z: f64) -> DVec3 {
    DVec3::new(0.0, r, z)
}

fn features(shape: &Shape, centre: DVec3, reach: f64) -> Vec<u32> {
    touches(shape, centre, reach)
        .iter()
        .map(|t| t.feature)
        .collect()
}

fn assert_close(a: DVec3, b: DVec3) {
    assert!((a - b).length() < 1e-14, "{a} != {b}");
}

#[test]
fn a_concave_corner_gives_one_touch_per_face() {
    let vessel = revolution(&VESSEL, Side::Inside);
    // 0.01 above the floor, 0.01 from the cone of slope 3.
    let slope = DVec3::new(0.0, 0.1, 0.3).normalize();
    let normal = DVec3::new(0.0, -slope.z, slope.y);
    let r = 0.2 + (0.01 * slope.y - 0.01) / slope.z;
    let found = touches(&vessel, at(r, 0.01), 0.02);
    assert_eq!(found.len(), 2);
    assert_eq!((found[0].feature, found[1].feature), (0, 1));
    assert_close(found[0].normal, DVec3::Z);
    assert_close(found[1].normal, normal);
    for touch in found {
        assert!((touch.distance - 0.01).abs() < 1e-15);
    }
}

#[test]
fn the_inside_does_not_depend_on_the_direction_of_listing() {
    let mut reversed = VESSEL;
    reversed.reverse();
    let (vessel, other) = (
        revolution(&VESSEL, Side::Inside),
        revolution(&reversed, Side::Inside),
    );
    for centre in [at(0.1, 0.05), at(0.25, 0.3), at(0.28, 0.5), at(0.1, -0.01)] {
        let (a, b) = (nearest(&vessel, centre), nearest(&other, centre));
        assert!((a.distance - b.distance).abs() < 1e-15);
        assert_close(a.normal, b.normal);
    }
    assert!(nearest(&vessel, at(0.1, 0.05)).distance > 0.0);
    assert!(nearest(&vessel, at(0.1, -0.05)).distance < 0.0);
    // A roof: its inside is below it.
    let roof = revolution(&[[0.0, 1.0], [0.5, 1.0], [0.5, 0.0]], Side::Inside);
    assert_close(nearest(&roof, at(0.1, 0.9)).normal, -DVec3::Z);
    // A flat annulus encloses nothing with the axis: left of its direction.
    let annulus = revolution(&[[0.1, 0.0], [0.5, 0.0]], Side::Inside);
    assert_close(nearest(&annulus, at(0.3, 0.1)).normal, DVec3::Z);
    let annulus = revolution(&[[0.5, 0.0], [0.1, 0.0]], Side::Inside);
    assert_close(nearest(&annulus, at(0.3, -0.1)).normal, -DVec3::Z);
}

#[test]
fn a_convex_corner_gives_one_touch_whose_direction_is_continuous() {
    let ring = revolution(&RING, Side::Outside);
    // Along a line that passes the corner (2, 1) at distance 0.1, from above the top to beside the
    // mantle.
    let corner = at(2.0, 1.0);
    let closest = corner + DVec3::new(0.0, 0.1, 0.1) * 0.5_f64.sqrt();
    let along = DVec3::new(0.0, 1.0, -1.0) * 0.5_f64.sqrt();
    let steps = 1000;
    let step = 0.4 / f64::from(steps);
    let mut before: Option<(DVec3, u32)> = None;
    let mut seen = Vec::new();
    for i in 0..=steps {
        let centre = closest + along * (-0.2 + step * f64::from(i));
        let found = touches(&ring, centre, 0.5);
        assert_eq!(found.len(), 1, "at {centre}");
        let (normal, feature) = (found[0].normal, found[0].feature);
        assert!(found[0].distance > 0.0);
        if seen.last() != Some(&feature) {
            seen.push(feature);
        }
        if let Some((last, last_feature)) = before {
            // The direction from the corner turns by at most step / distance.
            assert!((normal - last).length() <= step / 0.1 * (1.0 + 1e-9));
            assert!(feature == last_feature || ring.adjacent(feature, last_feature));
        }
        before = Some((normal, feature));
    }
    // Top, corner, mantle: the pieces are 0..4, the corners 4..8.
    assert_eq!(seen, [2, 6, 1]);
}

#[test]
fn the_far_side_of_a_thin_lip_does_not_count() {
    let lip = [[1.0, 0.0], [1.01, 0.0], [1.01, 1.0], [1.0, 1.0], [1.0, 0.0]];
    let lip = revolution(&lip, Side::Outside);
    // A sphere of radius 0.05 touches from inside; the outer face is 0.055 behind it.
    assert_eq!(features(&lip, at(0.955, 0.5), 0.08), [3]);
    // Within the lip, the nearer face pushes, and it alone.
    let inside = touches(&lip, at(1.003, 0.5), 0.08);
    assert_eq!(inside.len(), 1);
    assert_close(inside[0].normal, -DVec3::Y);
    assert!((inside[0].distance + 0.003).abs() < 1e-15);
}

#[test]
fn beyond_one_face_of_a_corner_the_other_still_counts() {
    // The mantle leans inwards, over the floor.
    let flask = revolution(&[[0.0, 0.0], [0.3, 0.0], [0.2, 0.3]], Side::Inside);
    let found = touches(&flask, at(0.291, 0.03), 0.05);
    assert_eq!(found.len(), 2);
    assert_eq!((found[0].feature, found[1].feature), (0, 1));
    assert_eq!(found[0].distance, 0.03);
    // 0.001 beyond the mantle, measured horizontally; the mantle has the slope 3.
    assert!((found[1].distance + 0.001 * 0.9_f64.sqrt()).abs() < 1e-15);
    assert!(found[1].normal.y < 0.0);
}

#[test]
fn beyond_both_faces_a_corner_pushes_back() {
    let cup = revolution(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], Side::Inside);
    let found = touches(&cup, at(1.0 + 3.0 / 1024.0, -4.0 / 1024.0), 0.05);
    assert_eq!(found.len(), 1);
    assert!((found[0].distance + 5.0 / 1024.0).abs() < 1e-15);
    assert_close(found[0].normal, DVec3::new(0.0, -0.6, 0.8));
    // Deeper than the reach it is on the other side.
    assert_eq!(features(&cup, at(1.04, 0.5), 0.05), [1]);
    assert!(touches(&cup, at(1.06, 0.5), 0.05).is_empty());
}

#[test]
fn a_disc_has_two_faces_and_a_rim() {
    let disc = Shape::Disc(Disc::new(DVec3::Z * 3.0, DVec3::ZERO, 1.0).unwrap());
    let front = touches(&disc, at(0.5, 0.1), 0.2);
    let back = touches(&disc, at(0.5, -0.1), 0.2);
    let rim = touches(&disc, at(1.03, -0.04), 0.2);
    assert_eq!([front.len(), back.len(), rim.len()], [1; 3]);
    assert_eq!(
        [front[0].feature, rim[0].feature, back[0].feature],
        [0, 2, 3]
    );
    assert_close(front[0].normal, DVec3::Z);
    assert_close(back[0].normal, -DVec3::Z);
    assert_close(rim[0].normal, DVec3::new(0.0, 0.6, -0.8));
    assert!((rim[0].distance - 0.05).abs() < 1e-15);
    assert!(disc.adjacent(0, 2) && disc.adjacent(2, 0) && disc.adjacent(2, 3));
    assert!(!disc.adjacent(0, 3) && !disc.adjacent(0, 0) && !disc.adjacent(0, 9));
}

/// The two faces of a thin shell are two features, none a way to the other: what pressed from one side remembers nothing on the other.
#[test]
fn two_sided_shells_have_two_faces() {
    let sphere = SphereShell::new(DVec3::ZERO, 1.0, Side::Both).unwrap();
    let pipe = Cylinder::new(DVec3::Z, DVec3::ZERO, 1.0, None, Side::Both).unwrap();
    for shape in [Shape::Sphere(sphere), Shape::Cylinder(pipe)] {
        assert_eq!(features(&shape, at(0.9, 0.0), 0.2), [0]);
        assert_eq!(features(&shape, at(1.1, 0.0), 0.2), [1]);
        assert!(!shape.adjacent(0, 1) && !shape.adjacent(1, 0));
    }
}

#[test]
fn adjacency_goes_round_a_ring_and_stops_at_ends() {
    let ring = revolution(&RING, Side::Outside);
    assert!(ring.adjacent(3, 0) && ring.adjacent(0, 3));
    assert!(
        ring.adjacent(3, 4) && ring.adjacent(4, 0),
        "faces 3 and 0 meet in corner 4"
    );
    assert!(!ring.adjacent(0, 2) && !ring.adjacent(4, 5));
    let vessel = revolution(&VESSEL, Side::Inside);
    assert!(vessel.adjacent(0, 1) && vessel.adjacent(1, 5) && vessel.adjacent(2, 6));
    assert!(!vessel.adjacent(2, 0) && !vessel.adjacent(2, 3));
    // Without backs there is no feature 7.
    assert!(!vessel.adjacent(7, 0));
}

/// Three pieces are enough to close a profile: its first corner is a corner like the others, and no end.
#[test]
fn a_ring_of_triangular_section_is_closed() {
    let corners = [[1.0, 0.0], [2.0, 0.0], [1.5, 1.0]];
    let ring = revolution(
        &[corners[0], corners[1], corners[2], corners[0]],
        Side::Outside,
    );
    assert!(ring.adjacent(2, 0) && ring.adjacent(0, 2));
    assert!(
        ring.adjacent(2, 3) && ring.adjacent(3, 0),
        "faces 2 and 0 meet in corner 3"
    );
    for (k, [r, z]) in (0u32..).zip(corners) {
        let away = at(r, z) - at(1.5, 1.0 / 3.0);
        let centre = at(r, z) + 0.1 * away.normalize();
        assert_eq!(features(&ring, centre, 0.2), [3 + k]);
    }
}

#[test]
fn bounded_and_endless_cylinders_agree_between_the_rims() {
    for side in [Side::Inside, Side::Outside] {
        let cylinder = |along| {
            Shape::Cylinder(Cylinder::new(DVec3::X, at(0.1, 0.2), 0.4, along, side).unwrap())
        };
        let (endless, bounded) = (cylinder(None), cylinder(Some([-1.0, 2.0])));
        for centre in [
            DVec3::ZERO,
            DVec3::new(1.0, 0.3, 0.4),
            DVec3::new(-0.9, 0.7, 0.7),
        ] {
            let (a, b) = (nearest(&endless, centre), nearest(&bounded, centre));
            assert!((a.distance - b.distance).abs() < 1e-15);
            assert_close(a.normal, b.normal);
            assert!((a.curvature[1] - b.curvature[1]).abs() < 1e-14);
            assert_eq!(a.feature, b.feature);
        }
        // 0.03 beyond the end and 0.04 from the mantle.
        let rim = nearest(&bounded, DVec3::new(2.03, 0.1 + 0.36, 0.2));
        assert_eq!(rim.feature, 2);
        assert_close(rim.normal, DVec3::new(0.6, -0.8, 0.0));
    }
}

#[test]
fn the_tip_of_a_cone_pushes_towards_the_side_of_the_particles() {
    let cone =
        |side| Shape::Cone(Cone::new(DVec3::Z, DVec3::ZERO, [0.0, 1.0], [0.0, 1.0], side).unwrap());
    let inside = nearest(&cone(Side::Inside), at(0.0, 0.1));
    assert!((inside.distance - 0.1 * 0.5_f64.sqrt()).abs() < 1e-15);
    let outside = nearest(&cone(Side::Outside), at(0.0, -0.1));
    assert_eq!(outside.distance, 0.1);
    assert_close(outside.normal, -DVec3::Z);
    let beyond = nearest(&cone(Side::Inside), at(0.0, -0.1));
    assert_eq!(beyond.distance, -0.1);
    assert_close(beyond.normal, DVec3::Z);
}

#[test]
fn centres_on_axes_surfaces_edges_and_tips_give_one_finite_touch() {
    let kinds = [
        (Kind::Plane, vec![at(0.0, 0.0), at(0.3, 0.0)]),
        (
            Kind::Disc(1.0),
            vec![at(0.0, 0.0), at(0.5, 0.0), at(1.0, 0.0), at(0.0, 0.1)],
        ),
        (
            Kind::Sphere(1.0),
            vec![at(0.0, 0.0), at(1.0, 0.0), at(0.0, -1.0)],
        ),
        (Kind::Cylinder(1.0, None), vec![at(0.0, 0.3), at(1.0, 0.2)]),
        (
            Kind::Cylinder(1.0, Some([0.0, 1.0])),
            vec![
                at(0.0, 0.3),
                at(1.0, 0.2),
                at(1.0, 0.0),
                at(1.0, 1.0),
                at(0.0, -0.5),
            ],
        ),
        (
            Kind::Cone([0.0, 1.0], [0.0, 1.0]),
            vec![
                at(0.0, 0.0),
                at(0.0, 0.5),
                at(0.0, -0.5),
                at(0.5, 0.5),
                at(1.0, 1.0),
            ],
        ),
        (
            Kind::Revolution(RING.to_vec()),
            vec![at(1.0, 0.0), at(2.0, 1.0), at(0.0, 0.5)],
        ),
    ];
    for (kind, centres) in kinds {
        for side in [Side::Inside, Side::Outside, Side::Both] {
            let shape = kind.build(&Pose::IDENTITY, side).unwrap();
            for &centre in &centres {
                let touch = nearest(&shape, centre);
                assert!(touch.distance.is_finite());
                assert!(
                    (touch.normal.length() - 1.0).abs() < 1e-14,
                    "{kind:?} {centre}"
                );
                assert!(touch.curvature.iter().all(|c| c.is_finite()));
            }
        }
    }
    // At the very tip of a convex corner its two faces are one place.
    assert_eq!(
        touches(&revolution(&RING, Side::Outside), at(2.0, 1.0), 0.1).len(),
        1
    );
}

/// In a corner of a two-sided shell its two faces are one place: a centre that lies in it is pushed once.
#[test]
fn a_centre_in_a_corner_of_a_two_sided_shell_is_pushed_once() {
    let found = touches(&revolution(&VESSEL, Side::Both), at(0.2, 0.0), 0.05);
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].distance, 0.0);
}

#[test]
fn a_straight_corner_is_no_corner() {
    let straight = revolution(
        &[[0.0, 0.0], [0.1, 0.0], [0.3, 0.0], [0.3, 0.5]],
        Side::Inside,
    );
    for i in 0..400 {
        let r = 0.09 + 0.02 * f64::from(i) / 400.0;
        let found = touches(&straight, at(r, 0.01), 0.02);
        assert_eq!(found.len(), 1);
        assert_close(found[0].normal, DVec3::Z);
    }
    assert_eq!(touches(&straight, at(0.1, 0.01), 0.02).len(), 1);
}

#[test]
fn round_off_opens_no_gap_between_pieces_in_line() {
    for i in 0..200 {
        // Many slopes, so that round-off falls every way.
        let (r, z) = (0.2 + 0.001 * f64::from(i), 0.3);
        let end = [0.1 + (r - 0.1) * 1.7, z * 1.7];
        let slope = revolution(&[[0.1, 0.0], [r, z], end], Side::Inside);
        let direction = DVec3::new(0.0, r - 0.1, z).normalize();
        let normal = DVec3::new(0.0, -direction.z, direction.y);
        for height in [0.01, 0.003, -0.003, -0.01] {
            for ulps in -10..=10 {
                let offset = direction * (f64::from(ulps) * 0.2 * f64::EPSILON);
                let found = touches(&slope, at(r, z) + normal * height + offset, 0.02);
                assert_eq!(found.len(), 1);
                assert!(found[0].feature < 2);
                assert!((found[0].distance - height).abs() < 1e-15);
                assert_close(found[0].normal, normal);
            }
        }
    }
}

#[test]
fn bad_descriptions_are_refused() {
    let profile = |p: &[[f64; 2]]| {
        Revolution::new(DVec3::Z, DVec3::ZERO, p, Side::Inside).expect_err("must be refused")
    };
    assert_eq!(profile(&[[0.1, 0.0]]), WallError::TooFewPoints { count: 1 });
    assert_eq!(
        profile(&[[0.1, 0.0], [0.2, 0.0], [0.2, 0.0]]),
        WallError::RepeatedPoint { index: 1 }
    );
    assert_eq!(
        profile(&[[0.0, 0.0], [0.0, 1.0], [1.0, 1.0]]),
        WallError::PieceOnAxis { index: 0 }
    );
    let bow = [[0.1, 0.0], [1.0, 1.0], [1.0, 0.0], [0.1, 1.0]];
    assert_eq!(
        profile(&bow),
        WallError::Crossing {
            first: 0,
            second: 2
        }
    );
    let folded = [[0.1, 0.0], [1.0, 0.0], [0.5, 0.0]];
    assert_eq!(
        profile(&folded),
        WallError::Crossing {
            first: 0,
            second: 1
        }
    );
    assert!(matches!(
        profile(&[[-0.1, 0.0], [1.0, 0.0]]),
        WallError::Negative { .. }
    ));
    assert!(matches!(
        profile(&[[0.1, f64::NAN], [1.0, 0.0]]),
        WallError::NotFinite { .. }
    ));

    let (z, o, inside) = (DVec3::Z, DVec3::ZERO, Side::Inside);
    assert!(matches!(
        Disc::new(o, o, 1.0),
        Err(WallError::NoDirection { key: "axis", .. })
    ));
    assert!(matches!(
        Disc::new(z, o, 0.0),
        Err(WallError::NotPositive { key: "radius", .. })
    ));
    assert!(SphereShell::new(DVec3::NAN, 1.0, inside).is_err());
    assert!(SphereShell::new(o, f64::INFINITY, inside).is_err());
    assert!(Cylinder::new(z, o, 1.0, Some([1.0, 0.0]), inside).is_err());
    assert!(Cone::new(z, o, [0.0, 1.0], [0.0, 0.0], inside).is_err());
    assert!(Cone::new(z, o, [0.0, 1.0], [-0.1, 0.5], inside).is_err());
    // Directions of any length do.
    assert!(Disc::new(z * 1e-200, o, 1.0).is_ok() && Disc::new(z * 1e200, o, 1.0).is_ok());
}
