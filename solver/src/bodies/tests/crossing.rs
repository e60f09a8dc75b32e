//! A body crosses periodic faces: it must not notice.

use std::sync::Arc;

use glam::{DVec3, dvec3};

use super::t_bar;
use crate::contact::registry::AnyPairLaw;
use crate::contact::{AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, Linear};
use crate::plan::{Draft, NewBody};
use crate::state::Body;
use crate::step::Engine;

fn law() -> AnyPairLaw {
    AnyPairLaw {
        normal: AnyNormal::Linear(Linear::new(1e4, 0.0)),
        tangential: AnyTangential::None,
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    }
}

/// The T-bar after 1 s in a box of 8 m, periodic or far from every face.
fn after_a_second(periodic: bool, velocity: DVec3) -> Body {
    let half = if periodic { 4.0 } else { 1000.0 };
    let mut plan = Draft::new(1e-3, (DVec3::splat(-half), DVec3::splat(half)), 1.0, law());
    plan.periodic = [periodic; 3];
    let bar = NewBody {
        velocity,
        angular_velocity: dvec3(0.0, 20.0, 0.01),
        ..NewBody::at(DVec3::ZERO, 0)
    };
    let mut engine = Engine::new(
        Arc::new(plan.with_bodies(vec![t_bar()], vec![bar]).plan().unwrap()),
        1,
    )
    .unwrap();
    engine.steps_at_once(1000, None).unwrap();
    engine.complete_step().unwrap();
    let bodies = engine.particles.bodies.as_ref().unwrap();
    let body = bodies.all[0];
    for pebble in &bodies.pebbles {
        // Rows stand whole periods off where the body has them, and none is farther out than the skin lets it.
        let record = &engine.particles.records[pebble.row.index()];
        let placed = body.position + body.orientation * pebble.offset;
        let apart = (record.position - placed - pebble.shift).length();
        assert!(apart < 1e-12, "{apart:e}");
        if periodic {
            let periods = pebble.shift / 8.0;
            assert_eq!(periods, periods.round());
            assert!(record.position.abs().max_element() < 4.0 + 0.5);
        }
    }
    body
}

#[test]
fn a_body_that_crosses_faces_stays_a_free_rotor() {
    let velocity = dvec3(8.0, -3.0, 5.0);
    let free = after_a_second(false, velocity);
    let crossing = after_a_second(true, velocity);
    // Rotation and velocity know nothing of positions: the same bits.
    assert_eq!(crossing.orientation, free.orientation);
    assert_eq!(crossing.velocity, velocity);
    assert_eq!(crossing.angular_momentum, free.angular_momentum);
    let apart = free.position - crossing.position;
    let periods = apart / 8.0;
    assert!((periods - periods.round()).length() < 1e-13, "{periods}");
    assert!(periods.length() > 0.5, "it has crossed faces");
    // The angular velocity of the reference (tests::rotor), in the global frame, at this step.
    let reference = dvec3(-0.287_582_95, 19.999_812_46, 0.286_081_07);
    assert!((crossing.angular_velocity - reference).length() < 1e-3);
}
