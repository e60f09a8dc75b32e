//! Arrays cut into blocks, each compressed on its own: VTK's layout of appended data.
//!
//! Uncompressed: the number of bytes as `UInt64`, then the bytes. Compressed: the number of blocks, the bytes of a whole
//! block, the bytes of the last block if it is shorter (else 0), the compressed bytes of each block, all `UInt64`, then the
//! blocks as zlib streams (RFC 1950).

use flate2::{Compress, Compression, FlushCompress};
use rayon::prelude::*;

use super::{VtuCompression, VtuOptions, VtuValues};

/// Bytes of a whole block: a multiple of every size of an entry, so that no entry is cut.
pub(super) const BLOCK: usize = 3 << 16;
/// Bytes of a block on which the gain of compressing it is tried.
const SAMPLE: usize = 1 << 13;

/// An array as it stands in the file.
pub(super) fn encode(values: &VtuValues, options: VtuOptions) -> Vec<Vec<u8>> {
    let entry = values.entry_bytes(options.precision);
    let per_block = BLOCK / entry;
    let bytes = values.len() * entry;
    let blocks = bytes.div_ceil(BLOCK);
    let block = |k: usize| {
        let entries = k * per_block..((k + 1) * per_block).min(values.len());
        let mut raw = Vec::new();
        values.bytes(options.precision, entries, &mut raw);
        match options.compression {
            VtuCompression::None => raw,
            VtuCompression::Level(level) => deflate(&raw, level.clamp(1, 9)),
            VtuCompression::Adaptive => deflate(&raw, worth(&raw)),
        }
    };
    let encoded: Vec<Vec<u8>> = if options.parallel && blocks > 1 {
        (0..blocks).into_par_iter().map(block).collect()
    } else {
        (0..blocks).map(block).collect()
    };
    let mut head = Vec::new();
    let mut number = |n: usize| head.extend_from_slice(&(n as u64).to_le_bytes());
    if options.compression == VtuCompression::None {
        number(bytes);
    } else {
        number(blocks);
        number(BLOCK);
        number(bytes % BLOCK);
        for block in &encoded {
            number(block.len());
        }
    }
    std::iter::once(head).chain(encoded).collect()
}

/// Level 1 if a sample shrinks by a tenth, else 0. The sample lies in the middle: a block may begin with something else.
fn worth(raw: &[u8]) -> u8 {
    let length = raw.len().min(SAMPLE);
    let start = (raw.len() - length) / 2;
    let sample = deflate(&raw[start..start + length], 1);
    u8::from(sample.len() * 10 <= length * 9)
}

/// A zlib stream; level 0 only frames the bytes.
fn deflate(raw: &[u8], level: u8) -> Vec<u8> {
    let mut state = Compress::new(Compression::new(u32::from(level)), true);
    // What deflate needs where nothing shrinks: 5 bytes per stored part, and the frame.
    let mut out = Vec::with_capacity(raw.len() + raw.len() / 1000 + 64);
    loop {
        let read = state.total_in() as usize;
        match state.compress_vec(&raw[read..], &mut out, FlushCompress::Finish) {
            Ok(flate2::Status::StreamEnd) => return out,
            // Compressing from memory can only ask for room.
            _ => out.reserve(raw.len() / 8 + 64),
        }
    }
}
