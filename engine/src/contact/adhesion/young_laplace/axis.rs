//! An axis of a table: evenly spaced nodes, and cubic interpolation between them.

/// Largest distance outside that counts as round-off of the input.
const ROUND_OFF: f64 = 1e-9;

/// Evenly spaced nodes; one alone where the range is a single value, else at least four.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    low: f64,
    step: f64,
    pub(super) count: usize,
}

impl Axis {
    /// Over a range, in cells of at most `width`.
    pub(super) fn new(low: f64, high: f64, width: f64) -> Self {
        if low >= high {
            return Self {
                low,
                step: 0.0,
                count: 1,
            };
        }
        let cells = f64::max(((high - low) / width).ceil(), 3.0);
        Self {
            low,
            step: (high - low) / cells,
            count: cells as usize + 1,
        }
    }

    /// Value at a node, or between two.
    pub(super) fn value(&self, place: f64) -> f64 {
        self.low + self.step * place
    }

    /// Where interpolation is worst: the middles of all cells; and both ends.
    pub(super) fn probes(&self) -> Vec<f64> {
        if self.count == 1 {
            return vec![self.low];
        }
        let cells = self.count - 1;
        let middles = (0..cells).map(|cell| self.value(cell as f64 + 0.5));
        [self.low]
            .into_iter()
            .chain(middles)
            .chain([self.value(cells as f64)])
            .collect()
    }

    /// The nearest value of the axis, and whether it is the given one.
    pub(super) fn clamped(&self, value: f64) -> (f64, bool) {
        let high = self.value((self.count - 1) as f64);
        let inside = value >= self.low - ROUND_OFF && value <= high + ROUND_OFF;
        let nearest = if value > self.low {
            f64::min(value, high)
        } else {
            self.low
        };
        (nearest, inside)
    }

    /// Lagrange's weights of the four nodes around a value of the axis, and the first of these nodes.
    pub(super) fn weights(&self, value: f64) -> (usize, [f64; 4]) {
        if self.count == 1 {
            return (0, [1.0, 0.0, 0.0, 0.0]);
        }
        let place = (value - self.low) / self.step;
        let first = (place as usize).saturating_sub(1).min(self.count - 4);
        let a = place - first as f64;
        let (b, c, d) = (a - 1.0, a - 2.0, a - 3.0);
        let weights = [
            b * c * d / -6.0,
            a * c * d / 2.0,
            a * b * d / -2.0,
            a * b * c / 6.0,
        ];
        (first, weights)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubics_are_interpolated_exactly_and_what_is_outside_is_clamped() {
        let axis = Axis::new(-1.0, 2.0, 0.4);
        assert_eq!((axis.count, axis.probes().len()), (9, 10));
        let cubic = |x: f64| 1.0 + x * (2.0 + x * (3.0 + 4.0 * x));
        for k in 0..=30 {
            let x = -1.0 + 0.1 * f64::from(k);
            let (value, inside) = axis.clamped(x);
            let (first, weights) = axis.weights(value);
            let sum: f64 = (0..4)
                .map(|i| weights[i] * cubic(axis.value((first + i) as f64)))
                .sum();
            assert!(inside && (sum - cubic(x)).abs() < 1e-12, "{x}: {sum}");
        }
        assert_eq!(axis.clamped(-3.0), (-1.0, false));
        assert_eq!(axis.clamped(3.0), (2.0, false));
        assert_eq!(axis.clamped(f64::NAN), (-1.0, false));
        let single = Axis::new(0.5, 0.5, 0.4);
        assert_eq!((single.count, single.weights(0.5).0), (1, 0));
        assert_eq!(single.probes(), [0.5]);
    }
}
