//! Reading flatbuffers without trusting them: every offset is checked where it is followed.
//!
//! Layout: FlatBuffers documentation, "FlatBuffer Internals". A table begins with the distance back to its vtable, which says for
//! each slot how far behind the beginning of the table its value lies; 0 or a missing entry means that the value is left out.

use std::cell::Cell;

/// Something in a flatbuffer points where it cannot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Damaged;

/// What following a slot gives: `None` where the value is left out.
pub(super) type Found<T> = Result<Option<T>, Damaged>;

/// Bytes that one flatbuffer may be read for each byte that it has. Writers may store equal texts once, so more than one; without a
/// limit, a small file whose offsets all lead to one long text would fill the memory.
const READS_PER_BYTE: usize = 64;

/// What reading a table or an entry costs beside its texts, in bytes.
const ENTRY: usize = 16;

/// The bytes of a flatbuffer.
pub(super) struct Flat<'a> {
    bytes: &'a [u8],
    /// How many bytes may still be read.
    left: Cell<usize>,
}

/// A table in a flatbuffer.
#[derive(Clone, Copy)]
pub(super) struct Table<'a> {
    flat: &'a Flat<'a>,
    /// Offset of the table and of its vtable, and the length of that, in bytes.
    at: usize,
    slots: usize,
    slots_length: usize,
}

impl<'a> Flat<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        let left = Cell::new(bytes.len().saturating_mul(READS_PER_BYTE));
        Self { bytes, left }
    }

    /// The root table.
    pub(super) fn root(&'a self) -> Result<Table<'a>, Damaged> {
        self.table(self.follow(0)?)
    }

    fn slice(&self, at: usize, length: usize) -> Result<&'a [u8], Damaged> {
        let end = at.checked_add(length).ok_or(Damaged)?;
        self.charge(length)?;
        self.bytes.get(at..end).ok_or(Damaged)
    }

    /// Takes what is read from what may be read.
    fn charge(&self, length: usize) -> Result<(), Damaged> {
        self.left
            .set(self.left.get().checked_sub(length).ok_or(Damaged)?);
        Ok(())
    }

    fn number<const N: usize>(&self, at: usize) -> Result<[u8; N], Damaged> {
        let mut own = [0; N];
        own.copy_from_slice(self.slice(at, N)?);
        Ok(own)
    }

    /// Where the unsigned offset that stands at `at` leads.
    fn follow(&self, at: usize) -> Result<usize, Damaged> {
        let offset = usize::try_from(u32::from_le_bytes(self.number(at)?)).map_err(|_| Damaged)?;
        at.checked_add(offset).ok_or(Damaged)
    }

    fn table(&'a self, at: usize) -> Result<Table<'a>, Damaged> {
        let back = i64::from(i32::from_le_bytes(self.number(at)?));
        let slots = i64::try_from(at).map_err(|_| Damaged)? - back;
        let slots = usize::try_from(slots).map_err(|_| Damaged)?;
        let slots_length = usize::from(u16::from_le_bytes(self.number(slots)?));
        self.charge(ENTRY)?;
        Ok(Table {
            flat: self,
            at,
            slots,
            slots_length,
        })
    }

    /// Number of entries of the vector at `at` and where they begin; there are as many bytes as they need.
    fn vector(&self, at: usize, entry: usize) -> Result<(usize, usize), Damaged> {
        let count = usize::try_from(u32::from_le_bytes(self.number(at)?)).map_err(|_| Damaged)?;
        let first = at.checked_add(4).ok_or(Damaged)?;
        self.slice(first, count.checked_mul(entry).ok_or(Damaged)?)?;
        Ok((count, first))
    }
}

impl<'a> Table<'a> {
    /// Offset of the value of a slot.
    fn place(&self, slot: usize) -> Found<usize> {
        let entry = 4 + 2 * slot;
        if entry + 2 > self.slots_length {
            return Ok(None);
        }
        let offset = u16::from_le_bytes(self.flat.number(self.slots + entry)?);
        Ok((offset > 0).then_some(self.at + usize::from(offset)))
    }

    fn value<const N: usize>(&self, slot: usize) -> Found<[u8; N]> {
        let place = self.place(slot)?;
        place.map(|at| self.flat.number(at)).transpose()
    }

    /// The byte in a slot, 0 if it is left out.
    pub(super) fn byte(&self, slot: usize) -> Result<u8, Damaged> {
        Ok(self.value(slot)?.map_or(0, u8::from_le_bytes))
    }

    /// The 16-bit number in a slot, 0 if it is left out.
    pub(super) fn short(&self, slot: usize) -> Result<i16, Damaged> {
        Ok(self.value(slot)?.map_or(0, i16::from_le_bytes))
    }

    /// The 32-bit number in a slot, 0 if it is left out.
    pub(super) fn int(&self, slot: usize) -> Result<i32, Damaged> {
        Ok(self.value(slot)?.map_or(0, i32::from_le_bytes))
    }

    /// The 64-bit number in a slot, 0 if it is left out.
    pub(super) fn long(&self, slot: usize) -> Result<i64, Damaged> {
        Ok(self.value(slot)?.map_or(0, i64::from_le_bytes))
    }

    /// The table in a slot.
    pub(super) fn table(&self, slot: usize) -> Found<Table<'a>> {
        let place = self.place(slot)?;
        let table = |at| self.flat.table(self.flat.follow(at)?);
        place.map(table).transpose()
    }

    /// The text in a slot.
    pub(super) fn text(&self, slot: usize) -> Found<&'a str> {
        let Some(place) = self.place(slot)? else {
            return Ok(None);
        };
        let (length, first) = self.flat.vector(self.flat.follow(place)?, 1)?;
        let bytes = self.flat.slice(first, length)?;
        std::str::from_utf8(bytes).map(Some).map_err(|_| Damaged)
    }

    /// The tables of a vector, none if it is left out.
    pub(super) fn tables(&self, slot: usize) -> Result<Vec<Table<'a>>, Damaged> {
        let Some(place) = self.place(slot)? else {
            return Ok(Vec::new());
        };
        let (count, first) = self.flat.vector(self.flat.follow(place)?, 4)?;
        let table = |k| self.flat.table(self.flat.follow(first + 4 * k)?);
        (0..count).map(table).collect()
    }

    /// The pairs of 64-bit numbers of a vector of such structs.
    pub(super) fn pairs(&self, slot: usize) -> Found<Vec<[i64; 2]>> {
        let Some(place) = self.place(slot)? else {
            return Ok(None);
        };
        let (count, first) = self.flat.vector(self.flat.follow(place)?, 16)?;
        let number = |at| self.flat.number(at).map(i64::from_le_bytes);
        let pair = |k| Ok([number(first + 16 * k)?, number(first + 16 * k + 8)?]);
        (0..count).map(pair).collect::<Result<_, _>>().map(Some)
    }
}

#[cfg(test)]
mod tests {
    use flatbuffers::FlatBufferBuilder;
    use proptest::prelude::*;

    use super::*;

    /// A table of a number, a text and a vector of tables that hold the same text.
    fn sample(text: &str, count: usize) -> Vec<u8> {
        let mut builder = FlatBufferBuilder::new();
        let text = builder.create_string(text);
        let inner: Vec<_> = (0..count)
            .map(|_| {
                let table = builder.start_table();
                builder.push_slot_always(4, text);
                builder.end_table(table)
            })
            .collect();
        let inner = builder.create_vector(&inner);
        let table = builder.start_table();
        builder.push_slot::<i64>(4, -7, 0);
        builder.push_slot_always(6, text);
        builder.push_slot_always(8, inner);
        let root = builder.end_table(table);
        builder.finish(root, None);
        builder.finished_data().to_vec()
    }

    fn read(bytes: &[u8]) -> Result<(i64, Option<String>, usize, i16), Damaged> {
        let flat = Flat::new(bytes);
        let root = flat.root()?;
        let mut texts = 0;
        for table in root.tables(2)? {
            texts += table.text(0)?.unwrap_or_default().len();
        }
        let text = root.text(1)?.map(str::to_owned);
        Ok((root.long(0)?, text, texts, root.short(17)?))
    }

    #[test]
    fn what_a_builder_wrote_is_read() {
        let expected = (-7, Some("überlappung".to_owned()), 3 * 12, 0);
        assert_eq!(read(&sample("überlappung", 3)), Ok(expected));
    }

    #[test]
    fn one_text_behind_many_offsets_does_not_fill_the_memory() {
        // 10 kB of text behind a thousand tables: 10 MB of texts in a file of 30 kB.
        assert_eq!(read(&sample(&"x".repeat(10_000), 1000)), Err(Damaged));
    }

    proptest! {
        #[test]
        fn no_damage_panics(
            changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
            length in any::<prop::sample::Index>(),
            cut in any::<bool>(),
        ) {
            let mut bytes = sample("text", 5);
            for (place, byte) in changes {
                let place = place.index(bytes.len());
                bytes[place] = byte;
            }
            if cut {
                bytes.truncate(length.index(bytes.len()));
            }
            let _ = read(&bytes);
        }
    }
}
