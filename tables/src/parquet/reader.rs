//! Reading whole files.

use std::collections::HashSet;
use std::fs::File;
use std::io::{Read, Seek as _, SeekFrom};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;

use arrow_array::cast::AsArray as _;
use arrow_array::types::{
    Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type, UInt8Type, UInt16Type,
    UInt32Type, UInt64Type,
};
use arrow_array::{Array as _, ArrayRef, ArrowPrimitiveType};
use arrow_schema::{DataType, Field, Schema};
use mercury_common::error::FormatError;
use mercury_common::readable::shortened;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{
    ArrowReaderMetadata, ArrowReaderOptions, ParquetRecordBatchReaderBuilder,
};
use parquet::basic::Compression;
use parquet::errors::{ParquetError, Result};
use parquet::file::metadata::ColumnChunkMetaData;
use polars_parquet_format::PageHeader;
use polars_parquet_format::thrift::protocol::TCompactInputProtocol;

use super::UNIT;
use crate::column::{Column, Values};
use crate::table::{Origin, Table, unreadable};

/// How a Parquet file begins and ends.
pub(crate) const MAGIC: &[u8] = b"PAR1";
/// Where programs that know Arrow note its types.
const ARROW_SCHEMA: &str = "ARROW:schema";

/// Rows that are decoded at a time.
const ROWS: usize = 1 << 16;

/// A table may take so many bytes in memory, or [`MOST_FOR_EACH`] for each byte of the file if that is more. Runs of equal values
/// and compression let a file of some hundred bytes claim anything.
const MOST: u64 = 64_000_000;
/// See [`MOST`].
const MOST_FOR_EACH: u64 = 1000;
/// Memory of a value, in bytes: itself, whether it is there, and once more while it becomes a column.
const VALUE: u64 = 16;

/// Bytes that the rest of a table may take.
struct ByteBudget(u64);

impl ByteBudget {
    fn take(&mut self, bytes: u64) -> Result<()> {
        self.0 = self.0.checked_sub(bytes).ok_or_else(|| {
            ParquetError::General(format!(
                "it claims to hold more than {} MB and than {MOST_FOR_EACH} times its size",
                MOST / 1_000_000
            ))
        })?;
        Ok(())
    }
}

/// See [`Table::read_parquet`].
pub(crate) fn read(path: &Path) -> std::result::Result<Table, FormatError> {
    let mut file = File::open(path).map_err(|error| unreadable(path, &error))?;
    let (first, last) = ends(&mut file).map_err(|error| unreadable(path, &error))?;
    if first != MAGIC {
        let mut error = FormatError::of_file(path, "the file does not begin like a Parquet file");
        error.expected = "Parquet".to_owned();
        return Err(error);
    }
    if last != MAGIC {
        let found = "the end of the Parquet file is missing: it was cut, or is still being written";
        return Err(FormatError::of_file(path, found));
    }
    // Files of other programs may be damaged in ways that the library answers with a panic.
    let read = catch_unwind(AssertUnwindSafe(|| read_whole(path, &file)));
    let damaged = |reason: &str| {
        FormatError::of_file(path, format!("the Parquet file cannot be read: {reason}"))
    };
    match read {
        Ok(table) => table.map_err(|error| match error {
            ParquetError::General(reason) | ParquetError::EOF(reason) => damaged(&reason),
            other => damaged(&other.to_string()),
        }),
        Err(_) => Err(damaged("its bytes contradict each other")),
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

fn read_whole(path: &Path, file: &File) -> Result<Table> {
    let length = file.metadata()?.len();
    let mut room = ByteBudget(MOST.max(length.saturating_mul(MOST_FOR_EACH)));
    // The types of Arrow that a program may have noted are left aside: the file's own types are sufficient.
    let options = ArrowReaderOptions::new().with_skip_arrow_metadata(true);
    let known = ArrowReaderMetadata::load(file, options)?;
    let footer = Arc::clone(known.metadata());
    let entries = footer.file_metadata().key_value_metadata();
    let mut metadata: Vec<(String, String)> = (entries.into_iter().flatten())
        .filter(|entry| entry.key != ARROW_SCHEMA)
        .map(|entry| (entry.key.clone(), entry.value.clone().unwrap_or_default()))
        .collect();
    let mut origin = Origin {
        path: path.to_owned(),
        ..Origin::default()
    };
    let (mut roots, mut names) = (Vec::new(), HashSet::new());
    for (root, field) in known.schema().fields().iter().enumerate() {
        if !names.insert(field.name()) {
            let name = shortened(field.name(), 100);
            return Err(ParquetError::General(format!(
                "two columns are called `{name}`"
            )));
        }
        if is_known(field.data_type()) {
            roots.push(root);
        } else {
            let what = format!("values of type {}", field.data_type());
            origin.left_out.push((field.name().clone(), what));
        }
    }
    let leaves = footer.file_metadata().schema_descr();
    for group in footer.row_groups() {
        for (leaf, chunk) in group.columns().iter().enumerate() {
            if roots.contains(&leaves.get_column_root_idx(leaf)) {
                check(chunk, file, &mut room)?;
            }
        }
    }
    let arrays = arrays_of(file, &known, &roots)?;
    let mut columns = Vec::new();
    for (root, arrays) in roots.into_iter().zip(arrays) {
        let field = known.schema().field(root);
        let name = field.name().clone();
        match column(field.data_type(), &arrays, &mut room)? {
            Ok(values) => {
                let unit = metadata
                    .iter()
                    .position(|(key, _)| key.strip_prefix(UNIT) == Some(name.as_str()));
                let unit = unit.map(|place| metadata.remove(place).1);
                columns.push(Column::new(name, unit.unwrap_or_default(), values));
            }
            Err(what) => origin.left_out.push((name, what)),
        }
    }
    let mut table = columns
        .into_iter()
        .fold(Table::read_from(origin), Table::with);
    table.metadata = metadata;
    Ok(table)
}

/// Whether a column of ours can hold it.
fn is_known(kind: &DataType) -> bool {
    use DataType as D;
    kind.is_integer() || matches!(kind, D::Float32 | D::Float64 | D::Boolean | D::Utf8)
}

/// The columns with these numbers, each in pieces.
fn arrays_of(
    file: &File,
    known: &ArrowReaderMetadata,
    roots: &[usize],
) -> Result<Vec<Vec<ArrayRef>>> {
    let mut arrays = vec![Vec::new(); roots.len()];
    if roots.is_empty() {
        return Ok(arrays);
    }
    // Equal texts are stored once in the file; as views they are in memory, too.
    let fields = known.schema().fields().iter();
    let fields = fields.map(|field| match field.data_type() {
        DataType::Utf8 => Field::clone(field).with_data_type(DataType::Utf8View),
        _ => Field::clone(field),
    });
    let schema = Schema::new(fields.collect::<Vec<_>>());
    let options = ArrowReaderOptions::new().with_schema(Arc::new(schema));
    let known = ArrowReaderMetadata::try_new(Arc::clone(known.metadata()), options)?;
    let builder = ParquetRecordBatchReaderBuilder::new_with_metadata(file.try_clone()?, known);
    let mask = ProjectionMask::roots(builder.parquet_schema(), roots.iter().copied());
    for batch in builder
        .with_projection(mask)
        .with_batch_size(ROWS)
        .build()?
    {
        for (own, array) in arrays.iter_mut().zip(batch?.columns()) {
            own.push(Arc::clone(array));
        }
    }
    Ok(arrays)
}

/// The values of a column, or what is in it that no column of ours can hold.
fn column(
    kind: &DataType,
    arrays: &[ArrayRef],
    room: &mut ByteBudget,
) -> Result<std::result::Result<Values, String>> {
    use DataType as D;
    Ok(match kind {
        D::Float64 => Ok(Values::F64(
            numbers::<Float64Type>(arrays).map(or_nan).collect(),
        )),
        D::Float32 => Ok(Values::F64(
            wider::<Float32Type, f64>(arrays).map(or_nan).collect(),
        )),
        D::Int8 => all(wider::<Int8Type, i32>(arrays)).map(Values::I32),
        D::Int16 => all(wider::<Int16Type, i32>(arrays)).map(Values::I32),
        D::UInt16 => all(wider::<UInt16Type, u32>(arrays)).map(Values::U32),
        D::Int32 => all(numbers::<Int32Type>(arrays)).map(Values::I32),
        D::Int64 => all(numbers::<Int64Type>(arrays)).map(Values::I64),
        D::UInt8 => all(numbers::<UInt8Type>(arrays)).map(Values::U8),
        D::UInt32 if arrays.iter().any(|array| array.null_count() > 0) => {
            Ok(Values::OptionalU32(numbers::<UInt32Type>(arrays).collect()))
        }
        D::UInt32 => all(numbers::<UInt32Type>(arrays)).map(Values::U32),
        D::UInt64 => all(numbers::<UInt64Type>(arrays)).map(Values::U64),
        D::Boolean => all(arrays.iter().flat_map(|array| array.as_boolean())).map(Values::Bool),
        _ => {
            let texts = || arrays.iter().flat_map(|array| array.as_string_view());
            // Equal texts are stored once in the file and in the arrays, but not in a column.
            for text in texts().flatten() {
                room.take(text.len() as u64)?;
            }
            all(texts().map(|text| text.map(str::to_owned))).map(Values::Text)
        }
    })
}

/// Whether a column in one row group can be read: how it is compressed, and what its pages claim to hold.
fn check(chunk: &ColumnChunkMetaData, mut file: &File, room: &mut ByteBudget) -> Result<()> {
    let codec = chunk.compression();
    if !matches!(
        codec,
        Compression::UNCOMPRESSED | Compression::SNAPPY | Compression::ZSTD(_)
    ) {
        let codec = format!("{codec:?}");
        let codec = codec.split('(').next().unwrap_or_default();
        return Err(ParquetError::General(format!(
            "it is compressed by {codec}, not by Snappy or Zstandard\nhelp: write it by one of them, or uncompressed"
        )));
    }
    let (start, length) = chunk.byte_range();
    let mut bytes = Vec::new();
    file.seek(SeekFrom::Start(start))?;
    Read::by_ref(&mut file)
        .take(length)
        .read_to_end(&mut bytes)?;
    claims(&bytes, room)
}

/// Largest count of [`TCompactInputProtocol`] for each byte that it reads: a list counts 8 for each entry, of which each has a
/// byte, and a struct 2.
const COUNTED: usize = 16;

/// Takes what the pages of a chunk claim to hold; the library believes them.
fn claims(mut chunk: &[u8], room: &mut ByteBudget) -> Result<()> {
    while !chunk.is_empty() {
        let most = chunk.len().saturating_mul(COUNTED);
        let mut protocol = TCompactInputProtocol::new(&mut chunk, most);
        // The library does not read beyond the last page.
        let Ok(page) = PageHeader::read_from_in_protocol(&mut protocol) else {
            break;
        };
        let values = [
            page.data_page_header.map(|page| page.num_values),
            page.data_page_header_v2.map(|page| page.num_values),
            page.dictionary_page_header.map(|page| page.num_values),
        ];
        let number = |number: i32| u64::try_from(number).unwrap_or(u64::MAX);
        room.take(number(page.uncompressed_page_size))?;
        for values in values.into_iter().flatten() {
            room.take(number(values).saturating_mul(VALUE))?;
        }
        let length = usize::try_from(page.compressed_page_size).unwrap_or(usize::MAX);
        chunk = chunk.get(length..).unwrap_or_default();
    }
    Ok(())
}

fn numbers<T: ArrowPrimitiveType>(arrays: &[ArrayRef]) -> impl Iterator<Item = Option<T::Native>> {
    arrays.iter().flat_map(|array| array.as_primitive::<T>())
}

fn wider<T: ArrowPrimitiveType, U: From<T::Native>>(
    arrays: &[ArrayRef],
) -> impl Iterator<Item = Option<U>> {
    numbers::<T>(arrays).map(|value| value.map(U::from))
}

fn or_nan(value: Option<f64>) -> f64 {
    value.unwrap_or(f64::NAN)
}

fn all<T>(values: impl Iterator<Item = Option<T>>) -> std::result::Result<Vec<T>, String> {
    let values: Option<Vec<T>> = values.collect();
    values.ok_or_else(|| "missing values among whole numbers, truth values or text".to_owned())
}
