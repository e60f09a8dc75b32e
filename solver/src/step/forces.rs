//! The force evaluation, and what is fused with it.

use std::sync::{Mutex, PoisonError};

use glam::DQuat;

use super::Engine;
use super::crossings::SEEN;
use super::motion::turn_orientations;
use crate::forces::{Finish, MotionBound, StepContext, Watch, block_size};
use crate::liquid::Liquids;
use crate::state::{Load, Particle, Particles};

impl Engine {
    /// Evaluates all forces; springs are stretched by `spring_time` seconds of motion. `fuse`: and kicks twice and drifts, which
    /// ends this step and begins the next.
    pub(super) fn evaluate_forces(&mut self, spring_time: f64, watch: Option<Watch>, fuse: bool) {
        // The loads that servos follow act on walls without sleepers beside them.
        let sees_sleepers = watch.is_some() || self.plan.physics().energy_budget();
        let watch = match watch {
            Some(watch) => Some(watch),
            None if self.plan.physics().energy_budget() || self.has_servos => {
                Some(Watch::default())
            }
            None => None,
        };
        let watch = watch.map(|watch| Watch {
            audit: self
                .plan
                .physics()
                .energy_budget()
                .then(|| self.since_last()),
            ..watch
        });
        // Prescribed motion is put right between kick and drift of all particles, not block by block; and where other forces come
        // after the contacts, the loads are not complete yet. The audit needs the velocities at the time when all forces are
        // known.
        // Liquid with mass changes masses after them.
        let has_mass = self.liquid.as_ref().is_some_and(Liquids::has_mass);
        let fuse = fuse && !self.plan.physics().energy_budget() && !has_mass;
        if fuse && self.particles.prescribed.is_empty() && !self.forces.needs().after_contacts {
            self.forces_and_drift(spring_time, (watch, sees_sleepers));
        } else {
            self.forces_alone(spring_time, (watch, sees_sleepers));
            self.kick_due = true;
        }
        self.load_surfaces();
        self.load_series.note_evaluation();
        self.tell_audit_and_servos();
        self.move_liquid();
    }

    /// Sums up what the contacts did, once for both that ask for it in every step.
    fn tell_audit_and_servos(&mut self) {
        let is_audited = self.plan.physics().energy_budget();
        if !is_audited && !self.has_servos {
            return;
        }
        let mut sums = self.forces.sums(self.plan.physics().walls().len());
        self.add_holds_to_walls(&mut sums);
        if self.has_servos {
            self.answer_loads(&sums);
        }
        if is_audited {
            self.audit_step(&sums);
        }
    }

    /// Time since the last force evaluation, s: 0 in the first.
    pub(super) fn since_last(&self) -> f64 {
        if self.step > 0 {
            self.plan.physics().time_step()
        } else {
            0.0
        }
    }

    /// The forces, loads gathered to bodies.
    fn forces_alone(&mut self, spring_time: f64, watch: (Option<Watch>, bool)) {
        let leave = |_: usize, _: &mut [Particle], _: &[Load]| MotionBound::default();
        self.compute(spring_time, watch, &leave);
        self.gather_loads();
    }

    /// The forces, and block by block, while it is in the cache, two half kicks and the drift into the next step.
    fn forces_and_drift(&mut self, spring_time: f64, watch: (Option<Watch>, bool)) {
        let drift = self.plan.physics().time_step();
        let pass = self.kick_drift(2, drift);
        // Turned while the angular velocities are in the cache. No lock is ever waited for.
        let mut orientations = self.particles.orientations.take();
        let (size, width) = (block_size(self.particles.len()), self.width);
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
        self.gather_loads();
        let of_bodies = self.advance_bodies(2, drift);
        self.drifted = Some(fastest.merge(of_bodies));
    }

    fn compute(
        &mut self,
        spring_time: f64,
        (watch, sees_sleepers): (Option<Watch>, bool),
        finish: &Finish<'_>,
    ) -> MotionBound {
        let overlap_limit = self.overlap_limit();
        if let Some(liquid) = &mut self.liquid {
            liquid.measure_films(&self.particles);
        }
        let vertices = self.all_vertex_spheres();
        let context = StepContext {
            spring_time,
            velocity_lag: 0.5 * self.since_last(),
            sliding_normal: self.plan.physics().sliding_normal(),
            images: &self.images,
            walls: &self.walls,
            surfaces: &self.surfaces,
            films: self.liquid.as_ref().and_then(Liquids::measured_films),
            wall_films: self.liquid.as_ref().and_then(Liquids::films_that_meet),
            wall_curvature: self.plan.physics().wall_curvature(),
            contact_point_mass: self.plan.physics().contact_point_mass(),
            feature_loads: self.plan.outputs().files().triangle_loads,
            overlap_limit,
            deep: if overlap_limit.is_infinite() {
                f64::INFINITY
            } else {
                overlap_limit.min(SEEN)
            },
            watch,
            sees_sleepers,
            width: self.width,
        };
        let pool = self.pool.as_deref();
        let bound = self
            .forces
            .compute(&mut self.particles, &context, pool, finish);
        self.vertex_loads.clear();
        let mut first = 0;
        for (number, (vertices, surface)) in vertices.iter().zip(&self.surfaces).enumerate() {
            let mut loads = vec![Load::default(); vertices.len()];
            let contacts = &mut self.forces.contacts;
            contacts.compute_vertices((number, first), vertices, &context, pool, &mut loads);
            first += surface.positions.len();
            self.vertex_loads.push(loads);
        }
        bound
    }

    /// Sums up the loads among sleepers; `roused`: the rows that were woken, if nothing else changed.
    pub(super) fn hold_contacts(&mut self, roused: Option<&[u32]>) {
        let context = StepContext {
            spring_time: 0.0,
            velocity_lag: 0.0,
            sliding_normal: self.plan.physics().sliding_normal(),
            images: &self.images,
            walls: &self.walls,
            surfaces: &self.surfaces,
            films: None,
            wall_films: None,
            wall_curvature: self.plan.physics().wall_curvature(),
            contact_point_mass: self.plan.physics().contact_point_mass(),
            feature_loads: false,
            overlap_limit: f64::INFINITY,
            deep: f64::INFINITY,
            watch: None,
            sees_sleepers: false,
            width: self.width,
        };
        let (contacts, pool) = (&mut self.forces.contacts, self.pool.as_deref());
        contacts.settle(&self.particles, &context, pool, roused);
    }

    /// Adds up what the contacts did to the pebbles of each body.
    fn gather_loads(&mut self) {
        let Particles { loads, bodies, .. } = &mut self.particles;
        if let Some(bodies) = bodies {
            bodies.gather(loads, self.pool.as_deref());
        }
    }
}
