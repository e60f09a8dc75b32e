//! A measured distribution: shares of classes of the diameter, and what is assumed inside a class.

use super::Weighting;
use super::powers::{power_mean, power_quantile, power_share, whole_power};

/// How sizes are spread inside a measured class, which no measurement shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ClassModel {
    /// The density of a quantity per metre is constant: of the number (the default), or of that which was measured.
    Uniform(Weighting),
    /// The density of a quantity per ln d is constant, as laser diffraction spaces its classes.
    LogUniform(Weighting),
}

impl Default for ClassModel {
    fn default() -> Self {
        Self::Uniform(Weighting::Number)
    }
}

/// All models with the words that name them in files.
const MODELS: [(&str, ClassModel); 8] = [
    ("number-uniform", ClassModel::Uniform(Weighting::Number)),
    ("length-uniform", ClassModel::Uniform(Weighting::Length)),
    ("area-uniform", ClassModel::Uniform(Weighting::Area)),
    ("volume-uniform", ClassModel::Uniform(Weighting::Volume)),
    (
        "number-log-uniform",
        ClassModel::LogUniform(Weighting::Number),
    ),
    (
        "length-log-uniform",
        ClassModel::LogUniform(Weighting::Length),
    ),
    ("area-log-uniform", ClassModel::LogUniform(Weighting::Area)),
    (
        "volume-log-uniform",
        ClassModel::LogUniform(Weighting::Volume),
    ),
];

impl ClassModel {
    /// The number density inside a class goes with d to this power: q_k(d) = d^k q_0(d) constant, or constant per ln d.
    fn exponent(self) -> i32 {
        match self {
            Self::Uniform(weighting) => -i32::from(weighting.power()),
            Self::LogUniform(weighting) => -1 - i32::from(weighting.power()),
        }
    }

    /// The word of files: `number-uniform`, `volume-log-uniform`, ...
    #[must_use]
    pub fn word(self) -> &'static str {
        let found = MODELS.iter().find(|(_, model)| *model == self);
        found.map_or("number-uniform", |(word, _)| word)
    }

    /// The model of a word.
    #[must_use]
    pub fn from_word(word: &str) -> Option<Self> {
        let found = MODELS.iter().find(|(name, _)| *name == word);
        found.map(|(_, model)| *model)
    }

    /// All models with their words.
    pub fn all() -> impl Iterator<Item = (&'static str, Self)> {
        MODELS.into_iter()
    }
}

/// Why classes make no distribution.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ClassProblem {
    /// The numbers of edges and shares do not match, or there is no class.
    #[error(
        "{edges} diameters bound no {shares} classes: one more diameter than shares is needed, and at least one class"
    )]
    Lengths {
        /// Number of edges.
        edges: usize,
        /// Number of shares.
        shares: usize,
    },
    /// A diameter that cannot bound a class.
    #[error("diameter {} of the list is {value}: diameters must be finite, >= 0 and ascending", .index + 1)]
    Edge {
        /// Its place in the list, from 0.
        index: usize,
        /// The diameter, m.
        value: f64,
    },
    /// A share that is negative or not finite.
    #[error("share {} of the list is {value}: shares must be finite and >= 0", .index + 1)]
    Share {
        /// Its place in the list, from 0.
        index: usize,
        /// The share.
        value: f64,
    },
    /// All shares are 0.
    #[error("all shares are 0")]
    Empty,
    /// The first class reaches down to 0 where the model puts infinitely many particles.
    #[error("the finest class reaches down to diameter 0, where \"{}\" means infinitely many particles", .0.word())]
    Zero(ClassModel),
}

/// Shares of classes of the diameter, exact in every weighting for the chosen [`ClassModel`].
///
/// Inside a class the number density goes with d^s, s whole, so every share, quantile and moment is a closed form.
#[derive(Debug, Clone, PartialEq)]
pub struct Classes {
    /// Diameters between classes, m, ascending; one more than classes.
    edges: Vec<f64>,
    /// Share of each class by number; their sum is 1.
    numbers: Vec<f64>,
    model: ClassModel,
}

impl Classes {
    /// Classes with shares of a quantity, in any unit: they are scaled to the sum 1. Empty classes at the ends are dropped.
    ///
    /// # Errors
    /// [`ClassProblem`], with the place in the list.
    pub fn new(
        edges: &[f64],
        shares: &[f64],
        weighting: Weighting,
        model: ClassModel,
    ) -> Result<Self, ClassProblem> {
        if shares.is_empty() || edges.len() != shares.len() + 1 {
            return Err(ClassProblem::Lengths {
                edges: edges.len(),
                shares: shares.len(),
            });
        }
        for (index, &value) in edges.iter().enumerate() {
            let ascends = index == 0 || value > edges[index - 1];
            if !(value.is_finite() && value >= 0.0 && ascends) {
                return Err(ClassProblem::Edge { index, value });
            }
        }
        for (index, &value) in shares.iter().enumerate() {
            if !(value.is_finite() && value >= 0.0) {
                return Err(ClassProblem::Share { index, value });
            }
        }
        let first = shares.iter().position(|&share| share > 0.0);
        let last = shares.iter().rposition(|&share| share > 0.0);
        let (Some(first), Some(last)) = (first, last) else {
            return Err(ClassProblem::Empty);
        };
        let edges = &edges[first..=last + 1];
        let shares = &shares[first..=last];
        if edges[0] == 0.0 && model.exponent() < 0 {
            return Err(ClassProblem::Zero(model));
        }
        // Diameters relative to the largest, so that powers of micrometres stay in range.
        let scale = edges[edges.len() - 1];
        let k = i32::from(weighting.power());
        let s = model.exponent();
        let counts: Vec<f64> = edges
            .windows(2)
            .zip(shares)
            .map(|(class, share)| {
                let (a, b) = (class[0] / scale, class[1] / scale);
                share * power_mean(a, b, s) / power_mean(a, b, s + k)
            })
            .collect();
        let sum: f64 = counts.iter().sum();
        Ok(Self {
            edges: edges.to_vec(),
            numbers: counts.iter().map(|count| count / sum).collect(),
            model,
        })
    }

    /// The diameters between classes, m, ascending.
    #[must_use]
    pub fn edges(&self) -> &[f64] {
        &self.edges
    }

    /// Distribution inside a class.
    #[must_use]
    pub fn model(&self) -> ClassModel {
        self.model
    }

    /// The share of each class of a quantity; their sum is 1.
    #[must_use]
    pub fn shares(&self, weighting: Weighting) -> Vec<f64> {
        let k = i32::from(weighting.power());
        let scale = self.edges[self.edges.len() - 1];
        let parts: Vec<f64> = self.parts(k, scale).collect();
        let sum: f64 = parts.iter().sum();
        parts.iter().map(|part| part / sum).collect()
    }

    /// The share of a quantity below each edge: 0 at the first, 1 at the last.
    #[must_use]
    pub fn cumulative(&self, weighting: Weighting) -> Vec<f64> {
        let shares = self.shares(weighting);
        let mut below = vec![0.0];
        let mut sum = 0.0;
        for share in &shares {
            sum += share;
            below.push(sum.min(1.0));
        }
        // The sum of shares is 1 up to round-off.
        below[shares.len()] = 1.0;
        below
    }

    /// The mean of d^j by number, m^j.
    ///
    /// ```
    /// use mercury_common::sizes::{ClassModel, Classes, Weighting};
    /// // All sizes from 1 to 3 m equally often: the mean of d^3 is (3^4 - 1^4) / (4 (3 - 1)) = 10.
    /// let classes = Classes::new(&[1.0, 3.0], &[1.0], Weighting::Volume, ClassModel::default())?;
    /// assert_eq!(classes.moment(3), 10.0);
    /// # Ok::<(), mercury_common::sizes::ClassProblem>(())
    /// ```
    #[must_use]
    pub fn moment(&self, j: i32) -> f64 {
        let scale = self.edges[self.edges.len() - 1];
        self.parts(j, scale).sum::<f64>() * whole_power(scale, j)
    }

    /// Number share times the mean of (d / scale)^j, class by class.
    fn parts(&self, j: i32, scale: f64) -> impl Iterator<Item = f64> {
        let s = self.model.exponent();
        self.edges
            .windows(2)
            .zip(&self.numbers)
            .map(move |(class, number)| {
                let (a, b) = (class[0] / scale, class[1] / scale);
                if *number == 0.0 {
                    return 0.0;
                }
                number * power_mean(a, b, s + j) / power_mean(a, b, s)
            })
    }

    /// Part between two diameters; classes are divided where the diameters fall.
    ///
    /// # Errors
    /// [`ClassProblem::Empty`] when nothing does.
    pub fn between(&self, low: f64, high: f64) -> Result<Self, ClassProblem> {
        let s = self.model.exponent();
        let mut edges = Vec::new();
        let mut numbers = Vec::new();
        for (class, number) in self.edges.windows(2).zip(&self.numbers) {
            let (a, b) = (class[0].max(low), class[1].min(high));
            if a >= b {
                continue;
            }
            let part =
                power_share(class[0], class[1], s, b) - power_share(class[0], class[1], s, a);
            if edges.is_empty() {
                edges.push(a);
            }
            edges.push(b);
            numbers.push(number * part);
        }
        if edges.is_empty() {
            return Err(ClassProblem::Empty);
        }
        Self::new(&edges, &numbers, Weighting::Number, self.model)
    }

    /// Classes with these numbers of particles between other diameters.
    ///
    /// # Errors
    /// [`ClassProblem::Edge`] where the map does not keep the order of diameters or makes them negative.
    pub fn moved(&self, map: impl Fn(f64) -> f64) -> Result<Self, ClassProblem> {
        let edges: Vec<f64> = self.edges.iter().map(|&edge| map(edge)).collect();
        Self::new(&edges, &self.numbers, Weighting::Number, self.model)
    }

    /// Ready to evaluate in one weighting.
    pub(super) fn by(&self, weighting: Weighting) -> WeightedClasses {
        WeightedClasses {
            edges: self.edges.clone(),
            cumulative: self.cumulative(weighting),
            power: self.model.exponent() + i32::from(weighting.power()),
        }
    }
}

/// Classes in one weighting.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct WeightedClasses {
    edges: Vec<f64>,
    cumulative: Vec<f64>,
    /// The density inside a class goes with d to this power.
    power: i32,
}

impl WeightedClasses {
    pub(super) fn cdf(&self, diameter: f64) -> f64 {
        let above = self.edges.partition_point(|&edge| edge <= diameter);
        if above == 0 {
            return 0.0;
        }
        if above == self.edges.len() {
            return 1.0;
        }
        let (a, b) = (self.edges[above - 1], self.edges[above]);
        let (low, high) = (self.cumulative[above - 1], self.cumulative[above]);
        low + (high - low) * power_share(a, b, self.power, diameter)
    }

    pub(super) fn quantile(&self, u: f64) -> f64 {
        // The first edge with at least u below it ends the class; so a gap is left at its lower end.
        let above = self
            .cumulative
            .partition_point(|&share| share < u)
            .clamp(1, self.edges.len() - 1);
        let (a, b) = (self.edges[above - 1], self.edges[above]);
        let (low, high) = (self.cumulative[above - 1], self.cumulative[above]);
        if high <= low {
            return a;
        }
        power_quantile(a, b, self.power, ((u - low) / (high - low)).clamp(0.0, 1.0))
    }

    pub(super) fn density(&self, diameter: f64) -> f64 {
        let above = self.edges.partition_point(|&edge| edge <= diameter);
        if above == 0 || above == self.edges.len() {
            return 0.0;
        }
        let (a, b) = (self.edges[above - 1], self.edges[above]);
        let share = self.cumulative[above] - self.cumulative[above - 1];
        if share == 0.0 {
            return 0.0;
        }
        // In units of b, so that powers stay in range.
        let relative = whole_power(diameter / b, self.power) / power_mean(a / b, 1.0, self.power);
        share * relative / (b - a)
    }
}

#[cfg(test)]
mod tests;
