//! Overlaps that contacts do not count: those that glued pairs had when they were glued.

/// The overlap of each glued pair that its contact does not count, by rows of the present list.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct OverlapOffsets {
    /// First entry of each row in `pairs`, and their number.
    start: Vec<u32>,
    /// The higher row, and the overlap, m.
    pairs: Vec<(u32, f64)>,
    /// Row, wall and overlap (m), sorted.
    walls: Vec<([u32; 2], f64)>,
}

impl OverlapOffsets {
    /// Those of pairs of so many rows, the lower row first, and of rows and walls; m.
    #[must_use]
    pub fn new(
        rows: usize,
        mut pairs: Vec<([u32; 2], f64)>,
        mut walls: Vec<([u32; 2], f64)>,
    ) -> Self {
        pairs.sort_unstable_by_key(|&(pair, _)| pair);
        walls.sort_unstable_by_key(|&(pair, _)| pair);
        let mut start = vec![0; rows + 1];
        for ([row, _], _) in &pairs {
            start[*row as usize + 1] += 1;
        }
        for row in 0..rows {
            start[row + 1] += start[row];
        }
        Self {
            start,
            pairs: pairs
                .iter()
                .map(|&([_, other], offset)| (other, offset))
                .collect(),
            walls,
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty() && self.walls.is_empty()
    }

    /// That of two rows, the lower one first, m; 0 if they have none.
    #[must_use]
    pub fn of_pair(&self, row: usize, other: usize) -> f64 {
        let Some(&[first, end]) = self.start.get(row..row + 2) else {
            return 0.0;
        };
        let mut own = self.pairs[first as usize..end as usize].iter();
        own.find(|(partner, _)| *partner as usize == other)
            .map_or(0.0, |(_, offset)| *offset)
    }

    /// That of a row and a wall, m; 0 if they have none.
    #[must_use]
    pub fn at_wall(&self, row: u32, wall: u32) -> f64 {
        let found = (self.walls).binary_search_by_key(&[row, wall], |&(pair, _)| pair);
        found.map_or(0.0, |place| self.walls[place].1)
    }
}
