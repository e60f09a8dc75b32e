//! Bodies of which a part of the motion is prescribed: the rest is free.

use glam::{DMat3, DQuat, DVec3, dvec3};

use super::t_bar;
use crate::bodies::NewBody;
use crate::contact::registry::AnyPairLaw;
use crate::contact::{AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, Linear};
use crate::physics::Inputs;
use crate::state::Body;
use crate::step::Engine;

const GRAVITY: DVec3 = dvec3(0.3, -0.2, -9.81);

/// The T-bar after `steps` of `time_step` (s) under gravity.
fn after(steps: u64, time_step: f64, bar: NewBody) -> Body {
    let law = AnyPairLaw {
        normal: AnyNormal::Linear(Linear::new(1e4, 0.0)),
        tangential: AnyTangential::None,
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    };
    let domain = (DVec3::splat(-1e3), DVec3::splat(1e3));
    let mut plan = Inputs::new(time_step, domain, 1.0, law);
    plan.gravity = GRAVITY;
    let plan = plan.with_bodies(vec![t_bar()], vec![bar]);
    let mut engine = Engine::new(plan.setup().unwrap(), 1).unwrap();
    engine.steps_at_once(steps, None).unwrap();
    engine.complete_step().unwrap();
    engine.particles.bodies()[0]
}

/// Components that are not prescribed fall: x = v t + g t^2/2, which the integrator gives to round-off, and v + g t.
#[test]
fn what_is_not_prescribed_falls() {
    for (velocity, spin) in [
        ([Some(2.0), None, None], [None; 3]),
        ([None, Some(-1.0), None], [Some(3.0), None, None]),
        ([None; 3], [None, None, Some(-4.0)]),
    ] {
        let start = dvec3(1.0, 2.0, 3.0);
        let bar = NewBody {
            velocity: start,
            prescribed_velocity: velocity,
            prescribed_angular_velocity: spin,
            ..NewBody::at(DVec3::ZERO, 0)
        };
        let body = after(1000, 1e-3, bar);
        for axis in 0..3 {
            let (place, speed) = match velocity[axis] {
                Some(held) => (held, held),
                None => (
                    start[axis] + 0.5 * GRAVITY[axis],
                    start[axis] + GRAVITY[axis],
                ),
            };
            assert!((body.position[axis] - place).abs() < 1e-11, "{body:?}");
            assert!((body.velocity[axis] - speed).abs() < 1e-11, "{body:?}");
        }
    }
}

/// A spin that is prescribed about one axis leaves the angular momentum about the others alone, while the body turns under them: the midpoint
/// rule errs by the square of the step.
#[test]
fn a_prescribed_spin_is_turned_by_the_midpoint_rule() {
    let turned = |steps: u32| {
        let bar = NewBody {
            orientation: DQuat::from_rotation_y(0.5),
            angular_velocity: dvec3(1.0, 0.5, 6.0),
            prescribed_angular_velocity: [None, None, Some(6.0)],
            ..NewBody::at(DVec3::ZERO, 0)
        };
        let body = after(u64::from(steps), 1.0 / f64::from(steps), bar);
        assert_eq!(body.angular_velocity.z, 6.0);
        body.orientation
    };
    let finest = turned(16_000);
    let error = |steps: u32| turned(steps).angle_between(finest);
    let (coarse, fine) = (error(250), error(1000));
    // Sixteen times less with a fourth of the step; of first order it would be four times.
    assert!(
        coarse > 1e-6 && coarse / fine > 12.0,
        "{coarse:e}, {fine:e}"
    );
}

/// The angular momentum of a body whose spin is prescribed is that of its spin, as it stands: its energy is w I w / 2.
#[test]
fn the_energy_of_a_prescribed_spin_is_that_of_the_body_as_it_stands() {
    for held in [[None, None, Some(6.0)], [Some(0.0), Some(3.0), Some(6.0)]] {
        let bar = NewBody {
            orientation: DQuat::from_rotation_y(0.5),
            angular_velocity: dvec3(1.0, 0.5, 6.0),
            prescribed_angular_velocity: held,
            ..NewBody::at(DVec3::ZERO, 0)
        };
        let body = after(400, 1e-3, bar);
        let turned = DMat3::from_quat(body.orientation);
        let inertia = turned * DMat3::from_diagonal(body.moments) * turned.transpose();
        let energy = 0.5 * body.angular_velocity.dot(inertia * body.angular_velocity);
        let found = body.rotational_energy();
        assert!(
            (found / energy - 1.0).abs() < 1e-12,
            "{found} J, not {energy} J"
        );
    }
}
