//! The state of one insertion during a run.

use glam::DVec3;
use mercury_common::random::Stream;

use super::behind::{is_behind_a_wall, is_in_wake};
use super::occupied::Occupied;
use super::passage::Look;
use super::placed_sizes::PlacedSizes;
use super::placement::{Extent, PlacementRegion, of_sphere, overlaps_wall};
use super::quota::Quota;
use super::wait::Wait;
use super::{BoundaryContext, InsertionPlan, Tally, Total};
use crate::bodies::{Clump, NewBody};
use crate::state::{MaterialIndex, NewParticle, Particles, Plain};
use crate::task::TaskProgress;
use crate::walls::WallNow;

/// Why an insertion did not insert more in the last step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Limit {
    /// The insertion has not begun.
    #[default]
    NotBegun,
    /// Its rate does not allow more yet.
    Rate,
    /// Its last round of attempts ended without a place for the next particle.
    Space,
    /// Its total is reached; for `full`: no more particles fit. It is finished.
    Total,
    /// Its time is over; it is finished.
    Time,
}

/// A particle or body that was drawn and waits for its place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pending {
    /// Index of the material.
    pub material: MaterialIndex,
    /// Index of the clump; `None`: a sphere.
    pub clump: Option<u32>,
    /// Radius of the sphere, or of the sphere of the body's volume, m.
    pub radius: f64,
    /// Index of the ingredient of the mixture.
    pub ingredient: u32,
}

/// A particle or body that is tried at a place.
enum New {
    Particle(NewParticle),
    Body(NewBody),
}

/// The state of an insertion: everything that a later continuation needs.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct InsertionState {
    /// The particles that it has placed.
    pub inserted: Tally,
    /// Placements that failed, since the start.
    pub failed_attempts: u64,
    /// The reason why it did not place more.
    pub limit: Limit,
    /// The next particle, if it has been drawn. It is never rejected, however long it waits for a place: rejecting what does not
    /// fit would favour small particles.
    pub pending: Option<Pending>,
    /// Positions of the random streams of sizes, places, velocities and orientations.
    pub drawn: [u64; 4],
    /// The time of the next attempt, while its region is full.
    pub wait: Wait,
    /// The sizes of the placed particles, by ingredient of the mixture; empty for ingredients of a single size.
    pub sizes: Vec<PlacedSizes>,
    /// The particles placed of each ingredient; ingredients after the last one placed are left out.
    pub brought: Vec<Tally>,
    /// Number of grains placed behind each of the [closing walls](InsertionPlan::closing); walls after the last one with any are
    /// left out.
    pub behind: Vec<u64>,
}

impl InsertionState {
    /// Whether the insertion has ended.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        matches!(self.limit, Limit::Total | Limit::Time)
    }
}

/// An insertion: its state, and the data that it needs to continue.
#[derive(Debug, Clone)]
pub(super) struct Insertion {
    pub(super) state: InsertionState,
    room: PlacementRegion,
    shares: f64,
    sizes: Stream,
    places: Stream,
    velocities: Stream,
    orientations: Stream,
    /// All particles to be inserted, where they are fixed in advance.
    quota: Option<Quota>,
}

/// The surroundings of an insertion beside the particles.
pub(super) struct InsertionContext<'a> {
    pub(super) setting: &'a BoundaryContext<'a>,
    pub(super) walls: &'a [WallNow],
    /// The largest distance of particles from their listed positions, m.
    pub(super) margin: f64,
    /// s
    pub(super) time: f64,
    /// Records the placed particles.
    pub(super) task_progress: &'a TaskProgress,
}

impl Insertion {
    pub(super) fn new(insertion: &InsertionPlan, setting: &BoundaryContext<'_>) -> Self {
        let used = insertion.mixture.iter().filter(|part| part.share > 0.0);
        let stream = |what: &str| {
            Stream::new(
                setting.seed,
                &format!("insertion {} {what}", insertion.name),
                0,
            )
        };
        Self {
            state: InsertionState::default(),
            room: PlacementRegion::new(&insertion.region, setting.space()),
            shares: used.map(|part| part.share).sum(),
            sizes: stream("sizes"),
            places: stream("positions"),
            velocities: stream("velocities"),
            orientations: stream("orientations"),
            quota: insertion.by_quota.then(|| Quota::new(insertion, setting)),
        }
    }

    /// The state, with the positions of the random streams.
    pub(super) fn state(&self) -> InsertionState {
        InsertionState {
            drawn: [
                self.sizes.position(),
                self.places.position(),
                self.velocities.position(),
                self.orientations.position(),
            ],
            ..self.state.clone()
        }
    }

    /// Grains that it has placed, a clump as one.
    pub(super) fn number_inserted(&self) -> u64 {
        self.state.inserted.number
    }

    /// Continues from a state.
    pub(super) fn restore(&mut self, state: InsertionState) {
        let [sizes, places, velocities, orientations] = state.drawn;
        self.sizes = self.sizes.clone().at(sizes);
        self.places = self.places.clone().at(places);
        self.velocities = self.velocities.clone().at(velocities);
        self.orientations = self.orientations.clone().at(orientations);
        self.state = state;
    }

    /// Whether it looks for places at this time.
    pub(super) fn is_due(&self, insertion: &InsertionPlan, time: f64, time_step: f64) -> bool {
        let slack = 1e-6 * time_step;
        let is_complete = match &self.quota {
            Some(quota) => self.state.inserted.number >= quota.len(),
            None => insertion.total_reached(&self.state.inserted),
        };
        !self.state.is_finished()
            && (insertion.from - slack..insertion.until - slack).contains(&time)
            && self.state.wait.clone().step()
            && !is_complete
            && !insertion.rate_reached(&self.state.inserted, time - slack)
    }

    /// Inserts what is due and fits; returns whether anything was inserted.
    pub(super) fn insert(
        &mut self,
        insertion: &InsertionPlan,
        particles: &mut Particles,
        occupied: &mut Occupied,
        around: &InsertionContext<'_>,
    ) -> bool {
        // Times are whole numbers of steps up to round-off; a millionth of a step is far above it.
        let slack = 1e-6 * around.setting.time_step;
        if self.state.is_finished() || around.time < insertion.from - slack {
            return false;
        }
        if around.time >= insertion.until - slack {
            self.state.limit = Limit::Time;
            return false;
        }
        if !self.state.wait.step() {
            return false;
        }
        let before = particles.len();
        let mut failed = 0;
        self.state.limit = loop {
            let is_complete = match &self.quota {
                Some(quota) => self.state.inserted.number >= quota.len(),
                None => insertion.total_reached(&self.state.inserted),
            };
            if is_complete {
                break Limit::Total;
            }
            if insertion.rate_reached(&self.state.inserted, around.time - slack) {
                break Limit::Rate;
            }
            let Some(pending) = self.state.pending.or_else(|| self.draw(insertion)) else {
                // A mixture without ingredients.
                break Limit::Total;
            };
            if around.task_progress.is_given_up() {
                self.state.pending = Some(pending);
                break Limit::Space;
            }
            if self.place(pending, insertion, particles, occupied, around) {
                self.state.pending = None;
                self.state.wait.succeeded();
                around.task_progress.note_placed();
                self.count_size(pending, insertion);
                failed = 0;
            } else {
                self.state.pending = Some(pending);
                self.state.failed_attempts += 1;
                failed += 1;
                let clump = pending
                    .clump
                    .map(|index| &around.setting.clumps[index as usize]);
                let pebbles = clump.map_or(1, |clump| clump.pebbles.len());
                let tries = (self.state.wait).tries(insertion.attempts, before, pebbles);
                if failed >= tries || !self.may_fit(pending, around.setting) {
                    self.state.wait.failed();
                    break match insertion.total {
                        Some(Total::Full) => Limit::Total,
                        _ => Limit::Space,
                    };
                }
            }
        };
        particles.len() > before
    }

    /// Whether the waiting particle has a free position now, as far as `attempts` tries show; true if none waits. Changes
    /// nothing.
    pub(super) fn has_place(
        &self,
        insertion: &InsertionPlan,
        particles: &Particles,
        around: &InsertionContext<'_>,
    ) -> bool {
        let Some(pending) = self.state.pending else {
            return true;
        };
        let (mut probe, mut occupied) = (self.clone(), Occupied::default());
        occupied.take_in(particles, around.setting.cell);
        (0..insertion.attempts).any(|_| {
            let place = probe.find_place(pending, particles, &occupied, around);
            place.is_some()
        })
    }

    /// The next particle: of the quota, or drawn, the ingredient by its share, then its size, with two words. `None` if there is
    /// none.
    fn draw(&mut self, insertion: &InsertionPlan) -> Option<Pending> {
        if let Some(quota) = &self.quota {
            let (index, diameter) = quota.next(self.state.inserted.number, &insertion.mixture)?;
            let chosen = &insertion.mixture[index];
            return Some(Pending {
                material: chosen.material,
                clump: chosen.clump,
                radius: 0.5 * diameter,
                ingredient: index as u32,
            });
        }
        let mut left = self.sizes.uniform() * self.shares;
        let u = self.sizes.uniform();
        let mut chosen = None;
        let used = insertion.mixture.iter().enumerate();
        for (index, ingredient) in used.filter(|(_, part)| part.share > 0.0) {
            chosen = Some((index, ingredient));
            if left < ingredient.share {
                break;
            }
            left -= ingredient.share;
        }
        chosen.map(|(index, chosen)| Pending {
            material: chosen.material,
            clump: chosen.clump,
            radius: 0.5 * chosen.sizes.sample_diameter(u),
            ingredient: index as u32,
        })
    }

    /// Stores the size of a placed particle, for the check at the end.
    fn count_size(&mut self, placed: Pending, insertion: &InsertionPlan) {
        let index = placed.ingredient as usize;
        let asked_for = &insertion.mixture[index].sizes;
        if asked_for.has_single_sizes() {
            return;
        }
        let known = self.state.sizes.len().max(index + 1);
        self.state.sizes.resize_with(known, PlacedSizes::default);
        // For a quota, at most as many as are fixed in advance.
        self.state.sizes[index].count(2.0 * placed.radius, asked_for, insertion.by_quota);
    }

    /// Whether the region has space for a particle at all; for a body, space for its largest pebble.
    fn may_fit(&self, pending: Pending, setting: &BoundaryContext<'_>) -> bool {
        let radius = match pending.clump {
            None => pending.radius,
            Some(index) => {
                let clump = &setting.clumps[index as usize];
                clump.pebble_radii().1 * scale(&pending, clump)
            }
        };
        self.room.has_space(of_sphere(radius), setting.cell)
    }

    /// Tries one position, and for a body one orientation; on success the particle is placed.
    fn place(
        &mut self,
        pending: Pending,
        insertion: &InsertionPlan,
        particles: &mut Particles,
        occupied: &mut Occupied,
        around: &InsertionContext<'_>,
    ) -> bool {
        let setting = around.setting;
        occupied.take_in(particles, around.setting.cell);
        let Some(new) = self.find_place(pending, particles, occupied, around) else {
            return false;
        };
        let deviation = DVec3::new(
            self.velocities.uniform_in(-1.0, 1.0),
            self.velocities.uniform_in(-1.0, 1.0),
            self.velocities.uniform_in(-1.0, 1.0),
        );
        let mut velocity = insertion.velocity_mean + deviation * insertion.velocity_spread;
        if setting.dimensions == 2 {
            velocity.z = 0.0;
        }
        let place = match &new {
            New::Particle(new) => new.position,
            New::Body(new) => new.position,
        };
        for (number, &wall) in insertion.closing.iter().enumerate() {
            if is_in_wake(&around.walls[wall], around.setting.cell, place) {
                let known = self.state.behind.len().max(number + 1);
                self.state.behind.resize(known, 0);
                self.state.behind[number] += 1;
            }
        }
        let inserted = &mut self.state.inserted;
        let index = pending.ingredient as usize;
        let known = self.state.brought.len().max(index + 1);
        self.state.brought.resize(known, Tally::default());
        let of_ingredient = &mut self.state.brought[index];
        let first = particles.len();
        let look = match new {
            New::Particle(new) => {
                let new = NewParticle { velocity, ..new };
                let (record, mass, prescribed) = new.build(setting.materials, setting.dimensions);
                particles.push(record, mass, prescribed);
                Look::of_particle(particles.ids[first], &record, mass, setting.dimensions)
            }
            New::Body(new) => {
                let new = NewBody { velocity, ..new };
                new.add_to(particles, setting.clumps);
                Look::of_body(&new.body(setting.clumps))
            }
        };
        inserted.count(&look);
        of_ingredient.count(&look);
        let properties = &insertion.mixture[index].properties;
        if !properties.is_empty() {
            let rows: Vec<usize> = (first..particles.len()).collect();
            for &(property, value) in properties {
                particles.give(property, &rows, value);
            }
        }
        true
    }

    /// A position at which the pending particle lies in the region and overlaps nothing, found with one draw; at rest there.
    fn find_place(
        &mut self,
        pending: Pending,
        particles: &Particles,
        occupied: &Occupied,
        around: &InsertionContext<'_>,
    ) -> Option<New> {
        let setting = around.setting;
        let sphere = [(DVec3::ZERO, pending.radius)];
        let Some(index) = pending.clump else {
            let extent = of_sphere(pending.radius);
            let position = self.find_centre(&sphere, extent, particles, occupied, around)?;
            let new = NewParticle::at(position, pending.radius, pending.material);
            return Some(New::Particle(new));
        };
        let clump = &setting.clumps[index as usize];
        let mut body = NewBody {
            scale: scale(&pending, clump),
            orientation: self.orientations.unit_quaternion(),
            ..NewBody::at(DVec3::ZERO, index)
        };
        let spheres: Vec<(DVec3, f64)> = body.spheres(clump).collect();
        let extent = clump.extent(body.scale, body.orientation);
        body.position = self.find_centre(&spheres, extent, particles, occupied, around)?;
        Some(New::Body(body))
    }

    /// A centre for spheres at these offsets (m) and of these radii (m), of the given extent.
    fn find_centre(
        &mut self,
        spheres: &[(DVec3, f64)],
        extent: Extent,
        particles: &Particles,
        occupied: &Occupied,
        around: &InsertionContext<'_>,
    ) -> Option<DVec3> {
        let cell = around.setting.cell;
        let centre = (self.room).draw(spheres, extent, &mut self.places, cell)?;
        let at = |offset: DVec3| cell.wrap(centre + offset);
        // Particles before walls: walls take longer to test and seldom block a position that is free of particles.
        let is_free = spheres.iter().all(|&(offset, radius)| {
            !occupied.overlaps(particles, cell, (at(offset), radius), around.margin)
        }) && spheres.iter().all(|&(offset, radius)| {
            !overlaps_wall(around.walls, cell, at(offset), radius)
                && !is_behind_a_wall(around.walls, cell, at(offset))
        });
        is_free.then_some(centre)
    }
}

/// The factor on the lengths of a clump that gives it the pending size.
fn scale(pending: &Pending, clump: &Clump) -> f64 {
    2.0 * pending.radius / clump.equal_volume_diameter()
}

crate::state::plain!(Pending {
    material,
    clump,
    radius,
    ingredient
});
crate::state::plain!(InsertionState {
    inserted,
    failed_attempts,
    limit,
    pending,
    drawn,
    wait,
    sizes,
    brought,
    behind
});

impl Plain for Limit {
    fn put(&self, bytes: &mut Vec<u8>) {
        let number: u8 = match self {
            Self::NotBegun => 0,
            Self::Rate => 1,
            Self::Space => 2,
            Self::Total => 3,
            Self::Time => 4,
        };
        number.put(bytes);
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        match u8::take(bytes)? {
            0 => Ok(Self::NotBegun),
            1 => Ok(Self::Rate),
            2 => Ok(Self::Space),
            3 => Ok(Self::Total),
            4 => Ok(Self::Time),
            other => Err(format!(
                "{other} is not a valid reason for an insertion to wait"
            )),
        }
    }
}
