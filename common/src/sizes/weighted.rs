//! A size distribution in one weighting: cumulative share, quantile, density.

use super::classes::WeightedClasses;
use super::laws::WeightedLaw;

/// A size distribution as seen when a quantity is counted: made by
/// [`SizeDistribution::by`](super::SizeDistribution::by), evaluated any number of times.
#[derive(Debug, Clone)]
pub struct Weighted {
    pub(super) smallest: f64,
    pub(super) largest: f64,
    pub(super) way: Way,
}

/// How it is evaluated.
#[derive(Debug, Clone)]
pub(super) enum Way {
    Law(WeightedLaw),
    Classes(WeightedClasses),
    /// Parts with their shares, whose sum is 1.
    Mixture(Vec<(f64, Weighted)>),
}

impl Weighted {
    /// The diameter below which a share `u` lies, m; increasing in `u`, which is clipped to [0, 1]. Exact: the inverse of
    /// [`Weighted::cdf`] in the model of the distribution.
    #[must_use]
    pub fn quantile(&self, u: f64) -> f64 {
        let (a, b) = (self.smallest, self.largest);
        if u <= 0.0 {
            return a;
        }
        if u >= 1.0 {
            return b;
        }
        match &self.way {
            Way::Law(law) => law.quantile(u),
            Way::Classes(classes) => classes.quantile(u),
            Way::Mixture(parts) => self.mixed_quantile(parts, u),
        }
        .clamp(a, b)
    }

    /// The share below `diameter` (m).
    #[must_use]
    pub fn cdf(&self, diameter: f64) -> f64 {
        if diameter < self.smallest {
            return 0.0;
        }
        if diameter >= self.largest {
            return 1.0;
        }
        match &self.way {
            Way::Law(law) => law.cdf(diameter),
            Way::Classes(classes) => classes.cdf(diameter),
            Way::Mixture(parts) => parts
                .iter()
                .map(|(share, part)| share * part.cdf(diameter))
                .sum::<f64>()
                .min(1.0),
        }
    }

    /// The density at `diameter`, 1/m; infinite where many particles have one size.
    #[must_use]
    pub fn density(&self, diameter: f64) -> f64 {
        if diameter < self.smallest || diameter > self.largest {
            return 0.0;
        }
        match &self.way {
            Way::Law(law) => law.density(diameter),
            Way::Classes(classes) => classes.density(diameter),
            Way::Mixture(parts) => parts
                .iter()
                .map(|(share, part)| match part.density(diameter) {
                    0.0 => 0.0,
                    density => share * density,
                })
                .sum(),
        }
    }

    /// Newton steps kept in a bracket by bisection.
    fn mixed_quantile(&self, parts: &[(f64, Weighted)], u: f64) -> f64 {
        let quantiles = || parts.iter().map(|(_, part)| part.quantile(u));
        let mut low = quantiles().fold(f64::INFINITY, f64::min);
        let mut high = quantiles().fold(0.0, f64::max);
        let mut d = 0.5 * (low + high);
        for _ in 0..200 {
            // The smallest diameter with at least u below it.
            let excess = self.cdf(d) - u;
            if excess >= 0.0 {
                high = d;
            } else {
                low = d;
            }
            if high - low <= 1e-15 * high {
                // Where one size is met it is that very size.
                let sizes = parts.iter().map(|(_, part)| part.largest);
                return sizes
                    .filter(|size| low <= *size && *size <= high && self.cdf(*size) >= u)
                    .fold(high, f64::min);
            }
            let newton = d - excess / self.density(d);
            if (newton - d).abs() <= 1e-16 * d && newton.is_finite() {
                return d;
            }
            d = if newton > low && newton < high {
                newton
            } else {
                0.5 * (low + high)
            };
        }
        high
    }
}
