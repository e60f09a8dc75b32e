//! When the particles have come to rest: nothing moves, will move, or can set something in motion.

use glam::DVec3;
use mercury_common::readable::rounded;

use crate::plan::{Plan, ScheduledChange};
use mercury_engine::forces::block_size;
use mercury_engine::state::{
    Body, FIXED, PEBBLE, PRESCRIBED, Particle, Particles, inverse_inertia_factor,
};
use mercury_engine::step::Engine;
use mercury_engine::sums::exact_sums;

/// Calm steps in a row that make rest.
const STEPS: u64 = 1000;
/// The interval of the checks: the steps in between need no check.
pub(super) const EVERY: u64 = 10;
/// The time for which calm must last, over the time in which a particle falls by about its diameter, sqrt(d/g): in 1,000 steps of
/// 1 ns a released particle has hardly gained any speed. Without gravity over the time in which it goes as far at the reference
/// speed.
const LASTS: f64 = 0.1;
/// Limit of the kinetic energy per particle for calm, over m g d; without gravity over that at the reference speed.
const SHARE: f64 = 1e-6;
/// Bodies whose numbers are added plainly; like the sums of blocks of rows, these sums are added exactly.
const BODIES: usize = 512;

/// Counts calm checks: those at which the kinetic energy of translation per free particle or body is below 1e-6 m g d (mean mass
/// and diameter, of bodies the circumscribed one), no wall is faster than that, and nothing is still to begin or to end. Spin
/// counts by its change: where it can move something it is slowed down, and about the normal of a contact that does not resist it
/// may last for ever.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Rest {
    /// Magnitude of gravity, m/s^2.
    gravity: f64,
    /// Where there is none: half the square of the reference speed of the plan, J/kg.
    energy: f64,
    /// FrameCopy of inertia over m R^2.
    inertia: f64,
    calm: u64,
    /// Calm looks that make rest.
    needed: u64,
    /// The least and the most energy of rotation per particle since the looks are calm, J.
    spins: [f64; 2],
}

/// Mean energies per particle, J, and the limit for calm.
pub(super) struct Means {
    translation: f64,
    rotation: f64,
    limit: f64,
    mass: f64,
    /// In which something would have moved, s.
    time: f64,
}

/// The events for which rest has to wait, whatever the particles do.
enum Awaited {
    /// More particles come.
    Insertion,
    /// Something begins or ends.
    Change(ScheduledChange),
    /// The wall of this index may move something, m/s.
    Wall(usize, f64),
}

impl Rest {
    pub(super) fn new(plan: &Plan) -> Self {
        let gravity = plan.physics().gravity.length();
        let speed = plan.notes().step().reference_speed;
        Self {
            gravity,
            energy: 0.5 * speed * speed,
            inertia: 1.0 / inverse_inertia_factor(plan.physics().dimensions),
            calm: 0,
            needed: STEPS / EVERY,
            spins: [0.0; 2],
        }
    }

    /// Whether enough calm looks have been counted.
    pub(super) fn is_over(&self) -> bool {
        self.calm >= self.needed
    }

    /// Whether one more calm look would be enough.
    pub(super) fn is_near(&self) -> bool {
        self.calm + 1 >= self.needed
    }

    /// Counts this check; returns whether everything is at rest now.
    pub(super) fn is_reached(&mut self, engine: &Engine) -> bool {
        let dt = engine.physics().time_step;
        self.look(&engine.particles, dt, |means| {
            awaited(engine, means).is_some()
        })
    }

    /// Looks at these particles with steps of `dt` (s); `is_awaited`: whether there is another event to wait for.
    pub(super) fn look(
        &mut self,
        particles: &Particles,
        dt: f64,
        is_awaited: impl FnOnce(&Means) -> bool,
    ) -> bool {
        let means = self.means(particles);
        let steps = (LASTS * means.time / dt).ceil() as u64;
        self.needed = steps.max(STEPS).div_ceil(EVERY);
        // Without free particles the limit is not a number, and nothing is calm.
        let is_calm = means.translation < means.limit && !is_awaited(&means);
        self.count(is_calm, &means)
    }

    fn count(&mut self, is_calm: bool, means: &Means) -> bool {
        let [least, most] = match self.calm {
            0 => [means.rotation; 2],
            _ => [
                self.spins[0].min(means.rotation),
                self.spins[1].max(means.rotation),
            ],
        };
        (self.calm, self.spins) = if !is_calm {
            (0, [0.0; 2])
        } else if most - least < means.limit {
            (self.calm + 1, [least, most])
        } else {
            (1, [means.rotation; 2])
        };
        self.is_over()
    }

    fn means(&self, particles: &Particles) -> Means {
        let size = block_size(particles.len());
        let blocks = particles.records.chunks(size);
        let blocks = blocks.zip(particles.masses.chunks(size));
        let of_blocks = blocks.map(|(records, masses)| self.sums_of_rows(records, masses));
        let of_bodies = particles.bodies().chunks(BODIES).map(sums_of_bodies);
        let [number, mass, diameter, translation, rotation] =
            exact_sums(of_blocks.chain(of_bodies));
        let (mass, diameter) = (mass / number, diameter / number);
        let (scale, time) = if self.gravity > 0.0 {
            let (g, d) = (self.gravity, diameter);
            (g * d, (d / g).sqrt())
        } else {
            let energy = self.energy;
            (energy, diameter / (2.0 * energy).sqrt())
        };
        Means {
            translation: translation / number,
            rotation: rotation / number,
            limit: SHARE * mass * scale,
            mass,
            time,
        }
    }

    /// Number, mass (kg), diameters (m), energy of translation and of rotation (J) of the free ones of some rows.
    fn sums_of_rows(&self, records: &[Particle], masses: &[f64]) -> [f64; 5] {
        let [mut number, mut mass, mut diameter] = [0.0; 3];
        let [mut translation, mut rotation] = [0.0; 2];
        for (record, &m) in records.iter().zip(masses) {
            if record.is_constrained() || record.flags & PEBBLE != 0 {
                continue;
            }
            let spin = record.radius * record.radius * record.angular_velocity.length_squared();
            number += 1.0;
            mass += m;
            diameter += 2.0 * record.radius;
            translation += 0.5 * m * record.velocity.length_squared();
            rotation += 0.5 * m * self.inertia * spin;
        }
        [number, mass, diameter, translation, rotation]
    }

    /// Why there is no rest at the end of a run that would have ended with it.
    pub(super) fn why_not(&self, engine: &Engine) -> String {
        let means = self.means(&engine.particles);
        let walls = &engine.physics().walls;
        match awaited(engine, &means) {
            _ if means.limit.is_nan() => "there was no particle that can move".to_owned(),
            Some(Awaited::Insertion) => "more particles were still to come".to_owned(),
            Some(Awaited::Change(event)) => format!("{event} was still to come"),
            Some(Awaited::Wall(index, speed)) => {
                let name = walls.get(index).map_or("", |wall| wall.name.as_str());
                format!("wall `{name}` moves, at up to {} m/s", rounded(speed, 3))
            }
            None if means.translation >= means.limit => {
                let times = rounded(means.translation / means.limit, 3);
                format!("the kinetic energy per particle is {times} times the limit for rest")
            }
            None => "it was not calm for 1,000 steps in a row".to_owned(),
        }
    }
}

/// Number, mass (kg), diameters (m), energy of translation and of rotation (J) of the free ones of some bodies.
fn sums_of_bodies(bodies: &[Body]) -> [f64; 5] {
    let [mut number, mut mass, mut diameter] = [0.0; 3];
    let [mut translation, mut rotation] = [0.0; 2];
    for body in bodies {
        if body.flags & (FIXED | PRESCRIBED) != 0 {
            continue;
        }
        number += 1.0;
        mass += body.mass;
        diameter += 2.0 * body.radius;
        translation += 0.5 * body.mass * body.velocity.length_squared();
        rotation += body.rotational_energy();
    }
    [number, mass, diameter, translation, rotation]
}

/// Event that is still to be waited for.
fn awaited(engine: &Engine, means: &Means) -> Option<Awaited> {
    if engine.boundaries().expects_more() {
        return Some(Awaited::Insertion);
    }
    let event = engine.physics().last_event();
    if let Some(event) = event.filter(|event| engine.time() < event.time) {
        return Some(Awaited::Change(event));
    }
    // As fast as a particle that is calm.
    let limit = (2.0 * means.limit / means.mass).sqrt();
    let cell = engine.cell();
    let (middle, half) = (cell.middle(), 0.5 * cell.size());
    engine.walls().iter().enumerate().find_map(|(index, wall)| {
        let state = &wall.state;
        if !state.present || !state.moves {
            return None;
        }
        // The speed of points of a rigid body is largest at a corner of any box that holds them.
        let corners = (0..8).map(|corner| {
            let side = |axis: i32| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
            state
                .velocity
                .at(middle + half * DVec3::new(side(0), side(1), side(2)))
                .length()
        });
        let speed = corners.fold(0.0, f64::max);
        (speed >= limit).then_some(Awaited::Wall(index, speed))
    })
}

mercury_engine::state::plain!(Rest {
    gravity,
    energy,
    inertia,
    calm,
    needed,
    spins
});
