//! From the bytes of a message to schema, batch and columns. Nothing in here trusts the bytes.

use super::flat::{Damaged, Flat};
use super::schema::{RECORD_BATCH, message, metadata_of};
use super::{ArrowSchema, FieldType, LittleEndian, STEP_KEY, TIME_KEY, batch};
use crate::frames::{Column, ColumnKind};

/// Bytes read at a time when numbers are converted.
const CHUNK: usize = 64 * 1024;

/// Reads `bytes.len()` bytes of the body from an offset in it; the error says what went wrong.
pub(in crate::frames) type ReadBody<'a> = dyn Fn(&mut [u8], u64) -> Result<(), String> + 'a;

/// The head of a record batch, checked against the number of columns and the length of its body.
pub(in crate::frames) struct Batch {
    pub(in crate::frames) rows: usize,
    /// From the metadata of the message, where it has them.
    pub(in crate::frames) time: Option<f64>,
    pub(in crate::frames) step: Option<u64>,
    /// Offset in the body and length of each buffer, in bytes.
    buffers: Vec<(u64, u64)>,
}

/// The Arrow schema in the first message of a stream.
pub(in crate::frames) fn parse_schema(
    flatbuffer: &[u8],
) -> Result<ArrowSchema<Result<FieldType, String>>, String> {
    ArrowSchema::decode(flatbuffer)
}

/// The length of the body of a message, in bytes; `None` where it is no message.
pub(in crate::frames) fn body_length(flatbuffer: &[u8]) -> Option<u64> {
    let flat = Flat::new(flatbuffer);
    let length = flat.root().and_then(|root| root.long(message::BODY_LENGTH));
    u64::try_from(length.ok()?).ok()
}

/// Reads the head of a record batch whose columns have these kinds.
pub(in crate::frames) fn parse_batch(
    flatbuffer: &[u8],
    kinds: &[ColumnKind],
) -> Result<Batch, String> {
    let damaged = |Damaged| "no Arrow message".to_owned();
    let flat = Flat::new(flatbuffer);
    let root = flat.root().map_err(damaged)?;
    let kind = root.byte(message::KIND).map_err(damaged)?;
    if kind != RECORD_BATCH {
        return Err(format!(
            "an Arrow message of type {kind} in place of a record batch"
        ));
    }
    let header = root.table(message::HEADER).map_err(damaged)?;
    let header = header.ok_or("a message without a record batch")?;
    if header.table(batch::COMPRESSION).map_err(damaged)?.is_some() {
        return Err("a compressed record batch, which this reader cannot open".to_owned());
    }
    let body_length = root.long(message::BODY_LENGTH).map_err(damaged)?;
    let body_length = u64::try_from(body_length).map_err(|_| "a negative body length")?;
    let length = header.long(batch::LENGTH).map_err(damaged)?;
    let rows = usize::try_from(length).map_err(|_| "a negative number of rows")?;
    let nodes = header.pairs(batch::NODES).map_err(damaged)?;
    let nodes = nodes.ok_or("a batch without columns")?;
    if nodes.len() != kinds.len() {
        return Err(format!(
            "a batch of {} columns in place of {}",
            nodes.len(),
            kinds.len()
        ));
    }
    if let Some([other, _]) = nodes.iter().find(|[other, _]| *other != length) {
        return Err(format!("a column of {other} rows in place of {rows}"));
    }
    let stored = header.pairs(batch::BUFFERS).map_err(damaged)?;
    let stored = stored.ok_or("a batch without buffers")?;
    if stored.len() != kinds.iter().map(|k| k.buffers()).sum::<usize>() {
        return Err(format!("a batch with {} buffers", stored.len()));
    }
    let mut buffers = Vec::with_capacity(stored.len());
    // Buffers that lie over each other would let a small file fill the memory.
    let mut left = body_length;
    for [offset, length] in stored {
        let inside = match (u64::try_from(offset), u64::try_from(length)) {
            (Ok(offset), Ok(length)) => offset
                .checked_add(length)
                .filter(|&end| end <= body_length)
                .map(|_| (offset, length)),
            _ => None,
        };
        let (offset, length) = inside.ok_or("a buffer outside of its batch")?;
        let rest = left.checked_sub(length);
        left = rest.ok_or("buffers that lie over each other")?;
        buffers.push((offset, length));
    }

    let metadata = metadata_of(&root, message::METADATA).map_err(damaged)?;
    let value_of = |key: &str| {
        let entry = metadata.iter().find(|(own, _)| own == key);
        entry.map(|(_, value)| &value[..])
    };
    let time = match value_of(TIME_KEY) {
        None => None,
        Some(text) => {
            let time = text.parse::<f64>().ok().filter(|time| time.is_finite());
            Some(time.ok_or_else(|| format!("the time `{text}`"))?)
        }
    };
    let step = match value_of(STEP_KEY) {
        None => None,
        Some(text) => Some(text.parse().map_err(|_| format!("the step `{text}`"))?),
    };
    Ok(Batch {
        rows,
        time,
        step,
        buffers,
    })
}

/// The first `rows` numbers of a buffer.
fn numbers<T: LittleEndian>(
    rows: usize,
    (offset, length): (u64, u64),
    read: &ReadBody<'_>,
) -> Result<Vec<T>, String> {
    // The buffer lies in the body and the body in the file, so a wrong number of rows cannot ask for more memory than
    // the file has bytes.
    let bytes = rows.checked_mul(T::WIDTH).filter(|&n| n as u64 <= length);
    let bytes = bytes.ok_or_else(|| format!("a buffer of {length} bytes for {rows} rows"))?;
    let mut values = Vec::with_capacity(rows);
    let mut chunk = vec![0; bytes.min(CHUNK)];
    let mut done = 0;
    while done < bytes {
        let part = &mut chunk[..(bytes - done).min(CHUNK)];
        read(part, offset + done as u64)?;
        values.extend(part.chunks_exact(T::WIDTH).map(T::get));
        done += part.len();
    }
    Ok(values)
}

/// For each row whether it has a value; `None` when all have one.
fn validity(
    rows: usize,
    buffer: (u64, u64),
    read: &ReadBody<'_>,
) -> Result<Option<Vec<bool>>, String> {
    // A buffer of no bytes means that nothing is missing.
    if rows == 0 || buffer.1 == 0 {
        return Ok(None);
    }
    let bits: Vec<u8> = numbers(rows.div_ceil(8), buffer, read)?;
    let valid: Vec<bool> = (0..rows).map(|k| bits[k / 8] >> (k % 8) & 1 == 1).collect();
    Ok(valid.contains(&false).then_some(valid))
}

fn text(rows: usize, buffers: &[(u64, u64)], read: &ReadBody<'_>) -> Result<Vec<String>, String> {
    // Arrow lets the offsets of an empty column be left out.
    if rows == 0 {
        return Ok(Vec::new());
    }
    let offsets: Vec<i32> = numbers(rows + 1, buffers[1], read)?;
    let length = usize::try_from(buffers[2].1).map_err(|_| "a text too long for this machine")?;
    let bytes: Vec<u8> = numbers(length, buffers[2], read)?;
    let word = |ends: &[i32]| -> Option<String> {
        let start = usize::try_from(ends[0]).ok()?;
        let end = usize::try_from(ends[1]).ok()?;
        Some(std::str::from_utf8(bytes.get(start..end)?).ok()?.to_owned())
    };
    let words: Option<Vec<String>> = offsets.windows(2).map(word).collect();
    words.ok_or_else(|| "text that is not UTF-8 or lies outside of its buffer".to_owned())
}

/// One column of a batch: `field` counts the columns of the file. The error says what was found in it.
pub(in crate::frames) fn read_column(
    batch: &Batch,
    kinds: &[ColumnKind],
    field: usize,
    read: &ReadBody<'_>,
) -> Result<Column, String> {
    let first = kinds[..field].iter().map(|k| k.buffers()).sum::<usize>();
    let buffers = &batch.buffers[first..first + kinds[field].buffers()];
    let (rows, values) = (batch.rows, buffers[1]);
    let valid = validity(rows, buffers[0], read)?;
    if kinds[field] != ColumnKind::OptionalU32
        && let Some(row) = valid.as_ref().and_then(|v| v.iter().position(|v| !v))
    {
        return Err(format!("no value in row {row}"));
    }
    Ok(match kinds[field] {
        ColumnKind::F64 => Column::F64(numbers(rows, values, read)?),
        ColumnKind::I32 => Column::I32(numbers(rows, values, read)?),
        ColumnKind::U8 => Column::U8(numbers(rows, values, read)?),
        ColumnKind::U32 => Column::U32(numbers(rows, values, read)?),
        ColumnKind::U64 => Column::U64(numbers(rows, values, read)?),
        ColumnKind::Text => Column::Text(text(rows, buffers, read)?),
        ColumnKind::OptionalU32 => {
            let values = numbers(rows, values, read)?.into_iter();
            Column::OptionalU32(match valid {
                None => values.map(Some).collect(),
                Some(valid) => values.zip(valid).map(|(x, v)| v.then_some(x)).collect(),
            })
        }
    })
}
