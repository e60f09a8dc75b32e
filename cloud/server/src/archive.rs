//! A .zip of files that are stored without compression: its length is known before a file is read, and any part of it can be sent.
//!
//! Fields and numbers are those of PKWARE's APPNOTE 6.3.10. Checksums stand behind the files (4.3.9), as they are known after a file was
//! read only; their places and lengths do not depend on them.

/// A file of an archive.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Member {
    /// Path within the archive.
    pub(crate) name: String,
    /// Length in bytes.
    pub(crate) bytes: u64,
    /// CRC-32, once the file was read.
    pub(crate) crc: u32,
}

/// Lengths and places from here on need fields of 64 bits.
const LARGE: u64 = u32::MAX as u64;

/// The checksum stands behind the file (bit 3); names are UTF-8 (bit 11).
const FLAGS: u16 = 1 << 3 | 1 << 11;

/// 1 January 1980, the zero of dates in archives: the same files are the same archive at any time.
const DATE: u16 = 1 << 5 | 1;

/// A regular file that its owner may write and all may read, of Unix.
const MODE: u32 = 0o100_644 << 16;

fn push16(to: &mut Vec<u8>, values: &[u16]) {
    to.extend(values.iter().flat_map(|value| value.to_le_bytes()));
}

fn push32(to: &mut Vec<u8>, values: &[u32]) {
    to.extend(values.iter().flat_map(|value| value.to_le_bytes()));
}

fn push64(to: &mut Vec<u8>, values: &[u64]) {
    to.extend(values.iter().flat_map(|value| value.to_le_bytes()));
}

/// A field of 32 bits; all ones where the number is in a field of 64 bits elsewhere.
fn narrow(value: u64) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}

impl Member {
    fn is_large(&self) -> bool {
        self.bytes >= LARGE
    }

    /// Version of the format that a reader has to know: 4.5 for lengths of 64 bits, else 2.0.
    fn version(&self) -> u16 {
        if self.is_large() { 45 } else { 20 }
    }

    /// The head of the file (4.3.7).
    pub(crate) fn head(&self) -> Vec<u8> {
        let mut head = Vec::new();
        push32(&mut head, &[0x0403_4b50]);
        push16(&mut head, &[self.version(), FLAGS, 0, 0, DATE]);
        // Checksum and lengths follow behind the file; a field of 64 bits says that they are wide there.
        let length = if self.is_large() { u32::MAX } else { 0 };
        push32(&mut head, &[0, length, length]);
        let extra = if self.is_large() { 20 } else { 0 };
        push16(&mut head, &[self.name.len() as u16, extra]);
        head.extend(self.name.as_bytes());
        if self.is_large() {
            push16(&mut head, &[1, 16]);
            push64(&mut head, &[0, 0]);
        }
        head
    }

    /// Checksum and lengths behind the file (4.3.9).
    pub(crate) fn tail(&self) -> Vec<u8> {
        let mut tail = Vec::new();
        push32(&mut tail, &[0x0807_4b50, self.crc]);
        if self.is_large() {
            push64(&mut tail, &[self.bytes, self.bytes]);
        } else {
            push32(&mut tail, &[narrow(self.bytes), narrow(self.bytes)]);
        }
        tail
    }

    /// The row of the file, whose head is at byte `at`, in the directory (4.3.12).
    fn row(&self, at: u64) -> Vec<u8> {
        let mut wide = Vec::new();
        if self.is_large() {
            push64(&mut wide, &[self.bytes, self.bytes]);
        }
        if at >= LARGE {
            push64(&mut wide, &[at]);
        }
        let mut row = Vec::new();
        push32(&mut row, &[0x0201_4b50]);
        let needs = if wide.is_empty() { 20 } else { 45 };
        // Made by 4.5 on Unix.
        push16(&mut row, &[3 << 8 | 45, needs, FLAGS, 0, 0, DATE]);
        let length = narrow(self.bytes);
        push32(&mut row, &[self.crc, length, length]);
        let extra = if wide.is_empty() { 0 } else { wide.len() + 4 };
        push16(&mut row, &[self.name.len() as u16, extra as u16, 0, 0, 0]);
        push32(&mut row, &[MODE, narrow(at)]);
        row.extend(self.name.as_bytes());
        if !wide.is_empty() {
            push16(&mut row, &[1, wide.len() as u16]);
            row.extend(wide);
        }
        row
    }

    /// Bytes of the file with its head and tail.
    fn all_bytes(&self) -> u64 {
        (self.head().len() + self.tail().len()) as u64 + self.bytes
    }
}

/// The directory behind the last file, and the end of the archive (4.3.12, 4.3.14 to 4.3.16).
pub(crate) fn directory(members: &[Member]) -> Vec<u8> {
    let mut directory = Vec::new();
    let mut at = 0;
    for member in members {
        directory.extend(member.row(at));
        at += member.all_bytes();
    }
    let (count, length) = (members.len() as u64, directory.len() as u64);
    let is_wide = count >= u64::from(u16::MAX) || at >= LARGE || length >= LARGE;
    if is_wide {
        push32(&mut directory, &[0x0606_4b50]);
        push64(&mut directory, &[44]);
        push16(&mut directory, &[3 << 8 | 45, 45]);
        push32(&mut directory, &[0, 0]);
        push64(&mut directory, &[count, count, length, at]);
        push32(&mut directory, &[0x0706_4b50, 0]);
        push64(&mut directory, &[at + length]);
        push32(&mut directory, &[1]);
    }
    let few = u16::try_from(count).unwrap_or(u16::MAX);
    push32(&mut directory, &[0x0605_4b50]);
    push16(&mut directory, &[0, 0, few, few]);
    push32(&mut directory, &[narrow(length), narrow(at)]);
    push16(&mut directory, &[0]);
    directory
}

/// Length of the archive in bytes.
pub(crate) fn length(members: &[Member]) -> u64 {
    let files: u64 = members.iter().map(Member::all_bytes).sum();
    files + directory(members).len() as u64
}

#[cfg(test)]
mod tests {
    use std::fs::File;
    use std::io::{Read, Seek, SeekFrom, Write};

    use super::*;

    /// Writes an archive whose files have these contents at their begin, and holes behind.
    fn write(files: &[(&str, &[u8], u64)]) -> (File, u64) {
        let mut file = tempfile::tempfile().unwrap();
        let mut members = Vec::new();
        for &(name, content, bytes) in files {
            // The checksum of a hole is not that of its file: it is not read here.
            let crc = crc32fast::hash(content);
            let name = name.to_owned();
            let member = Member { name, bytes, crc };
            file.write_all(&member.head()).unwrap();
            file.write_all(content).unwrap();
            let hole = (bytes - content.len() as u64) as i64;
            file.seek(SeekFrom::Current(hole)).unwrap();
            file.write_all(&member.tail()).unwrap();
            members.push(member);
        }
        file.write_all(&directory(&members)).unwrap();
        (file, length(&members))
    }

    #[test]
    fn another_program_reads_the_archive_and_its_length_is_known() {
        let files: [(&str, &[u8], u64); 3] = [
            ("drum.toml", b"seed = 1\n", 9),
            ("drum/empty", b"", 0),
            ("drum/größe.csv", b"time [s]\n0\n", 11),
        ];
        let (file, length) = write(&files);
        assert_eq!(file.metadata().unwrap().len(), length);
        let mut archive = zip::ZipArchive::new(file).unwrap();
        for (k, (name, content, _)) in files.into_iter().enumerate() {
            let mut member = archive.by_index(k).unwrap();
            assert_eq!(member.name(), name);
            assert_eq!(member.unix_mode(), Some(0o100_644));
            let mut read = Vec::new();
            member.read_to_end(&mut read).unwrap();
            assert_eq!(read, content);
        }
    }

    /// A file of 5 GB, one behind it, and one of exactly the first length that needs 64 bits.
    #[test]
    fn lengths_and_places_may_have_64_bits() {
        let files: [(&str, &[u8], u64); 3] = [
            ("large", b"", 5 << 30),
            ("behind", b"abc", 3),
            ("border", b"", LARGE),
        ];
        let (file, length) = write(&files);
        assert_eq!(file.metadata().unwrap().len(), length);
        let mut archive = zip::ZipArchive::new(file).unwrap();
        for (k, (name, _, bytes)) in files.into_iter().enumerate() {
            let member = archive.by_index(k).unwrap();
            assert_eq!((member.name(), member.size()), (name, bytes));
        }
        let mut read = String::new();
        let mut behind = archive.by_name("behind").unwrap();
        behind.read_to_string(&mut read).unwrap();
        assert_eq!(read, "abc");
    }

    #[test]
    fn more_files_than_16_bits_count() {
        let names: Vec<String> = (0..65_535).map(|k| k.to_string()).collect();
        let files: Vec<(&str, &[u8], u64)> =
            names.iter().map(|name| (&name[..], &b""[..], 0)).collect();
        let (file, length) = write(&files);
        assert_eq!(file.metadata().unwrap().len(), length);
        assert_eq!(zip::ZipArchive::new(file).unwrap().len(), 65_535);
    }
}
