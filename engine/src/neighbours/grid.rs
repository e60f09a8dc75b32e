//! Cells and the sort of the particles into them.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::lines::Lines;
use crate::cell::Cell;
use crate::parallel::{each, each_part};

/// A grid of cells over the particles; rows are sorted by cell, line by line along the fastest axis, the lines brick by brick (`lines.rs`).
///
/// Particles outside the outermost cells belong to the nearest one, so that neighbours stay neighbours. Axes are taken in
/// ascending order of extent, so that the slowest axis is the longest and layers are small.
#[derive(Debug, Clone)]
pub struct Grid {
    origin: DVec3,
    inverse_edge: DVec3,
    /// Cells along x, y, z.
    counts: [usize; 3],
    /// x, y and z in order from the fastest to the slowest.
    order: [usize; 3],
    lines: Lines,
    /// First row of each cell, and the number of rows at the end.
    pub(super) start: Vec<u32>,
}

impl Grid {
    /// A grid of cells not smaller than `edge` (m) over this many particles, and the order of rows by cell; `parallel`: with the
    /// threads of the pool from which this is called.
    ///
    /// Positions must be finite and, along periodic axes, inside the domain.
    #[must_use]
    pub fn sort(
        particles: usize,
        position: impl Fn(usize) -> DVec3 + Sync,
        edge: f64,
        domain: &Cell,
        parallel: bool,
    ) -> (Self, Vec<u32>) {
        let bounds = bounds(particles, &position, parallel);
        let mut grid = Self::over(particles, bounds, edge, domain);
        let rows = grid.put(particles, position, parallel);
        (grid, rows)
    }

    /// An empty grid of cells not smaller than `edge` (m) for this many particles, `bounds` (m) of them all.
    pub(super) fn over(
        particles: usize,
        [mut min, mut max]: [DVec3; 2],
        edge: f64,
        domain: &Cell,
    ) -> Self {
        if particles == 0 {
            (min, max) = (DVec3::ZERO, DVec3::ZERO);
        }
        let (low, high) = domain.faces();
        for axis in 0..3 {
            if domain.is_periodic(axis) {
                (min[axis], max[axis]) = (low[axis], high[axis]);
            }
        }
        let extent = max - min;
        // A dilute gas in a huge domain does not need a cell for each void.
        let most = 4 * particles + 64;
        // Without particles there is no length scale: one cell.
        let mut edge = if edge > 0.0 { edge } else { f64::INFINITY };
        let counts = loop {
            let count = |length: f64| (length / edge).floor().clamp(1.0, 1e6) as usize;
            let counts = [count(extent.x), count(extent.y), count(extent.z)];
            if counts.iter().map(|&n| n as f64).product::<f64>() <= most as f64 {
                break counts;
            }
            edge *= 1.25;
        };
        let mut order = [0, 1, 2];
        order.sort_by_key(|&axis| counts[axis]);
        let cells = counts.iter().product::<usize>();
        let lines = Lines::new(
            order.map(|axis| counts[axis]),
            particles as f64 / cells as f64,
        );
        let mut inverse_edge = DVec3::ZERO;
        for axis in 0..3 {
            if extent[axis] > 0.0 {
                inverse_edge[axis] = counts[axis] as f64 / extent[axis];
            }
        }
        Self {
            origin: min,
            inverse_edge,
            counts,
            order,
            lines,
            start: vec![0; cells + 1],
        }
    }

    /// Puts particles into the cells of an empty grid, and returns their order.
    pub(super) fn put(
        &mut self,
        particles: usize,
        position: impl Fn(usize) -> DVec3 + Sync,
        parallel: bool,
    ) -> Vec<u32> {
        let cell_of = each(particles, parallel, |row| self.cell(position(row)) as u32);
        let parts = if parallel && particles > FEW {
            rayon::current_num_threads()
        } else {
            1
        };
        self.put_into_cells(&cell_of, parts)
    }

    /// Finds the first row of each cell and returns the rows cell by cell, in each cell in their order; in this many parts in
    /// parallel.
    ///
    /// Every part reads all rows and handles those of its own cells: reading is cheap, and no two parts write to the same place.
    fn put_into_cells(&mut self, cell_of: &[u32], parts: usize) -> Vec<u32> {
        let cells = self.start.len() - 1;
        let mut counts = Vec::with_capacity(parts);
        let mut rest = &mut self.start[1..];
        for part in 0..parts {
            let range = cells * part / parts..cells * (part + 1) / parts;
            let (own, others) = rest.split_at_mut(range.len());
            rest = others;
            counts.push((range, own));
        }
        each_part(
            parts > 1,
            counts,
            |(range, own): (Range<usize>, &mut [u32])| {
                for &cell in cell_of {
                    if let Some(count) = own.get_mut((cell as usize).wrapping_sub(range.start)) {
                        *count += 1;
                    }
                }
            },
        );
        for cell in 0..cells {
            self.start[cell + 1] += self.start[cell];
        }
        let mut rows = vec![0; cell_of.len()];
        let mut places = Vec::with_capacity(parts);
        let mut rest = &mut rows[..];
        let mut first = 0;
        for part in 0..parts {
            // About equally many rows in each.
            let upto = (cell_of.len() * (part + 1) / parts) as u32;
            let end = if part + 1 == parts {
                cells
            } else {
                let end = self.start[..cells].partition_point(|&start| start < upto);
                end.max(first)
            };
            let begin = self.start[first];
            let (own, others) = rest.split_at_mut((self.start[end] - begin) as usize);
            rest = others;
            places.push((first, self.start[first..end].to_vec(), begin, own));
            first = end;
        }
        each_part(parts > 1, places, |(first, mut next, begin, own)| {
            for (row, &cell) in cell_of.iter().enumerate() {
                if let Some(place) = next.get_mut((cell as usize).wrapping_sub(first)) {
                    own[(*place - begin) as usize] = row as u32;
                    *place += 1;
                }
            }
        });
        rows
    }

    /// Cell coordinates of a position; outside positions get the nearest cell.
    #[inline]
    pub(super) fn coordinates(&self, position: DVec3) -> [usize; 3] {
        let scaled = (position - self.origin) * self.inverse_edge;
        let mut coordinates = [0; 3];
        for axis in 0..3 {
            // A cast from a negative number gives 0.
            coordinates[axis] = (scaled[axis] as usize).min(self.counts[axis] - 1);
        }
        coordinates
    }

    /// Index of the cell that holds a position.
    #[inline]
    fn cell(&self, position: DVec3) -> usize {
        self.index(self.coordinates(position))
    }

    /// Index of the cell with these coordinates.
    #[inline]
    pub(super) fn index(&self, coordinates: [usize; 3]) -> usize {
        let [fast, middle, slow] = self.order.map(|axis| coordinates[axis]);
        self.line(middle, slow) + fast
    }

    /// Cells along the fastest, the middle and the slowest axis.
    pub(super) fn ordered_counts(&self) -> [usize; 3] {
        [
            self.counts[self.order[0]],
            self.counts[self.order[1]],
            self.counts[self.order[2]],
        ]
    }

    /// Index of the first cell of the line of cells that is `b` along the middle and `c` along the slowest axis.
    #[inline]
    pub(super) fn line(&self, b: usize, c: usize) -> usize {
        self.counts[self.order[0]] * self.lines.at(b, c)
    }

    /// Indices of the first cells of the lines next to that line which come later; at most [`MOST_LATER`].
    pub(super) fn later_lines(&self, b: usize, c: usize) -> Vec<usize> {
        let fast = self.counts[self.order[0]];
        self.lines.later(b, c).map(|line| fast * line).collect()
    }

    /// The layers of cells in the order of the rows: which lines along the middle axis, and where along the slowest one.
    pub(super) fn layers(&self) -> Vec<(Range<usize>, usize)> {
        self.lines.layers()
    }

    /// Rows in the cells from index `first` to `last` inclusive.
    #[inline]
    pub(super) fn rows(&self, first: usize, last: usize) -> std::ops::Range<usize> {
        self.start[first] as usize..self.start[last + 1] as usize
    }

    /// Calls `visit` for every row whose cell may hold something within `reach` (m) of `position`, by whole cells.
    pub fn visit_near(&self, position: DVec3, reach: f64, mut visit: impl FnMut(usize)) {
        self.any_near(position, reach, |row| {
            visit(row);
            false
        });
    }

    /// Whether `test` is true of a row whose cell may hold something within `reach` (m) of `position`; those behind the first one are not tested.
    pub fn any_near(
        &self,
        position: DVec3,
        reach: f64,
        mut test: impl FnMut(usize) -> bool,
    ) -> bool {
        let low = self.coordinates(position - DVec3::splat(reach));
        let high = self.coordinates(position + DVec3::splat(reach));
        let [fast, middle, slow] = self.order;
        let mut cell = low;
        for c in low[slow]..=high[slow] {
            cell[slow] = c;
            for b in low[middle]..=high[middle] {
                cell[middle] = b;
                cell[fast] = low[fast];
                let first = self.index(cell);
                cell[fast] = high[fast];
                if self.rows(first, self.index(cell)).any(&mut test) {
                    return true;
                }
            }
        }
        false
    }
}

/// A line of cells has eight neighbours, half of which come later, and one more where bricks meet.
pub(super) const MOST_LATER: usize = 5;

/// Fewer particles than this are sorted faster by one thread.
const FEW: usize = 8192;

/// The smallest box along the axes that holds all positions (m); the largest and smallest number without any.
pub(super) fn bounds(
    particles: usize,
    position: &(impl Fn(usize) -> DVec3 + Sync),
    parallel: bool,
) -> [DVec3; 2] {
    let nothing = || [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let join = |[min, max]: [DVec3; 2], [low, high]: [DVec3; 2]| [min.min(low), max.max(high)];
    let add = |found, row| join(found, [position(row); 2]);
    if parallel && particles > FEW {
        let rows = (0..particles).into_par_iter().with_min_len(FEW / 4);
        rows.fold(nothing, add).reduce(nothing, join)
    } else {
        (0..particles).fold(nothing(), add)
    }
}

#[cfg(test)]
mod tests {
    use mercury_common::random::Stream;

    use super::*;

    /// However many parts there are, also more than cells, and with all particles in one corner.
    #[test]
    fn parts_do_not_change_the_order() {
        let domain = Cell::new(DVec3::ZERO, DVec3::ONE, [false, true, false]);
        let mut stream = Stream::new(5, "grid", 0);
        for (count, power, edge) in [(2000, 1, 0.07), (2000, 8, 0.11), (3, 1, 0.5), (0, 1, 0.1)] {
            let mut number = || stream.uniform().powi(power);
            let places: Vec<DVec3> = (0..count)
                .map(|_| DVec3::new(number(), number(), number()))
                .collect();
            let (mut grid, order) = Grid::sort(count, |k| places[k], edge, &domain, false);
            let cells: Vec<u32> = (places.iter().map(|&x| grid.cell(x) as u32)).collect();
            let mut expected: Vec<u32> = (0..count as u32).collect();
            expected.sort_by_key(|&row| cells[row as usize]);
            assert_eq!(order, expected);
            let start = grid.start.clone();
            for parts in [2, 3, 64] {
                grid.start.fill(0);
                assert_eq!(grid.put_into_cells(&cells, parts), expected, "{parts}");
                assert_eq!(grid.start, start);
            }
        }
    }
}
