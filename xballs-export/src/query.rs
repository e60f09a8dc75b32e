//! The tables that SQL can name in a run or a study.

use std::path::{Path, PathBuf};

use mercury_common::error::FormatError;
use mercury_common::frames::{BondNames, FrameReader, FramesHeader};
use mercury_common::readable::counted;
use mercury_common::run_files::{FRAMES, particles_in};
use mercury_tables::query::{Database, Format, Relation, Rows};

use crate::output::ending_of_file;
use crate::{ExportError, study_table};

/// Tables of frames, which a query reads part by part.
const TABLES: [&str; 5] = ["particles", "contacts", "bonds", "bodies", "wear_triangles"];

/// The tables of a run folder or of its `.particles.arrow`, and of a study.
///
/// Frames are `particles`, `contacts`, `bonds`, `bodies` and `wear_triangles`, materials, walls and kinds of bonds by name; tables of text have the name of
/// their file without that of the run, dots as underscores: `walls`, `flux`, `fields_mean`; the table of a study is `study`.
///
/// # Errors
/// When there is neither a run nor a study, or its frames cannot be opened.
pub fn tables_in(input: &Path) -> Result<Database, ExportError> {
    let mut tables = Database::default();
    if let Some(path) = study_table::table_in(input) {
        tables.add("study", Relation::Text(path));
        return Ok(tables);
    }
    let particles = match input.is_dir() {
        true => particles_in(input)?,
        false => input.to_owned(),
    };
    let file = particles.file_name().unwrap_or_default().to_string_lossy();
    let Some(prefix) = file.strip_suffix(FRAMES) else {
        let mut error = FormatError::of_file(&particles, "no native frames");
        error.expected = "a folder of mercury-solve or its .particles.arrow".to_owned();
        return Err(error.into());
    };
    for (name, path) in texts_of(&particles, prefix)? {
        tables.add(name, Relation::Text(path));
    }
    for name in TABLES {
        let path = particles.with_file_name(format!("{prefix}.{name}.arrow"));
        if path.exists() {
            let reader = Box::new(FrameReader::open(&path)?);
            let header = FramesHeader::of(reader.schema()).map_err(|[found, expected]| {
                let mut error = FormatError::of_file(&path, found);
                error.expected = expected;
                error
            })?;
            let bonds = BondNames::of(reader.schema());
            let labels = vec![
                ("bond".to_owned(), bonds.0),
                ("material".to_owned(), header.materials),
                ("wall".to_owned(), header.walls),
            ];
            tables.add(name, Relation::Frames(reader, labels));
        }
    }
    Ok(tables)
}

/// Names and files of the tables that a run wrote as text.
fn texts_of(particles: &Path, prefix: &str) -> Result<Vec<(String, PathBuf)>, ExportError> {
    let folder = match particles.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let unreadable = |error: std::io::Error| {
        FormatError::of_file(folder, format!("the folder cannot be read: {error}"))
    };
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        let file = path.file_name().unwrap_or_default().to_string_lossy();
        let name = (file.strip_prefix(prefix))
            .and_then(|rest| rest.strip_prefix('.'))
            .and_then(|rest| rest.strip_suffix(".csv"));
        if let Some(name) = name {
            found.push((name.replace('.', "_"), path.clone()));
        }
    }
    Ok(found)
}

/// The format that the name of a file stands for.
///
/// # Errors
/// When it stands for none that answers can have.
pub fn format_of(path: &Path) -> Result<Format, ExportError> {
    match ending_of_file(path).as_deref() {
        Some("csv") => Ok(Format::Csv),
        Some("parquet") => Ok(Format::Parquet),
        Some("arrow") => Ok(Format::Arrow),
        _ => Err(ExportError::Input(format!(
            "{}: the answer to a query is a file that ends in .csv, .parquet or .arrow",
            path.display()
        ))),
    }
}

/// Rows as text in columns, and how many are left out.
#[must_use]
pub fn printed(rows: &Rows) -> String {
    let widths: Vec<usize> = (rows.columns.iter().enumerate())
        .map(|(k, name)| {
            let cells = rows.cells.iter().map(|row| row[k].chars().count());
            cells.max().unwrap_or(0).max(name.chars().count())
        })
        .collect();
    let mut out = String::new();
    for row in std::iter::once(&rows.columns).chain(&rows.cells) {
        let mut line = String::new();
        for (cell, width) in row.iter().zip(&widths) {
            line += &format!("{cell:<width$}  ");
        }
        out += line.trim_end();
        out.push('\n');
    }
    let left = rows.total - rows.cells.len();
    if left > 0 {
        out += &format!("... {} more; -o FILE.csv takes all\n", counted(left, "row"));
    }
    out
}
