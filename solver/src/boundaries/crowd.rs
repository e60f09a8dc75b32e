//! What stands in the way of new particles: the spheres about an insertion region, in cells.

use glam::DVec3;

use super::thinning::Looks;
use crate::neighbours::{Images, NO_SHIFT};
use crate::state::Particles;

/// Most cells: a million heads of lists are cleared in a fraction of a millisecond.
const MOST_CELLS: f64 = 1_048_576.0;
/// The end of a list.
const END: u32 = u32::MAX;

/// The particles (and periodic images) near an insertion region, each listed in every cell that its bounding box meets.
///
/// Cells hold where particles were listed, widened by a margin, tests use where they are now: so the cells serve until the
/// candidate list is built again, however many steps that takes. Two boxes that meet share a cell even outside of the grid,
/// as coordinates are clipped monotonically.
#[derive(Debug, Clone)]
pub(super) struct Crowd {
    low: DVec3,
    high: DVec3,
    /// Largest radius of new particles, m.
    largest: f64,
    margin: f64,
    inverse_edge: DVec3,
    counts: [usize; 3],
    heads: Vec<u32>,
    links: Vec<Link>,
    members: Vec<Member>,
    /// Rows that have been looked at.
    rows: usize,
}

#[derive(Debug, Clone, Copy)]
struct Link {
    member: u32,
    next: u32,
}

#[derive(Debug, Clone, Copy)]
struct Member {
    row: u32,
    image: u32,
}

impl Crowd {
    /// Nobody yet, about the box from `low` to `high` (m) in which the centres of new particles of at most `largest` radius
    /// lie, with cells of about `edge` (m). Particles will stay within `margin` (m) of where they were listed.
    pub(super) fn new(low: DVec3, high: DVec3, largest: f64, edge: f64, margin: f64) -> Self {
        let extent = (high - low).max(DVec3::ZERO);
        let mut edge = edge;
        let counts = loop {
            let counts = (extent / edge).floor().clamp(DVec3::ONE, DVec3::splat(1e6));
            if counts.element_product() <= MOST_CELLS {
                break [counts.x as usize, counts.y as usize, counts.z as usize];
            }
            edge *= 1.25;
        };
        let mut inverse_edge = DVec3::ZERO;
        for axis in 0..3 {
            if extent[axis] > 0.0 {
                inverse_edge[axis] = counts[axis] as f64 / extent[axis];
            }
        }
        Self {
            low,
            high,
            largest,
            margin,
            inverse_edge,
            counts,
            heads: vec![END; counts.iter().product()],
            links: Vec::new(),
            members: Vec::new(),
            rows: 0,
        }
    }

    /// Takes in the rows that were appended since the last call.
    pub(super) fn take_in(&mut self, particles: &Particles, images: &Images) {
        if self.rows == particles.len() {
            return;
        }
        let codes: Vec<u32> = std::iter::once(NO_SHIFT)
            .chain(images.neighbours())
            .collect();
        let reach = DVec3::splat(self.largest + self.margin);
        let (low, high) = (self.low - reach, self.high + reach);
        for row in self.rows..particles.len() {
            let radius = DVec3::splat(particles.records[row].radius);
            for &image in &codes {
                let centre = particles.listed_at[row] + images.shift(image);
                let meets =
                    (centre + radius).cmpge(low).all() && (centre - radius).cmple(high).all();
                if meets {
                    self.add(row as u32, image, centre, radius.x + self.margin);
                }
            }
        }
        self.rows = particles.len();
    }

    fn add(&mut self, row: u32, image: u32, centre: DVec3, reach: f64) {
        let member = self.members.len() as u32;
        self.members.push(Member { row, image });
        let [low, high] = self.cells(centre, reach);
        for z in low[2]..=high[2] {
            for y in low[1]..=high[1] {
                let start = self.counts[0] * (y + self.counts[1] * z);
                for head in &mut self.heads[start + low[0]..=start + high[0]] {
                    self.links.push(Link {
                        member,
                        next: *head,
                    });
                    *head = self.links.len() as u32 - 1;
                }
            }
        }
    }

    /// Whether a sphere would overlap anybody; touching is not overlapping.
    pub(super) fn overlaps(
        &self,
        particles: &Particles,
        images: &Images,
        centre: DVec3,
        radius: f64,
        looks: &mut Looks,
    ) -> bool {
        let [low, high] = self.cells(centre, radius);
        for z in low[2]..=high[2] {
            for y in low[1]..=high[1] {
                let start = self.counts[0] * (y + self.counts[1] * z);
                for &head in &self.heads[start + low[0]..=start + high[0]] {
                    let mut next = head;
                    looks.add(1);
                    while next != END {
                        looks.add(1);
                        let link = self.links[next as usize];
                        let member = self.members[link.member as usize];
                        let record = &particles.records[member.row as usize];
                        let branch = record.position + images.shift(member.image) - centre;
                        let contact = record.radius + radius;
                        if branch.length_squared() < contact * contact {
                            return true;
                        }
                        next = link.next;
                    }
                }
            }
        }
        false
    }

    /// Lowest and highest cell that a cube of half edge `reach` meets.
    fn cells(&self, centre: DVec3, reach: f64) -> [[usize; 3]; 2] {
        [-reach, reach].map(|reach| {
            let scaled = (centre + DVec3::splat(reach) - self.low) * self.inverse_edge;
            // Casts from negative numbers give 0.
            [0, 1, 2].map(|axis| (scaled[axis] as usize).min(self.counts[axis] - 1))
        })
    }
}
