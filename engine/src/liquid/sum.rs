//! Sums whose round-off is summed up beside them.

/// A sum and the rounding errors of its additions (Neumaier 1974).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sum {
    total: f64,
    lost: f64,
}

crate::state::plain!(Sum { total, lost });

impl Sum {
    /// Adds a number.
    pub fn add(&mut self, number: f64) {
        let next = self.total + number;
        self.lost += if self.total.abs() >= number.abs() {
            (self.total - next) + number
        } else {
            (number - next) + self.total
        };
        self.total = next;
    }

    /// The sum.
    #[must_use]
    pub fn value(self) -> f64 {
        self.total + self.lost
    }
}
