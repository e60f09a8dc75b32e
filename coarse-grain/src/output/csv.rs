//! Tables: coordinates first, then fields, with a line of units.

use std::fmt::Write as _;

use mercury_common::formats::number::{NumberStyle, push_number};

use crate::analysis::Block;
use crate::evaluate::Evaluator;

/// Unit of a column; powers have units of their own.
fn unit(column: &crate::analysis::Column) -> String {
    if column.field.unit == "m^(q-3)" {
        format!("m^{}", column.component as i32 - 3)
    } else {
        column.field.unit.to_owned()
    }
}

/// The heading: a line of units behind `#`, then the names. `timed` tables have the time as first column.
#[must_use]
pub fn header(evaluator: &Evaluator, block: &Block, timed: bool) -> String {
    let mut names: Vec<String> = Vec::new();
    let mut units: Vec<String> = Vec::new();
    if timed {
        names.push("time".to_owned());
        units.push("s".to_owned());
    }
    names.extend(evaluator.coordinates.names().into_iter().map(str::to_owned));
    units.extend(evaluator.coordinates.units().into_iter().map(str::to_owned));
    for column in &block.columns {
        names.push(column.name.clone());
        units.push(unit(column));
        if column.errors.is_some() {
            names.push(format!("{}_error", column.name));
            units.push(unit(column));
        }
    }
    let mut out = String::new();
    let _ = writeln!(out, "# units: {}", units.join(","));
    let _ = writeln!(out, "{}", names.join(","));
    out
}

/// The rows of a block.
pub fn push_rows(out: &mut Vec<u8>, evaluator: &Evaluator, block: &Block, timed: bool) {
    for point in 0..evaluator.place.len() {
        let mut values: Vec<f64> = Vec::new();
        values.extend(timed.then_some(block.time));
        values.extend(evaluator.place.coordinates(point));
        for column in &block.columns {
            values.push(column.values[point]);
            values.extend(column.errors.as_ref().map(|errors| errors[point]));
        }
        for (k, value) in values.into_iter().enumerate() {
            if k > 0 {
                out.push(b',');
            }
            push_number(out, value, NumberStyle::Shortest);
        }
        out.push(b'\n');
    }
}
