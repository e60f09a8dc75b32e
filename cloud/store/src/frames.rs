//! Where the last whole frame of a growing Arrow stream ends.
//!
//! A frame is appended in two strokes, of which the last replaces the old end marker (`docs/formats/frames.md`), so a
//! copy of "all bytes" taken in between is not a prefix of the later file. This walks from message to message instead,
//! and says up to where bytes will not change any more.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};

/// Length of the end marker, in bytes. It stands behind the last whole frame.
pub const MARKER: [u8; 8] = [0xff, 0xff, 0xff, 0xff, 0, 0, 0, 0];

/// The longest description of a message; ours have some kB.
const LONGEST_HEAD: u32 = 1 << 24;

/// End of the last whole message at or behind byte `from`, which is the end of a message (or 0).
pub fn whole_frames(file: &mut File, from: u64) -> io::Result<u64> {
    let length = file.metadata()?.len();
    let mut at = from;
    let mut head = Vec::new();
    loop {
        let mut start = [0; 8];
        if at + 8 > length {
            return Ok(at);
        }
        file.seek(SeekFrom::Start(at))?;
        file.read_exact(&mut start)?;
        let [_, _, _, _, a, b, c, d] = start;
        let bytes = u32::from_le_bytes([a, b, c, d]);
        if start[..4] != MARKER[..4] || bytes == 0 || bytes > LONGEST_HEAD {
            return Ok(at);
        }
        head.resize(bytes as usize, 0);
        if at + 8 + u64::from(bytes) > length {
            return Ok(at);
        }
        file.read_exact(&mut head)?;
        let Some(end) =
            body_length(&head).and_then(|body| (at + 8 + u64::from(bytes)).checked_add(body))
        else {
            return Ok(at);
        };
        if end > length {
            return Ok(at);
        }
        at = end;
    }
}

/// `bodyLength`, the fourth field of the table `Message` (Arrow columnar format, `Message.fbs`).
fn body_length(head: &[u8]) -> Option<u64> {
    let u16_at = |at: usize| Some(u16::from_le_bytes(head.get(at..at + 2)?.try_into().ok()?));
    let i32_at = |at: usize| Some(i32::from_le_bytes(head.get(at..at + 4)?.try_into().ok()?));
    let table = usize::try_from(i32_at(0)?).ok()?;
    let fields = usize::try_from(i64::try_from(table).ok()? - i64::from(i32_at(table)?)).ok()?;
    let field = 4 + 2 * 3;
    if usize::from(u16_at(fields)?) < field + 2 {
        return Some(0);
    }
    match usize::from(u16_at(fields + field)?) {
        0 => Some(0),
        offset => {
            let at = table + offset;
            let length = i64::from_le_bytes(head.get(at..at + 8)?.try_into().ok()?);
            u64::try_from(length).ok()
        }
    }
}

/// End of the last whole line at or behind byte `from`.
pub fn whole_lines(file: &mut File, from: u64) -> io::Result<u64> {
    let length = file.metadata()?.len();
    let mut end = length;
    let mut block = [0; 4096];
    while end > from {
        let begin = end.saturating_sub(block.len() as u64).max(from);
        let bytes = &mut block[..(end - begin) as usize];
        file.seek(SeekFrom::Start(begin))?;
        file.read_exact(bytes)?;
        if let Some(at) = bytes.iter().rposition(|&byte| byte == b'\n') {
            return Ok(begin + at as u64 + 1);
        }
        end = begin;
    }
    Ok(from)
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    /// A message with a head of one table with four fields, and a body.
    fn message(body: &[u8]) -> Vec<u8> {
        let mut head = vec![0; 64];
        head[0..4].copy_from_slice(&16i32.to_le_bytes()); // the table
        head[16..20].copy_from_slice(&12i32.to_le_bytes()); // its fields begin 12 before
        head[4..6].copy_from_slice(&12u16.to_le_bytes()); // length of their list
        head[6..8].copy_from_slice(&24u16.to_le_bytes());
        head[14..16].copy_from_slice(&8u16.to_le_bytes()); // the fourth is 8 behind the table
        head[24..32].copy_from_slice(&(body.len() as i64).to_le_bytes());
        let mut message = MARKER[..4].to_vec();
        message.extend((head.len() as u32).to_le_bytes());
        message.extend(head);
        message.extend(body);
        message
    }

    #[test]
    fn a_frame_counts_once_its_first_bytes_are_there() {
        let mut file = tempfile::tempfile().unwrap();
        let one = message(&[7; 128]);
        file.write_all(&one).unwrap();
        file.write_all(&MARKER).unwrap();
        let first = one.len() as u64;
        assert_eq!(whole_frames(&mut file, 0).unwrap(), first);
        // First stroke: everything but the first eight bytes, and the new marker.
        let two = message(&[9; 64]);
        file.seek(SeekFrom::Start(first + 8)).unwrap();
        file.write_all(&two[8..]).unwrap();
        file.write_all(&MARKER).unwrap();
        assert_eq!(whole_frames(&mut file, 0).unwrap(), first);
        // Second stroke.
        file.seek(SeekFrom::Start(first)).unwrap();
        file.write_all(&two[..8]).unwrap();
        assert_eq!(
            whole_frames(&mut file, 0).unwrap(),
            first + two.len() as u64
        );
        assert_eq!(
            whole_frames(&mut file, first).unwrap(),
            first + two.len() as u64
        );
        // A file that was cut within a frame ends before it.
        file.set_len(first + 20).unwrap();
        assert_eq!(whole_frames(&mut file, 0).unwrap(), first);
    }

    #[test]
    fn lines_count_when_they_are_whole() {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(b"one\ntwo\nthr").unwrap();
        assert_eq!(whole_lines(&mut file, 0).unwrap(), 8);
        assert_eq!(whole_lines(&mut file, 8).unwrap(), 8);
        file.seek(SeekFrom::End(0)).unwrap();
        file.write_all(&[b'e'; 9000]).unwrap();
        assert_eq!(whole_lines(&mut file, 0).unwrap(), 8);
        file.seek(SeekFrom::End(0)).unwrap();
        file.write_all(b"\n").unwrap();
        assert_eq!(whole_lines(&mut file, 8).unwrap(), 8 + 3 + 9000 + 1);
    }
}
