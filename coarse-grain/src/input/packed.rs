//! Text files, unpacked on the way.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use flate2::bufread::MultiGzDecoder;
use mercury_common::error::FormatError;
use mercury_common::run_files::Packing;

/// Bytes that are read in one go.
const BUFFER: usize = 1 << 17;
/// Opens a file, unpacking it on the way if it is packed by its first bytes; the name is only used in messages.
pub(super) fn open_text(path: &Path) -> Result<Box<dyn BufRead + Send>, FormatError> {
    let cannot = |error| FormatError::of_file(path, format!("the file cannot be opened: {error}"));
    let mut file = BufReader::with_capacity(BUFFER, File::open(path).map_err(cannot)?);
    let packing = Packing::of(file.fill_buf().map_err(cannot)?);
    Ok(match packing {
        None => Box::new(file),
        Some(Packing::Gzip) => buffered(MultiGzDecoder::new(file)),
        Some(other) => unpacked(file, other, path)?,
    })
}

fn buffered(reader: impl Read + Send + 'static) -> Box<dyn BufRead + Send> {
    Box::new(BufReader::with_capacity(BUFFER, reader))
}

/// Refuses the file in programs that were built without these.
#[cfg(not(feature = "packed"))]
fn unpacked(
    _: BufReader<File>,
    packing: Packing,
    path: &Path,
) -> Result<Box<dyn BufRead + Send>, FormatError> {
    let found = format!("a file packed as {}", packing.ending());
    let help = format!("unpack it first ({})", packing.command());
    Err(FormatError::of_file(path, found).with_help(help))
}

#[cfg(feature = "packed")]
fn unpacked(
    file: BufReader<File>,
    packing: Packing,
    _: &Path,
) -> Result<Box<dyn BufRead + Send>, FormatError> {
    Ok(match packing {
        Packing::Bzip2 => buffered(bzip2::bufread::MultiBzDecoder::new(file)),
        Packing::Xz => {
            let reader = lzma_rust2::XzReader::new_mem_limit(file, true, MOST_KIB);
            buffered(reader)
        }
        _ => buffered(zstd::Frames::new(file)),
    })
}

/// Memory that a file may ask for to be unpacked, KiB: `xz -9` takes 65 MiB, `zstd --long` 128 (the most that its reader grants by itself).
#[cfg(feature = "packed")]
const MOST_KIB: u32 = 1 << 18;

#[cfg(feature = "packed")]
mod zstd;
