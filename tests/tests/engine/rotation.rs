//! How particles and bodies turn: about which axes, in which order, how exactly, and that a spin which is no number ends the run.

use glam::{DQuat, DVec3, dvec3};
use mercury_common::formats::clump::Pebble;
use mercury_engine::bodies::{Clump, NewBody};
use mercury_engine::contact::registry::AnyPairLaw;
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, CoulombLimits, Linear, LinearFriction,
    PairLaw, SpringRotation,
};
use mercury_engine::state::MaterialIndex;
use mercury_engine::step::{Engine, RunError};
use mercury_tests::scenes::{advance, plan, sphere, start};

/// With friction, so that particles turn.
fn law() -> AnyPairLaw {
    PairLaw {
        normal: AnyNormal::Linear(Linear::new(1e3, 0.0)),
        tangential: AnyTangential::Linear(LinearFriction {
            stiffness: 1e3,
            dissipation: 0.0,
            friction: 0.5,
            static_friction: 0.5,
            rotation: SpringRotation::Project,
            limits: CoulombLimits::Bounded,
        }),
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    }
}

/// A ball that nothing touches.
fn free_ball(spin: DVec3) -> Engine {
    let mut plan = plan(1e-3, 2000.0, law());
    plan.orientations = true;
    start(plan.with_particles(vec![sphere(DVec3::ZERO, 0.01, DVec3::X, spin)]))
}

/// First by an angle a about x, then by b about z: angular velocities are those of space, so that the second turn comes after the first, from the
/// left. From the right, about the ball's own z, the ball would end elsewhere: Rx Rz is another rotation than Rz Rx. Each step turns exactly for a spin that stays.
#[test]
fn turns_about_one_axis_after_another_are_made_in_space() {
    let (a, b) = (0.9, 1.3);
    let mut engine = free_ball(DVec3::X * (a / 0.1));
    advance(&mut engine, 100);
    engine.particles.records[0].angular_velocity = DVec3::Z * (b / 0.1);
    advance(&mut engine, 100);
    let found = engine.particles.orientations.as_ref().unwrap()[0];
    let expected = DQuat::from_rotation_z(b) * DQuat::from_rotation_x(a);
    let other = DQuat::from_rotation_x(a) * DQuat::from_rotation_z(b);
    let off = |one: DQuat| one.dot(found).abs() - 1.0;
    assert!(off(expected).abs() < 1e-12, "{found}, {expected}");
    assert!(off(other).abs() > 0.01);
}

/// Nothing moves yet with a spin that is no number, or whose square is none: it ends the run all the same, before it gets into a contact or a file.
#[test]
fn a_spin_that_is_no_number_ends_the_run() {
    for wrong in [f64::NAN, f64::INFINITY, 1e200] {
        let mut engine = free_ball(DVec3::Y);
        advance(&mut engine, 3);
        engine.particles.records[0].angular_velocity.y = wrong;
        let ended = engine.step(None);
        assert!(
            matches!(ended, Err(RunError::NotFinite { .. })),
            "{wrong}: {ended:?}"
        );
    }
}

/// Where a body with three different moments has got in one turn about z, which is prescribed, while nothing turns it about x and y but what it has.
fn wobbling(steps: u64) -> DQuat {
    let (time, spin) = (1.0, std::f64::consts::TAU);
    let pebble = Pebble {
        position: DVec3::ZERO,
        radius: 0.05,
    };
    let moments = dvec3(1e-3, 1.6e-3, 2.2e-3);
    let material = MaterialIndex::new(0);
    let clump = Clump::new("potato", material, vec![pebble], 1.0, 1e-3, moments).unwrap();
    let body = NewBody {
        orientation: DQuat::from_scaled_axis(dvec3(0.3, 0.5, -0.4)),
        angular_velocity: dvec3(1.5, -1.0, spin),
        prescribed_angular_velocity: [None, None, Some(spin)],
        ..NewBody::at(DVec3::ZERO, 0)
    };
    let plan = plan(time / steps as f64, 2000.0, law());
    let mut engine = start(plan.with_bodies(vec![clump], vec![body]));
    advance(&mut engine, steps);
    engine.particles.bodies()[0].orientation
}

/// The motion about the other axes is of second order in the step: half the step, a quarter of the error. Errors of first order would halve. Against a run of
/// 16 times the finest resolution the ratio is 4 (1 - 1/32²)/(1 - 1/16²), within a thousandth.
#[test]
fn what_is_free_beside_a_prescribed_spin_is_of_second_order() {
    let exact = wobbling(6400);
    let error = |steps: u64| {
        let off = wobbling(steps) * exact.conjugate();
        2.0 * dvec3(off.x, off.y, off.z).length()
    };
    let (coarse, fine) = (error(200), error(400));
    assert!(fine > 1e-9, "{fine}: too small to tell");
    let ratio = coarse / fine;
    assert!((3.7..4.3).contains(&ratio), "{coarse:e}, {fine:e}: {ratio}");
}
