//! Cells and the sort of the particles into them.

use glam::DVec3;

use super::Images;

/// A grid of cells over the particles; rows are sorted by cell, x-like axis fastest.
///
/// Particles outside the outermost cells belong to the nearest one, which keeps neighbours neighbours. Axes are taken in
/// ascending order of extent, so that the slowest axis is the longest and layers are small.
#[derive(Debug, Clone)]
pub struct Grid {
    origin: DVec3,
    inverse_edge: DVec3,
    /// Cells along x, y, z.
    counts: [usize; 3],
    /// x, y and z in order from the fastest to the slowest.
    order: [usize; 3],
    strides: [usize; 3],
    /// First row of each cell, and the number of rows at the end.
    pub(super) start: Vec<u32>,
}

impl Grid {
    /// A grid of cells not smaller than `edge` (m) over the particles, and the order of rows by cell.
    ///
    /// Positions must be finite and, along periodic axes, inside the domain.
    #[must_use]
    pub fn sort(
        positions: impl ExactSizeIterator<Item = DVec3> + Clone,
        edge: f64,
        images: &Images,
    ) -> (Self, Vec<u32>) {
        let particles = positions.len();
        let mut min = DVec3::INFINITY;
        let mut max = DVec3::NEG_INFINITY;
        for position in positions.clone() {
            min = min.min(position);
            max = max.max(position);
        }
        if particles == 0 {
            (min, max) = (DVec3::ZERO, DVec3::ZERO);
        }
        for axis in 0..3 {
            if images.periodic[axis] {
                min[axis] = images.min[axis];
                max[axis] = images.min[axis] + images.size[axis];
            }
        }
        let extent = max - min;
        // A thin gas in a huge domain does not need a cell for each of its voids.
        let most = 4 * particles + 64;
        // Without particles nothing sets a size: one cell.
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
        let mut strides = [0; 3];
        strides[order[0]] = 1;
        strides[order[1]] = counts[order[0]];
        strides[order[2]] = counts[order[0]] * counts[order[1]];
        let mut inverse_edge = DVec3::ZERO;
        for axis in 0..3 {
            if extent[axis] > 0.0 {
                inverse_edge[axis] = counts[axis] as f64 / extent[axis];
            }
        }
        let cells = counts.iter().product::<usize>();
        let mut grid = Self {
            origin: min,
            inverse_edge,
            counts,
            order,
            strides,
            start: vec![0; cells + 1],
        };

        let cell_of: Vec<u32> = positions
            .map(|position| grid.cell(position) as u32)
            .collect();
        for &cell in &cell_of {
            grid.start[cell as usize + 1] += 1;
        }
        for cell in 0..cells {
            grid.start[cell + 1] += grid.start[cell];
        }
        let mut next = grid.start.clone();
        let mut rows = vec![0; particles];
        for (row, &cell) in cell_of.iter().enumerate() {
            let place = &mut next[cell as usize];
            rows[*place as usize] = row as u32;
            *place += 1;
        }
        (grid, rows)
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
        coordinates[0] * self.strides[0]
            + coordinates[1] * self.strides[1]
            + coordinates[2] * self.strides[2]
    }

    /// Cells along the fastest, the middle and the slowest axis.
    pub(super) fn ordered_counts(&self) -> [usize; 3] {
        [
            self.counts[self.order[0]],
            self.counts[self.order[1]],
            self.counts[self.order[2]],
        ]
    }

    /// Rows in the cells from index `first` to `last` inclusive.
    #[inline]
    pub(super) fn rows(&self, first: usize, last: usize) -> std::ops::Range<usize> {
        self.start[first] as usize..self.start[last + 1] as usize
    }

    /// Calls `visit` for every row whose cell may hold something within `reach` (m) of `position`, by whole cells.
    pub fn visit_near(&self, position: DVec3, reach: f64, mut visit: impl FnMut(usize)) {
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
                for row in self.rows(first, self.index(cell)) {
                    visit(row);
                }
            }
        }
    }
}
