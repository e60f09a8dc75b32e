//! The candidate lists: whether they still hold all contacts, and how they are built.

use super::snapshot::MOST_STEPS;
use super::{Core, Engine, RunError};
use crate::forces::{NewList, find_near_walls};
use crate::memory::{MANY, give_back};
use crate::neighbours::{Built, Cells, Levels, Margin, Skin, Validity, build, extra_skins};
use crate::parallel::each;
use crate::state::{Particle, Particles, Row};
use crate::surface::Surface;
use crate::walls::WallNow;

/// Facts about the present lists.
#[derive(Debug, Clone, PartialEq)]
pub struct Lists {
    /// Thickness of the skin, and its limits.
    pub skin: Skin,
    /// How much farther than half the skin each particle may go before the list is built anew, m; empty if all may go as far.
    pub extra_skin: Vec<f64>,
    /// How much of the skin is used up.
    pub validity: Validity,
    /// Rows were added or removed since the list was built.
    pub rows_changed: bool,
    /// How often the list was built.
    pub rebuilds: u64,
}

impl Lists {
    /// Before the first one.
    pub(super) fn new(skin: Skin) -> Self {
        Self {
            skin,
            extra_skin: Vec::new(),
            validity: Validity::default(),
            rows_changed: true,
            rebuilds: 0,
        }
    }

    /// Whether it can be of so many rows.
    ///
    /// # Errors
    /// The skin, a number of steps, or the length of the extra skins is wrong.
    pub(super) fn check(&self, rows: usize) -> Result<(), String> {
        if !self.skin.is_possible() {
            return Err("invalid skin thickness".to_owned());
        }
        if self.rebuilds.max(self.validity.steps) > MOST_STEPS {
            return Err("more steps than a run can make".to_owned());
        }
        if ![0, rows].contains(&self.extra_skin.len()) {
            return Err("the extra skins do not match the particles".to_owned());
        }
        Ok(())
    }
}

impl Engine {
    /// Builds the candidate list anew if it may miss a contact.
    pub(super) fn keep_lists_valid(&mut self) -> Result<(), RunError> {
        if !self.are_lists_valid() {
            self.rebuild()?;
        }
        Ok(())
    }

    /// Sorts the particles and builds the candidate lists.
    fn rebuild(&mut self) -> Result<(), RunError> {
        let Self { core, parts, .. } = self;
        let finite = |record: &Particle| record.position.is_finite();
        if !core.particles.records.iter().all(finite) {
            return Err(core.not_finite());
        }
        (parts.iter_mut()).try_for_each(|part| part.before_list(core))?;
        if core.lists.validity.steps > 0 {
            let [listed, touching] = core.contacts.count();
            let idle = listed - touching;
            core.lists.skin.adapt(
                core.lists.validity.steps,
                idle as f64 / core.particles.len().max(1) as f64,
                !core.history_columns().is_empty(),
            );
        }
        let parallel = in_pool();
        let removed = core.domain.boundaries.take_row_map(core.particles.len());
        core.rename_images(&removed);
        let skin = core.lists.skin.thickness;
        let levels = Levels::choose(&core.particles.records, skin);
        let mut extra = extra_skins(&core.particles, &core.lists.skin, parallel);
        // Forces that act across a gap need their pairs listed that much farther out.
        let margin = Margin {
            skin,
            ranges: core.constants.ranges.clone(),
        };
        if let Some(bodies) = &mut core.particles.bodies {
            bodies.wrap(&core.domain.cell);
        }
        let Built {
            list,
            new_row: sorted,
            grid,
        } = build(
            &mut core.particles,
            &mut extra,
            &levels,
            &margin,
            &core.domain.cell,
            parallel,
        );
        let Particles {
            records, bodies, ..
        } = &mut core.particles;
        if let Some(bodies) = bodies {
            bodies.note_shifts(records, &core.domain.cell);
        }
        for wall in &mut core.domain.walls {
            wall.note_images(&core.domain.cell);
        }
        let mut near_walls = find_near_walls(
            &core.particles,
            &extra,
            &grid,
            &core.domain.walls,
            &core.domain.cell,
            &margin,
            parallel,
        );
        let unpaired = &core.particles.unpaired;
        if !unpaired.is_empty() {
            near_walls.retain(|near| !unpaired.holds_wall(near.row, u32::from(near.wall.number())));
        }
        core.note_rooms(&extra, &margin);
        let new_row: Vec<Option<Row>> = each(removed.len(), parallel, |old| {
            removed[old].map(|row| sorted[row.index()])
        });
        core.contacts.adopt(&list, &near_walls, &new_row, parallel);
        let list = NewList {
            particles: &core.particles,
            pairs: &list,
            near_walls: &near_walls,
            new_row: &new_row,
            parallel,
        };
        parts.iter_mut().for_each(|part| part.new_list(&list));
        let most = extra.iter().copied().fold(0.0, f64::max);
        core.domain
            .boundaries
            .listed(&core.particles, &core.domain.cell, skin + 2.0 * most);
        if core.domain.boundaries.expects_more() {
            let cells = Cells::of_list(grid, &levels, &core.particles, &core.domain.cell);
            core.domain
                .boundaries
                .take_cells(core.particles.len(), cells);
        }
        core.lists.validity = Validity::default();
        core.lists.extra_skin = extra;
        core.domain.walls.iter_mut().for_each(WallNow::note_listed);
        core.domain
            .surfaces
            .iter_mut()
            .for_each(Surface::note_listed);
        core.list_vertices(0.5 * skin);
        core.lists.rows_changed = false;
        core.lists.rebuilds += 1;
        if core.particles.len() > MANY {
            give_back();
        }
        Ok(())
    }
}

impl Core {
    fn are_lists_valid(&mut self) -> bool {
        let dt = self.physics.time_step;
        let limit = 0.5 * self.lists.skin.thickness;
        let mut valid = !self.lists.rows_changed;
        if valid {
            valid = self.lists.validity.advance(
                self.fastest() * dt / limit,
                dt,
                limit,
                &self.particles,
                &self.lists.extra_skin,
                in_pool(),
            );
        }
        let (about, reach) = (self.domain.cell.middle(), self.domain.cell.diagonal());
        // Sheets stand behind the walls of the plan.
        let rooms = std::iter::repeat_n(0.0, self.physics.walls.len());
        let rooms = rooms.chain(self.domain.surfaces.iter().map(|surface| surface.room));
        valid
            && self
                .domain
                .walls
                .iter()
                .zip(rooms)
                .all(|(wall, room)| wall.displacement_since_listed(about, reach) <= limit + room)
    }
}

impl Core {
    /// Before particles are put back into the domain: contacts with a wall go on by the image that is the same copy of it then.
    /// `present`: where each row of the last list is now.
    fn rename_images(&mut self, present: &[Option<Row>]) {
        let (cell, walls) = (&self.domain.cell, &self.domain.walls);
        if !cell.has_images() || walls.is_empty() {
            return;
        }
        let records = &self.particles.records;
        self.contacts.rename_images(&|row, wall, image| {
            let Some(row) = present[row as usize] else {
                return image;
            };
            let position = records[row.index()].position;
            let way = cell.wrap(position) - position;
            walls[wall.index()].renamed(cell, image, way)
        });
    }
}

/// Steps are made from within the pool, if there is one.
fn in_pool() -> bool {
    rayon::current_thread_index().is_some()
}

crate::state::plain!(Lists {
    skin,
    extra_skin,
    validity,
    rows_changed,
    rebuilds
});
