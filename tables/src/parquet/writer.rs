//! Writing batch after batch.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use mercury_common::whole_file::{FileError, WholeFile};
use polars_arrow::array::{Array, BooleanArray, PrimitiveArray, Utf8Array};
use polars_arrow::datatypes::{ArrowDataType, ArrowSchema, Field};
use polars_error::{PolarsError, PolarsResult};
use polars_parquet::parquet::error::ParquetError;
use polars_parquet::parquet::write::{FileWriter, WriteOptions as FileOptions};
use polars_parquet::write::{
    CompressedPage, CompressionOptions, DynIter, DynStreamingIterator, Encoding, KeyValue,
    ParquetType, StatisticsOptions, Version, WriteOptions, array_to_columns, compress,
    fallible_streaming_iterator, to_parquet_schema,
};
use rayon::prelude::*;

use super::UNIT;
use crate::column::{Kind, Spec, Values};

/// How pages are written: the first version of the format, which all readers know.
const OPTIONS: WriteOptions = WriteOptions {
    statistics: StatisticsOptions {
        min_value: true,
        max_value: true,
        distinct_count: false,
        null_count: true,
        binary_statistics_truncate_length: None,
    },
    version: Version::V1,
    compression: CompressionOptions::Zstd(None),
    data_page_size: None,
};

/// Why a table was not written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The columns do not make a table.
    #[error("{}: {reason}", path.display())]
    Columns {
        /// The file.
        path: PathBuf,
        /// What is wrong with them.
        reason: String,
    },
    /// The operating system refused.
    #[error(transparent)]
    File(#[from] FileError),
}

/// A Parquet file that grows batch by batch, with the memory of one batch, and gets its name when it is finished. Dropped
/// before, it leaves nothing behind.
///
/// ```
/// use mercury_tables::{Kind, ParquetWriter, Spec, Table, Values};
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("energies.parquet");
/// let specs = vec![Spec::new("time", "s", Kind::F64), Spec::new("kinetic", "J", Kind::F64)];
/// let mut writer = ParquetWriter::create(&path, specs, &[])?;
/// for frame in 0..3 {
///     let time = 0.1 * f64::from(frame);
///     writer.write(vec![Values::F64(vec![time]), Values::F64(vec![2.0 * time])])?;
/// }
/// writer.finish()?;
/// assert_eq!(Table::read(&path)?.rows(), 3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct ParquetWriter {
    file: WholeFile,
    specs: Vec<Spec>,
    types: Vec<ParquetType>,
    metadata: Vec<KeyValue>,
    writer: FileWriter<BufWriter<File>>,
}

impl std::fmt::Debug for ParquetWriter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut out = f.debug_struct("ParquetWriter");
        out.field("path", &self.file.path()).finish_non_exhaustive()
    }
}

impl ParquetWriter {
    /// Begins a file with these columns. Units go to its metadata as `unit.COLUMN`, beside the entries of `metadata`.
    ///
    /// # Errors
    /// When two columns have the same name, or the file cannot be made.
    pub fn create(
        path: &Path,
        specs: Vec<Spec>,
        metadata: &[(String, String)],
    ) -> Result<Self, WriteError> {
        for (k, spec) in specs.iter().enumerate() {
            if specs[..k].iter().any(|other| other.name == spec.name) {
                let reason = format!("two columns are called `{}`", spec.name);
                return Err(columns(path, reason));
            }
        }
        let fields = specs.iter().map(field);
        let schema: ArrowSchema = fields.map(|field| (field.name.clone(), field)).collect();
        let schema = to_parquet_schema(&schema).map_err(|error| unwritable(path, &error))?;
        let units = specs.iter().filter(|spec| !spec.unit.is_empty());
        let units = units.map(|spec| (format!("{UNIT}{}", spec.name), spec.unit.clone()));
        let metadata = units.chain(metadata.iter().cloned());
        let metadata = metadata.map(|(key, value)| KeyValue {
            key,
            value: Some(value),
        });
        let file = WholeFile::create(path)?;
        let options = FileOptions {
            write_statistics: true,
            version: OPTIONS.version,
        };
        let by = concat!("mercury-tables version ", env!("CARGO_PKG_VERSION"));
        Ok(Self {
            types: schema.fields().to_vec(),
            metadata: metadata.collect(),
            writer: FileWriter::new(file.writer()?, schema, options, Some(by.to_owned())),
            specs,
            file,
        })
    }

    /// Appends rows as a row group of their own; none leave no trace. Batches of less than some thousand rows make files
    /// that are long and slow to read. Columns are compressed on all threads, to the same bytes on any number of them.
    ///
    /// # Errors
    /// When there are more or fewer columns than announced, one is of another type or length, or the file cannot be written.
    pub fn write(&mut self, values: Vec<Values>) -> Result<(), WriteError> {
        let path = self.file.path();
        self.check(&values)
            .map_err(|reason| columns(path, reason))?;
        let rows = values.first().map_or(0, Values::len);
        if rows == 0 {
            return Ok(());
        }
        let pages: PolarsResult<Vec<Vec<CompressedPage>>> = values
            .into_par_iter()
            .zip(&self.types)
            .map(|(values, kind)| pages(values, kind))
            .collect();
        let pages = pages.map_err(|error| unwritable(path, &error))?;
        let group = DynIter::new(pages.iter().map(|pages| {
            let pages = pages.iter().map(Ok::<_, PolarsError>);
            Ok(DynStreamingIterator::new(
                fallible_streaming_iterator::convert(pages),
            ))
        }));
        let written = self.writer.write(rows as u64, group);
        written.map_err(|error| unwritable(path, &error))
    }

    fn check(&self, values: &[Values]) -> Result<(), String> {
        if values.len() != self.specs.len() {
            let (found, expected) = (values.len(), self.specs.len());
            return Err(format!("{found} columns, expected {expected}"));
        }
        for (spec, column) in self.specs.iter().zip(values) {
            let (name, found) = (&spec.name, column.kind());
            if found != spec.kind {
                return Err(format!(
                    "column `{name}` is {found:?}, expected {:?}",
                    spec.kind
                ));
            }
            let (found, expected) = (column.len(), values[0].len());
            if found != expected {
                let first = &self.specs[0].name;
                return Err(format!(
                    "column `{name}` has {found} rows, expected {expected} as in `{first}`"
                ));
            }
        }
        Ok(())
    }

    /// Completes the file, hands it to the disk and gives it its name.
    ///
    /// # Errors
    /// When it cannot be written; a file that was there before is still there then.
    pub fn finish(self) -> Result<(), WriteError> {
        let Self {
            file,
            metadata,
            mut writer,
            ..
        } = self;
        // The end flushes the buffer.
        let ended = writer.end(Some(metadata));
        ended.map_err(|error| unwritable(file.path(), &error))?;
        drop(writer);
        file.finish()?;
        Ok(())
    }
}

fn columns(path: &Path, reason: String) -> WriteError {
    let path = path.to_owned();
    WriteError::Columns { path, reason }
}

fn unwritable(path: &Path, error: &impl std::fmt::Display) -> WriteError {
    let source = std::io::Error::other(error.to_string());
    FileError::of(path, "the file cannot be written")(source).into()
}

fn field(spec: &Spec) -> Field {
    let kind = match spec.kind {
        Kind::F64 => ArrowDataType::Float64,
        Kind::I32 => ArrowDataType::Int32,
        Kind::I64 => ArrowDataType::Int64,
        Kind::U8 => ArrowDataType::UInt8,
        Kind::U32 | Kind::OptionalU32 => ArrowDataType::UInt32,
        Kind::U64 => ArrowDataType::UInt64,
        Kind::Bool => ArrowDataType::Boolean,
        Kind::Text => ArrowDataType::LargeUtf8,
    };
    let optional = spec.kind == Kind::OptionalU32;
    Field::new(spec.name.as_str().into(), kind, optional)
}

/// The pages of a column, compressed.
fn pages(values: Values, kind: &ParquetType) -> PolarsResult<Vec<CompressedPage>> {
    // Numbers seldom repeat, and a dictionary of them would take zeros of both signs, or all NaN, for the same.
    let encoding = match values.kind() {
        Kind::Text => Encoding::RleDictionary,
        _ => Encoding::Plain,
    };
    let array: Box<dyn Array> = match values {
        Values::F64(v) => PrimitiveArray::from_vec(v).boxed(),
        Values::I32(v) => PrimitiveArray::from_vec(v).boxed(),
        Values::I64(v) => PrimitiveArray::from_vec(v).boxed(),
        Values::U8(v) => PrimitiveArray::from_vec(v).boxed(),
        Values::U32(v) => PrimitiveArray::from_vec(v).boxed(),
        Values::OptionalU32(v) => PrimitiveArray::<u32>::from(v).boxed(),
        Values::U64(v) => PrimitiveArray::from_vec(v).boxed(),
        Values::Bool(v) => BooleanArray::from_slice(v).boxed(),
        Values::Text(v) => Utf8Array::<i64>::from_slice(v).boxed(),
    };
    let mut compressed = Vec::new();
    for pages in array_to_columns(array, kind.clone(), OPTIONS, &[encoding])? {
        for page in pages {
            let page = compress(page?, Vec::new(), OPTIONS.compression);
            compressed.push(page.map_err(|error: ParquetError| PolarsError::from(error))?);
        }
    }
    Ok(compressed)
}
