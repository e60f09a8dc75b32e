//! Parquet by the crate `parquet` of arrow-rs, over the arrays that frames are made of, too.

mod reader;
mod writer;

pub(crate) use reader::{MAGIC, read};
pub use writer::{ParquetWriter, WriteError};

/// The key of a column's unit in the metadata of a file begins like this.
const UNIT: &str = "unit.";
