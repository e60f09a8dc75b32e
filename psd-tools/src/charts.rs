//! Distributions, samples, fits and checks as charts.

mod checked;

use mercury_common::sizes::Weighting;
use mercury_pictures::charts::{Axis, Chart, ChartPage, Hue, Place, Series};

use crate::check::TwoSamples;
use crate::fit::{Data, Fitted};
use crate::input::{Sizes, Source};
use crate::sample::Sample;
use crate::statistics::Spectrum as _;
use mercury_common::sizes::SizeDistribution;

pub use checked::checked;

/// Points of a curve, and steps of a sample that are drawn: more than a printer resolves.
const POINTS: usize = 400;
const MOST_STEPS: usize = 2000;
/// Ends of axes that cannot show 0 and 1.
const LEAST_SHARE: f64 = 1e-3;
/// Nor less than this, whatever was measured.
const LEAST_OF_ALL: f64 = 1e-6;
/// The share of a law's tail that is not shown.
const TAIL: f64 = 1e-5;
/// Left beside the outermost diameters, of their range.
const MARGIN: f64 = 0.03;

/// The axis of cumulative shares.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Shares {
    /// Even.
    #[default]
    Linear,
    /// A normal law is straight, over ln d a lognormal one.
    Probability,
    /// A Rosin-Rammler law is straight over ln d.
    RosinRammler,
}

/// How curves are shown.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Look {
    /// Diameters by their logarithm.
    pub log: bool,
    /// The cumulative axis.
    pub shares: Shares,
}

impl Look {
    /// The axis of all panels of a page that show diameters in [low, high], so that they stand above each other.
    fn diameters(self, [low, high]: [f64; 2]) -> Axis {
        let low = self.low(low, high);
        let name = "diameter";
        match (self.log, low < high) {
            (true, true) => {
                let margin = libm::exp(MARGIN * libm::log(high / low));
                Axis::log(name, "m").within(low / margin, high * margin)
            }
            (false, true) => {
                let margin = MARGIN * (high - low);
                // No diameter is below 0.
                Axis::linear(name, "m").within((low - margin).max(0.0), high + margin)
            }
            // One size: as the curves need it.
            (true, false) => Axis::log(name, "m"),
            (false, false) => Axis::linear(name, "m"),
        }
    }

    fn cumulative(self, weighting: Weighting) -> Axis {
        self.cumulative_within(weighting, [LEAST_SHARE, 1.0 - LEAST_SHARE])
    }

    /// Axis of cumulative shares that reaches at least from `low` to `high` where it cannot show 0 and 1.
    fn cumulative_within(self, weighting: Weighting, [low, high]: [f64; 2]) -> Axis {
        let name = format!("share by {} below", weighting.word());
        let low = low.clamp(LEAST_OF_ALL, LEAST_SHARE);
        let high = high.clamp(1.0 - LEAST_SHARE, 1.0 - LEAST_OF_ALL);
        match self.shares {
            Shares::Linear => Axis::linear(&name, "").within(0.0, 1.0),
            Shares::Probability => Axis::probability(&name).within(low, high),
            Shares::RosinRammler => Axis::rosin_rammler(&name).within(low, high),
        }
    }

    /// Points spread evenly along the axis of diameters.
    fn grid(self, low: f64, high: f64) -> Vec<f64> {
        let share = |i: usize| i as f64 / POINTS as f64;
        (0..=POINTS)
            .map(|i| {
                if self.log {
                    low * libm::exp(libm::log(high / low) * share(i))
                } else {
                    low + (high - low) * share(i)
                }
            })
            .collect()
    }

    /// Where a curve begins: a class that reaches to 0 has no place on a logarithmic axis.
    fn low(self, low: f64, high: f64) -> f64 {
        if self.log && low <= 0.0 {
            1e-3 * high
        } else {
            low
        }
    }
}

/// Smallest and largest diameter that show a distribution, m: the tails of a law go on where nothing is to be seen of it.
fn shown(source: &Source, weighting: Weighting) -> [f64; 2] {
    match &source.sizes {
        Sizes::Distribution(sizes, _) if sizes.classes().is_none() && !sizes.has_single_sizes() => {
            let view = sizes.by(weighting);
            [TAIL, 1.0 - TAIL].map(|share| view.quantile(share))
        }
        other => other.range(),
    }
}

fn curve(sizes: &SizeDistribution, weighting: Weighting, look: Look) -> Vec<(f64, f64)> {
    curve_within(sizes, weighting, look, [sizes.smallest(), sizes.largest()])
}

fn curve_within(
    sizes: &SizeDistribution,
    weighting: Weighting,
    look: Look,
    [low, high]: [f64; 2],
) -> Vec<(f64, f64)> {
    let view = sizes.by(weighting);
    let low = look.low(low, high);
    if low >= high {
        // One size: a step.
        return [(0.999, 0.0), (1.0, 0.0), (1.0, 1.0), (1.001, 1.0)]
            .map(|(relative, share)| (relative * high, share))
            .into();
    }
    let mut at = look.grid(low, high);
    if let Some(classes) = sizes.classes() {
        at.extend(classes.edges().iter().filter(|&&edge| edge >= low));
        at.sort_by(f64::total_cmp);
    }
    at.iter().map(|&d| (d, view.cdf(d))).collect()
}

/// The ranks at which a sample is drawn, with their shares.
fn ranks(sample: &Sample) -> Vec<usize> {
    let n = sample.len();
    let every = n.div_ceil(MOST_STEPS);
    let mut ranks: Vec<usize> = (0..n).step_by(every).collect();
    if ranks.last() != Some(&(n - 1)) {
        ranks.push(n - 1);
    }
    ranks
}

fn share_at(sample: &Sample, weighting: Weighting, rank: usize) -> f64 {
    match weighting {
        Weighting::Number => (rank + 1) as f64 / sample.len() as f64,
        Weighting::Volume => sample.volume_share(rank + 1),
        _ => sample.cdf(weighting, sample.diameters()[rank]),
    }
}

fn steps(sample: &Sample, weighting: Weighting) -> Vec<(f64, f64)> {
    let mut points = vec![(sample.smallest(), 0.0)];
    let at = |&rank: &usize| (sample.diameters()[rank], share_at(sample, weighting, rank));
    points.extend(ranks(sample).iter().map(at));
    points
}

fn cumulative_series(source: &Source, weighting: Weighting, look: Look) -> Series {
    match &source.sizes {
        Sizes::Distribution(sizes, _) => {
            let curve = curve_within(sizes, weighting, look, shown(source, weighting));
            Series::line(&source.name, curve)
        }
        Sizes::Sample(sample) => Series::steps(&source.name, steps(sample, weighting)),
    }
}

/// Cumulative curves of distributions and samples, and their densities per ln d below.
#[must_use]
pub fn curves(title: &str, sources: &[Source], weighting: Weighting, look: Look) -> ChartPage {
    let range = range_of(sources.iter().map(|source| shown(source, weighting)));
    let mut cumulative = Chart::new("", look.diameters(range), look.cumulative(weighting));
    let density_axis = Axis::linear(&format!("density by {} per ln d", weighting.word()), "");
    let mut density = Chart::new("", look.diameters(range), density_axis);
    for source in sources {
        cumulative = cumulative.with(cumulative_series(source, weighting, look));
        density = density.with(density_series(source, weighting, look));
    }
    let page = ChartPage::new(title, 1, vec![cumulative, density]);
    ChartPage {
        shared_legend: true,
        ..page
    }
}

/// From the smallest to the largest diameter, m.
fn range_of(ranges: impl Iterator<Item = [f64; 2]>) -> [f64; 2] {
    ranges.fold([f64::INFINITY, 0.0], |[low, high], [a, b]| {
        [low.min(a), high.max(b)]
    })
}

fn density_series(source: &Source, weighting: Weighting, look: Look) -> Series {
    let points = match &source.sizes {
        Sizes::Distribution(sizes, _) => {
            let view = sizes.by(weighting);
            let [low, high] = shown(source, weighting);
            let low = look.low(low, high);
            let mut at = look.grid(low, high);
            if let Some(classes) = sizes.classes() {
                // Either side of every edge, where the density jumps.
                let edges = classes.edges().iter().filter(|&&edge| edge > low);
                at.extend(edges.flat_map(|edge| [edge * (1.0 - 1e-9), *edge]));
                at.sort_by(f64::total_cmp);
            }
            let density = |d: f64| match view.density(d) * d {
                density if density.is_finite() => density,
                _ => f64::NAN,
            };
            let mut points = vec![(low, 0.0)];
            points.extend(at.iter().filter(|&&d| d < high).map(|&d| (d, density(d))));
            points.push((high, 0.0));
            points
        }
        Sizes::Sample(sample) => {
            // Some twenty particles in each class, at most a hundred classes.
            let [low, high] = source.sizes.range();
            let count = (sample.len() / 20).clamp(5, 100);
            let step = libm::log(high / low) / count as f64;
            let edge = |i: usize| low * libm::exp(step * i as f64);
            let mut points = vec![(low, 0.0)];
            let mut below = 0.0;
            for i in 0..count {
                let up_to = if i + 1 == count {
                    1.0
                } else {
                    sample.cdf(weighting, edge(i + 1))
                };
                let density = if step > 0.0 {
                    (up_to - below) / step
                } else {
                    f64::NAN
                };
                points.extend([(edge(i), density), (edge(i + 1), density)]);
                below = up_to;
            }
            points.push((high, 0.0));
            points
        }
    };
    Series::line(&source.name, points)
}

/// Two samples: cumulative numbers and volumes.
#[must_use]
pub fn two_samples(
    title: &str,
    names: [&str; 2],
    samples: [&Sample; 2],
    result: &TwoSamples,
    look: Look,
) -> ChartPage {
    let range = range_of(samples.iter().map(|s| [s.smallest(), s.largest()]));
    let charts = [Weighting::Number, Weighting::Volume]
        .map(|weighting| {
            let mut chart = Chart::new("", look.diameters(range), look.cumulative(weighting));
            for (name, sample) in names.iter().zip(samples) {
                chart = chart.with(Series::steps(name, steps(sample, weighting)));
            }
            match weighting {
                Weighting::Number => chart.note(
                    &format!("Kolmogorov-Smirnov p = {:.3}", result.kolmogorov.p),
                    Place::LowerRight,
                ),
                _ => chart,
            }
        })
        .to_vec();
    ChartPage {
        // Names of runs and places are long.
        shared_legend: true,
        ..ChartPage::new(title, 2, charts)
    }
}

/// Fitted laws over the data, and what they leave.
#[must_use]
pub fn fitted(title: &str, source: &Source, data: &Data, fits: &[Fitted], look: Look) -> ChartPage {
    let weighting = data.weighting();
    let mut shown = [LEAST_SHARE, 1.0 - LEAST_SHARE];
    let points = match &source.sizes {
        Sizes::Distribution(sizes, table) => {
            let classes = sizes.classes();
            let edges = table
                .as_ref()
                .map(|t| &t.edges[..])
                .or(classes.map(|c| c.edges()));
            let view = sizes.by(weighting);
            let edges = edges.unwrap_or_default().iter();
            let points: Vec<(f64, f64)> = edges.map(|&d| (d, view.cdf(d))).collect();
            for &(_, share) in points.iter().filter(|(_, share)| {
                // 0 and 1 but for round-off.
                *share > LEAST_OF_ALL && *share < 1.0 - LEAST_OF_ALL
            }) {
                // With some air about them.
                shown[0] = shown[0].min(0.5 * share);
                shown[1] = shown[1].max(0.5 * (1.0 + share));
            }
            Series::points("measured", points)
        }
        Sizes::Sample(sample) => Series::steps("measured", steps(sample, weighting)),
    };
    let [low, high] = source.sizes.range();
    let axis = look.cumulative_within(weighting, shown);
    let mut cumulative =
        Chart::new("", look.diameters([low, high]), axis).with(points.hue(Hue::Ink));
    if look.shares != Shares::Linear {
        cumulative = cumulative.note("0 and 100 % have no place on this axis", Place::LowerRight);
    }
    let is_classes = matches!(source.sizes, Sizes::Distribution(..)) || data.gathered().is_some();
    let residual = if is_classes {
        "residual of class, in st.dev."
    } else {
        "(measured - law) root N"
    };
    let axis = Axis::linear(residual, "");
    let mut residuals = Chart::new("", look.diameters([low, high]), axis);
    let grid = look.grid(look.low(low, high), high);
    for fit in fits {
        let name = fit.family.word();
        let curve = grid.iter().map(|&d| (d, fit.cdf(d))).collect();
        cumulative = cumulative.with(Series::line(name, curve));
        let points = fit
            .residuals
            .iter()
            .map(|r| (0.5 * (r.low + r.high), r.value))
            .collect();
        residuals = residuals.with(if is_classes {
            Series::marked_line(name, points)
        } else {
            Series::line(name, points)
        });
    }
    residuals = residuals.with(Series::level("", 0.0));
    ChartPage::new(title, 1, vec![cumulative, residuals])
}
