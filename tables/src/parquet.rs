//! Parquet by polars: its crate for the format, `polars-parquet`, over its arrays, `polars-arrow`.

mod reader;
mod writer;

pub(crate) use reader::{MAGIC, read};
pub use writer::{ParquetWriter, WriteError};

/// The key of a column's unit in the metadata of a file begins like this.
const UNIT: &str = "unit.";
