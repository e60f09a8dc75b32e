//! Whether sizes and speeds are such that their products are finite.
//!
//! A double reaches from 2.2e-308 to 1.8e308. The volume of a sphere of 1e-110 m is 0 then, and a particle without mass is at
//! infinity after a step.

use glam::DVec3;
use mercury_common::scene::{Scene, SceneError, SourceSpan};

use super::checks::{name, place};
use super::particles::StartingParticles;
use mercury_engine::bodies::Clump;
use mercury_engine::boundaries::InsertionPlan;
use mercury_engine::contact::parameter::short;
use mercury_engine::state::volume;

/// Every mass and moment of inertia is a number that can be divided by, and every speed one that can be squared. One error for each entry of
/// `[[particles]]` and each insertion, one for gravity.
pub(super) fn magnitudes(
    scene: &Scene,
    start: &StartingParticles,
    clumps: &[Clump],
    insertions: &[InsertionPlan],
    dimensions: u8,
    errors: &mut Vec<SceneError>,
) {
    if !is_squarable(*scene.gravity) {
        let message = "is too large: its square is beyond the range of numbers";
        errors.push(scene.gravity.error(message).with_help(SI));
    }
    let mut reported: Option<usize> = None;
    for grain in 0..start.grains() {
        let entry = start.typed(grain).entry;
        if reported == Some(entry) {
            continue;
        }
        let matter = start.matter(scene, clumps, grain, dimensions);
        let (velocity, spin) = start.motion(grain);
        let error = if let Some(matter) = matter.filter(|matter| !matter.is_divisible()) {
            Some(matter.error(place(scene, start, grain), &name(scene, start, grain)))
        } else {
            let too_fast = |what: &str, unit: &str, vector: DVec3| {
                let message = format!(
                    "{} starts with {what} of {} {unit}, whose square is beyond the range of numbers",
                    name(scene, start, grain),
                    short(vector.abs().max_element()),
                );
                place(scene, start, grain).error(message).with_help(SI)
            };
            if !is_squarable(velocity) {
                Some(too_fast("a velocity", "m/s", velocity))
            } else if !is_squarable(spin) {
                Some(too_fast("an angular velocity", "rad/s", spin))
            } else {
                None
            }
        };
        if let Some(error) = error {
            reported = Some(entry);
            errors.push(error);
        }
    }
    for plan in insertions {
        let Some(typed) = (scene.insertions.iter()).find(|typed| typed.name.value == plan.name)
        else {
            continue;
        };
        for part in &plan.mixture {
            let density = *scene.materials[part.material.index()].density;
            let ends = [part.sizes.smallest(), part.sizes.largest()];
            let bad = ends
                .into_iter()
                .map(|diameter| Matter::of_sphere(0.5 * diameter, density, dimensions))
                .find(|matter| !matter.is_divisible());
            if let Some(matter) = bad {
                let subject = format!("a particle of `{}`", plan.name);
                errors.push(matter.error(&typed.place, &subject));
                break;
            }
        }
        if !is_squarable(plan.velocity_mean.abs() + plan.velocity_spread.abs()) {
            let message = "is too large: its square is beyond the range of numbers";
            errors.push(typed.velocity_mean.error(message).with_help(SI));
        }
    }
}

const SI: &str = "lengths are in m, times in s, densities in kg/m3";

fn is_squarable(vector: DVec3) -> bool {
    vector.length_squared().is_finite()
}

/// Mass and least moment of inertia of a grain.
#[derive(Debug, Clone, Copy)]
struct Matter {
    /// kg (per metre in two dimensions).
    mass: f64,
    /// kg m^2 (per metre).
    moment: f64,
}

impl Matter {
    /// Its moment of inertia by its order of magnitude, m R^2.
    fn of_sphere(radius: f64, density: f64, dimensions: u8) -> Self {
        let mass = density * volume(radius, dimensions);
        Self {
            mass,
            moment: mass * radius * radius,
        }
    }

    fn is_divisible(&self) -> bool {
        let numbers = [self.mass, 1.0 / self.mass, self.moment, 1.0 / self.moment];
        numbers.into_iter().all(f64::is_normal)
    }

    fn error(&self, place: &SourceSpan, subject: &str) -> SceneError {
        let message = format!(
            "{subject} has a mass of {} kg and a moment of inertia of {} kg m2: these and one over them must lie within the range of numbers, 2.2e-308 to 1.8e308",
            short(self.mass),
            short(self.moment)
        );
        place.error(message).with_help(SI)
    }
}

impl StartingParticles {
    /// Matter of a free grain; none of a fixed one, whose mass is not used.
    fn matter(
        &self,
        scene: &Scene,
        clumps: &[Clump],
        grain: usize,
        dimensions: u8,
    ) -> Option<Matter> {
        if let Some(particle) = self.particles.get(grain) {
            let density = *scene.materials[particle.material.index()].density;
            let matter = Matter::of_sphere(particle.radius, density, dimensions);
            return (!particle.fixed).then_some(matter);
        }
        let body = &self.bodies[grain - self.particles.len()];
        let clump = body.clump(clumps);
        let scale = body.scale;
        let matter = Matter {
            mass: body.mass(clumps),
            moment: clump.moments.min_element() * (body.volume_factor() * scale * scale),
        };
        (!body.fixed).then_some(matter)
    }

    /// Velocity (m/s) and angular velocity (rad/s) of a grain.
    fn motion(&self, grain: usize) -> (DVec3, DVec3) {
        match grain.checked_sub(self.particles.len()) {
            None => {
                let particle = &self.particles[grain];
                (particle.velocity, particle.angular_velocity)
            }
            Some(body) => {
                let body = &self.bodies[body];
                (body.velocity, body.angular_velocity)
            }
        }
    }
}
