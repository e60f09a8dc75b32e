//! The engine: it owns the state and makes time steps.

use std::sync::{Arc, Mutex, PoisonError};

mod awake;
mod load_series;
mod motion;
mod snapshot;
#[cfg(test)]
mod tests;

pub use load_series::LoadSeries;
pub use snapshot::Snapshot;

use awake::awake;
use motion::{KickDrift, turn_orientations};

use glam::{DQuat, DVec3};
use rayon::prelude::*;

use crate::bodies::BodyStep;
use crate::boundaries::Boundaries;
use crate::contact::HistoryNumber;
use crate::contact::registry::contact_loop;
use crate::forces::{
    ContactForces, Fastest, Observation, StepContext, Watch, block_size, find_near_walls,
};
use crate::neighbours::{Images, Skin, Validity, build, leeways};
use crate::plan::Plan;
use crate::state::{FIXED, Load, PRESCRIBED, Particle, Particles, inverse_inertia_factor};
use crate::walls::{Pose, ServoState, WallState};

/// Why a run cannot go on.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RunError {
    /// A position or velocity is no longer a number.
    #[error(
        "step {step} (t = {time} s): particle {id} has left the numbers (position {position}, velocity {velocity})\n\
         help: the time step is too large for the contacts that occur, or particles were placed deep inside one another; \
         see the plan for the critical step"
    )]
    NotFinite {
        /// Step.
        step: u64,
        /// Time, s.
        time: f64,
        /// Id of the particle.
        id: u32,
        /// Position, m.
        position: DVec3,
        /// Velocity, m/s.
        velocity: DVec3,
    },
    /// Threads could not be started.
    #[error("the threads cannot be started: {0}")]
    Threads(String),
}

/// The engine: the whole state of a run and the way from one step to the next.
pub struct Engine {
    plan: Arc<Plan>,
    /// All particles.
    pub particles: Particles,
    forces: Box<dyn ContactForces>,
    law_names: String,
    images: Images,
    boundaries: Boundaries,
    wall_states: Vec<WallState>,
    /// One for each wall if any has a servo; empty otherwise.
    servos: Vec<ServoState>,
    skin: Skin,
    /// How much farther than half the skin each particle may go before the list is built anew, m; empty if none may.
    leeway: Vec<f64>,
    validity: Validity,
    /// Poses of the walls when the list was built.
    listed_poses: Vec<Pose>,
    /// Walls that move.
    moving_walls: Vec<usize>,
    step: u64,
    /// The second half kick of the last step is still to be made; it is made together with the next one.
    kick_due: bool,
    /// The present step was begun when the last one ended: its kicks and drift are made already.
    drifted: Option<Fastest>,
    /// Rows were added or removed since the list was built.
    rows_changed: bool,
    /// How often the list was built.
    rebuilds: u64,
    inverse_inertia: f64,
    turns: bool,
    pool: Option<Arc<rayon::ThreadPool>>,
    /// Running sums of the energy audit.
    audit: Audit,
    /// Running sums of the loads on the triangles of meshes.
    load_series: LoadSeries,
}

/// What happened to the energy since the start, J; filled only in audited runs.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Audit {
    /// By viscous and plastic normal forces.
    pub dissipated_normal: f64,
    /// By sliding friction and tangential dashpots.
    pub dissipated_tangential: f64,
    /// By rolling and torsion resistance.
    pub dissipated_rolling: f64,
    /// Done by the walls on the particles.
    pub wall_work: f64,
}

impl Audit {
    /// Dissipated by all mechanisms, J.
    #[must_use]
    pub fn dissipated(&self) -> f64 {
        self.dissipated_normal + self.dissipated_tangential + self.dissipated_rolling
    }
}

impl Engine {
    /// The state at the start of a planned run, its first forces evaluated, for `threads` threads.
    ///
    /// # Errors
    /// If threads cannot be started, or the start is not a number.
    pub fn new(plan: Arc<Plan>, threads: usize) -> Result<Self, RunError> {
        let mut engine = Self::unstarted(plan, threads)?;
        engine.exchange_particles();
        engine.keep_lists_valid(0.0)?;
        let spring_time = if engine.plan.startup_increment {
            engine.plan.time_step
        } else {
            0.0
        };
        engine.evaluate_forces(
            spring_time,
            Some(Watch {
                records: true,
                audit: None,
            }),
            false,
        );
        // The first step begins with its own half kick alone.
        engine.kick_due = false;
        Ok(engine)
    }

    /// The particles and walls of a plan as they are placed, without lists and forces.
    fn unstarted(plan: Arc<Plan>, threads: usize) -> Result<Self, RunError> {
        let (forces, law_names) = contact_loop(&plan.laws);
        let images = Images::new(plan.domain_min, plan.domain_max, plan.periodic);
        let mut particles = Particles::new(plan.orientations);
        for new in &plan.particles {
            let (record, mass, prescribed) = new.build(&plan);
            particles.push(record, mass, prescribed);
        }
        for new in &plan.bodies {
            new.add_to(&mut particles, &plan);
        }
        let pool = match threads {
            0 | 1 => None,
            _ => {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
                Some(Arc::new(
                    pool.map_err(|error| RunError::Threads(error.to_string()))?,
                ))
            }
        };
        let wall_states: Vec<_> = plan
            .walls
            .iter()
            .map(|wall| wall.state(0.0, plan.time_step))
            .collect();
        let has_servo = plan
            .walls
            .iter()
            .any(|wall| wall.motion.servo(0.0).is_some());
        let servos = vec![ServoState::default(); if has_servo { plan.walls.len() } else { 0 }];
        let moving_walls = plan
            .walls
            .iter()
            .enumerate()
            .filter(|(_, wall)| !wall.motion.is_static())
            .map(|(index, _)| index)
            .collect();
        let mut skin = Skin::new(plan.smallest_radius, plan.mean_radius);
        let mut room = f64::INFINITY;
        for axis in 0..3 {
            if plan.periodic[axis] {
                room = room.min(0.5 * images.size[axis] - 2.0 * plan.largest_radius);
            }
        }
        skin.limit(0.99 * room);
        Ok(Self {
            boundaries: Boundaries::new(&plan),
            inverse_inertia: inverse_inertia_factor(plan.dimensions),
            turns: plan.laws.turns(),
            plan,
            particles,
            forces,
            law_names,
            images,
            wall_states,
            servos,
            skin,
            leeway: Vec::new(),
            validity: Validity::default(),
            listed_poses: Vec::new(),
            moving_walls,
            step: 0,
            kick_due: false,
            drifted: None,
            rows_changed: true,
            rebuilds: 0,
            pool,
            audit: Audit::default(),
            load_series: LoadSeries::default(),
        })
    }

    /// Makes one time step: velocity Verlet as kick, drift, kick, rotation alike.
    ///
    /// `watch` says what to see of the contacts; the [`Engine::observation`] then belongs to the end of the step.
    ///
    /// # Errors
    /// If a particle's motion is no longer a number.
    pub fn step(&mut self, watch: Option<Watch>) -> Result<(), RunError> {
        self.steps_at_once(1, watch)
    }

    /// Makes `count` time steps; `watch` is for the last one. The result is that of `count` calls of [`Engine::step`], to the
    /// bit, but nobody looks in between, so that each block of particles can go on to the next step while it is in the cache.
    ///
    /// # Errors
    /// If a particle's motion is no longer a number.
    pub fn steps_at_once(&mut self, count: u64, watch: Option<Watch>) -> Result<(), RunError> {
        let pool = self.pool.clone();
        let mut run = || {
            (1..=count).try_for_each(|k| {
                let last = k == count;
                self.one_step(if last { watch } else { None }, !last)
            })
        };
        match pool {
            Some(pool) => pool.install(|| awake(run)),
            None => run(),
        }
    }

    /// The time step. `go_on`: kick and drift into the next step as soon as forces are known.
    fn one_step(&mut self, watch: Option<Watch>, go_on: bool) -> Result<(), RunError> {
        let fastest = match self.drifted.take() {
            Some(fastest) => fastest,
            None => self.kick_and_drift(),
        };
        if !fastest.sum.is_finite() {
            return Err(self.not_finite());
        }
        self.step += 1;
        self.move_walls();
        self.exchange_particles();
        self.keep_lists_valid(fastest.squared_speed.sqrt())?;
        self.evaluate_forces(self.plan.time_step, watch, go_on);
        Ok(())
    }

    /// First half kick and drift, with the second half kick of the step before if it is still due.
    fn kick_and_drift(&mut self) -> Fastest {
        let kicks = if std::mem::take(&mut self.kick_due) {
            2
        } else {
            1
        };
        let drift = self.plan.time_step;
        let fastest = self.advance(kicks, drift);
        self.turn_orientations(drift);
        fastest
    }

    /// Makes the second half kick if it is still due, so that positions, velocities and forces belong to the same time.
    ///
    /// # Errors
    /// If a particle's motion is no longer a number.
    pub fn complete_step(&mut self) -> Result<(), RunError> {
        if std::mem::take(&mut self.kick_due) && !self.advance(1, 0.0).sum.is_finite() {
            return Err(self.not_finite());
        }
        Ok(())
    }

    /// `kicks` half kicks, then a drift of `drift` seconds.
    fn advance(&mut self, kicks: u32, drift: f64) -> Fastest {
        let pass = self.kick_drift(kicks, drift);
        let special = self.hold_prescribed();
        let size = block_size(self.particles.len());
        let records = &mut self.particles.records;
        let loads = &self.particles.loads;
        let fastest = match &self.pool {
            Some(pool) if records.len() > size => pool.install(|| {
                let chunks = records.par_chunks_mut(size).zip(loads.par_chunks(size));
                chunks
                    .map(|(records, loads)| pass.run(records, loads))
                    .reduce(Fastest::default, Fastest::merge)
            }),
            _ => pass.run(records, loads),
        };
        let prescribed = self.release_prescribed(special, drift);
        let fastest = Fastest {
            squared_speed: fastest.squared_speed.max(prescribed),
            ..fastest
        };
        fastest.merge(self.advance_bodies(kicks, drift))
    }

    /// The same for bodies, whose pebbles the pass over the particles leaves alone.
    fn advance_bodies(&mut self, kicks: u32, drift: f64) -> Fastest {
        let Particles {
            records, bodies, ..
        } = &mut self.particles;
        let Some(bodies) = bodies else {
            return Fastest::default();
        };
        let step = BodyStep {
            half: 0.5 * self.plan.time_step,
            drift,
            kicks,
            gravity: self.plan.gravity,
        };
        bodies.advance(records, &step, self.pool.as_deref())
    }

    /// Adds up what the contacts did to the pebbles of each body.
    fn gather_loads(&mut self) {
        let Particles { loads, bodies, .. } = &mut self.particles;
        if let Some(bodies) = bodies {
            bodies.gather(loads, self.pool.as_deref());
        }
    }

    fn kick_drift(&self, kicks: u32, drift: f64) -> KickDrift {
        KickDrift {
            half: 0.5 * self.plan.time_step,
            drift,
            kicks,
            gravity: self.plan.gravity,
            inverse_inertia: self.inverse_inertia,
            turns: self.turns,
        }
    }

    /// Remembers where prescribed particles stand before a pass that ignores what is prescribed.
    fn hold_prescribed(&self) -> Vec<Particle> {
        let rows = self.particles.prescribed.iter();
        rows.map(|prescribed| self.particles.records[prescribed.row as usize])
            .collect()
    }

    /// Puts the prescribed components back and drifts them with their prescribed velocity. Returns the largest squared speed
    /// of these particles, which the pass did not see: a kick may have cancelled what is prescribed.
    fn release_prescribed(&mut self, before: Vec<Particle>, drift: f64) -> f64 {
        let mut largest = 0.0f64;
        for (prescribed, before) in self.particles.prescribed.iter().zip(before) {
            let record = &mut self.particles.records[prescribed.row as usize];
            for axis in 0..3 {
                if let Some(velocity) = prescribed.velocity[axis] {
                    record.velocity[axis] = velocity;
                    record.position[axis] = before.position[axis] + velocity * drift;
                }
                if let Some(spin) = prescribed.angular_velocity[axis] {
                    record.angular_velocity[axis] = spin;
                }
            }
            largest = largest.max(record.velocity.length_squared());
        }
        largest
    }

    /// Turns the orientations by the angular velocities over `drift` seconds.
    fn turn_orientations(&mut self, drift: f64) {
        if let Some(orientations) = &mut self.particles.orientations {
            turn_orientations(orientations, &self.particles.records, drift);
        }
    }

    /// Moves the walls to the present time.
    fn move_walls(&mut self) {
        let (time, dt) = (self.time(), self.plan.time_step);
        for (wall, servo) in self.plan.walls.iter().zip(&mut self.servos) {
            if let Some((motor, _)) = wall.motion.servo(time) {
                *servo = motor.advance(*servo, time, dt);
            }
        }
        for (index, (wall, state)) in
            (self.plan.walls.iter().zip(&mut self.wall_states)).enumerate()
        {
            if wall.motion.is_static() {
                state.present = wall.is_present(time, self.plan.time_step);
            } else {
                let driven = self.servos.get(index).copied().unwrap_or_default();
                *state = wall.driven_state(time, dt, &driven);
            }
        }
    }

    /// Tells the servos what their walls felt in the force evaluation just made.
    fn answer_loads(&mut self) {
        if self.servos.is_empty() {
            return;
        }
        let (time, dt) = (self.time(), self.plan.time_step);
        let seen = self.forces.observation(self.plan.walls.len());
        for (index, wall) in self.plan.walls.iter().enumerate() {
            let Some((motor, axis)) = wall.motion.servo(time) else {
                continue;
            };
            self.servos[index].next_velocity = if self.wall_states[index].present {
                // The load is that of the particles on the wall.
                let force = -seen.walls[index].0.force.dot(axis);
                motor.answer(force, &seen.grips[index], dt)
            } else {
                0.0
            };
        }
    }

    /// Removes and inserts particles.
    fn exchange_particles(&mut self) {
        let time = self.time();
        let changed = self.boundaries.exchange(
            &mut self.particles,
            &self.plan,
            &self.images,
            &self.wall_states,
            time,
        );
        self.rows_changed |= changed;
    }

    /// Builds the candidate list anew if it may miss a contact. `fastest` is the largest speed of this step, m/s.
    fn keep_lists_valid(&mut self, fastest: f64) -> Result<(), RunError> {
        let dt = self.plan.time_step;
        let limit = 0.5 * self.skin.thickness;
        let mut valid = !self.rows_changed;
        if valid {
            valid = self
                .validity
                .advance(fastest, dt, limit, &self.particles, &self.leeway);
        }
        // Particles use up to half of the skin; the other half is the walls'.
        let reach = self.images.size.length();
        let about = self.images.min + 0.5 * self.images.size;
        valid = valid
            && self.moving_walls.iter().all(|&index| {
                let (from, to) = (&self.listed_poses[index], &self.wall_states[index].pose);
                self.plan.walls[index]
                    .shape
                    .displacement(from, to, about, reach)
                    <= limit
            });
        if !valid {
            self.rebuild()?;
        }
        Ok(())
    }

    /// Sorts the particles and builds the candidate lists.
    fn rebuild(&mut self) -> Result<(), RunError> {
        let finite = |record: &Particle| record.position.is_finite();
        if !self.particles.records.iter().all(finite) {
            return Err(self.not_finite());
        }
        if self.validity.steps > 0 {
            let idle = self.forces.listed().saturating_sub(self.forces.touching());
            self.skin.adapt(
                self.validity.steps,
                idle as f64 / self.particles.len().max(1) as f64,
            );
        }
        let mut leeway = leeways(&self.particles, &self.skin);
        let removed = self.boundaries.take_row_map(self.particles.len());
        // Steps are made from within the pool, if there is one.
        let parallel = rayon::current_thread_index().is_some();
        let skin = self.skin.thickness;
        if let Some(bodies) = &mut self.particles.bodies {
            bodies.wrap(&self.images);
        }
        let (list, sorted) = build(
            &mut self.particles,
            &mut leeway,
            skin,
            &self.images,
            parallel,
        );
        let Particles {
            records, bodies, ..
        } = &mut self.particles;
        if let Some(bodies) = bodies {
            bodies.note_shifts(records, &self.images);
        }
        let near_walls = find_near_walls(
            &self.particles,
            &leeway,
            &self.plan.walls,
            &self.wall_states,
            &self.images,
            skin,
            parallel,
        );
        let new_row: Vec<u32> = removed
            .into_iter()
            .map(|row| {
                if row == u32::MAX {
                    row
                } else {
                    sorted[row as usize]
                }
            })
            .collect();
        self.forces.adopt(&list, &near_walls, &new_row, parallel);
        let most = leeway.iter().copied().fold(0.0, f64::max);
        self.boundaries.listed(&self.particles, skin + 2.0 * most);
        self.leeway = leeway;
        self.listed_poses = self.wall_states.iter().map(|state| state.pose).collect();
        self.validity.reset();
        self.rows_changed = false;
        self.rebuilds += 1;
        Ok(())
    }

    /// Evaluates all contact forces; springs are stretched by `spring_time` seconds of motion. `go_on`: and kicks twice and
    /// drifts, which ends this step and begins the next.
    fn evaluate_forces(&mut self, spring_time: f64, watch: Option<Watch>, go_on: bool) {
        let watch = match watch {
            Some(watch) => Some(watch),
            None if self.plan.energy_budget || !self.servos.is_empty() => Some(Watch::default()),
            None => None,
        };
        let watch = watch.map(|watch| Watch {
            audit: (self.plan.energy_budget && self.step > 0).then_some(self.plan.time_step),
            ..watch
        });
        let context = StepContext {
            spring_time,
            images: &self.images,
            walls: &self.plan.walls,
            wall_states: &self.wall_states,
            wall_curvature: self.plan.wall_curvature,
            contact_point_mass: self.plan.contact_point_mass,
            feature_loads: self.plan.output.triangle_loads,
            watch,
        };
        // Prescribed motion is put right between kick and drift of all particles, not block by block.
        let go_on = go_on && self.particles.prescribed.is_empty();
        let pool = self.pool.as_deref();
        if go_on {
            let drift = self.plan.time_step;
            let pass = self.kick_drift(2, drift);
            // Turned block by block while the angular velocities are in the cache. No lock is ever waited for.
            let mut orientations = self.particles.orientations.take();
            let size = block_size(self.particles.len());
            let shares: Vec<Mutex<&mut [DQuat]>> = orientations
                .iter_mut()
                .flat_map(|all| all.chunks_mut(size))
                .map(Mutex::new)
                .collect();
            let finish = |block: usize, records: &mut [Particle], loads: &[Load]| {
                let fastest = pass.run(records, loads);
                if let Some(share) = shares.get(block) {
                    let mut share = share.lock().unwrap_or_else(PoisonError::into_inner);
                    turn_orientations(&mut share, records, drift);
                }
                fastest
            };
            let fastest = self
                .forces
                .compute(&mut self.particles, &context, pool, &finish);
            drop(shares);
            self.particles.orientations = orientations;
            self.gather_loads();
            let of_bodies = self.advance_bodies(2, self.plan.time_step);
            self.drifted = Some(fastest.merge(of_bodies));
        } else {
            let finish = |_: usize, _: &mut [Particle], _: &[Load]| Fastest::default();
            self.forces
                .compute(&mut self.particles, &context, pool, &finish);
            self.gather_loads();
            self.kick_due = true;
        }
        self.answer_loads();
        self.load_series.note_evaluation();
        if self.plan.energy_budget {
            let seen = self.forces.observation(self.plan.walls.len());
            self.audit.dissipated_normal += seen.dissipated_normal;
            self.audit.dissipated_tangential += seen.dissipated_tangential;
            self.audit.dissipated_rolling += seen.dissipated_rolling;
            self.audit.wall_work += seen.wall_work;
        }
    }

    /// The first particle whose motion is not a number.
    fn not_finite(&self) -> RunError {
        let lost = |record: &Particle| {
            !(record.position.is_finite()
                && record.velocity.is_finite()
                && record.angular_velocity.is_finite())
        };
        let row = self.particles.records.iter().position(lost).unwrap_or(0);
        RunError::NotFinite {
            step: self.step,
            time: self.time(),
            id: self.particles.ids[row],
            position: self.particles.records[row].position,
            velocity: self.particles.records[row].velocity,
        }
    }

    /// Time of the present state, s: step number times step, never a running sum.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.step as f64 * self.plan.time_step
    }

    /// Steps made.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.step
    }

    /// The plan it follows.
    #[must_use]
    pub fn plan(&self) -> &Arc<Plan> {
        &self.plan
    }

    /// Periodic images of the domain.
    #[must_use]
    pub fn images(&self) -> &Images {
        &self.images
    }

    /// Insertions and deletions, and what they counted.
    #[must_use]
    pub fn boundaries(&self) -> &Boundaries {
        &self.boundaries
    }

    /// Where the walls stand.
    #[must_use]
    pub fn wall_states(&self) -> &[WallState] {
        &self.wall_states
    }

    /// What was seen of the contacts in the last watched step.
    #[must_use]
    pub fn observation(&self) -> Observation {
        self.forces.observation(self.plan.walls.len())
    }

    /// What became of the energy, if the plan asks for it.
    #[must_use]
    pub fn audit(&self) -> Audit {
        self.audit
    }

    /// Unit and meaning of the numbers that contacts remember.
    #[must_use]
    pub fn history_columns(&self) -> Vec<HistoryNumber> {
        self.forces.history_columns()
    }

    /// The laws that the contact loop was compiled for.
    #[must_use]
    pub fn law_names(&self) -> &str {
        &self.law_names
    }

    /// Times the candidate list was built, and the listed pairs of the present one.
    #[must_use]
    pub fn list_statistics(&self) -> (u64, usize) {
        (self.rebuilds, self.forces.listed())
    }
}

/// Whether any of the flags mark a particle that does not move freely.
#[must_use]
pub fn is_constrained(record: &Particle) -> bool {
    record.flags & (FIXED | PRESCRIBED) != 0
}
