//! Removal of particles: deletion regions, and the faces of the domain.

use glam::DVec3;

use super::passage::{Gate, Grain, OwnGrains};
use super::{BoundaryContext, DeletionPlan, Region};
use crate::cell::{Cell, NO_SHIFT};
use crate::state::{FIXED, PEBBLE, Particles};

/// Deletion regions and faces, and which particles may reach them soon.
///
/// Bodies leave as a whole, by their centre of mass; there are few of them, and each is tested in every step. Fixed particles are
/// part of the geometry, like walls: they are never removed.
#[derive(Debug, Clone)]
pub(super) struct Deletion {
    regions: Vec<Region>,
    /// Axes along which particles can leave: not periodic, and not the third of a two-dimensional scene.
    open: [bool; 3],
    /// Rows that may reach an exit before the next list, ascending; `None`: not known, so all may.
    near: Option<Vec<u32>>,
}

impl Deletion {
    pub(super) fn new(deletions: &[DeletionPlan], setting: &BoundaryContext<'_>) -> Self {
        let open =
            |axis: usize| !setting.cell.is_periodic(axis) && (axis < 2 || setting.dimensions == 3);
        Self {
            regions: deletions
                .iter()
                .map(|DeletionPlan { region, .. }| region.clone())
                .collect(),
            open: [open(0), open(1), open(2)],
            near: None,
        }
    }

    /// Clears the list of near rows, after rows have changed.
    pub(super) fn forget_near(&mut self) {
        self.near = None;
    }

    /// Collects the rows whose centre is within `margin` (m) of an exit.
    pub(super) fn listed(&mut self, particles: &Particles, cell: &Cell, margin: f64) {
        let codes: Vec<u32> = cell.images().collect();
        let ((low, high), (start, end)) = (cell.corners(), cell.faces());
        let mut near = self.near.take().unwrap_or_default();
        near.clear();
        for (row, record) in particles.records.iter().enumerate() {
            if particles.is_fixed(row) || particles.is_pebble(row) {
                continue;
            }
            let at_face = (0..3).any(|axis| {
                let x = record.position[axis];
                self.open[axis] && (x < low[axis] + margin || x > high[axis] - margin)
            });
            let reaches = |code: u32| {
                let position = record.position + cell.shift(code);
                // Only an image that may replace the particle itself: one that is about to cross a periodic face.
                let crosses = code == NO_SHIFT
                    || (0..3).all(|axis| {
                        cell.shift(code)[axis] == 0.0
                            || (position[axis] > start[axis] - margin
                                && position[axis] < end[axis] + margin)
                    });
                crosses
                    && self
                        .regions
                        .iter()
                        .any(|region| region.signed_distance(position) <= margin)
            };
            if at_face
                || (!self.regions.is_empty()
                    && (reaches(NO_SHIFT) || codes.iter().any(|&code| reaches(code))))
            {
                near.push(row as u32);
            }
        }
        self.near = Some(near);
    }

    /// The particles and bodies that have left, with their way: particles by ascending rows, then bodies.
    pub(super) fn find(
        &self,
        particles: &Particles,
        cell: &Cell,
        own: &OwnGrains,
    ) -> Vec<(Grain, Gate)> {
        let exit = |row: u32| {
            let record = &particles.records[row as usize];
            if record.flags & (FIXED | PEBBLE) != 0 || !own.has(Grain::Row(row)) {
                return None;
            }
            Some((Grain::Row(row), self.exit(record.position, cell)?))
        };
        let mut gone: Vec<_> = match &self.near {
            Some(near) => near.iter().filter_map(|&row| exit(row)).collect(),
            None => (0..particles.len() as u32).filter_map(exit).collect(),
        };
        let bodies = particles.bodies().iter().enumerate();
        for (index, body) in bodies.filter(|_| own.bodies) {
            if !body.is_fixed()
                && let Some(exit) = self.exit(body.position, cell)
            {
                gone.push((Grain::Body(index as u32), exit));
            }
        }
        gone
    }

    /// Whether any particle or body may leave before the next list.
    pub(super) fn is_watching(&self, particles: &Particles) -> bool {
        self.near.as_ref().is_none_or(|near| !near.is_empty()) || particles.bodies.is_some()
    }

    /// The way by which a centre has left, if it has: the first region that holds it, else the first face that it is beyond.
    fn exit(&self, position: DVec3, cell: &Cell) -> Option<Gate> {
        if !self.regions.is_empty() {
            let inside = cell.wrap(position);
            if let Some(index) = self
                .regions
                .iter()
                .position(|region| region.contains(inside))
            {
                return Some(Gate::Region(index as u32));
            }
        }
        let (low, high) = cell.corners();
        (0..3).filter(|&axis| self.open[axis]).find_map(|axis| {
            if position[axis] < low[axis] {
                Some(Gate::Face(2 * axis as u32))
            } else if position[axis] > high[axis] {
                Some(Gate::Face(2 * axis as u32 + 1))
            } else {
                None
            }
        })
    }
}

/// Removes these rows. Returns those that stay, in order.
pub(super) fn remove(particles: &mut Particles, leavers: &[(u32, bool)]) -> Vec<u32> {
    let mut leaves = vec![false; particles.len()];
    for &(row, _) in leavers {
        leaves[row as usize] = true;
    }
    let stay: Vec<u32> = (0..particles.len() as u32)
        .filter(|&row| !leaves[row as usize])
        .collect();
    particles.keep(&stay);
    stay
}
