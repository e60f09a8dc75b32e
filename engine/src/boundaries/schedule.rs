//! The amount that an insertion may have placed by a time.

use super::{InsertionPlan, Quantity, Rate, Tally, Total};

/// Relative slack of totals of mass and volume, far above the round-off of their sums: a total that is a whole number of equal
/// particles is met exactly.
const ROUND_OFF: f64 = 1e-11;

impl Rate {
    /// Measure of the amount.
    #[must_use]
    pub fn quantity(&self) -> Quantity {
        match self {
            Self::Steady { quantity, .. } | Self::Table { quantity, .. } => *quantity,
        }
    }

    /// The amount allowed by `time` (s) for a flow that starts at `from` (s), and its quantity.
    #[must_use]
    pub fn allowed(&self, from: f64, time: f64) -> (Quantity, f64) {
        match self {
            Self::Steady {
                quantity,
                per_second,
            } => (*quantity, per_second * (time - from).max(0.0)),
            Self::Table { quantity, amounts } => (*quantity, amounts.cumulative(time)),
        }
    }
}

/// The counted amount of a quantity.
fn amount(tally: &Tally, quantity: Quantity) -> f64 {
    match quantity {
        Quantity::Number => tally.number as f64,
        Quantity::Mass => tally.mass,
        Quantity::Volume => tally.volume,
    }
}

impl InsertionPlan {
    /// Whether the target is reached; never for `full`.
    #[must_use]
    pub fn total_reached(&self, inserted: &Tally) -> bool {
        match self.total {
            Some(Total::Number(number)) => inserted.number >= number,
            Some(Total::Mass(mass)) => inserted.mass >= mass * (1.0 - ROUND_OFF),
            Some(Total::Volume(volume)) => inserted.volume >= volume * (1.0 - ROUND_OFF),
            Some(Total::Full) | None => false,
        }
    }

    /// Whether the rate allows no more at `time` (s). The last particle may exceed the limit.
    #[must_use]
    pub fn rate_reached(&self, inserted: &Tally, time: f64) -> bool {
        self.rate.as_ref().is_some_and(|rate| {
            let (quantity, allowed) = rate.allowed(self.from, time);
            amount(inserted, quantity) >= allowed * (1.0 - ROUND_OFF)
        })
    }

    /// The target amount by `time` (s): by its rate, else its total; `None` for `full` without rate.
    #[must_use]
    pub fn requested(&self, time: f64) -> Option<(Quantity, f64)> {
        let total = match self.total {
            Some(Total::Number(number)) => Some((Quantity::Number, number as f64)),
            Some(Total::Mass(mass)) => Some((Quantity::Mass, mass)),
            Some(Total::Volume(volume)) => Some((Quantity::Volume, volume)),
            Some(Total::Full) | None => None,
        };
        let rate = self
            .rate
            .as_ref()
            .map(|rate| rate.allowed(self.from, time.min(self.until)));
        match (rate, total) {
            (Some((of_rate, rate)), Some((of_total, total))) if of_rate == of_total => {
                Some((of_rate, rate.min(total)))
            }
            (Some(rate), _) => Some(rate),
            (None, total) => total.filter(|_| time >= self.from),
        }
    }
}
