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

/// One level of blocks.
#[derive(Debug)]
struct Level {
    division: Blocks,
    blocks: Vec<Block>,
}

/// How blocks lie.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Blocks {
    /// So many in each brick along its fastest, its middle and its slowest axis, brick by brick.
    InBricks([usize; 3]),
    /// Of bricks that follow one another.
    OfBricks,
}

/// Blocks of bricks, or of such blocks, that are a block of the next level.
const JOINED: usize = 8;

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
            for rows in rows_of(grid, index) {
                block.join(&of_rows(rows));
            }
            block
        };
        let counts = blocks_of_brick(grid);
        let all = 0..grid.brick_count() * counts.iter().product::<usize>();
        let blocks = if parallel {
            all.into_par_iter().with_min_len(64).map(smallest).collect()
        } else {
            all.map(smallest).collect()
        };
        let division = Blocks::InBricks(counts);
        let mut levels = vec![Level { division, blocks }];
        while let Some(next) = levels.last().and_then(Level::joined) {
            levels.push(next);
        }
        Self { grid, levels }
    }

    /// Appends to `found` the smallest blocks of which `may_matter` is true; blocks inside of one of which it is false are not
    /// tested.
    pub fn find(&self, mut may_matter: impl FnMut(&Block) -> bool, found: &mut Vec<u32>) {
        let mut stack = vec![(self.levels.len() - 1, 0)];
        while let Some((height, index)) = stack.pop() {
            let block = &self.levels[height].blocks[index];
            if block.is_empty() || !may_matter(block) {
                continue;
            }
            if height == 0 {
                found.push(index as u32);
                continue;
            }
            let first = stack.len();
            let below = |index| stack.push((height - 1, index));
            self.levels[height - 1].inside(&self.levels[height].division, index, below);
            // The first of them is the next.
            stack[first..].reverse();
        }
    }

    /// The rows of one of the smallest blocks.
    pub fn rows(&self, block: u32) -> impl Iterator<Item = usize> {
        rows_of(self.grid, block as usize).flatten()
    }
}

impl Level {
    /// Calls `each` for the blocks of this level inside a block of the next one, which lies by `above`.
    fn inside(&self, above: &Blocks, index: usize, mut each: impl FnMut(usize)) {
        match (&self.division, above) {
            (&Blocks::InBricks(counts), &Blocks::InBricks(fewer)) => {
                let (brick, [a, b, c]) = at(index, fewer);
                for c in 2 * c..counts[2].min(2 * c + 2) {
                    for b in 2 * b..counts[1].min(2 * b + 2) {
                        for a in 2 * a..counts[0].min(2 * a + 2) {
                            each(index_of(brick, [a, b, c], counts));
                        }
                    }
                }
            }
            _ => (JOINED * index..self.blocks.len().min(JOINED * (index + 1))).for_each(each),
        }
    }

    /// The level whose blocks hold up to eight of these; none above the single one.
    fn joined(&self) -> Option<Self> {
        if self.blocks.len() <= 1 {
            return None;
        }
        let (division, count) = match self.division {
            Blocks::InBricks(counts) if counts != [1; 3] => {
                let fewer = counts.map(|count| count.div_ceil(2));
                let bricks = self.blocks.len() / counts.iter().product::<usize>();
                (
                    Blocks::InBricks(fewer),
                    bricks * fewer.iter().product::<usize>(),
                )
            }
            _ => (Blocks::OfBricks, self.blocks.len().div_ceil(JOINED)),
        };
        let mut blocks = vec![Block::EMPTY; count];
        for (index, block) in blocks.iter_mut().enumerate() {
            self.inside(&division, index, |inside| block.join(&self.blocks[inside]));
        }
        Some(Self { division, blocks })
    }
}

/// The smallest blocks of each brick along its fastest, its middle and its slowest axis.
fn blocks_of_brick(grid: &Grid) -> [usize; 3] {
    let cells = grid.cells_of_brick();
    [0, 1, 2].map(|k| cells[k].div_ceil(BLOCK[k]))
}

/// The brick of a block, and where in it that is, with so many in each.
fn at(index: usize, [x, y, z]: [usize; 3]) -> (usize, [usize; 3]) {
    (
        index / (x * y * z),
        [index % x, index / x % y, index / (x * y) % z],
    )
}

/// The reverse of [`at`].
fn index_of(brick: usize, [a, b, c]: [usize; 3], [x, y, z]: [usize; 3]) -> usize {
    a + x * (b + y * (c + z * brick))
}

/// The rows of a smallest block: one run for each row of cells.
fn rows_of(grid: &Grid, block: usize) -> impl Iterator<Item = Range<usize>> + use<'_> {
    let [fast, middle, slow] = grid.cells_of_brick();
    let (brick, at) = at(block, blocks_of_brick(grid));
    let [a, b, c] = [0, 1, 2].map(|k| at[k] * BLOCK[k]);
    let last = (a + BLOCK[0]).min(fast) - 1;
    let layers = c..(c + BLOCK[2]).min(slow);
    layers.flat_map(move |c| {
        let lines = b..(b + BLOCK[1]).min(middle);
        lines.map(move |b| {
            let line = grid.line(brick, b, c);
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
