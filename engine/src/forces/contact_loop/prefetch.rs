//! Prefetching of the memory of contacts that are evaluated soon.

use super::pass::Rows;
use super::slots::Slot;
use crate::lanes::MOST_LANES;
use crate::memory::prefetch;

/// Beyond this number of rows, the data of a step does not stay in the cache until the next step: some 600 bytes for each row. In
/// unit tests every scene prefetches.
pub(super) const BEYOND_CACHE: usize = if cfg!(test) { 0 } else { 50_000 };

/// The number of contacts that are evaluated between two requests.
pub(super) const PORTION: usize = 16;
const _: () = assert!(PORTION.is_multiple_of(MOST_LANES));

/// The number of slots of one request: a portion of contacts and the slots among them that do not touch.
const SLOTS: usize = 24;

/// The distance, in slots, by which slots are prefetched before their partners.
const AHEAD: usize = 128;

/// Prefetches the slots that follow a chunk, `later`, and their partners, when contact `base` of the chunk is evaluated next.
///
/// The processor predicts the addresses of the slots, but not those of their partners, and it can hold a dozen or two of pending
/// reads: prefetched all at once, they would hold up the evaluation, so they are requested in portions.
#[inline(always)]
pub(super) fn prefetch_ahead<H>(later: &[Slot<H>], rows: &Rows<'_>, first_row: usize, base: usize) {
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
