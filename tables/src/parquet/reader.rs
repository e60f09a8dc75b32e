//! Reading whole files.

use std::fs::File;
use std::io::{Cursor, Read, Seek as _, SeekFrom};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use mercury_common::error::FormatError;
use mercury_common::readable::shortened;
use polars_arrow::array::{Array, BooleanArray, PrimitiveArray, Utf8ViewArray};
use polars_arrow::datatypes::{ArrowDataType, Field};
use polars_arrow::types::NativeType;
use polars_buffer::Buffer;
use polars_error::{PolarsError, PolarsResult};
use polars_parquet::parquet::compression::Compression;
use polars_parquet::read::{
    BasicDecompressor, ColumnChunkMetadata, FileMetadata, PageReader, column_iter_to_arrays,
    infer_schema, read_metadata,
};

use polars_parquet_format::thrift::protocol::TCompactInputProtocol;
use polars_parquet_format::{FileMetaData as Footer, PageHeader};

use super::UNIT;
use crate::column::{Column, Values};
use crate::table::{Origin, Table, unreadable};

/// How a Parquet file begins and ends.
pub(crate) const MAGIC: &[u8] = b"PAR1";
/// Where programs that know Arrow note its types.
const ARROW_SCHEMA: &str = "ARROW:schema";

/// What a file may be compressed by.
const CODECS: [Compression; 3] = [
    Compression::Uncompressed,
    Compression::Snappy,
    Compression::Zstd,
];

/// A table may take so many bytes in memory, or [`MOST_FOR_EACH`] for each byte of the file if that is more. Runs of equal values
/// and compression let a file of some hundred bytes claim anything.
const MOST: u64 = 64_000_000;
/// See [`MOST`].
const MOST_FOR_EACH: u64 = 1000;
/// What a value takes, in bytes: itself, whether it is there, and once more while it becomes a column.
const VALUE: u64 = 16;

/// How many bytes the rest of a table may take.
struct Room(u64);

impl Room {
    fn take(&mut self, bytes: u64) -> PolarsResult<()> {
        self.0 = self.0.checked_sub(bytes).ok_or_else(|| {
            PolarsError::ComputeError(
                format!(
                    "it claims to hold more than {} MB and than {MOST_FOR_EACH} times its size",
                    MOST / 1_000_000
                )
                .into(),
            )
        })?;
        Ok(())
    }
}

/// See [`Table::read_parquet`].
pub(crate) fn read(path: &Path) -> Result<Table, FormatError> {
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
    let read = catch_unwind(AssertUnwindSafe(|| read_whole(path, &mut file)));
    let damaged = |reason: &str| {
        FormatError::of_file(path, format!("the Parquet file cannot be read: {reason}"))
    };
    match read {
        Ok(table) => table.map_err(|error| damaged(&error.to_string())),
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

fn read_whole(path: &Path, file: &mut File) -> PolarsResult<Table> {
    let length = file.metadata()?.len();
    let mut room = Room(MOST.max(length.saturating_mul(MOST_FOR_EACH)));
    check_footer(file, length)?;
    let footer = read_metadata(file)?;
    let schema = infer_schema(&footer)?;
    let entries = footer.key_value_metadata.iter().flatten();
    let mut metadata: Vec<(String, String)> = entries
        .filter(|entry| entry.key != ARROW_SCHEMA)
        .map(|entry| (entry.key.clone(), entry.value.clone().unwrap_or_default()))
        .collect();
    let mut origin = Origin {
        path: path.to_owned(),
        ..Origin::default()
    };
    let mut columns = Vec::new();
    for field in schema.iter_values() {
        let name = field.name.to_string();
        match column(&footer, field, file, &mut room)? {
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
    let rows = columns.first().map_or(0, |column| column.values.len());
    if let Some(other) = columns.iter().find(|column| column.values.len() != rows) {
        return Err(PolarsError::ComputeError(
            format!(
                "the column `{}` has {} rows, the first one {rows}",
                shortened(&other.name, 100),
                other.values.len()
            )
            .into(),
        ));
    }
    let mut table = columns
        .into_iter()
        .fold(Table::read_from(origin), Table::with);
    table.metadata = metadata;
    Ok(table)
}

/// What [`TCompactInputProtocol`] may count for each byte that it reads: a list counts 8 for each entry, of which each has a byte, and a
/// struct 2.
const COUNTED: usize = 16;

/// Reads the footer with lists that are no longer than it has bytes for: the library takes memory for as many entries as a list claims.
fn check_footer(file: &mut File, length: u64) -> PolarsResult<()> {
    // Behind it stand its length and the magic word.
    let tail = size_of::<u32>() + MAGIC.len();
    let mut claimed = [0; size_of::<u32>()];
    file.seek(SeekFrom::End(-(tail as i64)))?;
    file.read_exact(&mut claimed)?;
    let claimed = u64::from(u32::from_le_bytes(claimed));
    let Some(start) = length.checked_sub(tail as u64 + claimed) else {
        return Err(PolarsError::ComputeError(
            "its footer is longer than the file".into(),
        ));
    };
    let mut footer = Vec::new();
    file.seek(SeekFrom::Start(start))?;
    Read::by_ref(file).take(claimed).read_to_end(&mut footer)?;
    let most = footer.len().saturating_mul(COUNTED);
    let mut protocol = TCompactInputProtocol::new(footer.as_slice(), most);
    match Footer::read_from_in_protocol(&mut protocol) {
        Ok(_) => Ok(()),
        Err(error) => Err(PolarsError::ComputeError(
            format!("its footer is damaged: {error}").into(),
        )),
    }
}

/// The values of a column, or what is in it that no column of ours can hold.
fn column(
    footer: &FileMetadata,
    field: &Field,
    file: &mut File,
    room: &mut Room,
) -> PolarsResult<Result<Values, String>> {
    use ArrowDataType as D;
    let mut arrays = Vec::new();
    let known = matches!(
        field.dtype,
        D::Float64
            | D::Float32
            | D::Int8
            | D::Int16
            | D::Int32
            | D::Int64
            | D::UInt8
            | D::UInt16
            | D::UInt32
            | D::UInt64
            | D::Boolean
            | D::Utf8View
    );
    if !known {
        return Ok(Err(format!("values of type {:?}", field.dtype)));
    }
    for group in &footer.row_groups {
        let Some(mut chunks) = group.columns_under_root_iter(&field.name) else {
            return Err(PolarsError::ComputeError(
                format!("a row group has no column `{}`", field.name).into(),
            ));
        };
        let Some(chunk) = chunks.next() else { continue };
        let codec = chunk.compression();
        if !CODECS.contains(&codec) {
            return Err(PolarsError::ComputeError(
                format!(
                    "it is compressed by {codec:?}, not by Snappy or Zstandard\nhelp: write it by one of them, or uncompressed"
                )
                .into(),
            ));
        }
        arrays.extend(arrays_of(chunk, field, file, room)?);
    }
    let arrays: Vec<&dyn Array> = arrays.iter().map(AsRef::as_ref).collect();
    Ok(match field.dtype {
        D::Float64 => Ok(Values::F64(numbers::<f64>(&arrays)?.map(or_nan).collect())),
        D::Float32 => {
            let values = wider::<f32, f64>(&arrays)?;
            Ok(Values::F64(values.map(or_nan).collect()))
        }
        D::Int8 => all(wider::<i8, i32>(&arrays)?).map(Values::I32),
        D::Int16 => all(wider::<i16, i32>(&arrays)?).map(Values::I32),
        D::UInt16 => all(wider::<u16, u32>(&arrays)?).map(Values::U32),
        D::Int32 => all(numbers(&arrays)?).map(Values::I32),
        D::Int64 => all(numbers(&arrays)?).map(Values::I64),
        D::UInt8 => all(numbers(&arrays)?).map(Values::U8),
        D::UInt32 if arrays.iter().any(|array| array.null_count() > 0) => {
            Ok(Values::OptionalU32(numbers(&arrays)?.collect()))
        }
        D::UInt32 => all(numbers(&arrays)?).map(Values::U32),
        D::UInt64 => all(numbers(&arrays)?).map(Values::U64),
        D::Boolean => {
            let arrays: Vec<&BooleanArray> = of_type(&arrays)?;
            all(arrays.into_iter().flatten()).map(Values::Bool)
        }
        _ => {
            let arrays: Vec<&Utf8ViewArray> = of_type(&arrays)?;
            // Equal texts are stored once in the file and in the arrays, but not in a column.
            for array in &arrays {
                room.take(array.total_bytes_len() as u64)?;
            }
            let texts = arrays.into_iter().flatten();
            all(texts.map(|text| text.map(str::to_owned))).map(Values::Text)
        }
    })
}

/// The values of a column in one row group.
fn arrays_of(
    chunk: &ColumnChunkMetadata,
    field: &Field,
    file: &mut File,
    room: &mut Room,
) -> PolarsResult<Vec<Box<dyn Array>>> {
    let range = chunk.byte_range();
    let mut bytes = Vec::new();
    file.seek(SeekFrom::Start(range.start))?;
    let length = range.end.saturating_sub(range.start);
    Read::by_ref(file).take(length).read_to_end(&mut bytes)?;
    let bytes = Cursor::new(Buffer::from(bytes));
    claims(bytes.get_ref(), room)?;
    // No page, and no text in the head of one, is longer than all of them.
    let most = bytes.get_ref().len().saturating_mul(COUNTED);
    let pages = PageReader::new(bytes, chunk, Vec::new(), most);
    let kind = &chunk.descriptor().descriptor.primitive_type;
    let pages = BasicDecompressor::new(pages, Vec::new());
    let (arrays, _) = column_iter_to_arrays(vec![pages], vec![kind], field.clone(), None)?;
    Ok(arrays)
}

/// Takes what the pages of a chunk claim to hold; the library believes them.
fn claims(mut chunk: &[u8], room: &mut Room) -> PolarsResult<()> {
    while !chunk.is_empty() {
        let most = chunk.len().saturating_mul(COUNTED);
        let mut protocol = TCompactInputProtocol::new(&mut chunk, most);
        // What is behind the last page the library does not read.
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

fn of_type<'a, A: Array>(arrays: &[&'a dyn Array]) -> PolarsResult<Vec<&'a A>> {
    let array = |array: &&'a dyn Array| array.as_any().downcast_ref::<A>();
    let arrays: Option<Vec<&A>> = arrays.iter().map(array).collect();
    arrays.ok_or_else(|| PolarsError::ComputeError("row groups of different types".into()))
}

fn numbers<'a, T: NativeType>(
    arrays: &[&'a dyn Array],
) -> PolarsResult<impl Iterator<Item = Option<T>> + use<'a, T>> {
    let arrays: Vec<&PrimitiveArray<T>> = of_type(arrays)?;
    let values = arrays.into_iter().flat_map(|array| array.iter());
    Ok(values.map(Option::<&T>::copied))
}

fn wider<'a, T: NativeType, U: From<T>>(
    arrays: &[&'a dyn Array],
) -> PolarsResult<impl Iterator<Item = Option<U>> + use<'a, T, U>> {
    Ok(numbers::<T>(arrays)?.map(|value| value.map(U::from)))
}

fn or_nan(value: Option<f64>) -> f64 {
    value.unwrap_or(f64::NAN)
}

fn all<T>(values: impl Iterator<Item = Option<T>>) -> Result<Vec<T>, String> {
    let values: Option<Vec<T>> = values.collect();
    values.ok_or_else(|| "missing values among whole numbers, truth values or text".to_owned())
}
