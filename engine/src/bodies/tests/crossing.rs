//! A body crosses periodic faces: its motion must not change.

use glam::{DVec3, dvec3};

use super::t_bar;
use crate::bodies::NewBody;
use crate::contact::registry::AnyPairLaw;
use crate::contact::{AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, Linear};
use crate::physics::Inputs;
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

/// The T-bar after 1 s in a periodic box of this size (m), or far from every face, with its start in the middle.
fn after_a_second(middle: DVec3, period: Option<f64>, velocity: DVec3) -> Body {
    let half = DVec3::splat(period.map_or(1000.0, |period| 0.5 * period));
    let mut plan = Inputs::new(1e-3, (middle - half, middle + half), 1.0, law());
    plan.cell = plan.cell.with_periodic([period.is_some(); 3]);
    let bar = NewBody {
        velocity,
        angular_velocity: dvec3(0.0, 20.0, 0.01),
        ..NewBody::at(middle, 0)
    };
    let mut engine = Engine::new(
        plan.with_bodies(vec![t_bar()], vec![bar]).setup().unwrap(),
        1,
    )
    .unwrap();
    for _ in 0..100 {
        engine.steps_at_once(10, None).unwrap();
        rows_are_where_the_body_has_them(&engine, middle, period);
    }
    engine.complete_step().unwrap();
    engine.particles.bodies.as_ref().unwrap().all[0]
}

/// Rows are whole periods away from their bodies' places, and none is farther out than the skin permits.
fn rows_are_where_the_body_has_them(engine: &Engine, middle: DVec3, period: Option<f64>) {
    let bodies = engine.particles.bodies.as_ref().unwrap();
    let body = bodies.all[0];
    for pebble in &bodies.pebbles {
        let record = &engine.particles.records[pebble.row.index()];
        let placed = body.position + body.orientation * pebble.offset;
        let apart = (record.position - placed - pebble.shift).length();
        assert!(apart < 1e-12, "{apart:e}");
        if let Some(period) = period {
            let periods = pebble.shift / period;
            assert_eq!(periods, periods.round());
            assert!((record.position - middle).abs().max_element() < 0.5 * period + 0.5);
        }
    }
}

#[test]
fn a_body_that_crosses_faces_stays_a_free_rotor() {
    let velocity = dvec3(8.0, -3.0, 5.0);
    let free = after_a_second(DVec3::ZERO, None, velocity);
    // From zero on, where what is shifted by a period is rounded, too.
    for (middle, period) in [(DVec3::ZERO, 8.0), (DVec3::splat(3.65), 7.3)] {
        let crossing = after_a_second(middle, Some(period), velocity);
        // Rotation and velocity do not depend on positions: the same bits.
        assert_eq!(crossing.orientation, free.orientation);
        assert_eq!(crossing.velocity, velocity);
        assert_eq!(crossing.angular_momentum, free.angular_momentum);
        let periods = (free.position - (crossing.position - middle)) / period;
        // A rounding of the position in each of 1000 steps.
        let round_off = 1e-13 + 1000.0 * f64::EPSILON * middle.length() / period;
        assert!(
            (periods - periods.round()).length() < round_off,
            "{periods}"
        );
        assert!(periods.length() > 0.5, "it has crossed faces");
    }
    // The angular velocity of the reference (tests::rotor), in the global frame, at this step.
    let reference = dvec3(-0.287_582_95, 19.999_812_46, 0.286_081_07);
    assert!((free.angular_velocity - reference).length() < 1e-3);
}
