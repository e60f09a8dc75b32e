//! Bricks: boxes of cells that follow one another in the order of rows.

use glam::DVec3;

use super::hilbert;
use crate::cell::Cell;

// Both are smaller in unit tests, so that their few particles lie in bricks too.

/// A layer of cells up to this many rows is never cut into bricks: the data that a step reads before the rows of the next layer fits into the
/// second-level cache of one core.
pub(super) const LAYER: f64 = if cfg!(test) { 40.0 } else { 1600.0 };
/// Least cells of a brick along an axis; twice as many are two bricks, but along axes along which the domain is too short for that.
const FEWEST: f64 = if cfg!(test) { 2.0 } else { 8.0 };
/// Of the levels of the tree, two are above the domain.
const MOST_LEVELS: i32 = hilbert::MOST_BITS as i32 - 2;
/// Most cells of a brick along an axis, so that those from the root on can be counted.
const MOST_CELLS: f64 = 1000.0;

/// The division of space into bricks, and of bricks into cells.
///
/// A brick is a node of an octree whose root holds the domain 1 to 4 times along each axis, so that places outside of the domain have bricks, too.
/// Bricks depend on the domain and on their level alone, and those of a finer level follow one another in place of the coarser one (but outside of the
/// domain where it is too thin to be divided at the coarser level). So the order of rows outlasts changes of the particles' bounding box and of the
/// size of cells.
#[derive(Debug, Clone, Copy)]
pub(super) struct Division {
    /// Lower corner of the root, m.
    origin: DVec3,
    /// 1/m
    inverse_edge: DVec3,
    /// Cells of a brick along x, y and z.
    pub(super) cells: [usize; 3],
    /// Bits of a coordinate of a brick.
    bits: u32,
    /// First and last cell along each axis, counted from the origin.
    ends: [[u32; 2]; 3],
}

impl Division {
    /// Cells not smaller than `edge` (m, above 0).
    pub(super) fn new(domain: &Cell, edge: f64) -> Self {
        let size = domain.size();
        let longest = size.max_element();
        // How many times the domain is halved along each axis when it is halved the most along its longest one, less that number. Bricks are nearly cubes so.
        let fewer =
            [0, 1, 2].map(|axis| libm::round(libm::log2(longest / size[axis])).min(1e3) as i32);
        let halvings = |axis: usize, level: i32| (level - fewer[axis]).max(0);
        let cells_at =
            |axis: usize, level: i32| size[axis] / f64::from(1u32 << halvings(axis, level)) / edge;
        // An axis that is not divided yet does not limit the level.
        let fits = |level: i32| {
            (0..3).all(|axis| halvings(axis, level) == 0 || cells_at(axis, level) >= FEWEST)
        };
        let level = (1..=MOST_LEVELS)
            .take_while(|&level| fits(level))
            .last()
            .unwrap_or(0);
        let cells = [0, 1, 2].map(|axis| cells_at(axis, level).clamp(1.0, MOST_CELLS) as usize);
        let first = 1u32 << level;
        let (mut origin, mut inverse_edge, mut ends) = (domain.low(), DVec3::ZERO, [[0, 0]; 3]);
        for axis in 0..3 {
            let bricks = 1 << halvings(axis, level);
            let cells = cells[axis] as u32;
            if size[axis] > 0.0 {
                origin[axis] -= f64::from(first) * (size[axis] / f64::from(bricks));
                inverse_edge[axis] = f64::from(bricks * cells) / size[axis];
            }
            ends[axis] = if domain.is_periodic(axis) {
                [first * cells, (first + bricks) * cells - 1]
            } else {
                [0, 4 * first * cells - 1]
            };
        }
        Self {
            origin,
            inverse_edge,
            cells,
            bits: level as u32 + 2,
            ends,
        }
    }

    /// The brick that holds a position, and the cell in it, along x, y and z; the nearest one of those that are too far outside of the domain.
    #[inline]
    pub(super) fn at(&self, position: DVec3) -> ([u32; 3], [usize; 3]) {
        let scaled = (position - self.origin) * self.inverse_edge;
        let (mut brick, mut cell) = ([0; 3], [0; 3]);
        for axis in 0..3 {
            let [first, last] = self.ends[axis];
            // A cast from a negative number gives 0, from a large one the largest.
            let along = (scaled[axis] as u32).clamp(first, last);
            let cells = self.cells[axis] as u32;
            brick[axis] = along / cells;
            cell[axis] = (along % cells) as usize;
        }
        (brick, cell)
    }

    /// Where a brick is in the order of bricks.
    pub(super) fn order(&self, brick: [u32; 3]) -> u64 {
        hilbert::index(brick, self.bits)
    }
}

#[cfg(test)]
mod tests {
    use mercury_common::random::Stream;
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Cells are not smaller than they must be, and at most by one in [`FEWEST`] larger along axes that are divided. A brick of fine cells follows
        /// its neighbours as the brick of coarse cells does that holds it, also outside of the domain.
        #[test]
        fn the_order_outlasts_changes_of_the_size_of_cells(
            seed in any::<u64>(),
            exponents in prop::array::uniform3(-2.0..2.0f64),
            periodic in any::<[bool; 3]>(),
            coarse in 0.01..1.0f64,
            finer in 0.02..1.0f64,
        ) {
            let size = DVec3::from(exponents.map(libm::exp));
            let domain = Cell::new(DVec3::new(3.0, -1.0, 0.2), DVec3::new(3.0, -1.0, 0.2) + size, periodic);
            let (coarse, finer) = (coarse * size.max_element(), finer * coarse * size.max_element());
            let [few, many] = [coarse, finer].map(|edge| Division::new(&domain, edge));
            for (division, edge) in [(&few, coarse), (&many, finer)] {
                let [low, high] = [domain.low(), domain.low() + size].map(|corner| (corner - division.origin) * division.inverse_edge);
                for axis in 0..3 {
                    let own = 1.0 / division.inverse_edge[axis];
                    prop_assert!(own >= edge * (1.0 - 1e-12) || division.ends[axis] == [0, 0] || size[axis] < edge);
                    let is_divided = high[axis] - low[axis] > 1.5 * division.cells[axis] as f64;
                    prop_assert!(!is_divided || own < edge * (1.0 + 1.0 / FEWEST) * (1.0 + 1e-12));
                }
            }
            let levels = many.bits - few.bits;
            let mut random = Stream::new(seed, "bricks", 0);
            for _ in 0..50 {
                let at = DVec3::new(random.uniform(), random.uniform(), random.uniform());
                // Up to half the size outside of the domain.
                let stretched = |axis: usize| {
                    let bricks = size[axis] * few.inverse_edge[axis] / few.cells[axis] as f64;
                    if periodic[axis] || bricks < 1.5 { at[axis] } else { 2.0 * at[axis] - 0.5 }
                };
                let at = domain.low() + size * DVec3::new(stretched(0), stretched(1), stretched(2));
                let [coarse, fine] = [&few, &many].map(|division| division.order(division.at(at).0));
                prop_assert_eq!(fine >> (3 * levels), coarse);
            }
        }
    }

    /// Places beyond the root belong to its outermost cells.
    #[test]
    fn places_far_outside_have_a_brick() {
        let domain = Cell::new(DVec3::ZERO, DVec3::ONE, [false; 3]);
        let division = Division::new(&domain, 0.01);
        for (far, expected) in [(-1e9, 0), (1e9, (1 << division.bits) - 1)] {
            let (brick, _) = division.at(DVec3::splat(far));
            assert_eq!(brick, [expected; 3]);
        }
    }
}
