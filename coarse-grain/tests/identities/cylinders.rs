//! Cylindrical coordinates.

use glam::DVec3;
use mercury_cg::coordinates::{Coordinates, CylinderAxis, Place};
use mercury_cg::evaluate::Evaluator;
use mercury_cg::kernel::{KernelChoice, KernelShape};
use mercury_cg::sums::Sum;

use crate::support::packing;
use crate::{all, axis, close, exact, totals};

#[test]
fn cylindrical_fields_keep_mass_and_turn_vectors() {
    let mut state = packing(60, 14, false);
    state.space.periodic = [false; 3];
    let middle = DVec3::splat(0.5);
    // A rigid rotation about the axis: only the velocity along phi remains.
    let omega = 3.0;
    for k in 0..state.particles.len() {
        let from = state.particles.position[k] - middle;
        state.particles.velocity[k] = omega * DVec3::new(-from.y, from.x, 0.0);
    }
    let w = 0.1;
    let layout = all();
    let coordinates = Coordinates::Cylindrical {
        angle: false,
        along: false,
    };
    let outer = 1.8;
    let count = 60;
    let grid = vec![axis(0.0, outer, count)];
    let mut evaluator = Evaluator::new(
        coordinates,
        Place::Grid(grid.clone()),
        exact(KernelShape::Gaussian, w),
    );
    evaluator.axis = CylinderAxis {
        along: 2,
        through: middle,
    };
    let sums = evaluator.sums(&state, &layout, None);
    let total = totals(&state, &layout);
    // The mean over the length of the domain, 1 m, so the integral over rings is the sum.
    let mut mass = 0.0;
    for k in 0..count {
        mass +=
            2.0 * std::f64::consts::PI * grid[0].at(k) * grid[0].step() * sums.at(Sum::Mass, k)[0];
        let j = sums.at(Sum::Momentum, k);
        let scale = sums.at(Sum::Mass, 0)[0].max(sums.at(Sum::Mass, k)[0]) * omega;
        assert!(j[0].abs() <= 1e-7 * scale && j[2].abs() < 1e-12, "{j:?}");
    }
    // A midpoint sum with an end at r = 0, where r rho is odd: h^2/24 (r rho)'(0) 2 pi is missing.
    let missing =
        2.0 * std::f64::consts::PI * grid[0].step().powi(2) / 24.0 * sums.at(Sum::Mass, 0)[0];
    assert!(
        (mass - total.at(Sum::Mass, 0)[0]).abs() < 1.2 * missing + 1e-9 * mass,
        "{mass} {:?}",
        total.at(Sum::Mass, 0)
    );
    // Turned by the angle, points of a plane are those of the plane.
    let angle = 0.7;
    let mut round = Evaluator::new(
        Coordinates::Cylindrical {
            angle: true,
            along: true,
        },
        Place::Points(vec![vec![0.3, angle, 0.9]]),
        exact(KernelShape::Gaussian, w),
    );
    round.axis = evaluator.axis;
    let plane = vec![0.5 + 0.3 * angle.cos(), 0.5 + 0.3 * angle.sin(), 0.9];
    let flat = Evaluator::new(
        Coordinates::default(),
        Place::Points(vec![plane]),
        exact(KernelShape::Gaussian, w),
    );
    let (a, b) = (
        round.sums(&state, &layout, None),
        flat.sums(&state, &layout, None),
    );
    close(a.at(Sum::Mass, 0), b.at(Sum::Mass, 0), 1e-12, "mass");
    let (s, t) = (a.at(Sum::Stress, 0), b.at(Sum::Stress, 0));
    close(&[s[0] + s[4] + s[8]], &[t[0] + t[4] + t[8]], 1e-11, "trace");
    let (e_r, e_phi) = (
        DVec3::new(angle.cos(), angle.sin(), 0.0),
        DVec3::new(-angle.sin(), angle.cos(), 0.0),
    );
    let along = |x: DVec3, y: DVec3| (0..9).map(|k| x[k / 3] * t[k] * y[k % 3]).sum::<f64>();
    close(
        &[s[1], s[3]],
        &[along(e_r, e_phi), along(e_phi, e_r)],
        1e-11,
        "shear",
    );
}

#[test]
fn an_axis_may_be_any_and_turns_with_the_state() {
    let state = packing(40, 15, false);
    // The turned state is the original with its axes permuted: x to z, y to x, z to y.
    let turn = |v: DVec3| DVec3::new(v.y, v.z, v.x);
    let mut turned = state.clone();
    let p = &mut turned.particles;
    for list in [
        &mut p.position,
        &mut p.velocity,
        &mut p.angular_velocity,
        &mut p.spin,
    ] {
        for v in list.iter_mut() {
            *v = turn(*v);
        }
    }
    let c = turned.contacts.as_mut().unwrap();
    for list in [
        &mut c.point,
        &mut c.arm,
        &mut c.partner_arm,
        &mut c.normal,
        &mut c.force,
        &mut c.couple,
    ] {
        for v in list.iter_mut() {
            *v = turn(*v);
        }
    }
    turned.space.periodic = [true, false, true];
    let coordinates = Coordinates::Cylindrical {
        angle: true,
        along: true,
    };
    let place = Place::Points(vec![vec![0.2, 0.4, 0.5], vec![0.35, 2.0, 0.1]]);
    let mut about_x = Evaluator::new(
        coordinates,
        place,
        KernelChoice::new(KernelShape::Gaussian, 0.1),
    );
    about_x.axis = CylinderAxis {
        along: 0,
        // Heights are those of the input, wherever on the axis its point is.
        through: DVec3::new(7.0, 0.5, 0.5),
    };
    let mut about_z = about_x.clone();
    about_z.axis = CylinderAxis {
        along: 2,
        through: DVec3::new(0.5, 0.5, 0.0),
    };
    let (a, b) = (
        about_x.sums(&state, &all(), None),
        about_z.sums(&turned, &all(), None),
    );
    for (a, b) in a.values.iter().zip(&b.values) {
        close(a, b, 1e-12, "turned");
    }
}
