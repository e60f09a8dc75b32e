//! Integrals of fields are sums over particles and contacts.

use glam::DVec3;
use mercury_cg::coordinates::{Coordinates, GridAxis, Place};
use mercury_cg::evaluate::Evaluator;
use mercury_cg::kernel::{KernelChoice, KernelShape};
use mercury_cg::state::Partner;
use mercury_cg::sums::{Layout, Sum};

use crate::support::packing;
use crate::{SHAPES, all, axis, close, exact, integral, totals};

#[test]
fn integrals_of_fields_are_sums_over_particles_and_contacts() {
    let state = packing(40, 1, false);
    let total = totals(&state, &all());
    // The sums without coordinates: Love's and Weber's stress, written out once more.
    let c = state.contacts.as_ref().unwrap();
    let mut stress = [0.0; 9];
    for k in 0..c.len() {
        let flows = |partner: Partner| matches!(partner, Partner::Particle(j) if state.particles.flowing[j as usize]);
        let mut l = DVec3::ZERO;
        l += if state.particles.flowing[c.particle[k] as usize] {
            c.arm[k]
        } else {
            DVec3::ZERO
        };
        l -= if flows(c.partner[k]) {
            c.partner_arm[k]
        } else {
            DVec3::ZERO
        };
        for a in 0..9 {
            stress[a] += c.force[k][a / 3] * l[a % 3];
        }
    }
    close(total.at(Sum::Stress, 0), &stress, 1e-13, "stress");
    // x and y are periodic, z is open: the grid goes on as far as the kernel reaches. h = 0.75 w: exact to 4e-15.
    let w = 0.1;
    let count = |length: f64| (length / (0.75 * w)).ceil() as usize;
    let grid = vec![
        axis(0.0, 1.0, count(1.0)),
        axis(0.0, 1.0, count(1.0)),
        axis(-1.0, 2.0, count(3.0)),
    ];
    let cell = grid.iter().map(GridAxis::step).product::<f64>();
    let evaluator = Evaluator::new(
        Coordinates::default(),
        Place::Grid(grid),
        exact(KernelShape::Gaussian, w),
    );
    let sums = evaluator.sums(&state, &all(), None);
    for sum in [
        Sum::Sizes,
        Sum::Volume,
        Sum::Mass,
        Sum::Momentum,
        Sum::MomentumFlux,
        Sum::Touching,
        Sum::Spin,
        Sum::SpinFlux,
        Sum::Stress,
        Sum::ContactCount,
        Sum::Fabric,
        Sum::CoupleDifference,
        Sum::BoundaryForce,
        Sum::BoundaryCouple,
    ] {
        close(
            &integral(&sums, sum, cell),
            total.at(sum, 0),
            2e-13,
            &format!("{sum:?}"),
        );
    }
    // First moments of line integrals and gradients integrate to nothing.
    for sum in [Sum::CoupleSum, Sum::MomentumGradient, Sum::MassGradient] {
        let largest = sums
            .values
            .iter()
            .flatten()
            .fold(0.0f64, |a, b| a.max(b.abs()));
        for value in integral(&sums, sum, cell) {
            assert!(value.abs() < 1e-12 * largest, "{sum:?}: {value}");
        }
    }
}

#[test]
fn one_contact_integrates_to_force_times_branch_for_every_kernel() {
    let state = |l: DVec3, force: DVec3| {
        let mut state = packing(2, 3, true);
        state.space.periodic = [false; 3];
        let c = state.contacts.as_mut().unwrap();
        *c = Default::default();
        state.particles.flowing = vec![true; 2];
        let middle = DVec3::splat(0.5);
        c.particle.push(0);
        c.partner.push(Partner::Particle(1));
        c.point.push(middle);
        c.arm.push(0.4 * l);
        c.partner_arm.push(-0.6 * l);
        c.normal.push(l.normalize());
        c.force.push(force);
        state
    };
    let (l, force) = (DVec3::new(0.06, -0.02, 0.11), DVec3::new(1.0, 2.0, -0.5));
    let expected: Vec<f64> = (0..9).map(|k| force[k / 3] * l[k % 3]).collect();
    for shape in SHAPES {
        for cutoff in [3.0, 5.0, 8.8] {
            let w = if shape == KernelShape::Gaussian {
                0.1
            } else {
                0.35
            };
            let grid = |n| vec![axis(-0.6, 1.6, n), axis(-0.6, 1.6, n), axis(-0.6, 1.6, n)];
            let n = 44;
            let choice = KernelChoice {
                cutoff,
                tolerance: 1e-15,
                ..KernelChoice::new(shape, w)
            };
            let evaluator = Evaluator::new(Coordinates::default(), Place::Grid(grid(n)), choice);
            let sums = evaluator.sums(&state(l, force), &Layout::new(&[Sum::Stress]), None);
            let cell = (2.2 / n as f64).powi(3);
            // Error of a sum over cells for a function with a jump or a kink at its edge.
            let tolerance = match (shape, cutoff) {
                (KernelShape::Gaussian, 8.8) => 1e-13,
                (KernelShape::Gaussian, 5.0) => 2e-5,
                (KernelShape::Gaussian, _) => 5e-3,
                (KernelShape::Lucy, _) => 1e-4,
                (KernelShape::Linear, _) => 5e-3,
                (KernelShape::Heaviside, _) => 2e-2,
            };
            close(
                &integral(&sums, Sum::Stress, cell),
                &expected,
                tolerance,
                &format!("{shape:?} {cutoff}"),
            );
            if shape != KernelShape::Gaussian {
                break;
            }
        }
    }
}

#[test]
fn materials_add_up_to_the_mixture_and_their_drag_to_nothing() {
    let state = packing(80, 9, false);
    let grid = vec![axis(0.0, 1.0, 4), axis(0.0, 1.0, 3), axis(0.0, 1.0, 5)];
    let evaluator = Evaluator::new(
        Coordinates::default(),
        Place::Grid(grid),
        exact(KernelShape::Gaussian, 0.1),
    );
    let whole = evaluator.sums(&state, &all(), None);
    let mut parts = evaluator.sums(&state, &all(), Some(0));
    parts.add(&evaluator.sums(&state, &all(), Some(1)), 1.0);
    for sum in [
        Sum::Sizes,
        Sum::Mass,
        Sum::Momentum,
        Sum::MomentumFlux,
        Sum::Stress,
        Sum::BoundaryForce,
        Sum::BoundaryCouple,
        Sum::MomentumGradient,
    ] {
        for point in 0..whole.points {
            close(
                parts.at(sum, point),
                whole.at(sum, point),
                1e-11,
                &format!("{sum:?}"),
            );
        }
    }
    let single = evaluator.sums(&state, &all(), Some(0));
    let largest = single.values[4].iter().fold(0.0f64, |a, b| a.max(b.abs()));
    for point in 0..whole.points {
        assert!(
            single
                .at(Sum::Drag, point)
                .iter()
                .any(|value| value.abs() > 1e-6 * largest)
                || point > 0
        );
        for value in parts
            .at(Sum::Drag, point)
            .iter()
            .chain(whole.at(Sum::Drag, point))
        {
            assert!(value.abs() < 1e-12 * largest);
        }
    }
}

#[test]
fn equal_particles_give_the_same_as_nearly_equal_ones() {
    let mut state = packing(60, 10, true);
    let layout = Layout::new(&[
        Sum::Sizes,
        Sum::Volume,
        Sum::Mass,
        Sum::Momentum,
        Sum::MomentumFlux,
    ]);
    let evaluator = |coordinates, place| {
        Evaluator::new(
            coordinates,
            place,
            KernelChoice::new(KernelShape::Gaussian, 0.1),
        )
    };
    for evaluator in [
        evaluator(
            Coordinates::default(),
            Place::Grid(vec![axis(0.0, 1.0, 3); 3]),
        ),
        evaluator(
            Coordinates::default(),
            Place::Points(vec![vec![0.3, 0.4, 0.2]]),
        ),
        evaluator(
            Coordinates::Cartesian([false; 3]),
            Place::Points(vec![Vec::new()]),
        ),
    ] {
        let equal = evaluator.sums(&state, &layout, None);
        let mass = state.particles.mass[0];
        state.particles.mass[0] *= 1.0 + 1e-15;
        let nearly = evaluator.sums(&state, &layout, None);
        state.particles.mass[0] = mass;
        close(&equal.values[0], &nearly.values[0], 1e-13, "equal");
    }
}
