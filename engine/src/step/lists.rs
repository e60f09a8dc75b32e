//! The candidate lists: whether they still hold all contacts, and how they are built.

use super::snapshot::MOST_STEPS;
use super::{Core, Domain, Engine, RunError};
use crate::forces::{NearWall, NewList, block_size, find_near_walls};
use crate::memory::{MANY, give_back};
use crate::neighbours::{Cells, Common, Grid, Levels, Margin, Skin, Validity, extra_skins, used};
use crate::parallel::{each, holds_for_all};
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

    /// Sorts the particles and builds the candidate lists: finds the numbers of all particles together, puts the rows into order,
    /// searches, and hands the lists over to all that follow them.
    fn rebuild(&mut self) -> Result<(), RunError> {
        let Self { core, parts, .. } = self;
        core.complete_rows();
        let parallel = in_pool();
        let finite = |record: &Particle| record.position.is_finite();
        if !holds_for_all(&core.particles.records, parallel, finite) {
            return Err(core.not_finite());
        }
        (parts.iter_mut()).try_for_each(|part| part.before_list(core))?;
        core.adapt_skin();
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
        let (particles, cell) = (&mut core.particles, &core.domain.cell);
        let common = Common::find(particles, &extra, &levels, &margin, cell, parallel);
        let (grid, sorted) = common.order(particles, &mut extra);
        if let Some(share) = &mut core.ranks {
            share.divide(particles.len(), block_size(particles.len()));
        }
        let own = match &core.ranks {
            Some(share) => share.own_rows(particles.len()),
            None => 0..particles.len(),
        };
        let pairs = common.list(particles, &extra, &grid, own);
        core.note_images();
        let near_walls = core.near_walls(&extra, &grid, &margin, parallel);
        core.note_rooms(&extra, &margin);
        let new_row: Vec<Option<Row>> = each(removed.len(), parallel, |old| {
            removed[old].map(|row| sorted[row.index()])
        });
        let contacts = &mut core.contacts;
        match &mut core.ranks {
            Some(share) => share.with_all(|across| {
                contacts.adopt(&pairs, &near_walls, &new_row, Some(across), parallel);
            }),
            None => contacts.adopt(&pairs, &near_walls, &new_row, None, parallel),
        }
        let list = NewList {
            particles: &core.particles,
            pairs: &pairs,
            near_walls: &near_walls,
            new_row: &new_row,
            parallel,
        };
        parts.iter_mut().for_each(|part| part.new_list(&list));
        core.adopt(extra, grid, &levels);
        self.share_parts();
        if self.particles.len() > MANY {
            give_back();
        }
        Ok(())
    }
}

impl Core {
    /// Adapts the skin to how long the last list lasted, and how many of its pairs were idle.
    fn adapt_skin(&mut self) {
        if self.lists.validity.steps == 0 {
            return;
        }
        let [listed, touching] = self.count_pairs();
        let idle = listed - touching;
        let remembers = !self.history_columns().is_empty();
        self.lists.skin.adapt(
            self.lists.validity.steps,
            idle as f64 / self.particles.len().max(1) as f64,
            remembers,
        );
    }

    /// Notes the images at which bodies and walls stand now that particles are sorted.
    fn note_images(&mut self) {
        let cell = &self.domain.cell;
        let Particles {
            records, bodies, ..
        } = &mut self.particles;
        if let Some(bodies) = bodies {
            bodies.note_shifts(records, cell);
        }
        for wall in &mut self.domain.walls {
            wall.note_images(cell);
        }
    }

    /// The sorted particles that are near walls.
    fn near_walls(
        &self,
        extra: &[f64],
        grid: &Grid,
        margin: &Margin,
        parallel: bool,
    ) -> Vec<NearWall> {
        let (particles, Domain { walls, cell, .. }) = (&self.particles, &self.domain);
        let own = self.own_rows();
        let mut near = find_near_walls(particles, extra, grid, walls, cell, margin, &own, parallel);
        let unpaired = &particles.unpaired;
        if !unpaired.is_empty() {
            near.retain(|near| !unpaired.holds_wall(near.row, u32::from(near.wall.number())));
        }
        near
    }

    /// Takes a new list: boundaries, walls, sheets and the account of the skin.
    fn adopt(&mut self, extra: Vec<f64>, grid: Grid, levels: &Levels) {
        let skin = self.lists.skin.thickness;
        let most = extra.iter().copied().fold(0.0, f64::max);
        let Domain {
            cell,
            boundaries,
            walls,
            surfaces,
            ..
        } = &mut self.domain;
        boundaries.listed(&self.particles, cell, skin + 2.0 * most);
        if boundaries.expects_more() {
            let cells = Cells::of_list(grid, levels, &self.particles, cell);
            boundaries.take_cells(self.particles.len(), cells);
        }
        walls.iter_mut().for_each(WallNow::note_listed);
        surfaces.iter_mut().for_each(Surface::note_listed);
        self.lists.validity = Validity::default();
        self.lists.extra_skin = extra;
        self.lists.rows_changed = false;
        self.lists.rebuilds += 1;
        self.list_vertices(0.5 * skin);
    }

    fn are_lists_valid(&mut self) -> bool {
        let dt = self.physics.time_step;
        let limit = 0.5 * self.lists.skin.thickness;
        let mut valid = !self.lists.rows_changed;
        if valid {
            let part = self.fastest() * dt / limit;
            let own = self.own_rows();
            let Self {
                lists,
                particles,
                ranks,
                ..
            } = self;
            valid = lists.validity.advance(part, || {
                let skins = (limit, &lists.extra_skin[..]);
                let (used, lasts) = used(particles, own.clone(), skins, dt, in_pool());
                let mut largest = [used, f64::from(!lasts)];
                if let Some(share) = ranks {
                    share.ranks().largest(&mut largest);
                }
                (largest[0], largest[1] == 0.0)
            });
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
