//! The rule by which a run ends when a result is known.

/// Fewest rows of a first look.
pub const FIRST_LOOK: u64 = 64;

/// Fewest independent batches with which a result is known.
const FEWEST_INDEPENDENT: f64 = 32.0;

/// Largest difference of the means of both halves, in standard errors.
const MOST_DIFFERENCE: f64 = 4.0;

/// Findings of a look at a result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// One standard error.
    pub error: f64,
    /// Half the width of the 95 % interval.
    pub half_width: f64,
    /// Independent batches.
    pub independent: f64,
    /// Difference of the means of both halves of the batches.
    pub difference: f64,
    /// Whether the series is steady behind its start-up.
    pub is_steady: bool,
}

impl Look {
    /// The error that counts: the standard error of a normal law with the same interval.
    #[must_use]
    pub fn counted_error(&self) -> f64 {
        self.half_width / 1.959_963_984_540_054
    }

    /// Whether the result is known to `wanted`, one standard error.
    #[must_use]
    pub fn is_known_to(&self, wanted: f64) -> bool {
        self.is_trusted().is_ok() && self.counted_error() <= wanted
    }

    /// Whether the error can be trusted.
    ///
    /// # Errors
    /// The reason why it cannot.
    pub fn is_trusted(&self) -> Result<(), String> {
        if !self.is_steady {
            return Err("it is not steady yet".to_owned());
        }
        if self.independent < FEWEST_INDEPENDENT {
            let batches = self.independent;
            return Err(format!(
                "it has {batches:.1} independent batches, and {FEWEST_INDEPENDENT} are needed"
            ));
        }
        if self.difference.abs() > MOST_DIFFERENCE * self.error {
            return Err(format!(
                "its halves differ by more than {MOST_DIFFERENCE} standard errors"
            ));
        }
        Ok(())
    }
}

/// The looks at a series while its rows come: at row 64 or later, then each time when there are a tenth more. Looking seldom keeps the chance small that a look
/// finds a small error by accident; a series is known when two looks in a row say so.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Looks {
    next: u64,
    was_known: bool,
}

impl Looks {
    /// Looks that begin at a row.
    #[must_use]
    pub fn from_row(row: u64) -> Self {
        Self {
            next: row.max(FIRST_LOOK),
            was_known: false,
        }
    }

    /// Whether the series is looked at when it has so many rows.
    #[must_use]
    pub fn is_due(&self, rows: u64) -> bool {
        rows >= self.next
    }

    /// Notes a look at `rows` rows; returns whether this and the last look found it known.
    pub fn note(&mut self, rows: u64, is_known: bool) -> bool {
        // ceil(1.1 rows), in whole numbers.
        self.next = rows + rows.div_ceil(10);
        std::mem::replace(&mut self.was_known, is_known) && is_known
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_looks_in_a_row_end_a_run() {
        let mut looks = Looks::from_row(10);
        assert!(!looks.is_due(63) && looks.is_due(64));
        assert!(!looks.note(64, true));
        assert!(!looks.is_due(70) && looks.is_due(71));
        assert!(!looks.note(71, false));
        assert!(!looks.note(79, true));
        assert!(looks.is_due(87) && looks.note(87, true));
    }

    #[test]
    fn known_is_steady_and_of_many_batches() {
        let look = Look {
            error: 1.0,
            half_width: 2.0,
            independent: 40.0,
            difference: 3.0,
            is_steady: true,
        };
        assert!(look.is_known_to(1.03) && !look.is_known_to(1.01));
        for worse in [
            Look {
                independent: 31.0,
                ..look
            },
            Look {
                difference: -4.1,
                ..look
            },
            Look {
                is_steady: false,
                ..look
            },
        ] {
            assert!(!worse.is_known_to(100.0));
        }
    }
}
