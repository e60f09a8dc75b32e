//! The answer to a query: computed when it is printed or written.

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use mercury_common::error::FormatError;
use mercury_common::formats::number::{NumberStyle, push_number};
use mercury_common::whole_file::{FileError, WholeFile};
use polars::io::utils::file::Writable;
use polars::prelude::{
    AnyValue, CsvWriterOptions, DataFrame, Engine, FileWriteFormat, IpcWriterOptions, LazyFrame,
    ParquetWriteOptions, PlanCallback, PolarsResult, SinkDestination, SinkTarget, SpecialEq,
    UnifiedSinkArgs,
};

use super::{Broken, QueryError, caught};

/// The format of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Text with commas.
    Csv,
    /// Parquet.
    Parquet,
    /// Arrow IPC file (Feather).
    Arrow,
}

/// An answer that is planned.
pub struct Answer {
    /// The names of its columns.
    pub columns: Vec<String>,
    /// Warnings of frames that were cut; their whole frames count.
    pub damage: Vec<FormatError>,
    pub(super) lazy: LazyFrame,
    pub(super) broken: Broken,
}

impl std::fmt::Debug for Answer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut out = f.debug_struct("Answer");
        out.field("columns", &self.columns).finish_non_exhaustive()
    }
}

/// The first rows of an answer as text.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Rows {
    /// The names of the columns.
    pub columns: Vec<String>,
    /// Row by row the cells; numbers as short as they read back exactly, and nothing for what is missing.
    pub cells: Vec<Vec<String>>,
    /// Number of rows of the answer.
    pub total: usize,
}

impl Answer {
    /// Computes the answer and keeps so many of its first rows, in the memory of these.
    ///
    /// # Errors
    /// When polars cannot compute it, or frames cannot be read.
    pub fn first_rows(self, most: usize) -> Result<Rows, QueryError> {
        let rows = Arc::new(Mutex::new(Rows {
            columns: self.columns.clone(),
            ..Rows::default()
        }));
        let kept = Arc::clone(&rows);
        let keep = move |part: DataFrame| {
            let mut rows = kept.lock().unwrap_or_else(PoisonError::into_inner);
            let more = most.saturating_sub(rows.cells.len()).min(part.height());
            for k in 0..more {
                let cells = part.columns().iter().map(|column| column.get(k).map(text));
                let cells = cells.collect::<PolarsResult<_>>()?;
                rows.cells.push(cells);
            }
            rows.total += part.height();
            Ok(false)
        };
        self.run(|lazy| lazy.sink_batches(PlanCallback::new(keep), true, None))?;
        let mut rows = rows.lock().unwrap_or_else(PoisonError::into_inner);
        Ok(std::mem::take(&mut *rows))
    }

    /// Computes the answer and writes it as it comes: the whole file, or none.
    ///
    /// # Errors
    /// When polars cannot compute it, frames cannot be read, or the file cannot be written.
    pub fn write(self, path: &Path, format: Format) -> Result<(), QueryError> {
        let format = match format {
            Format::Csv => FileWriteFormat::Csv(CsvWriterOptions::default()),
            Format::Parquet => FileWriteFormat::Parquet(Arc::new(ParquetWriteOptions::default())),
            Format::Arrow => FileWriteFormat::Ipc(IpcWriterOptions::default()),
        };
        let file = WholeFile::create(path)?;
        let unwritable = FileError::of(path, "the file cannot be written");
        let inner = file.writer()?.into_inner();
        let inner = inner.map_err(|error| unwritable(error.into_error()))?;
        let target = SpecialEq::new(Arc::new(Mutex::new(Some(Writable::Local(inner)))));
        let target = SinkDestination::File {
            target: SinkTarget::Dyn(target),
        };
        self.run(|lazy| lazy.sink(target, format, UnifiedSinkArgs::default()))?;
        file.finish()?;
        Ok(())
    }

    fn run(
        self,
        sink: impl FnOnce(LazyFrame) -> PolarsResult<LazyFrame>,
    ) -> Result<(), QueryError> {
        let ran = caught(|| sink(self.lazy)?.collect_with_engine(Engine::Streaming));
        let mut broken = self.broken.lock().unwrap_or_else(PoisonError::into_inner);
        match (ran, broken.take()) {
            (_, Some(error)) => Err(error.into()),
            (Err(reason), None) => Err(QueryError::Sql(reason)),
            (Ok(_), None) => Ok(()),
        }
    }
}

/// A cell as text.
fn text(value: AnyValue<'_>) -> String {
    match value {
        AnyValue::Null => String::new(),
        AnyValue::Float64(number) => {
            let mut out = Vec::new();
            push_number(&mut out, number, NumberStyle::Shortest);
            String::from_utf8_lossy(&out).into_owned()
        }
        AnyValue::String(text) => text.to_owned(),
        AnyValue::StringOwned(text) => text.to_string(),
        other => other.to_string(),
    }
}
