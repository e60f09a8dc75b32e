//! Measured data: sizes one by one, or shares of classes; and how likely a law makes them.

use mercury_common::sizes::Weighting;
use mercury_common::sizes::table::SizeTable;

use super::family::{Family, Law, Part, Shape};
use super::minimise::Minimum;
use super::{Residual, bootstrap};
use crate::check::anderson_darling;
use crate::sample::Sample;

/// Samples larger than this are fitted by classes, narrow enough that no estimate changes visibly.
pub(super) const MOST_SINGLE_SIZES: usize = 50_000;
const FINE_CLASSES: usize = 4096;
/// Widths of components below this part of that of all data are a peak on a single particle, no component.
const LEAST_WIDTH: f64 = 1e-3;

/// Why data determine no law.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DataError {
    /// Fewer classes or sizes than parameters need.
    #[error("{have} do not determine the {} parameters of {}", .family.parameters(), .family.word())]
    TooFew {
        /// Data that there are.
        have: String,
        /// The family.
        family: Family,
    },
    /// All particles have one size.
    #[error("all particles have one size: nothing to fit")]
    OneSize,
    /// The number that the shares stand for is none.
    #[error("the number of particles must be at least 1, got {0}")]
    Number(f64),
    /// The likelihood grows without bound as a component of a mixture closes in on a few particles (Day 1969, Biometrika 56, 463), and
    /// has no maximum elsewhere.
    #[error("{} is not determined by {number} particles: the likelihood grows without bound as one part of it closes in on a few of them", .family.word())]
    Unbounded {
        /// Number of particles.
        number: f64,
        /// The family.
        family: Family,
    },
    /// The search found nothing.
    #[error("no parameters of {} make the data possible", .0.word())]
    NoFit(Family),
}

/// A measurement to fit.
#[derive(Debug, Clone)]
pub struct Data {
    kind: Kind,
    /// Diameters are in units of this, m.
    unit: f64,
    weighting: Weighting,
    /// Mean and standard deviation of ln d.
    logs: [f64; 2],
    /// Number of classes into which single sizes were gathered.
    gathered: Option<usize>,
}

#[derive(Debug, Clone)]
pub(super) enum Kind {
    /// Sizes, ascending.
    Sizes(Vec<f64>),
    /// Classes from 0 to infinity, the first and the last empty, with how many particles are in each.
    Classes { edges: Vec<f64>, counts: Vec<f64> },
}

fn mean_and_deviation(values: impl Iterator<Item = (f64, f64)> + Clone) -> [f64; 2] {
    let total: f64 = values.clone().map(|(_, weight)| weight).sum();
    let mean = values.clone().map(|(x, weight)| weight * x).sum::<f64>() / total;
    let square = |(x, weight): (f64, f64)| weight * (x - mean) * (x - mean);
    [mean, (values.map(square).sum::<f64>() / total).sqrt()]
}

impl Data {
    /// Particles one by one, counted by number.
    ///
    /// # Errors
    /// [`DataError::OneSize`].
    pub fn from_sample(sample: &Sample) -> Result<Self, DataError> {
        let unit = sample.quantile(Weighting::Number, 0.5);
        if sample.smallest() == sample.largest() {
            return Err(DataError::OneSize);
        }
        let sizes: Vec<f64> = sample.diameters().iter().map(|d| d / unit).collect();
        if sizes.len() <= MOST_SINGLE_SIZES {
            return Ok(Self::new(Kind::Sizes(sizes), unit, Weighting::Number, None));
        }
        let (low, high) = (sizes[0] * 0.999_999, sizes[sizes.len() - 1] * 1.000_001);
        let step = libm::log(high / low) / FINE_CLASSES as f64;
        let inner = (0..=FINE_CLASSES).map(|i| low * libm::exp(step * i as f64));
        let edges: Vec<f64> = std::iter::once(0.0)
            .chain(inner)
            .chain([f64::INFINITY])
            .collect();
        let below: Vec<usize> = edges
            .iter()
            .map(|&e| sizes.partition_point(|&d| d <= e))
            .collect();
        let counts = below
            .windows(2)
            .map(|pair| (pair[1] - pair[0]) as f64)
            .collect();
        let kind = Kind::Classes { edges, counts };
        Ok(Self::new(kind, unit, Weighting::Number, Some(FINE_CLASSES)))
    }

    /// Shares of classes. `number`: how many particles they stand for.
    ///
    /// # Errors
    /// [`DataError::Number`].
    pub fn from_table(table: &SizeTable, number: f64) -> Result<Self, DataError> {
        if !(number >= 1.0 && number.is_finite()) {
            return Err(DataError::Number(number));
        }
        let classes = &table.edges;
        let unit = classes[classes.len() / 2];
        let first = usize::from(classes[0] == 0.0);
        let inner = classes[first..].iter().map(|d| d / unit);
        let edges = std::iter::once(0.0)
            .chain(inner)
            .chain([f64::INFINITY])
            .collect();
        let mut counts: Vec<f64> = table.shares.iter().map(|share| number * share).collect();
        if first == 0 {
            counts.insert(0, 0.0);
        }
        counts.push(0.0);
        let kind = Kind::Classes { edges, counts };
        Ok(Self::new(kind, unit, table.weighting, None))
    }

    fn new(kind: Kind, unit: f64, weighting: Weighting, gathered: Option<usize>) -> Self {
        let mut data = Self {
            kind,
            unit,
            weighting,
            logs: [0.0; 2],
            gathered,
        };
        let points = data.points();
        data.logs = mean_and_deviation(points.iter().map(|(d, weight)| (libm::log(*d), *weight)));
        data
    }

    /// This measurement with an estimated number of particles: the number that makes the best of these families just probable,
    /// its chi-square equal to its degrees of freedom. For shares of an unknown number of particles.
    ///
    /// # Errors
    /// As [`super::fit`], if no family fits.
    pub fn with_estimated_number(&self, families: &[Family]) -> Result<Self, DataError> {
        let mut best: Option<f64> = None;
        let mut last = DataError::OneSize;
        for &family in families {
            let found = self
                .check(family)
                .and_then(|()| super::search(self, family));
            match found {
                Ok(minimum) => {
                    let number = self.number_of(&Law::of(family, &minimum.at), family);
                    best = Some(best.map_or(number, |best| best.max(number)));
                }
                Err(error) => last = error,
            }
        }
        Ok(self.rescaled(best.ok_or(last)?))
    }

    /// The number at which the law's chi-square is its degrees of freedom.
    fn number_of(&self, law: &Law, family: Family) -> f64 {
        let Kind::Classes { edges, counts } = &self.kind else {
            return self.number();
        };
        let number = self.number();
        let mut misfit = 0.0;
        let mut classes = 0;
        for (class, count) in edges.windows(2).zip(counts) {
            let expected = law.share(class[0], class[1]);
            // Classes where a tenth of a per cent is not expected depend more on the ends than on the middle.
            if expected > 1e-3 {
                misfit += (count / number - expected).powi(2) / expected;
                classes += 1;
            }
        }
        let degrees = (classes as f64 - 1.0 - family.parameters() as f64).max(1.0);
        (degrees / misfit).clamp(10.0, 1e9)
    }

    fn rescaled(&self, number: f64) -> Self {
        let mut data = self.clone();
        let factor = number / self.number();
        if let Kind::Classes { counts, .. } = &mut data.kind {
            for count in counts {
                *count *= factor;
            }
        }
        data
    }

    /// Number of particles in the likelihood.
    #[must_use]
    pub fn number(&self) -> f64 {
        match &self.kind {
            Kind::Sizes(sizes) => sizes.len() as f64,
            Kind::Classes { counts, .. } => counts.iter().sum(),
        }
    }

    /// Number of classes into which single sizes were gathered, as there are so many.
    #[must_use]
    pub fn gathered(&self) -> Option<usize> {
        self.gathered
    }

    /// Quantity that was measured.
    #[must_use]
    pub fn weighting(&self) -> Weighting {
        self.weighting
    }

    pub(super) fn unit(&self) -> f64 {
        self.unit
    }

    pub(super) fn kind(&self) -> &Kind {
        &self.kind
    }

    pub(super) fn with_kind(&self, kind: Kind) -> Self {
        Self::new(kind, self.unit, self.weighting, self.gathered)
    }

    /// Sizes with their weights; a class at its middle.
    fn points(&self) -> Vec<(f64, f64)> {
        match &self.kind {
            Kind::Sizes(sizes) => sizes.iter().map(|&d| (d, 1.0)).collect(),
            Kind::Classes { edges, counts } => edges
                .windows(2)
                .zip(counts)
                .filter(|(_, count)| **count > 0.0)
                .map(|(class, count)| {
                    // Drawn samples may have particles beyond the ends.
                    let high = if class[1].is_finite() {
                        class[1]
                    } else {
                        1.2 * class[0]
                    };
                    (0.5 * (class[0] + high), *count)
                })
                .collect(),
        }
    }

    pub(super) fn check(&self, family: Family) -> Result<(), DataError> {
        let filled = self.points().len();
        let (have, enough) = match &self.kind {
            Kind::Sizes(sizes) => (
                format!("{} particles", sizes.len()),
                filled > family.parameters(),
            ),
            Kind::Classes { counts, .. } => {
                let classes = format!("{filled} classes with particles");
                // The empty ends count, as the law may reach there; the total is known.
                (
                    classes,
                    filled > 1 && counts.len() > family.parameters() + 1,
                )
            }
        };
        if !enough {
            return Err(DataError::TooFew { have, family });
        }
        Ok(())
    }

    /// Parameters of a single law from mean and deviation of ln d.
    fn start(shape: Shape, points: &[(f64, f64)]) -> Vec<f64> {
        let logs = |&(d, weight): &(f64, f64)| (libm::log(d), weight);
        let [mean_log, log_width] = mean_and_deviation(points.iter().map(logs));
        let log_width = log_width.max(1e-3);
        match shape {
            Shape::Lognormal => vec![mean_log, libm::log(log_width)],
            Shape::Normal => {
                let [mean, width] = mean_and_deviation(points.iter().copied());
                vec![mean, libm::log(width.max(1e-3 * mean))]
            }
            Shape::RosinRammler => {
                // ln d of a Weibull law: deviation pi/sqrt(6)/n, mean ln d63 - gamma/n.
                let n = 1.282_549_83 / log_width;
                vec![mean_log + 0.577_215_66 / n, libm::log(n)]
            }
            Shape::Ggs => {
                let last = points.iter().fold(0.0, |last: f64, (d, _)| last.max(*d));
                // ln(max/d) is exponential with mean 1/n.
                let ln_max = libm::log(1.05 * last);
                vec![ln_max, -libm::log((ln_max - mean_log).max(1e-3))]
            }
        }
    }

    /// Where searches begin.
    pub(super) fn starts(&self, family: Family) -> Vec<Vec<f64>> {
        let points = self.points();
        if family.components == 1 {
            return vec![Self::start(family.shape, &points)];
        }
        let total: f64 = points.iter().map(|(_, weight)| weight).sum();
        let mut starts = Vec::new();
        for split in [0.2, 0.4, 0.6, 0.8] {
            let mut sum = 0.0;
            let reaches = |&(_, weight): &(f64, f64)| {
                sum += weight;
                sum >= split * total
            };
            let at = points
                .iter()
                .position(reaches)
                .unwrap_or(0)
                .clamp(1, points.len() - 1);
            let mut start = vec![libm::log(split / (1.0 - split))];
            start.extend(Self::start(family.shape, &points[..at]));
            start.extend(Self::start(family.shape, &points[at..]));
            starts.push(start);
        }
        starts
    }

    /// -ln L up to what depends on the data alone.
    pub(super) fn minus_log_likelihood(&self, family: Family, theta: &[f64]) -> f64 {
        let law = Law::of(family, theta);
        if law.parts.len() > 1 && law.parts.iter().any(|(_, part)| self.is_spike(part)) {
            return f64::INFINITY;
        }
        let sum: f64 = match &self.kind {
            Kind::Sizes(sizes) => sizes.iter().map(|&d| law.ln_density(d)).sum(),
            Kind::Classes { edges, counts } => edges
                .windows(2)
                .zip(counts)
                .filter(|(_, count)| **count > 0.0)
                .map(|(class, count)| count * libm::log(law.share(class[0], class[1])))
                .sum(),
        };
        if sum.is_nan() { f64::INFINITY } else { -sum }
    }

    /// A component so narrow that it sits on a single particle, where the likelihood has no bound.
    fn is_spike(&self, part: &Part) -> bool {
        let [place, width] = part.values();
        let log_width = match part.shape {
            Shape::Lognormal => width,
            Shape::Normal => width / place.abs(),
            Shape::RosinRammler | Shape::Ggs => 1.28 / width,
        };
        log_width < LEAST_WIDTH * self.logs[1]
    }

    /// Estimates that need no search.
    pub(super) fn closed_form(&self, family: Family) -> Option<Minimum> {
        let Kind::Sizes(sizes) = &self.kind else {
            return None;
        };
        let at = match (family.shape, family.components) {
            (Shape::Lognormal, 1) => vec![self.logs[0], libm::log(self.logs[1])],
            (Shape::Normal, 1) => {
                let [mean, width] = mean_and_deviation(sizes.iter().map(|&d| (d, 1.0)));
                // Nearer to 0 the part of the law that is cut off there matters.
                if mean < 8.5 * width {
                    return None;
                }
                vec![mean, libm::log(width)]
            }
            (Shape::Ggs, 1) => {
                let ln_max = libm::log(sizes[sizes.len() - 1]);
                vec![ln_max, -libm::log(ln_max - self.logs[0])]
            }
            _ => return None,
        };
        let value = self.minus_log_likelihood(family, &at);
        Some(Minimum { at, value })
    }

    /// Whether a search ended at a maximum, and not where a component of a mixture has closed in on single particles: each has more
    /// particles than parameters, and the likelihood falls to all sides.
    pub(super) fn is_maximum(&self, family: Family, found: &Minimum) -> bool {
        if family.components == 1 || !matches!(self.kind, Kind::Sizes(_)) {
            return true;
        }
        let law = Law::of(family, &found.at);
        let of_each = Family {
            components: 1,
            ..family
        };
        let enough = of_each.parameters() as f64;
        // At a maximum the shares are the mean probabilities with which particles belong to the components.
        let has_enough = |(share, _): &(f64, Part)| share * self.number() > enough;
        let errors = || found.errors(|theta| self.minus_log_likelihood(family, theta));
        law.parts.iter().all(has_enough) && errors().iter().all(Option::is_some)
    }

    /// Whether a parameter is estimated by the end of the data, where the likelihood has a step.
    pub(super) fn is_at_end(&self, family: Family) -> bool {
        matches!(self.kind, Kind::Sizes(_)) && family.shape == Shape::Ggs
    }

    /// Errors of the law whose largest size is the largest of the sample: that of ln n is 1/sqrt(N).
    pub(super) fn end_errors(&self, minimum: &Minimum) -> Vec<Option<f64>> {
        debug_assert_eq!(minimum.at.len(), 2);
        vec![None, Some(1.0 / self.number().sqrt())]
    }

    /// A^2 for sizes, the deviance 2 sum c ln(c / (N p)) for classes.
    pub(super) fn distance(&self, law: &Law) -> f64 {
        match &self.kind {
            Kind::Sizes(sizes) => {
                let edge = 0.5_f64.powi(53);
                let shares: Vec<f64> = sizes
                    .iter()
                    .map(|&d| law.cdf(d).clamp(edge, 1.0 - edge))
                    .collect();
                anderson_darling(&shares)
            }
            Kind::Classes { edges, counts } => {
                let number = self.number();
                edges
                    .windows(2)
                    .zip(counts)
                    .filter(|(_, count)| **count > 0.0)
                    .map(|(class, count)| {
                        let expected = number * law.share(class[0], class[1]);
                        2.0 * count * libm::log(count / expected)
                    })
                    .sum()
            }
        }
    }

    /// Residuals against a law in m.
    pub(super) fn residuals(&self, law: &Law) -> Vec<Residual> {
        let unit = self.unit;
        match &self.kind {
            Kind::Sizes(sizes) => {
                let n = sizes.len() as f64;
                // A thousand are enough for the eye.
                let every = sizes.len().div_ceil(1000);
                let residual = |(i, &d): (usize, &f64)| Residual {
                    low: unit * d,
                    high: unit * d,
                    value: n.sqrt() * ((i as f64 + 0.5) / n - law.cdf(unit * d)),
                };
                sizes
                    .iter()
                    .enumerate()
                    .step_by(every)
                    .map(residual)
                    .collect()
            }
            Kind::Classes { edges, counts } => {
                let number = self.number();
                let mut residuals = Vec::new();
                for (class, count) in edges.windows(2).zip(counts) {
                    let (low, high) = (unit * class[0], unit * class[1]);
                    if low == 0.0 || high.is_infinite() {
                        continue;
                    }
                    let share = law.share(low, high);
                    residuals.push(Residual {
                        low,
                        high,
                        value: (count - number * share) / (number * share * (1.0 - share)).sqrt(),
                    });
                }
                residuals
            }
        }
    }

    /// Data of the same kind and number, drawn from a law (in units of these data).
    pub(super) fn drawn(&self, law: &Law, stream: &mut mercury_common::random::Stream) -> Self {
        bootstrap::drawn(self, law, stream)
    }
}
