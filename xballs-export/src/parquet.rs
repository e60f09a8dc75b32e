//! Parquet, as much of it as tables of numbers need: plain encoding, no compression, one row group per frame.
//!
//! The layout is that of the format's specification (Apache Parquet 2, `parquet.thrift`); its headers are Thrift structures in the
//! compact protocol, which the room `thrift` writes. Missing values of optional columns are Parquet nulls.

mod thrift;

use mercury_common::frames::{Column, ColumnKind, ColumnSpec};
use thrift::{BINARY, I32, STRUCT, Struct};

const MAGIC: &[u8] = b"PAR1";
/// Rows of a page: pages count their bytes in 32 bits.
const PAGE_ROWS: usize = 1 << 20;

/// Numbers that the specification gives to things.
mod code {
    pub(super) const INT32: i32 = 1;
    pub(super) const INT64: i32 = 2;
    pub(super) const DOUBLE: i32 = 5;
    pub(super) const BYTE_ARRAY: i32 = 6;
    pub(super) const REQUIRED: i32 = 0;
    pub(super) const OPTIONAL: i32 = 1;
    pub(super) const UTF8: i32 = 0;
    pub(super) const UINT_8: i32 = 11;
    pub(super) const UINT_32: i32 = 13;
    pub(super) const UINT_64: i32 = 14;
    pub(super) const PLAIN: i32 = 0;
    pub(super) const RLE: i32 = 3;
    pub(super) const UNCOMPRESSED: i32 = 0;
    pub(super) const DATA_PAGE: i32 = 0;
}

/// Physical type, converted type, repetition.
fn kind_codes(kind: ColumnKind) -> (i32, Option<i32>, i32) {
    use code::{
        BYTE_ARRAY, DOUBLE, INT32, INT64, OPTIONAL, REQUIRED, UINT_8, UINT_32, UINT_64, UTF8,
    };
    match kind {
        ColumnKind::F64 => (DOUBLE, None, REQUIRED),
        ColumnKind::I32 => (INT32, None, REQUIRED),
        ColumnKind::U8 => (INT32, Some(UINT_8), REQUIRED),
        ColumnKind::U32 => (INT32, Some(UINT_32), REQUIRED),
        ColumnKind::OptionalU32 => (INT32, Some(UINT_32), OPTIONAL),
        ColumnKind::U64 => (INT64, Some(UINT_64), REQUIRED),
        ColumnKind::Text => (BYTE_ARRAY, Some(UTF8), REQUIRED),
    }
}

/// A column of a row group, as the footer tells of it.
#[derive(Debug)]
struct Chunk {
    offset: u64,
    bytes: u64,
}

/// A table in the making. It appends to buffers of the caller, who writes them behind each other.
#[derive(Debug)]
pub struct ParquetWriter {
    specs: Vec<ColumnSpec>,
    offset: u64,
    groups: Vec<(u64, Vec<Chunk>)>,
}

impl ParquetWriter {
    /// A table with these columns.
    pub fn new(specs: Vec<ColumnSpec>, out: &mut Vec<u8>) -> Self {
        out.extend_from_slice(MAGIC);
        Self {
            specs,
            offset: MAGIC.len() as u64,
            groups: Vec::new(),
        }
    }

    /// Appends rows. A frame without rows leaves no trace.
    ///
    /// # Errors
    /// When the columns are not those of the table.
    pub fn push(&mut self, columns: &[Column], out: &mut Vec<u8>) -> Result<(), String> {
        let kinds = |columns: &[Column]| columns.iter().map(Column::kind).collect::<Vec<_>>();
        let expected: Vec<ColumnKind> = self.specs.iter().map(|spec| spec.kind).collect();
        if kinds(columns) != expected {
            return Err("other columns than in the frames before".to_owned());
        }
        let rows = columns.first().map_or(0, Column::len);
        if rows == 0 {
            return Ok(());
        }
        let begin = out.len();
        let mut chunks = Vec::with_capacity(columns.len());
        for column in columns {
            let before = out.len();
            for first in (0..rows).step_by(PAGE_ROWS) {
                push_page(column, first..(first + PAGE_ROWS).min(rows), out);
            }
            chunks.push(Chunk {
                offset: self.offset + (before - begin) as u64,
                bytes: (out.len() - before) as u64,
            });
        }
        self.offset += (out.len() - begin) as u64;
        self.groups.push((rows as u64, chunks));
        Ok(())
    }

    /// Appends what makes it a file.
    pub fn finish(self, out: &mut Vec<u8>) {
        let before = out.len();
        self.footer().write(out);
        let length = (out.len() - before) as u32;
        out.extend_from_slice(&length.to_le_bytes());
        out.extend_from_slice(MAGIC);
    }

    fn footer(&self) -> Struct {
        let mut schema = vec![root(self.specs.len())];
        schema.extend(self.specs.iter().map(element));
        let rows: u64 = self.groups.iter().map(|(rows, _)| rows).sum();
        let groups = self.groups.iter().map(|(rows, chunks)| {
            let columns = self.specs.iter().zip(chunks);
            let total: u64 = chunks.iter().map(|chunk| chunk.bytes).sum();
            let mut group = Struct::default();
            let columns = columns.map(|(spec, chunk)| chunk_of(spec, chunk, *rows));
            group.list(1, STRUCT, columns.collect());
            group.i64(2, total as i64);
            group.i64(3, *rows as i64);
            group.bytes()
        });
        let mut footer = Struct::default();
        footer.i32(1, 1);
        footer.list(2, STRUCT, schema);
        footer.i64(3, rows as i64);
        footer.list(4, STRUCT, groups.collect());
        footer.list(5, STRUCT, self.units());
        footer.text(6, concat!("mercury-export ", env!("CARGO_PKG_VERSION")));
        footer
    }

    /// Units as metadata `unit.<column>`.
    fn units(&self) -> Vec<Vec<u8>> {
        let entry = |spec: &ColumnSpec| {
            let mut entry = Struct::default();
            entry.text(1, &format!("unit.{}", spec.name));
            entry.text(2, &spec.unit);
            entry.bytes()
        };
        self.specs.iter().map(entry).collect()
    }
}

fn root(columns: usize) -> Vec<u8> {
    let mut root = Struct::default();
    root.text(4, "frames");
    root.i32(5, columns as i32);
    root.bytes()
}

fn element(spec: &ColumnSpec) -> Vec<u8> {
    let (physical, converted, repetition) = kind_codes(spec.kind);
    let mut element = Struct::default();
    element.i32(1, physical);
    element.i32(3, repetition);
    element.text(4, &spec.name);
    if let Some(converted) = converted {
        element.i32(6, converted);
    }
    element.bytes()
}

fn chunk_of(spec: &ColumnSpec, chunk: &Chunk, rows: u64) -> Vec<u8> {
    let (physical, ..) = kind_codes(spec.kind);
    let mut data = Struct::default();
    data.i32(1, physical);
    let encodings = [code::PLAIN, code::RLE].map(thrift::i32_bytes);
    data.list(2, I32, encodings.to_vec());
    data.list(3, BINARY, vec![thrift::text_bytes(&spec.name)]);
    data.i32(4, code::UNCOMPRESSED);
    data.i64(5, rows as i64);
    data.i64(6, chunk.bytes as i64);
    data.i64(7, chunk.bytes as i64);
    data.i64(9, chunk.offset as i64);
    let mut outer = Struct::default();
    outer.i64(2, chunk.offset as i64);
    outer.structure(3, &data);
    outer.bytes()
}

/// Header and values of a page.
fn push_page(column: &Column, rows: std::ops::Range<usize>, out: &mut Vec<u8>) {
    let count = rows.len() as i32;
    let values = values(column, rows);
    let mut page = Struct::default();
    page.i32(1, count);
    page.i32(2, code::PLAIN);
    page.i32(3, code::RLE);
    page.i32(4, code::RLE);
    let mut header = Struct::default();
    header.i32(1, code::DATA_PAGE);
    header.i32(2, values.len() as i32);
    header.i32(3, values.len() as i32);
    header.structure(5, &page);
    header.write(out);
    out.extend_from_slice(&values);
}

fn values(column: &Column, rows: std::ops::Range<usize>) -> Vec<u8> {
    fn flat<T: Copy, const N: usize>(values: &[T], bytes: impl Fn(T) -> [u8; N]) -> Vec<u8> {
        values.iter().flat_map(|&value| bytes(value)).collect()
    }
    match column {
        Column::F64(v) => flat(&v[rows], f64::to_le_bytes),
        Column::I32(v) => flat(&v[rows], i32::to_le_bytes),
        Column::U8(v) => flat(&v[rows], |v| u32::from(v).to_le_bytes()),
        Column::U32(v) => flat(&v[rows], u32::to_le_bytes),
        Column::U64(v) => flat(&v[rows], u64::to_le_bytes),
        Column::OptionalU32(v) => {
            let mut out = levels(&v[rows.clone()]);
            out.extend(v[rows].iter().flatten().flat_map(|v| v.to_le_bytes()));
            out
        }
        Column::Text(v) => {
            let mut out = Vec::new();
            for text in &v[rows] {
                out.extend_from_slice(&(text.len() as u32).to_le_bytes());
                out.extend_from_slice(text.as_bytes());
            }
            out
        }
    }
}

/// Definition levels, 1 where there is a value, as runs behind their length in bytes.
fn levels(values: &[Option<u32>]) -> Vec<u8> {
    let mut runs = Vec::new();
    for run in values.chunk_by(|a, b| a.is_some() == b.is_some()) {
        thrift::push_varint((run.len() as u64) << 1, &mut runs);
        runs.push(u8::from(run[0].is_some()));
    }
    let mut out = (runs.len() as u32).to_le_bytes().to_vec();
    out.extend(runs);
    out
}
