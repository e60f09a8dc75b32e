//! The setting of a run's boundaries, beside the insertions and deletions.

use glam::DVec3;

use super::Space;
use crate::bodies::Clump;
use crate::state::Material;

/// Where insertions and deletions take place: the same from the start of a run to its end.
#[derive(Debug, Clone, Copy)]
pub struct Setting<'a> {
    /// Lower and upper corner of the domain, m.
    pub domain: (DVec3, DVec3),
    /// Periodic axes.
    pub periodic: [bool; 3],
    /// 3, or 2 for discs.
    pub dimensions: u8,
    /// All materials.
    pub materials: &'a [Material],
    /// All clumps.
    pub clumps: &'a [Clump],
    /// Time step, s.
    pub time_step: f64,
    /// Seed of every random choice.
    pub seed: u64,
}

impl Setting<'_> {
    /// The space that regions lie in.
    pub fn space(&self) -> Space {
        Space {
            domain: self.domain,
            periodic: self.periodic,
            dimensions: self.dimensions,
        }
    }
}
