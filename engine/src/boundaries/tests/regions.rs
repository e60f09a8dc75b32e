//! Regions: signs, bounds, samples, spheres inside.

use std::f64::consts::PI;

use glam::DVec3;
use mercury_common::random::Stream;
use proptest::prelude::*;

use super::super::Region;

fn vector() -> impl Strategy<Value = DVec3> {
    [-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64].prop_map(DVec3::from)
}

fn direction() -> impl Strategy<Value = DVec3> {
    prop_oneof![
        Just(DVec3::X),
        Just(-DVec3::Z),
        vector()
            .prop_filter("too short", |v| v.length() > 0.1)
            .prop_map(DVec3::normalize),
    ]
}

fn single() -> impl Strategy<Value = Region> {
    let size = 0.1..1.5f64;
    prop_oneof![
        (vector(), [0.1..1.5f64, 0.1..1.5f64, 0.1..1.5f64]).prop_map(|(min, size)| Region::Box {
            min,
            max: min + DVec3::from(size)
        }),
        (
            direction(),
            vector(),
            size.clone(),
            -1.0..0.0f64,
            0.1..1.0f64
        )
            .prop_map(|(axis, origin, radius, low, high)| Region::Cylinder {
                axis,
                origin,
                radius,
                along: [low, high]
            }),
        (vector(), size.clone()).prop_map(|(origin, radius)| Region::Sphere { origin, radius }),
        (
            direction(),
            vector(),
            -1.0..0.0f64,
            0.1..1.0f64,
            0.0..1.0f64,
            size
        )
            .prop_map(|(axis, origin, low, high, a, b)| Region::Cone {
                axis,
                origin,
                along: [low, high],
                radii: [a, b]
            }),
        (vector(), direction()).prop_map(|(point, normal)| Region::HalfSpace { point, normal }),
    ]
}

fn any_region() -> impl Strategy<Value = Region> {
    single().prop_recursive(2, 8, 3, |part| {
        let parts = || prop::collection::vec(part.clone(), 1..4);
        prop_oneof![
            parts().prop_map(Region::Union),
            parts().prop_map(Region::Intersection),
            parts().prop_map(Region::Difference),
        ]
    })
}

/// Whether a point is inside, from the definition of each shape.
fn is_inside(region: &Region, p: DVec3) -> bool {
    let cylindrical = |axis: DVec3, origin: DVec3| {
        let height = (p - origin).dot(axis);
        ((p - origin).cross(axis).length(), height)
    };
    match region {
        Region::Box { min, max } => p.cmpge(*min).all() && p.cmple(*max).all(),
        Region::Cylinder {
            axis,
            origin,
            radius,
            along,
        } => {
            let (rho, height) = cylindrical(*axis, *origin);
            rho <= *radius && along[0] <= height && height <= along[1]
        }
        Region::Sphere { origin, radius } => p.distance(*origin) <= *radius,
        Region::Cone {
            axis,
            origin,
            along,
            radii,
        } => {
            let (rho, height) = cylindrical(*axis, *origin);
            let share = (height - along[0]) / (along[1] - along[0]);
            (0.0..=1.0).contains(&share) && rho <= radii[0] + share * (radii[1] - radii[0])
        }
        Region::HalfSpace { point, normal } => (p - *point).dot(*normal) >= 0.0,
        Region::Mesh(_) => unreachable!("none is drawn"),
        Region::Union(parts) => parts.iter().any(|part| is_inside(part, p)),
        Region::Intersection(parts) => parts.iter().all(|part| is_inside(part, p)),
        Region::Difference(parts) => {
            is_inside(&parts[0], p) && !parts[1..].iter().any(|part| is_inside(part, p))
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn the_sign_is_exact_and_the_distance_a_lower_bound(
        region in any_region(), point in vector(), steps in prop::collection::vec((vector(), 0.0..1.0f64), 60)
    ) {
        let distance = region.signed_distance(point);
        prop_assume!(distance.abs() > 1e-9);
        prop_assert_eq!(distance < 0.0, is_inside(&region, point));
        // No particle within the distance is on the other side.
        for (step, share) in steps {
            let near = point + step.normalize_or_zero() * (distance.abs() * share * (1.0 - 1e-9));
            prop_assert_eq!(is_inside(&region, near), distance < 0.0, "{} of {}", near, distance);
        }
    }

    #[test]
    fn single_shapes_know_the_exact_distance(region in single(), point in vector()) {
        let distance = region.signed_distance(point);
        prop_assume!(distance.abs() > 1e-6);
        // Walking down the distance field ends on the surface after exactly that length: the field has slope 1.
        let h = 1e-7;
        let slope = DVec3::AXES.map(|axis| {
            (region.signed_distance(point + h * axis) - region.signed_distance(point - h * axis)) / (2.0 * h)
        });
        let slope = DVec3::from(slope);
        // On ridges, where two faces are equally near, the slope is not defined.
        prop_assume!((slope.length() - 1.0).abs() < 1e-5);
        let foot = point - slope * distance;
        prop_assert!(region.signed_distance(foot).abs() < 1e-5, "{} from the surface", region.signed_distance(foot));
    }

    #[test]
    fn spheres_held_are_wholly_inside(
        region in any_region(), centre in vector(), radius in 0.01..0.5f64, steps in prop::collection::vec(vector(), 60)
    ) {
        if region.holds_sphere(centre, radius) {
            for step in steps {
                let surface = centre + step.normalize_or_zero() * (radius * (1.0 - 1e-9));
                // Slits between the parts of a union that are narrower than a sixteenth of the radius are not seen.
                let seen = !region.has_union() || region.signed_distance(surface) > radius / 16.0;
                prop_assert!(!seen || is_inside(&region, surface));
            }
        }
    }

    #[test]
    fn bounds_hold_the_region(region in any_region(), point in vector()) {
        let (min, max) = region.bounds();
        if is_inside(&region, point) {
            let slack = DVec3::splat(1e-12);
            prop_assert!(point.cmpge(min - slack).all() && point.cmple(max + slack).all());
        }
    }

    #[test]
    fn samples_lie_inside(region in any_region(), seed in 0..1000u64) {
        let mut stream = Stream::new(seed, "test", 0);
        if let Some(point) = region.sample(&mut stream, 1000) {
            prop_assert!(region.contains(point));
        }
    }

    #[test]
    fn in_the_plane_a_disc_is_held_as_its_outline_says(
        region in any_region(), x in -1.0..1.0f64, y in -1.0..1.0f64, plane in -0.5..0.5f64, radius in 0.001..0.4f64,
    ) {
        let flat = region.in_plane(plane);
        let centre = DVec3::new(x, y, plane);
        if flat.holds_sphere(centre, radius) {
            for k in 0..64 {
                let angle = 2.0 * PI * f64::from(k) / 64.0;
                let rim = centre + DVec3::new(angle.cos(), angle.sin(), 0.0) * (radius * (1.0 - 1e-9));
                prop_assert!(is_inside(&region, rim), "{} of {:?}", rim, flat);
            }
        }
        // It never holds less than the region itself.
        prop_assert!(flat.holds_sphere(centre, radius * (1.0 - 1e-9)) || !region.holds_sphere(centre, radius));
    }
}

#[test]
fn samples_are_uniform() {
    // Shares of volume at three heights of a cone with its tip at the bottom are as h^3.
    let cone = Region::Cone {
        axis: DVec3::Z,
        origin: DVec3::ZERO,
        along: [0.0, 1.0],
        radii: [0.0, 0.5],
    };
    let mut stream = Stream::new(1, "test", 0);
    let n = 20_000;
    let heights: Vec<f64> = (0..n)
        .map(|_| cone.sample(&mut stream, 1000).unwrap().z)
        .collect();
    for height in [0.5, 0.7, 0.9] {
        let share: f64 = f64::powi(height, 3);
        let below = heights.iter().filter(|&&z| z < height).count() as f64 / f64::from(n);
        // Four standard deviations of a binomial count.
        let tolerance = 4.0 * (share * (1.0 - share) / f64::from(n)).sqrt();
        assert!((below - share).abs() < tolerance, "{below} below {height}");
    }
}

#[test]
fn volumes() {
    let sphere = |x: f64, radius| Region::Sphere {
        origin: DVec3::X * x,
        radius,
    };
    let shell = Region::Difference(vec![sphere(0.0, 1.0), sphere(0.0, 0.5)]);
    let exact = 4.0 / 3.0 * PI * (1.0 - 0.125);
    // Four standard errors: the bounding box is 8 m^3.
    assert!((shell.volume() - exact).abs() < 4.0 * 8.0 * 0.0016);
    assert!((sphere(0.0, 1.0).volume() - 4.0 / 3.0 * PI).abs() < 1e-15);
    let cone = Region::Cone {
        axis: DVec3::Y,
        origin: DVec3::ZERO,
        along: [1.0, 3.0],
        radii: [0.0, 1.0],
    };
    assert!((cone.volume() - 2.0 / 3.0 * PI).abs() < 1e-15);
    let apart = Region::Intersection(vec![sphere(0.0, 1.0), sphere(3.0, 1.0)]);
    assert_eq!(apart.volume(), 0.0);
    let half = Region::HalfSpace {
        point: DVec3::ZERO,
        normal: DVec3::X,
    };
    assert_eq!(half.volume(), f64::INFINITY);
    let half_ball = Region::Intersection(vec![half, sphere(0.0, 1.0)]);
    assert!((half_ball.volume() - 2.0 / 3.0 * PI).abs() < 4.0 * 4.0 * 0.0016);
}

/// Two boxes with a common face: together the box from 0 to 1 along each axis.
fn joined() -> Region {
    let part = |low: f64, high: f64| Region::Box {
        min: DVec3::new(0.0, 0.0, low),
        max: DVec3::new(1.0, 1.0, high),
    };
    Region::Union(vec![part(0.0, 0.4), part(0.4, 1.0)])
}

#[test]
fn a_sphere_may_lie_across_the_joint_of_a_union() {
    let region = joined();
    // Far from the other faces it is held as in the whole box, wherever the joint cuts it.
    for z in [0.35, 0.4, 0.41, 0.5] {
        assert!(region.holds_sphere(DVec3::new(0.5, 0.5, z), 0.25), "{z}");
    }
    assert!(!region.holds_sphere(DVec3::new(0.5, 0.5, 0.3), 0.31));
    // An eighth of the radius is kept from faces, no more.
    assert!(region.holds_sphere(DVec3::new(0.23, 0.5, 0.4), 0.2));
    assert!(!region.holds_sphere(DVec3::new(0.19, 0.5, 0.4), 0.2));
    // A step at the joint is a corner that must not be cut.
    let step = Region::Union(vec![
        Region::Box {
            min: DVec3::ZERO,
            max: DVec3::new(1.0, 1.0, 0.4),
        },
        Region::Box {
            min: DVec3::new(0.5, 0.0, 0.4),
            max: DVec3::ONE,
        },
    ]);
    assert!(step.holds_sphere(DVec3::new(0.75, 0.5, 0.4), 0.2));
    assert!(!step.holds_sphere(DVec3::new(0.6, 0.5, 0.4), 0.2));
    assert!(!step.holds_sphere(DVec3::new(0.4, 0.5, 0.3), 0.15));
}

proptest! {
    #[test]
    fn a_box_cut_in_two_holds_what_the_whole_one_holds(centre in vector(), radius in 0.05..0.5f64) {
        let centre = 0.5 * (centre + DVec3::ONE);
        let whole = Region::Box { min: DVec3::ZERO, max: DVec3::ONE };
        if joined().holds_sphere(centre, radius) {
            prop_assert!(whole.holds_sphere(centre, radius));
        }
        if whole.holds_sphere(centre, 1.126 * radius) {
            prop_assert!(joined().holds_sphere(centre, radius));
        }
    }
}
