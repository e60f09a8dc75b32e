//! A sample against its target.

use mercury_common::readable::rounded;
use mercury_common::sizes::{SizeDistribution, Weighting};
use mercury_pictures::charts::{Axis, Chart, ChartPage, Dash, Hue, Series};

use super::{Look, MARGIN, curve, range_of, ranks, share_at, steps};
use crate::check::{Goodness, number_band};
use crate::sample::Sample;

/// A sample against its target: cumulative numbers and volumes with their bands, and their differences. Those of a quota
/// are far below what chance would leave, and are drawn on their own scale.
#[must_use]
pub fn checked(
    title: &str,
    (sample, is_quota): (&Sample, bool),
    target: &SizeDistribution,
    goodness: &Goodness,
    level: f64,
    look: Look,
) -> ChartPage {
    let number = number_band(sample.len(), level);
    let volume = goodness.volume_band.half_width;
    let confidence = format!("{} % band", rounded(100.0 * (1.0 - level), 6));
    let own = [sample.smallest(), sample.largest()];
    let asked_for = [target.smallest(), target.largest()];
    let range = range_of([own, asked_for].into_iter());
    let ends = [look.low(range[0], range[1]), range[1]];
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
        let chart = Chart::new("", look.diameters(range), look.cumulative(weighting))
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
        let name = format!("sample - target by {}", weighting.word());
        let points = differences(sample, target, weighting, look);
        let promise = match weighting {
            Weighting::Number => "dashed: 1/N; ",
            _ => "",
        };
        let percent = rounded(100.0 * (1.0 - level), 6);
        let spread = format!("{promise}random: \u{b1}{} ({percent} %)", rounded(band, 3));
        let title = if is_quota { &spread } else { "" };
        let mut chart = Chart::new(title, look.diameters(range), Axis::linear(&name, ""))
            .with(Series::line("", points));
        if !is_quota {
            chart = chart.with(Series::band(
                "",
                ends.map(|d| (d, -band)).to_vec(),
                ends.map(|d| (d, band)).to_vec(),
            ));
        } else if weighting == Weighting::Number {
            // Drawing by quotas keeps the deviation within these levels.
            let step = 1.0 / sample.len() as f64;
            chart = chart
                .with(Series::level("", step))
                .with(Series::level("", -step));
        }
        charts.push(chart.with(Series::level("", 0.0)));
    }
    charts.push(quantiles(sample, target));
    ChartPage::new(title, 2, charts)
}

/// Cumulative shares of a sample less those of its target, in the middle of each of its steps; beyond its ends what the target has there.
fn differences(
    sample: &Sample,
    target: &SizeDistribution,
    weighting: Weighting,
    look: Look,
) -> Vec<(f64, f64)> {
    let view = target.by(weighting);
    let (first, last) = (sample.smallest(), sample.largest());
    let beyond = |low: f64, high: f64, share: f64| {
        let grid = match low < high {
            true => look.grid(look.low(low, high), high),
            false => Vec::new(),
        };
        let at = |d: f64| (d, share - view.cdf(d));
        grid.into_iter().map(at).collect::<Vec<_>>()
    };
    let mut points = beyond(target.smallest(), first, 0.0);
    points.extend(ranks(sample).iter().map(|&rank| {
        let d = sample.diameters()[rank];
        let before = match rank {
            0 => 0.0,
            rank => share_at(sample, weighting, rank - 1),
        };
        let middle = 0.5 * (before + share_at(sample, weighting, rank));
        (d, middle - view.cdf(d))
    }));
    points.extend(beyond(last, target.largest(), 1.0));
    points
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
    let [low, high] = range_of(
        [
            [target.smallest(), target.largest()],
            [sample.smallest(), sample.largest()],
        ]
        .into_iter(),
    );
    let ends = vec![(low, low), (high, high)];
    // Both alike, so that the diagonal is one.
    let axis = |name: &str| {
        let axis = Axis::linear(name, "m");
        let margin = MARGIN * (high - low);
        if margin > 0.0 {
            axis.within((low - margin).max(0.0), high + margin)
        } else {
            axis
        }
    };
    Chart::new("", axis("target's quantile"), axis("sample's quantile"))
        .with(Series::line("particles", points))
        .with(
            Series::line("equal", ends)
                .hue(Hue::Grey)
                .dash(Dash::Dashed)
                .width(1.2),
        )
}
