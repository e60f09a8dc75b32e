//! SHA-256, by which contents are named and compared.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::ops::Range;

use sha2::{Digest, Sha256};

/// Bytes as hexadecimal digits.
pub fn hex(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 16] = b"0123456789abcdef";
    let mut text = String::with_capacity(2 * bytes.len());
    for byte in bytes {
        text.push(DIGITS[usize::from(byte >> 4)] as char);
        text.push(DIGITS[usize::from(byte & 15)] as char);
    }
    text
}

/// SHA-256 of some bytes, as hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

/// SHA-256 of a part of a file, as hexadecimal digits. An end before that of `range` is an error.
pub fn sha256_of_file(file: &mut File, range: Range<u64>) -> io::Result<String> {
    let mut hashing = Hashing::new(io::sink());
    copy_range(file, range, &mut hashing)?;
    Ok(hashing.finish().0)
}

/// Copies a part of a file. An end before that of `range` is an error.
pub(crate) fn copy_range(
    file: &mut File,
    range: Range<u64>,
    to: &mut impl Write,
) -> io::Result<()> {
    let wanted = range.end.saturating_sub(range.start);
    file.seek(SeekFrom::Start(range.start))?;
    let copied = io::copy(&mut file.take(wanted), to)?;
    if copied == wanted {
        Ok(())
    } else {
        Err(io::ErrorKind::UnexpectedEof.into())
    }
}

/// A writer that computes the SHA-256 of what passes through.
pub struct Hashing<W> {
    inner: W,
    digest: Sha256,
}

impl<W: Write> Hashing<W> {
    /// Around `inner`.
    pub fn new(inner: W) -> Self {
        Self {
            inner,
            digest: Sha256::new(),
        }
    }

    /// The digits, and what was written to.
    pub fn finish(self) -> (String, W) {
        (hex(&self.digest.finalize()), self.inner)
    }
}

impl<W: Write> Write for Hashing<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.inner.write(bytes)?;
        self.digest.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}
