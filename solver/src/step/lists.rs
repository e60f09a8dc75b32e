//! The candidate lists: whether they still hold all contacts, and how they are built.

use super::snapshot::MOST_STEPS;
use super::{Engine, RunError};
use crate::forces::{MotionBound, NewList, find_near_walls};
use crate::memory::{MANY, give_back};
use crate::neighbours::{Built, Cells, ExtraSkins, HalfSkins, Levels, Skin, Validity, build, each};
use crate::state::{Particle, Particles, Row};
use crate::surface::Surface;
use crate::walls::WallNow;

/// What is known of the present lists.
#[derive(Debug, Clone, PartialEq)]
pub struct Lists {
    /// Thickness of the skin, and its limits.
    pub skin: Skin,
    /// Half the skin of each level of sizes.
    pub half_skins: HalfSkins,
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
            half_skins: HalfSkins::default(),
            extra_skin: Vec::new(),
            validity: Validity::default(),
            rows_changed: true,
            rebuilds: 0,
        }
    }

    /// Whether it can be of so many rows.
    ///
    /// # Errors
    /// What is wrong.
    pub(super) fn check(&self, rows: usize) -> Result<(), String> {
        if !(self.skin.is_possible() && self.half_skins.is_possible()) {
            return Err("a skin that cannot be".to_owned());
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
    /// Builds the candidate list anew if it may miss a contact. `fastest`: how particles moved in this step.
    pub(super) fn keep_lists_valid(&mut self, fastest: MotionBound) -> Result<(), RunError> {
        let dt = self.plan.physics().time_step();
        let limit = 0.5 * self.lists.skin.thickness;
        let limit_of_walls = self.skin_of_walls();
        let mut valid = !self.lists.rows_changed;
        if valid {
            valid = self.lists.validity.advance(
                fastest.squared_part.sqrt() * dt,
                dt,
                limit,
                &self.particles,
                &self.lists.extra_skin,
                in_pool(),
            );
        }
        let reach = self.images.size.length();
        let about = self.images.min + 0.5 * self.images.size;
        valid = valid
            && self
                .walls
                .iter()
                .all(|wall| wall.displacement_since_listed(about, reach) <= limit_of_walls);
        if !valid {
            self.rebuild()?;
        }
        Ok(())
    }

    /// Largest thickness of the skin of the smallest particles, m.
    fn widest_skin(&self) -> f64 {
        let [_, mean, _] = self.plan.physics().radii();
        Skin::widest(mean)
    }

    /// How far surfaces of walls may get from where they were listed, m: as far as most particles, not as large ones that need more.
    fn skin_of_walls(&self) -> f64 {
        0.5 * self.lists.skin.thickness.min(self.widest_skin())
    }

    /// Sorts the particles and builds the candidate lists.
    fn rebuild(&mut self) -> Result<(), RunError> {
        let finite = |record: &Particle| record.position.is_finite();
        if !self.particles.records.iter().all(finite) {
            return Err(self.not_finite());
        }
        self.freshen_surfaces()?;
        if self.lists.validity.steps > 0 {
            let idle = self
                .forces
                .contacts
                .listed()
                .saturating_sub(self.forces.contacts.touching());
            self.lists.skin.adapt(
                self.lists.validity.steps,
                idle as f64 / self.particles.len().max(1) as f64,
                !self.forces.contacts.history_columns().is_empty(),
            );
        }
        let parallel = in_pool();
        let removed = self.boundaries.take_row_map(self.particles.len());
        self.rename_images(&removed);
        let widest = self.widest_skin();
        let Lists { skin, .. } = &mut self.lists;
        let levels = Levels::choose(&self.particles.records, skin.thickness.min(widest));
        let mut extra = ExtraSkins::measure(&self.particles, skin, &levels, widest, parallel);
        let skin = skin.thickness;
        // Forces that act across a gap need their pairs listed that much farther out.
        let range = self.forces.needs().range;
        self.count_periods();
        if let Some(bodies) = &mut self.particles.bodies {
            bodies.wrap(&self.images);
        }
        let Built {
            list,
            new_row: sorted,
            grid,
        } = build(
            &mut self.particles,
            &mut extra,
            &levels,
            skin + range,
            &self.images,
            parallel,
        );
        let Particles {
            records, bodies, ..
        } = &mut self.particles;
        if let Some(bodies) = bodies {
            bodies.note_shifts(records, &self.images);
        }
        for wall in &mut self.walls {
            wall.note_images(&self.images);
        }
        let skin_of_walls = self.skin_of_walls();
        let near_walls = find_near_walls(
            &self.particles,
            &extra.rows,
            &grid,
            &self.walls,
            &self.images,
            0.5 * skin + skin_of_walls + range,
            parallel,
        );
        self.note_near_surfaces(&near_walls);
        let new_row: Vec<Option<Row>> = each(removed.len(), parallel, |old| {
            removed[old].map(|row| sorted[row.index()])
        });
        if let Some(sleep) = &mut self.sleep {
            sleep.follow(&new_row, self.particles.len());
        }
        self.forces.adopt(&NewList {
            particles: &self.particles,
            pairs: &list,
            near_walls: &near_walls,
            new_row: &new_row,
            parallel,
        });
        let most = extra.rows.iter().copied().fold(0.0, f64::max);
        self.boundaries.listed(&self.particles, skin + 2.0 * most);
        if self.boundaries.expects_more() {
            let cells = Cells::of_list(grid, &levels, &self.particles, &self.images);
            self.boundaries.take_cells(self.particles.len(), cells);
        }
        self.lists.half_skins = HalfSkins::new(&levels, &extra, skin);
        self.lists.validity = Validity::default();
        self.lists.extra_skin = extra.rows;
        self.walls.iter_mut().for_each(WallNow::note_listed);
        self.surfaces.iter_mut().for_each(Surface::note_listed);
        self.list_vertices(skin_of_walls);
        self.lists.rows_changed = false;
        self.lists.rebuilds += 1;
        if self.particles.len() > MANY {
            give_back();
        }
        Ok(())
    }
}

impl Engine {
    /// Before particles are put back into the domain: contacts with a wall go on by the image that is the same copy of it then.
    /// `present`: where each row of the last list is now.
    fn rename_images(&mut self, present: &[Option<Row>]) {
        let (images, walls) = (&self.images, &self.walls);
        if !images.any() || walls.is_empty() {
            return;
        }
        let records = &self.particles.records;
        self.forces.contacts.rename_images(&|row, wall, image| {
            let Some(row) = present[row as usize] else {
                return image;
            };
            let position = records[row.index()].position;
            let way = images.wrap(position) - position;
            walls[wall.index()].renamed(images, image, way)
        });
    }
}

/// Steps are made from within the pool, if there is one.
fn in_pool() -> bool {
    rayon::current_thread_index().is_some()
}

crate::state::plain!(Lists {
    skin,
    half_skins,
    extra_skin,
    validity,
    rows_changed,
    rebuilds
});
