//! A file of a run as it is in the store: pieces behind each other.

use std::ops::Range;

use cloud_api::names::{Growth, growth};
use cloud_api::{Head, InputFile, RunId};
use cloud_store::frames::MARKER;
use cloud_store::{Result, Store, StoreError, sha256};

/// How much is read at once, in bytes.
pub(crate) const PIECE: u64 = 1 << 20;

/// A tag of what has this description.
pub(crate) fn tag_of(description: &str) -> String {
    format!("\"{}\"", &sha256(description.as_bytes())[..32])
}

/// A file of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Content {
    /// Key, first byte in the file, length.
    pieces: Vec<(String, u64, u64)>,
    /// Bytes that readers append: the end marker of frames.
    end: &'static [u8],
    bytes: u64,
}

impl Content {
    /// The file `name`, if the head has it.
    pub(crate) fn of(run: &RunId, head: &Head, name: &str) -> Option<Self> {
        let key = |rest: &str| format!("runs/{run}/{rest}");
        if let Some(stream) = head.streams.get(name) {
            let pieces = stream
                .segments
                .iter()
                .map(|s| (key(&s.key), s.from, s.to - s.from))
                .collect();
            let end = if growth(name) == Growth::Frames {
                &MARKER[..]
            } else {
                &[]
            };
            return Some(Self {
                pieces,
                end,
                bytes: stream.bytes() + end.len() as u64,
            });
        }
        let whole = head.whole.get(name).map(|whole| (&whole.key, whole.bytes));
        let checkpoint = || {
            let mut both = [&head.checkpoint, &head.earlier].into_iter().flatten();
            both.find(|checkpoint| checkpoint.name == name)
                .map(|checkpoint| (&checkpoint.key, checkpoint.bytes))
        };
        let (rest, bytes) = whole.or_else(checkpoint)?;
        Some(Self {
            pieces: vec![(key(rest), 0, bytes)],
            end: &[],
            bytes,
        })
    }

    /// An input of a run.
    pub(crate) fn of_input(input: &InputFile) -> Self {
        Self {
            pieces: vec![(format!("inputs/{}", input.sha256), 0, input.bytes)],
            end: &[],
            bytes: input.bytes,
        }
    }

    /// Length in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes
    }

    /// A tag of these bytes (RFC 9110, 8.8.3): names of pieces are those of one content.
    pub(crate) fn tag(&self) -> String {
        let pieces = self.pieces.iter();
        let names: Vec<String> = pieces
            .map(|(key, from, bytes)| format!("{key} {from} {bytes}"))
            .collect();
        tag_of(&names.join("\n"))
    }

    /// Length without what readers add.
    pub(crate) fn stored(&self) -> u64 {
        self.bytes - self.end.len() as u64
    }

    /// At most [`PIECE`] bytes from byte `range.start` on; nothing where that is the end.
    pub(crate) fn read(&self, store: &dyn Store, range: Range<u64>) -> Result<Vec<u8>> {
        let at = range.start;
        let wanted = range.end.min(self.bytes).saturating_sub(at).min(PIECE);
        if wanted == 0 {
            return Ok(Vec::new());
        }
        if at >= self.stored() {
            let from = (at - self.stored()) as usize;
            return Ok(self.end[from..from + wanted as usize].to_vec());
        }
        let missing = || StoreError::Missing("a piece of this file".to_owned());
        let piece = self
            .pieces
            .iter()
            .find(|(_, from, bytes)| (*from..from + bytes).contains(&at));
        let (key, from, bytes) = piece.ok_or_else(missing)?;
        let read = store.get_range(key, at - from..(at - from + wanted).min(*bytes))?;
        if read.is_empty() {
            Err(missing())
        } else {
            Ok(read)
        }
    }
}
