//! The laws that are fitted, one or two of them together.

use mercury_common::normal::normal_quantile;

/// The shape of a law.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Shape {
    /// ln d is normal; by another name phi-normal, sigma = sigma_phi ln 2.
    Lognormal,
    /// d is normal, given that it is positive.
    Normal,
    /// 1 - exp(-(d/d63)^n).
    RosinRammler,
    /// (d/d_max)^n.
    Ggs,
}

/// A shape, alone or two of it mixed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Family {
    /// The shape.
    pub shape: Shape,
    /// 1, or 2 for a mixture.
    pub components: usize,
}

/// All families with their words.
const FAMILIES: [(&str, Shape, usize); 7] = [
    ("lognormal", Shape::Lognormal, 1),
    ("normal", Shape::Normal, 1),
    ("rosin-rammler", Shape::RosinRammler, 1),
    ("ggs", Shape::Ggs, 1),
    ("two-lognormal", Shape::Lognormal, 2),
    ("two-normal", Shape::Normal, 2),
    ("two-rosin-rammler", Shape::RosinRammler, 2),
];

impl Family {
    /// All families, the single ones first.
    pub fn all() -> impl Iterator<Item = Self> {
        FAMILIES
            .iter()
            .map(|&(_, shape, components)| Self { shape, components })
    }

    /// `lognormal`, `two-normal`, ...
    #[must_use]
    pub fn word(self) -> &'static str {
        let found = FAMILIES
            .iter()
            .find(|f| f.1 == self.shape && f.2 == self.components);
        found.map_or("", |family| family.0)
    }

    /// The number of free parameters.
    #[must_use]
    pub fn parameters(self) -> usize {
        3 * self.components - 1
    }
}

impl std::str::FromStr for Family {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        let word = match word {
            // Other names of the same laws.
            "weibull" => "rosin-rammler",
            "phi-normal" => "lognormal",
            word => word,
        };
        let found = FAMILIES.iter().find(|family| family.0 == word);
        found
            .map(|&(_, shape, components)| Self { shape, components })
            .ok_or_else(|| {
                let words: Vec<&str> = FAMILIES.iter().map(|family| family.0).collect();
                format!(
                    "there is no family \"{word}\"; there are: {}",
                    words.join(", ")
                )
            })
    }
}

impl Shape {
    /// The kind of the scene format.
    pub(super) fn word(self) -> &'static str {
        Family {
            shape: self,
            components: 1,
        }
        .word()
    }

    /// The keys of the scene format.
    pub(super) fn names(self) -> [&'static str; 2] {
        match self {
            Shape::Lognormal => ["median_diameter", "sigma"],
            Shape::Normal => ["mean_diameter", "standard_deviation"],
            Shape::RosinRammler => ["d63", "exponent"],
            Shape::Ggs => ["max_diameter", "exponent"],
        }
    }

    pub(super) fn is_length(self, index: usize) -> bool {
        index == 0 || self == Shape::Normal
    }

    /// Searched as it is, not by its logarithm.
    pub(super) fn is_plain(self, index: usize) -> bool {
        self == Shape::Normal && index == 0
    }
}

/// One component: a location and a width.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Part {
    pub(super) shape: Shape,
    /// Median, mean, d63 or largest diameter.
    place: f64,
    /// Sigma, standard deviation or exponent.
    width: f64,
}

/// Share of the standard normal law below x.
fn phi(x: f64) -> f64 {
    0.5 * libm::erfc(-x * std::f64::consts::FRAC_1_SQRT_2)
}

/// Share of the standard normal law in [a, b].
fn phi_between(a: f64, b: f64) -> f64 {
    if a > 0.0 {
        phi(-a) - phi(-b)
    } else {
        phi(b) - phi(a)
    }
}

const LN_ROOT_TAU: f64 = 0.918_938_533_204_672_7;

impl Part {
    /// From two searched parameters.
    pub(super) fn of(shape: Shape, theta: &[f64]) -> Self {
        Self {
            shape,
            place: if shape == Shape::Normal {
                theta[0]
            } else {
                libm::exp(theta[0])
            },
            width: libm::exp(theta[1]),
        }
    }

    /// The parameters by the names of the scene format.
    pub(super) fn values(&self) -> [f64; 2] {
        [self.place, self.width]
    }

    pub(super) fn scaled(self, unit: f64) -> Self {
        Self {
            place: unit * self.place,
            width: match self.shape {
                Shape::Normal => unit * self.width,
                _ => self.width,
            },
            ..self
        }
    }

    fn z(&self, d: f64) -> f64 {
        match self.shape {
            Shape::Lognormal => libm::log(d / self.place) / self.width,
            _ => (d - self.place) / self.width,
        }
    }

    /// Share of the normal law that is positive.
    fn positive(&self) -> f64 {
        phi(self.place / self.width)
    }

    pub(super) fn cdf(&self, d: f64) -> f64 {
        self.share(0.0, d)
    }

    /// Share in [a, b], b may be infinite, without cancellation in the tails.
    pub(super) fn share(&self, a: f64, b: f64) -> f64 {
        if b <= a || b <= 0.0 {
            return 0.0;
        }
        match self.shape {
            Shape::Lognormal => {
                let low = if a > 0.0 {
                    self.z(a)
                } else {
                    f64::NEG_INFINITY
                };
                phi_between(low, self.z(b))
            }
            Shape::Normal => phi_between(self.z(a.max(0.0)), self.z(b)) / self.positive(),
            Shape::RosinRammler => {
                let power = |d: f64| libm::pow(d / self.place, self.width);
                let (low, high) = (power(a), power(b));
                libm::exp(-low) * -libm::expm1(low - high)
            }
            Shape::Ggs => {
                let power = |d: f64| libm::pow((d / self.place).min(1.0), self.width);
                power(b) - power(a)
            }
        }
    }

    pub(super) fn ln_density(&self, d: f64) -> f64 {
        let (n, place) = (self.width, self.place);
        match self.shape {
            Shape::Lognormal => {
                let z = self.z(d);
                -0.5 * z * z - LN_ROOT_TAU - libm::log(self.width * d)
            }
            Shape::Normal => {
                let z = self.z(d);
                -0.5 * z * z - LN_ROOT_TAU - libm::log(self.width * self.positive())
            }
            Shape::RosinRammler => {
                let ln_x = libm::log(d / place);
                libm::log(n / place) + (n - 1.0) * ln_x - libm::exp(n * ln_x)
            }
            Shape::Ggs if d > place => f64::NEG_INFINITY,
            Shape::Ggs => libm::log(n / place) + (n - 1.0) * libm::log(d / place),
        }
    }

    pub(super) fn quantile(&self, u: f64) -> f64 {
        match self.shape {
            Shape::Lognormal => self.place * libm::exp(self.width * normal_quantile(u)),
            Shape::Normal => {
                // From the upper side, where the part below 0 is out of the way.
                let above = (1.0 - u) * self.positive();
                self.place - self.width * normal_quantile(above)
            }
            Shape::RosinRammler => self.place * libm::pow(-libm::log1p(-u), 1.0 / self.width),
            Shape::Ggs => self.place * libm::pow(u, 1.0 / self.width),
        }
    }
}

/// One component or two with their shares.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Law {
    pub(super) parts: Vec<(f64, Part)>,
}

/// Whether the first component of searched parameters of a mixture is the smaller one.
pub(super) fn first_is_smaller(family: Family, theta: &[f64]) -> bool {
    let median = |theta: &[f64]| Part::of(family.shape, theta).quantile(0.5);
    median(&theta[1..3]) <= median(&theta[3..5])
}

impl Law {
    /// From searched parameters; the smaller component first.
    pub(super) fn of(family: Family, theta: &[f64]) -> Self {
        if family.components == 1 {
            return Self {
                parts: vec![(1.0, Part::of(family.shape, theta))],
            };
        }
        let share = 1.0 / (1.0 + libm::exp(-theta[0]));
        let rest = 1.0 / (1.0 + libm::exp(theta[0]));
        let mut parts = vec![
            (share, Part::of(family.shape, &theta[1..3])),
            (rest, Part::of(family.shape, &theta[3..5])),
        ];
        if !first_is_smaller(family, theta) {
            parts.swap(0, 1);
        }
        Self { parts }
    }

    pub(super) fn scaled(mut self, unit: f64) -> Self {
        for (_, part) in &mut self.parts {
            *part = part.scaled(unit);
        }
        self
    }

    pub(super) fn cdf(&self, d: f64) -> f64 {
        self.share(0.0, d)
    }

    pub(super) fn share(&self, a: f64, b: f64) -> f64 {
        self.parts
            .iter()
            .map(|(share, part)| share * part.share(a, b))
            .sum()
    }

    pub(super) fn ln_density(&self, d: f64) -> f64 {
        match &self.parts[..] {
            [(_, part)] => part.ln_density(d),
            parts => {
                // Relative to the larger one, so that neither vanishes.
                let logs = parts
                    .iter()
                    .map(|(share, part)| libm::log(*share) + part.ln_density(d));
                let logs: Vec<f64> = logs.collect();
                let largest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                if largest == f64::NEG_INFINITY {
                    return largest;
                }
                let sum: f64 = logs.iter().map(|log| libm::exp(log - largest)).sum();
                largest + libm::log(sum)
            }
        }
    }

    pub(super) fn quantile(&self, u: f64) -> f64 {
        let quantiles = || self.parts.iter().map(|(_, part)| part.quantile(u));
        let mut low = quantiles().fold(f64::INFINITY, f64::min);
        let mut high = quantiles().fold(0.0, f64::max);
        for _ in 0..200 {
            if high - low <= 1e-15 * high {
                break;
            }
            let middle = 0.5 * (low + high);
            if self.cdf(middle) < u {
                low = middle
            } else {
                high = middle
            }
        }
        high
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_densities_and_quantiles_agree() {
        for family in Family::all() {
            let theta = match family.components {
                1 => vec![0.1, -1.2],
                _ => vec![0.4, 0.6, -1.4, 0.1, -1.2],
            };
            let law = Law::of(family, &theta);
            for i in 1..20 {
                let u = f64::from(i) / 20.0;
                let d = law.quantile(u);
                assert!(d > 0.0);
                assert!(
                    (law.cdf(d) - u).abs() < 1e-12,
                    "{family:?} {u}: {}",
                    law.cdf(d)
                );
                // Central difference: error h^2/6 of the third derivative, some 1e-8 here.
                let h = 1e-4 * d;
                let slope = law.share(d - h, d + h) / (2.0 * h);
                let density = libm::exp(law.ln_density(d));
                let ends = family.shape == Shape::Ggs && d + h > law.quantile(1.0);
                assert!(
                    ends || (slope / density - 1.0).abs() < 1e-5,
                    "{family:?} {u}: {slope} {density}"
                );
            }
            let word = family.word();
            assert_eq!(word.parse::<Family>(), Ok(family));
        }
        assert!(
            "gamma"
                .parse::<Family>()
                .unwrap_err()
                .contains("there are: lognormal")
        );
    }
}
