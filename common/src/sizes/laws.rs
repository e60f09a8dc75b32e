//! Laws of the diameter by formula, cut to a finite range.

use std::f64::consts::PI;

use super::Weighting;
use super::powers::{power_mean, power_quantile, power_share, whole_power};
use super::tabulated::Tabulated;
use crate::normal::{normal_cdf, normal_quantile};

/// The share left out at an open end of a law: a law that reaches down to 0 or up to infinity is cut at
/// the quantiles 1e-9 and 1 - 1e-9 of its stated weighting, unless `cut` is narrower. So every law has a
/// smallest and a largest diameter, and the plan may size its grids by them.
const OPEN_END: f64 = 1e-9;

/// A law by formula, as stated in one weighting, and the range that is left of it. Diameters in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CutLaw {
    pub(super) law: Law,
    /// k of the stated weighting, q_k(d) proportional to d^k q_0(d).
    pub(super) power: i32,
    /// Shares of the stated law, before cutting, at the two bounds.
    pub(super) bounds: [f64; 2],
    pub(super) smallest: f64,
    pub(super) largest: f64,
}

/// The stated law in its weighting, before cutting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Law {
    Monodisperse(f64),
    Uniform { min: f64, max: f64 },
    Normal { mean: f64, deviation: f64 },
    Lognormal { median: f64, sigma: f64 },
    RosinRammler { d63: f64, exponent: f64 },
    Power { max: f64, exponent: f64 },
}

/// A cut law in one weighting, ready to evaluate.
#[derive(Debug, Clone)]
pub(super) enum WeightedLaw {
    /// All at one diameter.
    Atom(f64),
    /// Density proportional to d^p, p whole.
    Whole { a: f64, b: f64, power: i32 },
    /// Density proportional to d^(e-1).
    Power { a: f64, b: f64, exponent: f64 },
    /// ln d is normal.
    Lognormal {
        a: f64,
        b: f64,
        centre: f64,
        sigma: f64,
    },
    /// d is normal: in the stated weighting.
    Normal {
        a: f64,
        b: f64,
        mean: f64,
        deviation: f64,
    },
    /// The stated law itself.
    Stated(CutLaw),
    /// A table: the law times d^p.
    Table {
        table: Box<Tabulated>,
        law: CutLaw,
        power: i32,
    },
}

impl CutLaw {
    pub(super) fn new(law: Law, power: i32, cut: Option<[f64; 2]>) -> Result<Self, String> {
        let [mut low, mut high] = cut.unwrap_or([0.0, 1.0]);
        // A law that is not integrable by number at d = 0 needs the user's cut, not ours: the answer
        // would hang on it.
        let needs_cut = match law {
            Law::Normal { mean, deviation } => mean + deviation * normal_quantile(OPEN_END) <= 0.0,
            Law::RosinRammler { exponent, .. } | Law::Power { exponent, .. } => {
                exponent <= f64::from(power)
            }
            _ => false,
        };
        if needs_cut && low < OPEN_END {
            return Err(match law {
                Law::Normal { .. } => {
                    "reaches diameters <= 0: the mean is below 6 standard deviations".to_owned()
                }
                _ => format!(
                    "holds infinitely many particles near d = 0: the exponent is <= {power}"
                ),
            });
        }
        if law.is_open_below() {
            low = low.max(OPEN_END);
        }
        if law.is_open_above() {
            high = high.min(1.0 - OPEN_END);
        }
        let (smallest, largest) = (law.quantile(low), law.quantile(high));
        if !(smallest > 0.0 && largest.is_finite() && smallest <= largest && low < high) {
            return Err("has no finite, positive range of diameters".to_owned());
        }
        let cut = Self {
            law,
            power,
            bounds: [low, high],
            smallest,
            largest,
        };
        let mean = cut.moment(3);
        if !(mean.is_finite() && mean > 0.0) {
            return Err("is too wide for double precision".to_owned());
        }
        Ok(cut)
    }

    /// The quantiles that were left, where they are not those of the open ends.
    pub(super) fn stated_cut(&self) -> Option<[f64; 2]> {
        let [low, high] = self.bounds;
        let is_open_below = low == 0.0 || low == OPEN_END && self.law.is_open_below();
        let is_open_above = high == 1.0 || high == 1.0 - OPEN_END && self.law.is_open_above();
        (!(is_open_below && is_open_above)).then_some([
            if is_open_below { 0.0 } else { low },
            if is_open_above { 1.0 } else { high },
        ])
    }

    /// The diameter below which a share `q` lies, in the stated weighting.
    pub(super) fn quantile(&self, q: f64) -> f64 {
        let [low, high] = self.bounds;
        self.law
            .quantile(low + q * (high - low))
            .clamp(self.smallest, self.largest)
    }

    /// Ready to evaluate in a weighting.
    pub(super) fn by(&self, weighting: Weighting) -> WeightedLaw {
        // Density = stated density times d^power.
        let power = i32::from(weighting.power()) - self.power;
        let (a, b) = (self.smallest, self.largest);
        match self.law {
            Law::Monodisperse(diameter) => WeightedLaw::Atom(diameter),
            Law::Uniform { .. } => WeightedLaw::Whole { a, b, power },
            Law::Power { exponent, .. } => WeightedLaw::Power {
                a,
                b,
                exponent: exponent + f64::from(power),
            },
            // Weighting a lognormal law by d^p gives a lognormal law of the same sigma whose median is
            // larger by exp(p sigma^2) (Hatch and Choate 1929, J. Franklin Inst. 207, 369).
            Law::Lognormal { median, sigma } => WeightedLaw::Lognormal {
                a,
                b,
                centre: libm::log(median) + f64::from(power) * sigma * sigma,
                sigma,
            },
            Law::Normal { mean, deviation } if power == 0 => WeightedLaw::Normal {
                a,
                b,
                mean,
                deviation,
            },
            Law::RosinRammler { .. } if power == 0 => WeightedLaw::Stated(*self),
            _ => WeightedLaw::Table {
                table: Box::new(self.table(power)),
                law: *self,
                power,
            },
        }
    }

    fn table(&self, power: i32) -> Tabulated {
        Tabulated::new(self.smallest, self.largest, |d| self.density(d, power))
    }

    /// Mean of d^j by number.
    pub(super) fn moment(&self, j: i32) -> f64 {
        let (a, b) = (self.smallest, self.largest);
        match self.law {
            Law::Monodisperse(diameter) => whole_power(diameter, j),
            Law::Uniform { .. } => power_mean(a, b, j - self.power) / power_mean(a, b, -self.power),
            Law::Lognormal { .. } => self.partial_moment(j, a, b) / self.partial_moment(0, a, b),
            Law::Normal { .. } if self.power == 0 && j >= 0 => {
                self.partial_moment(j, a, b) / self.partial_moment(0, a, b)
            }
            Law::Power { exponent, .. } => {
                let e = exponent - f64::from(self.power);
                let range = libm::log(b / a);
                whole_power(a, j) * growth(e + f64::from(j), range) / growth(e, range)
            }
            Law::Normal { .. } | Law::RosinRammler { .. } => self
                .table(-self.power)
                .mean(|d| self.density(d, -self.power), |d| whole_power(d, j)),
        }
    }

    /// Integral of d^j q_0(d) over [a, b], up to a factor that does not depend on the bounds or j, for
    /// the lognormal law in any weighting and the normal one by number.
    fn partial_moment(&self, j: i32, a: f64, b: f64) -> f64 {
        match self.law {
            Law::Lognormal { median, sigma } => {
                let number_median = libm::log(median) - f64::from(self.power) * sigma * sigma;
                let j = f64::from(j);
                let centre = number_median + j * sigma * sigma;
                let z = |d: f64| (libm::log(d) - centre) / sigma;
                libm::exp(j * number_median + 0.5 * j * j * sigma * sigma)
                    * normal_share(z(a), z(b))
            }
            // Recursion of the moments of a truncated normal law by partial integration:
            // m_j = mean m_(j-1) + (j-1) s^2 m_(j-2) - s^2 [d^(j-1) q(d)] between the bounds.
            Law::Normal { mean, deviation } => {
                let z = |d: f64| (d - mean) / deviation;
                let density =
                    |d: f64| libm::exp(-0.5 * z(d) * z(d)) / ((2.0 * PI).sqrt() * deviation);
                let square = deviation * deviation;
                let (mut before, mut last) = (0.0, normal_share(z(a), z(b)));
                for i in 1..=j {
                    let ends =
                        whole_power(b, i - 1) * density(b) - whole_power(a, i - 1) * density(a);
                    let next = mean * last + f64::from(i - 1) * square * before - square * ends;
                    before = last;
                    last = next;
                }
                last
            }
            _ => f64::NAN,
        }
    }

    /// The stated density times d^power, up to a factor, for the laws that need tables.
    fn density(&self, d: f64, power: i32) -> f64 {
        // Relative to the smallest size, so that d^-3 of micrometres does not overflow anything.
        whole_power(d / self.smallest, power)
            * match self.law {
                Law::Normal { mean, deviation } => {
                    let z = (d - mean) / deviation;
                    libm::exp(-0.5 * z * z)
                }
                Law::RosinRammler { d63, exponent } => {
                    let x = d / d63;
                    libm::exp(-libm::pow(x, exponent)) * libm::pow(x, exponent - 1.0)
                }
                _ => f64::NAN,
            }
    }
}

impl WeightedLaw {
    /// The diameter below which a share `u` lies; `u` in (0, 1).
    pub(super) fn quantile(&self, u: f64) -> f64 {
        match *self {
            Self::Atom(diameter) => diameter,
            Self::Whole { a, b, power } => power_quantile(a, b, power, u),
            Self::Power { a, b, exponent } => {
                let range = libm::log(b / a);
                let share = if exponent == 0.0 {
                    u * range
                } else {
                    libm::log1p(u * libm::expm1(exponent * range)) / exponent
                };
                (a * libm::exp(share)).clamp(a, b)
            }
            Self::Lognormal {
                a,
                b,
                centre,
                sigma,
            } => {
                let z = |d: f64| (libm::log(d) - centre) / sigma;
                let x = truncated_normal(z(a), z(b), u);
                libm::exp(centre + sigma * x).clamp(a, b)
            }
            Self::Normal {
                a,
                b,
                mean,
                deviation,
            } => {
                let z = |d: f64| (d - mean) / deviation;
                (mean + deviation * truncated_normal(z(a), z(b), u)).clamp(a, b)
            }
            Self::Stated(law) => law.quantile(u),
            Self::Table {
                ref table,
                law,
                power,
            } => table
                .quantile(|d| law.density(d, power), u)
                .clamp(law.smallest, law.largest),
        }
    }

    /// The share below `diameter`, which lies between smallest and largest.
    pub(super) fn cdf(&self, diameter: f64) -> f64 {
        let share = match *self {
            Self::Atom(_) => 1.0,
            Self::Whole { a, b, power } => power_share(a, b, power, diameter),
            Self::Power { a, b, exponent } => {
                growth(exponent, libm::log(diameter / a)) / growth(exponent, libm::log(b / a))
            }
            Self::Lognormal {
                a,
                b,
                centre,
                sigma,
            } => {
                let z = |d: f64| (libm::log(d) - centre) / sigma;
                normal_share(z(a), z(diameter)) / normal_share(z(a), z(b))
            }
            Self::Normal {
                a,
                b,
                mean,
                deviation,
            } => {
                let z = |d: f64| (d - mean) / deviation;
                normal_share(z(a), z(diameter)) / normal_share(z(a), z(b))
            }
            Self::Stated(law) => {
                let [low, high] = law.bounds;
                (law.law.cdf(diameter) - low) / (high - low)
            }
            Self::Table {
                ref table,
                law,
                power,
            } => table.cdf(|d| law.density(d, power), diameter),
        };
        share.clamp(0.0, 1.0)
    }

    /// The density per metre at `diameter`, which lies between smallest and largest; of one size infinite.
    pub(super) fn density(&self, d: f64) -> f64 {
        let gauss = |z: f64| libm::exp(-0.5 * z * z) / (2.0 * PI).sqrt();
        match *self {
            Self::Atom(_) => f64::INFINITY,
            Self::Whole { a, b, power } => {
                whole_power(d / b, power) / (power_mean(a / b, 1.0, power) * (b - a))
            }
            Self::Power { a, b, exponent } => {
                let range = libm::log(b / a);
                libm::exp((exponent - 1.0) * libm::log(d / a)) / (a * growth(exponent, range))
            }
            Self::Lognormal {
                a,
                b,
                centre,
                sigma,
            } => {
                let z = |d: f64| (libm::log(d) - centre) / sigma;
                gauss(z(d)) / (sigma * d * normal_share(z(a), z(b)))
            }
            Self::Normal {
                a,
                b,
                mean,
                deviation,
            } => {
                let z = |d: f64| (d - mean) / deviation;
                gauss(z(d)) / (deviation * normal_share(z(a), z(b)))
            }
            Self::Stated(law) => {
                let [low, high] = law.bounds;
                match law.law {
                    Law::RosinRammler { d63, exponent } => {
                        law.density(d, 0) * exponent / (d63 * (high - low))
                    }
                    _ => f64::NAN,
                }
            }
            Self::Table {
                ref table,
                law,
                power,
            } => law.density(d, power) / table.total(),
        }
    }
}

impl Law {
    fn is_open_below(self) -> bool {
        !matches!(self, Law::Monodisperse(_) | Law::Uniform { .. })
    }

    fn is_open_above(self) -> bool {
        self.is_open_below() && !matches!(self, Law::Power { .. })
    }

    /// The law of diameters that are all larger by a factor.
    pub(super) fn scaled(self, factor: f64) -> Self {
        match self {
            Law::Monodisperse(diameter) => Law::Monodisperse(factor * diameter),
            Law::Uniform { min, max } => Law::Uniform {
                min: factor * min,
                max: factor * max,
            },
            Law::Normal { mean, deviation } => Law::Normal {
                mean: factor * mean,
                deviation: factor * deviation,
            },
            Law::Lognormal { median, sigma } => Law::Lognormal {
                median: factor * median,
                sigma,
            },
            Law::RosinRammler { d63, exponent } => Law::RosinRammler {
                d63: factor * d63,
                exponent,
            },
            Law::Power { max, exponent } => Law::Power {
                max: factor * max,
                exponent,
            },
        }
    }

    /// Quantile in the stated weighting, before cutting.
    fn quantile(self, q: f64) -> f64 {
        match self {
            Law::Monodisperse(diameter) => diameter,
            Law::Uniform { min, max } => min + q * (max - min),
            // Only positive diameters exist: the law is the normal one given that d > 0.
            Law::Normal { mean, deviation } => {
                mean + deviation * truncated_normal(-mean / deviation, f64::INFINITY, q)
            }
            Law::Lognormal { median, sigma } => median * libm::exp(sigma * normal_quantile(q)),
            Law::RosinRammler { d63, exponent } => {
                d63 * libm::pow(-libm::log1p(-q), 1.0 / exponent)
            }
            Law::Power { max, exponent } => max * libm::pow(q, 1.0 / exponent),
        }
    }

    /// Share below d in the stated weighting, before cutting; of the Rosin-Rammler law only.
    fn cdf(self, d: f64) -> f64 {
        match self {
            Law::RosinRammler { d63, exponent } => -libm::expm1(-libm::pow(d / d63, exponent)),
            _ => f64::NAN,
        }
    }
}

/// Share of the standard normal law in [low, high], without cancellation in the upper tail.
fn normal_share(low: f64, high: f64) -> f64 {
    if low > 0.0 {
        normal_cdf(-low) - normal_cdf(-high)
    } else {
        normal_cdf(high) - normal_cdf(low)
    }
}

/// Quantile of the standard normal law given that it lies in [low, high].
fn truncated_normal(low: f64, high: f64, u: f64) -> f64 {
    if low > 0.0 {
        return -truncated_normal(-high, -low, 1.0 - u);
    }
    let below = normal_cdf(low);
    normal_quantile(below + u * (normal_cdf(high) - below)).clamp(low, high)
}

/// Integral of exp(e x) over [0, range].
fn growth(e: f64, range: f64) -> f64 {
    if e == 0.0 {
        range
    } else {
        libm::expm1(e * range) / e
    }
}

#[cfg(test)]
mod tests;
