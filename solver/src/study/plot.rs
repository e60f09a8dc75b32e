//! A column of a study's table over a key.

use std::collections::{BTreeMap, BTreeSet};

use mercury_common::units::Quantity;
use mercury_pictures::charts::{Axis, Chart, ChartPage, Series};

use super::Study;
use super::table::{StudyTable, number, plain};

/// Places in their order, and the values at each.
type Points = BTreeMap<u64, (f64, Vec<f64>)>;

/// More lines than a chart can tell apart.
const MOST_LINES: usize = 12;

/// A column over the first key that has different numbers, a line for each combination of the other keys' values. Runs that
/// differ only in `seed` are one point: their mean, with the standard error of it.
///
/// # Errors
/// Why there is nothing to draw.
pub fn page(study: &Study, table: &StudyTable, column: &str) -> Result<ChartPage, String> {
    let values = table.numbers(column).ok_or_else(|| {
        let names = table.columns.iter().map(String::as_str);
        let hint = match mercury_common::scene::nearest(column, names.clone()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("there are: {}", mercury_common::scene::listed(names)),
        };
        format!("the table has no column `{column}`; {hint}")
    })?;
    let numbers = |key: &String| table.numbers(key).unwrap_or_default();
    let differs = |key: &&String| {
        let found: Vec<f64> = numbers(key).into_iter().flatten().collect();
        found.iter().any(|value| *value != found[0])
    };
    let over = (study.keys.iter().filter(|key| *key != "seed").find(differs))
        .or_else(|| study.keys.iter().find(differs))
        .ok_or("no key of the study has different numbers")?;
    let others: Vec<&String> = (study.keys.iter())
        .filter(|key| *key != over && *key != "seed")
        .collect();
    let cell = |row: usize, key: &str| {
        let place = table.columns.iter().position(|name| name == key);
        place.map_or("", |place| table.rows[row][place].as_str())
    };
    // In the units in which they were typed.
    let (over_shown, shown) = (Shown::of(study, over), Shown::of(study, column));

    // By line and then by place: the values of all seeds.
    let mut lines: Vec<(String, Points)> = Vec::new();
    for (row, (at, value)) in numbers(over).into_iter().zip(values).enumerate() {
        let (Some(at), Some(value)) = (at, value) else {
            continue;
        };
        if !(at.is_finite() && value.is_finite()) {
            continue;
        }
        let at = at / over_shown.per_unit;
        let name: Vec<String> = others
            .iter()
            .map(|key| format!("{key} = {}", typed(study, key, cell(row, key))))
            .collect();
        let name = name.join(", ");
        let line = lines.iter().position(|(known, _)| *known == name);
        let line = line.unwrap_or_else(|| {
            lines.push((name, BTreeMap::new()));
            lines.len() - 1
        });
        let points = &mut lines[line].1;
        points
            .entry(ordered(at))
            .or_insert((at, Vec::new()))
            .1
            .push(value / shown.per_unit);
    }
    if lines.is_empty() {
        return Err(format!("`{column}` has no numbers yet"));
    }
    if lines.len() > MOST_LINES {
        return Err(format!(
            "{} lines, more than a chart can distinguish: draw study.csv with another program",
            lines.len()
        ));
    }
    let places: Vec<f64> = lines
        .iter()
        .flat_map(|(_, points)| points.values().map(|(at, _)| *at))
        .collect();
    let low = places.iter().copied().fold(f64::INFINITY, f64::min);
    let high = places.iter().copied().fold(0.0, f64::max);
    let x = if low > 0.0 && high >= 50.0 * low {
        Axis::log(over, &over_shown.unit)
    } else {
        Axis::linear(over, &over_shown.unit)
    };
    let mut chart = Chart::new(&study.title, x, Axis::linear(column, &shown.unit));
    for (name, points) in lines {
        let means: Vec<(f64, f64)> = points
            .values()
            .map(|(at, values)| (*at, mean(values)))
            .collect();
        let repeated = points.values().any(|(_, values)| values.len() > 1);
        chart = if repeated {
            let errors = points.values().map(|(_, values)| error(values)).collect();
            chart.with(Series::points_with_errors(&name, means, errors))
        } else {
            chart.with(Series::marked_line(&name, means))
        };
    }
    Ok(ChartPage::of(chart))
}

/// The unit in which a column is drawn.
struct Shown {
    unit: String,
    /// Scale of the numbers of the table, which are in SI.
    per_unit: f64,
}

impl Shown {
    /// The unit in which all values of a key were typed; otherwise that of the table.
    fn of(study: &Study, column: &str) -> Self {
        let in_si = || Self {
            unit: study.unit(column),
            per_unit: 1.0,
        };
        let Some(k) = study.keys.iter().position(|key| key == column) else {
            return in_si();
        };
        let texts = study.runs.iter().filter_map(|run| run.values[k].as_deref());
        let texts: Vec<String> = texts.map(|text| plain(Some(text))).collect();
        let units: BTreeSet<&str> = texts.iter().map(|text| Quantity::unit_in(text)).collect();
        let mut units = units.into_iter();
        let (Some(unit), None) = (units.next(), units.next()) else {
            return in_si();
        };
        // For a text that is no quantity, or a key without unit, there is nothing to convert.
        match number(column, &format!("1 {unit}")).filter(|_| !study.unit(column).is_empty()) {
            Some(per_unit) if !unit.is_empty() => Self {
                unit: unit.to_owned(),
                per_unit,
            },
            _ => in_si(),
        }
    }
}

/// The value of a key as typed, if a run of the study has it; otherwise as in the table, with its unit.
fn typed(study: &Study, key: &str, cell: &str) -> String {
    let place = study.keys.iter().position(|known| known == key);
    let typed = place.and_then(|k| {
        let mut runs = study.runs.iter();
        let run = runs.find(|run| plain(run.settled[k].as_deref()) == cell)?;
        run.values[k].as_deref()
    });
    match typed {
        Some(text) => plain(Some(text)),
        None => format!("{cell} {}", study.unit(key)).trim_end().to_owned(),
    }
}

/// A number whose order is that of the values.
fn ordered(value: f64) -> u64 {
    let bits = (value + 0.0).to_bits();
    if bits >> 63 == 0 {
        bits | 1 << 63
    } else {
        !bits
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Half the lengths of a point's bars: the standard error of the mean, none for a single value.
fn error(values: &[f64]) -> (f64, f64) {
    let (mean, count) = (mean(values), values.len() as f64);
    let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
    (0.0, (squares / (count - 1.0).max(1.0) / count).sqrt())
}
