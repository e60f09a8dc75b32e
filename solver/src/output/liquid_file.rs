//! `<prefix>.liquid.csv`: where the liquid is, and how it left.

use mercury_common::formats::number::{NumberStyle, push_integer, push_number};
use mercury_common::formats::table_head::TableColumn;

use super::stream::{Beginning, Sink, Stream, StreamKind, TIME, TextFile};
use super::{OrderedFrame, OutputError};
use crate::plan::Plan;

/// Columns of values.
const COLUMNS: &[TableColumn] = &[
    ("films", "m3"),
    ("bridges", "m3"),
    ("wall_films", "m3"),
    ("in_flight", "m3"),
    ("emitted", "m3"),
    ("absorbed", "m3"),
    ("lost", "m3"),
    ("left", "m3"),
    ("evaporated", "m3"),
    ("inserted", "m3"),
    ("deleted", "m3"),
    ("error", "m3"),
    ("bridge_count", "1"),
    ("formed", "1"),
    ("ruptured", "1"),
];

/// A row for each output interval; volumes in m^3.
pub(super) struct LiquidFile {
    file: TextFile,
}

impl StreamKind for LiquidFile {
    const NAME: &'static str = "liquid.csv";

    fn is_wanted(plan: &Plan) -> bool {
        plan.outputs().files().liquid && plan.physics().liquid.is_some()
    }

    fn begin(run: &Beginning<'_>) -> Result<Self, OutputError> {
        let file = run.table(Self::NAME, &[TIME], COLUMNS)?;
        Ok(Self { file })
    }
}

impl Stream for LiquidFile {
    fn write(&mut self, state: &OrderedFrame) -> Result<(), OutputError> {
        let Some(row) = state.liquid.as_ref().filter(|_| state.due.frame) else {
            return Ok(());
        };
        let out = &mut self.file.buffer;
        push_number(out, state.time, NumberStyle::Shortest);
        let balance = &row.balance;
        let [in_flight, emitted, absorbed, lost, left] = row.sprayed;
        for volume in [
            row.films,
            row.bridges,
            row.wall_films,
            in_flight,
            emitted,
            absorbed,
            lost,
            balance.left.value() + left,
            balance.evaporated.value(),
            balance.inserted.value(),
            balance.deleted.value(),
            row.error,
        ] {
            out.push(b',');
            push_number(out, volume, NumberStyle::Shortest);
        }
        for count in [row.bridge_count, balance.formed, balance.ruptured] {
            out.push(b',');
            push_integer(out, count as i64);
        }
        out.push(b'\n');
        self.file.flush()
    }

    fn sink(&self) -> Sink<'_> {
        Sink::Text(&self.file)
    }
}
