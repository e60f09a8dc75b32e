//! Parquet by polars.

use std::fs::File;
use std::io::{BufWriter, Read, Seek as _, SeekFrom};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use mercury_common::error::FormatError;
use mercury_common::whole_file::{FileError, WholeFile};
use polars_core::frame::column::Column as PolarsColumn;
use polars_core::prelude::{
    ArrowDataType, BooleanChunked, ChunkedArray, DataFrame, DataType, Float64Type, Int32Type,
    Int64Type, IntoColumn as _, IntoSeries as _, NewChunkedArray as _, PlSmallStr, PolarsError,
    PolarsNumericType, PolarsResult, Schema, Series, StringChunked, UInt8Type, UInt32Type,
    UInt64Type,
};
use polars_io::SerReader as _;
use polars_io::parquet::read::ParquetReader;
use polars_io::parquet::write::{
    BatchedWriter, KeyValueMetadata, ParquetCompression, ParquetWriter as PolarsWriter,
    StatisticsOptions,
};

use crate::column::{Column, Kind, Spec, Values};
use crate::table::{Origin, Table, unreadable};

/// How a Parquet file begins and ends.
pub(crate) const MAGIC: &[u8] = b"PAR1";
/// The key of a column's unit in the metadata begins like this.
const UNIT: &str = "unit.";
/// Where programs that know Arrow note its types; it is written by the library.
const ARROW_SCHEMA: &str = "ARROW:schema";

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
    writer: BatchedWriter<BufWriter<File>>,
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
        let file = WholeFile::create(path)?;
        let units = specs.iter().filter(|spec| !spec.unit.is_empty());
        let units = units.map(|spec| (format!("{UNIT}{}", spec.name), spec.unit.clone()));
        let metadata = units.chain(metadata.iter().cloned()).collect();
        let schema: Schema = specs
            .iter()
            .map(|spec| (PlSmallStr::from_str(&spec.name), data_type(spec.kind)))
            .collect();
        let writer = PolarsWriter::new(file.writer()?)
            .with_compression(ParquetCompression::Zstd(None))
            .with_statistics(StatisticsOptions::default())
            .with_key_value_metadata(Some(KeyValueMetadata::from_static(metadata)))
            .batched(&schema);
        Ok(Self {
            writer: writer.map_err(|error| unwritable(path, error))?,
            specs,
            file,
        })
    }

    /// Appends rows as a row group of their own; none leave no trace. Batches of less than some thousand rows make files
    /// that are long and slow to read.
    ///
    /// # Errors
    /// When there are more or fewer columns than announced, one is of another type or length, or the file cannot be written.
    pub fn write(&mut self, values: Vec<Values>) -> Result<(), WriteError> {
        let path = self.file.path();
        if values.len() != self.specs.len() {
            let reason = format!("{} columns, expected {}", values.len(), self.specs.len());
            return Err(columns(path, reason));
        }
        let rows = values.first().map_or(0, Values::len);
        for (spec, values) in self.specs.iter().zip(&values) {
            let (name, found) = (&spec.name, values.kind());
            if found != spec.kind {
                let reason = format!("column `{name}` is {found:?}, expected {:?}", spec.kind);
                return Err(columns(path, reason));
            }
            if values.len() != rows {
                let reason = format!(
                    "column `{name}` has {} rows, expected {rows} as in `{}`",
                    values.len(),
                    self.specs[0].name
                );
                return Err(columns(path, reason));
            }
        }
        if rows == 0 {
            return Ok(());
        }
        let named = self.specs.iter().zip(values);
        let batch = named.map(|(spec, values)| to_polars(&spec.name, values));
        DataFrame::new(rows, batch.collect())
            .and_then(|batch| self.writer.write_batch(&batch))
            .map_err(|error| unwritable(path, error))
    }

    /// Completes the file, hands it to the disk and gives it its name.
    ///
    /// # Errors
    /// When it cannot be written; a file that was there before is still there then.
    pub fn finish(self) -> Result<(), WriteError> {
        let Self { file, writer, .. } = self;
        let finished = writer.finish();
        finished.map_err(|error| unwritable(file.path(), error))?;
        drop(writer);
        file.finish()?;
        Ok(())
    }
}

fn columns(path: &Path, reason: String) -> WriteError {
    let path = path.to_owned();
    WriteError::Columns { path, reason }
}

fn unwritable(path: &Path, error: PolarsError) -> WriteError {
    let source = match error {
        PolarsError::IO { error, .. } => std::io::Error::new(error.kind(), error.to_string()),
        other => std::io::Error::other(other.to_string()),
    };
    FileError::of(path, "the file cannot be written")(source).into()
}

fn data_type(kind: Kind) -> DataType {
    match kind {
        Kind::F64 => DataType::Float64,
        Kind::I32 => DataType::Int32,
        Kind::I64 => DataType::Int64,
        Kind::U8 => DataType::UInt8,
        Kind::U32 | Kind::OptionalU32 => DataType::UInt32,
        Kind::U64 => DataType::UInt64,
        Kind::Bool => DataType::Boolean,
        Kind::Text => DataType::String,
    }
}

fn to_polars(name: &str, values: Values) -> PolarsColumn {
    fn numbers<T: PolarsNumericType>(name: PlSmallStr, values: Vec<T::Native>) -> PolarsColumn
    where
        ChunkedArray<T>: polars_core::prelude::IntoSeries,
    {
        ChunkedArray::<T>::from_vec(name, values)
            .into_series()
            .into_column()
    }
    let name = PlSmallStr::from_str(name);
    match values {
        Values::F64(v) => numbers::<Float64Type>(name, v),
        Values::I32(v) => numbers::<Int32Type>(name, v),
        Values::I64(v) => numbers::<Int64Type>(name, v),
        Values::U8(v) => numbers::<UInt8Type>(name, v),
        Values::U32(v) => numbers::<UInt32Type>(name, v),
        Values::U64(v) => numbers::<UInt64Type>(name, v),
        Values::OptionalU32(v) => ChunkedArray::<UInt32Type>::from_slice_options(name, &v)
            .into_series()
            .into_column(),
        Values::Bool(v) => BooleanChunked::from_slice(name, &v)
            .into_series()
            .into_column(),
        Values::Text(v) => StringChunked::from_iter_values(name, v.iter().map(String::as_str))
            .into_series()
            .into_column(),
    }
}

/// See [`Table::read_parquet`].
pub(crate) fn read(path: &Path) -> Result<Table, FormatError> {
    let mut file = File::open(path).map_err(|error| unreadable(path, &error))?;
    let magic = ends(&mut file).map_err(|error| unreadable(path, &error))?;
    if magic.0 != MAGIC {
        let mut error = FormatError::of_file(path, "the file does not begin like a Parquet file");
        error.expected = "Parquet".to_owned();
        return Err(error);
    }
    if magic.1 != MAGIC {
        let found = "the end of the Parquet file is missing: it was cut, or is still being written";
        return Err(FormatError::of_file(path, found));
    }
    // Files of other programs may be damaged in ways that the library answers with a panic.
    let read = catch_unwind(AssertUnwindSafe(|| read_whole(path, file)));
    let damaged = |reason: String| {
        FormatError::of_file(path, format!("the Parquet file cannot be read: {reason}"))
    };
    match read {
        Ok(table) => table.map_err(|error| damaged(error.to_string())),
        Err(_) => Err(damaged("its bytes contradict each other".to_owned())),
    }
}

/// The first and last bytes, which are those of its magic word.
fn ends(file: &mut File) -> std::io::Result<(Vec<u8>, Vec<u8>)> {
    let (mut first, mut last) = (Vec::new(), Vec::new());
    let length = MAGIC.len() as u64;
    Read::by_ref(file).take(length).read_to_end(&mut first)?;
    // Between them stand the length of the footer and the footer, so a whole file is longer than both words.
    let end = file.seek(SeekFrom::End(0))?;
    if end > 2 * length {
        file.seek(SeekFrom::End(-(length as i64)))?;
        Read::by_ref(file).take(length).read_to_end(&mut last)?;
    }
    file.rewind()?;
    Ok((first, last))
}

fn read_whole(path: &Path, file: File) -> PolarsResult<Table> {
    let mut reader = ParquetReader::new(file);
    let schema = reader.schema()?;
    let entries = reader.get_metadata()?.key_value_metadata.clone();
    let mut metadata: Vec<(String, String)> = (entries.into_iter().flatten())
        .filter(|entry| entry.key != ARROW_SCHEMA)
        .map(|entry| (entry.key, entry.value.unwrap_or_default()))
        .collect();
    let mut origin = Origin {
        path: path.to_owned(),
        ..Origin::default()
    };
    let mut wanted = Vec::new();
    for (k, (name, field)) in schema.iter().enumerate() {
        if is_known(field.dtype()) {
            wanted.push(k);
        } else {
            let what = format!("values of type {:?}", field.dtype());
            origin.left_out.push((name.to_string(), what));
        }
    }
    let mut columns = Vec::new();
    if !wanted.is_empty() {
        let frame = reader.with_projection(Some(wanted)).finish()?;
        for column in frame.columns() {
            let name = column.name().to_string();
            match from_polars(column.as_materialized_series())? {
                Ok(values) => columns.push(Column::new(name, "", values)),
                Err(what) => origin.left_out.push((name, what)),
            }
        }
    }
    for column in &mut columns {
        let key = format!("{UNIT}{}", column.name);
        if let Some(place) = metadata.iter().position(|(entry, _)| *entry == key) {
            column.unit = metadata.remove(place).1;
        }
    }
    let mut table = columns
        .into_iter()
        .fold(Table::read_from(origin), Table::with);
    table.metadata = metadata;
    Ok(table)
}

/// Whether [`from_polars`] has a type for it, and polars, as we build it, too.
fn is_known(data_type: &ArrowDataType) -> bool {
    use ArrowDataType as D;
    matches!(
        data_type,
        D::Float64
            | D::Float32
            | D::Int32
            | D::Int64
            | D::UInt8
            | D::UInt32
            | D::UInt64
            | D::Boolean
            | D::Utf8
            | D::LargeUtf8
            | D::Utf8View
    )
}

/// The values of a column, or what is in it that a column of ours cannot hold.
fn from_polars(series: &Series) -> PolarsResult<Result<Values, String>> {
    fn all<T: PolarsNumericType>(values: &ChunkedArray<T>) -> Result<Vec<T::Native>, String> {
        values.to_vec_null_aware().left().ok_or_else(gaps)
    }
    fn gaps() -> String {
        "missing values among whole numbers, truth values or text".to_owned()
    }
    Ok(match series.dtype() {
        DataType::Float64 => {
            let values = series.f64()?;
            Ok(Values::F64(match values.null_count() {
                0 => values.into_no_null_iter().collect(),
                _ => values.iter().map(|v| v.unwrap_or(f64::NAN)).collect(),
            }))
        }
        DataType::Float32 => {
            let values = series.f32()?.iter();
            Ok(Values::F64(
                values.map(|v| v.map_or(f64::NAN, f64::from)).collect(),
            ))
        }
        DataType::Int32 => all(series.i32()?).map(Values::I32),
        DataType::Int64 => all(series.i64()?).map(Values::I64),
        DataType::UInt8 => all(series.u8()?).map(Values::U8),
        DataType::UInt32 if series.null_count() > 0 => {
            Ok(Values::OptionalU32(series.u32()?.iter().collect()))
        }
        DataType::UInt32 => all(series.u32()?).map(Values::U32),
        DataType::UInt64 => all(series.u64()?).map(Values::U64),
        DataType::Boolean => {
            let values: Option<Vec<bool>> = series.bool()?.iter().collect();
            values.map(Values::Bool).ok_or_else(gaps)
        }
        DataType::String => {
            let values = series.str()?.iter();
            let values: Option<Vec<String>> = values.map(|v| v.map(str::to_owned)).collect();
            values.map(Values::Text).ok_or_else(gaps)
        }
        other => Err(format!("values of type {other}")),
    })
}
