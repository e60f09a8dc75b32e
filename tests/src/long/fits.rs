//! Lines and curves through measured points.

/// A line through points by least squares.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line {
    pub(super) slope: f64,
    pub(super) intercept: f64,
    /// 1 - (what is left of the variance)/(variance).
    pub(super) r_squared: f64,
}

impl Line {
    pub(super) fn through(points: &[(f64, f64)]) -> Self {
        let n = points.len() as f64;
        let mean = |value: fn(&(f64, f64)) -> f64| points.iter().map(value).sum::<f64>() / n;
        let (x, y) = (mean(|p| p.0), mean(|p| p.1));
        let sum = |value: &dyn Fn(f64, f64) -> f64| {
            points.iter().map(|p| value(p.0 - x, p.1 - y)).sum::<f64>()
        };
        let slope = sum(&|dx, dy| dx * dy) / sum(&|dx, _| dx * dx);
        let left = sum(&|dx, dy| (dy - slope * dx).powi(2));
        Self {
            slope,
            intercept: y - slope * x,
            r_squared: 1.0 - left / sum(&|_, dy| dy * dy),
        }
    }

    pub(super) fn at(&self, x: f64) -> f64 {
        self.intercept + self.slope * x
    }
}

/// The argument in [low, high] at which a function with one minimum there is least (golden section).
pub(super) fn least(mut low: f64, mut high: f64, value: impl Fn(f64) -> f64) -> f64 {
    let share = 0.5 * (5.0f64.sqrt() - 1.0);
    while high - low > 1e-9 * (low.abs() + high.abs()) {
        let (a, b) = (high - share * (high - low), low + share * (high - low));
        if value(a) < value(b) {
            high = b;
        } else {
            low = a;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_and_a_minimum_are_found() {
        let line = Line::through(&[(0.0, 1.0), (1.0, 3.0), (2.0, 5.0)]);
        assert_eq!(
            (line.slope, line.intercept, line.r_squared),
            (2.0, 1.0, 1.0)
        );
        assert_eq!(line.at(3.0), 7.0);
        let noisy = Line::through(&[(0.0, 0.0), (1.0, 1.0), (2.0, 0.0)]);
        assert!(noisy.slope.abs() < 1e-15 && noisy.r_squared.abs() < 1e-15);
        assert!((least(0.0, 3.0, |x| (x - 1.25).powi(2)) - 1.25).abs() < 1e-6);
    }
}
