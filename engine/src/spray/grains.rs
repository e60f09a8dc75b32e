//! The particles near a place, listed by cells.

use glam::DVec3;

use super::Droplet;
use crate::cell::{Cell, NO_SHIFT};
use crate::state::Particles;

/// Part of an edge of a cell that particles may move by before they are listed anew.
const STALE: f64 = 0.25;

/// Part of an edge of a cell within which the nearest particle is looked for first.
const NEAR: f64 = 0.2;

/// Cells for each particle, at most.
const CELLS_PER_GRAIN: usize = 8;

/// A particle, or an image of it, in a cell.
#[derive(Debug, Clone, Copy)]
struct Member {
    row: u32,
    image: u32,
}

/// Particles and their images by the cells that their bounding boxes meet, as they stood when it was made; since then each may have moved
/// by a known distance.
#[derive(Debug, Clone, Default)]
pub(super) struct Grains {
    low: DVec3,
    edge: f64,
    counts: [usize; 3],
    /// Where each cell begins in `members`, and the end.
    starts: Vec<u32>,
    members: Vec<Member>,
    /// How far particles may have moved since, m.
    moved: f64,
}

impl Grains {
    /// Memory for each particle, bytes: with all cells, and a particle in eight of them.
    pub(super) const BYTES_OF_ROW: usize =
        CELLS_PER_GRAIN * (size_of::<u32>() + size_of::<Member>());

    /// Grid of all particles as they are now.
    pub(super) fn new(particles: &Particles, domain: &Cell) -> Self {
        let mean = if particles.is_empty() {
            f64::INFINITY
        } else {
            let radii = particles.records.iter().map(|record| record.radius);
            radii.sum::<f64>() / particles.len() as f64
        };
        let most = CELLS_PER_GRAIN * particles.len() + 64;
        let per_cell = domain.size().element_product() / most as f64;
        let edge = f64::max(
            2.0 * mean.min(domain.size().max_element()),
            libm::cbrt(per_cell),
        );
        let counts = domain
            .size()
            .to_array()
            .map(|size| ((size / edge) as usize).max(1));
        let mut grains = Self {
            low: domain.low(),
            edge,
            counts,
            starts: vec![0; counts.iter().product::<usize>() + 1],
            members: Vec::new(),
            moved: 0.0,
        };
        let codes: Vec<u32> = std::iter::once(NO_SHIFT).chain(domain.images()).collect();
        let near = |visit: &mut dyn FnMut(Member, usize)| {
            for (row, record) in particles.records.iter().enumerate() {
                for &image in &codes {
                    let centre = record.position + domain.shift(image);
                    // One cell more: a path may begin at a face and lead out of the domain.
                    if image != NO_SHIFT && !grains.is_near(centre, record.radius + grains.edge) {
                        continue;
                    }
                    let row = row as u32;
                    grains.cells(centre, record.radius, |cell| {
                        visit(Member { row, image }, cell)
                    });
                }
            }
        };
        let mut starts = grains.starts.clone();
        near(&mut |_, cell| starts[cell + 1] += 1);
        for cell in 1..starts.len() {
            starts[cell] += starts[cell - 1];
        }
        let mut next = starts.clone();
        let none = Member { row: 0, image: 0 };
        let mut members = vec![none; starts.last().map_or(0, |&end| end as usize)];
        near(&mut |member, cell| {
            members[next[cell] as usize] = member;
            next[cell] += 1;
        });
        grains.starts = starts;
        grains.members = members;
        grains
    }

    /// Particles have moved on by this distance (m) at most. Whether it is time to list them anew: near places are searched as far out as
    /// all may have moved, also where they only swing about.
    #[must_use]
    pub(super) fn drift(&mut self, way: f64) -> bool {
        self.moved += way;
        self.moved > STALE * self.edge
    }

    /// Edge of a cell, m.
    pub(super) fn edge(&self) -> f64 {
        self.edge
    }

    /// Whether a box of half edge `reach` about a place meets the domain.
    fn is_near(&self, centre: DVec3, reach: f64) -> bool {
        let high = self.low + self.edge * DVec3::from(self.counts.map(|count| count as f64));
        (centre + reach).cmpge(self.low).all() && (centre - reach).cmple(high).all()
    }

    /// The cells that a box of half edge `reach` about a place meets; places outside count to the cells at the faces.
    fn cells(&self, centre: DVec3, reach: f64, mut visit: impl FnMut(usize)) {
        let range = |axis: usize| {
            let at =
                |x: f64| (((x - self.low[axis]) / self.edge) as usize).min(self.counts[axis] - 1);
            at(centre[axis] - reach)..=at(centre[axis] + reach)
        };
        for z in range(2) {
            for y in range(1) {
                for x in range(0) {
                    visit(x + self.counts[0] * (y + self.counts[1] * z));
                }
            }
        }
    }

    /// Calls `visit` with the row and the shift (m) of each particle that may be within `reach` (m) of the place; a particle in several cells
    /// comes several times.
    pub(super) fn near(
        &self,
        place: DVec3,
        reach: f64,
        domain: &Cell,
        mut visit: impl FnMut(usize, DVec3),
    ) {
        self.cells(place, reach + self.moved, |cell| {
            let members = self.starts[cell] as usize..self.starts[cell + 1] as usize;
            for member in &self.members[members] {
                visit(member.row as usize, domain.shift(member.image));
            }
        });
    }

    /// A lower bound of the gap between a droplet and the particles, m; an edge at most.
    pub(super) fn clearance(&self, droplet: &Droplet, particles: &Particles, domain: &Cell) -> f64 {
        let within = |reach: f64| {
            let mut clear = reach;
            self.near(
                droplet.position,
                droplet.radius + reach,
                domain,
                |row, shift| {
                    let record = &particles.records[row];
                    let distance = (record.position + shift).distance(droplet.position);
                    clear = clear.min(distance - record.radius - droplet.radius);
                },
            );
            clear
        };
        // Among particles there is one near, and fewer cells to look at.
        let near = NEAR * self.edge;
        let clear = within(near);
        if clear < near {
            clear
        } else {
            within(self.edge)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The way that is searched beyond a place is bounded, however long the candidate lists last: a grain that swings about for ever has
    /// them made anew from time to time.
    #[test]
    fn grains_that_swing_about_are_listed_anew() {
        let domain = Cell::new(DVec3::ZERO, DVec3::splat(1.0), [false; 3]);
        let mut grains = Grains::new(&Particles::default(), &domain);
        let way = 0.03 * grains.edge();
        let steps = (1..=100).find(|_| grains.drift(way));
        // A quarter of a cell: 8 steps are 0.24 of it.
        assert_eq!(steps, Some(9));
        assert!(grains.moved <= (STALE + 0.03) * grains.edge());
    }
}
