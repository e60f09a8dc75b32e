//! Momentum, angular momentum and energy of particles and sheets together.

use super::*;

#[test]
fn momentum_and_angular_momentum_are_kept_in_every_step() {
    for seed in 1..4 {
        let sheet = square(6, 0.12, 0.15, seed);
        let plan = Setup::default().plan(thrown(seed), vec![sheet]);
        let mut engine = Engine::new(plan, 1).unwrap();
        let first = momenta(&engine);
        let (mut contacts, mut couples) = (0, 0);
        for step in 0..600 {
            engine.step(Some(SEE)).unwrap();
            let seen = engine.take_observation();
            contacts += at_sheets(&seen);
            couples += (seen.records.iter())
                .filter(|record| record.couple != DVec3::ZERO)
                .count();
            let now = momenta(&engine);
            for (kind, (now, first)) in now.iter().zip(&first).enumerate() {
                let off = now.0.distance(first.0);
                let size = first.1.max(now.1);
                assert!(off < 1e-11 * size, "{step}, {kind}: {off:e} of {size:e}");
            }
        }
        assert!(contacts > 1000 && couples > 1000, "{contacts}, {couples}");
    }
}

/// Balls hit a sheet on a face, near an edge and near a corner: the largest error of the energy over the energy, until a contact ends.
fn error_of_bounce(step: f64, laws: &str, normal: &str, spot: usize) -> f64 {
    let setup = Setup {
        step,
        normal,
        laws,
        ..Setup::default()
    };
    let sheet = square(6, 0.12, 0.1, 7);
    let (triangle, weights): (usize, [f64; 3]) = [
        (10, [0.4, 0.3, 0.3]),
        (31, [0.5, 0.5, 0.0]),
        (60, [0.95, 0.03, 0.02]),
    ][spot];
    let corners = sheet.triangles[triangle].map(|k| sheet.vertices[k as usize]);
    let at: DVec3 = (0..3).map(|k| corners[k] * weights[k]).sum();
    let radius = 0.006;
    let thrown = ball(
        at + dvec3(0.0, 0.0, radius + 0.0004),
        radius,
        dvec3(0.2, -0.1, -1.0),
        dvec3(40.0, -60.0, 30.0),
    );
    let plan = setup.plan(vec![thrown], vec![sheet]);
    let mut engine = Engine::new(plan, 1).unwrap();
    let first = energy(&engine, &Observation::empty(0));
    let (mut most, mut contacts, mut touched) = (0.0f64, 0, false);
    for _ in 0..(5e-3 / step).round() as u32 {
        engine.step(Some(SEE)).unwrap();
        let seen = engine.take_observation();
        engine.complete_step().unwrap();
        let touching = at_sheets(&seen);
        // The energy of a friction spring is lost when its contact ends.
        if touched && touching == 0 && !laws.is_empty() {
            break;
        }
        touched = touching > 0;
        most = most.max((energy(&engine, &seen) - first).abs());
        contacts += touching;
    }
    assert!(contacts as f64 * step > 5e-4, "{contacts}");
    most / first
}

const STICKING: &str =
    r#"tangential = { law = "linear", stiffness_ratio = 0.2857, friction = 1e9 }"#;

/// The sheet bends around the ball: contacts come and go beside the first one, and nothing is lost with them.
#[test]
fn elastic_bounces_close_the_energy_with_order_two() {
    for spot in 0..3 {
        let errors = [4e-6, 2e-6, 1e-6].map(|step| error_of_bounce(step, "", LINEAR, spot));
        assert!(errors[0] < 1e-5, "{spot}: {errors:?}");
        // Begin and end of a contact fall somewhere within a step: one pair of steps proves little. At the corner forces turn at
        // once where contacts change their order.
        let order = (errors[0] / errors[2]).log2() / 2.0;
        let least = if spot == 2 { 1.2 } else { 1.7 };
        assert!(order > least, "{spot}: {errors:?}");
    }
}

/// With springs of friction that never slide: they begin to stretch within a step, which makes an error of first order.
#[test]
fn sticking_bounces_close_the_energy() {
    for spot in 0..3 {
        let errors = [4e-6, 1e-6].map(|step| error_of_bounce(step, STICKING, LINEAR, spot));
        assert!(
            errors.iter().all(|&error| error < 1e-3),
            "{spot}: {errors:?}"
        );
    }
}

/// With losses, the audit closes: what is lost is what kinetic and stored energy lack.
#[test]
fn the_audit_closes_with_losses() {
    let lacks = |step: f64| {
        let setup = Setup {
            step,
            output: "interval = 0.1, energy_budget = true",
            ..Setup::default()
        };
        let plan = setup.plan(thrown(3), vec![square(6, 0.12, 0.1, 3)]);
        let mut engine = Engine::new(plan, 1).unwrap();
        let seen = engine.take_observation();
        let start = energy(&engine, &seen);
        engine
            .steps_at_once((3e-3 / step).round() as u64, Some(SEE))
            .unwrap();
        let seen = engine.take_observation();
        engine.complete_step().unwrap();
        let audit = engine.audit();
        assert!(audit.losses.total() > 0.02 * start, "{audit:?}");
        assert!(audit.wall_work.abs() < 1e-12 * start, "{audit:?}");
        (energy(&engine, &seen) + audit.losses.total() - start).abs() / start
    };
    let [coarse, fine] = [lacks(4e-6), lacks(1e-6)];
    assert!(coarse < 2e-3 && fine < 1e-3, "{coarse:e}, {fine:e}");
}
