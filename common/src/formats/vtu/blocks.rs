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
            VtuCompression::Adaptive if shrinks(&raw) => deflate(&raw, 1),
            VtuCompression::Adaptive => store(&raw),
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

/// Whether a sample shrinks by a tenth. It lies in the middle: a block may begin with something else.
fn shrinks(raw: &[u8]) -> bool {
    let length = raw.len().min(SAMPLE);
    let start = (raw.len() - length) / 2;
    let sample = deflate(&raw[start..start + length], 1);
    sample.len() * 10 <= length * 9
}

/// A zlib stream.
fn deflate(raw: &[u8], level: u8) -> Vec<u8> {
    let mut state = Compress::new(Compression::new(u32::from(level)), true);
    // Where nothing shrinks, deflate adds 5 bytes to each stored part, and the frame.
    let mut out = Vec::with_capacity(raw.len() + raw.len() / 1000 + 64);
    loop {
        let read = state.total_in() as usize;
        match state.compress_vec(&raw[read..], &mut out, FlushCompress::Finish) {
            Ok(flate2::Status::StreamEnd) => return out,
            // Compression in memory can fail only for lack of memory.
            _ => out.reserve(raw.len() / 8 + 64),
        }
    }
}

/// A zlib stream that holds the bytes as they are (RFC 1950, RFC 1951 section 3.2.4); the
/// compressor's own level 0 takes longer than a disk.
fn store(raw: &[u8]) -> Vec<u8> {
    const PART: usize = 0xFFFF;
    let mut out = Vec::with_capacity(raw.len() + 5 * raw.len().div_ceil(PART) + 11);
    // Deflate with a window of 32 KiB, made with little effort.
    out.extend_from_slice(&[0x78, 0x01]);
    let parts = raw.chunks(PART);
    let last = parts.len();
    for (k, part) in parts.enumerate() {
        let length = part.len() as u16;
        out.push(u8::from(k + 1 == last));
        out.extend_from_slice(&length.to_le_bytes());
        out.extend_from_slice(&(!length).to_le_bytes());
        out.extend_from_slice(part);
    }
    out.extend_from_slice(&simd_adler32::adler32(&raw).to_be_bytes());
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cargo unites the features of all crates of one build: a crate that selected another compressor of flate2 would change the
    /// bytes of every file, depending on what else was built.
    #[test]
    fn the_compressor_is_the_same_however_the_program_is_built() {
        let raw: Vec<u8> = (0..40_000u64).map(|k| ((k * k) >> 9) as u8).collect();
        let of = |level| {
            let bytes = deflate(&raw, level);
            (bytes.len(), simd_adler32::adler32(&bytes.as_slice()))
        };
        assert_eq!(
            [of(1), of(9)],
            [(38_000, 193_966_798), (33_895, 3_411_914_002)]
        );
    }
}
