//! Boxes around the particles of blocks of cells, and around blocks of these, for searches among all particles, such as those of
//! walls.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::Grid;
use crate::state::Particle;

/// Cells of a block along the fastest, the middle and the slowest axis: some sixteen particles of a dense packing of equal ones.
const BLOCK: [usize; 3] = [4, 2, 2];

/// The box around the centres of some particles that contacts can move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block {
    /// Lowest coordinates of a centre, m.
    pub low: DVec3,
    /// Highest coordinates of a centre, m; below the lowest if the block is empty.
    pub high: DVec3,
    /// Largest radius with its extra skin, m.
    pub radius: f64,
}

impl Block {
    const EMPTY: Self = Self {
        low: DVec3::INFINITY,
        high: DVec3::NEG_INFINITY,
        radius: 0.0,
    };

    fn is_empty(&self) -> bool {
        self.low.x > self.high.x
    }

    fn join(&mut self, other: &Self) {
        self.low = self.low.min(other.low);
        self.high = self.high.max(other.high);
        self.radius = self.radius.max(other.radius);
    }
}

/// One level of blocks, the fastest axis first.
#[derive(Debug)]
struct Level {
    counts: [usize; 3],
    blocks: Vec<Block>,
}

/// The sorted particles by blocks of cells. The cell size that a particle would need does not matter: a box encloses the centres
/// and stores the largest radius.
#[derive(Debug)]
pub struct Boxes<'a> {
    grid: &'a Grid,
    /// From the smallest blocks to a single one that holds all.
    levels: Vec<Level>,
}

impl<'a> Boxes<'a> {
    /// Boxes of particles sorted by the cells of `grid`; `extra_skin` (m; empty for none) counts as part of the radius.
    /// `parallel`: with the threads of the pool from within which it is called.
    #[must_use]
    pub fn new(grid: &'a Grid, records: &[Particle], extra_skin: &[f64], parallel: bool) -> Self {
        let cells = grid.ordered_counts();
        let counts = [0, 1, 2].map(|k| cells[k].div_ceil(BLOCK[k]));
        let of_rows = |rows: Range<usize>| {
            let mut block = Block::EMPTY;
            for row in rows {
                let record = &records[row];
                if record.inverse_mass > 0.0 {
                    block.low = block.low.min(record.position);
                    block.high = block.high.max(record.position);
                    let extra_skin = extra_skin.get(row).copied().unwrap_or_default();
                    block.radius = block.radius.max(record.radius + extra_skin);
                }
            }
            block
        };
        let smallest = |index: usize| {
            let mut block = Block::EMPTY;
            for rows in rows_of(grid, counts, index) {
                block.join(&of_rows(rows));
            }
            block
        };
        let all = 0..counts.iter().product();
        let blocks = if parallel {
            all.into_par_iter().with_min_len(64).map(smallest).collect()
        } else {
            all.map(smallest).collect()
        };
        let mut levels = vec![Level { counts, blocks }];
        while let Some(next) = levels.last().and_then(Level::halved) {
            levels.push(next);
        }
        Self { grid, levels }
    }

    /// Appends to `found` the smallest blocks of which `may_matter` is true; blocks inside of one of which it is false are not
    /// tested.
    pub fn find(&self, mut may_matter: impl FnMut(&Block) -> bool, found: &mut Vec<u32>) {
        let mut stack = vec![(self.levels.len() - 1, [0, 0, 0])];
        while let Some((height, [a, b, c])) = stack.pop() {
            let level = &self.levels[height];
            let index = level.index([a, b, c]);
            let block = &level.blocks[index];
            if block.is_empty() || !may_matter(block) {
                continue;
            }
            if height == 0 {
                found.push(index as u32);
                continue;
            }
            let [fast, middle, slow] = self.levels[height - 1].counts;
            for c in (2 * c..slow.min(2 * c + 2)).rev() {
                for b in (2 * b..middle.min(2 * b + 2)).rev() {
                    for a in (2 * a..fast.min(2 * a + 2)).rev() {
                        stack.push((height - 1, [a, b, c]));
                    }
                }
            }
        }
    }

    /// The rows of one of the smallest blocks.
    pub fn rows(&self, block: u32) -> impl Iterator<Item = usize> {
        rows_of(self.grid, self.levels[0].counts, block as usize).flatten()
    }
}

impl Level {
    fn index(&self, [a, b, c]: [usize; 3]) -> usize {
        a + self.counts[0] * (b + self.counts[1] * c)
    }

    /// The level whose blocks hold eight of these; none above the single one.
    fn halved(&self) -> Option<Self> {
        if self.blocks.len() <= 1 {
            return None;
        }
        let counts = self.counts.map(|count| count.div_ceil(2));
        let mut next = Self {
            counts,
            blocks: vec![Block::EMPTY; counts.iter().product()],
        };
        let [fast, middle, slow] = self.counts;
        for c in 0..slow {
            for b in 0..middle {
                for a in 0..fast {
                    let index = next.index([a / 2, b / 2, c / 2]);
                    next.blocks[index].join(&self.blocks[self.index([a, b, c])]);
                }
            }
        }
        Some(next)
    }
}

/// The rows of a smallest block: one run for each row of cells.
fn rows_of(
    grid: &Grid,
    counts: [usize; 3],
    block: usize,
) -> impl Iterator<Item = Range<usize>> + use<'_> {
    let [fast, middle, slow] = grid.ordered_counts();
    let at = [
        block % counts[0],
        block / counts[0] % counts[1],
        block / (counts[0] * counts[1]),
    ];
    let [a, b, c] = [0, 1, 2].map(|k| at[k] * BLOCK[k]);
    let last = (a + BLOCK[0]).min(fast) - 1;
    let layers = c..(c + BLOCK[2]).min(slow);
    layers.flat_map(move |c| {
        let lines = b..(b + BLOCK[1]).min(middle);
        lines.map(move |b| {
            let line = grid.line(b, c);
            grid.rows(line + a, line + last)
        })
    })
}

#[cfg(test)]
mod tests {
    use mercury_common::random::Stream;
    use proptest::prelude::*;

    use super::*;
    use crate::cell::Cell;
    use crate::state::MaterialIndex;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// Every row is in one of the smallest blocks, which encloses it, and a search near a place finds all rows there.
        #[test]
        fn blocks_hold_their_particles(
            seed in any::<u64>(),
            count in 0usize..600,
            size in prop::array::uniform3(0.0..3.0f64),
            edge in 0.02..2.0f64,
            periodic in any::<[bool; 3]>(),
            parallel in any::<bool>(),
        ) {
            let mut random = Stream::new(seed, "boxes", 0);
            let size = DVec3::from(size) + 0.1;
            let domain = Cell::new(DVec3::ZERO, size, periodic);
            let mut draw = || DVec3::new(random.uniform(), random.uniform(), random.uniform());
            let places: Vec<DVec3> = (0..count).map(|_| draw() * size).collect();
            let (grid, order) = Grid::sort(count, |k| places[k], edge, &domain, parallel);
            let records: Vec<Particle> = order.iter().map(|&k| Particle {
                position: places[k as usize],
                radius: 0.01 * f64::from(k % 7 + 1),
                velocity: DVec3::ZERO,
                inverse_mass: f64::from(k % 5 > 0),
                angular_velocity: DVec3::ZERO,
                material: MaterialIndex::new(0),
                flags: 0,
            }).collect();
            let extra_skin: Vec<f64> = (0..count).map(|row| f64::from(row % 11 == 3)).collect();
            let boxes = Boxes::new(&grid, &records, &extra_skin, parallel);
            let mut seen = vec![0; count];
            for (index, block) in boxes.levels[0].blocks.iter().enumerate() {
                for row in boxes.rows(index as u32) {
                    seen[row] += 1;
                    let record = &records[row];
                    let x = record.position;
                    prop_assert!(record.inverse_mass == 0.0 ||
                        (x.cmpge(block.low).all() && x.cmple(block.high).all()
                            && record.radius + extra_skin[row] <= block.radius));
                }
            }
            prop_assert!(seen.iter().all(|&times| times == 1));
            let (place, reach) = (draw() * size, draw().x);
            let mut found = Vec::new();
            let near = |x: DVec3, radius: f64| x.distance(place) < reach + radius;
            boxes.find(|block| near(place.clamp(block.low, block.high), block.radius), &mut found);
            let rows: Vec<usize> = found.iter().flat_map(|&block| boxes.rows(block)).collect();
            for (row, record) in records.iter().enumerate() {
                let asked = record.inverse_mass > 0.0 && near(record.position, record.radius + extra_skin[row]);
                prop_assert!(!asked || rows.contains(&row));
            }
        }
    }
}
