//! The chart of the energies that a run leaves behind.

use crate::charts::{Axis, Chart, ChartPage, Dash, Hue, Legend, Series};

/// The energies of the system at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnergyRow {
    /// Time (s).
    pub time: f64,
    /// Kinetic energy of translation (J).
    pub kinetic: f64,
    /// Kinetic energy of rotation (J).
    pub rotational: f64,
    /// Potential energy in gravity (J), from any level.
    pub gravitational: f64,
    /// Elastic energy stored in contacts (J).
    pub elastic: f64,
    /// Energy dissipated since the start (J), where the run keeps account of it.
    pub dissipated: Option<f64>,
}

/// The energies of a run over time, as charts: every kind that the run has, gravitational energy counted from its lowest in the
/// run, and below the whole kinetic energy on a logarithmic axis. `rows` are in the order of time.
#[must_use]
pub fn energy_page(title: &str, rows: &[EnergyRow]) -> ChartPage {
    let times = || {
        rows.iter()
            .map(|row| row.time)
            .filter(|time| time.is_finite())
    };
    let (first, last) = (
        times().fold(f64::MAX, f64::min),
        times().fold(f64::MIN, f64::max),
    );
    let time = || {
        let axis = Axis::linear("time", "s");
        if first < last {
            axis.within(first, last)
        } else {
            axis
        }
    };
    let mut upper = Chart::new("", time(), Axis::linear("energy", "J")).legend(Legend::Right);
    upper.series = kinds(rows);
    let mut lower = Chart::new("", time(), Axis::log("kinetic energy", "J"));
    let kinetic = |row: &EnergyRow| (row.time, row.kinetic + row.rotational);
    let line = Series::line("", rows.iter().map(kinetic).collect());
    lower.series.push(line.hue(Hue::Blue));
    for chart in [&mut upper, &mut lower] {
        chart.when_empty = "no energies were recorded".into();
    }
    if !rows.is_empty() {
        lower.when_empty = "zero throughout the run".into();
    }
    let page = ChartPage::new(title, 1, vec![upper, lower]);
    ChartPage {
        subtitle: "Energies over time".into(),
        row_shares: vec![3.0, 2.0],
        ..page.size(720.0, 540.0)
    }
}

/// The kinds of energy that the run has: one that is zero throughout is not drawn, except the kinetic one.
fn kinds(rows: &[EnergyRow]) -> Vec<Series> {
    let heights = rows.iter().map(|row| row.gravitational);
    let lowest = heights
        .filter(|energy| energy.is_finite())
        .fold(f64::MAX, f64::min);
    type Pick<'a> = Box<dyn Fn(&EnergyRow) -> f64 + 'a>;
    let all: [(&str, &str, Hue, Dash, Pick); 5] = [
        (
            "kinetic",
            "of translation",
            Hue::Blue,
            Dash::Solid,
            Box::new(|row| row.kinetic),
        ),
        (
            "rotational",
            "kinetic, of rotation",
            Hue::Orange,
            Dash::Dashed,
            Box::new(|row| row.rotational),
        ),
        (
            "gravitational",
            "above its lowest in this run",
            Hue::Green,
            Dash::DashDot,
            Box::new(move |row| row.gravitational - lowest),
        ),
        (
            "elastic",
            "stored in contacts",
            Hue::Purple,
            Dash::Dotted,
            Box::new(|row| row.elastic),
        ),
        (
            "dissipated",
            "since the start",
            Hue::Vermillion,
            Dash::Long,
            Box::new(|row| row.dissipated.unwrap_or(0.0)),
        ),
    ];
    let is_there = |name: &str, pick: &Pick| match name {
        "kinetic" => true,
        "dissipated" => rows.iter().any(|row| row.dissipated.is_some()),
        _ => rows.iter().any(|row| pick(row) != 0.0),
    };
    let all: Vec<_> = all
        .into_iter()
        .filter(|(name, .., pick)| is_there(name, pick))
        .collect();
    let mut series = Vec::new();
    if all.len() > 1 {
        // Thin and first, so that it covers nothing.
        let sum = |row: &EnergyRow| all.iter().map(|(.., pick)| pick(row)).sum::<f64>();
        let total = rows.iter().map(|row| (row.time, sum(row))).collect();
        let total = Series::line("sum", total).hue(Hue::Ink).dash(Dash::Solid);
        series.push(total.width(0.9).about("of those below"));
    }
    series.extend(all.iter().map(|(name, about, hue, dash, pick)| {
        let points = rows.iter().map(|row| (row.time, pick(row))).collect();
        Series::line(name, points)
            .hue(*hue)
            .dash(*dash)
            .about(about)
    }));
    series
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::charts::Shape;

    fn row(time: f64, kinetic: f64, gravitational: f64) -> EnergyRow {
        EnergyRow {
            time,
            kinetic,
            rotational: 0.0,
            gravitational,
            elastic: 0.0,
            dissipated: None,
        }
    }

    fn points(series: &Series) -> &[(f64, f64)] {
        match &series.shape {
            Shape::Line(points) => points,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn gravitational_energy_counts_from_its_lowest_and_absent_kinds_stay_out() {
        let all = kinds(&[
            row(0.0, 1.0, -7.0),
            row(1.0, 1.0, -9.0),
            row(2.0, 1.0, -8.5),
        ]);
        let names: Vec<_> = all.iter().map(|s| s.name.as_str()).collect();
        assert_eq!(names, ["sum", "kinetic", "gravitational"]);
        assert_eq!(points(&all[2]), [(0.0, 2.0), (1.0, 0.0), (2.0, 0.5)]);
        assert_eq!(points(&all[0]), [(0.0, 3.0), (1.0, 1.0), (2.0, 1.5)]);
    }

    #[test]
    fn both_charts_share_their_time_and_say_what_is_missing() {
        let rows = [row(0.0, 0.0, 0.0), row(1.0, 1e-3, 0.0), row(2.0, 1e-9, 0.0)];
        let page = energy_page("Fall", &rows);
        assert!(
            page.charts
                .iter()
                .all(|chart| chart.x.range == Some((0.0, 2.0)))
        );
        let svg = page.svg().unwrap();
        for said in [
            "Fall",
            "Energies over time",
            "energy (mJ)",
            "kinetic energy (J)",
            "time (s)",
            "1 of 3 points",
        ] {
            assert!(svg.contains(said), "{said}");
        }
        assert!(
            energy_page("", &rows[..1])
                .svg()
                .unwrap()
                .contains("zero throughout the run")
        );
        assert!(
            energy_page("", &[])
                .svg()
                .unwrap()
                .contains("no energies were recorded")
        );
    }

    #[test]
    fn the_largest_numbers_and_none_are_drawn() {
        let odd = [
            row(0.0, f64::MAX, f64::MIN),
            row(1.0, f64::NAN, f64::MAX),
            row(f64::INFINITY, 1.0, 1.0),
            row(3.0, f64::MIN_POSITIVE, 0.0),
        ];
        assert!(
            energy_page("odd", &odd)
                .svg()
                .unwrap()
                .contains("points not drawn")
        );
    }

    #[test]
    fn a_long_run_makes_a_small_svg() {
        let noise =
            |n: u32, factor: u32| f64::from(n.wrapping_mul(factor) >> 8) / f64::from(1 << 24);
        let rows: Vec<_> = (0..200_000)
            .map(|n| EnergyRow {
                rotational: noise(n, 2_654_435_761),
                ..row(f64::from(n), noise(n, 2_246_822_519), 0.0)
            })
            .collect();
        let svg = energy_page("long", &rows).svg().unwrap();
        assert!(svg.len() < 500_000, "{}", svg.len());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        #[test]
        fn no_energies_break_the_chart(bits in prop::collection::vec(any::<[u64; 6]>(), 1..6)) {
            let rows: Vec<_> = (bits.iter())
                .map(|bits| {
                    let [time, kinetic, rotational, gravitational, elastic, dissipated] = bits.map(f64::from_bits);
                    let dissipated = (bits[5] % 2 == 0).then_some(dissipated);
                    EnergyRow { time, kinetic, rotational, gravitational, elastic, dissipated }
                })
                .collect();
            let svg = energy_page("any", &rows).svg().unwrap();
            prop_assert!(!svg.contains("NaN") && !svg.contains("inf"));
            roxmltree::Document::parse(&svg).unwrap();
        }
    }
}
