//! The present rows of the particles of the last candidate list.

use crate::state::Row;

/// Follows removals of rows from one list build to the next, so that contact histories find their particles.
#[derive(Debug, Clone, Default)]
pub(super) struct RowMap {
    /// Rows of the last list.
    listed: usize,
    /// Present row of each, `None` if removed; no list at all if no row has changed.
    present: Option<Vec<Option<Row>>>,
}

impl RowMap {
    /// No change since a list of `listed` rows.
    pub(super) fn of_list(listed: usize) -> Self {
        Self {
            listed,
            present: None,
        }
    }

    /// Keeps the rows `stay` of `rows`, in this order.
    pub(super) fn keep(&mut self, stay: &[u32], rows: usize) {
        let mut moved = vec![None; rows];
        for (new, &old) in stay.iter().enumerate() {
            moved[old as usize] = Some(Row::new(new));
        }
        let present = self.present.get_or_insert_with(|| in_place(self.listed));
        for row in present {
            *row = row.and_then(|row| moved[row.index()]);
        }
    }

    /// Whether this row of the last list was removed since.
    pub(super) fn is_removed(&self, row: usize) -> bool {
        (self.present.as_ref()).is_some_and(|present| present[row].is_none())
    }

    /// The present row of each row of the last list; the next list will have `rows`.
    pub(super) fn take(&mut self, rows: usize) -> Vec<Option<Row>> {
        let last = std::mem::replace(self, Self::of_list(rows));
        last.present.unwrap_or_else(|| in_place(last.listed))
    }
}

/// Every row in its place.
fn in_place(rows: usize) -> Vec<Option<Row>> {
    (0..rows).map(|row| Some(Row::new(row))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn removals_and_insertions_compose_over_several_steps() {
        let mut map = RowMap::default();
        assert!(
            map.take(5).is_empty(),
            "before the first list there were no rows"
        );
        // Rows 0 1 2 3 4, one more comes (5): then 1 and 5 go.
        map.keep(&[0, 2, 3, 4], 6);
        // Left: 0 2 3 4, two more come (4, 5): then 0 and the first new one go.
        map.keep(&[1, 2, 3, 5], 6);
        let row = |row| Some(Row::new(row));
        assert_eq!(map.take(4), [None, None, row(0), row(1), row(2)]);
        assert_eq!(map.take(7), [0, 1, 2, 3].map(row), "nothing moved since");
        assert_eq!(map.take(0).len(), 7);
    }
}
