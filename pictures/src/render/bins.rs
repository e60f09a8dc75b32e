//! Bins: the objects that may touch each tile.

use super::TILE;

/// A rectangle of samples, the upper ends outside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Rect {
    pub(super) x0: usize,
    pub(super) y0: usize,
    pub(super) x1: usize,
    pub(super) y1: usize,
}

impl Rect {
    /// The samples whose centres (at halves) may lie in the given range, inside `columns` x `rows`; none if there are none.
    pub(super) fn around(
        (left, top): (f64, f64),
        (right, bottom): (f64, f64),
        columns: usize,
        rows: usize,
    ) -> Option<Self> {
        // Casts hold the values to the range of usize; NaN becomes 0.
        let first = |low: f64| (low - 0.5).ceil().max(0.0) as usize;
        let end = |high: f64, limit: usize| {
            ((high - 0.5).floor() + 1.0).clamp(0.0, limit as f64) as usize
        };
        let rect = Self {
            x0: first(left),
            y0: first(top),
            x1: end(right, columns),
            y1: end(bottom, rows),
        };
        (rect.x0 < rect.x1 && rect.y0 < rect.y1).then_some(rect)
    }

    pub(super) fn cut(self, other: Self) -> Self {
        Self {
            x0: self.x0.max(other.x0),
            y0: self.y0.max(other.y0),
            x1: self.x1.min(other.x1),
            y1: self.y1.min(other.y1),
        }
    }
}

/// For each tile the things whose rectangles touch it, in the order of the list.
#[derive(Debug)]
pub(super) struct Bins {
    across: usize,
    starts: Vec<usize>,
    items: Vec<u32>,
}

impl Bins {
    pub(super) fn new(columns: usize, rows: usize, rects: &[Rect]) -> Self {
        let (across, down) = (columns.div_ceil(TILE), rows.div_ceil(TILE));
        let tiles = |rect: &Rect| {
            let (x0, x1) = (rect.x0 / TILE, (rect.x1 - 1) / TILE);
            (rect.y0 / TILE..=(rect.y1 - 1) / TILE)
                .flat_map(move |y| (x0..=x1).map(move |x| y * across + x))
        };
        let mut starts = vec![0; across * down + 1];
        for tile in rects.iter().flat_map(tiles) {
            starts[tile + 1] += 1;
        }
        for tile in 1..starts.len() {
            starts[tile] += starts[tile - 1];
        }
        let mut next = starts.clone();
        let mut items = vec![0; starts[across * down]];
        for (item, rect) in rects.iter().enumerate() {
            for tile in tiles(rect) {
                items[next[tile]] = item as u32;
                next[tile] += 1;
            }
        }
        Self {
            across,
            starts,
            items,
        }
    }

    /// The things of the tile in this column and row of tiles.
    pub(super) fn tile(&self, column: usize, row: usize) -> &[u32] {
        let tile = row * self.across + column;
        &self.items[self.starts[tile]..self.starts[tile + 1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_tile_has_what_touches_it() {
        let rects: Vec<Rect> = [
            ((0.0, 0.0), (10.0, 10.0)),
            ((60.0, 60.0), (70.0, 70.0)),
            ((-50.0, -50.0), (500.0, 500.0)),
        ]
        .into_iter()
        .filter_map(|(low, high)| Rect::around(low, high, 200, 100))
        .collect();
        let bins = Bins::new(200, 100, &rects);
        assert_eq!(bins.tile(0, 0), [0, 1, 2]);
        assert_eq!(bins.tile(1, 1), [1, 2]);
        assert_eq!(bins.tile(3, 0), [2]);
        assert_eq!(Rect::around((300.0, 0.0), (310.0, 5.0), 200, 100), None);
        assert_eq!(
            Rect::around((0.6, 0.0), (1.4, 5.0), 200, 100),
            None,
            "between centres"
        );
    }
}
