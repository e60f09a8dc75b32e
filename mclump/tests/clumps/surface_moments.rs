//! Volume integrals of surfaces: exact for polyhedra, second order for smooth bodies, the same in every pose.

use std::f64::consts::PI;

use crate::common::*;
use glam::{DMat3, DVec3};
use mclump::inertia::{MassProperties, surface};
use mclump::surface::prepare;
use mercury_common::formats::mesh::{TriangleMesh, read_mesh};
use proptest::prelude::*;

fn integrate(mesh: &TriangleMesh) -> MassProperties {
    surface::integrate(mesh).unwrap()
}

#[test]
fn polyhedra_are_exact() {
    let half = DVec3::new(0.5, 1.0, 1.5);
    let square = half * half;
    // A box: m/3 (b² + c²) with half edges. A tetrahedron (0, x, y, z): volume 1/6, ∫ x² = 1/60 and ∫ x y = 1/120 about
    // the corner. An octahedron |x| + |y| + |z| <= a: volume 4/3 a³, ∫ x² = 2/15 a⁵.
    let a = 1.7f64;
    for (name, mesh, volume, centre, second, mixed) in [
        (
            "cube",
            cuboid(DVec3::splat(0.5)),
            1.0,
            DVec3::ZERO,
            DVec3::splat(1.0 / 12.0),
            0.0,
        ),
        (
            "box",
            cuboid(half),
            6.0,
            DVec3::ZERO,
            6.0 / 3.0 * square,
            0.0,
        ),
        (
            "tetrahedron",
            tetrahedron(),
            1.0 / 6.0,
            DVec3::splat(0.25),
            DVec3::splat(1.0 / 60.0 - 1.0 / 96.0),
            1.0 / 120.0 - 1.0 / 96.0,
        ),
        (
            "octahedron",
            octahedron(a),
            4.0 / 3.0 * a.powi(3),
            DVec3::ZERO,
            DVec3::splat(2.0 / 15.0 * a.powi(5)),
            0.0,
        ),
    ] {
        let found = integrate(&mesh);
        assert_close(found.volume, volume, 1e-12, name);
        assert_vectors(found.centre, centre, 1e-12, name);
        let off = DMat3::from_cols(DVec3::ONE, DVec3::ONE, DVec3::ONE) * mixed;
        let expected = off + DMat3::from_diagonal(second - DVec3::splat(mixed));
        let scale = second.max_element();
        assert!(
            found.second_moment.abs_diff_eq(expected, 1e-12 * scale),
            "{name}: {} {expected}",
            found.second_moment
        );
    }
}

#[test]
fn products_of_inertia_are_not_swapped() {
    // A defect of the existing tool: Ixy and Ixz were exchanged. A box sheared in x over y only has xy alone: the map x + s y
    // of the unit cube gives ∫ x y = s/12.
    let s = 0.3;
    let sheared = mapped(&cuboid(DVec3::splat(0.5)), |v| {
        DVec3::new(v.x + s * v.y, v.y, v.z)
    });
    let inertia = integrate(&sheared).inertia();
    assert_close(inertia.x_axis.y, -s / 12.0, 1e-12, "Ixy");
    assert!(
        inertia.x_axis.z.abs() < 1e-16 && inertia.y_axis.z.abs() < 1e-16,
        "{inertia}"
    );
}

/// Volume, and second moments along the axes about the centre.
type Exact = (f64, DVec3);
/// A body at a level of refinement.
type Family = Box<dyn Fn(u32) -> TriangleMesh>;

#[test]
fn smooth_bodies_converge_with_second_order() {
    let (a, b, c) = (1.0, 2.0, 3.0);
    let ellipsoid_volume = ball_volume(1.0) * a * b * c;
    let squares = DVec3::new(a * a, b * b, c * c);
    let (big, small) = (2.0f64, 0.5f64);
    let torus_volume = 2.0 * PI * PI * big * small * small;
    // Torus: m (4 r² ... ) about its axis I_z = m (R² + 3/4 r²), I_x = m (R²/2 + 5/8 r²); ∫ z² = m r²/4.
    let torus_z = torus_volume * small * small / 4.0;
    let torus_x = 0.5 * torus_volume * (big * big + 0.75 * small * small);
    let (r, h) = (0.8f64, 1.9f64);
    let cone_volume = PI * r * r * h / 3.0;
    // Cone: I_z = 3/10 m r², ∫ z² about the centre = 3/80 m h².
    let cone_x = cone_volume * 0.15 * r * r;
    let bodies: [(&str, Family, Exact); 4] = [
        (
            "sphere",
            Box::new(sphere),
            (ball_volume(1.0), DVec3::splat(ball_volume(1.0) / 5.0)),
        ),
        (
            "ellipsoid",
            Box::new(move |n| mapped(&sphere(n), |v| v * DVec3::new(a, b, c))),
            (ellipsoid_volume, ellipsoid_volume / 5.0 * squares),
        ),
        (
            "torus",
            Box::new(move |n| torus(big, small, 6 << n)),
            (torus_volume, DVec3::new(torus_x, torus_x, torus_z)),
        ),
        (
            "cone",
            Box::new(move |n| cone(r, h, 6 << n)),
            (
                cone_volume,
                DVec3::new(cone_x, cone_x, cone_volume * 3.0 / 80.0 * h * h),
            ),
        ),
    ];
    for (name, generate, (volume, second)) in bodies {
        let errors: Vec<(f64, f64)> = (2..5)
            .map(|level| {
                let found = integrate(&generate(level));
                let j = found.second_moment;
                let diagonal = DVec3::new(j.x_axis.x, j.y_axis.y, j.z_axis.z);
                (
                    (found.volume / volume - 1.0).abs(),
                    (diagonal / second - 1.0).abs().max_element(),
                )
            })
            .collect();
        for pair in errors.windows(2) {
            // Each level halves the edges: a quarter of the error.
            for (coarse, fine) in [(pair[0].0, pair[1].0), (pair[0].1, pair[1].1)] {
                let order = (coarse / fine).log2();
                assert!((order - 2.0).abs() < 0.15, "{name}: order {order}");
            }
        }
        assert!(errors[2].0 < 0.01, "{name}: {errors:?}");
    }
}

#[test]
fn third_moments_are_exact() {
    // ∫ z³ of the cone about its centre: with s = h - z from the tip, ∫ (s - 3h/4)³ pi r² s²/h² ds = -pi r² h⁴/480 along s, so
    // +... along z. By the binomial: s⁵/5... evaluated below.
    let (r, h) = (1.0f64, 2.0f64);
    let n = 40;
    let mesh = cone(r, h, n);
    let properties = integrate(&mesh);
    let base = f64::from(n) / 2.0 * (2.0 * PI / f64::from(n)).sin() * r * r;
    let m = 0.75 * h;
    let power = |k: i32| h.powi(k) / f64::from(k);
    let from_tip = power(6) - 3.0 * m * power(5) + 3.0 * m * m * power(4) - m.powi(3) * power(3);
    let expected = -base / (h * h) * from_tip;
    let found = surface::third_moment(&mesh, properties.centre, DVec3::Z);
    assert_close(found, expected, 1e-12, "third moment along the axis");
    let across = surface::third_moment(&mesh, properties.centre, DVec3::X);
    assert!(across.abs() < 1e-14, "{across}");
}

#[test]
fn the_rattleback_has_the_reference_values() {
    let Some(folder) = shared("data/shapes/mesh") else {
        return;
    };
    let prepared = prepare(read_mesh(folder.join("Rattleback.stl")).unwrap(), false).unwrap();
    assert_eq!(prepared.done, Vec::<String>::new());
    let found = integrate(&prepared.mesh);
    // Reference values are printed with this many digits.
    assert_close(found.volume, 8512.45680345, 1e-11, "volume");
    assert_close(surface::area(&prepared.mesh), 3817.62838524, 1e-11, "area");
    assert_vectors(
        found.centre,
        DVec3::new(124.9530410089, 89.0569499788, -1.3611130833),
        1e-9,
        "centre",
    );
    let expected = DMat3::from_cols(
        DVec3::new(221776.61612531, -745.10024084, -1550.55691221),
        DVec3::new(-745.10024084, 3624607.92847045, 246.88895336),
        DVec3::new(-1550.55691221, 246.88895336, 3767463.04174954),
    );
    assert!(
        found.inertia().abs_diff_eq(expected, 1e-10 * 3767463.0),
        "{}",
        found.inertia()
    );
    assert_vectors(
        found.principal_moments(),
        DVec3::new(221775.77495, 3624607.66376, 3767464.14763),
        1e-5,
        "principal moments",
    );
}

#[test]
fn drums_and_box_have_the_reference_values() {
    let Some(folder) = shared("data/shapes/mesh") else {
        return;
    };
    for (name, volume, area, centre, moments, digits) in [
        (
            "Box1x1x1.stl",
            0.999999924,
            5.9999997,
            DVec3::new(1.1029065847, 0.8621355444, 0.5000009768),
            DVec3::splat(1.0 / 6.0),
            1e-6,
        ),
        (
            "RotatingDrum_clump.stl",
            1.85508385590e11,
            1.87135380752e8,
            DVec3::new(-1.5227, 0.0, 2125.0),
            DVec3::new(9.2308528e17, 9.2413430e17, 1.28876205e18),
            1e-7,
        ),
        (
            "RotatingDrum_nozzle.stl",
            1484067.09098,
            74854.1525324,
            DVec3::new(-0.030454, 0.0, 42.5),
            DVec3::new(2.95387295e9, 2.95722976e9, 4.12403859e9),
            1e-8,
        ),
    ] {
        let prepared = prepare(read_mesh(folder.join(name)).unwrap(), false).unwrap();
        let found = integrate(&prepared.mesh);
        assert_close(found.volume, volume, 1e-9, name);
        assert_close(surface::area(&prepared.mesh), area, 1e-8, name);
        let size = volume.cbrt();
        assert_vectors(found.centre / size, centre / size, 1e-7, name);
        assert_vectors(
            found.principal_moments() / moments,
            DVec3::ONE,
            digits,
            name,
        );
    }
}

fn shapes() -> Vec<TriangleMesh> {
    let odd = mapped(&sphere(2), |v| {
        DVec3::new(
            v.x * (1.0 + 0.3 * v.z),
            1.5 * v.y + 0.2 * v.x * v.x,
            2.0 * v.z,
        )
    });
    vec![
        cuboid(DVec3::new(0.5, 1.0, 1.5)),
        tetrahedron(),
        torus(2.0, 0.5, 12),
        odd,
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Any rotation, and any translation up to 100 sizes: the same tensor, turned, to 1e-10.
    #[test]
    fn poses_do_not_matter(
        index in 0usize..4,
        numbers in [-1.0..1.0f64, -1.0..1.0, -1.0..1.0, 0.1..1.0],
        shift in [-1.0..1.0f64, -1.0..1.0, -1.0..1.0],
    ) {
        let mesh = &shapes()[index];
        let (low, high) = mesh.bounds().unwrap();
        let (rotation, shift) = (turn(numbers), 100.0 * (high - low).length() * DVec3::from_array(shift));
        let moved = integrate(&mapped(mesh, |v| rotation * v + shift));
        let still = integrate(mesh);
        prop_assert!((moved.volume / still.volume - 1.0).abs() < 1e-11);
        let expected = rotation * still.inertia() * rotation.transpose();
        let trace = still.principal_moments().element_sum();
        prop_assert!(moved.inertia().abs_diff_eq(expected, 1e-11 * trace), "{} {expected}", moved.inertia());
        let moments = moved.principal_moments() / still.principal_moments();
        prop_assert!(moments.abs_diff_eq(DVec3::ONE, 1e-10), "{moments}");
        prop_assert!(moved.centre.abs_diff_eq(rotation * still.centre + shift, 1e-11 * shift.length().max(1.0)));
    }
}
