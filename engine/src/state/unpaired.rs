//! Pairs without a contact.

use super::Row;

/// Pairs of rows, and of rows and walls, that have no contact however near they are, beside the pebbles of one body.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Unpaired {
    /// The lower row first, sorted.
    pairs: Vec<[u32; 2]>,
    /// Row and wall, sorted.
    walls: Vec<[u32; 2]>,
}

impl Unpaired {
    /// These pairs of rows, and of rows and walls.
    #[must_use]
    pub fn new(
        pairs: impl Iterator<Item = [u32; 2]>,
        walls: impl Iterator<Item = [u32; 2]>,
    ) -> Self {
        let mut unpaired = Self {
            pairs: pairs.map(|[a, b]| [a.min(b), a.max(b)]).collect(),
            walls: walls.collect(),
        };
        unpaired.sort();
        unpaired
    }

    /// Whether every pair may have a contact.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty() && self.walls.is_empty()
    }

    /// Whether two rows have no contact.
    #[must_use]
    pub fn holds(&self, row: usize, other: usize) -> bool {
        let pair = [row.min(other) as u32, row.max(other) as u32];
        self.pairs.binary_search(&pair).is_ok()
    }

    /// Whether a row and a wall have no contact.
    #[must_use]
    pub fn holds_wall(&self, row: u32, wall: u32) -> bool {
        self.walls.binary_search(&[row, wall]).is_ok()
    }

    /// With one more pair of rows, or of a row and a wall.
    pub fn add(&mut self, rows: [u32; 2], is_wall: bool) {
        let (pairs, pair) = self.place_of(rows, is_wall);
        let place = pairs.partition_point(|other| *other < pair);
        pairs.insert(place, pair);
    }

    /// Without a pair; it stays if it is there twice.
    pub fn remove(&mut self, rows: [u32; 2], is_wall: bool) {
        let (pairs, pair) = self.place_of(rows, is_wall);
        if let Ok(place) = pairs.binary_search(&pair) {
            pairs.remove(place);
        }
    }

    fn place_of(&mut self, [a, b]: [u32; 2], is_wall: bool) -> (&mut Vec<[u32; 2]>, [u32; 2]) {
        match is_wall {
            true => (&mut self.walls, [a, b]),
            false => (&mut self.pairs, [a.min(b), a.max(b)]),
        }
    }

    /// The rows were reordered: `new_row[old]`, `None` for rows that were removed.
    pub(super) fn follow(&mut self, new_row: &[Option<Row>]) {
        let now = |row: u32| new_row[row as usize].map(|row| row.index() as u32);
        let pairs = std::mem::take(&mut self.pairs).into_iter();
        let walls = std::mem::take(&mut self.walls).into_iter();
        *self = Self::new(
            pairs.filter_map(|[a, b]| Some([now(a)?, now(b)?])),
            walls.filter_map(|[row, wall]| Some([now(row)?, wall])),
        );
    }

    fn sort(&mut self) {
        self.pairs.sort_unstable();
        self.walls.sort_unstable();
    }
}
