//! Answers that geometry gives.

use glam::{DQuat, DVec3};

use super::super::shapes::{cuboid, moved, octahedron, spheroid};
use super::*;

#[test]
fn the_first_ball_in_a_cube_has_half_its_edge_and_its_centre() {
    let unit_cube = cuboid(DVec3::splat(-0.5), DVec3::splat(0.5));
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7);
    for (turn, scale, shift) in [
        (DQuat::IDENTITY, 1.0, DVec3::ZERO),
        (DQuat::IDENTITY, 1.0, DVec3::new(0.6029, 0.3621, 1e-6)),
        (turn, 3e-3, DVec3::new(-1.0, 5.0, 0.2)),
    ] {
        let cube = moved(&unit_cube, turn, scale, shift);
        let first = run(&cube, &pebbles(euclidean(), 1)).unwrap()[0];
        // Round-off of the coordinates (5 m in 3 mm: 2e-13), no voxels: half a voxel at 50 per edge would be 0.01.
        assert!((first.radius / scale - 0.5).abs() < 1e-11, "{first:?}");
        assert!(first.position.distance(shift) < 1e-10 * scale, "{first:?}");
    }
}

#[test]
fn the_first_ball_in_an_octahedron_has_its_inradius() {
    let first = run(&octahedron(), &pebbles(euclidean(), 1)).unwrap()[0];
    assert!((first.radius - (1.0f64 / 3.0).sqrt()).abs() < 1e-12);
    assert!(first.position.length() < 1e-11);
}

#[test]
fn no_tangent_ball_leaves_an_octahedron() {
    let mesh = octahedron();
    for pebble in run(&mesh, &pebbles(tangent(), 60)).unwrap() {
        // The faces are x + y + z = 1 and so on: distance (1 - |x| - |y| - |z|)/sqrt(3).
        let p = pebble.position.abs();
        let depth = (1.0 - p.element_sum()) / 3.0f64.sqrt();
        assert!(pebble.radius <= depth + 1e-13, "{pebble:?}");
        // Tangent: each touches a face.
        assert!(pebble.radius > depth - 1e-9, "{pebble:?}");
    }
}

#[test]
fn favier_in_an_ellipsoid_has_the_distance_to_its_surface() {
    // x²/4 + y² + z² = 1. From (x0, 0, 0) the nearest surface point has x = 4/3 x0 and the squared distance 1 - x0²/3, as long as
    // x < 2; else it is the tip.
    let rings = 300;
    let turn = DQuat::from_axis_angle(DVec3::new(0.3, 1.0, 0.2).normalize(), 1.1);
    let shift = DVec3::new(4.0, -2.0, 1.0);
    let mesh = moved(&spheroid(2.0, 1.0, rings, 100), turn, 1.0, shift);
    let found = run(&mesh, &pebbles(Method::Favier, 10)).unwrap();
    let mut expected: Vec<(f64, f64)> = Vec::new();
    for x in [0.2, 0.6, 1.0, 1.4, 1.8f64] {
        let radius = if 4.0 / 3.0 * x < 2.0 {
            (1.0 - x * x / 3.0).sqrt()
        } else {
            2.0 - x
        };
        expected.extend([(x, radius), (-x, radius)]);
    }
    // The corners lie on the ellipsoid, so the triangles lie inside: by at most 1 - cos(pi/100) around and
    // about (pi/300)²/2 * 2²/1 along.
    let tolerance = 4.94e-4 + 2.2e-4;
    for pebble in &found {
        let x = (turn.inverse() * (pebble.position - shift)).x;
        let off_axis = (turn.inverse() * (pebble.position - shift)).with_x(0.0);
        assert!(off_axis.length() < 1e-9);
        let known = expected.iter().position(|known| (known.0 - x).abs() < 1e-9);
        let (_, radius) = expected.swap_remove(known.expect("a known place"));
        assert!(
            pebble.radius <= radius + 1e-12 && pebble.radius > radius - tolerance,
            "at {x}: {} instead of {radius}",
            pebble.radius
        );
    }
    assert!(expected.is_empty());
}

#[test]
fn a_sphere_is_one_pebble() {
    let mesh = spheroid(1.0, 1.0, 60, 60);
    for method in [euclidean(), tangent(), Method::Favier] {
        let request = Request {
            method: method.clone(),
            stop: Stop {
                pebbles: None,
                volume_error: Some(0.03),
            },
            ..Request::default()
        };
        let found = run(&mesh, &request).unwrap();
        assert_eq!(found.len(), 1, "{method:?}");
        // Facets lie up to about 2 (1 - cos(pi/60)) below the sphere.
        assert!(
            found[0].radius < 1.0 && found[0].radius > 1.0 - 2.8e-3,
            "{method:?}: {found:?}"
        );
    }
}

#[test]
fn disjoint_balls_touch_at_most() {
    let method = Method::Euclidean(Euclidean {
        overlap: 0.0,
        largest_radius_ratio: 0.6,
        ..Euclidean::default()
    });
    let cube = cuboid(DVec3::ZERO, DVec3::ONE);
    let found = run(&cube, &pebbles(method, 40)).unwrap();
    assert_eq!(found.len(), 40);
    assert!(
        (found[0].radius - 0.3).abs() < 1e-3,
        "0.6 of 1/2 to the accuracy of the search"
    );
    for (k, a) in found.iter().enumerate() {
        for b in &found[..k] {
            assert!(a.position.distance(b.position) >= a.radius + b.radius - 1e-12);
        }
    }
}

#[test]
fn protrusion_is_added_to_inscribed_radii() {
    let cube = cuboid(DVec3::ZERO, DVec3::ONE);
    for method in [euclidean(), tangent(), Method::Favier] {
        let request = Request {
            protrusion: 0.01,
            ..pebbles(method, 10)
        };
        let found = run(&cube, &request).unwrap();
        for pebble in &found {
            assert!(
                (protrusion(&cube, pebble) - 0.01).abs() < 1e-9 || protrusion(&cube, pebble) < 0.01
            );
        }
    }
}
