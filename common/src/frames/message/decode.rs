//! From the bytes of a message to schema, batch and columns. Nothing in here trusts the bytes.

use std::ops::Range;

use arrow_ipc::convert::try_fb_to_schema;
use arrow_ipc::{Endianness, Message, MessageHeader, root_as_message_with_opts};
use arrow_schema::Schema;
use flatbuffers::VerifierOptions;

use super::{LittleEndian, STEP_KEY, TIME_KEY};
use crate::frames::{Column, ColumnKind};

/// Bytes read at a time when numbers are converted.
const CHUNK: usize = 64 * 1024;

/// Reads `bytes.len()` bytes of the body from an offset in it; the error describes the failure.
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

/// A message whose offsets and texts were checked.
///
/// Its size with every offset followed is bounded by that of its bytes: without a limit, a small file whose offsets all lead to
/// one long text would fill the memory.
fn message(flatbuffer: &[u8]) -> Result<Message<'_>, String> {
    let options = VerifierOptions {
        max_apparent_size: flatbuffer.len().saturating_mul(8),
        ..VerifierOptions::default()
    };
    root_as_message_with_opts(&options, flatbuffer).map_err(|_| "no Arrow message".to_owned())
}

/// The Arrow schema in the first message of a stream.
pub(in crate::frames) fn parse_schema(flatbuffer: &[u8]) -> Result<Schema, String> {
    let message = message(flatbuffer)?;
    if message.header_type() != MessageHeader::Schema {
        return Err("a first message that is no schema".to_owned());
    }
    if message.bodyLength() != 0 {
        return Err("a schema message with a body".to_owned());
    }
    let schema = message.header_as_schema();
    let schema = schema.ok_or("a schema message without a schema")?;
    if schema.endianness() != Endianness::Little {
        return Err("big-endian numbers".to_owned());
    }
    try_fb_to_schema(schema).map_err(|error| format!("a damaged schema ({error})"))
}

/// The length of the body of a message, in bytes; `None` where it is no message.
pub(in crate::frames) fn body_length(flatbuffer: &[u8]) -> Option<u64> {
    u64::try_from(message(flatbuffer).ok()?.bodyLength()).ok()
}

/// Reads the head of a record batch whose columns have these kinds.
pub(in crate::frames) fn parse_batch(
    flatbuffer: &[u8],
    kinds: &[ColumnKind],
) -> Result<Batch, String> {
    let message = message(flatbuffer)?;
    let kind = message.header_type();
    if kind != MessageHeader::RecordBatch {
        return Err(format!(
            "an Arrow message of type {kind:?} in place of a record batch"
        ));
    }
    let header = message.header_as_record_batch();
    let header = header.ok_or("a message without a record batch")?;
    if header.compression().is_some() {
        return Err("a compressed record batch, which this reader cannot open".to_owned());
    }
    let body_length = u64::try_from(message.bodyLength()).map_err(|_| "a negative body length")?;
    let length = header.length();
    let rows = usize::try_from(length).map_err(|_| "a negative number of rows")?;
    let nodes = header.nodes().ok_or("a batch without columns")?;
    if nodes.len() != kinds.len() {
        return Err(format!(
            "a batch of {} columns in place of {}",
            nodes.len(),
            kinds.len()
        ));
    }
    if let Some(other) = nodes.iter().find(|node| node.length() != length) {
        let other = other.length();
        return Err(format!("a column of {other} rows in place of {rows}"));
    }
    let stored = header.buffers().ok_or("a batch without buffers")?;
    if stored.len() != kinds.iter().map(|k| k.buffers()).sum::<usize>() {
        return Err(format!("a batch with {} buffers", stored.len()));
    }
    let mut buffers = Vec::with_capacity(stored.len());
    // Buffers that lie over each other would let a small file fill the memory.
    let mut left = body_length;
    for buffer in stored {
        let inside = match (
            u64::try_from(buffer.offset()),
            u64::try_from(buffer.length()),
        ) {
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

    let value_of = |key: &str| {
        let mut entries = message.custom_metadata()?.iter();
        entries.find(|entry| entry.key() == Some(key))?.value()
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

/// The numbers of these rows in a buffer.
fn numbers<T: LittleEndian>(
    rows: Range<usize>,
    (offset, length): (u64, u64),
    read: &ReadBody<'_>,
) -> Result<Vec<T>, String> {
    // The buffer lies in the body and the body in the file, so a wrong number of rows cannot take more memory than
    // the file has bytes.
    let end = rows.end;
    let bytes = end.checked_mul(T::WIDTH).filter(|&n| n as u64 <= length);
    bytes.ok_or_else(|| format!("a buffer of {length} bytes for {end} rows"))?;
    let offset = offset + (rows.start * T::WIDTH) as u64;
    let bytes = rows.len() * T::WIDTH;
    let mut values = Vec::with_capacity(rows.len());
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

/// For each of these rows whether it has a value; `None` when all have one.
fn validity(
    rows: Range<usize>,
    buffer: (u64, u64),
    read: &ReadBody<'_>,
) -> Result<Option<Vec<bool>>, String> {
    // A buffer of no bytes means that nothing is missing.
    if rows.is_empty() || buffer.1 == 0 {
        return Ok(None);
    }
    let first = rows.start / 8;
    let bits: Vec<u8> = numbers(first..rows.end.div_ceil(8), buffer, read)?;
    let bit = |k: usize| bits[k / 8 - first] >> (k % 8) & 1 == 1;
    let valid: Vec<bool> = rows.map(bit).collect();
    Ok(valid.contains(&false).then_some(valid))
}

fn text(
    rows: Range<usize>,
    buffers: &[(u64, u64)],
    read: &ReadBody<'_>,
) -> Result<Vec<String>, String> {
    // Arrow lets the offsets of an empty column be left out.
    if rows.is_empty() {
        return Ok(Vec::new());
    }
    let offsets: Vec<i32> = numbers(rows.start..rows.end + 1, buffers[1], read)?;
    let length = usize::try_from(buffers[2].1).map_err(|_| "a text too long for this machine")?;
    let bytes: Vec<u8> = numbers(0..length, buffers[2], read)?;
    let word = |ends: &[i32]| -> Option<String> {
        let start = usize::try_from(ends[0]).ok()?;
        let end = usize::try_from(ends[1]).ok()?;
        Some(std::str::from_utf8(bytes.get(start..end)?).ok()?.to_owned())
    };
    let words: Option<Vec<String>> = offsets.windows(2).map(word).collect();
    words.ok_or_else(|| "text that is not UTF-8 or lies outside of its buffer".to_owned())
}

/// These rows, which the batch has, of one of its columns: `field` counts the columns of the file. The error describes what was
/// found.
pub(in crate::frames) fn read_column(
    batch: &Batch,
    kinds: &[ColumnKind],
    field: usize,
    rows: Range<usize>,
    read: &ReadBody<'_>,
) -> Result<Column, String> {
    let first = kinds[..field].iter().map(|k| k.buffers()).sum::<usize>();
    let buffers = &batch.buffers[first..first + kinds[field].buffers()];
    let (first, values) = (rows.start, buffers[1]);
    let valid = validity(rows.clone(), buffers[0], read)?;
    if kinds[field] != ColumnKind::OptionalU32
        && let Some(row) = valid.as_ref().and_then(|v| v.iter().position(|v| !v))
    {
        return Err(format!("no value in row {}", first + row));
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

#[cfg(test)]
mod tests {
    use arrow_ipc::{FieldBuilder, KeyValueBuilder, MessageBuilder, SchemaBuilder};
    use arrow_schema::{DataType, Field};
    use flatbuffers::FlatBufferBuilder;
    use proptest::prelude::*;

    use super::*;
    use crate::frames::Frame;
    use crate::frames::message::{END_OF_STREAM, encode, encode_schema};

    /// A message with a schema of so many fields, which are all the same one, with a text in its metadata.
    fn repeated(text: &str, times: usize) -> Vec<u8> {
        let mut builder = FlatBufferBuilder::new();
        let value = builder.create_string(text);
        let mut entry = KeyValueBuilder::new(&mut builder);
        entry.add_key(value);
        entry.add_value(value);
        let entry = entry.finish();
        let metadata = builder.create_vector(&[entry]);
        let mut field = FieldBuilder::new(&mut builder);
        field.add_custom_metadata(metadata);
        let field = field.finish();
        let fields = builder.create_vector(&vec![field; times]);
        let mut schema = SchemaBuilder::new(&mut builder);
        schema.add_fields(fields);
        let schema = schema.finish();
        let mut message = MessageBuilder::new(&mut builder);
        message.add_header_type(MessageHeader::Schema);
        message.add_header(schema.as_union_value());
        let message = message.finish();
        builder.finish(message, None);
        builder.finished_data().to_vec()
    }

    #[test]
    fn one_text_behind_many_offsets_does_not_fill_the_memory() {
        // 10 kB of text behind a thousand fields: 20 MB of texts in a file of 15 kB.
        let refused = parse_schema(&repeated(&"x".repeat(10_000), 1000));
        assert_eq!(refused.unwrap_err(), "no Arrow message");
        // A field without a type.
        let refused = parse_schema(&repeated("unit", 1)).unwrap_err();
        assert!(refused.starts_with("a damaged schema ("), "{refused}");
    }

    proptest! {
        #[test]
        fn no_damage_panics(
            changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
            length in any::<prop::sample::Index>(),
            cut in any::<bool>(),
        ) {
            let fields: Vec<Field> = (0..5).map(|k| Field::new(format!("x{k}"), DataType::Float64, true)).collect();
            let schema = encode_schema(&Schema::new(fields)).unwrap();
            let columns = vec![Column::F64(vec![1.0; 3]); 4];
            let batch = encode(&Frame { time: 0.5, step: 7, columns }).unwrap().head;
            for file in [&schema[..schema.len() - END_OF_STREAM.len()], &batch] {
                let mut bytes = file[8..].to_vec();
                for (place, byte) in &changes {
                    let place = place.index(bytes.len());
                    bytes[place] = *byte;
                }
                if cut {
                    bytes.truncate(length.index(bytes.len()));
                }
                let _ = (parse_schema(&bytes), parse_batch(&bytes, &[ColumnKind::F64; 5]));
            }
        }
    }
}
