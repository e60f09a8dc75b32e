//! SHA-256 of texts and files, in hexadecimal digits as `sha256sum` prints them.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use sha2::{Digest as _, Sha256};

/// Bytes in hexadecimal digits.
#[must_use]
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// SHA-256 of bytes.
#[must_use]
pub fn sha256(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

/// A sum over the bytes of a file from its beginning on, which can go on where it stopped.
#[derive(Debug, Clone, Default)]
pub struct FileSum {
    sum: Sha256,
    /// Bytes that it counts.
    pub bytes: u64,
}

impl FileSum {
    /// Goes on to this position, or to the end of the file. Where the file is shorter, fewer bytes are counted.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn go_on(&mut self, path: &Path, to: Option<u64>) -> io::Result<()> {
        use std::io::{Seek as _, SeekFrom};
        let mut file = File::open(path)?;
        file.seek(SeekFrom::Start(self.bytes))?;
        let most = to.map_or(u64::MAX, |to| to.saturating_sub(self.bytes));
        let mut part = file.take(most);
        let mut piece = vec![0; most.min(1 << 18) as usize];
        loop {
            match part.read(&mut piece)? {
                0 => return Ok(()),
                count => {
                    self.sum.update(&piece[..count]);
                    self.bytes += count as u64;
                }
            }
        }
    }

    /// The sum up to here.
    #[must_use]
    pub fn hex(&self) -> String {
        hex(&self.sum.clone().finalize())
    }
}

/// Bytes of a file and their SHA-256.
///
/// # Errors
/// If the file cannot be read.
pub fn summed(path: &Path) -> io::Result<(u64, String)> {
    let mut sum = FileSum::default();
    sum.go_on(path, None)?;
    Ok((sum.bytes, sum.hex()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_those_of_the_standard() {
        // FIPS 180-4, examples for SHA-256: "abc", and a million times "a".
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        for (text, sum) in [
            (
                "abc".to_owned(),
                "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad",
            ),
            (
                "a".repeat(1_000_000),
                "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0",
            ),
        ] {
            std::fs::write(&path, &text).unwrap();
            assert_eq!(summed(&path).unwrap(), (text.len() as u64, sum.to_owned()));
            assert_eq!(sha256(text.as_bytes()), sum);
        }
    }

    #[test]
    fn a_sum_goes_on_where_it_stopped() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::write(&path, "abcdef").unwrap();
        let mut sum = FileSum::default();
        sum.go_on(&path, Some(2)).unwrap();
        sum.go_on(&path, Some(3)).unwrap();
        assert_eq!((sum.bytes, sum.hex()), (3, sha256(b"abc")));
        sum.go_on(&path, Some(9)).unwrap();
        assert_eq!((sum.bytes, sum.hex()), (6, sha256(b"abcdef")));
    }
}
