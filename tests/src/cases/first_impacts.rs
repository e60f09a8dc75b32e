//! T21: head-on impacts of Chung & Ooi (2011), tests 1 to 3, with their time steps.

use mercury_engine::contact::normal::hertz_damping;
use mercury_engine::contact::{AnyNormal, Hertz};
use mercury_engine::state::volume;

use super::Case;
use super::Tolerance::{Absolute, Relative};
use super::collision::{Collision, HeadOn, lag};
use super::impact::RIGID;
use crate::closed_forms::{effective_modulus, hertz_contact_time, hertz_largest_overlap};

/// A sphere of the tests: radius, density, elasticity, approach speed, time step.
struct Ball {
    radius: f64,
    density: f64,
    elasticity: (f64, f64),
    speed: f64,
    step: f64,
}

impl Ball {
    fn mass(&self) -> f64 {
        self.density * volume(self.radius, 3)
    }

    /// Against an equal one.
    fn pair(&self) -> HeadOn {
        let modulus = effective_modulus(self.elasticity, self.elasticity);
        HeadOn::equal(
            AnyNormal::Hertz(Hertz::new(modulus, 0.0)),
            self.radius,
            self.mass(),
            self.speed,
            self.step,
        )
    }

    /// Against a rigid plane.
    fn wall(&self, damping: f64) -> HeadOn {
        let modulus = effective_modulus(self.elasticity, RIGID);
        HeadOn::equal(
            AnyNormal::Hertz(Hertz::new(modulus, damping)),
            self.radius,
            self.mass(),
            self.speed,
            self.step,
        )
        .on_wall()
    }
}

/// Test 1; the second material is quoted second-hand.
const TEST_1: [(&str, Ball); 2] = [
    (
        "R 10 mm, E 20 GPa",
        Ball {
            radius: 0.01,
            density: 2500.0,
            elasticity: (2e10, 0.25),
            speed: 20.0,
            step: 6.4e-8,
        },
    ),
    (
        "R 10 mm, E 48 GPa",
        Ball {
            radius: 0.01,
            density: 2800.0,
            elasticity: (4.8e10, 0.2),
            speed: 20.0,
            step: 6.4e-8,
        },
    ),
];

const TEST_2: Ball = Ball {
    radius: 0.1,
    density: 1800.0,
    elasticity: (4e10, 0.35),
    speed: 0.2,
    step: 3e-7,
};

const TEST_3: Ball = Ball {
    radius: 0.0025,
    density: 4000.0,
    elasticity: (3.8e11, 0.23),
    speed: 3.9,
    step: 8.1e-9,
};

/// Rows of T21.
pub(super) fn cases() -> Vec<Case> {
    let mut cases = elastic();
    cases.extend(restitution());
    cases
}

fn elastic() -> Vec<Case> {
    const CURVE: &str = "Chung & Ooi 2011 as shipped with Kratos, and its limit of 1 %";
    const THEORY: &str = "Hertz 1882";
    let mut cases = vec![
        Case::new(
            "T21 engine: test 1, largest force, R 10 mm, E 20 GPa (N)",
            7108.0,
            Relative(0.01),
            CURVE,
            || TEST_1[0].1.pair().run().largest_force,
        ),
        Case::new(
            "T21 engine: test 2, largest force on a rigid plane (N)",
            7233.0,
            Relative(0.01),
            CURVE,
            || TEST_2.wall(0.0).run().largest_force,
        ),
    ];
    for (name, ball) in TEST_1 {
        let modulus = effective_modulus(ball.elasticity, ball.elasticity);
        let (mass, radius) = (0.5 * ball.mass(), 0.5 * ball.radius);
        let deepest = hertz_largest_overlap(modulus, mass, radius, ball.speed);
        let time = hertz_contact_time(modulus, mass, radius, ball.speed);
        // No dashpot: what is left of this is the integrator, of second order.
        let near = Relative(lag(0.0, time / ball.step));
        let head_on = ball.pair();
        let mut row = |what: &str, expected, pick: fn(Collision) -> f64| {
            cases.push(Case::new(
                format!("T21 engine: test 1, {name}: {what}"),
                expected,
                near,
                THEORY,
                move || pick(head_on.run()),
            ));
        };
        row("largest overlap (m)", deepest, |c| c.largest_overlap);
        row("duration (s)", time, |c| c.duration);
        row(
            "largest force (N)",
            4.0 / 3.0 * modulus * radius.sqrt() * deepest.powf(1.5),
            |c| c.largest_force,
        );
    }
    cases
}

fn restitution() -> Vec<Case> {
    const LIMIT: &str = "the given restitution; Kratos' limit of 1 %";
    let mut cases: Vec<Case> = [0.2, 0.4, 0.6, 0.8, 1.0]
        .map(|e| {
            let head_on = TEST_3.wall(hertz_damping(e));
            Case::new(
                format!("T21 engine: test 3, restitution {e}"),
                e,
                Relative(0.01),
                LIMIT,
                move || head_on.run().restitution,
            )
        })
        .into();
    // Critically damped: it creeps out of the contact for ever. In y = overlap^(5/4) and a time that runs with overlap^(1/4) it is
    // y = v s exp(-w s), whose speed is never above exp(-2) of the first one on the way out, and falls with the overlap.
    let stopped = TEST_3.wall(hertz_damping(0.0));
    let modulus = effective_modulus(TEST_3.elasticity, RIGID);
    let time = hertz_contact_time(modulus, TEST_3.mass(), TEST_3.radius, TEST_3.speed);
    let steps = (20.0 * time / TEST_3.step) as u64;
    cases.push(Case::new(
        "T21 engine: test 3, restitution 0: speed after 20 elastic contact times over that before",
        0.0,
        Absolute(0.01),
        LIMIT,
        move || stopped.speed_after(steps) / stopped.speed,
    ));
    cases
}
