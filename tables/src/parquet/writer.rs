//! Writing batch after batch.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow_array::{
    ArrayRef, BooleanArray, Float64Array, Int32Array, Int64Array, LargeStringArray, UInt8Array,
    UInt32Array, UInt64Array,
};
use arrow_schema::{DataType, Field, Schema, SchemaRef};
use mercury_common::whole_file::{FileError, WholeFile};
use parquet::arrow::arrow_writer::{
    ArrowColumnChunk, ArrowRowGroupWriterFactory, ArrowWriter, ArrowWriterOptions, compute_leaves,
};
use parquet::basic::{Compression, ZstdLevel};
use parquet::errors::Result as ParquetResult;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::ColumnPath;
use rayon::prelude::*;

use super::UNIT;
use crate::column::{Kind, Spec, Values};

/// Why a table was not written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The columns do not make a table.
    #[error("{}: {reason}", path.display())]
    Columns {
        /// The file.
        path: PathBuf,
        /// Description of the mismatch.
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
    schema: SchemaRef,
    writer: SerializedFileWriter<BufWriter<File>>,
    encoders: ArrowRowGroupWriterFactory,
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
        let fields: Vec<Field> = specs.iter().map(field).collect();
        let schema = Arc::new(Schema::new(fields));
        let units = specs.iter().filter(|spec| !spec.unit.is_empty());
        let units = units.map(|spec| (format!("{UNIT}{}", spec.name), spec.unit.clone()));
        let metadata = units.chain(metadata.iter().cloned());
        let metadata = metadata.map(|(key, value)| KeyValue::new(key, value));
        let file = WholeFile::create(path)?;
        let options = ArrowWriterOptions::new()
            .with_properties(properties(&specs, metadata.collect()))
            // Otherwise readers would take the types of Arrow for those of the file.
            .with_skip_arrow_metadata(true);
        let writer =
            ArrowWriter::try_new_with_options(file.writer()?, Arc::clone(&schema), options)
                .and_then(ArrowWriter::into_serialized_writer);
        let (writer, encoders) = writer.map_err(|error| unwritable(path, &error))?;
        Ok(Self {
            file,
            specs,
            schema,
            writer,
            encoders,
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
        let written = self.write_group(values);
        written.map_err(|error| unwritable(self.file.path(), &error))
    }

    fn write_group(&mut self, values: Vec<Values>) -> ParquetResult<()> {
        let number = self.writer.flushed_row_groups().len();
        let encoders = self.encoders.create_column_writers(number)?;
        let fields = self.schema.fields();
        let chunks: ParquetResult<Vec<ArrowColumnChunk>> = (values.into_par_iter())
            .zip(encoders)
            .zip(fields.par_iter())
            .map(|((values, mut encoder), field)| {
                for leaf in compute_leaves(field, &array(values))? {
                    encoder.write(&leaf)?;
                }
                encoder.close()
            })
            .collect();
        let mut group = self.writer.next_row_group()?;
        for chunk in chunks? {
            chunk.append_to_row_group(&mut group)?;
        }
        group.close()?;
        Ok(())
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
        let Self { file, writer, .. } = self;
        // The end flushes the buffer.
        let ended = writer.close();
        ended.map_err(|error| unwritable(file.path(), &error))?;
        file.finish()?;
        Ok(())
    }
}

/// How a file is written: the first version of the format, which all readers know. Numbers seldom repeat, so only text has a
/// dictionary.
fn properties(specs: &[Spec], metadata: Vec<KeyValue>) -> WriterProperties {
    let by = concat!("mercury-tables version ", env!("CARGO_PKG_VERSION"));
    // The default level of zstd.
    let level = ZstdLevel::try_new(3).unwrap_or_default();
    let properties = WriterProperties::builder()
        .set_created_by(by.to_owned())
        .set_compression(Compression::ZSTD(level))
        .set_dictionary_enabled(false)
        .set_statistics_enabled(EnabledStatistics::Chunk)
        .set_offset_index_disabled(true)
        .set_key_value_metadata(Some(metadata));
    let texts = specs.iter().filter(|spec| spec.kind == Kind::Text);
    let properties = texts.fold(properties, |properties, spec| {
        properties.set_column_dictionary_enabled(ColumnPath::new(vec![spec.name.clone()]), true)
    });
    properties.build()
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
        Kind::F64 => DataType::Float64,
        Kind::I32 => DataType::Int32,
        Kind::I64 => DataType::Int64,
        Kind::U8 => DataType::UInt8,
        Kind::U32 | Kind::OptionalU32 => DataType::UInt32,
        Kind::U64 => DataType::UInt64,
        Kind::Bool => DataType::Boolean,
        Kind::Text => DataType::LargeUtf8,
    };
    let optional = spec.kind == Kind::OptionalU32;
    Field::new(&spec.name, kind, optional)
}

fn array(values: Values) -> ArrayRef {
    match values {
        Values::F64(v) => Arc::new(Float64Array::from(v)),
        Values::I32(v) => Arc::new(Int32Array::from(v)),
        Values::I64(v) => Arc::new(Int64Array::from(v)),
        Values::U8(v) => Arc::new(UInt8Array::from(v)),
        Values::U32(v) => Arc::new(UInt32Array::from(v)),
        Values::OptionalU32(v) => Arc::new(UInt32Array::from(v)),
        Values::U64(v) => Arc::new(UInt64Array::from(v)),
        Values::Bool(v) => Arc::new(BooleanArray::from(v)),
        Values::Text(v) => Arc::new(LargeStringArray::from(v)),
    }
}
