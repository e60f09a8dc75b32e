//! A fine grain in the groove of two coarse ones.

use anyhow::Result;

use super::stage::Stage;
use super::{Check, Found, Length};

/// When (s) the grain is below the beads, of 0.3 s; infinite if it is not.
fn falls(sets: &[&str]) -> Result<(f64, u64)> {
    let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    let mut stage = Stage::open("three-beads", &sets)?;
    let part = (2e-3 / stage.time_step()).round() as u64;
    for k in 1..=150u32 {
        stage.go(part)?;
        if stage.particle(0).position.z < -0.01 {
            return Ok((f64::from(k) * 2e-3, u64::from(k) * part));
        }
    }
    Ok((f64::INFINITY, 150 * part))
}

pub(super) fn groove(_: Length) -> Result<Found> {
    let (coarse, steps) = falls(&[])?;
    let (automatic, more) = falls(&["time.step=2.5e-7"])?;
    let check = |name: &str, time| {
        let source = "it rolls off within 0.15 s (LAMMPS with synchronised velocities: 0.145 s) and falls by 11 mm within 0.05 s more";
        Check::at_most(name, 0.2, time, source)
    };
    Ok(Found {
        checks: vec![
            check(
                "time to the fall at a step of a 13th of the contact (s)",
                coarse,
            ),
            check("time to the fall at the automatic step (s)", automatic),
        ],
        particles: 3,
        steps: steps + more,
        notes: Vec::new(),
    })
}
