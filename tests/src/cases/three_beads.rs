//! A grain rolls off two beads (Vyas et al. 2025): the time that it takes, in closed form.

use super::Case;
use super::Tolerance::Relative;
use crate::three_beads::{Beads, Groove};

/// Degrees from the top at which the time is taken: before friction gives way.
const ANGLE: f64 = 45.0;

/// Rows of grains that roll without sliding.
pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (beads, name) in [
        (Beads::Particles, "fixed particles"),
        (Beads::Walls(0.0), "spheres as walls"),
        (Beads::Pebbles(0.0), "pebbles of a clump"),
    ] {
        for (ratio, friction, steps) in [(8.0, 1.0, 12.5), (20.0, 0.5, 12.5), (20.0, 0.5, 50.0)] {
            let groove = Groove::new(beads, ratio, friction, steps);
            cases.push(Case::new(
                format!(
                    "Three beads engine: {name}, {ratio} times as large, mu = {friction}, step a {steps}th of the contact: time to {ANGLE} degrees (s)"
                ),
                groove.rolling_time(ANGLE),
                // The time grows with ln(angle/angle at the start). At the start, 1 degree off, the spring of friction takes up its load over some 1e-3 of
                // that way, and the grain is looked at every 2e-4 s of at least 0.08 s.
                Relative(5e-3),
                "rolling without sliding on a track of the contact points' distance from the axis: m g rho (1 - cos) = m v^2 K/2, K = 1 + 2/5 (r/track)^2",
                move || groove.time_to(ANGLE).unwrap_or(f64::NAN),
            ));
        }
    }
    cases
}
