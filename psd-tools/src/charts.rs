//! Distributions, samples, fits and checks as charts.

use mercury_common::sizes::Weighting;
use mercury_pictures::charts::{Axis, Chart, ChartPage, Dash, Hue, Place, Series};

use crate::check::{Goodness, TwoSamples, number_band};
use crate::fit::{Data, Fitted};
use crate::input::{Sizes, Source};
use crate::sample::Sample;
use crate::statistics::Spectrum as _;
use mercury_common::sizes::SizeDistribution;

/// Points of a curve, and steps of a sample that are drawn: more than a printer resolves.
const POINTS: usize = 400;
const MOST_STEPS: usize = 2000;
/// Ends of axes that cannot show 0 and 1.
const LEAST_SHARE: f64 = 1e-3;

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
    fn diameters(self) -> Axis {
        if self.log {
            Axis::log("diameter", "m")
        } else {
            Axis::linear("diameter", "m")
        }
    }

    fn cumulative(self, weighting: Weighting) -> Axis {
        let name = format!("share by {} below", weighting.word());
        match self.shares {
            Shares::Linear => Axis::linear(&name, "").within(0.0, 1.0),
            Shares::Probability => Axis::probability(&name).within(LEAST_SHARE, 1.0 - LEAST_SHARE),
            Shares::RosinRammler => {
                Axis::rosin_rammler(&name).within(LEAST_SHARE, 1.0 - LEAST_SHARE)
            }
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

fn curve(sizes: &SizeDistribution, weighting: Weighting, look: Look) -> Vec<(f64, f64)> {
    let view = sizes.by(weighting);
    let low = look.low(sizes.smallest(), sizes.largest());
    if low >= sizes.largest() {
        // One size: a step.
        let d = sizes.largest();
        return vec![(0.999 * d, 0.0), (d, 0.0), (d, 1.0), (1.001 * d, 1.0)];
    }
    let mut at = look.grid(low, sizes.largest());
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
        Sizes::Distribution(sizes, _) => Series::line(&source.name, curve(sizes, weighting, look)),
        Sizes::Sample(sample) => Series::steps(&source.name, steps(sample, weighting)),
    }
}

/// Cumulative curves of distributions and samples, and their densities per ln d below.
#[must_use]
pub fn curves(title: &str, sources: &[Source], weighting: Weighting, look: Look) -> ChartPage {
    let mut cumulative = Chart::new("", look.diameters(), look.cumulative(weighting));
    let density_axis = Axis::linear(&format!("density by {} per ln d", weighting.word()), "");
    let mut density = Chart::new("", look.diameters(), density_axis);
    for source in sources {
        cumulative = cumulative.with(cumulative_series(source, weighting, look));
        density = density.with(density_series(source, weighting, look));
    }
    let page = ChartPage::new(title, 1, vec![cumulative, density]);
    ChartPage {
        shared_legend: sources.len() > 1,
        ..page
    }
}

fn density_series(source: &Source, weighting: Weighting, look: Look) -> Series {
    let points = match &source.sizes {
        Sizes::Distribution(sizes, _) => {
            let view = sizes.by(weighting);
            let low = look.low(sizes.smallest(), sizes.largest());
            let mut at = look.grid(low, sizes.largest());
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
            points.extend(
                at.iter()
                    .filter(|&&d| d < sizes.largest())
                    .map(|&d| (d, density(d))),
            );
            points.push((sizes.largest(), 0.0));
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

/// A sample against its target: cumulative numbers and volumes with their bands, their differences, and the residuals of classes.
#[must_use]
pub fn checked(
    title: &str,
    sample: &Sample,
    target: &SizeDistribution,
    goodness: &Goodness,
    level: f64,
    look: Look,
) -> ChartPage {
    let number = number_band(sample.len(), level);
    let volume = goodness.volume_band.half_width;
    let confidence = format!("{} % band", 100.0 * (1.0 - level));
    let mut charts = Vec::new();
    for (weighting, band) in [(Weighting::Number, number), (Weighting::Volume, volume)] {
        let ranks = ranks(sample);
        let at = |side: f64| {
            ranks
                .iter()
                .map(|&rank| {
                    let share = share_at(sample, weighting, rank) + side * band;
                    (sample.diameters()[rank], share.clamp(0.0, 1.0))
                })
                .collect::<Vec<_>>()
        };
        let chart = Chart::new("", look.diameters(), look.cumulative(weighting))
            .with(Series::steps("sample", steps(sample, weighting)))
            .with(Series::band(&confidence, at(-1.0), at(1.0)))
            .with(
                Series::line("target", curve(target, weighting, look))
                    .hue(Hue::Ink)
                    .dash(Dash::Dashed),
            );
        charts.push(chart);
    }
    for (weighting, band) in [(Weighting::Number, number), (Weighting::Volume, volume)] {
        let view = target.by(weighting);
        let points = ranks(sample)
            .iter()
            .map(|&rank| {
                let d = sample.diameters()[rank];
                // In the middle of its step.
                let before = if rank == 0 {
                    0.0
                } else {
                    share_at(sample, weighting, rank - 1)
                };
                (
                    d,
                    0.5 * (before + share_at(sample, weighting, rank)) - view.cdf(d),
                )
            })
            .collect();
        let axis = Axis::linear(&format!("sample - target by {}", weighting.word()), "");
        let ends = [sample.smallest(), sample.largest()];
        let chart = Chart::new("", look.diameters(), axis)
            .with(Series::line("", points))
            .with(Series::band(
                "",
                ends.map(|d| (d, -band)).to_vec(),
                ends.map(|d| (d, band)).to_vec(),
            ))
            .with(Series::level("", 0.0));
        charts.push(chart);
    }
    if let Some(chi) = &goodness.chi_square {
        let mut edges: Vec<f64> = chi.classes.iter().map(|class| class.low).collect();
        edges.extend(chi.classes.last().map(|class| class.high));
        let heights: Vec<f64> = chi
            .classes
            .iter()
            .map(|class| class.residual(goodness.number))
            .collect();
        let rising =
            edges.windows(2).all(|pair| pair[0] < pair[1]) && (!look.log || edges[0] > 0.0);
        if rising {
            let axis = Axis::linear("residual of class, in st.dev.", "");
            let chart = Chart::new("", look.diameters(), axis)
                .with(Series::bars("", edges, heights))
                .with(Series::level("", 2.0))
                .with(Series::level("", -2.0));
            charts.push(chart);
            charts.push(quantiles(sample, target));
        }
    }
    ChartPage::new(title, 2, charts)
}

/// Quantiles of sample and target against each other: on the diagonal if they agree.
fn quantiles(sample: &Sample, target: &SizeDistribution) -> Chart {
    let n = sample.len() as f64;
    let view = target.by(Weighting::Number);
    let points: Vec<(f64, f64)> = ranks(sample)
        .iter()
        .map(|&rank| {
            (
                view.quantile((rank as f64 + 0.5) / n),
                sample.diameters()[rank],
            )
        })
        .collect();
    let ends = vec![
        (target.smallest(), target.smallest()),
        (target.largest(), target.largest()),
    ];
    Chart::new(
        "",
        Axis::linear("target's quantile", "m"),
        Axis::linear("sample's quantile", "m"),
    )
    .with(Series::line("particles", points))
    .with(
        Series::line("equal", ends)
            .hue(Hue::Grey)
            .dash(Dash::Dashed)
            .width(1.2),
    )
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
    let charts = [Weighting::Number, Weighting::Volume]
        .map(|weighting| {
            let mut chart = Chart::new("", look.diameters(), look.cumulative(weighting));
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
    ChartPage::new(title, 2, charts)
}

/// Fitted laws over the data, and what they leave.
#[must_use]
pub fn fitted(title: &str, source: &Source, data: &Data, fits: &[Fitted], look: Look) -> ChartPage {
    let weighting = data.weighting();
    let points = match &source.sizes {
        Sizes::Distribution(sizes, table) => {
            let classes = sizes.classes();
            let edges = table
                .as_ref()
                .map(|t| &t.edges[..])
                .or(classes.map(|c| c.edges()));
            let view = sizes.by(weighting);
            let edges = edges.unwrap_or_default().iter();
            Series::points("measured", edges.map(|&d| (d, view.cdf(d))).collect())
        }
        Sizes::Sample(sample) => Series::steps("measured", steps(sample, weighting)),
    };
    let mut cumulative =
        Chart::new("", look.diameters(), look.cumulative(weighting)).with(points.hue(Hue::Ink));
    let is_classes = matches!(source.sizes, Sizes::Distribution(..)) || data.gathered().is_some();
    let residual = if is_classes {
        "residual of class"
    } else {
        "(measured - law) root N"
    };
    let mut residuals = Chart::new("", look.diameters(), Axis::linear(residual, ""));
    let [low, high] = source.sizes.range();
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
