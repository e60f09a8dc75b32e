//! A head-on collision in the engine, measured.

use std::f64::consts::PI;

use glam::{DVec3, dvec3};
use mercury_engine::contact::registry::AnyPairLaw;

use crate::scenes::{
    add_material, advance, frictionless, observed_step, particle, plan, plane, sphere, start,
};
use mercury_engine::contact::AnyNormal;
use mercury_engine::state::{MaterialIndex, volume};
use mercury_engine::step::Engine;

/// Measured values of a collision.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Collision {
    pub(super) restitution: f64,
    /// s.
    pub(super) duration: f64,
    /// m.
    pub(super) largest_overlap: f64,
    /// s.
    pub(super) time_of_largest_overlap: f64,
    /// N.
    pub(super) largest_force: f64,
    /// Force in the last step in contact, N.
    pub(super) last_force: f64,
}

/// Two bodies that just touch and approach each other.
#[derive(Debug, Clone, Copy)]
pub(super) struct HeadOn {
    pub(super) law: AnyPairLaw,
    /// m.
    pub(super) radius: f64,
    /// kg; an infinite second mass stands for a wall.
    pub(super) masses: [f64; 2],
    /// m/s.
    pub(super) speed: f64,
    /// s.
    pub(super) time_step: f64,
}

impl HeadOn {
    /// Collision of two equal spheres under a normal law.
    pub(super) fn equal(
        normal: AnyNormal,
        radius: f64,
        mass: f64,
        speed: f64,
        time_step: f64,
    ) -> Self {
        Self {
            law: frictionless(normal),
            radius,
            masses: [mass, mass],
            speed,
            time_step,
        }
    }

    /// Collision of a sphere with a wall.
    pub(super) fn on_wall(self) -> Self {
        Self {
            masses: [self.masses[0], f64::INFINITY],
            ..self
        }
    }

    /// The two as they touch, and whether one of them is a wall.
    fn engine(&self) -> (Engine, bool) {
        let radius = self.radius;
        let on_wall = self.masses[1].is_infinite();
        let mut plan = plan(self.time_step, self.masses[0] / volume(radius, 3), self.law);
        let at =
            |x: f64, vx: f64| sphere(dvec3(x, 0.0, 0.0), radius, dvec3(vx, 0.0, 0.0), DVec3::ZERO);
        let plan = if on_wall {
            plan.walls.push(plane(DVec3::ZERO, DVec3::X));
            plan.with_particles(vec![at(radius, -self.speed)])
        } else {
            let other = add_material(&mut plan, self.masses[1] / volume(radius, 3));
            let mut second = at(radius, -0.5 * self.speed);
            second.material = MaterialIndex::new(other);
            plan.with_particles(vec![at(-radius, 0.5 * self.speed), second])
        };
        (start(plan), on_wall)
    }

    /// Speed (m/s) of the first body after so many steps.
    pub(super) fn speed_after(&self, steps: u64) -> f64 {
        let (mut engine, _) = self.engine();
        advance(&mut engine, steps);
        particle(&engine, 0).velocity.length()
    }

    /// Runs until they part.
    pub(super) fn run(&self) -> Collision {
        let radius = self.radius;
        let (mut engine, on_wall) = self.engine();
        let mut seen = Collision::default();
        while engine.steps() < 1_000_000 {
            observed_step(&mut engine);
            let (gap, separation_speed) = if on_wall {
                let one = particle(&engine, 0);
                (one.position.x - radius, one.velocity.x)
            } else {
                let (one, two) = (particle(&engine, 0), particle(&engine, 1));
                let gap = two.position.x - one.position.x - 2.0 * radius;
                (gap, two.velocity.x - one.velocity.x)
            };
            if gap >= 0.0 {
                seen.restitution = separation_speed / self.speed;
                seen.duration = engine.time() - gap / separation_speed;
                return seen;
            }
            if -gap > seen.largest_overlap {
                seen.largest_overlap = -gap;
                seen.time_of_largest_overlap = engine.time();
            }
            if let Some(record) = engine.observation().records.first() {
                seen.last_force = record.force.dot(record.normal);
                seen.largest_force = seen.largest_force.max(seen.last_force);
            }
        }
        Collision {
            restitution: f64::NAN,
            ..seen
        }
    }
}

/// Relative error of a damped collision in `steps` per contact time. The dashpot sees the velocity of half a step earlier, as
/// if the mass were off by γ dt/2; and the contact ends up to half a step too early or late, while it still pulls with γ v.
/// Each makes γ dt/(2m*) = ζ π/steps at most. To this comes the error of the integrator without damping, below
/// (π/steps)²/2 for the linear law and 10 times that for Hertz' law, whose contact begins with a kink of the stiffness.
pub(crate) fn lag(damping_ratio: f64, steps: f64) -> f64 {
    2.0 * damping_ratio * PI / steps + 5.0 * (PI / steps).powi(2)
}
