//! Axis of a chart: its quantity, unit, scale and range.

use mercury_common::normal::normal_quantile;

/// How values are spread along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// Scale by the logarithm; zero and negative values have no place.
    Log,
    /// Shares between 0 and 1 by the quantile of the normal distribution, labelled in per cent: a normal distribution is a straight
    /// line, over a logarithmic axis a log-normal one.
    Probability,
    /// Shares between 0 and 1 by `ln(−ln(1 − share))`, labelled in per cent: over a logarithmic axis a Rosin-Rammler (Weibull)
    /// distribution is a straight line whose slope is its exponent (P. Rosin and E. Rammler, 1933).
    RosinRammler,
}

impl Scale {
    /// Where a value is, in units of the axis' own; `None`: nowhere.
    pub(super) fn place(self, value: f64) -> Option<f64> {
        let place = match self {
            Self::Linear => value,
            Self::Log if value > 0.0 => libm::log10(value),
            Self::Probability if value > 0.0 && value < 1.0 => normal_quantile(value),
            Self::RosinRammler if value > 0.0 && value < 1.0 => libm::log(-libm::log1p(-value)),
            _ => f64::NAN,
        };
        place.is_finite().then_some(place)
    }

    /// Whether values are shares of a whole.
    pub(super) fn is_share(self) -> bool {
        matches!(self, Self::Probability | Self::RosinRammler)
    }
}

/// One axis of a chart.
///
/// Values are in SI units; this module chooses a prefix that makes the numbers short (`time (ms)`), for the units `s`, `m`, `J`,
/// `N`, `Pa`, `W`, `Hz` and quotients that begin with one of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Name of the quantity: `time`.
    pub name: String,
    /// Its SI unit: `s`; empty for pure numbers.
    pub unit: String,
    /// How values are spread.
    pub scale: Scale,
    /// Ends (SI); none: what the series need.
    pub range: Option<(f64, f64)>,
}

impl Axis {
    fn new(name: &str, unit: &str, scale: Scale) -> Self {
        Self {
            name: name.into(),
            unit: unit.into(),
            scale,
            range: None,
        }
    }

    /// An even axis.
    #[must_use]
    pub fn linear(name: &str, unit: &str) -> Self {
        Self::new(name, unit, Scale::Linear)
    }

    /// A logarithmic axis.
    #[must_use]
    pub fn log(name: &str, unit: &str) -> Self {
        Self::new(name, unit, Scale::Log)
    }

    /// An axis for shares on which a normal distribution is straight.
    #[must_use]
    pub fn probability(name: &str) -> Self {
        Self::new(name, "%", Scale::Probability)
    }

    /// An axis for shares on which, over a logarithmic one, a Rosin-Rammler distribution is straight.
    #[must_use]
    pub fn rosin_rammler(name: &str) -> Self {
        Self::new(name, "%", Scale::RosinRammler)
    }

    /// This axis from `low` to `high` (SI).
    #[must_use]
    pub fn within(mut self, low: f64, high: f64) -> Self {
        self.range = Some((low, high));
        self
    }

    /// Fault of the axis, if there is one.
    pub(super) fn fault(&self) -> Option<String> {
        let (low, high) = self.range?;
        let places = (self.scale.place(low), self.scale.place(high));
        match places {
            (Some(a), Some(b)) if a < b => None,
            _ => Some(format!(
                "\"{}\" cannot go from {low} to {high}: expected two rising {}",
                self.name,
                match self.scale {
                    Scale::Linear => "numbers",
                    Scale::Log => "positive numbers",
                    Scale::Probability | Scale::RosinRammler => "shares between 0 and 1",
                }
            )),
        }
    }
}
