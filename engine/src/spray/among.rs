//! The particles that droplets fly among, up to date where a droplet is looked at.

use std::collections::HashSet;

use glam::DVec3;

use super::grains::Grains;
use crate::cell::Cell;
use crate::ranks::Share;
use crate::state::Particles;

/// Particles in a step. Where several ranks divide them, each rank moves all droplets and gets the particles near them: droplets are the same on all
/// ranks, and so is what is brought.
pub struct Among<'a> {
    /// All particles.
    pub(super) particles: &'a mut Particles,
    ranks: Option<&'a mut Share>,
    /// Rows that have come in this step.
    brought: HashSet<u32>,
}

impl<'a> Among<'a> {
    /// Before the droplets of a step move.
    #[must_use]
    pub fn new(particles: &'a mut Particles, ranks: Option<&'a mut Share>) -> Self {
        Self {
            particles,
            ranks,
            brought: HashSet::new(),
        }
    }

    /// Brings all particles up to date.
    pub(super) fn bring_all(&mut self) {
        if let Some(ranks) = &mut self.ranks {
            ranks.complete(self.particles);
        }
    }

    /// Brings the particles up to date that may be within a reach (m) of some places, unless they have come before.
    pub(super) fn bring(
        &mut self,
        grains: &Grains,
        places: impl Iterator<Item = (DVec3, f64)>,
        domain: &Cell,
    ) {
        let Some(ranks) = &mut self.ranks else {
            return;
        };
        let mut missing = Vec::new();
        for (place, reach) in places {
            grains.near(place, reach, domain, |row, _| {
                if self.brought.insert(row as u32) {
                    missing.push(row as u32);
                }
            });
        }
        missing.sort_unstable();
        ranks.complete_some(&mut self.particles.records, &missing);
    }
}
