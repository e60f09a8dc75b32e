//! A long series of rows in few bins.

/// Most bins of a record.
pub const MOST_BINS: usize = 1024;

/// Rows averaged into equal bins, as they come: 8 kB for any number of rows, or less by [`Record::of_bins`].
///
/// When a bin is complete and all places are taken, neighbours are merged and the width doubles. The state after a row depends on the rows alone.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    bins: Vec<f64>,
    /// Most bins, an even number.
    most: usize,
    /// Rows of a bin: a power of two.
    width: u64,
    /// Sum of the rows that fill no bin yet.
    sum: f64,
    waiting: u64,
}

impl Default for Record {
    fn default() -> Self {
        Self::of_bins(MOST_BINS)
    }
}

impl Record {
    /// An empty record of at most so many bins, an even number.
    #[must_use]
    pub fn of_bins(most: usize) -> Self {
        Self {
            bins: Vec::new(),
            most,
            width: 1,
            sum: 0.0,
            waiting: 0,
        }
    }

    /// Adds a row.
    pub fn add(&mut self, row: f64) {
        self.sum += row;
        self.waiting += 1;
        if self.waiting < self.width {
            return;
        }
        if self.bins.len() == self.most {
            for k in 0..self.most / 2 {
                self.bins[k] = 0.5 * (self.bins[2 * k] + self.bins[2 * k + 1]);
            }
            self.bins.truncate(self.most / 2);
            // The complete bin is half of one of the new width.
            self.width *= 2;
            return;
        }
        self.bins.push(self.sum / self.width as f64);
        (self.sum, self.waiting) = (0.0, 0);
    }

    /// Means of the complete bins, in order.
    #[must_use]
    pub fn bins(&self) -> &[f64] {
        &self.bins
    }

    /// Rows of a bin.
    #[must_use]
    pub fn width(&self) -> u64 {
        self.width
    }

    /// Number of rows added.
    #[must_use]
    pub fn rows(&self) -> u64 {
        self.bins.len() as u64 * self.width + self.waiting
    }

    /// The record as numbers, from which [`Record::from_numbers`] makes the same: width, rows that wait, their sum, bins.
    #[must_use]
    pub fn numbers(&self) -> Vec<f64> {
        let head = [self.width as f64, self.waiting as f64, self.sum];
        head.into_iter().chain(self.bins.iter().copied()).collect()
    }

    /// The record of at most so many bins of these numbers; `None` if no rows can have left them.
    #[must_use]
    pub fn from_numbers(most: usize, numbers: &[f64]) -> Option<Self> {
        let (&[width, waiting, sum], bins) = numbers.split_first_chunk::<3>()?;
        // Whole numbers that a float holds exactly.
        let is_count =
            |value: f64| (0.0..9_007_199_254_740_992.0).contains(&value) && value.fract() == 0.0;
        let valid = is_count(width) && is_count(waiting) && bins.len() <= most;
        let width = valid.then_some(width as u64)?;
        let possible = width.is_power_of_two()
            && waiting < width as f64
            && (width == 1 || bins.len() >= most / 2);
        possible.then(|| Self {
            bins: bins.to_vec(),
            most,
            width,
            sum,
            waiting: waiting as u64,
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Bins are the means of equal stretches of the rows. Rows are small whole numbers, whose sums and halves are exact.
        #[test]
        fn bins_are_means_of_equal_stretches(count in 0usize..9000, seed in 1u64..1000) {
            let rows: Vec<f64> = (0..count as u64).map(|k| (k * seed % 97) as f64).collect();
            let mut record = Record::default();
            rows.iter().for_each(|&row| record.add(row));
            prop_assert_eq!(record.rows(), count as u64);
            prop_assert!(record.bins().len() <= MOST_BINS);
            let width = record.width() as usize;
            // The fewest doublings that the rows fit into.
            prop_assert!(width == 1 || count >= width / 2 * (MOST_BINS + 1));
            for (bin, rows) in record.bins().iter().zip(rows.chunks_exact(width)) {
                prop_assert_eq!(*bin, rows.iter().sum::<f64>() / width as f64);
            }
        }

        /// A record that was saved at any row and goes on is that of a series without a break.
        #[test]
        fn a_saved_record_goes_on(count in 1usize..5000, at in 0.0f64..1.0) {
            let rows = (0..count).map(|k| libm::sin(k as f64));
            let (mut whole, mut part) = (Record::default(), Record::default());
            let stop = (at * count as f64) as usize;
            for (k, row) in rows.enumerate() {
                if k == stop {
                    part = Record::from_numbers(MOST_BINS, &part.numbers()).unwrap();
                }
                whole.add(row);
                part.add(row);
            }
            prop_assert_eq!(whole, part);
        }

        #[test]
        fn any_numbers_are_read_or_refused(numbers in prop::collection::vec(any::<f64>(), 0..8)) {
            if let Some(record) = Record::from_numbers(MOST_BINS, &numbers) {
                prop_assert_eq!(record.numbers().len(), numbers.len());
            }
        }
    }

    #[test]
    fn impossible_numbers_are_refused() {
        for numbers in [
            vec![],
            vec![3.0, 0.0, 0.0],
            vec![2.0, 0.0, 0.0, 1.0],
            vec![1.0, 1.0, 0.0],
            vec![f64::NAN, 0.0, 0.0],
            vec![1.0, -1.0, 0.0],
            [1.0, 0.0, 0.0].into_iter().chain([0.0; 1025]).collect(),
        ] {
            assert_eq!(
                Record::from_numbers(MOST_BINS, &numbers),
                None,
                "{numbers:?}"
            );
        }
    }
}
