use std::f64::consts::PI;

use glam::{DQuat, DVec3};

use super::*;
use crate::generate::shapes::{cuboid, join, moved, octahedron, spheroid, torus};

fn turn() -> DQuat {
    DQuat::from_axis_angle(DVec3::new(1.0, -0.4, 0.3).normalize(), 0.9)
}

#[test]
fn a_turned_box_has_its_edges_and_its_closed_forms() {
    let mesh = cuboid(DVec3::ZERO, DVec3::new(3.0, 1.0, 2.0));
    let d = describe(&moved(&mesh, turn(), 1.0, DVec3::new(7.0, 0.0, -3.0))).unwrap();
    let b = d.bounding_box;
    for (found, exact) in [
        (b.longest, 3.0),
        (b.intermediate, 2.0),
        (b.shortest, 1.0),
        (b.elongation(), 2.0 / 3.0),
        (b.flatness(), 0.5),
        (b.compactness(), 1.0 / 3.0),
        (b.krumbein_sphericity(), (2.0f64 / 9.0).cbrt()),
        (b.corey_shape_factor(), 1.0 / 6.0f64.sqrt()),
        // Of an edge a the second moment is V a²/12: the axis is 2 sqrt(5/12) a.
        (
            d.inertia_ellipsoid.longest,
            2.0 * 3.0 * (5.0f64 / 12.0).sqrt(),
        ),
        (d.inertia_ellipsoid.shortest, 2.0 * (5.0f64 / 12.0).sqrt()),
        (d.volume, 6.0),
        (d.area, 22.0),
        (d.equal_volume_diameter, (36.0 / PI).cbrt()),
        (
            d.wadell_sphericity,
            PI.cbrt() * 36.0f64.powf(2.0 / 3.0) / 22.0,
        ),
        (d.convexity, 1.0),
        (d.circumscribed_radius, 14.0f64.sqrt() / 2.0),
    ] {
        assert!(
            (found / exact - 1.0).abs() < 1e-9,
            "{found} instead of {exact}"
        );
    }
    // To the accuracy of the search.
    assert!((d.inscribed_radius / 0.5 - 1.0).abs() < 1e-3);
}

#[test]
fn a_ball_is_round_and_a_cube_is_not() {
    // Normals of facets are off by up to pi/60 = 0.05, of which the scale forgives 0.02: balls at the corners of facets are smaller.
    let ball = describe(&spheroid(2.0, 2.0, 60, 60)).unwrap();
    assert!(
        ball.roundness > 0.98 && ball.roundness <= 1.0,
        "{}",
        ball.roundness
    );
    assert!(ball.wadell_sphericity > 0.99 && ball.wadell_sphericity < 1.0);
    // A ball that touches a face at the distance e from its edge may stand out by 0.02 of 1/2: its radius is e + 0.01, at most
    // 1/2. The distance to the nearest edge of a unit square exceeds e on (1 - 2 e)² of it; so the mean over 1/2 is
    // 2 (0.01 + integral of (1 - 2 e)² de from 0 to 0.49) = 0.02 + (1 - 0.02³)/3.
    let cube = describe(&cuboid(DVec3::ZERO, DVec3::ONE)).unwrap();
    let exact = 0.02 + (1.0 - 0.02f64.powi(3)) / 3.0;
    // 2000 points with a standard deviation of 0.24.
    assert!(
        (cube.roundness - exact).abs() < 4.0 * 0.24 / 2000f64.sqrt(),
        "{}",
        cube.roundness
    );
    assert!((cube.inscribed_radius / cube.circumscribed_radius - 1.0 / 3.0f64.sqrt()).abs() < 1e-3);
}

#[test]
fn the_ellipsoid_of_inertia_of_an_ellipsoid_is_itself() {
    let d = describe(&moved(&spheroid(2.0, 1.0, 80, 80), turn(), 1.0, DVec3::X)).unwrap();
    let e = d.inertia_ellipsoid;
    // The corners lie on the ellipsoid; the volume is too small by about (pi/80)² = 1.5e-3.
    for (found, exact) in [(e.longest, 4.0), (e.intermediate, 2.0), (e.shortest, 2.0)] {
        assert!(
            (found / exact - 1.0).abs() < 1.5e-3,
            "{found} instead of {exact}"
        );
    }
    assert!((d.bounding_box.longest - 4.0).abs() < 2e-3);
    assert!((d.circumscribed_radius - 2.0).abs() < 1e-9);
    assert!((d.inscribed_radius - 1.0).abs() < 2e-3);
    assert!((d.convexity - 1.0).abs() < 1e-9);
}

#[test]
fn convexity_counts_holes_and_gaps() {
    // Two unit cubes 2 apart: the hull is 4 x 1 x 1.
    let two = join(
        cuboid(DVec3::ZERO, DVec3::ONE),
        &cuboid(DVec3::new(3.0, 0.0, 0.0), DVec3::new(4.0, 1.0, 1.0)),
        false,
    );
    assert!((describe(&two).unwrap().convexity - 0.5).abs() < 1e-12);
    // A torus with radii 2 and 1/2: 2 pi² R r² over the hull, disc of radius R and thickness 2 r with a round rim.
    let torus = describe(&torus(2.0, 0.5, 80, 40)).unwrap();
    let (major, minor) = (2.0f64, 0.5f64);
    let hull = PI * major * major * 2.0 * minor
        + PI * PI * minor * minor * major
        + 4.0 / 3.0 * PI * minor.powi(3);
    let exact = 2.0 * PI * PI * major * minor * minor / hull;
    assert!(
        (torus.convexity / exact - 1.0).abs() < 6e-3,
        "{} {exact}",
        torus.convexity
    );
    assert!((torus.inscribed_radius - 0.5).abs() < 4e-3);
    assert!((torus.circumscribed_radius - 2.5).abs() < 1e-9);
}

#[test]
fn an_octahedron_has_its_radii_and_every_number_its_definition() {
    let d = describe(&octahedron()).unwrap();
    assert!((d.inscribed_radius - 1.0 / 3.0f64.sqrt()).abs() < 1e-3);
    assert!((d.circumscribed_radius - 1.0).abs() < 1e-11);
    let text = d.to_string();
    for part in [
        "volume V                  1.33333333e0 m3",
        "smallest box with a face on the convex hull",
        "axes of the ellipsoid of inertia",
        "elongation              1.000000   I/L",
        "convexity                 1.000000   V over the volume of the convex hull",
    ] {
        assert!(text.contains(part), "{part:?} is missing in\n{text}");
    }
}

#[test]
fn an_open_surface_is_refused() {
    let mut open = octahedron();
    open.triangles.pop();
    assert!(matches!(
        describe(&open),
        Err(GenerateError::Open { edges: 3 })
    ));
}
