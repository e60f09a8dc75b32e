//! The free rotor against references made with an integrator of eighth order, at a tolerance of 1e-13.

use glam::{DQuat, DVec3, dvec3};

use super::t_bar;
use crate::bodies::{angular_velocity, free_rotation};

/// Orientation and angular momentum after `steps` steps of `time` seconds in all.
fn rotor(spin: DVec3, time: f64, steps: u32) -> (DQuat, DVec3) {
    let moments = t_bar().moments;
    let momentum = moments * spin;
    let step = time / f64::from(steps);
    let turn = |q, _| free_rotation(q, momentum, moments, step);
    ((0..steps).fold(DQuat::IDENTITY, turn), momentum)
}

/// Difference of the angular velocity in the body frame from a reference, over the reference.
fn error(spin: DVec3, time: f64, steps: u32, reference: DVec3) -> f64 {
    let (q, momentum) = rotor(spin, time, steps);
    let moments = t_bar().moments;
    let body = q.inverse() * angular_velocity(q, momentum, moments);
    (body - reference).length() / reference.length()
}

const FAST: (DVec3, f64, DVec3) = (
    dvec3(0.0, 20.0, 0.01),
    1.0,
    dvec3(-0.603_232_76, -19.990_369_56, 0.422_231_60),
);
const SLOW: (DVec3, f64, DVec3) = (
    dvec3(0.01, 2.0, 0.01),
    20.0,
    dvec3(0.032_460_24, 1.999_747_65, 0.023_811_04),
);

#[test]
fn angular_velocities_of_the_references() {
    for (spin, time, reference) in [FAST, SLOW] {
        // Second order, see below, of an error of about 1e-3 at 1,000 steps; eight digits of the reference.
        let error = error(spin, time, 100_000, reference);
        assert!(error < 1e-7, "{error:e}");
    }
}

#[test]
fn the_error_is_of_second_order() {
    for (spin, time, reference) in [FAST, SLOW] {
        let errors = [500, 1000, 2000, 4000].map(|steps| error(spin, time, steps, reference));
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            assert!((order - 2.0).abs() < 0.1, "{errors:?}");
        }
    }
}

/// Energy and length of the quaternion over a million steps at 40 steps per turn: the energy oscillates with the square of the
/// step (0.157^2/24 of a difference of moments), without drift; the angular momentum is never touched.
#[test]
fn the_energy_stays_bounded_over_a_million_steps() {
    let moments = t_bar().moments;
    let momentum = moments * dvec3(0.5, 20.0, 0.3);
    let step = std::f64::consts::TAU / 20.0 / 40.0;
    let energy = |q| 0.5 * angular_velocity(q, momentum, moments).dot(momentum);
    let start = energy(DQuat::IDENTITY);
    let mut q = DQuat::IDENTITY;
    let mut most = [0.0f64; 2];
    for k in 0..1_000_000 {
        q = free_rotation(q, momentum, moments, step);
        let half = usize::from(k >= 500_000);
        most[half] = most[half].max((energy(q) / start - 1.0).abs());
    }
    assert!((q.length() - 1.0).abs() < 1e-15);
    assert!(most[0] < 2e-3, "{most:?}");
    // The second half goes no farther than the first, but for how near each comes to the extremes.
    assert!(most[1] < 1.01 * most[0], "{most:?}");
}

#[test]
fn rotation_runs_backwards() {
    let moments = t_bar().moments;
    let momentum = moments * dvec3(3.0, 20.0, -4.0);
    let mut q = DQuat::IDENTITY;
    for _ in 0..1000 {
        q = free_rotation(q, momentum, moments, 2e-3);
    }
    for _ in 0..1000 {
        q = free_rotation(q, -momentum, moments, 2e-3);
    }
    // Round-off of 10,000 rotations, grown by the instability of the intermediate axis (rate 20/s times 0.12 over 4 s: e^9).
    assert!(q.angle_between(DQuat::IDENTITY) < 1e-9, "{q}");
}

#[test]
fn large_angles_turn_as_small_ones() {
    // About a principal axis a step of any length is exact.
    let moments = dvec3(1.0, 2.0, 3.0);
    for axis in DVec3::AXES {
        let momentum = moments * axis * 2.0;
        let at_once = free_rotation(DQuat::IDENTITY, momentum, moments, 1.3);
        let expected = DQuat::from_axis_angle(axis, 2.6);
        // Some five roundings of numbers up to 1; not by the arc cosine, which sees no angle below 3e-8.
        assert!(at_once.abs_diff_eq(expected, 1e-15), "{at_once}");
    }
}
