//! A sphere that meets a wall or another sphere at an angle or with a spin, under Hertz' and Mindlin's laws.

use glam::{DVec3, dvec3};
use mercury_engine::contact::normal::{damping_ratio_clamped, hertz_damping};
use mercury_engine::contact::registry::AnyPairLaw;
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, Hertz, Mindlin, PairLaw,
};
use mercury_engine::state::{MaterialIndex, Particle, volume};
use mercury_solver::plan::{Draft, NewParticle};

use crate::closed_forms::{
    clamped_restitution, damping_ratio, effective_modulus, effective_shear_modulus,
    hertz_contact_time,
};
use crate::scenes::{add_material, advance, held, particle, plan, plane, sphere, start};

/// Young's modulus (Pa) and Poisson's ratio of what nothing deforms.
pub(crate) const RIGID: (f64, f64) = (f64::INFINITY, 0.0);

/// A sphere and its impact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Impact {
    pub(crate) radius: f64,
    pub(crate) density: f64,
    /// Young's modulus, Pa, and Poisson's ratio.
    pub(crate) elasticity: (f64, f64),
    /// Young's modulus, Pa, and Poisson's ratio of the partner.
    pub(crate) partner: (f64, f64),
    pub(crate) friction: f64,
    /// Restitution as measured after the impact: where tension is cut off the damping is that which gives it.
    pub(crate) restitution: f64,
    pub(crate) cut_tension: bool,
    /// Onto the wall, along it, m/s, and spin, rad/s.
    pub(crate) onto: f64,
    pub(crate) along: f64,
    pub(crate) spin: f64,
    /// On Mindlin's stiffness.
    pub(crate) factor: f64,
    /// Time step, s; 0 for 2000 steps in an elastic contact.
    pub(crate) step: f64,
}

const STEPS: f64 = 2000.0;

impl Impact {
    pub(crate) fn law(&self) -> AnyPairLaw {
        let damping = if self.cut_tension {
            5.0f64.sqrt() * damping_ratio_clamped(self.restitution)
        } else {
            hertz_damping(self.restitution)
        };
        let mut normal = Hertz::new(effective_modulus(self.elasticity, self.partner), damping);
        normal.clamp_tension = self.cut_tension;
        PairLaw {
            normal: AnyNormal::Hertz(normal),
            tangential: AnyTangential::Mindlin(Mindlin::new(
                effective_shear_modulus(self.elasticity, self.partner),
                self.factor,
                (2.0f64 / 3.0).sqrt() * damping,
                self.friction,
                self.friction,
            )),
            rolling: AnyRolling::None,
            adhesion: AnyAdhesion::None,
        }
    }

    /// Duration of the contact without damping, s.
    fn contact_time(&self) -> f64 {
        let modulus = effective_modulus(self.elasticity, self.partner);
        let mass = self.density * volume(self.radius, 3);
        hertz_contact_time(modulus, mass, self.radius, self.onto)
    }

    pub(crate) fn time_step(&self) -> f64 {
        if self.step > 0.0 {
            self.step
        } else {
            self.contact_time() / STEPS
        }
    }

    /// The sphere after the impact on the plane y = 0.
    pub(crate) fn on_wall(&self) -> Particle {
        let mut plan = plan(self.time_step(), self.density, self.law());
        plan.walls.push(plane(DVec3::ZERO, DVec3::Y));
        self.after(plan.with_particles(vec![self.sphere()]))
    }

    /// Impact on a sphere of five times the radius that does not move.
    pub(crate) fn on_sphere(&self) -> Particle {
        let plan = plan(self.time_step(), self.density, self.law());
        let anvil = held(self.large_sphere());
        self.after(plan.with_particles(vec![self.sphere(), anvil]))
    }

    /// Impact on a free sphere of five times the radius and the density given (kg/m³).
    pub(crate) fn on_heavy_sphere(&self, density: f64) -> Particle {
        let mut plan = plan(self.time_step(), self.density, self.law());
        let mut heavy = self.large_sphere();
        heavy.material = MaterialIndex::new(add_material(&mut plan, density));
        self.after(plan.with_particles(vec![self.sphere(), heavy]))
    }

    /// Impact on an equal sphere that comes from the other side with the opposite velocity.
    pub(crate) fn on_opposite(&self) -> Particle {
        let plan = plan(self.time_step(), self.density, self.law());
        let mut other = self.sphere();
        other.position = -other.position;
        other.velocity = -other.velocity;
        self.after(plan.with_particles(vec![self.sphere(), other]))
    }

    fn large_sphere(&self) -> NewParticle {
        let radius = 5.0 * self.radius;
        sphere(-radius * DVec3::Y, radius, DVec3::ZERO, DVec3::ZERO)
    }

    fn sphere(&self) -> NewParticle {
        sphere(
            self.radius * DVec3::Y,
            self.radius,
            dvec3(self.along, -self.onto, 0.0),
            self.spin * DVec3::Z,
        )
    }

    /// The first particle after three durations of the contact.
    pub(crate) fn after(&self, plan: Draft) -> Particle {
        let steps = (3.0 * self.contact_time() / self.time_step()).round() as u64;
        let mut engine = start(plan);
        advance(&mut engine, steps);
        particle(&engine, 0)
    }

    /// Loss of tangential velocity by friction in full sliding, m/s: mu times the normal impulse per mass, which ends when the
    /// sphere leaves with the speed of a contact without tension.
    pub(crate) fn taken(&self) -> f64 {
        let clamped = if self.cut_tension {
            self.restitution
        } else {
            clamped_restitution(damping_ratio(self.restitution))
        };
        self.friction * (1.0 + clamped) * self.onto
    }

    /// Velocity of the contact point along the wall, m/s.
    pub(crate) fn slip(&self, after: &Particle) -> f64 {
        after.velocity.x + after.angular_velocity.z * self.radius
    }
}
