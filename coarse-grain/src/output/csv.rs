//! Tables: coordinates first, then fields, with a line of units.

use mercury_common::formats::number::{NumberStyle, push_number};
use mercury_common::formats::table_head;

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

/// Names and units of the columns of a table: coordinates, then fields, each with its error where it has one. `timed` tables have the time as
/// first column.
#[must_use]
pub fn columns(evaluator: &Evaluator, block: &Block, timed: bool) -> Vec<(String, String)> {
    let pair = |name: &str, unit: &str| (name.to_owned(), unit.to_owned());
    let mut columns = Vec::new();
    columns.extend(timed.then(|| pair("time", "s")));
    let coordinates = evaluator.coordinates;
    columns.extend(
        coordinates
            .names()
            .into_iter()
            .zip(coordinates.units())
            .map(|(name, unit)| pair(name, unit)),
    );
    for column in &block.columns {
        columns.push((column.name.clone(), unit(column)));
        if column.errors.is_some() {
            columns.push((format!("{}_error", column.name), unit(column)));
        }
    }
    columns
}

/// The heading: a line of units behind `#`, then the names, each with its unit.
#[must_use]
pub fn header(evaluator: &Evaluator, block: &Block, timed: bool) -> String {
    let columns = columns(evaluator, block, timed);
    let units: Vec<&str> = columns.iter().map(|(_, unit)| unit.as_str()).collect();
    let names = table_head::line(columns.iter().map(|(name, unit)| (name, unit)));
    format!("# units: {}\n{names}", units.join(","))
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
