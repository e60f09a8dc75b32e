use glam::{DQuat, DVec2, DVec3};
use proptest::prelude::*;

use super::*;
use crate::formats::test_support::{any_number, any_vector};

fn area(mesh: &TriangleMesh) -> f64 {
    let areas = (0..mesh.triangles.len()).map(|k| {
        let [a, b, c] = mesh.corners(k);
        0.5 * (b - a).cross(c - a).length()
    });
    areas.sum()
}

const DOMAIN: (DVec3, DVec3) = (DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0));

fn plane(point: DVec3, normal: DVec3) -> Surface {
    Surface::Plane { point, normal }
}

#[test]
fn a_floor_is_the_face_of_the_domain_and_looks_up() {
    let mesh = plane(DVec3::ZERO, DVec3::Z).triangles(&Placement::default(), DOMAIN, &[]);
    assert!((area(&mesh) - 2.0).abs() < 1e-6, "{}", area(&mesh));
    for k in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(k);
        assert!((b - a).cross(c - a).z > 0.0);
    }
}

#[test]
fn a_lifted_and_turned_plane_is_cut_where_it_stands() {
    // The diagonal section of the box through the y axis: sqrt(1 + 9) x 2.
    let normal = DVec3::new(3.0, 0.0, -1.0).normalize();
    let up = DQuat::from_rotation_arc(DVec3::Z, normal);
    let placement = Placement {
        rotation: up,
        translation: DVec3::new(0.5, 1.0, 1.5),
    };
    let mesh = plane(DVec3::ZERO, DVec3::Z).triangles(&placement, DOMAIN, &[]);
    let expected = 10f64.sqrt() * 2.0;
    assert!((area(&mesh) - expected).abs() < 1e-6, "{}", area(&mesh));
    let lowered = Placement {
        translation: DVec3::new(0.0, 0.0, -0.1),
        ..Placement::default()
    };
    let outside = plane(DVec3::ZERO, DVec3::Z).triangles(&lowered, DOMAIN, &[]);
    assert!(outside.triangles.is_empty());
}

#[test]
fn faces_of_a_box_end_each_other() {
    let names = ["box.-x", "box.+x", "floor", "other.-x", "box.-z"].map(str::to_owned);
    let groups = faces_of_one_box(&names);
    assert_eq!(groups, [vec![1, 4], vec![0, 4], vec![], vec![], vec![0, 1]]);
    // Of a damaged file: one face that is there a great many times ends the other one once.
    let mut names = vec!["box.+z".to_owned()];
    names.extend((0..100_000).map(|_| "box.-z".to_owned()));
    let groups = faces_of_one_box(&names);
    assert_eq!(groups[0], [1]);
    assert!(groups[1..].iter().all(|group| group.len() <= 2));

    let placement = Placement::default();
    let side = plane(DVec3::new(0.25, 0.0, 0.0), DVec3::X);
    let cuts = [side.half_space(&placement).unwrap()];
    let floor = plane(DVec3::ZERO, DVec3::Z).triangles(&placement, DOMAIN, &cuts);
    assert!((area(&floor) - 0.75 * 2.0).abs() < 1e-6);
}

#[test]
fn a_flat_domain_shows_its_walls_as_strips() {
    let domain = (DVec3::ZERO, DVec3::new(3.0, 4.0, 0.0));
    let mesh = plane(DVec3::ZERO, DVec3::Y).triangles(&Placement::default(), domain, &[]);
    // A hundredth of the diagonal of 5 m.
    assert!((area(&mesh) - 3.0 * 0.05).abs() < 1e-6, "{}", area(&mesh));
}

fn turned(profile: Vec<DVec2>, endless: bool) -> Surface {
    Surface::Turned {
        origin: DVec3::new(0.5, 0.0, 1.0),
        direction: DVec3::Y,
        across: [DVec3::Z, DVec3::X],
        profile,
        endless,
    }
}

/// Area of the polygon with 72 corners over that of its circle, and of its outline.
fn polygon() -> (f64, f64) {
    let half = std::f64::consts::PI / 72.0;
    (half.sin() * half.cos() / half, half.sin() / half)
}

#[test]
fn discs_cylinders_cones_and_spheres_have_the_area_of_their_polygons() {
    use std::f64::consts::PI;
    let area = |surface: Surface| area(&surface.triangles(&Placement::default(), DOMAIN, &[]));
    let (round, outline) = polygon();
    let close = |found: f64, expected: f64| {
        assert!(
            (found - expected).abs() < 1e-12 * expected,
            "{found} {expected}"
        );
    };
    let corner = DVec2::new;
    close(
        area(turned(vec![corner(0.0, 1.0), corner(0.5, 1.0)], false)),
        PI * 0.25 * round,
    );
    close(
        area(turned(vec![corner(0.5, 0.0), corner(0.5, 2.0)], false)),
        2.0 * PI * 0.5 * 2.0 * outline,
    );
    // The endless one is as long as the domain is wide.
    close(
        area(turned(vec![corner(0.5, 0.0)], true)),
        2.0 * PI * 0.5 * 2.0 * outline,
    );
    // A cone of 72 flat triangles whose height is the distance of the chord from the tip.
    let half = PI / 72.0;
    let slant = (1f64 + (0.5 * half.cos()).powi(2)).sqrt();
    close(
        area(turned(vec![corner(0.0, 0.0), corner(0.5, 1.0)], false)),
        72.0 * 0.5 * half.sin() * slant,
    );
    let sphere = Surface::Sphere {
        centre: DVec3::ONE,
        radius: 2.0,
    };
    let mesh = sphere.triangles(&Placement::default(), DOMAIN, &[]);
    assert!(
        mesh.vertices
            .iter()
            .all(|x| (x.distance(DVec3::ONE) - 2.0).abs() < 1e-14)
    );
    assert!(mesh.degenerate_triangles().is_empty());
    // Between the sphere and the one inside all its triangles, whose distance from the centre is at least 2 cos^2(pi/72).
    let found = area(sphere);
    assert!(
        found < 16.0 * PI && found > 16.0 * PI * half.cos().powi(4),
        "{found}"
    );
}

#[test]
fn meshes_move_as_they_are() {
    let mesh = TriangleMesh {
        vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        triangles: vec![[0, 1, 2]],
        ..TriangleMesh::default()
    };
    let placement = Placement {
        rotation: DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2),
        translation: DVec3::Z,
    };
    let moved = Surface::Mesh(mesh.clone()).triangles(&placement, DOMAIN, &[]);
    assert_eq!(moved.triangles, mesh.triangles);
    let expected = [DVec3::Z, DVec3::Z + DVec3::Y, DVec3::Z - DVec3::X];
    for (found, expected) in moved.vertices.iter().zip(expected) {
        assert!(found.distance(expected) < 1e-15);
        assert!(placement.to_own(*found).is_finite());
    }
}

proptest! {
    #[test]
    fn text_reads_back_exactly(
        a in any_vector(), b in any_vector(), c in any_vector(), r in any_number(),
        profile in proptest::collection::vec((any_number(), any_number()), 1..5), endless: bool,
    ) {
        let finite = |v: DVec3| v.is_finite();
        prop_assume!(finite(a) && finite(b) && finite(c) && r.is_finite());
        let profile: Vec<DVec2> = profile.into_iter().map(|(r, z)| DVec2::new(r, z)).collect();
        prop_assume!(profile.iter().all(|p| p.is_finite()));
        for surface in [
            Surface::Plane { point: a, normal: b },
            Surface::Sphere { centre: a, radius: r },
            Surface::Turned { origin: a, direction: b, across: [c, a], profile, endless },
            Surface::Mesh(TriangleMesh::default()),
        ] {
            prop_assert_eq!(Surface::from_text(&surface.to_text()), Ok(surface));
        }
    }
}

#[test]
fn bad_text_is_refused_in_words() {
    for (text, message) in [
        ("", "the surface ``, expected plane, sphere, turned or mesh"),
        ("wave 1", "1 before any name"),
        (
            "wave a 1",
            "the surface `wave`, expected plane, sphere, turned or mesh",
        ),
        (
            "plane point 0 0 normal 0 0 1",
            "2 numbers `point` of a plane, expected 3",
        ),
        (
            "sphere centre 0 0 0",
            "0 numbers `radius` of a sphere, expected 1",
        ),
        (
            "turned origin 0 0 0 profile 1 2 3",
            "3 numbers `profile`, expected pairs",
        ),
    ] {
        assert_eq!(Surface::from_text(text).unwrap_err(), message);
    }
}
