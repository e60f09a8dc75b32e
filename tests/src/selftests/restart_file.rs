//! The few lines of MercuryDPM's restart files that comparisons need.

use std::path::Path;

use anyhow::{Context, Result};
use glam::DVec3;

/// A particle of a restart file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RestartParticle {
    /// Centre, m.
    pub(super) position: DVec3,
    /// Velocity, m/s.
    pub(super) velocity: DVec3,
    /// Force, N.
    pub(super) force: DVec3,
}

/// A contact of a restart file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RestartContact {
    /// The two ids; for walls that of the particle and that of the wall.
    pub(super) ids: (u32, u32),
    /// Whether the second id is a wall's.
    pub(super) with_wall: bool,
    /// Overlap, m.
    pub(super) overlap: f64,
    /// Force on the first, N.
    pub(super) force: DVec3,
    /// Largest overlap so far, m, where the law has one.
    pub(super) max_overlap: Option<f64>,
}

/// The state that a restart file holds.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct RestartState {
    /// In the order of the file.
    pub(super) particles: Vec<RestartParticle>,
    /// In the order of the file.
    pub(super) contacts: Vec<RestartContact>,
}

/// Reads the particles and contacts of a restart file.
pub(super) fn read(path: &Path) -> Result<RestartState> {
    let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
    let mut state = RestartState::default();
    for line in text.lines() {
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let numbers = |key: &str, count: usize| -> Result<Vec<f64>> {
            let at = words
                .iter()
                .position(|word| *word == key)
                .with_context(|| format!("{}: no {key} in {line:?}", path.display()))?;
            let found = words.get(at + 1..at + 1 + count).context("short line")?;
            found
                .iter()
                .map(|word| word.parse().with_context(|| (*word).to_owned()))
                .collect()
        };
        let vector = |key: &str| numbers(key, 3).map(|numbers| DVec3::from_slice(&numbers));
        let kind = words.first().copied().unwrap_or_default();
        if kind == "BaseParticle" {
            state.particles.push(RestartParticle {
                position: vector("position")?,
                velocity: vector("velocity")?,
                force: vector("force")?,
            });
        } else if kind.ends_with("Interaction") {
            let with_wall = words.contains(&"particleWallIds");
            let key = if with_wall {
                "particleWallIds"
            } else {
                "particleIds"
            };
            let ids = numbers(key, 2)?;
            state.contacts.push(RestartContact {
                ids: (ids[0] as u32, ids[1] as u32),
                with_wall,
                overlap: numbers("overlap", 1)?[0],
                force: vector("force")?,
                max_overlap: numbers("maxOverlap", 1).ok().map(|numbers| numbers[0]),
            });
        }
    }
    anyhow::ensure!(
        !state.particles.is_empty(),
        "{}: no particles",
        path.display()
    );
    Ok(state)
}
