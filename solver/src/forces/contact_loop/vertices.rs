//! Contacts of the vertices of sheets with walls: those of spheres without spin.

use super::ContactLoop;
use super::block::Block;
use super::pass::{Pass, Rows};
use super::slots::{FREE, WallSlot};
use crate::contact::{AdhesionLaw, NormalLaw, RollingLaw, TangentialLaw};
use crate::forces::{FIRST_VERTEX, NearWall, Observation, StepContext, Watch};
use crate::state::{Load, Particle};

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> ContactLoop<N, T, R, A> {
    /// New entries for the vertices of each sheet; slots go along with their vertex, wall and image.
    pub(super) fn take_near_vertices(&mut self, near_walls: &[Vec<NearWall>]) {
        let old = std::mem::take(&mut self.of_sheets);
        let mut old = old.into_iter();
        for near_walls in near_walls {
            let before = old.next().unwrap_or_else(|| Block::empty(0..0));
            self.of_sheets.push(carried(&before, near_walls));
        }
    }

    /// Evaluates the contacts of a sheet's vertices, the `first` of which has this number among those of all sheets.
    pub(super) fn touch_vertices(
        &mut self,
        (sheet, first): (usize, usize),
        vertices: &[Particle],
        context: &StepContext<'_>,
        loads: &mut [Load],
    ) {
        let context = StepContext {
            // Contacts of vertices have no records, no alarms, and no films.
            watch: context.watch.map(|watch| Watch {
                records: false,
                ..watch
            }),
            films: None,
            overlap_limit: f64::INFINITY,
            deep: f64::INFINITY,
            feature_loads: false,
            ..*context
        };
        let pass = Pass::new(
            (&self.laws, self.materials),
            (&self.memory, self.block_size),
            (&[], None),
            &context,
        );
        let Some(block) = self.of_sheets.get_mut(sheet) else {
            return;
        };
        if context.watch.is_some() {
            block.observation = Observation::empty(context.walls.len());
        }
        pass.walls(block, &Rows::together(vertices), loads);
        block.events.clear();
        block.rubs.clear();
        block.observation.largest_overlap = 0.0;
        for exchange in &mut block.observation.exchanges {
            exchange.row += FIRST_VERTEX + first as u32;
        }
    }
}

/// A block with these entries and the slots that `before` has for them.
fn carried<H: crate::contact::History>(before: &Block<H>, near_walls: &[NearWall]) -> Block<H> {
    let mut block = Block::empty(0..0);
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
