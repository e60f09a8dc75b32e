//! Order of convergence in the time step.

use glam::{DVec3, dvec3};
use mercury_solver::contact::registry::AnyPairLaw;
use mercury_solver::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, CoulombLimits, Hertz, Linear,
    LinearFriction, PairLaw, SpringRotation,
};
use mercury_solver::state::volume;
use mercury_tests::scenes::{advance, frictionless, particle, plan, plane, sphere, start};

/// Three spheres of unequal size in a sequence of contacts: the first hits the second, which hits the third and a plane.
fn sequence(law: AnyPairLaw, time: f64, steps: u64) -> Vec<DVec3> {
    let mut plan = plan(time / steps as f64, 2000.0, law);
    plan.walls
        .push(plane(dvec3(0.0, -0.06, 0.0), dvec3(0.1, 1.0, 0.0)));
    plan.gravity = dvec3(0.0, -9.81, 0.0);
    let at = |x: f64, y: f64, radius: f64, velocity: DVec3| {
        sphere(dvec3(x, y, 0.0), radius, velocity, dvec3(1.0, -2.0, 4.0))
    };
    let particles = vec![
        at(-0.105, 0.01, 0.05, dvec3(1.2, -0.1, 0.05)),
        at(0.0, 0.0, 0.05, DVec3::ZERO),
        at(0.083, -0.012, 0.03, dvec3(0.0, 0.1, 0.0)),
    ];
    let mut engine = start(plan.with_particles(particles));
    advance(&mut engine, steps);
    (0..3)
        .flat_map(|id| {
            let particle = particle(&engine, id);
            [
                particle.position,
                particle.velocity,
                particle.angular_velocity * 0.05,
            ]
        })
        .collect()
}

/// Slope of log(error) over log(dt) by least squares: the error oscillates with the phase in which a contact begins within its
/// step, so two time steps would not tell the order. The errors are those against a run with 16 times the finest resolution.
fn order(time: f64, run: impl Fn(f64, u64) -> Vec<DVec3>) -> f64 {
    let refinements = [1200u64, 1700, 2400, 3400, 4800, 6800, 9600, 13600, 19200];
    let exact = run(time, 16 * 19200);
    let points: Vec<(f64, f64)> = refinements
        .iter()
        .map(|&steps| {
            let seen = run(time, steps);
            let error: f64 = seen
                .iter()
                .zip(&exact)
                .map(|(a, b)| (*a - *b).length_squared())
                .sum::<f64>()
                .sqrt();
            ((time / steps as f64).ln(), error.ln())
        })
        .collect();
    let count = points.len() as f64;
    let (mean_x, mean_y) = points.iter().fold((0.0, 0.0), |(x, y), point| {
        (x + point.0 / count, y + point.1 / count)
    });
    let (above, below) = points.iter().fold((0.0, 0.0), |(above, below), (x, y)| {
        (
            above + (x - mean_x) * (y - mean_y),
            below + (x - mean_x) * (x - mean_x),
        )
    });
    above / below
}

/// A sphere that rests on a plane in its normal equilibrium and swings on its tangential spring, without slip.
fn swinging(time: f64, steps: u64) -> Vec<DVec3> {
    let (density, radius, stiffness, gravity) = (2000.0, 0.05, 1e5, 9.81);
    let law = sticking(Linear::new(stiffness, 0.0));
    let mut plan = plan(time / steps as f64, density, law);
    plan.walls.push(plane(DVec3::ZERO, DVec3::Z));
    plan.gravity = dvec3(0.0, 0.0, -gravity);
    let overlap = density * volume(radius, 3) * gravity / stiffness;
    let position = dvec3(0.0, 0.0, radius - overlap);
    let ball = sphere(
        position,
        radius,
        dvec3(0.1, -0.05, 0.0),
        dvec3(3.0, 1.0, 2.0),
    );
    let mut engine = start(plan.with_particles(vec![ball]));
    advance(&mut engine, steps);
    let ball = particle(&engine, 0);
    vec![ball.position, ball.velocity, ball.angular_velocity * radius]
}

/// Friction that holds whatever comes.
fn sticking(normal: Linear) -> AnyPairLaw {
    PairLaw {
        normal: AnyNormal::Linear(normal),
        tangential: AnyTangential::Linear(LinearFriction {
            stiffness: 2e4,
            dissipation: 0.0,
            friction: 1e3,
            static_friction: 1e3,
            rotation: SpringRotation::Project,
            limits: CoulombLimits::Bounded,
        }),
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    }
}

#[test]
fn is_two_for_elastic_contacts_that_come_and_go() {
    for normal in [
        AnyNormal::Linear(Linear::new(1e5, 0.0)),
        AnyNormal::Hertz(Hertz::new(3e6, 0.0)),
    ] {
        let order = order(0.06, |time, steps| {
            sequence(frictionless(normal), time, steps)
        });
        assert!((1.8..2.3).contains(&order), "{normal:?}: order {order}");
    }
}

#[test]
fn is_two_for_a_contact_that_sticks() {
    let order = order(0.06, swinging);
    assert!((1.9..2.1).contains(&order), "order {order}");
}

/// The dashpot sees the velocity of half a step earlier.
#[test]
fn is_one_or_better_with_damping() {
    for normal in [
        AnyNormal::Linear(Linear::with_damping_ratio(1e5, 0.1)),
        AnyNormal::Hertz(Hertz::new(3e6, 0.2)),
    ] {
        let order = order(0.06, |time, steps| {
            sequence(frictionless(normal), time, steps)
        });
        assert!((0.9..2.0).contains(&order), "{normal:?}: order {order}");
    }
}

/// A spring is stretched by the whole step in which the contact begins, though bodies touch for a part of it only.
#[test]
fn is_one_or_better_for_sticking_contacts_that_come_and_go() {
    let law = sticking(Linear::new(1e5, 0.0));
    let order = order(0.06, |time, steps| sequence(law, time, steps));
    assert!((0.9..2.0).contains(&order), "order {order}");
}
