//! Distances and normals of every shape against its definition.

use super::random::{kind, pose, side, vector};
use super::{nearest, touches};
use crate::walls::{Cone, Cylinder, Pose, Shape, Side, SphereShell};
use glam::DVec3;
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn the_nearest_touch_is_at_the_distance_of_the_surface(
        kind in kind(),
        place in pose(3.0, 1.0),
        offset in vector(1.5),
    ) {
        let shape = kind.build(&place, Side::Both).unwrap();
        let centre = place.to_global(offset);
        let (samples, spacing) = kind.samples(120);
        let sampled = samples.iter().map(|p| p.distance(offset)).fold(f64::INFINITY, f64::min);
        let distance = nearest(&shape, centre).distance.abs();
        // No sample is nearer than the surface; one is within the spacing of the nearest point.
        prop_assert!(distance <= sampled + 1e-12, "{distance} > {sampled}");
        prop_assert!(sampled <= distance + spacing, "{sampled} > {distance} + {spacing}");
    }

    #[test]
    fn the_nearest_touch_is_the_same_on_one_sided_walls(
        kind in kind(),
        offset in vector(1.5),
        side in side(),
    ) {
        let both = kind.build(&Pose::IDENTITY, Side::Both).unwrap();
        let one = kind.build(&Pose::IDENTITY, side).unwrap();
        let (a, b) = (nearest(&both, offset), nearest(&one, offset));
        prop_assert_eq!(a.distance.abs(), b.distance.abs());
    }

    #[test]
    fn inside_and_outside_are_opposite(kind in kind(), offset in vector(1.5)) {
        let inside = nearest(&kind.build(&Pose::IDENTITY, Side::Inside).unwrap(), offset);
        let outside = nearest(&kind.build(&Pose::IDENTITY, Side::Outside).unwrap(), offset);
        let two_faced = inside.feature == 0 && outside.feature == 0
            && kind.profile().is_none_or(|p| p.len() == 2)
            && !matches!(kind, super::random::Kind::Plane | super::random::Kind::Disc(_));
        if two_faced {
            prop_assert_eq!(inside.distance, -outside.distance);
            prop_assert_eq!(inside.normal, -outside.normal);
            prop_assert_eq!(inside.curvature[1], -outside.curvature[1]);
        }
    }

    /// Moving along the normal of a touch moves away from its feature at unit rate, and moving across
    /// it doesn't change the distance to first order.
    #[test]
    fn the_normal_is_the_gradient_of_the_distance(
        kind in kind(),
        side in side(),
        place in pose(3.0, 1.0),
        offset in vector(1.5),
        across in vector(1.0),
    ) {
        let shape = kind.build(&place, side).unwrap();
        let centre = place.to_global(offset);
        let h = 1e-6;
        for touch in touches(&shape, centre, 0.5) {
            prop_assert!((touch.normal.length() - 1.0).abs() < 1e-14);
            let t = across.reject_from_normalized(touch.normal);
            for (step, expected) in [(touch.normal, 1.0), (t, 0.0)] {
                let moved = touches(&shape, centre + step * h, 0.6);
                // At borders of features the touch may have become one of another feature.
                let Some(moved) = moved.iter().find(|m| m.feature == touch.feature) else {
                    continue;
                };
                // Second order: h^2 / 2 over the radius of curvature of the distance, the distance
                // from an edge or from the axis.
                let radius = touch.distance.abs().min(offset.truncate().length()).min(offset.length());
                let tolerance = 2.0 * h * h / radius.max(1e-3) + 1e-14;
                let change = moved.distance - touch.distance;
                prop_assert!(
                    radius < 1e-3 || (change - expected * h).abs() < tolerance,
                    "{change} instead of {expected} * {h}"
                );
            }
        }
    }

    /// The normal at a place h away is the normal here and its turning times h, to second order in h over the distance from an edge,
    /// tip or axis, r: h^2/r^2.
    #[test]
    fn the_normal_turns_as_the_touch_says(
        kind in kind(),
        side in side(),
        place in pose(3.0, 1.0),
        offset in vector(1.5),
        across in vector(1.0),
    ) {
        let shape = kind.build(&place, side).unwrap();
        let centre = place.to_global(offset);
        let h = 1e-6;
        for touch in touches(&shape, centre, 0.5) {
            let radius = touch.distance.abs().min(offset.truncate().length()).min(offset.length());
            if radius < 1e-2 {
                continue;
            }
            let moved = touches(&shape, centre + across * h, 0.6);
            let Some(moved) = moved.iter().find(|m| m.feature == touch.feature) else {
                continue;
            };
            let expected = touch.turning.of(touch.normal, across * h);
            let change = moved.normal - touch.normal;
            let tolerance = 3.0 * (h / radius) * (h / radius) * across.length_squared() + 1e-14;
            prop_assert!((change - expected).length() < tolerance, "{change} instead of {expected}");
        }
    }

    #[test]
    fn touches_do_not_depend_on_the_frame(
        kind in kind(),
        side in side(),
        place in pose(3.0, 2.0),
        offset in vector(1.5),
        reach in 0.0..1.0_f64,
    ) {
        // Directions away from the axis are ill-conditioned near it, and at a border of two features
        // round-off decides; neither is the concern here.
        prop_assume!(offset.truncate().length() > 1e-3);
        let here = touches(&kind.build(&Pose::IDENTITY, side).unwrap(), offset, reach);
        let there = touches(&kind.build(&place, side).unwrap(), place.to_global(offset), reach);
        prop_assert_eq!(here.len(), there.len());
        for (a, b) in here.iter().zip(&there) {
            prop_assert_eq!(a.feature, b.feature);
            prop_assert!((a.distance - b.distance).abs() < 1e-13);
            prop_assert!((place.rotation * a.normal - b.normal).length() < 1e-11);
            prop_assert!((a.curvature[1] - b.curvature[1]).abs() <= 1e-9 * a.curvature[1].abs());
        }
    }

    #[test]
    fn bounds_hold_the_surface_and_touch_it(kind in kind(), place in pose(3.0, 1.0)) {
        let shape = kind.build(&place, Side::Inside).unwrap();
        let (min, max) = shape.bounds();
        let (samples, spacing) = kind.samples(60);
        let mut low = DVec3::INFINITY;
        let mut high = DVec3::NEG_INFINITY;
        for point in samples {
            let point = place.to_global(point);
            prop_assert!(point.cmpge(min - 1e-12).all() && point.cmple(max + 1e-12).all());
            low = low.min(point);
            high = high.max(point);
        }
        for axis in 0..3 {
            prop_assert!(min[axis].is_infinite() || low[axis] <= min[axis] + spacing);
            prop_assert!(max[axis].is_infinite() || high[axis] >= max[axis] - spacing);
        }
    }
}

#[test]
fn bounds_of_unbounded_walls_along_the_axes() {
    let plane = super::random::Kind::Plane
        .build(&Pose::IDENTITY, Side::Inside)
        .unwrap();
    let (min, max) = plane.bounds();
    assert_eq!((min.z, max.z), (0.0, 0.0));
    assert_eq!((min.x, max.y), (f64::NEG_INFINITY, f64::INFINITY));
    let origin = DVec3::new(1.0, 2.0, 3.0);
    let pipe = Cylinder::new(DVec3::Y * 5.0, origin, 0.5, None, Side::Inside).unwrap();
    let (min, max) = Shape::Cylinder(pipe).bounds();
    assert_eq!(min, DVec3::new(0.5, f64::NEG_INFINITY, 2.5));
    assert_eq!(max, DVec3::new(1.5, f64::INFINITY, 3.5));
}

#[test]
fn curvatures_are_those_of_the_shapes() {
    let curvature = |shape: Shape, centre: DVec3| nearest(&shape, centre).curvature;
    let at = DVec3::new(0.3, 0.0, 0.0);
    let pipe =
        |side| Shape::Cylinder(Cylinder::new(DVec3::Z, DVec3::ZERO, 0.4, None, side).unwrap());
    assert_eq!(curvature(pipe(Side::Inside), at), [0.0, -1.0 / 0.4]);
    assert_eq!(curvature(pipe(Side::Outside), at * 2.0), [0.0, 1.0 / 0.4]);
    assert_eq!(curvature(pipe(Side::Both), at * 2.0), [0.0, 1.0 / 0.4]);
    let ball = |side| Shape::Sphere(SphereShell::new(DVec3::ZERO, 0.4, side).unwrap());
    assert_eq!(curvature(ball(Side::Inside), at), [-1.0 / 0.4; 2]);
    assert_eq!(curvature(ball(Side::Outside), at * 2.0), [1.0 / 0.4; 2]);
    // Cone of 45 degrees: at the foot, at distance r from the axis, the curvature is cos(45)/r. From
    // (0.5, 0.3) the foot is the middle (0.4, 0.4) of (0.5, 0.3) and its mirror image.
    let cone = Cone::new(DVec3::Z, DVec3::ZERO, [0.0, 1.0], [0.0, 1.0], Side::Outside).unwrap();
    let [along, around] = curvature(Shape::Cone(cone), DVec3::new(0.5, 0.0, 0.3));
    assert_eq!(along, 0.0);
    assert!((around - 0.5_f64.sqrt() / 0.4).abs() < 1e-14);
}
