//! Pictures of fields: profiles over one coordinate, heat maps over two.

use mercury_common::formats::number::{NumberStyle, push_number};
use mercury_pictures::ColourMap;
use mercury_pictures::charts::{Axis, Chart, ChartPage, HeatMap, Series};

use crate::CgError;
use crate::analysis::{Block, Column, TimeMode};
use crate::coordinates::{GridAxis, Place};
use crate::evaluate::Evaluator;

/// Most charts on a page: somewhat more than the components of the standard fields.
const MOST: usize = 48;

/// Part of the largest value below which the sign of a value is round-off.
const ROUND_OFF: f64 = 1e-9;

/// Maps of lengths are to scale unless one side is so many times the other: then nothing could be seen along the shorter one.
const LONGEST: f64 = 5.0;

/// A page of all fields of a block: of one coordinate a chart for each field, its components as lines and their standard errors (doubled: 95 %)
/// as bands; of two a heat map for each component.
///
/// # Errors
/// When the fields are of none or three coordinates or at points, or there are more charts than a page takes.
pub fn page(evaluator: &Evaluator, time: TimeMode, block: &Block) -> Result<ChartPage, CgError> {
    let Place::Grid(grid) = &evaluator.place else {
        return Err(refused(
            "pictures show fields on a grid of one or two coordinates",
        ));
    };
    let (names, units) = (evaluator.coordinates.names(), evaluator.coordinates.units());
    let mut to_scale = None;
    let charts = match grid[..] {
        [x] => profiles(block, &x, &Axis::linear(names[0], units[0])),
        [x, y] => {
            let axes = [0, 1].map(|k| Axis::linear(names[k], units[k]));
            let axes = [&axes[0], &axes[1]];
            to_scale = slope([&x, &y], axes);
            maps(block, [&x, &y], axes)
        }
        _ => {
            return Err(refused(
                "pictures show fields of one or two coordinates; three are for .vti",
            ));
        }
    };
    if charts.len() > MOST {
        let found = format!(
            "{} charts do not fit on a page, at most {MOST} do",
            charts.len()
        );
        return Err(CgError::Input(format!("{found}\nhelp: --fields chooses")));
    }
    let columns = if charts.len() < 3 { charts.len() } else { 3 };
    let rows = charts.len().div_ceil(columns) as f64;
    let mut page = ChartPage::new("", columns, charts);
    if let Some(slope) = to_scale {
        // About what axes and colour bar leave of the width, and as high a row as maps of this width need.
        let room = page.size.0 / columns as f64 - 150.0;
        page.size.1 = 40.0 + rows * (70.0 + (slope * room).clamp(100.0, 380.0));
    }
    page.title = match time {
        TimeMode::Average => mean_of(block),
        _ => format!("t = {} s", seconds(block.time)),
    };
    Ok(page)
}

/// The largest number of points that charts over the width distinguish.
const MOST_LINES: usize = 8;

/// A page of means at many widths of the kernel: a chart for each component of each field, over the logarithm of the width, with a line for each point and
/// its standard errors (doubled: 95 %) as bands. Where a field does not depend on the width, its lines are level.
///
/// # Errors
/// When there are more points or charts than can be shown, see [`refuse_widths`].
pub fn widths(evaluator: &Evaluator, blocks: &[(f64, Block)]) -> Result<ChartPage, CgError> {
    let columns = blocks.first().map_or(&[][..], |(_, block)| &block.columns);
    refuse_widths(evaluator, columns.len())?;
    let names = evaluator.coordinates.names();
    let label = |point: usize| -> String {
        let at = evaluator.place.coordinates(point);
        let parts = names.iter().zip(at);
        let parts: Vec<String> = parts
            .map(|(name, at)| format!("{name} = {}", seconds(at)))
            .collect();
        parts.join(", ")
    };
    let chart = |k: usize| {
        let first = &columns[k];
        let name = named(first);
        let mut chart = Chart::new(
            &name,
            Axis::log("kernel width", "m"),
            Axis::linear(&first.field.name.replace('_', " "), &unit(first)),
        );
        for point in 0..evaluator.place.len() {
            let line = |shift: f64| -> Vec<(f64, f64)> {
                let at = |(width, block): &(f64, Block)| {
                    let column = &block.columns[k];
                    let error = column.errors.as_ref().map_or(0.0, |errors| errors[point]);
                    (*width, column.values[point] + shift * error)
                };
                blocks.iter().map(at).collect()
            };
            // The band takes the colour of the line before it.
            chart = chart.with(Series::marked_line(&label(point), line(0.0)));
            if first.errors.is_some() {
                chart = chart.with(Series::band("", line(-2.0), line(2.0)));
            }
        }
        chart
    };
    let charts: Vec<Chart> = (0..columns.len()).map(chart).collect();
    let across = charts.len().clamp(1, 3);
    let mut page = ChartPage::new("", across, charts);
    if let Some((_, block)) = blocks.first() {
        page.title = mean_of(block);
    }
    Ok(page)
}

/// Refuses what [`widths`] cannot show: more points than there are distinguishable lines, or more columns than charts fit on a
/// page.
///
/// # Errors
/// Just these.
pub fn refuse_widths(evaluator: &Evaluator, columns: usize) -> Result<(), CgError> {
    let points = evaluator.place.len();
    if points > MOST_LINES {
        let found =
            format!("pictures of a scan show at most {MOST_LINES} points, and there are {points}");
        let help = "--grid 5, --coordinates O, or --points; a .csv takes any number";
        return Err(CgError::Input(format!("{found}\nhelp: {help}")));
    }
    if columns > MOST {
        let found = format!("{columns} charts do not fit on a page, at most {MOST} do");
        return Err(CgError::Input(format!("{found}\nhelp: --fields chooses")));
    }
    Ok(())
}

/// Frames of a mean, in words.
fn mean_of(block: &Block) -> String {
    format!(
        "Mean of {} frames, t = {} to {} s",
        block.frames,
        seconds(block.span.0),
        seconds(block.span.1)
    )
}

/// A time for people: sums of steps end in round-off.
fn seconds(time: f64) -> String {
    let mut out = Vec::new();
    push_number(&mut out, time, NumberStyle::Digits(6));
    String::from_utf8(out).unwrap_or_default()
}

fn refused(found: &str) -> CgError {
    CgError::Input(format!(
        "{found}\nhelp: --coordinates Z or --coordinates XZ, with --grid or --spacing"
    ))
}

/// The columns of each field of each part.
fn groups(block: &Block) -> Vec<&[Column]> {
    let mut rest = &block.columns[..];
    let mut found = Vec::new();
    while let Some(first) = rest.first() {
        let (group, others) = rest.split_at(first.field.components.count());
        found.push(group);
        rest = others;
    }
    found
}

/// A unit as axes take it: nothing for pure numbers.
fn unit(column: &Column) -> String {
    match column.field.unit {
        "1" => String::new(),
        "m^(q-3)" => format!("m^{}", column.component as i32 - 3),
        unit => unit.to_owned(),
    }
}

fn title(column: &Column) -> String {
    let name = column.field.name.replace('_', " ");
    column
        .part
        .as_ref()
        .map_or(name.clone(), |part| format!("{name}, {part}"))
}

fn profiles(block: &Block, x: &GridAxis, axis: &Axis) -> Vec<Chart> {
    let at = |values: &[f64]| -> Vec<(f64, f64)> {
        values
            .iter()
            .enumerate()
            .map(|(k, value)| (x.at(k), *value))
            .collect()
    };
    let chart = |group: &[Column]| {
        let first = &group[0];
        let mut chart = Chart::new(
            &title(first),
            axis.clone(),
            Axis::linear(&first.field.name.replace('_', " "), &unit(first)),
        );
        for column in group {
            let name = if group.len() == 1 {
                String::new()
            } else {
                component(column)
            };
            // The band takes the colour of the line before it.
            chart = chart.with(Series::line(&name, at(&column.values)));
            if let Some(errors) = &column.errors {
                let edge = |sign: f64| {
                    let values: Vec<f64> = column
                        .values
                        .iter()
                        .zip(errors)
                        .map(|(value, error)| value + sign * 2.0 * error)
                        .collect();
                    at(&values)
                };
                chart = chart.with(Series::band("", edge(-1.0), edge(1.0)));
            }
        }
        chart
    };
    groups(block).into_iter().map(chart).collect()
}

/// `xx` of `stress_xx`.
fn component(column: &Column) -> String {
    let known = column.part.as_ref().map_or(0, |part| part.len() + 1) + column.field.name.len();
    column.name[known..].trim_start_matches('_').to_owned()
}

/// The title of a chart of one component.
fn named(column: &Column) -> String {
    let component = component(column);
    if component.is_empty() {
        title(column)
    } else {
        format!("{} {component}", title(column))
    }
}

/// Height over width of a map whose axes are both lengths and can be drawn to scale.
fn slope([x, y]: [&GridAxis; 2], axes: [&Axis; 2]) -> Option<f64> {
    let slope = (y.max - y.min) / (x.max - x.min);
    let lengths = axes.iter().all(|axis| axis.unit == "m");
    (lengths && (1.0 / LONGEST..=LONGEST).contains(&slope)).then_some(slope)
}

/// Whether values lie on both sides of zero, beyond round-off of the largest.
fn has_both_signs(values: &[f64]) -> bool {
    let there = || values.iter().copied().filter(|value| value.is_finite());
    let (low, high) = (
        there().fold(0.0, f64::min).abs(),
        there().fold(0.0, f64::max),
    );
    low.min(high) > ROUND_OFF * low.max(high)
}

/// A heat map for each component. Those that may be of either sign have a map of colours whose middle is zero.
fn maps(block: &Block, [x, y]: [&GridAxis; 2], [x_axis, y_axis]: [&Axis; 2]) -> Vec<Chart> {
    let to_scale = slope([x, y], [x_axis, y_axis]).is_some();
    let edges = |axis: &GridAxis| -> Vec<f64> {
        (0..=axis.count)
            .map(|k| axis.min + k as f64 * axis.step())
            .collect()
    };
    let chart = |column: &Column| {
        let name = named(column);
        // Our grids run fastest along the last coordinate, maps along x.
        let value = |row: usize, k: usize| {
            let point = k * y.count + row;
            let shown = column.dense.get(point).is_none_or(|dense| *dense);
            if shown {
                column.values[point]
            } else {
                f64::NAN
            }
        };
        let cells = (0..y.count).flat_map(|row| (0..x.count).map(move |k| (row, k)));
        let values: Vec<f64> = cells.map(|(row, k)| value(row, k)).collect();
        let is_signed = column.field.is_signed(column.component) || has_both_signs(&values);
        let map = if is_signed {
            ColourMap::CoolWarm
        } else {
            ColourMap::Viridis
        };
        let map = HeatMap {
            x_edges: edges(x),
            y_edges: edges(y),
            values,
            name: String::new(),
            unit: unit(column),
            map,
            range: None,
            centred: is_signed,
        };
        let mut chart = Chart::new(&name, x_axis.clone(), y_axis.clone()).with(Series::heat(map));
        chart.when_empty = "no particles".into();
        chart.to_scale = to_scale;
        chart
    };
    block.columns.iter().map(chart).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fields::{Field, STANDARD};

    /// Bands have the colours of their lines, in profiles and over widths.
    #[test]
    fn bands_follow_their_lines() {
        use crate::coordinates::Coordinates;
        use crate::kernel::{KernelChoice, KernelShape};
        use mercury_pictures::charts::Shape;
        let axis = GridAxis {
            min: 0.0,
            max: 1.0,
            count: 2,
        };
        let evaluator = Evaluator::new(
            Coordinates::Cartesian([false, false, true]),
            Place::Grid(vec![axis]),
            KernelChoice::new(KernelShape::Lucy, 0.1),
        );
        let field = Field::by_name("velocity").unwrap();
        let column = |component: usize| Column {
            field,
            part: None,
            component,
            name: format!("velocity_{}", ["x", "y", "z"][component]),
            values: vec![1.0 + component as f64; 2],
            errors: Some(vec![0.1; 2]),
            dense: Vec::new(),
        };
        let block = Block {
            time: 1.0,
            span: (0.0, 1.0),
            frames: 9,
            space: Default::default(),
            columns: (0..3).map(column).collect(),
            sums: None,
        };
        let profile = page(&evaluator, TimeMode::Average, &block).unwrap();
        let blocks = [(0.1, block.clone()), (0.2, block)];
        let over_widths = widths(&evaluator, &blocks).unwrap();
        assert_eq!((profile.charts.len(), over_widths.charts.len()), (1, 3));
        for (chart, pairs) in [(&profile.charts[0], 3), (&over_widths.charts[0], 2)] {
            assert_eq!(chart.series.len(), 2 * pairs);
            for pair in chart.series.chunks_exact(2) {
                assert!(matches!(
                    pair[0].shape,
                    Shape::Line(_) | Shape::MarkedLine(_)
                ));
                assert!(matches!(pair[1].shape, Shape::Band { .. }));
            }
        }
    }

    /// One particle in a box three times as high as wide: the air has no velocity and no part in the colours, but a density of
    /// zero.
    #[test]
    fn maps_leave_the_air_blank_and_are_to_scale() {
        use crate::analysis::{Analysis, Part, Reference};
        use crate::coordinates::Coordinates;
        use crate::kernel::{KernelChoice, KernelShape};
        use crate::state::State;
        use glam::DVec3;
        use mercury_pictures::charts::Shape;
        let axis = |max: f64| GridAxis {
            min: 0.0,
            max,
            count: 30,
        };
        let place = Place::Grid(vec![axis(1.0), axis(3.0)]);
        let kernel = KernelChoice::new(KernelShape::Gaussian, 0.1);
        let coordinates = Coordinates::Cartesian([true, false, true]);
        let analysis = Analysis {
            evaluator: Evaluator::new(coordinates, place, kernel),
            fields: ["density", "velocity"]
                .iter()
                .filter_map(|name| Field::by_name(name))
                .collect(),
            parts: vec![Part::everything()],
            time: TimeMode::Frames,
            errors: false,
            reference: Reference::Previous,
            keep_sums: false,
            running: false,
        };
        let mut state = State::default();
        state.space.max = DVec3::new(1.0, 1.0, 3.0);
        let p = &mut state.particles;
        p.id.push(1);
        p.material.push(0);
        p.flowing.push(true);
        p.position.push(DVec3::new(0.5, 0.5, 0.5));
        p.velocity.push(DVec3::new(2.0, 2.0, 2.0));
        p.mass.push(1.0);
        p.volume.push(0.1);
        p.radius.push(0.1);
        p.angular_velocity.push(DVec3::ZERO);
        p.spin.push(DVec3::ZERO);
        let mut blocks = Vec::new();
        let keep = |block| {
            blocks.push(block);
            Ok(())
        };
        analysis.run([Ok(state)].into_iter(), keep).unwrap();
        let page = page(&analysis.evaluator, TimeMode::Frames, &blocks[0]).unwrap();
        let values = |chart: usize| match &page.charts[chart].series[0].shape {
            Shape::Heat(map) => map.values.clone(),
            _ => panic!("no map"),
        };
        assert!(page.charts.iter().all(|chart| chart.to_scale));
        assert!(values(0).iter().all(|density| density.is_finite()));
        assert!(values(0).contains(&0.0));
        let velocities = values(1);
        let shown: Vec<f64> = (velocities.iter().copied())
            .filter(|value| value.is_finite())
            .collect();
        // Of a Gaussian, exp(-r^2 / (2 w^2)) > 0.05 within r = 2.45 w: 0.188 m^2 of 3 m^2.
        assert!((45..70).contains(&shown.len()), "{}", shown.len());
        assert!(shown.iter().all(|value| (value - 2.0).abs() < 1e-12));
        // A density has one sign; a velocity has either, and grey is at rest.
        let maps = page
            .charts
            .iter()
            .map(|chart| match &chart.series[0].shape {
                Shape::Heat(map) => (map.map, map.centred),
                _ => panic!("no map"),
            });
        let maps: Vec<_> = maps.collect();
        assert_eq!(maps[0], (ColourMap::Viridis, false));
        assert_eq!(maps[1..], [(ColourMap::CoolWarm, true); 3]);
        assert!(page.svg().is_ok());
    }

    #[test]
    fn round_off_has_no_sign() {
        assert!(has_both_signs(&[-1.0, f64::NAN, 2.0]));
        assert!(!has_both_signs(&[-1e-12, 0.0, 2.0]));
        assert!(!has_both_signs(&[-3.0, -2.0]) && !has_both_signs(&[f64::NAN]));
    }

    #[test]
    fn maps_of_the_standard_fields_fit_on_a_page() {
        let fields = STANDARD.iter().filter_map(|name| Field::by_name(name));
        let charts: usize = fields.map(|field| field.components.count()).sum();
        assert!((30..=MOST).contains(&charts), "{charts}");
    }
}
