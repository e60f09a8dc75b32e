//! The laws and their number-weighted view.

use std::f64::consts::PI;

use super::error::SizeError;
use super::normal::{normal_cdf, normal_quantile};
use super::tabulated::Tabulated;
use crate::scene::{Located, Psd, SceneError, SizeLaw, Weighting};

/// The share left out at an open end of a law: a law that reaches down to 0 or up to infinity is cut at
/// the quantiles 1e-9 and 1 - 1e-9 of its stated weighting, unless `cut` is narrower. So every law has a
/// smallest and a largest diameter, and the plan may size its grids by them.
const OPEN_END: f64 = 1e-9;

/// A law of the diameter that particles can be drawn from.
///
/// Built from a scene by [`SizeDistribution::from_scene`]. Diameters in m.
#[derive(Debug, Clone)]
pub struct SizeDistribution {
    law: Law,
    /// k of the stated weighting, q_k(d) proportional to d^k q_0(d).
    power: i32,
    /// Shares of the stated law, before cutting, at the two bounds.
    bounds: [f64; 2],
    smallest: f64,
    largest: f64,
    number: Number,
}

/// The stated law in its weighting, before cutting.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Law {
    Monodisperse(f64),
    Uniform { min: f64, max: f64 },
    Normal { mean: f64, deviation: f64 },
    Lognormal { median: f64, sigma: f64 },
    RosinRammler { d63: f64, exponent: f64 },
    Power { max: f64, exponent: f64 },
}

/// How the number law is evaluated.
#[derive(Debug, Clone)]
enum Number {
    /// By the closed form that belongs to the law.
    Closed,
    /// By a table.
    Table(Box<Tabulated>),
}

impl SizeDistribution {
    /// The distribution that a scene asks for.
    ///
    /// # Errors
    /// [`SizeError::File`] for a measured distribution, which needs its table;
    /// [`SizeError::Improper`] where the law as stated holds infinitely many particles at d = 0 or
    /// reaches d <= 0, with the place in the scene and the remedy.
    pub fn from_scene(psd: &Located<Psd>) -> Result<Self, SizeError> {
        let law = match &psd.law {
            SizeLaw::Monodisperse { diameter } => Law::Monodisperse(**diameter),
            SizeLaw::Uniform {
                min_diameter,
                max_diameter,
            } => {
                if **min_diameter == **max_diameter {
                    Law::Monodisperse(**min_diameter)
                } else {
                    Law::Uniform {
                        min: **min_diameter,
                        max: **max_diameter,
                    }
                }
            }
            SizeLaw::Normal {
                mean_diameter,
                standard_deviation,
            } => Law::Normal {
                mean: **mean_diameter,
                deviation: **standard_deviation,
            },
            SizeLaw::Lognormal {
                median_diameter,
                sigma,
            } => Law::Lognormal {
                median: **median_diameter,
                sigma: **sigma,
            },
            // phi = -log2(d / 1 mm) is normal exactly when ln d is, with ln 2 between their widths.
            SizeLaw::PhiNormal {
                median_diameter,
                sigma_phi,
            } => Law::Lognormal {
                median: **median_diameter,
                sigma: **sigma_phi * std::f64::consts::LN_2,
            },
            SizeLaw::RosinRammler { d63, exponent } => Law::RosinRammler {
                d63: **d63,
                exponent: **exponent,
            },
            SizeLaw::Ggs {
                max_diameter,
                exponent,
            } => Law::Power {
                max: **max_diameter,
                exponent: **exponent,
            },
            SizeLaw::File { file } => return Err(SizeError::File(file.clone())),
        };
        let weighting = psd.weighting.unwrap_or(Weighting::Number);
        let cut = psd.cut.as_ref().map(|cut| cut.value);
        Self::new(law, i32::from(weighting.power()), cut)
            .map_err(|problem| SizeError::Improper(improper(psd, &problem)))
    }

    fn new(law: Law, power: i32, cut: Option<[f64; 2]>) -> Result<Self, String> {
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
        let (open_below, open_above) = match law {
            Law::Monodisperse(_) | Law::Uniform { .. } => (false, false),
            Law::Power { .. } => (true, false),
            _ => (true, true),
        };
        if open_below {
            low = low.max(OPEN_END);
        }
        if open_above {
            high = high.min(1.0 - OPEN_END);
        }
        let (smallest, largest) = (law.quantile(low), law.quantile(high));
        if !(smallest > 0.0 && largest.is_finite() && smallest <= largest && low < high) {
            return Err("has no finite, positive range of diameters".to_owned());
        }
        let mut distribution = Self {
            law,
            power,
            bounds: [low, high],
            smallest,
            largest,
            number: Number::Closed,
        };
        let has_closed_form = match law {
            Law::Normal { .. } | Law::RosinRammler { .. } => power == 0,
            _ => true,
        };
        if !has_closed_form {
            let table = Tabulated::new(smallest, largest, |d| distribution.number_density(d));
            distribution.number = Number::Table(Box::new(table));
        }
        let mean = distribution.mean_volume();
        if !(mean.is_finite() && mean > 0.0) {
            return Err("is too wide for double precision".to_owned());
        }
        Ok(distribution)
    }

    /// Smallest diameter that is drawn, m: the lower cut, or the quantile 1e-9 (in the stated
    /// weighting) of a law that reaches down to 0.
    #[must_use]
    pub fn smallest(&self) -> f64 {
        self.smallest
    }

    /// Largest diameter that is drawn, m: the upper cut, or the quantile 1 - 1e-9 (in the stated
    /// weighting) of a law without upper end, for a lognormal law 5.998 sigma above the median.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.largest
    }

    /// The diameter below which a share `q` of the cut law lies, counted in the stated weighting, m.
    /// `q` is clipped to [0, 1].
    #[must_use]
    pub fn quantile(&self, q: f64) -> f64 {
        let [low, high] = self.bounds;
        let q = q.clamp(0.0, 1.0);
        self.law
            .quantile(low + q * (high - low))
            .clamp(self.smallest, self.largest)
    }

    /// A random diameter, m, from a uniform random number in [0, 1]: the inverse of
    /// [`SizeDistribution::number_cdf`], increasing in `u`. `u` is clipped to [0, 1].
    #[must_use]
    pub fn sample_diameter(&self, u: f64) -> f64 {
        let (a, b) = (self.smallest, self.largest);
        if u <= 0.0 {
            return a;
        }
        if u >= 1.0 {
            return b;
        }
        let diameter = match (&self.number, self.law) {
            (Number::Table(table), _) => table.quantile(|d| self.number_density(d), u),
            (_, Law::Monodisperse(diameter)) => diameter,
            // The density 1/d^k integrated and inverted.
            (_, Law::Uniform { .. }) => match self.power {
                0 => a + u * (b - a),
                1 => a * (u * (b / a).ln()).exp(),
                2 => a * b / (b - u * (b - a)),
                _ => a * b / (b * b - u * (b - a) * (b + a)).sqrt(),
            },
            (_, Law::Lognormal { median, sigma }) => {
                let centre = median.ln() - f64::from(self.power) * sigma * sigma;
                let z = |d: f64| (d.ln() - centre) / sigma;
                (centre + sigma * truncated_normal(z(a), z(b), u)).exp()
            }
            (_, Law::Normal { mean, deviation }) => {
                let z = |d: f64| (d - mean) / deviation;
                mean + deviation * truncated_normal(z(a), z(b), u)
            }
            (_, Law::Power { exponent, .. }) => {
                let e = exponent - f64::from(self.power);
                let range = (b / a).ln();
                let share = if e == 0.0 {
                    u * range
                } else {
                    (u * (e * range).exp_m1()).ln_1p() / e
                };
                a * share.exp()
            }
            (_, Law::RosinRammler { .. }) => return self.quantile(u),
        };
        diameter.clamp(a, b)
    }

    /// Share of the particles, by number, that are smaller than `diameter` (m).
    #[must_use]
    pub fn number_cdf(&self, diameter: f64) -> f64 {
        let (a, b) = (self.smallest, self.largest);
        if diameter < a {
            return 0.0;
        }
        if diameter >= b {
            return 1.0;
        }
        let share = match (&self.number, self.law) {
            (Number::Table(table), _) => table.cdf(|d| self.number_density(d), diameter),
            (_, Law::Monodisperse(_)) => 1.0,
            (_, Law::Uniform { .. }) => {
                let p = -self.power;
                (diameter - a) * power_mean(a, diameter, p) / ((b - a) * power_mean(a, b, p))
            }
            (_, Law::Lognormal { .. } | Law::Normal { .. }) => {
                self.partial_moment(0, a, diameter) / self.partial_moment(0, a, b)
            }
            (_, Law::Power { exponent, .. }) => {
                let e = exponent - f64::from(self.power);
                growth(e, (diameter / a).ln()) / growth(e, (b / a).ln())
            }
            (_, Law::RosinRammler { .. }) => {
                let [low, high] = self.bounds;
                (self.law.cdf(diameter) - low) / (high - low)
            }
        };
        share.clamp(0.0, 1.0)
    }

    /// Mean diameter by number, m.
    #[must_use]
    pub fn mean_diameter(&self) -> f64 {
        self.moment(1)
    }

    /// Mean volume of a particle, by number: the mean of pi/6 d^3, m3.
    ///
    /// ```
    /// # use std::path::Path;
    /// # use mercury_common::scene::{Files, parse_scene};
    /// # use mercury_common::sizes::SizeDistribution;
    /// # let text = "[time]\nend = 1.0\nstep = 0.1\n[domain]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n[output]\ninterval = 0.1\n\
    /// # [materials.m]\ndensity = 1.0\nnormal = { law = \"linear\", stiffness = 1.0, dissipation = 0.0 }\n\
    /// # [[insertions]]\nname = \"feed\"\nregion = { shape = \"sphere\", origin = [0, 0, 0], radius = 1 }\nmaterial = \"m\"\ntotal = { full = true }\n\
    /// # psd = { kind = \"uniform\", min_diameter = 1.0, max_diameter = 3.0, weighting = \"number\" }\n";
    /// # let scene = parse_scene(Path::new("box.toml"), text, &[], Files::Unchecked).unwrap();
    /// // psd = { kind = "uniform", min_diameter = 1.0, max_diameter = 3.0, weighting = "number" }
    /// let sizes = SizeDistribution::from_scene(&scene.insertions[0].mixture[0].psd)?;
    /// // The mean of d^3 over [1, 3] is (3^4 - 1^4) / (4 * 2) = 10.
    /// assert!((sizes.mean_volume() - std::f64::consts::PI / 6.0 * 10.0).abs() < 1e-14);
    /// # Ok::<(), mercury_common::sizes::SizeError>(())
    /// ```
    #[must_use]
    pub fn mean_volume(&self) -> f64 {
        PI / 6.0 * self.moment(3)
    }

    /// Mean of d^j by number.
    fn moment(&self, j: i32) -> f64 {
        let (a, b) = (self.smallest, self.largest);
        match (&self.number, self.law) {
            (Number::Table(table), _) => table.mean(|d| self.number_density(d), |d| d.powi(j)),
            (_, Law::Monodisperse(diameter)) => diameter.powi(j),
            (_, Law::Uniform { .. }) => {
                power_mean(a, b, j - self.power) / power_mean(a, b, -self.power)
            }
            (_, Law::Lognormal { .. } | Law::Normal { .. }) => {
                self.partial_moment(j, a, b) / self.partial_moment(0, a, b)
            }
            (_, Law::Power { exponent, .. }) => {
                let e = exponent - f64::from(self.power);
                let range = (b / a).ln();
                a.powi(j) * growth(e + f64::from(j), range) / growth(e, range)
            }
            // By number and without table: the mean over the quantiles, whose ends are smooth enough
            // only in t = (d/d63)^n; tabulate for this one use.
            (_, Law::RosinRammler { .. }) => Tabulated::new(a, b, |d| self.number_density(d))
                .mean(|d| self.number_density(d), |d| d.powi(j)),
        }
    }

    /// Integral of d^j q_0(d) over [a, b], up to a factor that does not depend on the bounds or j, for
    /// the lognormal law in any weighting and the normal one by number.
    fn partial_moment(&self, j: i32, a: f64, b: f64) -> f64 {
        match self.law {
            // Weighting a lognormal law by d^p gives a lognormal law of the same sigma whose median is
            // larger by exp(p sigma^2) (Hatch and Choate 1929, J. Franklin Inst. 207, 369).
            Law::Lognormal { median, sigma } => {
                let number_median = median.ln() - f64::from(self.power) * sigma * sigma;
                let j = f64::from(j);
                let centre = number_median + j * sigma * sigma;
                let z = |d: f64| (d.ln() - centre) / sigma;
                (j * number_median + 0.5 * j * j * sigma * sigma).exp() * normal_share(z(a), z(b))
            }
            // Recursion of the moments of a truncated normal law by partial integration:
            // m_j = mean m_(j-1) + (j-1) s^2 m_(j-2) - s^2 [d^(j-1) q(d)] between the bounds.
            Law::Normal { mean, deviation } => {
                let z = |d: f64| (d - mean) / deviation;
                let density = |d: f64| (-0.5 * z(d) * z(d)).exp() / ((2.0 * PI).sqrt() * deviation);
                let square = deviation * deviation;
                let (mut before, mut last) = (0.0, normal_share(z(a), z(b)));
                for i in 1..=j {
                    let ends = b.powi(i - 1) * density(b) - a.powi(i - 1) * density(a);
                    let next = mean * last + f64::from(i - 1) * square * before - square * ends;
                    before = last;
                    last = next;
                }
                last
            }
            _ => f64::NAN,
        }
    }

    /// q_0(d) up to a factor.
    fn number_density(&self, d: f64) -> f64 {
        // Relative to the smallest size, so that d^-3 of micrometres does not overflow anything.
        let by_number = (d / self.smallest).powi(-self.power);
        by_number
            * match self.law {
                Law::Normal { mean, deviation } => {
                    let z = (d - mean) / deviation;
                    (-0.5 * z * z).exp()
                }
                Law::RosinRammler { d63, exponent } => {
                    let x = d / d63;
                    (-x.powf(exponent)).exp() * x.powf(exponent - 1.0)
                }
                _ => f64::NAN,
            }
    }
}

impl Law {
    /// Quantile in the stated weighting, before cutting.
    fn quantile(self, q: f64) -> f64 {
        match self {
            Law::Monodisperse(diameter) => diameter,
            Law::Uniform { min, max } => min + q * (max - min),
            // Only positive diameters exist: the law is the normal one given that d > 0.
            Law::Normal { mean, deviation } => {
                mean + deviation * truncated_normal(-mean / deviation, f64::INFINITY, q)
            }
            Law::Lognormal { median, sigma } => median * (sigma * normal_quantile(q)).exp(),
            Law::RosinRammler { d63, exponent } => d63 * (-(-q).ln_1p()).powf(1.0 / exponent),
            Law::Power { max, exponent } => max * q.powf(1.0 / exponent),
        }
    }

    /// Share below d in the stated weighting, before cutting; of the Rosin-Rammler law only.
    fn cdf(self, d: f64) -> f64 {
        match self {
            Law::RosinRammler { d63, exponent } => -(-(d / d63).powf(exponent)).exp_m1(),
            _ => f64::NAN,
        }
    }
}

fn improper(psd: &Located<Psd>, problem: &str) -> SceneError {
    psd.error(format!("the distribution {problem}"))
        .with_help("cut it at quantiles of its weighting, for example cut = [0.01, 0.99]")
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

/// Mean of d^p over [a, b], p = -3 ... 3, in forms without cancellation.
fn power_mean(a: f64, b: f64, p: i32) -> f64 {
    match p {
        -3 => (a + b) / (2.0 * a * a * b * b),
        -2 => 1.0 / (a * b),
        -1 => {
            if a == b {
                1.0 / a
            } else {
                ((b - a) / a).ln_1p() / (b - a)
            }
        }
        0 => 1.0,
        1 => 0.5 * (a + b),
        2 => (a * a + a * b + b * b) / 3.0,
        _ => 0.25 * (a + b) * (a * a + b * b),
    }
}

/// Integral of exp(e x) over [0, range].
fn growth(e: f64, range: f64) -> f64 {
    if e == 0.0 {
        range
    } else {
        (e * range).exp_m1() / e
    }
}

#[cfg(test)]
mod tests;
