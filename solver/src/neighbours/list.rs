//! The candidate list: every pair that may touch before the list is built again.

use rayon::prelude::*;

use super::{Grid, Images, NO_SHIFT};
use crate::particles::{Bodies, Particle, Particles};

/// A listed partner of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Candidate {
    /// Row of the partner; larger than the row that owns the entry.
    pub partner: u32,
    /// Code of the partner's image that is near ([`Images::shift`]).
    pub image: u32,
}

/// Half list in rows: `entries[start[i]..start[i + 1]]` are the partners of row `i`, each pair once.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct CandidateList {
    /// First entry of each row, and the number of entries at the end.
    pub start: Vec<u32>,
    /// Partners.
    pub entries: Vec<Candidate>,
}

impl CandidateList {
    /// Drops the pairs of pebbles of one body, which never touch.
    fn drop_inner_pairs(&mut self, bodies: &Bodies) {
        let (mut kept, mut begin) = (0, 0);
        for row in 0..self.start.len() - 1 {
            let end = self.start[row + 1] as usize;
            let body = bodies.body_of_row(row);
            for k in begin..end {
                let entry = self.entries[k];
                if body.is_none() || body != bodies.body_of_row(entry.partner as usize) {
                    self.entries[kept] = entry;
                    kept += 1;
                }
            }
            begin = end;
            self.start[row + 1] = kept as u32;
        }
        self.entries.truncate(kept);
    }
}

/// Sorts the particles into cells (in place, wrapped into periodic domains) and lists every pair closer than
/// R_i + R_j + `skin` (m), except pairs that contacts cannot move and pairs of pebbles of one body. Returns the list and where each old row went
/// (`new_row[old]`). `parallel`: with the threads of the pool from within which it is called; the list is the same.
///
/// Requires finite positions, and periodic edges of at least twice the largest listing distance.
#[must_use]
pub fn build(
    particles: &mut Particles,
    skin: f64,
    images: &Images,
    parallel: bool,
) -> (CandidateList, Vec<u32>) {
    let mut largest_radius: f64 = 0.0;
    for record in &mut particles.records {
        record.position = images.wrap(record.position);
        largest_radius = largest_radius.max(record.radius);
    }
    let reach = 2.0 * largest_radius + skin;
    let (grid, order) = Grid::sort(particles, reach, images);
    particles.reorder(&order, parallel);
    let mut new_row = vec![0; order.len()];
    for (new, &old) in order.iter().enumerate() {
        new_row[old as usize] = new as u32;
    }
    for (record, listed) in particles.records.iter().zip(&mut particles.listed_at) {
        *listed = record.position;
    }
    let mut list = list(particles, &grid, reach, skin, images, parallel);
    if let Some(bodies) = &particles.bodies {
        list.drop_inner_pairs(bodies);
    }
    (list, new_row)
}

/// Lists the pairs of sorted particles.
///
/// The partners of a row in later cells lie in five runs of rows: the rest of its own cell with the next one, and three
/// neighbouring cells in each of four later rows of cells.
fn list(
    particles: &Particles,
    grid: &Grid,
    reach: f64,
    skin: f64,
    images: &Images,
    parallel: bool,
) -> CandidateList {
    let records = &particles.records;
    let spots: Vec<Spot> = records
        .iter()
        .map(|record| Spot {
            position: record.position.to_array(),
            radius: signed_radius(record),
        })
        .collect();
    let through = ImagePairs::find(particles, grid, reach, skin, images);
    let [.., slow] = grid.ordered_counts();
    let layer = |c| layer(&spots, grid, c, skin, &through);
    let layers: Vec<CandidateList> = if parallel {
        (0..slow).into_par_iter().map(layer).collect()
    } else {
        (0..slow).map(layer).collect()
    };
    let count = layers.iter().map(|layer| layer.entries.len()).sum();
    let mut result = CandidateList {
        start: Vec::with_capacity(records.len() + 1),
        entries: Vec::with_capacity(count),
    };
    result.start.push(0);
    for layer in layers {
        let before = result.entries.len() as u32;
        result
            .start
            .extend(layer.start.iter().map(|start| before + start));
        result.entries.extend_from_slice(&layer.entries);
    }
    result
}

/// The part of the list that belongs to the rows of layer `c` of cells; `start` holds the ends of the rows alone.
fn layer(spots: &[Spot], grid: &Grid, c: usize, skin: f64, through: &ImagePairs) -> CandidateList {
    let [fast, middle, slow] = grid.ordered_counts();
    let (mut start, mut list) = (Vec::new(), Growing::default());
    let first = grid.rows(fast * middle * c, fast * middle * c).start;
    let mut through = through.from(first as u32);
    for b in 0..middle {
        for a in 0..fast {
            let cell = a + fast * (b + middle * c);
            let (left, right) = (a.saturating_sub(1), (a + 1).min(fast - 1));
            let mut runs = [0..0, 0..0, 0..0, 0..0];
            let mut used = 0;
            let mut add = |b: usize, c: usize| {
                let row = fast * (b + middle * c);
                runs[used] = grid.rows(row + left, row + right);
                used += 1;
            };
            if b + 1 < middle {
                add(b + 1, c);
            }
            if c + 1 < slow {
                if b > 0 {
                    add(b - 1, c + 1);
                }
                add(b, c + 1);
                if b + 1 < middle {
                    add(b + 1, c + 1);
                }
            }
            let own = grid.rows(cell, cell);
            let end = grid.rows(cell, cell + right - a).end;
            for row in own {
                let spot = spots[row];
                list.scan(spots, spot, row + 1..end, skin);
                for run in &runs[..used] {
                    list.scan(spots, spot, run.clone(), skin);
                }
                while let Some(&(_, candidate)) =
                    through.first().filter(|pair| pair.0 == row as u32)
                {
                    list.push(candidate);
                    through = &through[1..];
                }
                start.push(list.count as u32);
            }
        }
    }
    let mut entries = list.entries;
    entries.truncate(list.count);
    CandidateList { start, entries }
}

/// Position and radius; the radius of a particle that contacts cannot move is negated.
#[derive(Clone, Copy)]
struct Spot {
    position: [f64; 3],
    radius: f64,
}

fn signed_radius(record: &Particle) -> f64 {
    if record.inverse_mass > 0.0 {
        record.radius
    } else {
        -record.radius
    }
}

/// Entries of a list that grows without a branch for each: those behind `count` are scratch.
#[derive(Default)]
struct Growing {
    entries: Vec<Candidate>,
    count: usize,
}

impl Growing {
    /// Room for `more` entries at once.
    #[inline]
    fn reserve(&mut self, more: usize) -> &mut [Candidate] {
        let needed = self.count + more;
        if self.entries.len() < needed {
            let nothing = Candidate {
                partner: 0,
                image: NO_SHIFT,
            };
            self.entries
                .resize(needed.max(2 * self.entries.len()), nothing);
        }
        &mut self.entries[self.count..needed]
    }

    /// Appends the partners among the rows `run`. Few of those that are looked at are near, in no order that a processor
    /// could foresee: each is written, and the next one over it if it was not.
    #[inline]
    fn scan(&mut self, spots: &[Spot], spot: Spot, run: std::ops::Range<usize>, skin: f64) {
        let (first, others) = (run.start, &spots[run]);
        let room = self.reserve(others.len());
        let mut found = 0;
        for (k, other) in others.iter().enumerate() {
            room[found] = Candidate {
                partner: (first + k) as u32,
                image: NO_SHIFT,
            };
            found += usize::from(near(spot, other.position, other.radius, skin));
        }
        self.count += found;
    }

    fn push(&mut self, candidate: Candidate) {
        self.reserve(1)[0] = candidate;
        self.count += 1;
    }
}

/// Whether two particles are closer than the sum of their radii and the skin, and can be moved.
#[inline]
fn near(spot: Spot, position: [f64; 3], radius: f64, skin: f64) -> bool {
    let [x, y, z] = [
        spot.position[0] - position[0],
        spot.position[1] - position[1],
        spot.position[2] - position[2],
    ];
    let distance = spot.radius.abs() + radius.abs() + skin;
    (x * x + y * y + z * z < distance * distance) & ((spot.radius > 0.0) | (radius > 0.0))
}

/// Pairs that are near only through a periodic face, by their lower row.
struct ImagePairs {
    pairs: Vec<(u32, Candidate)>,
}

impl ImagePairs {
    fn find(particles: &Particles, grid: &Grid, reach: f64, skin: f64, images: &Images) -> Self {
        let mut pairs = Vec::new();
        if images.any() {
            let (low, high) = (images.min, images.min + images.size);
            let records = &particles.records;
            for (partner, other) in records.iter().enumerate() {
                for image in images.neighbours() {
                    let position = other.position + images.shift(image);
                    // Only images that stand within reach of a periodic face can have a neighbour behind it; along the
                    // other axes particles may stand outside the domain.
                    let outside = (low - position).max(position - high);
                    if (0..3).any(|axis| images.periodic[axis] && outside[axis] > reach) {
                        continue;
                    }
                    let radius = signed_radius(other);
                    grid.visit_near(position, reach, |row| {
                        if row < partner {
                            let record = &records[row];
                            let spot = Spot {
                                position: record.position.to_array(),
                                radius: signed_radius(record),
                            };
                            if near(spot, position.to_array(), radius, skin) {
                                let candidate = Candidate {
                                    partner: partner as u32,
                                    image,
                                };
                                pairs.push((row as u32, candidate));
                            }
                        }
                    });
                }
            }
            pairs.sort_unstable_by_key(|&(row, candidate)| (row, candidate.partner));
        }
        Self { pairs }
    }

    /// Those whose lower row is `row` or a later one.
    fn from(&self, row: u32) -> &[(u32, Candidate)] {
        &self.pairs[self.pairs.partition_point(|pair| pair.0 < row)..]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::FIXED;
    use glam::DVec3;
    use proptest::prelude::*;

    fn cloud(seed: u64, count: usize, size: DVec3, ratio: f64, fixed_every: usize) -> Particles {
        let mut random = mercury_common::random::Stream::new(seed, "list test", 0);
        let mut particles = Particles::new(false);
        for k in 0..count {
            let position = DVec3::new(random.uniform(), random.uniform(), random.uniform()) * size;
            let radius = 0.01 * ratio.powf(random.uniform());
            let fixed = fixed_every > 0 && k % fixed_every == 0;
            let record = Particle {
                position,
                radius,
                velocity: DVec3::ZERO,
                inverse_mass: f64::from(!fixed),
                angular_velocity: DVec3::ZERO,
                material: 0,
                flags: u32::from(fixed),
            };
            particles.push(record, 1.0, None);
        }
        particles
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(96))]

        /// The list is the brute-force set of pairs: every pair once, with the right image, none that is not near.
        #[test]
        fn lists_exactly_the_pairs_that_are_near(
            seed in any::<u64>(),
            count in 0usize..220,
            flat in any::<bool>(),
            ratio in prop_oneof![Just(1.0), 1.0..10.0f64],
            periodic in any::<[bool; 3]>(),
            skin in 0.0..0.02f64,
            fixed_every in 0usize..5,
            outside in any::<bool>(),
        ) {
            let size = DVec3::new(0.5, 0.7, if flat { 0.45 } else { 1.3 });
            let mut particles = cloud(seed, count, size, ratio, fixed_every);
            if outside {
                // particles may stand outside a domain's faces, far or near
                for (k, record) in particles.records.iter_mut().enumerate() {
                    record.position += DVec3::new(0.1, -0.3, 0.2) * (k % 4) as f64;
                }
            }
            let images = Images::new(DVec3::ZERO, size, periodic);
            let (list, new_row) = build(&mut particles, skin, &images, seed % 2 == 0);

            let mut moved = new_row.clone();
            moved.sort_unstable();
            prop_assert!(moved.iter().enumerate().all(|(k, &row)| k as u32 == row));

            let mut expected = Vec::new();
            for i in 0..count {
                for j in i + 1..count {
                    let (a, b) = (&particles.records[i], &particles.records[j]);
                    if a.flags & b.flags & FIXED != 0 {
                        continue;
                    }
                    for image in 0..27 {
                        let allowed = image == NO_SHIFT || images.neighbours().any(|c| c == image);
                        let gap = (a.position - b.position - images.shift(image)).length();
                        if allowed && gap < a.radius + b.radius + skin {
                            expected.push((i as u32, j as u32, image));
                        }
                    }
                }
            }
            let mut found = Vec::new();
            for i in 0..count {
                for entry in &list.entries[list.start[i] as usize..list.start[i + 1] as usize] {
                    found.push((i as u32, entry.partner, entry.image));
                }
            }
            found.sort_unstable();
            expected.sort_unstable();
            prop_assert_eq!(found, expected);
        }
    }
}
