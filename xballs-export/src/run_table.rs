//! Tables of a run that lie beside its frames as text (`.walls.csv`, ...): as a whole, with one head, or typed as Parquet.

use std::path::PathBuf;

use mercury_common::formats::delimited::push_line;
use mercury_common::formats::table_head;
use mercury_common::run_tables::TableSpec;
use mercury_tables::Table;

use crate::output::Output;
use crate::{ExportError, Selection, Source};

/// The format of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Text with commas.
    Csv,
    /// Parquet, in which columns of numbers are numbers.
    Parquet,
}

impl Format {
    fn ending(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Parquet => "parquet",
        }
    }
}

/// Writes a table of a run; returns the path and the number of rows.
///
/// # Errors
/// When the run has no such table, it cannot be read, single frames or particles are selected, or the file cannot be written.
pub fn export(
    source: &Source,
    table: &TableSpec,
    selection: &Selection,
    output: &Output,
    format: Format,
) -> Result<(PathBuf, usize), ExportError> {
    let name = table.name();
    if selection.is_partial() || selection.frames != crate::FrameChoice::All {
        return Err(ExportError::Input(format!(
            "--table {name}: --frames, --region and --material select of tables of frames; this one is written as a whole\nhelp: leave them out, or filter its column `time`"
        )));
    }
    let path = source
        .folder()
        .join(format!("{}.{}", source.prefix(), table.file));
    if !path.exists() {
        return Err(ExportError::Input(format!(
            "{}: there is no such table\nhelp: {} makes a run write it",
            path.display(),
            table.from
        )));
    }
    let read = Table::read_text(&path)?;
    let rows = read.rows();
    let file = output.one(&format!("{name}.{}", format.ending()));
    match format {
        Format::Csv => output.write(&file, &text(&read)?)?,
        Format::Parquet => {
            output.claim(&file)?;
            read.typed().write_parquet(&file)?;
        }
    }
    Ok((file, rows))
}

/// The table as text.
fn text(table: &Table) -> Result<Vec<u8>, ExportError> {
    let columns = table.columns();
    let cells: Vec<Vec<String>> = (columns.iter())
        .map(|column| table.values(&column.name))
        .collect::<Result<_, _>>()?;
    let head = table_head::line(columns.iter().map(|column| (&column.name, &column.unit)));
    let mut out = head.into_bytes();
    for row in 0..table.rows() {
        push_line(&mut out, cells.iter().map(|column| &column[row]));
    }
    Ok(out)
}
