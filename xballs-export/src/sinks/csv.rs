//! Tables as text, one file per frame.

use mercury_common::formats::delimited::push_cell;
use mercury_common::formats::number::{NumberStyle, push_number};
use mercury_common::formats::table_head::cell;
use mercury_common::frames::{Column, ColumnSpec, Frame};

use super::{Encode, FilePerFrame};
use crate::output::Output;
use crate::{Snapshot, Table};

/// `<prefix>.particles.0000.csv`, ...: a line of names with units, then one line per row, numbers in the shortest form that reads
/// back exactly. The first column is the time. A missing value is an empty field.
pub fn csv(output: &Output, table: Table) -> FilePerFrame<'_, impl Encode> {
    let encode = |snapshot: &Snapshot, out: &mut Vec<u8>| {
        push_csv(&snapshot.specs, &snapshot.frame, out);
        Ok(())
    };
    FilePerFrame::new(output, "csv", encode).of_table(table)
}

/// Appends a frame as CSV.
pub fn push_csv(specs: &[ColumnSpec], frame: &Frame, out: &mut Vec<u8>) {
    out.extend_from_slice(cell("time", "s").as_bytes());
    for spec in specs {
        out.push(b',');
        push_cell(out, &cell(&spec.name, &spec.unit));
    }
    out.push(b'\n');
    let mut time = Vec::new();
    push_number(&mut time, frame.time, NumberStyle::Shortest);
    for row in 0..frame.rows() {
        out.extend_from_slice(&time);
        for column in &frame.columns {
            out.push(b',');
            push_value(column, row, out);
        }
        out.push(b'\n');
    }
}

fn push_value(column: &Column, row: usize, out: &mut Vec<u8>) {
    let integer = |value: u64, out: &mut Vec<u8>| {
        out.extend_from_slice(value.to_string().as_bytes());
    };
    match column {
        Column::F64(v) => push_number(out, v[row], NumberStyle::Shortest),
        Column::I32(v) => out.extend_from_slice(v[row].to_string().as_bytes()),
        Column::U8(v) => integer(v[row].into(), out),
        Column::U32(v) => integer(v[row].into(), out),
        Column::OptionalU32(v) => v[row].into_iter().for_each(|v| integer(v.into(), out)),
        Column::U64(v) => integer(v[row], out),
        Column::Text(v) => push_cell(out, &v[row]),
    }
}
