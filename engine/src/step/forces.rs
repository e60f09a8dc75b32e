//! The force evaluation, and what is fused with it.

use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use glam::{DQuat, DVec3};

use super::motion::turn_orientations;
use super::{Core, Domain, Engine};
use crate::cell::Cell;
use crate::forces::{Finish, MotionBound, Observation, OfBlocks, StepContext, Watch, block_size};
use crate::lanes::Width;
use crate::physics::Physics;
use crate::state::{Load, Particle, Particles};
use crate::surface::Surface;
use crate::walls::{WallNow, WallStiffness};

impl Engine {
    /// Evaluates all forces; springs are stretched by `spring_time` seconds of motion. `fuse`: and kicks twice and drifts, which
    /// ends this step and begins the next.
    pub(super) fn evaluate_forces(&mut self, spring_time: f64, watch: Option<Watch>, fuse: bool) {
        let is_audited = self.physics.energy_budget;
        let watch = match watch {
            Some(watch) => Some(watch),
            None if self.constants.needs.sums || self.constants.has_servos => {
                Some(Watch::default())
            }
            None => None,
        };
        let watch = watch.map(|watch| Watch {
            audit: is_audited.then(|| self.since_last()),
            ..watch
        });
        // Prescribed motion is put right between kick and drift of all particles, not block by block; and where other forces come
        // after the contacts, the loads are not complete yet.
        let waits = self.constants.needs.whole_steps || self.constants.needs.after_contacts;
        if fuse && !waits && self.particles.prescribed.is_empty() {
            self.forces_and_drift(spring_time, watch);
        } else {
            self.forces_alone(spring_time, watch);
            self.clock.kick_due = true;
        }
        self.join_events();
        let sums = self.sums();
        self.call(|part, core| part.after_forces(core, sums.as_ref()));
    }

    /// Sums up what the contacts did, once for servos, which follow it, and for parts that need it in every step. Loads that a servo follows
    /// are exact sums over blocks.
    fn sums(&mut self) -> Option<Observation> {
        if !self.constants.needs.sums && !self.constants.has_servos {
            return None;
        }
        if self.constants.needs.sums {
            self.collect_from(OfBlocks::Observations);
        }
        let mut sums = (self.contacts).observation(self.physics.walls.len(), false);
        for wall in 0..self.physics.walls.len() {
            if !self.domain.walls[wall].servos.is_empty() {
                // Vertices are the same on all ranks: they count once.
                let load = self.contacts.exact_load(wall, self.is_first());
                let load = self.core.add_exactly(load).map(|sum| sum.value());
                let [x, y, z, stiffness, damping] = load;
                sums.walls[wall].0.force = DVec3::new(x, y, z);
                sums.wall_stiffness[wall] = WallStiffness { stiffness, damping };
            }
        }
        let sums = self.with_parts(sums);
        if self.constants.has_servos {
            self.answer_loads(&sums);
        }
        Some(sums)
    }

    /// The forces, loads gathered to bodies.
    fn forces_alone(&mut self, spring_time: f64, watch: Option<Watch>) {
        let leave = |_: usize, _: &mut [Particle], _: &[Load]| MotionBound::default();
        self.compute(spring_time, watch, &leave);
        self.complete_pebbles();
        self.gather_loads();
    }

    /// The forces, and block by block, while it is in the cache, two half kicks and the drift into the next step.
    fn forces_and_drift(&mut self, spring_time: f64, watch: Option<Watch>) {
        let drift = self.physics.time_step;
        let pass = self.kick_drift(2, drift);
        // Turned while the angular velocities are in the cache. No lock is ever waited for.
        let mut orientations = self.particles.orientations.take();
        let (size, width) = (block_size(self.particles.len()), self.constants.width);
        let shares: Vec<Mutex<&mut [DQuat]>> = orientations
            .iter_mut()
            .flat_map(|all| all.chunks_mut(size))
            .map(Mutex::new)
            .collect();
        let finish = |block: usize, records: &mut [Particle], loads: &[Load]| {
            let fastest = pass.run(records, loads);
            if let Some(share) = shares.get(block) {
                let mut share = share.lock().unwrap_or_else(PoisonError::into_inner);
                turn_orientations(&mut share, records, drift, width);
            }
            fastest
        };
        let fastest = self.compute(spring_time, watch, &finish);
        drop(shares);
        self.particles.orientations = orientations;
        self.complete_pebbles();
        self.gather_loads();
        let of_bodies = self.advance_bodies(2, drift);
        self.clock.drifted = Some(fastest.merge(of_bodies));
    }

    fn compute(
        &mut self,
        spring_time: f64,
        watch: Option<Watch>,
        finish: &Finish<'_>,
    ) -> MotionBound {
        let Self { core, parts, .. } = self;
        let vertices = core.all_vertex_spheres();
        let velocity_lag = 0.5 * core.since_last();
        let Core {
            physics,
            watched,
            particles,
            contacts,
            domain,
            threads,
            constants,
            ranks,
            ..
        } = core;
        let Domain {
            cell,
            walls,
            wall_films,
            surfaces,
            ..
        } = domain;
        let pool = threads.pool.as_deref();
        let mut context = StepContext {
            spring_time,
            velocity_lag,
            feature_loads: watched.triangle_loads,
            wall_films: Some(wall_films),
            watch,
            ..unobserved(physics, cell, (walls, surfaces), constants.width)
        };
        for part in parts.iter() {
            part.inform(&mut context);
        }
        let bound = match ranks {
            Some(share) => share
                .with_shares(|across| contacts.compute(particles, &context, pool, finish, across)),
            None => contacts.compute(particles, &context, pool, finish, None),
        };
        let (mut vertex_loads, mut first) = (Vec::new(), 0);
        for (number, (vertices, surface)) in vertices.iter().zip(&*surfaces).enumerate() {
            let mut loads = vec![Load::default(); vertices.len()];
            contacts.compute_vertices((number, first), vertices, &context, pool, &mut loads);
            first += surface.positions.len();
            vertex_loads.push(loads);
        }
        core.load_surfaces(&vertex_loads);
        let begun = core.is_divided().then(Instant::now);
        parts.iter_mut().for_each(|part| part.add_loads(core));
        if let Some((share, begun)) = core.ranks.as_mut().zip(begun) {
            share.note_work(begun.elapsed());
        }
        bound
    }
}

/// A force evaluation of which nothing is observed, without liquid, at rest.
fn unobserved<'a>(
    physics: &Physics,
    cell: &'a Cell,
    (walls, surfaces): (&'a [WallNow], &'a [Surface]),
    width: Width,
) -> StepContext<'a> {
    StepContext {
        spring_time: 0.0,
        velocity_lag: 0.0,
        sliding_normal: physics.sliding_normal,
        cell,
        walls,
        surfaces,
        beside_sheets: None,
        offsets: None,
        wall_films: None,
        wall_curvature: physics.wall_curvature,
        contact_point_mass: physics.contact_point_mass,
        feature_loads: false,
        wall_loads: false,
        overlap_limit: f64::INFINITY,
        deep: f64::INFINITY,
        watch: None,
        width,
    }
}

impl Core {
    /// Adds up what the contacts did to the pebbles of each body.
    fn gather_loads(&mut self) {
        let Particles { loads, bodies, .. } = &mut self.particles;
        if let Some(bodies) = bodies {
            bodies.gather(loads, self.threads.pool.as_deref());
        }
    }
}
