//! Time steps up to what the plan lets pass, in a crystal that bears half of it.

use anyhow::{Context, Result};
use mercury_engine::step::RunError;

use super::stage::{Stage, complaint, planned};
use super::{Check, Found, Length};

/// Sound steps: parts of the critical step of a pair.
const SOUND: [f64; 6] = [0.001, 0.01, 0.1, 0.2, 0.3, 0.45];
/// Beyond what the crystal bears.
const UNSOUND: [f64; 4] = [0.55, 0.6, 0.75, 0.9];

/// A face-centred crystal of springs k has modes up to 8 k/m, a pair 2 k/m; the prestress of a compression δ/d takes δ/(d - δ) of it. So the limit is at this part of the critical step of a
/// pair (Hairer et al. 2006, section I.5: Δt < 2/ω).
fn bearable() -> f64 {
    let (distance, diameter) = (2.8e-3 / 2f64.sqrt(), 2e-3);
    0.5 / (1.0 - (diameter - distance) / distance).sqrt()
}

pub(super) fn crystal(length: Length) -> Result<Found> {
    let plan = planned("time-steps", &[]).map_err(|errors| anyhow::anyhow!("{errors}"))?;
    let critical = plan
        .notes()
        .step()
        .critical
        .clone()
        .context("a pair can meet")?
        .time;
    let mut found = Found::default();
    let step = |part: f64| {
        vec![
            format!("time.step={:e}", part * critical),
            format!("time.end={:e}", 1e7 * part * critical),
            format!("output.interval={:e}", 1e6 * part * critical),
        ]
    };
    for part in SOUND {
        let mut stage = Stage::open("time-steps", &step(part))?;
        let grains = stage.len();
        // All steps that a sound wave needs to cross the box several times, and more.
        let steps = length.pick(2_000, 200_000);
        let at_rest = lattice_energy(grains);
        let before = stage.energies().total() - at_rest;
        let (mut least, mut most) = (f64::INFINITY, 0.0f64);
        const LOOKS: u64 = 100;
        for _ in 0..LOOKS {
            stage.go(steps / LOOKS)?;
            let now = (stage.energies().total() - at_rest) / before;
            (least, most) = (least.min(now), most.max(now));
        }
        // Leapfrog keeps K + (1 - x) U of each mode, x = (ω Δt/2)² ≤ (part/bearable)²: K + U lies within a factor 1/(1 - x) either way. The energy of the
        // crystal at rest is subtracted with its round-off.
        let x = (part / bearable()).powi(2);
        let slack = 1e-4 + 4.0 * f64::EPSILON * at_rest / before * (steps as f64).sqrt();
        let range = [
            (1.0 - x) * (1.0 - slack) - ANHARMONIC,
            (1.0 + slack) / (1.0 - x) + ANHARMONIC,
        ];
        for (what, measured) in [("least", least), ("largest", most)] {
            found.checks.push(Check::within(
                format!("{part} of the critical step: {what} energy of the disturbance over that of the start"),
                range,
                measured,
                SOURCE,
            ));
        }
        found.steps += steps;
        found.particles = grains;
    }
    for part in UNSOUND {
        let mut stage = Stage::open("time-steps", &step(part))?;
        let most = 1_000_000;
        let mut outcome = Ok(());
        while outcome.is_ok() && stage.engine.steps() < most {
            outcome = stage.go(1000);
        }
        let message = match &outcome {
            Ok(()) => format!("still running after {most} steps"),
            Err(error) => error.to_string(),
        };
        found.steps += stage.engine.steps();
        let mut check = Check::says(
            format!(
                "{part} of the critical step: the guard stops the run and names the particle, place and time, and says what to do"
            ),
            &["step ", "particle ", "(", " m/s", "help: "],
            &message,
            "the fastest mode of the crystal grows; contacts become deeper or speeds larger until a limit is passed",
        );
        check.holds &= matches!(outcome, Err(RunError::Guarded { .. })) && stage.is_finite();
        found.checks.push(check);
        let warned = complaint("time-steps", &step(part));
        found.checks.push(Check::says(
            format!("{part} of the critical step: the plan warns"),
            &[
                "taken; warnings",
                "of the shortest contact",
                "1/50 is usual",
            ],
            &warned,
            "above 0.2 of a collision, which is 0.31 of the critical step",
        ));
    }
    for part in [0.95, 1.0, 10.0] {
        found.checks.push(Check::says(
            format!("{part} of the critical step: refused"),
            &[
                "nothing was run",
                "time.step",
                "above 0.9 of the critical step",
                "help: ",
            ],
            &complaint("time-steps", &step(part)),
            "`docs/theory/time-integration.md`",
        ));
    }
    Ok(found)
}

const SOURCE: &str = "leapfrog keeps K + (1 - (ω Δt/2)²) U of each mode; the fastest mode of the crystal has twice the ω of a pair";

/// The disturbance is a hundredth of the compression: cubic terms of the energy are of that order of it.
const ANHARMONIC: f64 = 0.02;

/// Energy of the springs of the undisturbed crystal, J: six for each sphere.
fn lattice_energy(grains: usize) -> f64 {
    let overlap = 2e-3 - 2.8e-3 / 2f64.sqrt();
    6.0 * grains as f64 * 0.5 * 1e4 * overlap * overlap
}
