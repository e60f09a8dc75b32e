//! Cells and the sort of the particles into them.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::bricks::{Division, LAYER};
use crate::cell::Cell;
use crate::parallel::{each, each_part};

/// A grid of cells over the particles; rows are sorted by cell, brick by brick, in a brick line by line along its fastest axis.
///
/// Particles touch others in the next line of the same layer, or in the next layer. With large layers, the next layer is far away
/// in memory: the data would have left the cache before it is used again. So a grid of large layers consists of bricks (`bricks.rs`) along a Hilbert
/// curve, and only of those that hold a particle. A grid of small layers is a single brick about all particles. Its axes are taken in
/// ascending order of extent, so that the slowest axis is the longest and layers are small.
///
/// Particles outside the outermost cells belong to the nearest one, so that neighbours stay neighbours.
#[derive(Debug, Clone)]
pub struct Grid {
    places: Places,
    /// x, y and z in order from the fastest to the slowest.
    order: [usize; 3],
    /// Cells of a brick along x, y and z.
    cells: [usize; 3],
    /// Bricks of the box around all that hold a particle, along x, y and z.
    bricks: [usize; 3],
    /// The bricks of that box by their place in the order of rows; [`NONE`] without particles.
    rank: Vec<u32>,
    /// Where in that box the bricks are, in the order of rows.
    at: Vec<u32>,
    /// First row of each cell, and the number of rows at the end.
    pub(super) start: Vec<u32>,
}

/// How positions become cells.
#[derive(Debug, Clone, Copy)]
enum Places {
    /// A single brick with this lower corner (m) and inverse edges of cells (1/m).
    Whole(DVec3, DVec3),
    /// Bricks, in a box with this lowest brick.
    Bricks(Division, [u32; 3]),
}

/// No brick.
const NONE: u32 = u32::MAX;

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
        Self::sort_within(particles, position, bounds, edge, domain, parallel)
    }

    /// [`sort`](Self::sort) with the bounds (m) of all positions.
    pub(super) fn sort_within(
        particles: usize,
        position: impl Fn(usize) -> DVec3 + Sync,
        [mut min, mut max]: [DVec3; 2],
        edge: f64,
        domain: &Cell,
        parallel: bool,
    ) -> (Self, Vec<u32>) {
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
        let least = if edge > 0.0 { edge } else { f64::INFINITY };
        let mut edge = least;
        let count = |length: f64, edge: f64| (length / edge).floor().clamp(1.0, 1e6) as usize;
        let counts = loop {
            let counts = extent.to_array().map(|length| count(length, edge));
            if counts.iter().map(|&n| n as f64).product::<f64>() <= most as f64 {
                break counts;
            }
            edge *= 1.25;
        };
        let mut order = [0, 1, 2];
        order.sort_by_key(|&axis| counts[axis]);
        let slowest = counts[order[2]];
        let (mut grid, cell_of) = if particles as f64 / slowest as f64 > LAYER {
            Self::of_bricks(particles, &position, least, domain, parallel)
        } else {
            let mut inverse_edge = DVec3::ZERO;
            for axis in 0..3 {
                if extent[axis] > 0.0 {
                    inverse_edge[axis] = counts[axis] as f64 / extent[axis];
                }
            }
            let grid = Self {
                places: Places::Whole(min, inverse_edge),
                order,
                cells: counts,
                bricks: [1; 3],
                rank: vec![0],
                at: vec![0],
                start: Vec::new(),
            };
            let cell = |row| grid.in_brick(grid.coordinates(position(row))) as u32;
            let cell_of = each(particles, parallel, cell);
            (grid, cell_of)
        };
        grid.start = vec![0; grid.first_cell(grid.at.len()) + 1];
        let rows = if parallel && particles > FEW {
            grid.put_into_cells(&cell_of, rayon::current_num_threads())
        } else {
            grid.put_into_cells(&cell_of, 1)
        };
        (grid, rows)
    }

    /// Bricks of cells not smaller than `edge` (m) where there are particles, and the cell of each; rows are not sorted yet.
    fn of_bricks(
        particles: usize,
        position: &(impl Fn(usize) -> DVec3 + Sync),
        mut edge: f64,
        domain: &Cell,
        parallel: bool,
    ) -> (Self, Vec<u32>) {
        let most = 4 * particles + 64;
        loop {
            let division = Division::new(domain, edge);
            edge *= 1.25;
            let mut grid = Self {
                places: Places::Bricks(division, [0; 3]),
                order: [0, 1, 2],
                cells: division.cells,
                bricks: [0; 3],
                rank: Vec::new(),
                at: Vec::new(),
                start: Vec::new(),
            };
            let place = |row| {
                let (brick, cell) = division.at(position(row));
                (brick, grid.in_brick(cell) as u32)
            };
            let places = each(particles, parallel, place);
            let (mut low, mut high) = ([u32::MAX; 3], [0; 3]);
            for (brick, _) in &places {
                for axis in 0..3 {
                    low[axis] = low[axis].min(brick[axis]);
                    high[axis] = high[axis].max(brick[axis]);
                }
            }
            let counts = [0, 1, 2].map(|axis| (high[axis] - low[axis]) as usize + 1);
            if counts.iter().map(|&n| n as f64).product::<f64>() > most as f64 {
                continue;
            }
            (grid.places, grid.bricks) = (Places::Bricks(division, low), counts);
            let in_box =
                |brick: &[u32; 3]| [0, 1, 2].map(|axis| (brick[axis] - low[axis]) as usize);
            let mut rank = vec![NONE; counts.iter().product()];
            for (brick, _) in &places {
                rank[grid.in_box(in_box(brick))] = 0;
            }
            let [x, y, _] = counts;
            let mut along: Vec<(u64, u32)> = (rank.iter().enumerate())
                .filter(|&(_, &rank)| rank != NONE)
                .map(|(at, _)| {
                    let brick = [at % x, at / x % y, at / (x * y)];
                    let brick = [0, 1, 2].map(|axis| low[axis] + brick[axis] as u32);
                    (division.order(brick), at as u32)
                })
                .collect();
            if grid.first_cell(along.len()) > most {
                continue;
            }
            along.sort_unstable();
            for (k, &(_, at)) in (0..).zip(&along) {
                rank[at as usize] = k;
            }
            grid.at = along.into_iter().map(|(_, at)| at).collect();
            grid.rank = rank;
            let cell_of = each(particles, parallel, |row| {
                let (brick, cell) = &places[row];
                let rank = grid.rank[grid.in_box(in_box(brick))];
                grid.first_cell(rank as usize) as u32 + cell
            });
            return (grid, cell_of);
        }
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

    /// The cell that holds a position, counted along x, y and z through the box of all bricks; outside positions get the nearest cell.
    #[inline]
    fn coordinates(&self, position: DVec3) -> [usize; 3] {
        let mut coordinates = [0; 3];
        match &self.places {
            Places::Whole(low, inverse_edge) => {
                let scaled = (position - low) * inverse_edge;
                for axis in 0..3 {
                    // A cast from a negative number gives 0.
                    coordinates[axis] = (scaled[axis] as usize).min(self.cells[axis] - 1);
                }
            }
            Places::Bricks(division, low) => {
                let (brick, cell) = division.at(position);
                for axis in 0..3 {
                    let cells = self.cells[axis];
                    coordinates[axis] = match brick[axis].checked_sub(low[axis]) {
                        None => 0,
                        Some(ahead) => {
                            (ahead as usize * cells + cell[axis]).min(self.bricks[axis] * cells - 1)
                        }
                    };
                }
            }
        }
        coordinates
    }

    /// Index of a brick in the box of all bricks.
    #[inline]
    fn in_box(&self, [x, y, z]: [usize; 3]) -> usize {
        x + self.bricks[0] * (y + self.bricks[1] * z)
    }

    /// Index in its brick of a cell with these coordinates in it.
    #[inline]
    fn in_brick(&self, cell: [usize; 3]) -> usize {
        let [fast, middle, slow] = self.order.map(|axis| cell[axis]);
        let [of_line, lines, _] = self.cells_of_brick();
        fast + of_line * (middle + lines * slow)
    }

    /// Number of bricks.
    pub(super) fn brick_count(&self) -> usize {
        self.at.len()
    }

    /// Cells of a brick along its fastest, its middle and its slowest axis.
    #[inline]
    pub(super) fn cells_of_brick(&self) -> [usize; 3] {
        self.order.map(|axis| self.cells[axis])
    }

    /// Index of the first cell of a brick.
    #[inline]
    pub(super) fn first_cell(&self, brick: usize) -> usize {
        brick * self.cells.iter().product::<usize>()
    }

    /// Index of the first cell of the line of cells of a brick that is `b` along its middle and `c` along its slowest axis.
    #[inline]
    pub(super) fn line(&self, brick: usize, b: usize, c: usize) -> usize {
        let [of_line, lines, _] = self.cells_of_brick();
        self.first_cell(brick) + of_line * (b + lines * c)
    }

    /// Parts of the grid in the order of rows: bricks, or layers of a single one.
    pub(super) fn parts(&self) -> Vec<(usize, Range<usize>)> {
        let [.., layers] = self.cells_of_brick();
        match self.places {
            Places::Whole(..) => (0..layers).map(|c| (0, c..c + 1)).collect(),
            Places::Bricks(..) => (0..self.at.len()).map(|k| (k, 0..layers)).collect(),
        }
    }

    /// The rows of such a part.
    pub(super) fn rows_of_part(&self, brick: usize, layers: &Range<usize>) -> Range<usize> {
        if layers.is_empty() {
            return 0..0;
        }
        let [fast, lines, _] = self.cells_of_brick();
        let last = self.line(brick, lines - 1, layers.end - 1) + fast - 1;
        self.rows(self.line(brick, 0, layers.start), last)
    }

    /// The rows of all parts of the grid with a cell that may hold something within `reach` (m) of a box along the axes (its corners, m), or that is beside
    /// such a cell; ascending.
    pub(super) fn rows_about(&self, [low, high]: [DVec3; 2], reach: f64) -> Vec<Range<usize>> {
        let low = self.coordinates(low - DVec3::splat(reach));
        let high = self.coordinates(high + DVec3::splat(reach));
        let [x, y, _] = self.bricks;
        let slowest = self.order[2];
        let is_about = |(brick, layers): &(usize, Range<usize>)| {
            let at = self.at[*brick] as usize;
            let own = [at % x, at / x % y, at / (x * y)];
            (0..3).all(|axis| {
                let cells = self.cells[axis];
                let layers = if axis == slowest {
                    layers.clone()
                } else {
                    0..cells
                };
                let first = own[axis] * cells;
                first + layers.start <= high[axis] + 1 && low[axis] <= first + layers.end
            })
        };
        let parts = self.parts();
        let about = parts.iter().filter(|part| is_about(part));
        let rows = about.map(|(brick, layers)| self.rows_of_part(*brick, layers));
        rows.filter(|rows| !rows.is_empty()).collect()
    }

    /// The bricks about a brick that come later, and itself, by their places along the fastest, the middle and the slowest axis: 0 before it,
    /// 1 beside it, 2 behind it.
    pub(super) fn around(&self, brick: usize) -> Around {
        let mut around = [[[None; 3]; 3]; 3];
        let at = self.at[brick] as usize;
        let [x, y, _] = self.bricks;
        let own = [at % x, at / x % y, at / (x * y)];
        for (c, b, a) in (0..27).map(|k| (k / 9, k / 3 % 3, k % 3)) {
            let mut there = own;
            for (step, axis) in [a, b, c].into_iter().zip(self.order) {
                // One too far before it is beyond the box as well.
                there[axis] = (own[axis] + step).wrapping_sub(1);
            }
            if (0..3).all(|axis| there[axis] < self.bricks[axis]) {
                let rank = self.rank[self.in_box(there)];
                let is_later = rank != NONE && rank as usize >= brick;
                around[c][b][a] = is_later.then_some(rank as usize);
            }
        }
        around
    }

    /// Finds the later cells about the line of cells that is `b` along the middle and `c` along the slowest axis of a brick.
    pub(super) fn later_lines(
        &self,
        brick: usize,
        around: &Around,
        (b, c): (usize, usize),
        later: &mut LaterLines,
    ) {
        let LaterLines {
            lines,
            before,
            behind,
        } = later;
        for cells in [&mut *lines, before, behind] {
            cells.clear();
        }
        let [of_line, count, layers] = self.cells_of_brick();
        // One before the first is the last of the brick before.
        let beside = |at: usize, step: usize, count: usize| match at + step {
            0 => (0, count - 1),
            next if next > count => (2, 0),
            next => (1, next - 1),
        };
        for (step_c, step_b) in (0..9).map(|k| (k / 3, k % 3)) {
            let (brick_c, c) = beside(c, step_c, layers);
            let (brick_b, b) = beside(b, step_b, count);
            let around = around[brick_c][brick_b];
            let line = |brick| self.line(brick, b, c);
            before.extend(around[0].map(|brick| line(brick) + of_line - 1));
            let is_later = |&other: &usize| other > brick || (step_c, step_b) > (1, 1);
            lines.extend(around[1].filter(is_later).map(line));
            behind.extend(around[2].map(line));
        }
    }

    /// Rows in the cells from index `first` to `last` inclusive.
    #[inline]
    pub(super) fn rows(&self, first: usize, last: usize) -> Range<usize> {
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
        let [first, last] = [low, high].map(|at| [0, 1, 2].map(|axis| at[axis] / self.cells[axis]));
        for z in first[2]..=last[2] {
            for y in first[1]..=last[1] {
                for x in first[0]..=last[0] {
                    let rank = self.rank[self.in_box([x, y, z])];
                    if rank == NONE {
                        continue;
                    }
                    // The cells of the brick that are within the box of cells.
                    let ranges = self.order.map(|axis| {
                        let cells = self.cells[axis];
                        let begin = [x, y, z][axis] * cells;
                        low[axis].max(begin) - begin..=high[axis].min(begin + cells - 1) - begin
                    });
                    let [a, b, c] = ranges;
                    for c in c {
                        for b in b.clone() {
                            let line = self.line(rank as usize, b, c);
                            if self.rows(line + a.start(), line + a.end()).any(&mut test) {
                                return true;
                            }
                        }
                    }
                }
            }
        }
        false
    }
}

/// Bricks about a brick, by their places along the slowest, the middle and the fastest axis.
pub(super) type Around = [[[Option<usize>; 3]; 3]; 3];

/// Cells about a line of cells that come later in the order of rows, by their indices.
#[derive(Debug, Default)]
pub(super) struct LaterLines {
    /// First cells of the lines beside it.
    pub(super) lines: Vec<usize>,
    /// Cells before its first cell, in the bricks before.
    pub(super) before: Vec<usize>,
    /// Cells behind its last cell, in the bricks behind.
    pub(super) behind: Vec<usize>,
}

/// Most runs of rows near a cell that come later: those of nine lines of cells, and of the same lines in the bricks before and behind.
pub(super) const MOST_RUNS: usize = 27;

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

    /// One particle far outside of the domain, and a gas that hardly fills it: bricks are those that hold a particle, cells are not many more than
    /// particles, and a search near each finds it.
    #[test]
    fn few_bricks_hold_all_particles_however_far_apart() {
        let mut stream = Stream::new(6, "grid", 0);
        for (size, far, edge) in [(1.0, 1e6, 0.05), (300.0, 0.0, 0.05), (1.0, 3.0, 0.2)] {
            let domain = Cell::new(DVec3::ZERO, DVec3::splat(size), [false; 3]);
            let mut places: Vec<DVec3> = (0..3000)
                .map(|_| DVec3::from([0; 3].map(|_| size * stream.uniform())))
                .collect();
            places[7] += DVec3::splat(far);
            let (mut grid, cell_of) =
                Grid::of_bricks(places.len(), &|k| places[k], edge, &domain, false);
            grid.start = vec![0; grid.first_cell(grid.at.len()) + 1];
            let order = grid.put_into_cells(&cell_of, 1);
            assert!(
                grid.start.len() <= 4 * places.len() + 65,
                "{}",
                grid.start.len()
            );
            assert!(grid.at.len() <= places.len());
            for (row, &k) in order.iter().enumerate() {
                assert!(grid.any_near(places[k as usize], 0.0, |other| other == row));
            }
        }
    }

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
            let cell = |position: &DVec3| {
                let at = grid.coordinates(*position);
                let brick = [0, 1, 2].map(|axis| at[axis] / grid.cells[axis]);
                let cell = [0, 1, 2].map(|axis| at[axis] % grid.cells[axis]);
                let rank = grid.rank[grid.in_box(brick)] as usize;
                (grid.first_cell(rank) + grid.in_brick(cell)) as u32
            };
            let cells: Vec<u32> = places.iter().map(cell).collect();
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
