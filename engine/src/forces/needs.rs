//! Needs of contacts and parts in the step, and a new candidate list as they receive it.

use super::NearWall;
use crate::neighbours::CandidateList;
use crate::state::{Particles, Row};

/// Needs of a part in the step: only these decide how the step is made.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Needs {
    /// Largest gap between the surfaces of two particles, or of a particle and a wall, across which it acts, m. Pairs are listed
    /// that much farther out.
    pub range: f64,
    /// It reads the orientations of both particles, so they are integrated.
    pub orientations: bool,
    /// It adds loads once those of the contacts are known, so the kick has to wait for it.
    pub after_contacts: bool,
    /// It needs masses, or velocities at the time of the forces, so the kick has to wait for it.
    pub whole_steps: bool,
    /// It needs the sums of what contacts did in every step.
    pub sums: bool,
    /// It reads the events of contacts and the memory that their laws share.
    pub events: bool,
    /// It may change the surfaces of walls, so it runs before the lists are checked, and what it changes is refitted.
    pub reshapes_walls: bool,
    /// It looks for walls, so the mesh of a sheet follows its vertices in every step, not only where particles are near.
    pub all_walls: bool,
}

impl Needs {
    /// Needs of two together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            range: self.range.max(other.range),
            orientations: self.orientations || other.orientations,
            after_contacts: self.after_contacts || other.after_contacts,
            whole_steps: self.whole_steps || other.whole_steps,
            sums: self.sums || other.sums,
            events: self.events || other.events,
            reshapes_walls: self.reshapes_walls || other.reshapes_walls,
            all_walls: self.all_walls || other.all_walls,
        }
    }
}

/// A new candidate list, as a part receives it.
pub struct NewList<'a> {
    /// Particles in their new order.
    pub particles: &'a Particles,
    /// All pairs closer than their radii, the skin, and the range of the forces between their materials or of a part that reaches farther.
    pub pairs: &'a CandidateList,
    /// All particles that are near a wall by the same measure.
    pub near_walls: &'a [NearWall],
    /// Where each row of the last list went, `None` for rows that were removed.
    pub new_row: &'a [Option<Row>],
    /// The list was made with the threads of the pool from which this is called.
    pub parallel: bool,
}
