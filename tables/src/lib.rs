//! Tables of named columns, in Parquet files and in delimited text.
//!
//! A [`Table`] is a list of [`Column`]s, each with a name, a unit and [`Values`] of one type. It is read whole ([`Table::read`]
//! finds out from the file which of the two formats it is), and columns are then read by name and type:
//!
//! ```
//! use mercury_tables::{Column, Table, Values};
//!
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("profile.parquet");
//! let table = Table::default()
//!     .with(Column::new("z", "m", Values::F64(vec![0.01, 0.02])))
//!     .with(Column::new("count", "1", Values::U64(vec![40, 35])));
//! table.write_parquet(&path)?;
//!
//! let table = Table::read(&path)?;
//! assert_eq!(table.rows(), 2);
//! let heights: Vec<f64> = table.values("z")?;
//! let counts: Vec<f64> = table.values("count")?; // whole numbers are numbers, too
//! assert_eq!(heights[1] * counts[1], 0.02 * 35.0);
//! assert!(table.values::<f64>("density").unwrap_err().to_string().contains("its columns are z, count"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Tables that grow (time series, frames) are written by a [`ParquetWriter`], batch after batch, with the memory of one batch.
//!
//! The feature `query` adds `query`: SQL over tables and frames, by polars.
//!
//! Parquet is read and written by the crate `parquet`, compressed and with statistics. It is long to compile: `common`,
//! `coarse-grain`, `mclump` and the solver never depend on this crate (`docs/decisions/0029-libraries.md`).

mod column;
mod element;
mod parquet;
#[cfg(feature = "query")]
pub mod query;
mod table;
mod text;

pub use column::{Column, Kind, Spec, Values};
pub use element::Element;
pub use parquet::{ParquetWriter, WriteError};
pub use table::Table;
