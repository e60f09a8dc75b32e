//! The slots of a contact loop as plain numbers, for the state of a run.

use super::SlotState;
use crate::state::{Pieces, Plain};

/// One slot of [`SavedSlots`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SavedSlot<'a> {
    /// Row of the first particle.
    pub row: u32,
    /// Row of the partner, or index of the wall.
    pub partner: u32,
    /// Image code of the partner; for walls the image of the particle.
    pub image: u32,
    /// How the two stood in the last evaluation.
    pub state: SlotState,
    /// Wall contacts: the feature of the wall; `u32::MAX` for a slot that is free.
    pub feature: u32,
    /// The numbers of the history.
    pub history: &'a [f64],
}

/// Slots in order. Most remember nothing, and take no room for it: there are millions.
#[derive(Debug, Clone, PartialEq)]
pub struct SavedSlots {
    heads: Vec<Head>,
    /// The histories of the slots that have one, one behind the other.
    histories: Vec<f64>,
    /// A history that remembers nothing; as long as all others.
    nothing: Vec<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Head {
    row: u32,
    partner: u32,
    feature: u32,
    image: u32,
    state: SlotState,
    /// Whether it has a history.
    remembers: bool,
}

/// Bytes of a slot in a state, but for its history.
pub(super) const SAVED_BYTES: usize = 4 * size_of::<u32>() + 2;

impl Head {
    fn of(slot: &SavedSlot<'_>, remembers: bool) -> Self {
        Self {
            row: slot.row,
            partner: slot.partner,
            feature: slot.feature,
            image: slot.image,
            state: slot.state,
            remembers,
        }
    }
}

/// Whether a history is another one than that which remembers nothing. To the bit: a zero with a sign is something else.
fn remembers(history: &[f64], nothing: &[f64]) -> bool {
    let bits = |number: &f64| number.to_bits();
    !history.iter().map(bits).eq(nothing.iter().map(bits))
}

/// The bytes of some of the slots of [`SavedSlots`], without making them: for a million particles they would take as long as all else.
#[derive(Debug)]
pub(super) struct Stretch {
    heads: Vec<u8>,
    histories: Vec<u8>,
    remembering: usize,
}

impl Stretch {
    /// None yet, in this memory.
    pub(super) fn reusing(mut heads: Vec<u8>, mut histories: Vec<u8>) -> Self {
        heads.clear();
        histories.clear();
        Self {
            heads,
            histories,
            remembering: 0,
        }
    }

    /// Room for so many slots, of which so many have a history of `numbers` numbers.
    pub(super) fn reserve(&mut self, slots: usize, remembering: usize, numbers: usize) {
        self.heads.reserve(slots * SAVED_BYTES);
        let histories = remembering * numbers * size_of::<f64>();
        self.histories.reserve(histories);
    }

    /// Whether there is no room for histories at all.
    pub(super) fn is_new(&self) -> bool {
        self.histories.capacity() == 0
    }

    /// Appends slots. `write` appends the numbers of a history.
    pub(super) fn extend<H>(
        &mut self,
        nothing: &[f64],
        slots: impl Iterator<Item = (SavedSlot<'static>, H)>,
        write: impl Fn(H, &mut Vec<f64>),
    ) {
        let mut history = Vec::with_capacity(nothing.len());
        for (slot, own) in slots {
            history.clear();
            write(own, &mut history);
            let remembers = remembers(&history, nothing);
            Head::of(&slot, remembers).put(&mut self.heads);
            if remembers {
                self.remembering += 1;
                for number in &history {
                    number.put(&mut self.histories);
                }
            }
        }
    }
}

/// Appends what [`Plain::put`] of the [`SavedSlots`] with the slots of these stretches would.
pub(super) fn put_stretches(pieces: &mut Pieces, nothing: &[f64], stretches: Vec<Stretch>) {
    nothing.to_vec().put(pieces.end());
    let slots: usize = (stretches.iter())
        .map(|stretch| stretch.heads.len() / SAVED_BYTES)
        .sum();
    slots.put(pieces.end());
    let remembering: usize = stretches.iter().map(|stretch| stretch.remembering).sum();
    let (heads, histories): (Vec<_>, Vec<_>) = (stretches.into_iter())
        .map(|stretch| (stretch.heads, stretch.histories))
        .unzip();
    heads.into_iter().for_each(|piece| pieces.push(piece));
    (remembering * nothing.len()).put(pieces.end());
    histories.into_iter().for_each(|piece| pieces.push(piece));
}

impl SavedSlots {
    /// No slots yet, for histories like this one, which remembers nothing.
    #[must_use]
    pub fn new(nothing: Vec<f64>) -> Self {
        Self {
            heads: Vec::new(),
            histories: Vec::new(),
            nothing,
        }
    }

    /// None of these slots, for the same histories.
    #[must_use]
    pub fn emptied(&self) -> Self {
        Self::new(self.nothing.clone())
    }

    /// Room for so many more.
    pub fn reserve(&mut self, slots: usize) {
        self.heads.reserve(slots);
    }

    /// Appends a slot whose history `write` appends to what it is given.
    pub fn push(&mut self, slot: SavedSlot<'_>, write: impl FnOnce(&mut Vec<f64>)) {
        let begin = self.histories.len();
        write(&mut self.histories);
        let remembers = remembers(&self.histories[begin..], &self.nothing);
        if !remembers {
            self.histories.truncate(begin);
        }
        self.heads.push(Head::of(&slot, remembers));
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.heads.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.heads.is_empty()
    }

    /// How many numbers each history has.
    #[must_use]
    pub fn numbers(&self) -> usize {
        self.nothing.len()
    }

    /// Appends a slot with the numbers of its history.
    pub fn push_whole(&mut self, slot: SavedSlot<'_>) {
        self.push(slot, |numbers| numbers.extend_from_slice(slot.history));
    }

    /// The slots in order.
    pub fn iter(&self) -> impl Iterator<Item = SavedSlot<'_>> {
        let mut rest = &self.histories[..];
        self.heads.iter().map(move |head| {
            let history = if head.remembers {
                let (history, behind) = rest.split_at(self.nothing.len());
                rest = behind;
                history
            } else {
                &self.nothing
            };
            SavedSlot {
                row: head.row,
                partner: head.partner,
                image: head.image,
                state: head.state,
                feature: head.feature,
                history,
            }
        })
    }
}

impl Plain for Head {
    fn put(&self, bytes: &mut Vec<u8>) {
        // At once: there are several for each particle.
        let mut raw = [0; SAVED_BYTES];
        let numbers = [self.row, self.partner, self.feature, self.image];
        for (raw, number) in raw.chunks_exact_mut(size_of::<u32>()).zip(numbers) {
            raw.copy_from_slice(&number.to_le_bytes());
        }
        raw[SAVED_BYTES - 2] = self.state as u8;
        raw[SAVED_BYTES - 1] = u8::from(self.remembers);
        bytes.extend_from_slice(&raw);
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        Ok(Self {
            row: Plain::take(bytes)?,
            partner: Plain::take(bytes)?,
            feature: Plain::take(bytes)?,
            image: Plain::take(bytes)?,
            state: Plain::take(bytes)?,
            remembers: Plain::take(bytes)?,
        })
    }
}

impl Plain for SavedSlots {
    fn put(&self, bytes: &mut Vec<u8>) {
        self.nothing.put(bytes);
        self.heads.put(bytes);
        self.histories.put(bytes);
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        let slots = Self {
            nothing: Plain::take(bytes)?,
            heads: Plain::take(bytes)?,
            histories: Plain::take(bytes)?,
        };
        let remembering = slots.heads.iter().filter(|head| head.remembers).count();
        let expected = remembering.checked_mul(slots.nothing.len());
        if expected != Some(slots.histories.len()) {
            return Err(format!(
                "{remembering} histories of {} numbers, {} numbers found",
                slots.nothing.len(),
                slots.histories.len()
            ));
        }
        Ok(slots)
    }
}

impl Plain for SlotState {
    fn put(&self, bytes: &mut Vec<u8>) {
        bytes.push(*self as u8);
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        match u8::take(bytes)? {
            0 => Ok(Self::Near),
            1 => Ok(Self::Touching),
            2 => Ok(Self::Bonded),
            3 => Ok(Self::Behind),
            4 => Ok(Self::Through),
            other => Err(format!("{other} is no state of a pair")),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn what_is_pushed_comes_back_to_the_bit(
            histories in proptest::collection::vec(
                prop_oneof![Just([0.0, 0.0]), Just([0.0, -0.0]), [-1.0f64..1.0, -1.0..1.0]], 0..30)
        ) {
            let mut slots = SavedSlots::new(vec![0.0; 2]);
            for (row, history) in (0..).zip(&histories) {
                let slot = SavedSlot {
                    row,
                    partner: row + 7,
                    image: row % 27,
                    state: SlotState::Bonded,
                    feature: 3,
                    history: &[],
                };
                slots.push(slot, |all| all.extend(history));
            }
            let something = |history: &&[f64; 2]| history.map(f64::to_bits) != [0; 2];
            let remembering = histories.iter().filter(something).count();
            prop_assert_eq!(slots.histories.len(), 2 * remembering);
            let mut bytes = Vec::new();
            slots.put(&mut bytes);
            let back = SavedSlots::take(&mut &bytes[..]).unwrap();
            prop_assert_eq!(back.len(), histories.len());
            let bits = |history: &[f64]| -> Vec<u64> { history.iter().map(|x| x.to_bits()).collect() };
            for (slot, history) in back.iter().zip(&histories) {
                prop_assert_eq!(bits(slot.history), bits(history));
                prop_assert_eq!(slot.partner, slot.row + 7);
            }
        }
    }
}
