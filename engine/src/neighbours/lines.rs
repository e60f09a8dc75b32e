//! The order of the lines of cells.

use std::ops::Range;

// All of these are smaller in unit tests, so that their few particles lie in bricks too.

/// A layer of cells up to this many rows stays whole: the data that a step reads before the rows of the next layer fits into the
/// second-level cache of one core.
const LAYER: f64 = if cfg!(test) { 40.0 } else { 1600.0 };
/// The approximate number of rows in a layer of a brick.
const PART: f64 = if cfg!(test) { 20.0 } else { 800.0 };
/// Least lines of a layer of a brick, so that few of them have neighbours in another brick.
const NARROW: usize = if cfg!(test) { 3 } else { 8 };
/// Layers of a brick.
const SLAB: usize = if cfg!(test) { 4 } else { 32 };

/// The order of the lines of cells; a line goes along the fastest axis.
///
/// Particles touch others in the next line of the same layer, or in the next layer. With large layers, the next layer is far away
/// in memory: the data would have left the cache before it is used again. So a large grid is cut into bricks, along the middle
/// and the slowest axis, which are processed one after the other, each layer by layer. A grid of small layers is a single brick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lines {
    /// Lines of a layer of the grid.
    middle: usize,
    /// Layers.
    slow: usize,
    /// Lines of a layer of a brick.
    strip: usize,
    /// Layers of a brick.
    slab: usize,
}

impl Lines {
    /// For a grid with this many cells along the fastest, the middle and the slowest axis, and this many rows in a cell on
    /// average.
    pub(super) fn new([fast, middle, slow]: [usize; 3], rows_per_cell: f64) -> Self {
        let of_line = fast as f64 * rows_per_cell;
        let whole = Self {
            middle,
            slow,
            strip: middle,
            slab: slow,
        };
        if of_line * middle as f64 <= LAYER {
            return whole;
        }
        let strips = middle / ((PART / of_line) as usize).max(NARROW);
        if strips < 2 {
            return whole;
        }
        Self {
            strip: middle.div_ceil(strips),
            slab: SLAB,
            ..whole
        }
    }

    /// The index of the line at `b` along the middle and `c` along the slowest axis.
    #[inline]
    pub(super) fn at(&self, b: usize, c: usize) -> usize {
        if self.strip == self.middle {
            return b + self.middle * c;
        }
        let (first_b, first_c) = (b / self.strip * self.strip, c / self.slab * self.slab);
        let strip = self.strip.min(self.middle - first_b);
        let slab = self.slab.min(self.slow - first_c);
        self.middle * first_c + slab * first_b + strip * (c - first_c) + (b - first_b)
    }

    /// Lines next to line `b` of layer `c` that come later, so that each pair of neighbours occurs once.
    pub(super) fn later(&self, b: usize, c: usize) -> impl Iterator<Item = usize> {
        let own = self.at(b, c);
        let next = b + 1 < self.middle;
        let above = c + 1 < self.slow;
        // The brick of a line decides about the second and the last of these; the other neighbours are always earlier.
        let neighbours = [
            (next, b + 1, c),
            (above && b > 0, b.wrapping_sub(1), c + 1),
            (above, b, c + 1),
            (above && next, b + 1, c + 1),
            (next && c > 0, b + 1, c.wrapping_sub(1)),
        ];
        let is_later = move |&line: &usize| line > own;
        let there = neighbours.into_iter().filter(|neighbour| neighbour.0);
        there.map(|(_, b, c)| self.at(b, c)).filter(is_later)
    }

    /// The layers of all bricks, in the order of the lines: which lines along the middle axis, and where along the slowest one.
    pub(super) fn layers(&self) -> Vec<(Range<usize>, usize)> {
        let mut layers = Vec::new();
        for first_c in (0..self.slow).step_by(self.slab) {
            for first_b in (0..self.middle).step_by(self.strip) {
                let lines = first_b..self.middle.min(first_b + self.strip);
                let slab = first_c..self.slow.min(first_c + self.slab);
                layers.extend(slab.map(|c| (lines.clone(), c)));
            }
        }
        layers
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn lines_follow_one_another_brick_by_brick() {
        let mut bricks = 0;
        for counts in [
            [1, 1, 1],
            [26, 26, 38],
            [40, 60, 61],
            [38, 180, 180],
            [3, 700, 701],
            [900, 901, 902],
        ] {
            for rows_per_cell in [0.1, 0.8, 5.0] {
                let lines = Lines::new(counts, rows_per_cell);
                let mut next = 0;
                for (layer, c) in lines.layers() {
                    for b in layer {
                        assert_eq!(lines.at(b, c), next, "{counts:?}");
                        next += 1;
                    }
                }
                assert_eq!(next, counts[1] * counts[2]);
                bricks += usize::from(lines.strip < counts[1]);
            }
        }
        assert!(bricks > 5);
    }

    #[test]
    fn small_layers_stay_whole() {
        let small = Lines::new([4, 5, 38], 1.2);
        assert_eq!(small.at(3, 7), 3 + 5 * 7);
        let large = Lines::new([38, 180, 180], 0.8);
        assert_eq!(large.at(0, 1), large.strip);
    }

    #[test]
    fn each_two_neighbouring_lines_find_each_other_once() {
        for counts in [[26, 26, 38], [38, 90, 70]] {
            let lines = Lines::new(counts, 1.5);
            let [_, middle, slow] = counts;
            let mut pairs = BTreeSet::new();
            for (b, c) in (0..middle).flat_map(|b| (0..slow).map(move |c| (b, c))) {
                for later in lines.later(b, c) {
                    assert!(later > lines.at(b, c) && pairs.insert((lines.at(b, c), later)));
                }
            }
            for (b, c) in (0..middle).flat_map(|b| (0..slow).map(move |c| (b, c))) {
                for (other_b, other_c) in [
                    (b + 1, c),
                    (b, c + 1),
                    (b + 1, c + 1),
                    (b + 1, c.wrapping_sub(1)),
                ] {
                    if other_b < middle && other_c < slow {
                        let (one, two) = (lines.at(b, c), lines.at(other_b, other_c));
                        assert!(pairs.remove(&(one.min(two), one.max(two))));
                    }
                }
            }
            assert!(pairs.is_empty());
        }
    }
}
