//! Checksums of the begins of contents, as far as archives have read them: an archive that is resumed reads nothing twice.

use std::collections::HashMap;
use std::sync::Mutex;

/// The most contents whose checksums are kept, some 100 bytes each. With more all are forgotten, and read again where they are needed.
const MOST: usize = 10_000;

/// CRC-32 of the first bytes of contents, by their tags.
#[derive(Debug, Default)]
pub(crate) struct Sums(Mutex<HashMap<String, (u64, u32)>>);

/// CRC-32 of the first `bytes` bytes of a content.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sum {
    pub(crate) bytes: u64,
    crc: crc32fast::Hasher,
}

impl Sum {
    /// Adds bytes that begin at byte `at` of the content, as far as they are new. What is between is never left out.
    pub(crate) fn add(&mut self, at: u64, bytes: &[u8]) {
        debug_assert!(at <= self.bytes);
        let known = self.bytes.saturating_sub(at) as usize;
        if let Some(new) = bytes.get(known..) {
            self.crc.update(new);
            self.bytes += new.len() as u64;
        }
    }

    pub(crate) fn crc(&self) -> u32 {
        self.crc.clone().finalize()
    }
}

impl Sums {
    /// The checksum of the content with this tag, as far as it is known.
    pub(crate) fn of(&self, tag: &str) -> Sum {
        let sums = self.0.lock().unwrap_or_else(|bad| bad.into_inner());
        let (bytes, crc) = sums.get(tag).copied().unwrap_or_default();
        Sum {
            bytes,
            crc: crc32fast::Hasher::new_with_initial_len(crc, bytes),
        }
    }

    /// Keeps a checksum, unless that of more bytes is there.
    pub(crate) fn keep(&self, tag: &str, sum: &Sum) {
        let mut sums = self.0.lock().unwrap_or_else(|bad| bad.into_inner());
        if sums.get(tag).is_some_and(|(bytes, _)| *bytes >= sum.bytes) {
            return;
        }
        if sums.len() >= MOST {
            sums.clear();
        }
        sums.insert(tag.to_owned(), (sum.bytes, sum.crc()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_checksum_goes_on_where_another_reader_has_stopped() {
        let content: Vec<u8> = (0..1000_u32).map(|k| ((k * k) >> 3) as u8).collect();
        let sums = Sums::default();
        let mut sum = sums.of("tag");
        sum.add(0, &content[..300]);
        sums.keep("tag", &sum);
        // A reader that was behind forgets nothing of that.
        let mut behind = Sum::default();
        behind.add(0, &content[..100]);
        sums.keep("tag", &behind);
        let mut sum = sums.of("tag");
        assert_eq!(
            (sum.bytes, sum.crc()),
            (300, crc32fast::hash(&content[..300]))
        );
        // Of bytes that are sent again only the new ones count.
        sum.add(50, &content[50..200]);
        sum.add(200, &content[200..700]);
        sum.add(700, &content[700..]);
        assert_eq!((sum.bytes, sum.crc()), (1000, crc32fast::hash(&content)));
        assert_eq!(sums.of("other").bytes, 0);
    }

    #[test]
    fn the_number_of_checksums_is_bounded() {
        let sums = Sums::default();
        for k in 0..MOST + 1 {
            sums.keep(
                &k.to_string(),
                &Sum {
                    bytes: 1,
                    ..Sum::default()
                },
            );
        }
        assert_eq!(sums.0.lock().unwrap().len(), 1);
    }
}
