//! The displacement bound is never violated, is zero for motions of a shape in itself, and is sharp
//! where it can be.

use super::nearest;
use super::random::{Kind, kind, pose, vector};
use crate::walls::{Pose, Side};
use glam::{DQuat, DVec3};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn no_surface_point_moves_farther(
        kind in kind(),
        place in pose(3.0, 1.0),
        from in pose(2.0, 1.0),
        small in pose(0.05, 0.05),
        large in pose(3.0, 2.0),
        about in vector(1.2),
        reach in 0.05..1.0_f64,
    ) {
        let shape = kind.build(&place, Side::Both).unwrap();
        let about = place.to_global(about);
        for motion in [small, large] {
            let to = from.then(&motion);
            let bound = shape.displacement(&from, &to, about, reach);
            for point in kind.samples(24).0 {
                let point = place.to_global(point);
                if point.distance(about) > reach {
                    continue;
                }
                // How far the old place of the point is from the new surface.
                let seen = to.to_initial(from.to_global(point));
                let moved = nearest(&shape, seen).distance.abs();
                prop_assert!(moved <= bound + 1e-12, "{moved} > {bound}");
            }
        }
    }

    #[test]
    fn motions_of_a_shape_in_itself_are_none(
        kind in kind(),
        place in pose(3.0, 1.0),
        before in pose(3.0, 1.0),
        angle in -10.0..10.0_f64,
        slide in vector(5.0),
        turn in vector(3.0),
        about in vector(1.0),
    ) {
        let axis = place.rotation * DVec3::Z;
        let origin = place.translation;
        let (rotation, shift) = match kind {
            Kind::Plane => (DQuat::from_axis_angle(axis, angle), slide.reject_from_normalized(axis)),
            Kind::Sphere(_) => (DQuat::from_scaled_axis(turn), DVec3::ZERO),
            Kind::Cylinder(_, None) => {
                (DQuat::from_axis_angle(axis, angle), slide.project_onto_normalized(axis))
            }
            _ => (DQuat::from_axis_angle(axis, angle), DVec3::ZERO),
        };
        let shape = kind.build(&place, Side::Inside).unwrap();
        let itself = Pose::about(origin, rotation, shift);
        prop_assert_eq!(shape.displacement(&Pose::IDENTITY, &itself, about, 0.5), 0.0);
        prop_assert_eq!(shape.displacement(&before, &itself.then(&before), about, 0.5), 0.0);
        // It is the motion that is none, not the bound.
        let mut off = itself;
        off.translation += axis.any_orthonormal_vector() * 0.1 + axis * 0.1;
        prop_assert!(shape.displacement(&Pose::IDENTITY, &off, about, 0.5) > 0.09);
    }
}

#[test]
fn shifts_are_bounded_sharply() {
    let shift = DVec3::new(0.3, 0.0, 0.4);
    let to = Pose::about(DVec3::ZERO, DQuat::IDENTITY, shift);
    let cases = [
        (Kind::Plane, 0.4),
        (Kind::Cylinder(1.0, None), 0.3),
        (Kind::Cylinder(1.0, Some([0.0, 1.0])), 0.5),
        (Kind::Sphere(1.0), 0.5),
        (Kind::Disc(1.0), 0.5),
    ];
    for (kind, expected) in cases {
        let shape = kind.build(&Pose::IDENTITY, Side::Inside).unwrap();
        let bound = shape.displacement(&Pose::IDENTITY, &to, DVec3::new(0.2, 0.7, 0.1), 0.5);
        assert!((bound - expected).abs() < 1e-15, "{kind:?}: {bound}");
    }
}

#[test]
fn a_plane_that_tilts_about_a_line_in_it_moves_with_the_distance_from_it() {
    let angle = 1e-3;
    let to = Pose::about(DVec3::ZERO, DQuat::from_rotation_y(angle), DVec3::ZERO);
    let plane = Kind::Plane.build(&Pose::IDENTITY, Side::Inside).unwrap();
    // 2 from the line; points up to 0.5 farther rise by 2.5 sin(angle), to first order in the angle.
    let bound = plane.displacement(&Pose::IDENTITY, &to, DVec3::new(2.0, 0.0, 0.0), 0.5);
    assert!((bound - 2.5 * angle).abs() < 2.5 * angle * angle);
}
