//! What takes particles out: deletion regions, and the faces of the domain.

use super::{DeletionPlan, Region};
use crate::neighbours::{Images, NO_SHIFT};
use crate::particles::Particles;
use crate::plan::Plan;

/// Where a particle went.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Exit {
    /// Into the deletion region of this index.
    Region(usize),
    /// Through this face of the domain: -x, +x, -y, +y, -z, +z.
    Face(usize),
}

/// Deletion regions and faces, and which particles may reach them soon.
///
/// Fixed particles are part of the geometry, like walls: nothing removes them.
#[derive(Debug, Clone)]
pub(super) struct Deletion {
    regions: Vec<Region>,
    /// Axes along which particles can leave: not periodic, and not the third of a two-dimensional scene.
    open: [bool; 3],
    low: [f64; 3],
    high: [f64; 3],
    /// Rows that may reach an exit before the next list, ascending; `None`: not known, so all may.
    near: Option<Vec<u32>>,
}

impl Deletion {
    pub(super) fn new(plan: &Plan) -> Self {
        let open = |axis: usize| !plan.periodic[axis] && (axis < 2 || plan.dimensions == 3);
        Self {
            regions: plan
                .deletions
                .iter()
                .map(|DeletionPlan { region, .. }| region.clone())
                .collect(),
            open: [open(0), open(1), open(2)],
            low: plan.domain_min.to_array(),
            high: plan.domain_max.to_array(),
            near: None,
        }
    }

    /// Forgets what is near: rows have changed.
    pub(super) fn forget_near(&mut self) {
        self.near = None;
    }

    /// Collects the rows whose centre is within `margin` (m) of an exit.
    pub(super) fn listed(&mut self, particles: &Particles, images: &Images, margin: f64) {
        let codes: Vec<u32> = images.neighbours().collect();
        let end = images.min + images.size;
        let mut near = self.near.take().unwrap_or_default();
        near.clear();
        for (row, record) in particles.records.iter().enumerate() {
            if particles.is_fixed(row) {
                continue;
            }
            let at_face = (0..3).any(|axis| {
                let x = record.position[axis];
                self.open[axis] && (x < self.low[axis] + margin || x > self.high[axis] - margin)
            });
            let reaches = |code: u32| {
                let position = record.position + images.shift(code);
                // Only an image that may become the particle itself: one that is about to cross a periodic face.
                let crosses = code == NO_SHIFT
                    || (0..3).all(|axis| {
                        images.shift(code)[axis] == 0.0
                            || (position[axis] > images.min[axis] - margin
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

    /// The rows that have left, ascending, and where.
    pub(super) fn find(&self, particles: &Particles, images: &Images) -> Vec<(u32, Exit)> {
        let exit = |row: u32| Some((row, self.exit(particles, images, row as usize)?));
        match &self.near {
            Some(near) => near.iter().filter_map(|&row| exit(row)).collect(),
            None => (0..particles.len() as u32).filter_map(exit).collect(),
        }
    }

    /// The way out that the particle has taken, if any: the first region that holds its centre, else the first face that its
    /// centre is beyond.
    fn exit(&self, particles: &Particles, images: &Images, row: usize) -> Option<Exit> {
        if particles.is_fixed(row) {
            return None;
        }
        let position = particles.records[row].position;
        if !self.regions.is_empty() {
            let inside = images.wrap(position);
            if let Some(index) = self
                .regions
                .iter()
                .position(|region| region.contains(inside))
            {
                return Some(Exit::Region(index));
            }
        }
        (0..3).filter(|&axis| self.open[axis]).find_map(|axis| {
            if position[axis] < self.low[axis] {
                Some(Exit::Face(2 * axis))
            } else if position[axis] > self.high[axis] {
                Some(Exit::Face(2 * axis + 1))
            } else {
                None
            }
        })
    }
}

/// Removes rows, given in ascending order. Returns the rows that stay, in order.
pub(super) fn remove(particles: &mut Particles, gone: &[(u32, Exit)]) -> Vec<u32> {
    let mut leaving = gone.iter().map(|&(row, _)| row).peekable();
    let stay: Vec<u32> = (0..particles.len() as u32)
        .filter(|row| leaving.next_if_eq(row).is_none())
        .collect();
    particles.keep(&stay);
    stay
}
