//! Contacts of the vertices of sheets with walls: those of spheres without spin.

use std::ops::Range;

use super::ContactLoop;
use super::block::Block;
use super::pass::{Pass, Rows};
use super::slots::{FREE, WallSlot};
use crate::contact::{AdhesionLaw, Histories, History, NormalLaw, RollingLaw, TangentialLaw};
use crate::forces::{FIRST_VERTEX, NearWall, Observation, SavedSlots, StepContext, Watch};
use crate::parallel::each_part_by;
use crate::state::{Load, Particle};

/// Vertices of a sheet that a thread takes at a time. Sums are made within these and then over them, so they do not depend on threads.
const PIECE: usize = 1024;

/// The pieces of a sheet that are near walls.
pub(super) type VertexBlocks<H> = Vec<Block<H>>;

/// The rows of the piece with this one.
fn piece_of(row: u32) -> Range<usize> {
    let start = row as usize / PIECE * PIECE;
    start..start + PIECE
}

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> ContactLoop<N, T, R, A> {
    /// New entries for the vertices of each sheet; slots go along with their vertex, wall and image.
    pub(super) fn take_near_vertices(&mut self, near_walls: &[Vec<NearWall>]) {
        let old = std::mem::take(&mut self.of_sheets);
        let mut old = old.into_iter();
        for near_walls in near_walls {
            let before = old.next().unwrap_or_default();
            let pieces = near_walls.chunk_by(|one, other| piece_of(one.row) == piece_of(other.row));
            let blocks = pieces.map(|near_walls| {
                let rows = piece_of(near_walls[0].row);
                let place = before.binary_search_by_key(&rows.start, |block| block.rows.start);
                let empty = Block::empty(rows);
                carried(place.map_or(&empty, |place| &before[place]), near_walls)
            });
            self.of_sheets.push(blocks.collect());
        }
    }

    /// Evaluates the contacts of a sheet's vertices, the `first` of which has this number among those of all sheets.
    pub(super) fn touch_vertices(
        &mut self,
        (sheet, first): (usize, usize),
        vertices: &[Particle],
        context: &StepContext<'_>,
        pool: Option<&rayon::ThreadPool>,
        loads: &mut [Load],
    ) {
        let context = StepContext {
            // Contacts of vertices have no records.
            watch: context.watch.map(|watch| Watch {
                records: false,
                ..watch
            }),
            feature_loads: false,
            ..*context
        };
        let pass = Pass {
            sheet: Some(sheet as u16),
            ..Pass::new(
                (&self.laws, self.materials),
                &self.memory,
                (&[], None, None),
                &context,
            )
        };
        let Some(blocks) = self.of_sheets.get_mut(sheet) else {
            return;
        };
        let mut loads = (0..).zip(loads.chunks_mut(PIECE));
        let mut pieces: Vec<(&mut Block<_>, &mut [Load])> = Vec::with_capacity(blocks.len());
        for block in blocks {
            let number = block.rows.start / PIECE;
            let own = loads.find(|(piece, _)| *piece == number);
            pieces.extend(own.map(|(_, loads)| (block, loads)));
        }
        let touch = |(block, loads): (&mut Block<_>, &mut [Load])| {
            if context.watch.is_some() {
                block.reports.observation = Observation::empty(context.walls.len());
            }
            block.reports.begin_wall_loads(&context);
            let start = block.rows.start;
            let own = &vertices[start..start + loads.len()];
            pass.walls(block, &Rows::together(own), loads);
            block.events.clear();
            block.reports.rubs.clear();
            block.reports.observation.largest_overlap = 0.0;
            for exchange in &mut block.reports.observation.exchanges {
                exchange.row += FIRST_VERTEX + first as u32;
            }
        };
        let pool = pool.filter(|_| pieces.len() > 1);
        each_part_by(pool, pieces, touch);
    }

    /// Memories of the contacts of vertices, sheet by sheet.
    pub(super) fn saved_vertices(&self) -> Vec<SavedSlots> {
        let saved = |blocks: &VertexBlocks<_>| {
            let mut saved = SavedSlots::new(Self::nothing());
            for block in blocks {
                for (slot, history) in block.saved_near_walls() {
                    saved.push(slot, history, Histories::<N, T, R, A>::write);
                }
            }
            saved
        };
        self.of_sheets.iter().map(saved).collect()
    }

    /// As saved.
    pub(super) fn restore_vertices(&mut self, saved: &[SavedSlots]) {
        let restored = |slots: &SavedSlots| {
            let mut blocks = VertexBlocks::new();
            for saved in slots.iter() {
                let rows = piece_of(saved.row);
                if blocks.last().is_none_or(|block| block.rows != rows) {
                    blocks.push(Block::empty(rows));
                }
                if let Some(block) = blocks.last_mut() {
                    let history = <Histories<N, T, R, A>>::read(saved.history);
                    block.push_saved_at_wall(&saved, history);
                }
            }
            blocks
        };
        self.of_sheets = saved.iter().map(restored).collect();
    }
}

/// A block with these entries and the slots that `before` has for them.
fn carried<H: crate::contact::History>(before: &Block<H>, near_walls: &[NearWall]) -> Block<H> {
    let mut block = Block::empty(before.rows.clone());
    let key = |near: &NearWall| (near.row, near.wall, near.image);
    let mut starts = Vec::with_capacity(before.near_walls.len());
    let mut start = 0;
    for near in &before.near_walls {
        starts.push(start);
        start += near.features as usize;
    }
    for near in near_walls {
        let place = before.near_walls.binary_search_by_key(&key(near), key);
        let slots = match place {
            Ok(place) => {
                let count = before.near_walls[place].features as usize;
                &before.wall_slots[starts[place]..starts[place] + count]
            }
            Err(_) => &[],
        };
        let kept: Vec<WallSlot<H>> = slots
            .iter()
            .filter(|slot| slot.feature != FREE)
            .copied()
            .collect();
        let features = (near.features as usize).max(kept.len());
        block.near_walls.push(NearWall {
            features: features as u32,
            ..*near
        });
        block.wall_slots.extend(kept.iter().copied());
        let free = features - kept.len();
        block.wall_slots.extend((0..free).map(|_| WallSlot::free()));
    }
    block
}
