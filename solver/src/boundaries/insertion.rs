//! One insertion at work.

use glam::DVec3;
use mercury_common::random::Stream;

use super::crowd::Crowd;
use super::placement::{Room, overlaps_wall};
use super::{InsertionPlan, Tally, Total};
use crate::neighbours::Images;
use crate::particles::Particles;
use crate::plan::{NewParticle, Plan};
use crate::walls::WallState;

/// Why an insertion did not insert more in the last step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Limit {
    /// It has not begun.
    #[default]
    NotBegun,
    /// Its rate allows no more yet.
    Rate,
    /// Its attempts failed: the next particle found no space.
    Space,
    /// Its total is reached; for `full`: nothing fitted any more. It is finished.
    Total,
    /// Its time is over; it is finished.
    Time,
}

/// A particle that was drawn and waits for its place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pending {
    /// Index of the material.
    pub material: u32,
    /// m
    pub radius: f64,
}

/// What an insertion has done: all of it that must be kept to go on later.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct InsertionState {
    /// What came in.
    pub inserted: Tally,
    /// Placements that failed, since the start.
    pub failed_attempts: u64,
    /// Why no more came in.
    pub limit: Limit,
    /// The particle that comes next, if it has been drawn. It is never rejected, however long it waits for a place: rejecting
    /// what does not fit would favour small particles.
    pub pending: Option<Pending>,
    /// Positions of the random streams of sizes, places and velocities.
    pub drawn: [u64; 3],
}

impl InsertionState {
    /// Whether nothing will come any more.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        matches!(self.limit, Limit::Total | Limit::Time)
    }
}

/// An insertion: its state, and what it needs to go on.
#[derive(Debug, Clone)]
pub(super) struct Insertion {
    pub(super) state: InsertionState,
    room: Room,
    shares: f64,
    smallest_radius: f64,
    largest_radius: f64,
    mean_radius: f64,
    sizes: Stream,
    places: Stream,
    velocities: Stream,
    /// Who stands about the region, while that is known.
    crowd: Option<Crowd>,
}

/// What an insertion may look at beside the particles.
pub(super) struct Surroundings<'a> {
    pub(super) plan: &'a Plan,
    pub(super) images: &'a Images,
    pub(super) walls: &'a [WallState],
    pub(super) wall_images: &'a [Vec<u32>],
    /// How far particles may be from where they were listed, m.
    pub(super) margin: f64,
    /// s
    pub(super) time: f64,
}

impl Insertion {
    pub(super) fn new(insertion: &InsertionPlan, plan: &Plan) -> Self {
        let used = || {
            let positive = insertion.mixture.iter().filter(|part| part.share > 0.0);
            positive.map(|part| (&part.sizes, part.share))
        };
        let shares = used().map(|(_, share)| share).sum::<f64>();
        let mean = used()
            .map(|(sizes, share)| share * sizes.mean_diameter())
            .sum::<f64>();
        let stream = |what: &str| {
            Stream::new(
                plan.seed,
                &format!("insertion {} {what}", insertion.name),
                0,
            )
        };
        Self {
            state: InsertionState::default(),
            room: Room::new(&insertion.region, plan),
            shares,
            smallest_radius: used()
                .map(|(sizes, _)| 0.5 * sizes.smallest())
                .fold(f64::INFINITY, f64::min),
            largest_radius: used()
                .map(|(sizes, _)| 0.5 * sizes.largest())
                .fold(0.0, f64::max),
            mean_radius: 0.5 * mean / shares,
            sizes: stream("sizes"),
            places: stream("positions"),
            velocities: stream("velocities"),
            crowd: None,
        }
    }

    /// The state, with how far the streams were drawn.
    pub(super) fn state(&self) -> InsertionState {
        InsertionState {
            drawn: [
                self.sizes.position(),
                self.places.position(),
                self.velocities.position(),
            ],
            ..self.state
        }
    }

    /// Goes on from a state.
    pub(super) fn restore(&mut self, state: InsertionState) {
        let [sizes, places, velocities] = state.drawn;
        self.sizes = self.sizes.clone().at(sizes);
        self.places = self.places.clone().at(places);
        self.velocities = self.velocities.clone().at(velocities);
        self.state = state;
        self.crowd = None;
    }

    /// Forgets who stands about: rows or what is known of their positions changed.
    pub(super) fn forget_crowd(&mut self) {
        self.crowd = None;
    }

    /// Inserts what is due and fits; returns whether anything was inserted.
    pub(super) fn insert(
        &mut self,
        insertion: &InsertionPlan,
        particles: &mut Particles,
        around: &Surroundings<'_>,
    ) -> bool {
        // Times are whole numbers of steps up to round-off; a millionth of a step is far above it.
        let slack = 1e-6 * around.plan.time_step;
        if self.state.is_finished() || around.time < insertion.from - slack {
            return false;
        }
        if around.time >= insertion.until - slack {
            self.state.limit = Limit::Time;
            return false;
        }
        let before = particles.len();
        let mut failed = 0;
        self.state.limit = loop {
            if insertion.total_reached(&self.state.inserted) {
                break Limit::Total;
            }
            if insertion.rate_reached(&self.state.inserted, around.time - slack) {
                break Limit::Rate;
            }
            let Some(pending) = self.state.pending.or_else(|| self.draw(insertion)) else {
                // A mixture of nothing.
                break Limit::Total;
            };
            if self.place(pending, insertion, particles, around) {
                self.state.pending = None;
                failed = 0;
            } else {
                self.state.pending = Some(pending);
                self.state.failed_attempts += 1;
                failed += 1;
                if failed >= insertion.attempts || !self.room.has_space(pending.radius) {
                    break match insertion.total {
                        Some(Total::Full) => Limit::Total,
                        _ => Limit::Space,
                    };
                }
            }
        };
        particles.len() > before
    }

    /// Draws the next particle: the ingredient by its share, then its size. Two words. `None` if all shares are zero.
    fn draw(&mut self, insertion: &InsertionPlan) -> Option<Pending> {
        let mut left = self.sizes.uniform() * self.shares;
        let u = self.sizes.uniform();
        let mut chosen = None;
        for ingredient in insertion.mixture.iter().filter(|part| part.share > 0.0) {
            chosen = Some(ingredient);
            if left < ingredient.share {
                break;
            }
            left -= ingredient.share;
        }
        chosen.map(|chosen| Pending {
            material: chosen.material,
            radius: 0.5 * chosen.sizes.sample_diameter(u),
        })
    }

    /// Tries one place; on success the particle is there.
    fn place(
        &mut self,
        pending: Pending,
        insertion: &InsertionPlan,
        particles: &mut Particles,
        around: &Surroundings<'_>,
    ) -> bool {
        let (plan, images) = (around.plan, around.images);
        let radius = pending.radius;
        if !self.room.has_space(radius) {
            return false;
        }
        let Some(position) = self.room.draw(radius, &mut self.places, images) else {
            return false;
        };
        let crowd = self.crowd.get_or_insert_with(|| {
            let (low, high) = self.room.extent(self.smallest_radius);
            let edge = 2.0 * self.mean_radius;
            Crowd::new(low, high, self.largest_radius, edge, around.margin)
        });
        crowd.take_in(particles, images);
        if crowd.overlaps(particles, images, position, radius)
            || overlaps_wall(
                &plan.walls,
                around.walls,
                around.wall_images,
                images,
                position,
                radius,
            )
        {
            return false;
        }
        let deviation = DVec3::new(
            self.velocities.uniform_in(-1.0, 1.0),
            self.velocities.uniform_in(-1.0, 1.0),
            self.velocities.uniform_in(-1.0, 1.0),
        );
        let mut velocity = insertion.velocity_mean + deviation * insertion.velocity_spread;
        if plan.dimensions == 2 {
            velocity.z = 0.0;
        }
        let new = NewParticle {
            velocity,
            ..NewParticle::at(position, radius, pending.material)
        };
        let (record, mass, prescribed) = new.build(plan);
        particles.push(record, mass, prescribed);
        self.state.inserted.count(&record, mass, plan.dimensions);
        true
    }
}
