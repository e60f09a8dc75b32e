//! Sleeping as a part of the step.

use std::slice::{from_mut, from_ref};

use glam::DVec3;

use super::{SleepCounts, Sleeping};
use crate::bodies::BodyStep;
use crate::forces::{MotionBound, NewList};
use crate::lanes::Width;
use crate::state::{
    ASLEEP, FIXED, Load, PEBBLE, PRESCRIBED, Particle, Particles, Pieces, Plain, WOKEN,
};
use crate::step::{Core, Engine, Part, RunError, turn_orientations, unobserved};
use crate::walls::{Pose, Shape, WallNow};

/// To fall asleep, this part of the imbalance that wakes is allowed: round-off must not wake a particle that was just put to
/// rest.
const CALM: f64 = 0.5;
/// Place of a particle that was not slow at the last check: far from everywhere.
const NOWHERE: DVec3 = DVec3::INFINITY;

/// How many sleep.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Asleep {
    /// A clump is one.
    particles: u64,
    /// Spheres, and pebbles of clumps.
    rows: u64,
}

impl Asleep {
    fn of(particles: &Particles) -> Self {
        let sleepers = |flags: &u32| flags & ASLEEP != 0;
        let rows = particles.records.iter().map(|record| record.flags);
        let bodies = particles.bodies().iter().map(|body| body.flags);
        let alone = rows.clone().filter(|flags| flags & PEBBLE == 0);
        Self {
            particles: alone.chain(bodies).filter(sleepers).count() as u64,
            rows: rows.filter(sleepers).count() as u64,
        }
    }
}

/// The sleeping particles, and the data needed to put them to rest and to wake them.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sleep {
    plan: Sleeping,
    /// Positions at the last check of the particles that were slow then, m. By row.
    seen_at: Vec<DVec3>,
    /// What happened so far.
    counts: SleepCounts,
    /// How many sleep.
    asleep: Asleep,
    /// All sleepers are to be tested, not only those beside an awake particle: the lists are new, and particles may be gone, or a
    /// particle fell asleep.
    tests_all: bool,

    // What follows from the rest of the state.
    /// Which walls disturbed in the last step.
    stirs: Vec<bool>,
    /// Where each wall was then, and whether it was there.
    walls: Vec<(Pose, bool)>,
    /// How many lists had been built at the last update of the contacts.
    settled_at: u64,
    /// A particle fell asleep since.
    has_new: bool,
    /// Rows that were woken since the last update of the contacts.
    woken: Vec<u32>,
}

/// What a checkpoint holds of sleepers.
#[derive(Debug, Clone, PartialEq)]
struct SavedSleep {
    seen_at: Vec<DVec3>,
    counts: SleepCounts,
    tests_all: bool,
    wakes_all: bool,
    /// Which walls disturbed in the last step.
    stirs: Vec<bool>,
    /// What is held of each row.
    held: Vec<Load>,
}

crate::state::plain!(SavedSleep {
    seen_at,
    counts,
    tests_all,
    wakes_all,
    stirs,
    held
});

impl SavedSleep {
    /// Whether it can be of so many rows.
    fn fits(&self, rows: usize) -> bool {
        self.seen_at.len() == rows && self.held.len() == rows
    }
}

impl Sleep {
    /// No sleepers yet.
    fn new(plan: Sleeping) -> Self {
        Self {
            plan,
            seen_at: Vec::new(),
            counts: SleepCounts::default(),
            asleep: Asleep::default(),
            tests_all: false,
            stirs: Vec::new(),
            walls: Vec::new(),
            settled_at: 0,
            has_new: false,
            woken: Vec::new(),
        }
    }

    /// In scenes with `[sleeping]`.
    pub(crate) fn of(core: &Core) -> Option<Self> {
        core.physics.sleeping().map(Self::new)
    }

    /// Wakes a sleeper; of a body all pebbles.
    fn wake(&mut self, row: usize, particles: &mut Particles) {
        match particles
            .bodies
            .as_mut()
            .and_then(|bodies| Some((bodies.body_of_row(row)?, bodies)))
        {
            None => self.wake_row(row, &mut particles.records[row]),
            Some((body, bodies)) => {
                let body = &mut bodies.all[body.index()];
                body.flags &= !ASLEEP;
                for pebble in &bodies.pebbles[body.pebbles()] {
                    let row = pebble.row.index();
                    self.wake_row(row, &mut particles.records[row]);
                }
            }
        }
        self.counts.woken += 1;
        self.asleep.particles -= 1;
    }

    fn wake_row(&mut self, row: usize, record: &mut Particle) {
        record.flags = record.flags & !ASLEEP | WOKEN;
        self.seen_at[row] = NOWHERE;
        self.woken.push(row as u32);
        self.asleep.rows -= 1;
    }

    /// Notes a particle that fell asleep, of so many rows, with this kinetic energy (J).
    fn count(&mut self, rows: usize, energy: f64) {
        self.counts.energy += energy;
        self.counts.fell_asleep += 1;
        self.asleep.particles += 1;
        self.asleep.rows += rows as u64;
        self.has_new = true;
    }
}

/// By what part of its weight a particle is out of balance, a pebble with its body: by forces, or by torques at the lever of its radius.
fn imbalance(particles: &Particles, row: usize, gravity: DVec3) -> f64 {
    let body = (particles.bodies.as_ref())
        .and_then(|bodies| Some(&bodies.all[bodies.body_of_row(row)?.index()]));
    let (load, radius) = match body {
        Some(body) => (&body.load, body.radius),
        None => (&particles.loads[row], particles.records[row].radius),
    };
    // Of a pebble it is that of its body.
    let inverse_mass = particles.records[row].inverse_mass;
    let force = (load.force * inverse_mass + gravity).length();
    let torque = load.torque.length() * inverse_mass / radius;
    force.max(torque) / gravity.length()
}

/// Whether it is slower than `speed` (m/s), and so is its surface.
fn is_slow(record: &Particle, speed: f64) -> bool {
    let spin = record.angular_velocity.length() * record.radius;
    record.velocity.length() <= speed && spin <= speed
}

impl Part for Sleep {
    fn name(&self) -> &str {
        "sleep"
    }

    /// Wakes particles that are out of balance or disturbed, and, when a check is due, puts calm ones to rest.
    fn before_exchange(&mut self, core: &mut Core) {
        let plan = self.plan;
        let was_disturbed = self.note_walls(core);
        let wakes_all = std::mem::take(&mut core.has_new_surface);
        if self.asleep.rows > 0 {
            if wakes_all {
                self.wake_where(core, |_| true);
            } else if was_disturbed {
                self.wake_disturbed(core);
            }
            self.wake_unbalanced(core);
        }
        let woken = self.set_off(core);
        core.motion = core.motion.merge(woken);
        if core.step.is_multiple_of(plan.every) {
            self.put_to_rest(core);
        }
    }

    /// Takes the rows of a new list.
    fn new_list(&mut self, list: &NewList<'_>) {
        let places = vec![NOWHERE; list.particles.len()];
        let before = std::mem::replace(&mut self.seen_at, places);
        for (place, row) in before.into_iter().zip(list.new_row) {
            if let Some(row) = row {
                self.seen_at[row.index()] = place;
            }
        }
    }

    fn before_forces(&mut self, core: &mut Core) -> Result<(), RunError> {
        // The forces before the first step are of all particles.
        if core.step > 0 {
            self.settle(core);
        }
        Ok(())
    }

    fn put(&self, core: &Core, pieces: &mut Pieces) {
        let saved = SavedSleep {
            seen_at: self.seen_at.clone(),
            counts: self.counts,
            tests_all: self.tests_all,
            wakes_all: core.has_new_surface,
            stirs: self.stirs.clone(),
            held: core.contacts.held(),
        };
        saved.put(pieces.end());
    }

    fn take(&mut self, core: &mut Core, bytes: &mut &[u8]) -> Result<(), String> {
        let saved = SavedSleep::take(bytes)?;
        if !saved.fits(core.particles.len()) {
            return Err("the positions of sleepers do not match the particles".to_owned());
        }
        core.contacts.restore_held(&core.particles, &saved.held);
        core.has_new_surface = saved.wakes_all;
        let records = (0..).zip(&core.particles.records);
        let woken = records.filter(|(_, record)| record.flags & WOKEN != 0);
        *self = Self {
            woken: woken.map(|(row, _)| row).collect(),
            seen_at: saved.seen_at,
            counts: saved.counts,
            asleep: Asleep::of(&core.particles),
            tests_all: saved.tests_all,
            stirs: saved.stirs,
            walls: places(&core.walls).collect(),
            settled_at: core.lists.rebuilds,
            ..Self::new(self.plan)
        };
        Ok(())
    }
}

impl Engine {
    /// How many particles sleep, a clump as one, and the counts of sleepers; `None` where the plan does not enable sleeping.
    #[must_use]
    pub fn sleepers(&self) -> Option<(u64, SleepCounts)> {
        let sleep = self.part::<Sleep>()?;
        Some((sleep.asleep.particles, sleep.counts))
    }
}

impl Sleep {
    /// Subtracts the loads of the woken particles from the held ones, and makes up for the kick and the drift of this step, which
    /// they missed: no part of the forces that wake them is lost. Returns their motion.
    fn set_off(&mut self, core: &mut Core) -> MotionBound {
        if self.woken.is_empty() {
            return MotionBound::default();
        }
        hold_contacts(core, Some(&self.woken));
        let physics = &core.physics;
        let (gravity, dt) = (physics.gravity(), physics.time_step());
        let step = BodyStep {
            half: 0.5 * dt,
            drift: dt,
            kicks: 2,
            gravity,
            skins: core.lists.half_skins,
        };
        let mut fastest = MotionBound::default();
        for row in self.woken.drain(..) {
            let record = &mut core.particles.records[row as usize];
            record.flags &= !WOKEN;
            if let Some(bodies) = &mut core.particles.bodies
                && let Some(pebble) = bodies.of_row[row as usize]
            {
                let body = bodies.pebbles[pebble.index()].body;
                if bodies.all[body.index()].first as usize == pebble.index() {
                    let bound = bodies.advance_one(body, &mut core.particles.records, &step);
                    fastest = fastest.merge(bound);
                }
                continue;
            }
            let load = &core.particles.loads[row as usize];
            record.velocity += (load.force * record.inverse_mass + gravity) * dt;
            record.position += record.velocity * dt;
            if core.turns {
                let squared = record.radius * record.radius;
                let per_torque = core.inverse_inertia * record.inverse_mass / squared;
                record.angular_velocity += load.torque * (per_torque * dt);
            }
            if let Some(orientations) = &mut core.particles.orientations {
                let orientation = &mut orientations[row as usize];
                turn_orientations(from_mut(orientation), from_ref(record), dt, Width::ONE);
            }
            fastest = fastest.merge(MotionBound::of(record, &core.lists.half_skins));
        }
        fastest
    }

    /// Notes which walls disturb in this step; whether there are others than in the last one.
    fn note_walls(&mut self, core: &Core) -> bool {
        let mut is_new = false;
        self.stirs.resize(core.walls.len(), false);
        for (index, now) in core.walls.iter().enumerate() {
            let (pose, present) = (now.state.pose, now.state.present);
            let velocity = now.state.velocity;
            let moves = velocity.velocity != DVec3::ZERO
                || velocity.angular_velocity != DVec3::ZERO
                || !now.servos.is_empty();
            let is_other = (self.walls.get(index)).is_some_and(|before| *before != (pose, present));
            // The loads on triangles are summed up contact by contact, step by step.
            let is_summed = core.watched.triangle_loads && matches!(now.shape(), Shape::Mesh(_));
            let comes_or_goes = (self.walls.get(index)).is_some_and(|before| before.1 != present);
            // Surfaces that follow their wear move a little now and then.
            let follows = now.wears();
            let stirs = comes_or_goes || present && (moves || is_other || is_summed || follows);
            is_new |= stirs && !self.stirs[index];
            self.stirs[index] = stirs;
        }
        self.walls.clear();
        self.walls.extend(places(&core.walls));
        is_new
    }

    /// By rows: whether a particle is near a wall that disturbs, or near a particle whose motion is prescribed.
    fn disturbed(&self, core: &Core) -> Vec<bool> {
        let mut disturbed = vec![false; core.particles.len()];
        if self.stirs.contains(&true) || core.particles.has_prescribed() {
            let contacts = &core.contacts;
            contacts.mark_disturbed(&core.particles, &self.stirs, &mut disturbed);
        }
        disturbed
    }

    fn wake_disturbed(&mut self, core: &mut Core) {
        let disturbed = self.disturbed(core);
        self.wake_where(core, |row| disturbed[row]);
    }

    /// Wakes those of all sleepers for whose row this is true.
    fn wake_where(&mut self, core: &mut Core, is_meant: impl Fn(usize) -> bool) {
        for row in 0..core.particles.len() {
            if is_meant(row) && core.particles.records[row].flags & ASLEEP != 0 {
                self.wake(row, &mut core.particles);
            }
        }
    }

    fn wake_unbalanced(&mut self, core: &mut Core) {
        let gravity = core.physics.gravity();
        let particles = &mut core.particles;
        let tests_all = self.tests_all || core.needs.after_contacts;
        let rows = particles.len();
        let mut test = |row: usize| {
            let is_asleep = particles.records[row].flags & ASLEEP != 0;
            if is_asleep && imbalance(particles, row, gravity) > self.plan.imbalance {
                self.wake(row, particles);
            }
        };
        if tests_all {
            (0..rows).for_each(&mut test);
        } else {
            core.contacts.visit_borders(&mut test);
        }
    }

    /// Puts to rest the particles that were slow at the last check and are slow now, have hardly moved in between, and are in
    /// balance.
    fn put_to_rest(&mut self, core: &mut Core) {
        let physics = &core.physics;
        let (gravity, per_inertia) = (physics.gravity(), 1.0 / core.inverse_inertia);
        let way = self.plan.speed * self.plan.every as f64 * physics.time_step();
        let disturbed = self.disturbed(core);
        let particles = &mut core.particles;
        for (row, &is_disturbed) in disturbed.iter().enumerate() {
            let record = particles.records[row];
            if record.flags & (FIXED | PRESCRIBED | PEBBLE | ASLEEP) != 0 {
                continue;
            }
            let before = &mut self.seen_at[row];
            // A particle that was not slow at the last check is infinitely far from its place then.
            let is_slow = is_slow(&record, self.plan.speed);
            let is_calm = is_slow
                && record.position.distance(*before) <= way
                && !is_disturbed
                && imbalance(particles, row, gravity) <= CALM * self.plan.imbalance;
            *before = if is_slow { record.position } else { NOWHERE };
            if is_calm {
                let record = &mut particles.records[row];
                let inertia = per_inertia * record.radius * record.radius;
                let squares = record.velocity.length_squared()
                    + inertia * record.angular_velocity.length_squared();
                record.velocity = DVec3::ZERO;
                record.angular_velocity = DVec3::ZERO;
                record.flags |= ASLEEP;
                self.count(1, 0.5 * squares / record.inverse_mass);
            }
        }
        self.put_bodies_to_rest(core, &disturbed);
    }

    /// The same with bodies, each as a whole.
    fn put_bodies_to_rest(&mut self, core: &mut Core, disturbed: &[bool]) {
        let physics = &core.physics;
        let way = self.plan.speed * self.plan.every as f64 * physics.time_step();
        for index in 0..core.particles.bodies().len() {
            let particles = &core.particles;
            let Some(bodies) = &particles.bodies else {
                return;
            };
            let body = bodies.all[index];
            if body.flags & (FIXED | PRESCRIBED | ASLEEP) != 0 {
                continue;
            }
            let is_slow = body.velocity.length() <= self.plan.speed
                && body.angular_velocity.length() * body.radius <= self.plan.speed;
            let pebbles = &bodies.pebbles[body.pebbles()];
            let rows = || pebbles.iter().map(|pebble| pebble.row.index());
            let place = |row: usize| particles.records[row].position;
            let is_calm = is_slow
                && rows().all(|row| place(row).distance(self.seen_at[row]) <= way)
                && !rows().any(|row| disturbed[row])
                && imbalance(particles, pebbles[0].row.index(), physics.gravity())
                    <= CALM * self.plan.imbalance;
            for row in rows() {
                self.seen_at[row] = if is_slow { place(row) } else { NOWHERE };
            }
            if is_calm {
                let energy = 0.5 * body.mass * body.velocity.length_squared();
                self.count(pebbles.len(), energy + body.rotational_energy());
                core.particles.put_body_to_rest(index);
            }
        }
    }

    /// Updates the sleepers in the contacts, where these or the lists have changed. Lists are valid.
    fn settle(&mut self, core: &mut Core) {
        let is_listed_anew = self.settled_at != core.lists.rebuilds;
        // A particle that fell asleep was slow, and dashpots exert no force on it any more: a neighbour that a dashpot held back
        // is out of balance now, and may have no awake neighbour.
        self.tests_all = is_listed_anew || self.has_new;
        if is_listed_anew {
            self.settled_at = core.lists.rebuilds;
            // Rows are others, and some sleepers may be gone or near a wall that moves. Of these nothing is held yet.
            self.wake_disturbed(core);
            for row in self.woken.drain(..) {
                core.particles.records[row as usize].flags &= !WOKEN;
            }
            self.asleep = Asleep::of(&core.particles);
        }
        if is_listed_anew || self.has_new {
            hold_contacts(core, None);
            self.has_new = false;
        }
        self.counts.steps += core.particles.len() as u64;
        self.counts.slept += self.asleep.rows;
    }
}

/// Sums up the loads among sleepers; `woken`: the rows that were woken, if nothing else changed.
pub(crate) fn hold_contacts(core: &mut Core, woken: Option<&[u32]>) {
    let around = (&*core.walls, &*core.surfaces);
    let context = unobserved(&core.physics, &core.images, around, core.width);
    (core.contacts).hold(&core.particles, &context, core.pool.as_deref(), woken);
}

/// Where walls stand, and whether they are there.
fn places(walls: &[WallNow]) -> impl Iterator<Item = (Pose, bool)> {
    let states = walls.iter().map(|wall| &wall.state);
    states.map(|state| (state.pose, state.present))
}
