//! A million radians a second.

use anyhow::Result;
use glam::{DQuat, DVec3};
use mercury_engine::step::RunError;

use super::stage::{Stage, ulp};
use super::{Check, Found, Length};

pub(super) fn spheres(length: Length) -> Result<Found> {
    let steps = length.pick(20_000, 1_000_000);
    let mut stage = Stage::open("spin", &[])?;
    let dt = stage.time_step();
    stage.go(steps)?;
    let time = steps as f64 * dt;
    let (friction, gravity, radius) = (0.3, 9.81, 1e-3);
    let slides = stage.particle(0);
    // The weight makes an overlap of 1e-8 m, of which a place has ulp(R); the spring of friction reaches its limit within the first steps.
    let overlap = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 1e-9 * gravity / 1e4;
    let error = 4.0 * ulp(radius) / overlap + ulp(1.0) * steps as f64 + 2.0 / steps as f64;
    // The lever is R less the overlap or half of it.
    let lever = overlap / radius;
    let row = crate::scenes::row(&stage.engine, 1);
    let turned = stage
        .engine
        .particles
        .orientations
        .as_ref()
        .map_or(DQuat::IDENTITY, |all| all[row]);
    // One radian a step about (0.6, 0, 0.8).
    let half = 0.5 * 1e6 * dt * steps as f64;
    let (sine, cosine) = half.sin_cos();
    let wanted = DQuat::from_xyzw(0.6 * sine, 0.0, 0.8 * sine, cosine);
    let away = (turned - wanted).length().min((turned + wanted).length());
    let spin = stage.particle(1).angular_velocity;
    Ok(Found {
        checks: vec![
            Check::within(
                "sliding: speed over μ g t",
                [1.0 - error, 1.0 + error],
                slides.velocity.x / (friction * gravity * time),
                "Coulomb; the force does not know of the spin. Overlap and velocities rounded, two steps to load the spring",
            ),
            Check::within(
                "sliding: loss of spin over 5/2 μ g t/R",
                [1.0 - error - lever, 1.0 + error + lever],
                (1e6 - slides.angular_velocity.y) / (2.5 * friction * gravity * time / radius),
                "the same force at the lever R, less an overlap at most",
            ),
            Check::at_most(
                "sliding: way to the side and of the height (m)",
                overlap,
                slides
                    .position
                    .y
                    .abs()
                    .max((slides.position.z - radius + overlap).abs()),
                "nothing pushes it there; overlap of the balance",
            ),
            Check::at_most(
                "falling: orientation, distance to the exact quaternion",
                // Each product of quaternions rounds by a few ε, and so does each angle.
                4.0 * ulp(1.0) * steps as f64,
                away,
                "exp(ω Δt/2) is exact for constant ω, at one radian a step too; a few ε for each product",
            ),
            Check::at_most(
                "falling: change of the spin (rad/s)",
                0.0,
                (spin - DVec3::new(6e5, 0.0, 8e5)).length(),
                "no torque",
            ),
        ],
        particles: 2,
        steps,
        notes: Vec::new(),
    })
}

pub(super) fn clump(length: Length) -> Result<Found> {
    let steps = length.pick(20_000, 1_000_000);
    let mut stage = Stage::open("spin-clump", &[])?;
    let state = |stage: &Stage| {
        let bodies = stage.engine.particles.bodies();
        let body = &bodies[0];
        (
            body.angular_momentum,
            body.rotational_energy(),
            body.orientation.length(),
        )
    };
    let (momentum, energy, _) = state(&stage);
    let (mut lowest, mut highest) = (energy, energy);
    const LOOKS: u64 = 100;
    for _ in 0..LOOKS {
        stage.go(steps / LOOKS)?;
        let now = state(&stage).1;
        (lowest, highest) = (lowest.min(now), highest.max(now));
    }
    let (after, _, length_of_turn) = state(&stage);
    let angle = 1e6 * stage.time_step();
    let mut fast = Stage::open("spin-clump", &["time.step=1e-6".to_owned()])?;
    let outcome = fast.go(1000);
    let message = outcome
        .as_ref()
        .err()
        .map_or("nothing".to_owned(), ToString::to_string);
    let mut caught = Check::says(
        "one radian a step: the guard stops the run and names the particle, place and time, and says what to do",
        &[
            "step ",
            "particle ",
            "of its radius in one step",
            "guard.way = 0.5",
            "help: ",
        ],
        &message,
        "an end of the rod, two radii from the centre, moves by two radii",
    );
    caught.holds &= matches!(outcome, Err(RunError::Guarded { .. }));
    Ok(Found {
        checks: vec![
            Check::at_most(
                "relative change of the angular momentum",
                0.0,
                (after - momentum).length() / momentum.length(),
                "no torque: the scheme keeps it as it is (`docs/theory/rigid-bodies.md`)",
            ),
            Check::within(
                "rotational energy over that of the start, least and largest: spread",
                // Second order: (ω Δt)²/4 of each of two splittings.
                [0.0, 0.5 * angle * angle],
                (highest - lowest) / energy,
                "reversible scheme of second order: it swings within (ω Δt)²/2 and does not drift",
            ),
            Check::at_most(
                "length of its quaternion, less 1",
                8.0 * ulp(1.0),
                length_of_turn - 1.0,
                "normalised in each step",
            ),
            caught,
        ],
        particles: 1,
        steps,
        notes: Vec::new(),
    })
}
