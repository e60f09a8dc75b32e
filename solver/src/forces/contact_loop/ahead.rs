//! Asking for the memory of contacts that come soon.

use super::pass::Rows;
use super::slots::Slot;
use crate::lanes::MOST_LANES;
use crate::memory::prefetch;

/// With more rows than these, what a step reads does not stay in the cache until the next one: some 600 bytes for each row.
/// In unit tests all scenes are asked for.
pub(super) const BEYOND_CACHE: usize = if cfg!(test) { 0 } else { 50_000 };

/// So many contacts are evaluated between two requests.
pub(super) const PORTION: usize = 16;
const _: () = assert!(PORTION.is_multiple_of(MOST_LANES));

/// So many slots a request is for: a portion of contacts and those among them that do not touch.
const SLOTS: usize = 24;

/// How far before their partners slots are asked for, in slots.
const AHEAD: usize = 128;

/// Asks for the memory of slots that follow a chunk, `later`, and of their partners, when contact `base` of the chunk is evaluated next.
///
/// The processor foresees where the slots lie, but not their partners, and it has room for a dozen or two of reads that wait: asked for all at once, they would
/// hold up the evaluation, so they are asked for in portions.
#[inline(always)]
pub(super) fn ask_ahead<H>(later: &[Slot<H>], rows: &Rows<'_>, first_row: usize, base: usize) {
    let begin = base / PORTION * SLOTS;
    let of = |from: usize| {
        let upto = later.len().min(from + SLOTS);
        &later[from.min(upto)..upto]
    };
    for slot in of(begin) {
        prefetch(rows.ahead(slot.partner as usize - first_row));
    }
    of(begin + AHEAD).iter().for_each(prefetch);
}
