//! The slots of a contact loop as plain numbers, for the state of a run.

use super::SlotState;
use super::contact_loop::FREE;
use crate::cell::{NO_SHIFT, image};
use crate::state::{Pieces, Plain, announced};

/// One slot of [`SavedSlots`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SavedSlot<'a> {
    /// Row of the first particle.
    pub row: u32,
    /// Row of the partner, or index of the wall.
    pub partner: u32,
    /// Image code of the partner; for walls the image of the particle.
    pub image: u32,
    /// The state of the pair in the last evaluation.
    pub state: SlotState,
    /// Wall contacts: the feature of the wall; `u32::MAX` for a slot that is free.
    pub feature: u32,
    /// The numbers of the history.
    pub history: &'a [f64],
}

/// Slots in order. Most have no history and take no memory for one: there are millions.
#[derive(Debug, Clone, PartialEq)]
pub struct SavedSlots {
    heads: Vec<Head>,
    /// The histories of the slots that have one, one after the other.
    histories: Vec<f64>,
    /// An empty history; as long as all others.
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

/// The largest number of bytes of a slot at a wall in a state, without its history: its first byte, the wall, the row, the image
/// and the feature.
pub(super) const MOST_AT_WALL: usize = 1 + 4 * size_of::<u32>();

/// The largest number of bytes of the slots of pairs of this many rows in a state, without their histories. A pair has no
/// feature, and the consecutive slots of a row store it once; the bound assumes images for all pairs, which takes four bytes of
/// nine.
pub(super) fn most_bytes_of_pairs(slots: usize, rows: usize) -> usize {
    slots * (1 + 2 * size_of::<u32>()) + slots.min(rows) * size_of::<u32>()
}

/// In the first byte of a slot: its [`SlotState`].
const STATE: u8 = 7;
/// It has a history.
const REMEMBERS: u8 = 1 << 3;
/// Its row follows; else it is that of the slot before it.
const OTHER_ROW: u8 = 1 << 4;
/// The code of its image follows; else it is [`NO_SHIFT`].
const OTHER_IMAGE: u8 = 1 << 5;
/// Its feature follows; else it has none.
const FEATURE: u8 = 1 << 6;
/// Nothing.
const UNUSED: u8 = 1 << 7;

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

    /// Appends it, behind a slot of the row `before`.
    #[inline(always)]
    fn put(&self, before: Option<u32>, bytes: &mut Vec<u8>) {
        let reported = |flag: u8, is_reported: bool| if is_reported { flag } else { 0 };
        let first = self.state as u8
            | reported(REMEMBERS, self.remembers)
            | reported(OTHER_ROW, before != Some(self.row))
            | reported(OTHER_IMAGE, self.image != NO_SHIFT)
            | reported(FEATURE, self.feature != FREE);
        // Two numbers at once, as there are several slots for each particle.
        let mut raw = [first; 1 + size_of::<u32>()];
        raw[1..].copy_from_slice(&self.partner.to_le_bytes());
        bytes.extend_from_slice(&raw);
        let others = [
            (OTHER_ROW, self.row),
            (OTHER_IMAGE, self.image),
            (FEATURE, self.feature),
        ];
        for (flag, number) in others {
            if first & flag != 0 {
                number.put(bytes);
            }
        }
    }

    /// Takes one from the front, behind a slot of the row `before`.
    fn take(before: Option<u32>, bytes: &mut &[u8]) -> Result<Self, String> {
        let first = u8::take(bytes)?;
        if first & UNUSED != 0 {
            return Err(format!("invalid contact record header {first:#x}"));
        }
        let partner = u32::take(bytes)?;
        let mut number = |flag: u8, otherwise: Option<u32>| {
            if first & flag != 0 {
                return u32::take(bytes);
            }
            otherwise.ok_or_else(|| "the first pair names no row".to_owned())
        };
        Ok(Self {
            row: number(OTHER_ROW, before)?,
            partner,
            image: number(OTHER_IMAGE, Some(NO_SHIFT))?,
            feature: number(FEATURE, Some(FREE))?,
            state: SlotState::from_number(first & STATE)?,
            remembers: first & REMEMBERS != 0,
        })
    }
}

/// Whether a history differs from the empty one. Compared bit by bit: a negative zero is different.
fn remembers(history: &[f64], nothing: &[f64]) -> bool {
    let bits = |number: &f64| number.to_bits();
    !history.iter().map(bits).eq(nothing.iter().map(bits))
}

/// The bytes of some of the slots of [`SavedSlots`], without making them: for a million particles they would take as long as
/// everything else.
#[derive(Debug)]
pub(super) struct Stretch {
    heads: Vec<u8>,
    slots: usize,
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
            slots: 0,
            histories,
            remembering: 0,
        }
    }

    /// Reserves memory for slots of this many bytes in all, `remembering` of which have a history of `numbers` numbers.
    pub(super) fn reserve(&mut self, bytes: usize, remembering: usize, numbers: usize) {
        self.heads.reserve(bytes);
        let histories = remembering * numbers * size_of::<f64>();
        self.histories.reserve(histories);
    }

    /// Whether no memory for histories was reserved.
    pub(super) fn is_new(&self) -> bool {
        self.histories.capacity() == 0
    }

    /// Appends all slots of some rows with the histories that they may have. `write` appends the numbers of a history.
    pub(super) fn extend<H>(
        &mut self,
        nothing: &[f64],
        slots: impl Iterator<Item = (SavedSlot<'static>, Option<H>)>,
        write: impl Fn(H, &mut Vec<f64>),
    ) {
        let mut history = Vec::with_capacity(nothing.len());
        let mut before = None;
        for (slot, own) in slots {
            let remembers = own.is_some_and(|own| {
                history.clear();
                write(own, &mut history);
                remembers(&history, nothing)
            });
            Head::of(&slot, remembers).put(before, &mut self.heads);
            before = Some(slot.row);
            self.slots += 1;
            if remembers {
                self.remembering += 1;
                // Reserved at once, as there are some for each particle.
                let begin = self.histories.len();
                self.histories.resize(begin + size_of_val(&history[..]), 0);
                let raw = self.histories[begin..].chunks_exact_mut(size_of::<f64>());
                for (raw, number) in raw.zip(&history) {
                    raw.copy_from_slice(&number.to_le_bytes());
                }
            }
        }
    }
}

/// Appends what [`Plain::put`] of the [`SavedSlots`] with the slots of these parts would.
pub(super) fn put_stretches(pieces: &mut Pieces, nothing: &[f64], stretches: Vec<Stretch>) {
    nothing.to_vec().put(pieces.end());
    let slots: usize = stretches.iter().map(|stretch| stretch.slots).sum();
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
    /// No slots yet, for histories of the length of this one, which is empty.
    #[must_use]
    pub fn new(nothing: Vec<f64>) -> Self {
        Self {
            heads: Vec::new(),
            histories: Vec::new(),
            nothing,
        }
    }

    /// An empty list for the same histories.
    #[must_use]
    pub fn emptied(&self) -> Self {
        Self::new(self.nothing.clone())
    }

    /// Reserves memory for this many more slots.
    pub fn reserve(&mut self, slots: usize) {
        self.heads.reserve(slots);
    }

    /// Appends a slot with the history that it may have, whose numbers `write` appends to what it is given.
    pub fn push<H>(
        &mut self,
        slot: SavedSlot<'_>,
        own: Option<H>,
        write: impl FnOnce(H, &mut Vec<f64>),
    ) {
        let begin = self.histories.len();
        let remembers = own.is_some_and(|own| {
            write(own, &mut self.histories);
            remembers(&self.histories[begin..], &self.nothing)
        });
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

    /// Number of slots of the rows before this one, where slots are in the order of their rows.
    pub(super) fn before(&self, row: usize) -> usize {
        self.heads.partition_point(|head| (head.row as usize) < row)
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
        self.push(slot, Some(slot.history), |history, numbers| {
            numbers.extend_from_slice(history);
        });
    }

    /// Whether they can be pairs of so many rows, with histories of this length.
    ///
    /// # Errors
    /// The histories have another length, or a pair names a missing particle or image.
    pub fn check_pairs(&self, numbers: usize, rows: usize) -> Result<(), String> {
        self.check_numbers(numbers)?;
        let is_row = |row: u32| (row as usize) < rows;
        if !(self.heads.iter()).all(|head| is_row(head.row) && is_row(head.partner)) {
            return Err("a listed pair names a missing particle".to_owned());
        }
        if !(self.heads.iter()).all(|head| head.image < image::NEIGHBOURS) {
            return Err("a listed pair names a missing image".to_owned());
        }
        Ok(())
    }

    /// Checks the slots of rows near so many walls.
    ///
    /// # Errors
    /// The histories have another length, or a contact names a missing particle or wall.
    pub fn check_at_walls(&self, numbers: usize, rows: usize, walls: usize) -> Result<(), String> {
        self.check_numbers(numbers)?;
        let fits = |head: &Head| (head.row as usize) < rows && (head.partner as usize) < walls;
        if !self.heads.iter().all(fits) {
            return Err("it has contacts of particles or walls that are not there".to_owned());
        }
        Ok(())
    }

    fn check_numbers(&self, numbers: usize) -> Result<(), String> {
        let found = self.numbers();
        if found != numbers {
            return Err(format!(
                "its contacts remember {found} numbers each, those of the plan's laws {numbers}"
            ));
        }
        Ok(())
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

impl Plain for SavedSlots {
    fn put(&self, bytes: &mut Vec<u8>) {
        self.nothing.put(bytes);
        self.heads.len().put(bytes);
        let mut before = None;
        for head in &self.heads {
            head.put(before, bytes);
            before = Some(head.row);
        }
        self.histories.put(bytes);
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        let nothing = Plain::take(bytes)?;
        let count = announced(bytes)?;
        let mut before = None;
        let heads = (0..count).map(|_| {
            let head = Head::take(before, bytes)?;
            before = Some(head.row);
            Ok(head)
        });
        let slots = Self {
            nothing,
            heads: heads.collect::<Result<_, String>>()?,
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

impl SlotState {
    fn from_number(number: u8) -> Result<Self, String> {
        match number {
            0 => Ok(Self::Near),
            1 => Ok(Self::Touching),
            2 => Ok(Self::Adhering),
            3 => Ok(Self::Behind),
            4 => Ok(Self::Through),
            5 => Ok(Self::Joined),
            other => Err(format!("{other} is no state of a pair")),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::state::Encoder;

    /// A slot of a row `ahead` of the one before it: of any image, feature and state, the usual ones most often.
    fn any_slot() -> impl Strategy<Value = (u32, u32, u32, SlotState, u32, [f64; 2])> {
        let state = prop_oneof![
            Just(SlotState::Near),
            Just(SlotState::Touching),
            Just(SlotState::Adhering),
            Just(SlotState::Behind),
            Just(SlotState::Through),
            Just(SlotState::Joined)
        ];
        (
            prop_oneof![2 => Just(0), 1 => 1u32..3],
            any::<u32>(),
            prop_oneof![2 => Just(NO_SHIFT), 1 => 0u32..27],
            state,
            prop_oneof![2 => Just(FREE), 1 => any::<u32>()],
            prop_oneof![
                Just([0.0, 0.0]),
                Just([0.0, -0.0]),
                [-1.0f64..1.0, -1.0..1.0]
            ],
        )
    }

    fn same(a: &SavedSlot<'_>, b: &SavedSlot<'_>) -> bool {
        let bits =
            |slot: &SavedSlot<'_>| slot.history.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        (a.row, a.partner, a.image, a.state, a.feature)
            == (b.row, b.partner, b.image, b.state, b.feature)
            && bits(a) == bits(b)
    }

    proptest! {
        #[test]
        fn what_is_pushed_comes_back_to_the_bit(
            reported in proptest::collection::vec(any_slot(), 0..30)
        ) {
            let mut row = 5;
            let pushed: Vec<SavedSlot<'_>> = reported
                .iter()
                .map(|(ahead, partner, image, state, feature, history)| {
                    row += ahead;
                    SavedSlot {
                        row,
                        partner: *partner,
                        image: *image,
                        state: *state,
                        feature: *feature,
                        history,
                    }
                })
                .collect();
            let mut slots = SavedSlots::new(vec![0.0; 2]);
            pushed.iter().for_each(|&slot| slots.push_whole(slot));
            let something = |slot: &&SavedSlot<'_>| slot.history.iter().any(|x| x.to_bits() != 0);
            let remembering = pushed.iter().filter(something).count();
            prop_assert_eq!(slots.histories.len(), 2 * remembering);
            let mut bytes = Vec::new();
            slots.put(&mut bytes);
            let back = SavedSlots::take(&mut &bytes[..]).unwrap();
            prop_assert_eq!(back.len(), pushed.len());
            for (found, expected) in back.iter().zip(&pushed) {
                prop_assert!(same(&found, expected), "{:?} {:?}", found, expected);
            }

            // In parts of whole rows, as threads write them, the bytes are the same.
            let cut = pushed.iter().position(|slot| slot.row > 10).unwrap_or(pushed.len());
            let stretches = [&pushed[..cut], &pushed[cut..]].map(|part| {
                let mut stretch = Stretch::reusing(Vec::new(), Vec::new());
                // At walls, and as pairs, which have no features.
                let is_pair = |slot: &&SavedSlot<'_>| slot.feature == FREE;
                let rows: std::collections::BTreeSet<_> = part.iter().map(|slot| slot.row).collect();
                let most = if part.iter().all(|slot| is_pair(&slot)) {
                    most_bytes_of_pairs(part.len(), rows.len())
                } else {
                    part.len() * MOST_AT_WALL
                };
                stretch.reserve(most, part.len(), 2);
                let room = stretch.heads.capacity();
                let slots = part.iter().map(|slot| {
                    (SavedSlot { history: &[], ..*slot }, Some(slot.history))
                });
                stretch.extend(&[0.0; 2], slots, |history, all| all.extend(history));
                assert!(stretch.heads.len() <= most && stretch.heads.capacity() == room);
                stretch
            });
            let mut encoder = Encoder::new();
            encoder.section_by("slots", |pieces| put_stretches(pieces, &[0.0; 2], stretches.into()));
            let whole = encoder.finish();
            prop_assert!(whole.ends_with(&bytes));
        }

        #[test]
        fn arbitrary_bytes_are_refused_or_read(bytes in proptest::collection::vec(any::<u8>(), 0..100)) {
            let _ = SavedSlots::take(&mut &bytes[..]);
        }
    }

    #[test]
    fn no_slot_takes_more_bytes_than_there_is_room_for() {
        let slot = |row, image, feature| SavedSlot {
            row,
            partner: u32::MAX,
            image,
            state: SlotState::Touching,
            feature,
            history: &[1.0],
        };
        let bytes = |slots: &[SavedSlot<'static>]| {
            let mut stretch = Stretch::reusing(Vec::new(), Vec::new());
            let slots = slots.iter().map(|&slot| (slot, Some(slot.history)));
            stretch.extend(&[0.0], slots, |history, all| all.extend(history));
            stretch.heads.len()
        };
        // At a wall through a periodic face, on a feature of a mesh; pairs of two rows, all of images.
        assert_eq!(bytes(&[slot(7, 0, 3)]), MOST_AT_WALL);
        let pairs = [slot(7, 0, FREE), slot(7, 1, FREE), slot(9, 2, FREE)];
        assert_eq!(bytes(&pairs), most_bytes_of_pairs(3, 2));
        assert!(bytes(&[slot(7, NO_SHIFT, FREE)]) < most_bytes_of_pairs(1, 1));
    }

    #[test]
    fn slots_that_tell_of_nothing_are_refused() {
        let of = |head: &[u8]| {
            let mut bytes = Vec::new();
            Vec::<f64>::new().put(&mut bytes);
            1usize.put(&mut bytes);
            bytes.extend_from_slice(head);
            bytes.extend_from_slice(&[0; 8]);
            SavedSlots::take(&mut &bytes[..]).map(|slots| slots.len())
        };
        assert_eq!(of(&[OTHER_ROW, 1, 0, 0, 0, 2, 0, 0, 0]), Ok(1));
        assert!(of(&[0, 1, 0, 0, 0]).unwrap_err().contains("names no row"));
        assert!(
            of(&[UNUSED | OTHER_ROW, 1, 0, 0, 0, 2, 0, 0, 0])
                .unwrap_err()
                .contains("invalid contact record header")
        );
        assert!(
            of(&[OTHER_ROW | 6, 1, 0, 0, 0, 2, 0, 0, 0])
                .unwrap_err()
                .contains("no state")
        );
    }
}
