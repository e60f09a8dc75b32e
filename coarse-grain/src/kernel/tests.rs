use glam::DVec3;
use proptest::prelude::*;

use super::quadrature::Rule;
use super::*;

const SHAPES: [KernelShape; 4] = [
    KernelShape::Gaussian,
    KernelShape::Lucy,
    KernelShape::Linear,
    KernelShape::Heaviside,
];

fn kernel(shape: KernelShape, width: f64, cutoff: f64, dimensions: usize) -> Kernel {
    Kernel::new(
        KernelChoice {
            cutoff,
            ..KernelChoice::new(shape, width)
        },
        dimensions,
    )
}

/// Keeps the resolved directions: the last ones.
fn project(v: DVec3, dimensions: usize) -> DVec3 {
    match dimensions {
        1 => DVec3::new(0.0, 0.0, v.z),
        2 => DVec3::new(0.0, v.y, v.z),
        _ => v,
    }
}

#[test]
fn kernels_integrate_to_one_and_have_the_variances_of_the_table() {
    let rule = Rule::gauss_legendre(20).in_pieces(20);
    for shape in SHAPES {
        for dimensions in 1..=3 {
            let k = kernel(shape, 0.7, 3.0, dimensions);
            let c = k.reach();
            let (mut mass, mut second) = (0.0, 0.0);
            for (node, weight) in rule.nodes.iter().zip(&rule.weights) {
                let r = (node + 0.5) * c;
                let shell = match dimensions {
                    1 => 2.0,
                    2 => 2.0 * PI * r,
                    _ => 4.0 * PI * r * r,
                };
                let value = weight * c * shell * k.phi(r * r);
                mass += value;
                second += value * r * r;
            }
            assert!((mass - 1.0).abs() < 1e-12, "{shape:?} {dimensions}: {mass}");
            // Variances of the reference's table, summed over directions, in squared radii.
            let expected = match (shape, dimensions) {
                (KernelShape::Heaviside, 1) => 1.0 / 3.0,
                (KernelShape::Heaviside, 2) => 1.0 / 2.0,
                (KernelShape::Heaviside, 3) => 3.0 / 5.0,
                (KernelShape::Linear, 1) => 1.0 / 6.0,
                (KernelShape::Linear, 2) => 3.0 / 10.0,
                (KernelShape::Linear, 3) => 2.0 / 5.0,
                (KernelShape::Lucy, 1) => 1.0 / 10.5,
                (KernelShape::Lucy, 2) => 1.0 / 5.6,
                (KernelShape::Lucy, 3) => 1.0 / 4.0,
                _ => continue,
            };
            assert!(
                (second / (c * c) - expected).abs() < 1e-12,
                "{shape:?} {dimensions}: {second}"
            );
        }
    }
}

#[test]
fn prefactors_are_those_of_the_table() {
    let w = 0.3;
    for (shape, expected) in [
        (
            KernelShape::Heaviside,
            [
                1.0 / (2.0 * w),
                1.0 / (PI * w * w),
                3.0 / (4.0 * PI * w * w * w),
            ],
        ),
        (
            KernelShape::Linear,
            [1.0 / w, 3.0 / (PI * w * w), 3.0 / (PI * w * w * w)],
        ),
        (
            KernelShape::Lucy,
            [
                5.0 / (4.0 * w),
                5.0 / (PI * w * w),
                105.0 / (16.0 * PI * w * w * w),
            ],
        ),
    ] {
        for dimensions in 1..=3 {
            let found = kernel(shape, w, 3.0, dimensions).peak();
            assert!(
                (found / expected[dimensions - 1] - 1.0).abs() < 1e-14,
                "{shape:?} {dimensions}"
            );
        }
    }
}

/// The line integral and its moment by many nodes, from the very kernel.
fn by_quadrature(k: &Kernel, start: DVec3, l: DVec3, r: DVec3) -> [f64; 2] {
    let rule = Rule::gauss_legendre(8).in_pieces(400);
    let mut sums = [0.0; 2];
    for (node, weight) in rule.nodes.iter().zip(&rule.weights) {
        let value = weight * k.phi((r - start - (node + 0.5) * l).length_squared());
        sums[0] += value;
        sums[1] += node * value;
    }
    sums
}

fn vectors() -> impl Strategy<Value = DVec3> {
    [-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64].prop_map(DVec3::from_array)
}

proptest! {
    #[test]
    fn polynomial_line_integrals_are_integrals_of_the_kernel(
        start in vectors(), l in vectors(), r in vectors(), dimensions in 1usize..=3, shape in 1usize..4,
    ) {
        let k = kernel(SHAPES[shape], 0.9, 3.0, dimensions);
        let [start, l, r] = [start, l, r].map(|v| project(v, dimensions));
        let (found, expected) = (k.line(start, l, r), by_quadrature(&k, start, l, r));
        // The kernel of Heaviside has a jump, which the nodes see to within one of 3200.
        let tolerance = if shape == 3 { 1e-3 } else { 1e-6 } * k.peak();
        prop_assert!((found[0] - expected[0]).abs() < tolerance, "{found:?} {expected:?}");
        prop_assert!((found[1] - expected[1]).abs() < tolerance, "{found:?} {expected:?}");
    }

    #[test]
    fn gaussian_line_integrals_are_integrals_of_the_kernel(
        start in vectors(), l in vectors(), scale in -8.0..0.5f64, r in vectors(), dimensions in 1usize..=3,
    ) {
        let k = kernel(KernelShape::Gaussian, 0.4, 9.0, dimensions);
        let l = l * libm::pow(10.0, scale);
        let [start, l, r] = [start, l, r].map(|v| project(v, dimensions));
        let (found, expected) = (k.line(start, l, r), by_quadrature(&k, start, l, r));
        prop_assert!((found[0] - expected[0]).abs() < 1e-13 * k.peak(), "{found:?} {expected:?}");
        prop_assert!((found[1] - expected[1]).abs() < 1e-10 * k.peak(), "{found:?} {expected:?}");
    }

    /// Along the segment psi grows by what the kernel at its beginning exceeds that at its end: the balance of momentum hangs on it.
    #[test]
    fn the_gradient_along_the_branch_is_the_difference_of_the_kernels(
        start in vectors(), l in vectors(), r in vectors(), dimensions in 1usize..=3, lucy in any::<bool>(),
    ) {
        let (shape, w) = if lucy { (KernelShape::Lucy, 1.4) } else { (KernelShape::Gaussian, 0.4) };
        let k = kernel(shape, w, 9.0, dimensions);
        let [start, l, r] = [start, l, r].map(|v| project(v, dimensions));
        prop_assume!(l.length() > 0.01);
        // Symmetric differences of sixth order along l.
        let h = 1e-2;
        let psi = |s: f64| k.line(start, l, r + s * h * l)[0];
        let slope = (45.0 * (psi(1.0) - psi(-1.0)) - 9.0 * (psi(2.0) - psi(-2.0)) + (psi(3.0) - psi(-3.0))) / (60.0 * h);
        let expected = k.phi((r - start).length_squared()) - k.phi((r - start - l).length_squared());
        // Lucy's third derivative jumps at the edge, so the differences are of third order there.
        let tolerance = if lucy { 1e-3 } else { 1e-6 } * k.peak();
        prop_assert!((slope - expected).abs() < tolerance, "{slope} {expected}");
    }

    /// The derivative of the kernel.
    #[test]
    fn slopes_are_derivatives(x in 0.01..0.99f64, dimensions in 1usize..=3, shape in 0usize..3) {
        let k = kernel(SHAPES[shape], 0.8, 3.0, dimensions);
        let r = x * k.reach();
        let h = 1e-5;
        let slope = (k.phi((r + h) * (r + h)) - k.phi((r - h) * (r - h))) / (2.0 * h);
        prop_assert!((slope - k.slope(r * r) * r).abs() < 1e-7 * k.peak(), "{slope}");
    }

    /// Exchanging the ends leaves psi and turns the moment.
    #[test]
    fn line_integrals_do_not_know_a_direction(start in vectors(), l in vectors(), r in vectors(), shape in 0usize..4) {
        let k = kernel(SHAPES[shape], 0.8, 3.0, 3);
        let (there, back) = (k.line(start, l, r), k.line(start + l, -l, r));
        prop_assert!((there[0] - back[0]).abs() < 1e-12 * k.peak());
        prop_assert!((there[1] + back[1]).abs() < 1e-9 * k.peak());
    }
}

#[test]
fn cut_line_integrals_integrate_to_one() {
    // Midpoint sums on a fine grid: what is inside the cut is smooth, its edge is seen to about 1e-4 of what is cut there.
    for dimensions in 1..=3 {
        for cut in [LineCut::Ellipsoid, LineCut::Cylinder] {
            for length in [0.3, 1.0, 4.0] {
                let choice = KernelChoice {
                    cutoff: 3.0,
                    line_cut: cut,
                    ..KernelChoice::new(KernelShape::Gaussian, 1.0)
                };
                let k = Kernel::new(choice, dimensions);
                let l = DVec3::new(0.0, 0.0, length);
                let (half, h): (f64, f64) = (3.0, if dimensions == 3 { 0.1 } else { 0.01 });
                let count = (2.0 * half / h).round() as i32;
                let along = ((2.0 * half + length) / h).round() as i32;
                let mut sum = 0.0;
                let cells = |resolved: bool| if resolved { 0..count } else { 0..1 };
                for a in cells(dimensions == 3) {
                    for b in cells(dimensions >= 2) {
                        for c in 0..along {
                            let place = |k: i32, resolved: bool| {
                                if resolved {
                                    -half + (f64::from(k) + 0.5) * h
                                } else {
                                    0.0
                                }
                            };
                            let r = DVec3::new(
                                place(a, dimensions == 3),
                                place(b, dimensions >= 2),
                                -half + (f64::from(c) + 0.5) * h,
                            );
                            sum += k.line(DVec3::ZERO, l, r)[0];
                        }
                    }
                }
                sum *= libm::pow(h, dimensions as f64);
                assert!(
                    (sum - 1.0).abs() < 3e-4,
                    "{dimensions} {cut:?} {length}: {sum}"
                );
            }
        }
    }
}

#[test]
fn the_factor_of_mercurys_cylinder_is_its_closed_form() {
    let (w, c) = (0.5f64, 1.5f64);
    let e = |x: f64| {
        x * libm::erf(x / (SQRT_2 * w)) + (2.0 / PI).sqrt() * w * libm::exp(-0.5 * x * x / (w * w))
    };
    for length in [0.1, 0.5, 2.0, 10.0] {
        for dimensions in 1..=3 {
            let choice = KernelChoice {
                cutoff: c / w,
                line_cut: LineCut::Cylinder,
                ..KernelChoice::new(KernelShape::Gaussian, w)
            };
            let k = Kernel::new(choice, dimensions);
            let across = match dimensions {
                1 => 1.0,
                2 => libm::erf(c / (SQRT_2 * w)),
                _ => 1.0 - libm::exp(-0.5 * c * c / (w * w)),
            };
            let expected = length / (e(c + length) - e(c)) / across;
            assert!(
                (k.line_factor(length) / expected - 1.0).abs() < 1e-9,
                "{dimensions} {length}: {} {expected}",
                k.line_factor(length)
            );
        }
    }
}

#[test]
fn without_resolved_coordinates_everything_is_one() {
    let k = kernel(KernelShape::Lucy, 1.0, 3.0, 0);
    assert_eq!(k.phi(0.0), 1.0);
    assert_eq!(k.line(DVec3::ZERO, DVec3::ZERO, DVec3::ZERO), [1.0, 0.0]);
}
