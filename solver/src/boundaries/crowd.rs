//! What stands in the way of new particles: the spheres about an insertion region, in cells.

use glam::{DVec3, Vec3};

use super::thinning::Looks;
use crate::neighbours::{Images, NO_SHIFT};
use crate::state::Particles;

/// Most cells: a million heads of lists are cleared in a fraction of a millisecond.
const MOST_CELLS: f64 = 1_048_576.0;
/// What it costs to look whether a row is near, to find the cells of one that is, and to list it in a cell, in looks.
const LOOKS_OF_ROW: u64 = 1;
const LOOKS_OF_MEMBER: u64 = 10;
const LOOKS_OF_LISTED: u64 = 2;
/// Cells, empty or not, that are gone over in the time of a look.
const CELLS_PER_LOOK: u64 = 2;
/// Rows that are looked at in the time that it takes to find a place for one more entry of a list, at least.
const ROWS_PER_LINK: usize = 8;
/// The end of a list.
const END: u32 = u32::MAX;

/// The particles (and periodic images) near an insertion region, each listed in every cell that its bounding box meets.
///
/// Cells hold where particles were listed, widened by a margin, so they serve until the candidate list is built again, however many
/// steps that takes. Where that alone decides, nobody is asked where it is now. Two boxes that meet share a cell even outside of the
/// grid, as coordinates are clipped monotonically.
#[derive(Debug, Clone)]
pub(super) struct Crowd {
    low: DVec3,
    high: DVec3,
    /// Largest radius of new particles, m.
    largest: f64,
    margin: f64,
    inverse_edge: DVec3,
    counts: [usize; 3],
    /// Who is listed in each cell, cell by cell, by ascending rows.
    listed: Vec<Member>,
    /// Where each cell begins in `listed`, and the end.
    starts: Vec<u32>,
    /// Who came since: lists by cells, the latest first. No heads while there is nobody.
    heads: Vec<u32>,
    links: Vec<Link>,
    /// Rows that have been looked at.
    rows: usize,
    /// How many of them and their images are near.
    members: usize,
    /// Largest coordinate or radius of a member, m: a part in 2^24 of it is lost there.
    farthest: f32,
    /// How often all rows were listed.
    #[cfg(test)]
    listings: usize,
}

#[derive(Debug, Clone, Copy)]
struct Link {
    member: Member,
    next: u32,
}

/// A particle in a cell, with where it was listed: most questions end here, and to ask elsewhere costs more than the question.
#[derive(Debug, Clone, Copy, Default)]
struct Member {
    /// From the lowest corner, m.
    centre: Vec3,
    /// m
    radius: f32,
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
        let cells: usize = counts.iter().product();
        Self {
            low,
            high,
            largest,
            margin,
            inverse_edge,
            counts,
            listed: Vec::new(),
            starts: vec![0; cells + 1],
            heads: Vec::new(),
            links: Vec::new(),
            rows: 0,
            members: 0,
            farthest: 0.0,
            #[cfg(test)]
            listings: 0,
        }
    }

    /// Takes in the rows that were appended since the last call.
    pub(super) fn take_in(&mut self, particles: &Particles, images: &Images) {
        if self.rows == particles.len() {
            return;
        }
        // Lists are for few: cell by cell they lie side by side. To list anew all rows are looked at, also where none was near before.
        let few = self.listed.len().max(self.rows / ROWS_PER_LINK);
        if self.rows == 0 || self.links.len() > few {
            return self.list(particles, images);
        }
        self.heads.resize(self.starts.len() - 1, END);
        for member in self.near(self.rows, particles, images) {
            self.note(&member);
            for cell in self.cells_of(&member) {
                let next = self.heads[cell];
                self.heads[cell] = self.links.len() as u32;
                self.links.push(Link { member, next });
            }
        }
        self.rows = particles.len();
    }

    /// Lists all rows.
    fn list(&mut self, particles: &Particles, images: &Images) {
        #[cfg(test)]
        {
            self.listings += 1;
        }
        self.heads.clear();
        self.links.clear();
        self.members = 0;
        self.rows = particles.len();
        let near = self.near(0, particles, images);
        self.starts.fill(0);
        for member in &near {
            self.note(member);
            for cell in self.cells_of(member) {
                self.starts[cell + 1] += 1;
            }
        }
        for cell in 1..self.starts.len() {
            self.starts[cell] += self.starts[cell - 1];
        }
        let mut ends = self.starts.clone();
        let listed = self.starts.last().map_or(0, |&end| end as usize);
        self.listed.clear();
        self.listed.resize(listed, Member::default());
        for member in near {
            for cell in self.cells_of(&member) {
                self.listed[ends[cell] as usize] = member;
                ends[cell] += 1;
            }
        }
    }

    /// Rows from `first` on, and their images, that may meet a new particle.
    fn near(&self, first: usize, particles: &Particles, images: &Images) -> Vec<Member> {
        let codes: Vec<u32> = std::iter::once(NO_SHIFT)
            .chain(images.neighbours())
            .collect();
        let reach = DVec3::splat(self.largest + self.margin);
        let (low, high) = (self.low - reach, self.high + reach);
        let mut near = Vec::new();
        for row in first..particles.len() {
            let radius = particles.records[row].radius;
            for &image in &codes {
                let centre = particles.listed_at[row] + images.shift(image);
                let meets = (centre + DVec3::splat(radius)).cmpge(low).all()
                    && (centre - DVec3::splat(radius)).cmple(high).all();
                if meets {
                    near.push(Member {
                        centre: (centre - self.low).as_vec3(),
                        radius: radius as f32,
                        row: row as u32,
                        image,
                    });
                }
            }
        }
        near
    }

    fn note(&mut self, member: &Member) {
        self.members += 1;
        let farthest = member.centre.abs().max_element().max(member.radius);
        self.farthest = self.farthest.max(farthest);
    }

    /// How far a member may be from where it was listed in single precision, with what its radius lacks, m.
    fn apart(&self, farthest: f32) -> f64 {
        self.margin + 4.0 * f64::from(f32::EPSILON) * f64::from(farthest)
    }

    /// The cells that the box of a member meets.
    fn cells_of(&self, member: &Member) -> impl Iterator<Item = usize> + use<> {
        let farthest = member.centre.abs().max_element().max(member.radius);
        let reach = f64::from(member.radius) + self.apart(farthest);
        let [low, high] = self.cells(member.centre.as_dvec3(), reach);
        let [columns, rows, _] = self.counts;
        (low[2]..=high[2]).flat_map(move |z| {
            (low[1]..=high[1]).flat_map(move |y| {
                let start = columns * (y + rows * z);
                start + low[0]..=start + high[0]
            })
        })
    }

    /// What it costs to take in all that are there now, in looks.
    pub(super) fn cost(&self) -> u64 {
        self.starts.len() as u64 / CELLS_PER_LOOK
            + LOOKS_OF_ROW * self.rows as u64
            + LOOKS_OF_MEMBER * self.members as u64
            + LOOKS_OF_LISTED * (self.listed.len() + self.links.len()) as u64
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
        let from_corner = centre - self.low;
        let apart = self.apart(self.farthest);
        let mut meets = |member: &Member| {
            looks.at_sphere();
            let squared = (member.centre.as_dvec3() - from_corner).length_squared();
            let contact = f64::from(member.radius) + radius;
            let (surely, perhaps) = (contact - apart, contact + apart);
            if surely > 0.0 && squared < surely * surely {
                return true;
            }
            squared < perhaps * perhaps && {
                looks.at_sphere();
                let record = &particles.records[member.row as usize];
                let branch = record.position + images.shift(member.image) - centre;
                let contact = record.radius + radius;
                branch.length_squared() < contact * contact
            }
        };
        let mut is_taken = |cell: usize| {
            // The latest first, wherever they stand: what is looked at must not depend on when they came.
            let mut next = self.heads.get(cell).copied().unwrap_or(END);
            while next != END {
                let link = &self.links[next as usize];
                if meets(&link.member) {
                    return true;
                }
                next = link.next;
            }
            let listed = self.starts[cell] as usize..self.starts[cell + 1] as usize;
            self.listed[listed].iter().rev().any(&mut meets)
        };
        // Who is in the way is most often about the centre.
        let [middle, _] = self.cells(from_corner, 0.0);
        let cell = |[x, y, z]: [usize; 3]| x + self.counts[0] * (y + self.counts[1] * z);
        // To find which they are is counted as one more: failures among clumps take more than what is counted for them as it is
        // (docs/performance.md).
        let mut cells = 1;
        let mut is_taken_at = |at: [usize; 3]| {
            cells += 1;
            is_taken(cell(at))
        };
        let [low, high] = self.cells(from_corner, radius);
        let about = (low[2]..=high[2]).flat_map(|z| {
            (low[1]..=high[1]).flat_map(move |y| (low[0]..=high[0]).map(move |x| [x, y, z]))
        });
        let is_free =
            !is_taken_at(middle) && !about.filter(|&at| at != middle).any(&mut is_taken_at);
        looks.at_cells(cells);
        !is_free
    }

    /// Lowest and highest cell that a cube of half edge `reach` meets, whose middle lies so far from the lowest corner.
    fn cells(&self, from_corner: DVec3, reach: f64) -> [[usize; 3]; 2] {
        [-reach, reach].map(|reach| {
            let scaled = (from_corner + DVec3::splat(reach)) * self.inverse_edge;
            // Casts from negative numbers give 0.
            [0, 1, 2].map(|axis| (scaled[axis] as usize).min(self.counts[axis] - 1))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::{MaterialIndex, NewParticle};

    const RADIUS: f64 = 0.01;

    fn images() -> Images {
        Images::new(DVec3::splat(-100.0), DVec3::splat(100.0), [false; 3])
    }

    /// Spheres of a cubic lattice with this spacing (m) from a corner on.
    fn lattice(corner: DVec3, spacing: f64, counts: [usize; 3]) -> impl Iterator<Item = DVec3> {
        let [nx, ny, nz] = counts;
        (0..nx * ny * nz).map(move |i| {
            let at = [i % nx, i / nx % ny, i / (nx * ny)].map(|i| i as f64);
            corner + spacing * DVec3::from(at)
        })
    }

    fn add(particles: &mut Particles, centre: DVec3) {
        let materials = [crate::plan::Material {
            name: "m".to_owned(),
            density: 1000.0,
        }];
        let new = NewParticle::at(centre, RADIUS, MaterialIndex::new(0));
        let (record, mass, prescribed) = new.build(&materials, 3);
        particles.push(record, mass, prescribed);
    }

    /// About the unit cube.
    fn crowd() -> Crowd {
        Crowd::new(DVec3::ZERO, DVec3::ONE, RADIUS, 4.0 * RADIUS, 1e-3)
    }

    #[test]
    fn a_feed_far_from_all_others_lists_them_seldom() {
        let (mut particles, images, mut crowd) = (Particles::new(false), images(), crowd());
        for centre in lattice(DVec3::splat(-50.0), 0.1, [40, 25, 20]) {
            add(&mut particles, centre);
        }
        crowd.take_in(&particles, &images);
        assert_eq!((crowd.listings, crowd.members), (1, 0));
        let mut entries = 0;
        for centre in lattice(DVec3::splat(0.1), 0.05, [10, 10, 10]) {
            add(&mut particles, centre);
            let before = crowd.listed.len() + crowd.links.len();
            crowd.take_in(&particles, &images);
            entries += crowd.listed.len() + crowd.links.len() - before;
        }
        assert_eq!(crowd.members, 1000);
        // Each listing of the 20,000 takes an eighth as many entries at least.
        let most = 1 + entries / (20_000 / ROWS_PER_LINK);
        assert!(crowd.listings <= most, "{} {most}", crowd.listings);
        assert!(most < 6, "{entries}");
    }

    /// What is looked at in a question does not grow with the number of those who stand about, nor does what it costs to take one more in.
    #[test]
    fn a_question_costs_the_same_however_many_there_are() {
        let mean_looks = |per_axis: usize| {
            let (mut particles, images) = (Particles::new(false), images());
            let edge = 0.03 * per_axis as f64;
            let mut crowd = Crowd::new(DVec3::ZERO, DVec3::splat(edge), RADIUS, 4.0 * RADIUS, 1e-3);
            let all = lattice(DVec3::splat(0.015), 0.03, [per_axis; 3]);
            let mut entries = 0;
            for centre in all {
                add(&mut particles, centre);
                crowd.take_in(&particles, &images);
            }
            entries += crowd.listed.len() + crowd.links.len();
            let mut looks = Looks::default();
            let mut asked = 0;
            for centre in lattice(DVec3::splat(0.1), 0.0171, [10; 3]) {
                crowd.overlaps(&particles, &images, centre, RADIUS, &mut looks);
                asked += 1;
            }
            let listings = crowd.listings;
            // Twice as many at each listing.
            assert!(
                listings <= 2 + particles.len().ilog2() as usize,
                "{listings}"
            );
            [
                looks.number() as f64 / f64::from(asked),
                entries as f64 / particles.len() as f64,
            ]
        };
        let (few, many) = (mean_looks(12), mean_looks(36));
        // The same lattice; cells may lie a little otherwise about it.
        for (few, many) in few.into_iter().zip(many) {
            assert!((many / few - 1.0).abs() < 0.2, "{few} {many}");
        }
    }
}
