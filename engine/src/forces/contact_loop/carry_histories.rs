//! Data that is kept when a candidate list is built: histories of contacts and lists of facets.

use std::ops::Range;

use rayon::prelude::*;

use super::across::{send_from_walls, send_pairs};
use super::slots::{FREE, Slot, TOUCHING, WITH_HISTORY, WallSlot};
use super::{Block, ContactLoop};
use crate::contact::{AdhesionLaw, Histories, History, NormalLaw, RollingLaw, TangentialLaw};
use crate::forces::{NearWall, block_size};
use crate::neighbours::CandidateList;
use crate::parallel::map_parts;
use crate::ranks::Across;
use crate::state::{Row, WallIndex};
use crate::walls::NearMeshes;

impl<H: History> Block<H> {
    /// Fills an empty block with the listed pairs and the walls near its rows; `carried` and `from_walls` are the histories of
    /// continuing contacts, the latter sorted by row.
    pub(super) fn fill(
        &mut self,
        list: &CandidateList,
        carried: &Carried<H>,
        near_walls: &[NearWall],
        from_walls: &[CarriedFromWall<H>],
    ) {
        let first = self.rows.start as u32;
        let listed = list.start[self.rows.end] - list.start[self.rows.start];
        self.slots.reserve_exact(listed as usize);
        for (owner, row) in self.rows.clone().enumerate() {
            let entries = &list.entries[list.start[row] as usize..list.start[row + 1] as usize];
            let kept = carried.of(row);
            for entry in entries {
                let history = kept
                    .iter()
                    .find(|kept| kept.0 == entry.partner)
                    .map(|kept| kept.1);
                // The pair has a history, by contact or by adhesion: the next evaluation decides which.
                let state = if history.is_some() { TOUCHING } else { 0 };
                let history = history.unwrap_or_default();
                let slot = Slot::new(owner, entry.partner, entry.image, state, history);
                self.slots.push(slot);
            }
        }
        let begin = near_walls.partition_point(|near| near.row < first);
        let end = near_walls.partition_point(|near| (near.row as usize) < self.rows.end);
        self.near_walls.reserve_exact(end - begin);
        for (near, of_wall) in with_others_of_wall(&near_walls[begin..end]) {
            let mut kept = going_on(near, of_wall, from_walls);
            // As many slots as features may be touched, and at least as many as there are histories.
            let held = kept.clone().count().max(near.features as usize);
            self.near_walls.push(NearWall {
                features: held as u32,
                ..*near
            });
            for _ in 0..held {
                let slot = kept.next().map(|kept| kept.1);
                self.wall_slots.push(slot.unwrap_or(WallSlot::free()));
            }
        }
    }
}

impl<H> Block<H> {
    /// Takes over the lists of facets for the particles and meshes in `near_walls`.
    pub(super) fn take_over(&mut self, carried: &CarriedNearMeshes) {
        for (index, near) in self.near_walls.iter().enumerate() {
            let key = (near.row, near.wall, near.image);
            let place = carried.places.binary_search_by_key(&key, |place| place.0);
            if let Ok(place) = place {
                let (block, number) = carried.places[place].1;
                let lists = &carried.of_block[block];
                self.near_meshes.take_over(index, lists, number);
            }
        }
    }
}

/// Each entry with all entries of the same particle and wall, by images.
fn with_others_of_wall(near: &[NearWall]) -> impl Iterator<Item = (&NearWall, &[NearWall])> {
    near.chunk_by(|a, b| (a.row, a.wall) == (b.row, b.wall))
        .flat_map(|of_wall| of_wall.iter().map(move |near| (near, of_wall)))
}

/// The continuing contacts with a wall by the image `near`: those that it had. If the particle or the wall was wrapped, an image
/// may have been replaced by another one: the contacts of the old image go to the first image that had none.
fn going_on<'a, H>(
    near: &NearWall,
    of_wall: &[NearWall],
    from_walls: &'a [CarriedFromWall<H>],
) -> impl Iterator<Item = &'a CarriedFromWall<H>> + Clone + use<'a, H> {
    let key = (near.row, near.wall);
    let begin = from_walls.partition_point(|kept| (kept.0.0, kept.0.1) < key);
    let end = from_walls.partition_point(|kept| (kept.0.0, kept.0.1) <= key);
    let held = &from_walls[begin..end];
    let had = |near: &NearWall| held.iter().any(|kept| kept.0.2 == near.image);
    let is_lost = |image: u32| !of_wall.iter().any(|near| near.image == image);
    let first_new = of_wall.iter().find(|near| !had(near));
    let wanted = if had(near) {
        Some(near.image)
    } else if first_new.is_some_and(|first| first.image == near.image) {
        held.iter()
            .map(|kept| kept.0.2)
            .find(|&image| is_lost(image))
    } else {
        None
    };
    held.iter().filter(move |kept| Some(kept.0.2) == wanted)
}

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> ContactLoop<N, T, R, A> {
    /// Histories of pairs that touch or adhere, by their new rows. Slots with histories are freed at the same time: memory
    /// holds each history once.
    pub(super) fn carried(
        &mut self,
        new_row: &[Option<Row>],
        rows: usize,
        across: Option<&mut Across<'_>>,
        parallel: bool,
    ) -> Carried<Histories<N, T, R, A>> {
        let parts = if parallel {
            rayon::current_num_threads()
        } else {
            1
        };
        let per_part = rows.div_ceil(parts).max(1);
        let of_block = |block: &mut Block<Histories<N, T, R, A>>| {
            let first = block.rows.start;
            let slots = std::mem::take(&mut block.slots);
            let held = |slot: &&Slot<_>| slot.state & WITH_HISTORY != 0;
            let pair = |slot: &Slot<Histories<N, T, R, A>>| {
                let row = new_row[first + slot.owner()]?.number();
                let partner = new_row[slot.partner as usize]?.number();
                Some(if row < partner {
                    (row, partner, slot.history)
                } else {
                    (partner, row, slot.history.swapped())
                })
            };
            by_parts(slots.iter().filter(held).filter_map(pair), per_part, parts)
        };
        let mut pairs: Vec<Vec<Vec<_>>> = if <Histories<N, T, R, A>>::LENGTH == 0 {
            Vec::new()
        } else {
            map_parts(parallel, &mut self.blocks[self.own.clone()], of_block)
        };
        if let Some(across) = across {
            let size = block_size(rows);
            let own = across.own();
            let leaves = |pair: &mut (u32, u32, _)| !own.contains(&(pair.0 as usize / size));
            let parts_of_blocks = pairs.iter_mut().flatten();
            let leaving = parts_of_blocks.flat_map(|part| part.extract_if(.., leaves));
            let leaving = leaving.collect();
            let came = send_pairs(across, size, leaving);
            pairs.push(by_parts(came, per_part, parts));
        }
        let of_part = |part: usize| {
            let pairs = pairs.iter().map(|of_block| &of_block[part][..]);
            let first = (part * per_part).min(rows);
            CarriedPart::new(pairs, first..(first + per_part).min(rows))
        };
        Carried {
            per_part,
            parts: map_parts(parallel, 0..parts, of_part),
        }
    }

    /// Wall histories by new row, wall and image.
    pub(super) fn carried_from_walls(
        &self,
        new_row: &[Option<Row>],
        rows: usize,
        across: Option<&mut Across<'_>>,
        parallel: bool,
    ) -> Vec<CarriedFromWall<Histories<N, T, R, A>>> {
        let of_block = |block: &Block<Histories<N, T, R, A>>| {
            let (mut first, mut carried) = (0, Vec::new());
            for near in &block.near_walls {
                let row = new_row[near.row as usize];
                for slot in &block.wall_slots[first..first + near.features as usize] {
                    if let (true, Some(row)) = (slot.feature != FREE, row) {
                        carried.push(((row.number(), near.wall, near.image), *slot));
                    }
                }
                first += near.features as usize;
            }
            carried
        };
        let mut carried = map_parts(parallel, self.own_blocks(), of_block).concat();
        if let Some(across) = across {
            let size = block_size(rows);
            let own = across.own();
            let leaves = |one: &mut CarriedFromWall<_>| !own.contains(&(one.0.0 as usize / size));
            let leaving = carried.extract_if(.., leaves).collect();
            carried.extend(send_from_walls(across, size, leaving));
        }
        // Those of one wall that a particle touches keep their order. The sorted values have no type of a law, so that the sort
        // is compiled once.
        let mut places: Vec<(NearKey, u32)> =
            (0..).zip(&carried).map(|(k, one)| (one.0, k)).collect();
        sort(&mut places, parallel);
        (places.into_iter().map(|(_, k)| carried[k as usize])).collect()
    }

    /// Takes the lists of facets out of the blocks.
    pub(super) fn carried_near_meshes(
        &mut self,
        new_row: &[Option<Row>],
        parallel: bool,
    ) -> CarriedNearMeshes {
        let (mut of_block, mut places) = (Vec::new(), Vec::new());
        for (number, block) in self.blocks[self.own.clone()].iter_mut().enumerate() {
            let lists = std::mem::take(&mut block.near_meshes);
            let listed = block.near_walls.iter().take(lists.len()).enumerate();
            for (index, near) in listed.filter(|&(index, _)| lists.holds(index)) {
                if let Some(row) = new_row[near.row as usize] {
                    places.push(((row.number(), near.wall, near.image), (number, index)));
                }
            }
            of_block.push(lists);
        }
        sort(&mut places, parallel);
        CarriedNearMeshes { of_block, places }
    }
}

/// Histories by the parts of the rows, of `per_part` rows each.
fn by_parts<H: Clone>(
    pairs: impl IntoIterator<Item = (u32, u32, H)>,
    per_part: usize,
    parts: usize,
) -> Vec<Vec<(u32, u32, H)>> {
    let mut of_part = vec![Vec::new(); parts];
    for pair in pairs {
        of_part[pair.0 as usize / per_part].push(pair);
    }
    of_part
}

/// Sorts a list without equal entries.
fn sort<T: Ord + Send>(list: &mut [T], parallel: bool) {
    if parallel {
        list.par_sort_unstable();
    } else {
        list.sort_unstable();
    }
}

/// Lists of facets that go on when a candidate list is built: they are expensive to make on fine meshes.
pub(super) struct CarriedNearMeshes {
    /// The lists of each block before.
    of_block: Vec<NearMeshes>,
    /// By new row, wall and image: block and number there.
    places: Vec<(NearKey, (usize, usize))>,
}

/// Histories of continuing contacts, sorted by the lower of their new rows.
pub(super) struct Carried<H> {
    /// The number of rows in a part; the last part may have fewer.
    per_part: usize,
    parts: Vec<CarriedPart<H>>,
}

impl<H: History> Carried<H> {
    pub(super) fn of(&self, row: usize) -> &[(u32, H)] {
        self.parts[row / self.per_part].of(row % self.per_part)
    }
}

/// The histories of a run of rows.
struct CarriedPart<H> {
    /// First entry of each row, and the number of entries at the end.
    start: Vec<u32>,
    /// The higher row, and the history as seen from the lower one; within a row in the order of the old slots.
    entries: Vec<(u32, H)>,
}

impl<H: History> CarriedPart<H> {
    fn new<'a>(pairs: impl Iterator<Item = &'a [(u32, u32, H)]> + Clone, rows: Range<usize>) -> Self
    where
        H: 'a,
    {
        let mut start = vec![0; rows.len() + 1];
        for pair in pairs.clone().flatten() {
            start[pair.0 as usize - rows.start + 1] += 1;
        }
        for row in 0..rows.len() {
            start[row + 1] += start[row];
        }
        let mut next = start.clone();
        let mut entries = vec![(0, H::default()); start[rows.len()] as usize];
        for &(row, partner, history) in pairs.flatten() {
            let place = &mut next[row as usize - rows.start];
            entries[*place as usize] = (partner, history);
            *place += 1;
        }
        Self { start, entries }
    }

    fn of(&self, row: usize) -> &[(u32, H)] {
        &self.entries[self.start[row] as usize..self.start[row + 1] as usize]
    }
}

/// Row, wall and image.
type NearKey = (u32, WallIndex, u32);

pub(super) type CarriedFromWall<H> = (NearKey, WallSlot<H>);
