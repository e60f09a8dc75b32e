//! Text tables that grow: a head by the table's specification, then rows of cells with commas between them.

use mercury_common::formats::delimited::push_cell;
use mercury_common::formats::number::{NumberStyle, push_integer, push_number};
use mercury_common::formats::table_head;
use mercury_common::run_tables::TableSpec;

use super::stream::{Beginning, Sink, Stream, StreamKind, TextFile};
use super::{Due, FrameCopy, OutputError};
use crate::plan::Plan;
use mercury_engine::audit::Losses;

/// A table of a run: which it is, and how its rows are filled.
pub(crate) trait RunTable: Send + Sized + 'static {
    /// Its file and columns.
    const SPEC: &'static TableSpec;

    /// Whether the run of this plan has it.
    fn is_wanted(plan: &Plan) -> bool;

    /// The table of a plan.
    fn new(plan: &Plan) -> Self;

    /// Names and units of its columns, where they are not all columns of the specification.
    fn columns(&self, _losses: &Losses) -> Vec<(String, &'static str)> {
        let columns = Self::SPEC.columns.iter();
        columns
            .map(|column| (column.name.to_owned(), column.unit))
            .collect()
    }

    /// Whether rows are due.
    fn is_due(due: Due) -> bool {
        due.frame
    }

    /// Appends the rows of a state, each with a cell for each column.
    fn push_rows(&self, state: &FrameCopy, rows: &mut Rows<'_>);
}

/// Rows of a table, filled cell by cell.
pub(crate) struct Rows<'a> {
    out: &'a mut Vec<u8>,
    /// Columns of the table, and cells of the present row.
    columns: usize,
    cells: usize,
}

impl Rows<'_> {
    fn begin_cell(&mut self) -> &mut Vec<u8> {
        if self.cells > 0 {
            self.out.push(b',');
        }
        self.cells += 1;
        self.out
    }

    /// A number in its shortest form that reads back exactly.
    pub(crate) fn number(&mut self, number: f64) -> &mut Self {
        push_number(self.begin_cell(), number, NumberStyle::Shortest);
        self
    }

    /// Numbers.
    pub(crate) fn numbers(&mut self, numbers: impl IntoIterator<Item = f64>) -> &mut Self {
        for number in numbers {
            self.number(number);
        }
        self
    }

    /// A number that may be missing: the cell is empty then.
    pub(crate) fn perhaps(&mut self, number: Option<f64>) -> &mut Self {
        match number {
            Some(number) => self.number(number),
            None => self.text(""),
        }
    }

    /// A whole number.
    pub(crate) fn whole(&mut self, number: i64) -> &mut Self {
        push_integer(self.begin_cell(), number);
        self
    }

    /// Counts.
    pub(crate) fn counts(&mut self, counts: impl IntoIterator<Item = u64>) -> &mut Self {
        for count in counts {
            self.whole(count as i64);
        }
        self
    }

    /// A name, in quotes where it needs them.
    pub(crate) fn text(&mut self, text: &str) -> &mut Self {
        push_cell(self.begin_cell(), text);
        self
    }

    /// Ends the row.
    pub(crate) fn end(&mut self) {
        debug_assert_eq!(self.cells, self.columns, "cells of a row");
        self.out.push(b'\n');
        self.cells = 0;
    }
}

/// The stream of a table.
pub(crate) struct TableFile<T> {
    file: TextFile,
    table: T,
    columns: usize,
}

impl<T: RunTable> StreamKind for TableFile<T> {
    const NAME: &'static str = T::SPEC.file;

    fn is_wanted(plan: &Plan) -> bool {
        T::is_wanted(plan)
    }

    fn begin(run: &Beginning<'_>) -> Result<Self, OutputError> {
        let table = T::new(run.plan);
        let columns = table.columns(run.losses);
        let head = table_head::line(columns.iter().map(|(name, unit)| (name, unit)));
        Ok(Self {
            file: run.text(Self::NAME, head.as_bytes())?,
            columns: columns.len(),
            table,
        })
    }
}

impl<T: RunTable> Stream for TableFile<T> {
    fn write(&mut self, state: &FrameCopy) -> Result<(), OutputError> {
        if T::is_due(state.due) {
            let mut rows = Rows {
                out: &mut self.file.buffer,
                columns: self.columns,
                cells: 0,
            };
            self.table.push_rows(state, &mut rows);
            self.file.flush()?;
        }
        Ok(())
    }

    fn sink(&self) -> Sink<'_> {
        Sink::Text(&self.file)
    }
}
