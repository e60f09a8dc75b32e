//! `[sleeping]`: defaults, and what is refused.

use super::*;
use mercury_engine::sleeping::Sleeping;

const ON: &str = "sleeping={}";
const GRAVITY: &str = "gravity=[0, 0, -10]";

/// Spheres of 0.2 m under 10 m/s^2: sqrt(g d) = sqrt(2) m/s, sqrt(d/g) = 0.02^(1/2) s.
#[test]
fn defaults_follow_from_gravity_and_the_smallest_diameter() {
    let text = format!(
        "{HEAD}{BALL}{}{}",
        particle("ball", 0.1, [0.0; 3], ""),
        particle("ball", 0.2, [0.5, 0.0, 0.0], "")
    );
    let dt = 2e-4;
    let plan_of = |more: &[&str]| {
        let overrides = [&[ON, GRAVITY, "time.step=2e-4"], more].concat();
        planned_with(&text, &overrides).unwrap()
    };
    let plan = plan_of(&[]);
    let expected = Sleeping {
        every: (0.5 * 0.02f64.sqrt() / dt).round() as u64,
        speed: 1e-3 * 2f64.sqrt(),
        imbalance: 0.1,
    };
    let found = plan.physics().sleeping().unwrap();
    assert_eq!(found.every, expected.every);
    close(found.speed, expected.speed, 1e-12);
    assert_eq!(found.imbalance, expected.imbalance);
    let reported = |note: &String| {
        note.starts_with("sleeping: checked every 354 steps (0.0707107 s = 0.5 sqrt(d/g))")
    };
    assert!(
        plan.notes().remarks().iter().any(reported),
        "{:?}",
        plan.notes().remarks()
    );
    let plan = plan_of(&[
        "sleeping.after=0.5",
        "sleeping.speed=0.01",
        "sleeping.imbalance=0.3",
    ]);
    let typed = Sleeping {
        every: 2500,
        speed: 0.01,
        imbalance: 0.3,
    };
    assert_eq!(plan.physics().sleeping(), Some(typed));
    assert!(
        planned_with(&text, &[GRAVITY])
            .unwrap()
            .physics()
            .sleeping()
            .is_none()
    );
}

#[test]
fn what_cannot_be_judged_is_refused() {
    let ball = BALL.to_owned() + &two("ball", 0.1);
    assert_eq!(
        complaints_with(&ball, &[ON]),
        [
            "sleeping: whether a particle is in balance is judged by its weight, and gravity is 0 | \
          leave [sleeping] out: without gravity no particle can sleep"
        ]
    );
    assert_eq!(
        complaints_with(&ball, &["sleeping.imbalance=1", GRAVITY]),
        [
            "sleeping.imbalance: 1 times its weight: a particle in free fall is not further out of balance | \
          a number above 0 and below 1, as 0.1"
        ]
    );
    assert_eq!(
        complaints_with(&ball, &["sleeping.after=1e-3", GRAVITY, "time.step=2e-4"]),
        [
            "sleeping.after: 0.001 s between two checks are 5 time steps of 0.0002 s: too few to detect rest | \
          sleeping.after of 10 steps at least"
        ]
    );
}
