//! The files that are written: those of the library, and Parquet, which is long to compile and therefore the program's alone.

use std::path::{Path, PathBuf};

use mercury_cg::CgError;
use mercury_cg::analysis::{Analysis, Block};
use mercury_cg::output::{Format, Succession, Writer, about, csv};
use mercury_tables::{Kind, ParquetWriter, Spec, Values, WriteError};

/// Rows of a table that are put together before they are written: many small groups of rows make long and slow files.
const GROUP: usize = 1 << 16;

/// Whether the name ends as that of a Parquet file.
pub(crate) fn is_parquet(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending == "parquet")
}

/// A file, or a series of files, of blocks.
pub(crate) enum Output {
    Plain(Box<Writer>),
    Parquet(Box<ParquetTable>),
}

impl Output {
    pub(crate) fn new(
        path: &Path,
        succession: Succession,
        follow: bool,
        compat: bool,
        force: bool,
    ) -> Result<Self, CgError> {
        if !is_parquet(path) {
            Format::of(path).map_err(|_| {
                CgError::Input(format!(
                    "{}: the name must end in .csv, .parquet, .stat, .vti, .svg or .png",
                    path.display()
                ))
            })?;
            let writer = Writer::new(path, succession, follow, compat, force)?;
            return Ok(Self::Plain(Box::new(writer)));
        }
        if follow {
            let found = format!(
                "{}: --follow: a Parquet file cannot be read before it is complete",
                path.display()
            );
            return Err(CgError::Input(format!("{found}\nhelp: -o NAME.csv")));
        }
        if path.exists() && !force {
            return Err(CgError::Exists(path.to_owned()));
        }
        Ok(Self::Parquet(Box::new(ParquetTable {
            path: path.to_owned(),
            timed: succession == Succession::Series,
            writer: None,
            waiting: Vec::new(),
            blocks: 0,
        })))
    }

    pub(crate) fn write(&mut self, analysis: &Analysis, block: &Block) -> Result<(), CgError> {
        match self {
            Self::Plain(writer) => writer.write(analysis, block),
            Self::Parquet(table) => table.write(analysis, block),
        }
    }

    /// Puts the file in its place; returns its name and the number of blocks.
    pub(crate) fn finish(self) -> Result<(PathBuf, usize), CgError> {
        match self {
            Self::Plain(writer) => writer.finish(),
            Self::Parquet(table) => table.finish(),
        }
    }
}

/// A table of the columns that a `.csv` has.
pub(crate) struct ParquetTable {
    path: PathBuf,
    timed: bool,
    writer: Option<ParquetWriter>,
    /// Columns of rows that are not written yet.
    waiting: Vec<Vec<f64>>,
    blocks: usize,
}

fn failed(error: WriteError) -> CgError {
    CgError::Table(Box::new(error))
}

impl ParquetTable {
    fn write(&mut self, analysis: &Analysis, block: &Block) -> Result<(), CgError> {
        let evaluator = &analysis.evaluator;
        if self.writer.is_none() {
            let columns = csv::columns(evaluator, block, self.timed);
            self.waiting = vec![Vec::new(); columns.len()];
            let specs = columns
                .into_iter()
                .map(|(name, unit)| Spec::new(name, unit, Kind::F64));
            let origin = about(analysis, block, self.timed);
            let origin = origin.trim_start_matches("# ").trim_end().to_owned();
            let writer = ParquetWriter::create(
                &self.path,
                specs.collect(),
                &[("origin".to_owned(), origin)],
            );
            self.writer = Some(writer.map_err(failed)?);
        }
        let points = evaluator.place.len();
        let mut columns = self.waiting.iter_mut();
        let mut push = |values: &mut dyn Iterator<Item = f64>| {
            if let Some(column) = columns.next() {
                column.extend(values);
            }
        };
        if self.timed {
            push(&mut std::iter::repeat_n(block.time, points));
        }
        for axis in 0..evaluator.coordinates.names().len() {
            push(&mut (0..points).map(|point| evaluator.place.coordinates(point)[axis]));
        }
        for column in &block.columns {
            push(&mut column.values.iter().copied());
            if let Some(errors) = &column.errors {
                push(&mut errors.iter().copied());
            }
        }
        self.blocks += 1;
        if self.waiting.first().is_some_and(|rows| rows.len() >= GROUP) {
            self.flush()?;
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<(), CgError> {
        if let Some(writer) = &mut self.writer {
            let columns = self.waiting.iter_mut().map(std::mem::take);
            writer
                .write(columns.map(Values::F64).collect())
                .map_err(failed)?;
        }
        Ok(())
    }

    fn finish(mut self) -> Result<(PathBuf, usize), CgError> {
        self.flush()?;
        if let Some(writer) = self.writer.take() {
            writer.finish().map_err(failed)?;
        }
        Ok((self.path, self.blocks))
    }
}
