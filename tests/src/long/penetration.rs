//! A steel sphere is shot into a bed of 25,000 spheres.

use anyhow::{Context, Result, ensure};

use super::outcome;
use super::runs::{Run, numbers};
use crate::cases::Outcome;

/// Height of the intruder by LIGGGHTS; the file says how it was made.
const LIGGGHTS: &str = include_str!("penetration-25k.liggghts.csv");
/// End of the run, s: after the impact at 0.0207 s, the dive, and the rebound from the floor. The scene's is 0.1 s.
pub(super) const END: f64 = 0.045;
/// Until when heights are compared, s: the floor is met. What bounces the intruder back is a handful of beads crushed between it and the floor:
/// from there on the path is chaotic (see the page).
const COMPARED: f64 = 0.03;

/// What the run gave.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Found {
    pub(super) checks: Vec<Outcome>,
    /// Particles and steps.
    pub(super) size: (u64, u64),
    /// Time (s) and height (m) of the intruder in our run.
    pub(super) ours: Vec<[f64; 2]>,
    /// The same by LIGGGHTS.
    pub(super) theirs: Vec<[f64; 2]>,
}

/// Reads the run and compares.
pub(super) fn evaluate(run: &Run) -> Result<Found> {
    let ours = run.table("track.csv", ["time", "z"])?;
    let theirs = numbers(LIGGGHTS, ["time_s", "height_m"])?;
    let mut worst = 0.0f64;
    for &[time, height] in theirs.iter().filter(|row| row[0] < COMPARED + 1e-9) {
        let here = at(&ours, time).context("the run has no such time")?;
        worst = worst.max((here - height).abs());
    }
    ensure!(at(&theirs, END).is_some(), "LIGGGHTS' table is short");
    let rebound = |rows: &[[f64; 2]]| {
        let [early, late] = [0.04, END].map(|time| at(rows, time));
        // The speed in the middle of a flight.
        Some((late? - early?) / (END - 0.04))
    };
    let rebound = |rows| rebound(rows).context("a table is short");
    let (back, back_there) = (rebound(&ours)?, rebound(&theirs)?);
    let free = at(&ours, 0.02).context("the run is short")?;
    Ok(Found {
        checks: vec![
            outcome(
                "penetration-25k: height of the intruder just before the impact (m)",
                // 0.06 - 5 t - g t^2/2 at 0.02 s.
                0.06 - 5.0 * 0.02 - 0.5 * 9.81 * 0.02 * 0.02,
                free,
                1e-9,
                "free fall",
            ),
            outcome(
                "penetration-25k: height of the intruder until it meets the floor at 0.03 s, largest difference (mm)",
                0.0,
                1e3 * worst,
                1.0,
                "LIGGGHTS 3.8, same particles, mesh, law and step (`benches/penetration.py`)",
            ),
            outcome(
                "penetration-25k: speed of the intruder at 0.0425 s, thrown back by the floor (m/s)",
                back_there,
                back,
                // Shifts of the start by 1e-9 and 1e-6 m give 1.74 to 2.17 m/s: half of that range.
                0.2,
                "LIGGGHTS 3.8; the scatter of a chaotic rebound",
            ),
        ],
        size: (run.particles, run.steps),
        ours,
        theirs,
    })
}

/// The height at a time (s).
pub(super) fn at(rows: &[[f64; 2]], time: f64) -> Option<f64> {
    let row = rows.iter().find(|row| (row[0] - time).abs() < 1e-7)?;
    Some(row[1])
}

impl Found {
    /// Time (s) and height (m) of the lowest point that was written.
    pub(super) fn lowest(&self) -> [f64; 2] {
        let rows = self.ours.iter().copied();
        rows.min_by(|a, b| a[1].total_cmp(&b[1]))
            .unwrap_or([f64::NAN; 2])
    }

    /// Time (s) and height (m) at the end.
    pub(super) fn last(&self) -> [f64; 2] {
        self.ours.last().copied().unwrap_or([f64::NAN; 2])
    }
}
