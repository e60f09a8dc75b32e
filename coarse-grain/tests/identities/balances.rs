//! Balances of momentum and spin, and gradients.

use glam::DVec3;
use mercury_cg::coordinates::{Coordinates, Place};
use mercury_cg::evaluate::Evaluator;
use mercury_cg::kernel::{Kernel, KernelShape};
use mercury_cg::sums::Sum;

use crate::support::{loads, packing};
use crate::{all, exact};

/// d/dt j = -div(k + sigma_c) + sum (f - contacts) phi + boundary force, at points, with the exact derivative of the sums in time on the
/// left and differences of sixth order of the fields on the right.
#[test]
fn momentum_and_spin_are_balanced() {
    let state = packing(80, 7, false);
    let loads = loads(&state);
    let layout = all();
    let resolved_sets = [
        [true, true, true],
        [false, true, true],
        [false, false, true],
    ];
    for (shape, w) in [(KernelShape::Gaussian, 0.1), (KernelShape::Lucy, 0.4)] {
        for resolved in resolved_sets {
            let coordinates = Coordinates::Cartesian(resolved);
            let dimensions = coordinates.kernel_dimensions();
            let choice = exact(shape, w);
            let kernel = Kernel::new(choice, dimensions);
            // Lucy's third derivative jumps at its edge: there differences are of second order, and steps short.
            let h = if shape == KernelShape::Lucy {
                2e-4
            } else {
                0.02
            } * w;
            let centre = DVec3::new(0.37, 0.81, 0.43);
            let offsets = [-3.0, -2.0, -1.0, 1.0, 2.0, 3.0];
            let weights = [
                -1.0 / 60.0,
                9.0 / 60.0,
                -45.0 / 60.0,
                45.0 / 60.0,
                -9.0 / 60.0,
                1.0 / 60.0,
            ];
            let axes: Vec<usize> = (0..3).filter(|&axis| resolved[axis]).collect();
            let mut points = vec![axes.iter().map(|&axis| centre[axis]).collect::<Vec<f64>>()];
            for k in 0..axes.len() {
                for offset in offsets {
                    let mut point = points[0].clone();
                    point[k] += offset * h;
                    points.push(point);
                }
            }
            let sums = Evaluator::new(coordinates, Place::Points(points), choice)
                .sums(&state, &layout, None);
            // Divergence over the second index of a tensor.
            let divergence = |of: &dyn Fn(usize, usize, usize) -> f64| {
                let mut out = [0.0; 3];
                for (a, out) in out.iter_mut().enumerate() {
                    for (k, &axis) in axes.iter().enumerate() {
                        for (q, weight) in weights.iter().enumerate() {
                            *out += weight * of(1 + 6 * k + q, a, axis) / h;
                        }
                    }
                }
                DVec3::from_array(out)
            };
            let flux = |point: usize, a: usize, b: usize| {
                let place = mercury_cg::sums::SYMMETRIC
                    .iter()
                    .position(|&pair| pair == (a.min(b), a.max(b)))
                    .unwrap();
                sums.at(Sum::MomentumFlux, point)[place]
            };
            let tensor = |sum: Sum| {
                let sums = &sums;
                move |point: usize, a: usize, b: usize| sums.at(sum, point)[3 * a + b]
            };
            let vector = |sum: Sum| DVec3::from_slice(sums.at(sum, 0));
            let (stress, spin_flux) = (tensor(Sum::Stress), tensor(Sum::SpinFlux));
            let (difference, couple_sum) = (tensor(Sum::CoupleDifference), tensor(Sum::CoupleSum));
            let right =
                vector(Sum::BoundaryForce) - divergence(&|p, a, b| flux(p, a, b) + stress(p, a, b));
            // eps_abg sigma_gb: what the asymmetric part of the stress turns.
            let turning = DVec3::new(
                stress(0, 2, 1) - stress(0, 1, 2),
                stress(0, 0, 2) - stress(0, 2, 0),
                stress(0, 1, 0) - stress(0, 0, 1),
            );
            let right_spin = vector(Sum::BoundaryCouple)
                - turning
                - divergence(&|p, a, b| {
                    spin_flux(p, a, b) + difference(p, a, b) + couple_sum(p, a, b)
                });
            // The derivative of the sums, images included.
            let project = |v: DVec3| {
                DVec3::from_array([0, 1, 2].map(|axis| if resolved[axis] { v[axis] } else { 0.0 }))
            };
            let (mut left, mut left_spin, mut scale) = (DVec3::ZERO, DVec3::ZERO, [0.0f64; 2]);
            let particles = &state.particles;
            for (k, &(force, torque)) in loads.iter().enumerate() {
                if !particles.flowing[k] {
                    continue;
                }
                for i in -2..=2 {
                    for j in -2..=2 {
                        if (i != 0 && !resolved[0]) || (j != 0 && !resolved[1]) {
                            continue;
                        }
                        let from = project(
                            centre
                                - particles.position[k]
                                - DVec3::new(f64::from(i), f64::from(j), 0.0),
                        );
                        let square = from.length_squared();
                        let (phi, slope) = (kernel.phi(square), kernel.slope(square));
                        let v = project(particles.velocity[k]);
                        let moved = -slope * from.dot(v);
                        let (a, b) = (
                            force * phi,
                            particles.mass[k] * particles.velocity[k] * moved,
                        );
                        let (c, d) = (torque * phi, particles.spin[k] * moved);
                        left += a + b;
                        left_spin += c + d;
                        scale[0] = scale[0]
                            .max(a.abs().max_element())
                            .max(b.abs().max_element());
                        scale[1] = scale[1]
                            .max(c.abs().max_element())
                            .max(d.abs().max_element());
                    }
                }
            }
            let tolerance = if shape == KernelShape::Lucy {
                1e-5
            } else {
                1e-9
            };
            assert!(
                (left - right).abs().max_element() < tolerance * scale[0],
                "{shape:?} {resolved:?}: {left} {right}"
            );
            assert!(
                (left_spin - right_spin).abs().max_element() < 30.0 * tolerance * scale[1],
                "{shape:?} {resolved:?}: {left_spin} {right_spin}"
            );
        }
    }
}

#[test]
fn gradients_are_those_of_the_fields() {
    let state = packing(60, 8, false);
    for (shape, w, tolerance) in [
        (KernelShape::Gaussian, 0.1, 1e-9),
        (KernelShape::Lucy, 0.4, 1e-5),
    ] {
        let h = if shape == KernelShape::Lucy {
            2e-4
        } else {
            0.02
        } * w;
        let centre = DVec3::new(0.52, 0.13, 0.6);
        let mut points = vec![centre.to_array().to_vec()];
        for axis in 0..3 {
            for offset in [-2.0, -1.0, 1.0, 2.0] {
                let mut point = centre;
                point[axis] += offset * h;
                points.push(point.to_array().to_vec());
            }
        }
        let sums = Evaluator::new(
            Coordinates::default(),
            Place::Points(points),
            exact(shape, w),
        )
        .sums(&state, &all(), None);
        let largest = sums
            .at(Sum::MomentumGradient, 0)
            .iter()
            .fold(0.0f64, |a, b| a.max(b.abs()));
        for a in 0..3 {
            for axis in 0..3 {
                let j = |k: usize| sums.at(Sum::Momentum, 1 + 4 * axis + k)[a];
                let slope = (j(0) - 8.0 * j(1) + 8.0 * j(2) - j(3)) / (12.0 * h);
                let found = sums.at(Sum::MomentumGradient, 0)[3 * a + axis];
                assert!(
                    (slope - found).abs() < 100.0 * tolerance * largest,
                    "{shape:?} {a} {axis}: {slope} {found}"
                );
            }
        }
    }
}
