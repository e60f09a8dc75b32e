//! The setting of a run's boundaries, beside the insertions and deletions.

use super::Space;
use crate::bodies::Clump;
use crate::cell::Cell;
use crate::state::Material;

/// Where insertions and deletions take place.
#[derive(Debug, Clone, Copy)]
pub struct BoundaryContext<'a> {
    /// The present cell.
    pub cell: &'a Cell,
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

impl<'a> BoundaryContext<'a> {
    /// The space that regions lie in.
    pub fn space(&self) -> Space<'a> {
        Space {
            cell: self.cell,
            dimensions: self.dimensions,
        }
    }
}
