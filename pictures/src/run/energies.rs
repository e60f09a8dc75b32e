//! The picture of the energies over time: all of them on linear axes, the kinetic energy on a logarithmic one.

use super::EnergyRow;
use super::curve::curve;
use crate::canvas::{Anchor, Canvas, HALF_CAPITAL, Lettering, Spot, Stroke, WIDTH, frame};
use crate::colour::Colour;
use crate::font;
use crate::scale::{Ticks, Unit, superscript};

const LEFT: f64 = 104.0;
const RIGHT: f64 = 930.0;
const LEGEND: f64 = 958.0;
const UPPER: (f64, f64) = (96.0, 520.0);
const LOWER: (f64, f64) = (570.0, 820.0);
/// The logarithmic axis reaches at most this many decades below its top: the digits of an f64.
const MOST_DECADES: i32 = 16;

/// One line of the upper panel.
struct Series {
    name: &'static str,
    note: &'static str,
    stroke: Stroke,
    /// J.
    values: Vec<f64>,
}

/// Colours that colour-blind readers tell apart (M. Okabe and K. Ito, 2008).
const BLUE: Colour = Colour(0, 114, 178);
const ORANGE: Colour = Colour(230, 159, 0);
const GREEN: Colour = Colour(0, 158, 115);
const PURPLE: Colour = Colour(204, 121, 167);
const RED: Colour = Colour(213, 94, 0);

/// Draws the picture.
pub(super) fn draw(canvas: &mut dyn Canvas, title: &str, rows: &[EnergyRow]) {
    let (title, size) = font::fit(title, 24.0, 13.0, WIDTH - 40.0 - LEFT);
    canvas.text(
        &title,
        (LEFT, 50.0),
        Lettering::new(size, Colour::INK, Anchor::Start),
    );
    canvas.text(
        "Energies over time",
        (LEFT, 76.0),
        Lettering::new(15.0, Colour::SOFT_INK, Anchor::Start),
    );
    let rows: Vec<EnergyRow> = rows.iter().copied().filter(EnergyRow::is_finite).collect();
    let (time_unit, times, horizontal) = time_axis(&rows);
    upper_panel(canvas, &rows, &times, &horizontal);
    lower_panel(canvas, &rows, &times, &horizontal);
    let label = format!("time ({})", time_unit.name);
    let at = (0.5 * (LEFT + RIGHT), LOWER.1 + 54.0);
    canvas.text(
        &label,
        at,
        Lettering::new(15.0, Colour::INK, Anchor::Middle),
    );
}

/// A linear axis of the page: values at its two ends and the places of these.
struct Axis {
    values: (f64, f64),
    places: (f64, f64),
}

impl Axis {
    fn place(&self, value: f64) -> f64 {
        let share = (value - self.values.0) / (self.values.1 - self.values.0);
        self.places.0 + share.clamp(-0.5, 1.5) * (self.places.1 - self.places.0)
    }
}

/// `low..high`, opened where it is too narrow for an axis.
fn opened(low: f64, high: f64) -> (f64, f64) {
    let size = low.abs().max(high.abs());
    if high - low > 1e-9 * size && (high - low).is_normal() {
        return (low, high);
    }
    let room = if size > 0.0 { 0.1 * size } else { 1.0 };
    (low - room, high + room)
}

fn time_axis(rows: &[EnergyRow]) -> (Unit, Vec<f64>, Axis) {
    let largest = rows.iter().map(|row| row.time.abs()).fold(0.0, f64::max);
    let unit = Unit::not_above_plain(largest, "s");
    let times: Vec<f64> = rows.iter().map(|row| row.time / unit.size).collect();
    let low = times.iter().copied().fold(f64::MAX, f64::min);
    let high = times.iter().copied().fold(f64::MIN, f64::max);
    let values = if times.is_empty() {
        (0.0, 1.0)
    } else if low < high {
        opened(low, high)
    } else {
        opened(low, low)
    };
    (
        unit,
        times,
        Axis {
            values,
            places: (LEFT, RIGHT),
        },
    )
}

/// The series that the run has: a kind of energy that is zero throughout is not drawn, except the kinetic one.
fn series(rows: &[EnergyRow]) -> Vec<Series> {
    let lowest = rows
        .iter()
        .map(|row| row.gravitational)
        .fold(f64::MAX, f64::min);
    let column = |pick: &dyn Fn(&EnergyRow) -> f64| -> Vec<f64> {
        rows.iter()
            .map(|row| pick(row).clamp(f64::MIN, f64::MAX))
            .collect()
    };
    let line = |name, note, colour, dashes, values| Series {
        name,
        note,
        stroke: Stroke {
            colour,
            width: 2.2,
            dashes,
        },
        values,
    };
    let kinetic = column(&|row| row.kinetic);
    let mut all = vec![line("kinetic", "of translation", BLUE, &[], kinetic)];
    let rest = [
        line(
            "rotational",
            "kinetic, of rotation",
            ORANGE,
            &[9.0, 4.0],
            column(&|row| row.rotational),
        ),
        line(
            "gravitational",
            "above its minimum in this run",
            GREEN,
            &[14.0, 4.0, 3.0, 4.0],
            column(&|row| row.gravitational - lowest),
        ),
        line(
            "elastic",
            "stored in contacts",
            PURPLE,
            &[4.0, 4.0],
            column(&|row| row.elastic),
        ),
    ];
    all.extend(
        rest.into_iter()
            .filter(|s| s.values.iter().any(|v| *v != 0.0)),
    );
    if rows.iter().any(|row| row.dissipated.is_some()) {
        let values = column(&|row| row.dissipated.unwrap_or(0.0));
        all.push(line(
            "dissipated",
            "since the start",
            RED,
            &[9.0, 3.0, 2.0, 3.0, 2.0, 3.0],
            values,
        ));
    }
    all
}

fn upper_panel(canvas: &mut dyn Canvas, rows: &[EnergyRow], times: &[f64], horizontal: &Axis) {
    let mut all = series(rows);
    let largest = |all: &[Series]| {
        all.iter()
            .flat_map(|s| &s.values)
            .map(|v| v.abs())
            .fold(0.0, f64::max)
    };
    let mut unit = Unit::for_magnitude(largest(&all), "J");
    if all.len() > 1 {
        // Summed in the unit of the axis: no sum of finite energies overflows there.
        let sums: Vec<f64> = (0..rows.len())
            .map(|i| all.iter().map(|s| s.values[i] / unit.size).sum())
            .collect();
        let total = Series {
            name: "sum of these",
            note: "",
            stroke: Stroke::solid(Colour::INK, 1.3),
            values: sums
                .iter()
                .map(|sum| (sum * unit.size).clamp(f64::MIN, f64::MAX))
                .collect(),
        };
        all.push(total);
        unit = Unit::for_magnitude(largest(&all), "J");
    }
    let values = || all.iter().flat_map(|s| &s.values).map(|v| v / unit.size);
    let (low, high) = (values().fold(0.0, f64::min), values().fold(0.0, f64::max));
    let values = if low < high {
        (low, high + 0.05 * (high - low))
    } else {
        (0.0, 1.0)
    };
    let values = if low < 0.0 {
        (low - 0.05 * (high - low), values.1)
    } else {
        values
    };
    let vertical = Axis {
        values,
        places: (UPPER.1, UPPER.0),
    };
    axes(canvas, UPPER, horizontal, false);
    let ticks = Ticks::new(values.0, values.1, 6);
    for tick in &ticks.at {
        horizontal_tick(canvas, vertical.place(*tick), &ticks.label(*tick), "");
    }
    frame(
        canvas,
        (LEFT, UPPER.0),
        (RIGHT, UPPER.1),
        Stroke::solid(Colour::SOFT_INK, 1.0),
    );
    vertical_label(canvas, UPPER, &format!("energy ({})", unit.name));
    let mut y = UPPER.0 + 14.0;
    // The thin sum first, so that it covers nothing.
    for one in all.iter().rev() {
        let places: Vec<Spot> = times
            .iter()
            .zip(&one.values)
            .map(|(t, v)| (horizontal.place(*t), vertical.place(*v / unit.size)))
            .collect();
        curve(canvas, &places, one.stroke);
    }
    for one in &all {
        y = legend_entry(canvas, y, one.name, one.note, one.stroke);
    }
}

fn lower_panel(canvas: &mut dyn Canvas, rows: &[EnergyRow], times: &[f64], horizontal: &Axis) {
    // Halves, so that the largest finite energies have a finite sum; their logarithm is shifted back.
    let logarithms: Vec<Option<f64>> = rows
        .iter()
        .map(|row| 0.5 * row.kinetic + 0.5 * row.rotational)
        .map(|half| (half > 0.0).then(|| half.log10() + std::f64::consts::LOG10_2))
        .collect();
    axes(canvas, LOWER, horizontal, true);
    vertical_label(canvas, LOWER, "kinetic energy (J)");
    let stroke = Stroke::solid(BLUE, 1.8);
    let present = || logarithms.iter().flatten().copied();
    if let Some(top) = present().reduce(f64::max) {
        let bottom = present().fold(f64::MAX, f64::min);
        let high = top.ceil() as i32;
        let low = (bottom.floor() as i32)
            .min(high - 1)
            .max(high - MOST_DECADES);
        let vertical = Axis {
            values: (f64::from(low), f64::from(high)),
            places: (LOWER.1, LOWER.0),
        };
        let decades = high - low;
        let step = ((decades + 5) / 6).max(1);
        for exponent in low..=high {
            let y = vertical.place(f64::from(exponent));
            if (exponent - low) % step == 0 {
                horizontal_tick(canvas, y, "10", &superscript(exponent));
            }
            if decades <= 3 && exponent < high {
                for digit in 2..10 {
                    let y = vertical.place(f64::from(exponent) + f64::from(digit).log10());
                    canvas.polyline(
                        &[(LEFT - 3.0, y), (LEFT, y)],
                        Stroke::solid(Colour::SOFT_INK, 0.8),
                    );
                }
            }
        }
        // Where the energy is zero the line ends: a logarithmic axis has no zero.
        let mut run: Vec<Spot> = Vec::new();
        for (time, logarithm) in times.iter().zip(&logarithms) {
            match logarithm {
                Some(value) => {
                    run.push((
                        horizontal.place(*time),
                        vertical.place(value.max(f64::from(low))),
                    ));
                }
                None => {
                    curve(canvas, &run, stroke);
                    run.clear();
                }
            }
        }
        curve(canvas, &run, stroke);
        legend_entry(
            canvas,
            LOWER.0 + 14.0,
            "kinetic",
            "translation and rotation",
            stroke,
        );
    } else {
        let text = if rows.is_empty() {
            "no energies were recorded"
        } else {
            "zero throughout the run"
        };
        let at = (0.5 * (LEFT + RIGHT), 0.5 * (LOWER.0 + LOWER.1));
        canvas.text(
            text,
            at,
            Lettering::new(15.0, Colour::SOFT_INK, Anchor::Middle),
        );
    }
    frame(
        canvas,
        (LEFT, LOWER.0),
        (RIGHT, LOWER.1),
        Stroke::solid(Colour::SOFT_INK, 1.0),
    );
}

/// The vertical grid of a panel, with the numbers of the time axis below it if asked for.
fn axes(canvas: &mut dyn Canvas, (top, bottom): (f64, f64), horizontal: &Axis, numbers: bool) {
    let ticks = Ticks::new(horizontal.values.0, horizontal.values.1, 7);
    for tick in &ticks.at {
        let x = horizontal.place(*tick);
        canvas.polyline(&[(x, top), (x, bottom)], Stroke::solid(Colour::GRID, 1.0));
        canvas.polyline(
            &[(x, bottom), (x, bottom + 5.0)],
            Stroke::solid(Colour::SOFT_INK, 1.0),
        );
        if numbers {
            let style = Lettering::new(13.5, Colour::INK, Anchor::Middle);
            canvas.text(&ticks.label(*tick), (x, bottom + 23.0), style);
        }
    }
}

/// A line of the grid with its number, which may carry an exponent.
fn horizontal_tick(canvas: &mut dyn Canvas, y: f64, label: &str, exponent: &str) {
    canvas.polyline(&[(LEFT, y), (RIGHT, y)], Stroke::solid(Colour::GRID, 1.0));
    canvas.polyline(
        &[(LEFT - 5.0, y), (LEFT, y)],
        Stroke::solid(Colour::SOFT_INK, 1.0),
    );
    let size = 13.5;
    let at = (LEFT - 10.0, y + HALF_CAPITAL * size);
    canvas.text(
        &format!("{label}{exponent}"),
        at,
        Lettering::new(size, Colour::INK, Anchor::End),
    );
}

fn vertical_label(canvas: &mut dyn Canvas, (top, bottom): (f64, f64), text: &str) {
    let style = Lettering {
        upright: true,
        ..Lettering::new(15.0, Colour::INK, Anchor::Middle)
    };
    canvas.text(text, (34.0, 0.5 * (top + bottom)), style);
}

/// One line of the legend; returns where the next one goes.
fn legend_entry(canvas: &mut dyn Canvas, y: f64, name: &str, note: &str, stroke: Stroke) -> f64 {
    canvas.polyline(&[(LEGEND, y), (LEGEND + 40.0, y)], stroke);
    let x = LEGEND + 50.0;
    canvas.text(
        name,
        (x, y + HALF_CAPITAL * 14.5),
        Lettering::new(14.5, Colour::INK, Anchor::Start),
    );
    if note.is_empty() {
        return y + 30.0;
    }
    let (note, size) = font::fit(note, 11.5, 9.0, WIDTH - x - 14.0);
    canvas.text(
        &note,
        (x, y + 21.0),
        Lettering::new(size, Colour::SOFT_INK, Anchor::Start),
    );
    y + 46.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gravitational_energy_counts_from_its_minimum_and_absent_kinds_stay_out() {
        let row = |time, gravitational| EnergyRow {
            time,
            kinetic: 1.0,
            rotational: 0.0,
            gravitational,
            elastic: 0.0,
            dissipated: None,
        };
        let all = series(&[row(0.0, -7.0), row(1.0, -9.0), row(2.0, -8.5)]);
        let names: Vec<_> = all.iter().map(|s| s.name).collect();
        assert_eq!(names, ["kinetic", "gravitational"]);
        assert_eq!(all[1].values, [2.0, 0.0, 0.5]);
    }
}
