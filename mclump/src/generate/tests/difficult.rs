//! Thin, hollow, several, broken: bodies that work, and inputs that are refused.

use glam::DVec3;

use super::super::shapes::{cuboid, join, mesh};
use super::*;

#[test]
fn a_thin_plate_gets_balls_of_half_its_thickness() {
    let plate = cuboid(DVec3::ZERO, DVec3::new(1.0, 1.0, 0.02));
    for method in [euclidean(), tangent()] {
        let found = run(&plate, &pebbles(method.clone(), 20)).unwrap();
        assert_eq!(found.len(), 20);
        for pebble in &found {
            // Euclidean balls may be smaller by the accuracy of the search, 0.1.
            assert!(
                pebble.radius <= 0.01 + 1e-12 && pebble.radius > 0.009 - 1e-12,
                "{method:?}"
            );
        }
    }
}

#[test]
fn a_needle_works() {
    let needle = cuboid(DVec3::ZERO, DVec3::new(1.0, 1e-3, 1e-3));
    for method in [euclidean(), tangent(), Method::Favier] {
        let found = run(&needle, &pebbles(method, 10)).unwrap();
        for pebble in found {
            assert!(protrusion(&needle, &pebble) < 1e-12);
        }
    }
}

#[test]
fn a_cavity_stays_empty() {
    let hollow = join(
        cuboid(DVec3::splat(-1.0), DVec3::ONE),
        &cuboid(DVec3::splat(-0.5), DVec3::splat(0.5)),
        true,
    );
    for method in [euclidean(), tangent()] {
        for pebble in run(&hollow, &pebbles(method, 60)).unwrap() {
            assert!(protrusion(&hollow, &pebble) < 1e-12, "{pebble:?}");
        }
    }
    let error = run(&hollow, &pebbles(Method::Favier, 5)).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the longest principal axis leaves the body at 0.3000 of its length, so it is no body of revolution without a hole; \
         use another method"
    );
}

#[test]
fn each_of_several_shells_gets_balls() {
    let two = join(
        cuboid(DVec3::ZERO, DVec3::ONE),
        &cuboid(DVec3::new(3.0, 0.0, 0.0), DVec3::new(4.0, 1.0, 1.0)),
        false,
    );
    for method in [euclidean(), tangent()] {
        let found = run(&two, &pebbles(method, 10)).unwrap();
        assert!(found.iter().any(|pebble| pebble.position.x < 1.0));
        assert!(found.iter().any(|pebble| pebble.position.x > 3.0));
        assert!(found.iter().all(|pebble| protrusion(&two, pebble) < 1e-12));
    }
}

#[test]
fn triangles_without_area_do_not_matter() {
    // A cube whose front edge has an extra corner in a triangle without area.
    let mut cube = cuboid(DVec3::ZERO, DVec3::ONE);
    cube.triangles.push([0, 0, 1]);
    let first = run(&cube, &pebbles(euclidean(), 1)).unwrap()[0];
    assert!((first.radius - 0.5).abs() < 1e-12);
}

#[test]
fn broken_surfaces_are_refused() {
    let refused =
        |mesh: &TriangleMesh| run(mesh, &pebbles(euclidean(), 1)).unwrap_err().to_string();
    let cube = cuboid(DVec3::ZERO, DVec3::ONE);
    let mut open = cube.clone();
    open.triangles.pop();
    assert_eq!(
        refused(&open),
        "the surface is not closed: 3 edges do not have as many triangles on one side as on the other, so it has no inside; close \
         the holes, merge equal vertices, or turn triangles so that all corners run counter-clockwise seen from outside"
    );
    let mut inverted = cube.clone();
    for triangle in &mut inverted.triangles {
        triangle.swap(0, 1);
    }
    assert_eq!(
        refused(&inverted),
        "the surface encloses the volume -1e0 m3, which must be above 0: are its triangles turned inside out?"
    );
    let mut infinite = cube.clone();
    infinite.vertices[3].y = f64::NAN;
    assert_eq!(refused(&infinite), "vertex 3 of the surface is not finite");
    assert_eq!(
        refused(&mesh(Vec::new(), Vec::new())),
        "the surface has no triangle with an area"
    );
    let sheet = mesh(
        vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        vec![[0, 1, 2], [0, 2, 1]],
    );
    assert!(refused(&sheet).starts_with("the surface encloses the volume 0e0 m3"));
}

#[test]
fn requests_out_of_range_are_refused() {
    let cube = cuboid(DVec3::ZERO, DVec3::ONE);
    let refused = |change: fn(&mut Request)| {
        let mut request = pebbles(euclidean(), 1);
        change(&mut request);
        run(&cube, &request).unwrap_err().to_string()
    };
    assert_eq!(
        refused(|r| r.stop = Stop::default()),
        "a generator needs an end: give a number of pebbles (--pebbles), a volume error (--fidelity), or both"
    );
    assert_eq!(
        refused(|r| r.stop.pebbles = Some(0)),
        "number of pebbles is 0, expected at least 1"
    );
    assert_eq!(
        refused(|r| r.stop.volume_error = Some(1.0)),
        "volume error is 1, expected a share above 0 and below 1"
    );
    assert_eq!(
        refused(|r| r.smallest_radius = f64::NAN),
        "smallest radius is NaN, expected a finite length of at least 0 m"
    );
    assert_eq!(
        refused(|r| r.protrusion = -0.1),
        "protrusion is -0.1, expected a finite length of at least 0 m"
    );
    assert_eq!(
        refused(|r| r.method = Method::Euclidean(Euclidean {
            overlap: 1.0,
            ..Euclidean::default()
        })),
        "overlap is 1, expected at least 0 and below 1"
    );
    assert_eq!(
        refused(|r| r.method = Method::Tangent(Tangent {
            surface_points: 0,
            ..Tangent::default()
        })),
        "number of surface points is 0, expected at least 1"
    );
    assert_eq!(
        refused(|r| r.smallest_radius = 0.6),
        "no pebble fits: there is no inscribed ball with a radius of 0.6 m or more; allow smaller pebbles (--smallest-radius)"
    );
}

#[test]
fn a_target_out_of_reach_says_how_far_it_got() {
    let cube = cuboid(DVec3::ZERO, DVec3::ONE);
    let request = Request {
        method: euclidean(),
        stop: Stop {
            pebbles: None,
            volume_error: Some(0.05),
        },
        smallest_radius: 0.3,
        ..Request::default()
    };
    // Only the ball with radius 1/2 fits: 1 - pi/6 = 0.4764.
    let error = run(&cube, &request).unwrap_err().to_string();
    assert_eq!(
        error,
        "1 pebbles, all that fit, reach a volume error of 0.4764, not 0.05; allow smaller pebbles (--smallest-radius) \
         or some protrusion (--protrusion), ask for a number of pebbles (--pebbles) instead, or use another method (--generate)"
    );
}
