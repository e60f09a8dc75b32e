//! SQL over the tables of a run.
//!
//! A query is planned and computed by polars, row by row of what it needs: of frames, only the columns that it names and only frames
//! whose time can count are read, some ten thousand rows at a time.

mod answer;
mod frames;

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use mercury_common::error::FormatError;
use mercury_common::frames::FrameReader;
use mercury_common::whole_file::FileError;
use polars::prelude::{
    DataFrame, IntoColumn as _, IntoLazy as _, LazyFrame, NamedFrom as _, PolarsError,
    PolarsResult, Series,
};
use polars::sql::{SQLContext, extract_table_identifiers};

use crate::{Table, Values};
pub use answer::{Answer, Format, Rows};
use frames::Frames;
pub use frames::Labels;

/// Why a query has no answer.
#[derive(Debug, thiserror::Error)]
pub enum QueryError {
    /// The query cannot be understood, or names a missing column.
    #[error("{0}")]
    Sql(String),
    /// A table cannot be read.
    #[error(transparent)]
    Table(Box<FormatError>),
    /// The answer cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
}

impl From<FormatError> for QueryError {
    fn from(error: FormatError) -> Self {
        Self::Table(Box::new(error))
    }
}

impl Table {
    /// The table as polars has it. Numbers that are NaN are missing there, as they are in files.
    ///
    /// # Errors
    /// When columns have the same name or unequal lengths.
    pub fn into_data_frame(self) -> PolarsResult<DataFrame> {
        let rows = self.rows();
        let columns = self.columns.into_iter().map(|column| {
            let name = column.name.into();
            match column.values {
                Values::F64(values) => {
                    let there = |value: f64| (!value.is_nan()).then_some(value);
                    Series::new(name, values.into_iter().map(there).collect::<Vec<_>>())
                }
                Values::I32(values) => Series::new(name, values),
                Values::I64(values) => Series::new(name, values),
                // Polars as it is built here has no smaller type.
                Values::U8(values) => {
                    Series::new(name, values.into_iter().map(u32::from).collect::<Vec<_>>())
                }
                Values::U32(values) => Series::new(name, values),
                Values::OptionalU32(values) => Series::new(name, values),
                Values::U64(values) => Series::new(name, values),
                Values::Bool(values) => Series::new(name, values),
                Values::Text(values) => Series::new(name, values),
            }
            .into_column()
        });
        DataFrame::new(rows, columns.collect())
    }
}

/// The source of a table.
#[derive(Debug)]
pub enum Relation {
    /// Delimited text with a header, read whole when a query names it.
    Text(PathBuf),
    /// Frames, which stay on the disk: the columns `time`, `step` and `frame` (the number of the frame, from 0), and those of the
    /// file, indices as the names that they stand for.
    Frames(Box<FrameReader>, Labels),
}

/// Tables that a query can name.
///
/// ```
/// use mercury_tables::query::{Database, Relation};
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("drum.walls.csv");
/// std::fs::write(&path, "time [s],name,fz [N]\n0.1,lid,-2\n0.2,lid,-4\n")?;
/// let mut tables = Database::default();
/// tables.add("walls", Relation::Text(path));
/// let answer = tables.query("SELECT name, AVG(fz) AS mean FROM walls GROUP BY name")?;
/// let rows = answer.first_rows(10)?;
/// assert_eq!(rows.columns, ["name", "mean"]);
/// assert_eq!(rows.cells, [["lid", "-3"]]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Default)]
pub struct Database {
    relations: BTreeMap<String, Relation>,
}

/// The first error in reading frames; polars passes on its message only.
type Broken = Arc<Mutex<Option<FormatError>>>;

/// A table that a query names.
enum Source {
    Whole(DataFrame),
    Frames(Arc<Frames>),
}

impl Database {
    /// Adds a table, in place of another one of this name.
    pub fn add(&mut self, name: impl Into<String>, relation: Relation) {
        self.relations.insert(name.into(), relation);
    }

    /// The names of the tables, in alphabetical order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.relations.keys().map(String::as_str)
    }

    /// Plans a query: one statement of [SQL as polars has it](https://docs.pola.rs/user-guide/sql/intro/). Of frames nothing but
    /// the heads is read yet.
    ///
    /// # Errors
    /// When the statement cannot be understood, or a table or column is not there, which the message then names; when a table of text
    /// cannot be read.
    pub fn query(self, sql: &str) -> Result<Answer, QueryError> {
        let all: Vec<String> = self.relations.keys().cloned().collect();
        let mut help = format!("help: the tables are {}", all.join(", "));
        let named = extract_table_identifiers(sql, false, true);
        let named = named.map_err(|error| QueryError::Sql(format!("{}\n{help}", words(&error))))?;
        // polars would read these files by itself, without a limit on what they claim to hold.
        if let Some(name) = named.iter().find(|name| is_reader(name)) {
            return Err(QueryError::Sql(format!(
                "`{name}`: a query reads the tables of a run, not files\n{help}"
            )));
        }
        let (mut tables, mut damage) = (Vec::new(), Vec::new());
        for (name, relation) in self.relations {
            if !named.contains(&name) {
                continue;
            }
            let (columns, source) = match relation {
                Relation::Text(path) => {
                    let table = Table::read_text(&path)?.typed().into_data_frame();
                    let table = table.map_err(|error| QueryError::Sql(words(&error)))?;
                    let names = table.columns().iter();
                    let names: Vec<&str> = names.map(|column| column.name().as_str()).collect();
                    (names.join(", "), Source::Whole(table))
                }
                Relation::Frames(reader, labels) => {
                    damage.extend(reader.damage().cloned());
                    let frames = Frames::new(*reader, labels);
                    (frames.names().join(", "), Source::Frames(Arc::new(frames)))
                }
            };
            help += &format!("\n      the columns of {name} are {columns}");
            tables.push((name, source));
        }
        let broken = Broken::default();
        let (lazy, columns) = caught(|| plan(sql, &tables, &broken))
            .map_err(|reason| QueryError::Sql(format!("{reason}\n{help}")))?;
        Ok(Answer {
            columns,
            damage,
            lazy,
            broken,
        })
    }
}

/// The plan of a query and the names of its columns. It is planned twice: first over scans whose filters show which frames can count.
fn plan(
    sql: &str,
    tables: &[(String, Source)],
    broken: &Broken,
) -> PolarsResult<(LazyFrame, Vec<String>)> {
    let over = |frames: &dyn Fn(&Arc<Frames>) -> PolarsResult<LazyFrame>| {
        let mut context = SQLContext::new();
        for (name, source) in tables {
            let table = match source {
                Source::Whole(table) => table.clone().lazy(),
                Source::Frames(table) => frames(table)?,
            };
            context.register(name, table);
        }
        context.execute(sql)
    };
    let filters = frames::filters(over(&Frames::to_be_filtered)?)?;
    let mut lazy = over(&|table| table.lazy(table.that_can_count(&filters), broken))?;
    let schema = lazy.collect_schema()?;
    Ok((lazy, schema.iter_names().map(ToString::to_string).collect()))
}

/// Runs what may panic in polars; the error in words.
fn caught<T>(run: impl FnOnce() -> PolarsResult<T>) -> Result<T, String> {
    match catch_unwind(AssertUnwindSafe(run)) {
        Ok(result) => result.map_err(|error| words(&error)),
        Err(_) => Err("polars cannot compute this query".to_owned()),
    }
}

/// The first line of an error of polars: plans follow.
fn words(error: &PolarsError) -> String {
    let text = error.to_string();
    text.lines().next().unwrap_or_default().trim().to_owned()
}

/// Whether a table is a function of polars that reads a file.
fn is_reader(name: &str) -> bool {
    name.to_lowercase().starts_with("read_")
}
