//! From a frame to the bytes of its message.

use std::io::{self, Write};

use arrow_ipc::convert::metadata_to_fb;
use arrow_ipc::writer::StreamWriter;
use arrow_ipc::{
    Buffer, FieldNode, MessageBuilder, MessageHeader, MetadataVersion, RecordBatchBuilder,
};
use arrow_schema::{Metadata, Schema};
use flatbuffers::FlatBufferBuilder;

use super::{ALIGNMENT, CONTINUATION, LittleEndian, STEP_KEY, TIME_KEY, padded};
use crate::frames::{Column, Frame};

/// Values converted at a time; the bytes of a chunk stay in the first-level cache.
const CHUNK: usize = 1024;

/// The head of a message, and how many bytes of body follow it.
pub(in crate::frames) struct Encoded {
    /// Continuation word, length, flatbuffer and padding.
    pub(in crate::frames) head: Vec<u8>,
    /// Length of the body, in bytes.
    pub(in crate::frames) body_length: u64,
}

/// Continuation word, length, flatbuffer and padding; `None` if it is too long for the format.
fn head_of(flatbuffer: &[u8]) -> Option<Vec<u8>> {
    let head_length = padded(8 + flatbuffer.len());
    let metadata_length = i32::try_from(head_length - 8).ok()?;
    let mut head = Vec::with_capacity(head_length);
    head.extend_from_slice(&CONTINUATION);
    head.extend_from_slice(&metadata_length.to_le_bytes());
    head.extend_from_slice(flatbuffer);
    head.resize(head_length, 0);
    Some(head)
}

/// The schema message and the end-of-stream marker: a whole file without frames; `None` if there are too many columns for the format.
pub(in crate::frames) fn encode_schema(schema: &Schema) -> Option<Vec<u8>> {
    let writer = StreamWriter::try_new(Vec::new(), schema).ok()?;
    writer.into_inner().ok()
}

/// Lengths of the buffers of a column, without padding, in the order of the file; `None` when text is too long.
fn buffer_lengths(column: &Column) -> Option<Vec<usize>> {
    Some(match column {
        Column::F64(v) => vec![0, v.len() * 8],
        Column::U64(v) => vec![0, v.len() * 8],
        Column::I32(v) => vec![0, v.len() * 4],
        Column::U32(v) => vec![0, v.len() * 4],
        Column::OptionalU32(v) => vec![v.len().div_ceil(8), v.len() * 4],
        Column::U8(v) => vec![0, v.len()],
        Column::Text(v) => {
            let bytes = v.iter().map(String::len).sum::<usize>();
            // Arrow's utf8 has 32-bit offsets.
            i32::try_from(bytes).ok()?;
            vec![0, (v.len() + 1) * 4, bytes]
        }
    })
}

fn missing(column: &Column) -> usize {
    match column {
        Column::OptionalU32(v) => v.iter().filter(|x| x.is_none()).count(),
        _ => 0,
    }
}

/// The head of the message of a frame. `Err` describes the part that does not fit into the format.
pub(in crate::frames) fn encode(frame: &Frame) -> Result<Encoded, String> {
    let rows = frame.rows();
    let mut nodes = vec![FieldNode::new(rows as i64, 0)];
    let mut lengths = vec![0, rows * 8];
    for column in &frame.columns {
        nodes.push(FieldNode::new(rows as i64, missing(column) as i64));
        let text_too_long = "a text column of more than 2 GiB in one frame";
        lengths.extend(buffer_lengths(column).ok_or(text_too_long)?);
    }
    let mut body_length = 0;
    let buffers: Vec<Buffer> = lengths
        .into_iter()
        .map(|length| {
            let buffer = Buffer::new(body_length as i64, length as i64);
            body_length += padded(length);
            buffer
        })
        .collect();

    let mut builder = FlatBufferBuilder::new();
    // Debug prints the shortest decimals that read back exactly, with an exponent where the number is long.
    let (step, time) = (frame.step.to_string(), format!("{:?}", frame.time));
    let metadata = Metadata::from([(STEP_KEY, step), (TIME_KEY, time)]);
    let metadata = metadata_to_fb(&mut builder, &metadata);
    let nodes = builder.create_vector(&nodes);
    let buffers = builder.create_vector(&buffers);
    let mut batch = RecordBatchBuilder::new(&mut builder);
    batch.add_length(rows as i64);
    batch.add_nodes(nodes);
    batch.add_buffers(buffers);
    let batch = batch.finish();
    let mut message = MessageBuilder::new(&mut builder);
    message.add_version(MetadataVersion::V5);
    message.add_header_type(MessageHeader::RecordBatch);
    message.add_header(batch.as_union_value());
    message.add_bodyLength(body_length as i64);
    message.add_custom_metadata(metadata);
    let message = message.finish();
    builder.finish(message, None);
    Ok(Encoded {
        head: head_of(builder.finished_data()).ok_or("too many columns")?,
        body_length: body_length as u64,
    })
}

fn pad(out: &mut impl Write, length: usize) -> io::Result<()> {
    out.write_all(&[0; ALIGNMENT][..padded(length) - length])
}

fn write_numbers<T: LittleEndian>(
    out: &mut impl Write,
    numbers: impl Iterator<Item = T>,
) -> io::Result<()> {
    let mut chunk = [0; CHUNK * 8];
    let (mut filled, mut length) = (0, 0);
    for number in numbers {
        number.put(&mut chunk[filled..filled + T::WIDTH]);
        filled += T::WIDTH;
        if filled == CHUNK * T::WIDTH {
            out.write_all(&chunk[..filled])?;
            length += filled;
            filled = 0;
        }
    }
    out.write_all(&chunk[..filled])?;
    pad(out, length + filled)
}

/// Slices convert in whole chunks, which compiles to a copy of memory.
fn write_slice<T: LittleEndian>(out: &mut impl Write, numbers: &[T]) -> io::Result<()> {
    let mut chunk = [0; CHUNK * 8];
    for part in numbers.chunks(CHUNK) {
        let bytes = &mut chunk[..part.len() * T::WIDTH];
        for (bytes, number) in bytes.chunks_exact_mut(T::WIDTH).zip(part) {
            number.put(bytes);
        }
        out.write_all(bytes)?;
    }
    pad(out, numbers.len() * T::WIDTH)
}

fn write_validity(out: &mut impl Write, values: &[Option<u32>]) -> io::Result<()> {
    let bit = |(k, value): (usize, &Option<u32>)| u8::from(value.is_some()) << k;
    let bytes = values
        .chunks(8)
        .map(|eight| eight.iter().enumerate().map(bit).sum::<u8>());
    write_numbers(out, bytes)
}

/// The buffers of a frame, `time` first, each padded; [`Encoded::body_length`] bytes.
pub(in crate::frames) fn write_body(out: &mut impl Write, frame: &Frame) -> io::Result<()> {
    write_numbers(out, std::iter::repeat_n(frame.time, frame.rows()))?;
    for column in &frame.columns {
        match column {
            Column::F64(v) => write_slice(out, v)?,
            Column::I32(v) => write_slice(out, v)?,
            Column::U8(v) => write_slice(out, v)?,
            Column::U32(v) => write_slice(out, v)?,
            Column::U64(v) => write_slice(out, v)?,
            Column::OptionalU32(v) => {
                write_validity(out, v)?;
                write_numbers(out, v.iter().map(|x| x.unwrap_or(0)))?;
            }
            Column::Text(v) => {
                let mut end = 0_i32;
                let ends = v.iter().map(|word| {
                    // The sum fits: the lengths were checked when the head was made.
                    end = end.saturating_add(i32::try_from(word.len()).unwrap_or(i32::MAX));
                    end
                });
                write_numbers(out, std::iter::once(0).chain(ends))?;
                let mut length = 0;
                for word in v {
                    out.write_all(word.as_bytes())?;
                    length += word.len();
                }
                pad(out, length)?;
            }
        }
    }
    Ok(())
}
