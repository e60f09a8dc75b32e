//! The space that is occupied for new particles: the present particles, in cells.

use std::ops::Range;

use glam::DVec3;

use crate::cell::Cell;
use crate::neighbours::Cells;
use crate::state::Particles;

/// Rows that are compared one by one before they are sorted into cells.
const FEW: usize = 32;
/// Ratio of the sizes of successive blocks: the larger, the fewer blocks there are, and the more often a row is sorted.
const GROWTH: usize = 8;

/// The particles that a new one could overlap: those of the last candidate list in its own cells, those that came since in blocks.
///
/// Cells hold the listed positions. They serve until the next list, as particles stay within a margin of these places until then.
#[derive(Debug, Clone, Default)]
pub(super) struct Occupied {
    /// Consecutive rows, larger blocks first.
    blocks: Vec<Block>,
}

#[derive(Debug, Clone)]
struct Block {
    rows: Range<usize>,
    cells: Cells,
}

impl Occupied {
    /// The candidate list was built, with these cells of so many rows.
    pub(super) fn listed(&mut self, rows: usize, cells: Cells) {
        self.blocks.clear();
        self.blocks.push(Block {
            rows: 0..rows,
            cells,
        });
    }

    /// Rows were removed, so that others have changed their numbers.
    pub(super) fn forget(&mut self) {
        self.blocks.clear();
    }

    /// Sorts the rows that were appended, but for the last few.
    pub(super) fn take_in(&mut self, particles: &Particles, cell: &Cell) {
        let end = particles.len();
        let mut rows = self.end()..end;
        if rows.len() < FEW {
            return;
        }
        let order = |rows: &Range<usize>| (rows.len() / FEW).max(1).ilog(GROWTH);
        while let Some(last) = self.blocks.last()
            && order(&last.rows) <= order(&rows)
        {
            rows.start = last.rows.start;
            self.blocks.pop();
        }
        let cells = Cells::sort(rows.clone(), particles, cell);
        self.blocks.push(Block { rows, cells });
    }

    /// Whether a sphere at `centre` (m) of `radius` (m) would overlap a particle or an image of one; touching is not overlapping.
    /// `margin` (m): the largest distance of particles from
    /// their listed positions.
    pub(super) fn overlaps(
        &self,
        particles: &Particles,
        cell: &Cell,
        (centre, radius): (DVec3, f64),
        margin: f64,
    ) -> bool {
        let meets = |row: usize| {
            let record = &particles.records[row];
            let branch = cell.min_image(record.position - centre, DVec3::ZERO).0;
            let contact = record.radius + radius;
            branch.length_squared() < contact * contact
        };
        let reach = radius + margin;
        let mut blocks = self.blocks.iter();
        blocks.any(|block| block.cells.any_near(centre, reach, cell, meets))
            || (self.end()..particles.len()).any(meets)
    }

    /// The first row that is in no block.
    fn end(&self) -> usize {
        self.blocks.last().map_or(0, |block| block.rows.end)
    }
}
