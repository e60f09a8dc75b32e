//! The chart of the energies that a run leaves behind.

use std::borrow::Cow;

use crate::charts::{Axis, Chart, ChartPage, Dash, Hue, Legend, Series};

/// The energies of the system at one time.
#[derive(Debug, Clone, PartialEq)]
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
    /// The energy balance since the start, if the run keeps one.
    pub flows: Option<EnergyFlows>,
}

impl EnergyRow {
    /// Energy that is stored in the system (J).
    #[must_use]
    pub fn stored(&self) -> f64 {
        let sheets = (self.flows.as_ref()).map_or(0.0, |flows| flows.sheets.stored());
        self.kinetic + self.rotational + self.gravitational + self.elastic + sheets
    }
}

/// The energy balance of a system since the start, J.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EnergyFlows {
    /// Dissipated, by the name of what took it; the names are the same in all rows of a run.
    pub dissipated: Vec<(Cow<'static, str>, f64)>,
    /// Work of all walls on the particles.
    pub wall_work: f64,
    /// The part of it that walls with a servo did.
    pub servo_work: f64,
    /// Brought in by particles that came.
    pub inserted: f64,
    /// Taken out by particles that went, with what their contacts stored.
    pub deleted: f64,
    /// The part of it that their contacts stored.
    pub deleted_elastic: f64,
    /// Stored in contacts with walls that vanished.
    pub vanished_walls: f64,
    /// Elastic sheets.
    pub sheets: SheetEnergies,
}

/// Energies of elastic sheets, J.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SheetEnergies {
    /// Kinetic energy of the vertices.
    pub kinetic: f64,
    /// Potential energy in gravity, from any level.
    pub gravitational: f64,
    /// Elastic energy of stretching.
    pub stretching: f64,
    /// Elastic energy of bending.
    pub bending: f64,
    /// Dissipated since the start, by dashpots and drag.
    pub dissipated: f64,
    /// Work of the pressure since the start.
    pub pressure_work: f64,
    /// Work of holds since the start.
    pub hold_work: f64,
}

impl SheetEnergies {
    /// Energy that is stored in the sheets (J).
    #[must_use]
    pub fn stored(&self) -> f64 {
        self.kinetic + self.gravitational + self.stretching + self.bending
    }
}

impl EnergyFlows {
    /// Dissipated by all of them and by sheets (J).
    #[must_use]
    pub fn all_dissipated(&self) -> f64 {
        let losses = self.dissipated.iter().map(|(_, energy)| energy);
        losses.sum::<f64>() + self.sheets.dissipated
    }

    /// Taken from the system by all of them (J); negative if more was given to it.
    #[must_use]
    pub fn taken(&self) -> f64 {
        self.all_dissipated() + self.deleted + self.vanished_walls
            - self.wall_work
            - self.inserted
            - self.sheets.pressure_work
            - self.sheets.hold_work
    }
}

/// The energies of a run over time, as charts: every kind that the run has, gravitational energy counted from its lowest in the
/// run; where the run keeps one, the energy balance since the start; and the whole kinetic energy on a logarithmic axis. `rows`
/// are in the order of time.
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
    let mut charts = Vec::new();
    let mut energies = Chart::new("", time(), Axis::linear("energy", "J")).legend(Legend::Right);
    energies.series = kinds(rows);
    charts.push(energies);
    let mut row_shares = vec![3.0];
    let mut height = 540.0;
    if rows.iter().any(|row| row.flows.is_some()) {
        let axis = Axis::linear("energy since the start", "J");
        let mut since = Chart::new("", time(), axis).legend(Legend::Right);
        since.series = flows(rows);
        since.when_empty = "nothing was dissipated, given or taken".into();
        charts.push(since);
        row_shares.push(3.0);
        height = 800.0;
    }
    let mut speed = Chart::new("", time(), Axis::log("kinetic energy", "J"));
    let kinetic = |row: &EnergyRow| (row.time, row.kinetic + row.rotational);
    let line = Series::line("", rows.iter().map(kinetic).collect());
    speed.series.push(line.hue(Hue::Blue));
    if !rows.is_empty() {
        speed.when_empty = "zero throughout the run".into();
    }
    charts.push(speed);
    row_shares.push(2.0);
    if rows.is_empty() {
        for chart in &mut charts {
            chart.when_empty = "no energies were recorded".into();
        }
    }
    let page = ChartPage::new(title, 1, charts);
    ChartPage {
        subtitle: "Energies over time".into(),
        row_shares,
        ..page.size(720.0, height)
    }
}

/// A line of the chart: its name, what it is, its look, its value in a row.
type Kind<'a> = (
    Cow<'static, str>,
    Cow<'static, str>,
    Hue,
    Dash,
    Box<dyn Fn(&EnergyRow) -> f64 + 'a>,
);

fn line((name, about, hue, dash, pick): &Kind, rows: &[EnergyRow]) -> Series {
    let points = rows.iter().map(|row| (row.time, pick(row))).collect();
    Series::line(name.as_ref(), points)
        .hue(*hue)
        .dash(*dash)
        .about(about.as_ref())
}

/// Whether a kind has another value than zero anywhere.
fn is_there((.., pick): &Kind, rows: &[EnergyRow]) -> bool {
    rows.iter().any(|row| pick(row) != 0.0)
}

/// The kinds of energy that the run has: one that is zero throughout is not drawn, except the kinetic one. Before them their sum, with what
/// was taken from the system since the start and without what was given to it: it stays the same where the budget closes.
fn kinds(rows: &[EnergyRow]) -> Vec<Series> {
    let heights = rows.iter().map(|row| row.gravitational);
    let lowest = heights
        .filter(|energy| energy.is_finite())
        .fold(f64::MAX, f64::min);
    let all: [Kind; 4] = [
        (
            "kinetic".into(),
            "of translation".into(),
            Hue::Blue,
            Dash::Solid,
            Box::new(|row| row.kinetic),
        ),
        (
            "rotational".into(),
            "kinetic, of rotation".into(),
            Hue::Orange,
            Dash::Dashed,
            Box::new(|row| row.rotational),
        ),
        (
            "gravitational".into(),
            "above its lowest in this run".into(),
            Hue::Green,
            Dash::DashDot,
            Box::new(move |row| row.gravitational - lowest),
        ),
        (
            "elastic".into(),
            "stored in contacts".into(),
            Hue::Purple,
            Dash::Dotted,
            Box::new(|row| row.elastic),
        ),
    ];
    let all: Vec<_> = all
        .into_iter()
        .filter(|kind| kind.0 == "kinetic" || is_there(kind, rows))
        .collect();
    let is_audited = rows.iter().any(|row| row.flows.is_some());
    let mut series = Vec::new();
    if all.len() > 1 || is_audited {
        // Thin and first, so that it covers nothing.
        let sum = |row: &EnergyRow| {
            let stored: f64 = all.iter().map(|(.., pick)| pick(row)).sum();
            stored + (row.flows.as_ref()).map_or(0.0, EnergyFlows::taken)
        };
        let total = rows.iter().map(|row| (row.time, sum(row))).collect();
        let (name, about) = if is_audited {
            ("balance", "energies + taken - given")
        } else {
            ("sum", "of those below")
        };
        let total = Series::line(name, total).hue(Hue::Ink).dash(Dash::Solid);
        series.push(total.width(0.9).about(about));
    }
    series.extend(all.iter().map(|kind| line(kind, rows)));
    series
}

/// The energy balance since the start, kind by kind; a kind that is zero throughout is not drawn.
fn flows(rows: &[EnergyRow]) -> Vec<Series> {
    fn of(pick: fn(&EnergyFlows) -> f64) -> Box<dyn Fn(&EnergyRow) -> f64> {
        Box::new(move |row| row.flows.as_ref().map_or(0.0, pick))
    }
    // A row without losses may name none.
    let names = (rows.iter().filter_map(|row| row.flows.as_ref()))
        .max_by_key(|flows| flows.dissipated.len());
    let names = names.map_or(&[][..], |flows| &flows.dissipated);
    let losses = names.iter().enumerate().map(|(number, (name, _))| -> Kind {
        let (about, hue, dash) = look_of_loss(name);
        let energy = move |flows: &EnergyFlows| flows.dissipated.get(number).map_or(0.0, |it| it.1);
        (
            format!("dissipated, {name}").into(),
            about,
            hue,
            dash,
            Box::new(move |row| row.flows.as_ref().map_or(0.0, energy)),
        )
    });
    let others: [Kind; 5] = [
        (
            "work of walls".into(),
            "given, servos apart".into(),
            Hue::Blue,
            Dash::Solid,
            of(|flows| flows.wall_work - flows.servo_work),
        ),
        (
            "work of servos".into(),
            "given".into(),
            Hue::Blue,
            Dash::Dashed,
            of(|flows| flows.servo_work),
        ),
        (
            "inserted".into(),
            "brought in".into(),
            Hue::Green,
            Dash::Solid,
            of(|flows| flows.inserted),
        ),
        (
            "deleted".into(),
            "taken out, with contacts".into(),
            Hue::Orange,
            Dash::Dashed,
            of(|flows| flows.deleted),
        ),
        (
            "vanished walls".into(),
            "stored at them".into(),
            Hue::Purple,
            Dash::Dotted,
            of(|flows| flows.vanished_walls),
        ),
    ];
    losses
        .chain(others)
        .filter(|kind| is_there(kind, rows))
        .map(|kind| line(&kind, rows))
        .collect()
}

/// Cause of a loss, and the look of its line.
fn look_of_loss(name: &str) -> (Cow<'static, str>, Hue, Dash) {
    match name {
        "normal" => ("by normal forces".into(), Hue::Vermillion, Dash::Long),
        "tangential" => ("by friction".into(), Hue::Vermillion, Dash::Solid),
        "rolling" => (
            "by rolling and torsion".into(),
            Hue::Vermillion,
            Dash::Dotted,
        ),
        "liquid" => ("by bridges".into(), Hue::Sky, Dash::Long),
        other => (format!("by {other}").into(), Hue::Grey, Dash::Solid),
    }
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
            flows: None,
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

    /// A lid that presses on a bed gives 3 J, of which friction takes 2: the energies rise by 1 J, and nothing appears from nowhere.
    #[test]
    fn the_balance_does_not_rise_with_the_work_of_walls() {
        let begin = EnergyRow {
            flows: Some(EnergyFlows::default()),
            ..row(0.0, 1.0, 0.0)
        };
        let flows = EnergyFlows {
            dissipated: vec![
                ("normal".into(), 0.0),
                ("tangential".into(), 1.5),
                ("drag".into(), 0.5),
            ],
            wall_work: 3.0,
            servo_work: 1.0,
            ..EnergyFlows::default()
        };
        let end = EnergyRow {
            elastic: 1.0,
            flows: Some(flows),
            ..row(1.0, 1.0, 0.0)
        };
        let rows = [begin, end];
        let all = kinds(&rows);
        assert_eq!(all[0].name, "balance");
        assert_eq!(points(&all[0]), [(0.0, 1.0), (1.0, 1.0)]);
        let since = super::flows(&rows);
        let names: Vec<_> = since.iter().map(|s| s.name.as_str()).collect();
        assert_eq!(
            names,
            [
                "dissipated, tangential",
                "dissipated, drag",
                "work of walls",
                "work of servos"
            ]
        );
        let ends: Vec<_> = since.iter().map(|series| points(series)[1].1).collect();
        assert_eq!(ends, [1.5, 0.5, 2.0, 1.0]);
        assert_eq!(energy_page("", &rows).charts.len(), 3);
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
        fn no_energies_break_the_chart(bits in prop::collection::vec(any::<[u64; 8]>(), 1..6)) {
            let rows: Vec<_> = (bits.iter())
                .map(|bits| {
                    let [time, kinetic, rotational, gravitational, elastic, lost, wall_work, deleted] = bits.map(f64::from_bits);
                    let dissipated = vec![("normal".into(), lost)];
                    let flows = EnergyFlows { dissipated, wall_work, deleted, ..EnergyFlows::default() };
                    let flows = (bits[5] % 2 == 0).then_some(flows);
                    EnergyRow { time, kinetic, rotational, gravitational, elastic, flows }
                })
                .collect();
            let svg = energy_page("any", &rows).svg().unwrap();
            prop_assert!(!svg.contains("NaN") && !svg.contains("inf"));
            roxmltree::Document::parse(&svg).unwrap();
        }
    }
}
