//! One frame as one Arrow IPC message: the flatbuffer head with time and step, then the buffers of the columns.
//!
//! Layout: Apache Arrow columnar format 1.x, "Serialization and Interprocess Communication". Heads are written and read by the crate
//! `arrow-ipc`; it cannot put time and step into a message, and makes arrays of all columns, so bodies go from and to the file here.

mod decode;
mod encode;

pub(super) use decode::{Batch, body_length, parse_batch, parse_schema, read_column};
pub(super) use encode::{encode, encode_schema, write_body};

/// Closes a stream: the continuation word and a metadata length of zero.
pub(super) const END_OF_STREAM: [u8; 8] = [0xFF, 0xFF, 0xFF, 0xFF, 0, 0, 0, 0];

/// Opens every message since Arrow 0.15; the length of the metadata follows in four bytes.
pub(super) const CONTINUATION: [u8; 4] = [0xFF; 4];

/// Bytes to which heads, bodies and buffers are padded. As every message is a multiple of it long, the end-of-stream
/// marker always lies within one memory page and one disk sector.
const ALIGNMENT: usize = 64;

/// Keys of the metadata of a message.
const TIME_KEY: &str = "time";
const STEP_KEY: &str = "step";

fn padded(length: usize) -> usize {
    length.next_multiple_of(ALIGNMENT)
}

/// Numbers that Arrow stores as little-endian bytes.
trait LittleEndian: Copy {
    const WIDTH: usize;
    fn put(self, bytes: &mut [u8]);
    fn get(bytes: &[u8]) -> Self;
}

macro_rules! little_endian {
    ($($number:ty),*) => {$(
        impl LittleEndian for $number {
            const WIDTH: usize = size_of::<$number>();

            #[inline]
            fn put(self, bytes: &mut [u8]) {
                bytes.copy_from_slice(&self.to_le_bytes());
            }

            #[inline]
            fn get(bytes: &[u8]) -> Self {
                let mut own = [0; size_of::<$number>()];
                own.copy_from_slice(bytes);
                Self::from_le_bytes(own)
            }
        }
    )*};
}

little_endian!(u8, i32, u32, u64, f64);
