//! The plain reference path: discrete particle simulation as one would explain it at a blackboard.
//!
//! Every pair of particles is looked at in every step, everything is computed in the obvious order
//! by one thread, nothing is cached. It is slow, and it exists for two reasons: to be read, and to
//! have something independent that the fast engine must agree with.
//!
//! * `mod.rs`: the time step (this page),
//! * [`state`]: what is remembered between steps,
//! * [`bodies`]: how a rigid body of several pebbles moves,
//! * [`bonds`]: what glue does to a pair,
//! * [`laws`]: what two touching bodies do to each other,
//! * [`walls`]: where a sphere touches a wall, and how the wall moves there.
//!
//! Conventions. A contact is an ordered pair (A, B): A is the lower index, or the particle at a
//! wall. The normal points from B to A. Force laws see the velocities of the half step, which is
//! what makes the damping lag by dt/2 and the elastic part exactly second order.

pub mod bodies;
pub mod bonds;
pub mod laws;
pub mod state;
mod triangles;
pub mod walls;

pub(crate) use triangles::nearest_point;

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use glam::{DQuat, DVec3};

use bodies::Body;
use bonds::{Bond, Shortened};
use laws::{ContactLaw, Conventions, History, Kinematics, SlidingNormal, contact_force};
use state::{Contact, ContactKey, Energies, Particle, PeriodicBox};
use walls::{Shape, Wall};

/// Looks up the contact parameters of two materials; must not depend on their order.
pub type PairParameters = Box<dyn Fn(usize, usize) -> ContactLaw>;

/// A scene and its present state. Fill in the fields, then call [`Simulation::advance`].
pub struct Simulation {
    /// The particles; their order decides which is A in a contact.
    pub particles: Vec<Particle>,
    /// Rigid bodies, whose pebbles are among the particles.
    pub bodies: Vec<Body>,
    /// Glued pairs; [`Simulation::glue`] adds one.
    pub bonds: Vec<Bond>,
    /// Pairs whose contact does not count all of its overlap.
    pub shortened: Vec<Shortened>,
    /// Whether the effective mass of contacts of bodies is that at the contact point.
    pub contact_point_mass: bool,
    /// The walls.
    pub walls: Vec<Wall>,
    /// Contact parameters of a pair of materials.
    pub pair_parameters: PairParameters,
    /// The choices among published variants.
    pub conventions: Conventions,
    /// Acceleration of gravity \[m/s²\].
    pub gravity: DVec3,
    /// Periodic axes.
    pub periodic_box: PeriodicBox,
    /// Time step \[s\].
    pub time_step: f64,
    /// Steps made so far.
    pub step: u64,
    /// The contacts of the last force evaluation, with their histories.
    pub contacts: BTreeMap<ContactKey, Contact>,
    /// Whether the forces of the first instant are known.
    pub started: bool,
}

impl Simulation {
    /// An empty scene with one contact law for all materials and the default conventions.
    pub fn new(time_step: f64, law: ContactLaw) -> Self {
        Self {
            particles: Vec::new(),
            bodies: Vec::new(),
            bonds: Vec::new(),
            shortened: Vec::new(),
            contact_point_mass: false,
            walls: Vec::new(),
            pair_parameters: Box::new(move |_, _| law),
            conventions: Conventions::default(),
            gravity: DVec3::ZERO,
            periodic_box: PeriodicBox::default(),
            time_step,
            step: 0,
            contacts: BTreeMap::new(),
            started: false,
        }
    }

    /// Time t_k = k dt \[s\]: a product, since a running sum would drift.
    pub fn time(&self) -> f64 {
        self.step as f64 * self.time_step
    }

    /// One step of velocity Verlet, kick-drift-kick (Swope et al. 1982).
    pub fn advance(&mut self) {
        self.start();
        self.half_kick(); //  v, ω: t -> t + dt/2
        self.drift(); //      x   : t -> t + dt
        self.step += 1;
        self.evaluate_forces(self.time_step);
        self.half_kick(); //  v, ω: t + dt/2 -> t + dt
    }

    /// `steps` steps.
    pub fn advance_by(&mut self, steps: u64) {
        for _ in 0..steps {
            self.advance();
        }
    }

    /// Computes the forces of the first instant, once; [`Simulation::advance`] does so by itself.
    ///
    /// No time has passed, so the springs do not grow (unless `startup_increment` is set).
    pub fn start(&mut self) {
        if !self.started {
            self.started = true;
            let grown = self.conventions.startup_increment;
            self.evaluate_forces(if grown { self.time_step } else { 0.0 });
        }
    }

    /// v += (F/m + g) dt/2 and ω += T/I dt/2, except where a value is held.
    fn half_kick(&mut self) {
        let half = 0.5 * self.time_step;
        for body in &mut self.bodies {
            body.half_kick(half, self.gravity);
        }
        let free = |particle: &&mut Particle| !particle.fixed && particle.body.is_none();
        for particle in self.particles.iter_mut().filter(free) {
            let acceleration = particle.force / particle.mass + self.gravity;
            let angular_acceleration = particle.torque / particle.inertia;
            for axis in 0..3 {
                if !particle.velocity_held[axis] {
                    particle.velocity[axis] += acceleration[axis] * half;
                }
                if !particle.angular_velocity_held[axis] {
                    particle.angular_velocity[axis] += angular_acceleration[axis] * half;
                }
            }
        }
        self.move_pebbles();
    }

    /// Time by which the velocities that contacts see are earlier than the positions \[s\].
    fn lag(&self) -> f64 {
        if self.step > 0 {
            0.5 * self.time_step
        } else {
            0.0
        }
    }

    /// x += v dt, wrapped into the periodic box; the orientation turns by the angle |ω| dt.
    fn drift(&mut self) {
        let mut spins = Vec::new();
        for body in &mut self.bodies {
            spins.push(body.drift(self.time_step));
            body.position = self.periodic_box.wrap(body.position);
        }
        for particle in self.particles.iter_mut().filter(|p| p.body.is_none()) {
            let moved = particle.position + particle.velocity * self.time_step;
            particle.position = self.periodic_box.wrap(moved);
            let turn = DQuat::from_scaled_axis(particle.angular_velocity * self.time_step);
            particle.orientation = (turn * particle.orientation).normalize();
        }
        self.place_pebbles(&spins, 0.5 * self.time_step);
    }

    /// Pebbles are where their bodies have them, and move with them.
    fn move_pebbles(&mut self) {
        let spins: Vec<DVec3> = self.bodies.iter().map(Body::angular_velocity).collect();
        self.place_pebbles(&spins, 0.0);
    }

    /// Places the pebbles, with the angular velocities that the bodies had `lag` (s) ago, when the pebbles were where these place
    /// them.
    fn place_pebbles(&mut self, spins: &[DVec3], lag: f64) {
        for (body, &spin) in self.bodies.iter().zip(spins) {
            for (k, &(index, _)) in body.pebbles.iter().enumerate() {
                let pebble = &mut self.particles[index];
                let lever = body.lever(k);
                pebble.position = self.periodic_box.wrap(body.position + lever);
                if !body.fixed {
                    let lever = lever - spin.cross(lever) * lag;
                    pebble.velocity = body.velocity + spin.cross(lever);
                    pebble.angular_velocity = spin;
                }
            }
        }
    }

    /// F = Σ F_p, T = Σ (T_p + r_p × F_p) over the pebbles of each body.
    fn gather(&mut self) {
        for body in &mut self.bodies {
            (body.force, body.torque) = (DVec3::ZERO, DVec3::ZERO);
            for k in 0..body.pebbles.len() {
                let pebble = &self.particles[body.pebbles[k].0];
                body.force += pebble.force;
                body.torque += pebble.torque + body.lever(k).cross(pebble.force);
            }
        }
    }

    /// All contact forces at the present positions, with the present (half-step) velocities.
    /// The springs of all contacts grow over `spring_time`.
    fn evaluate_forces(&mut self, spring_time: f64) {
        for particle in &mut self.particles {
            particle.force = DVec3::ZERO;
            particle.torque = DVec3::ZERO;
        }
        // Only what touches now is put back: a contact that opened has lost its history.
        let mut previous = std::mem::take(&mut self.contacts);
        let mut remembered = |key: &ContactKey| {
            previous
                .remove(key)
                .map_or(History::default(), |c| c.history)
        };

        for a in 0..self.particles.len() {
            for b in a + 1..self.particles.len() {
                if let Some(kinematics) = self.pair_kinematics(a, b) {
                    let key = ContactKey::Pair(a, b);
                    let materials = (self.particles[a].material, self.particles[b].material);
                    self.add_contact(key, kinematics, materials, remembered(&key), spring_time);
                }
            }
        }
        for a in 0..self.particles.len() {
            for wall in 0..self.walls.len() {
                let materials = (self.particles[a].material, self.walls[wall].material);
                let touched = self.wall_kinematics(a, wall);
                let histories = self.wall_histories(&previous, a, wall, &touched);
                for ((feature, kinematics), history) in touched.into_iter().zip(histories) {
                    let key = ContactKey::Wall {
                        particle: a,
                        wall,
                        feature,
                    };
                    self.add_contact(key, kinematics, materials, history, spring_time);
                }
            }
        }
        self.evaluate_bonds();
        self.gather();
    }

    /// Histories of a particle at the parts of a wall that it touches now. A sphere that rolls from one part over onto the next,
    /// off a face over its rim, keeps what it remembers.
    fn wall_histories(
        &self,
        previous: &BTreeMap<ContactKey, Contact>,
        particle: usize,
        wall: usize,
        touched: &[(usize, Kinematics)],
    ) -> Vec<History> {
        let key = |feature| ContactKey::Wall {
            particle,
            wall,
            feature,
        };
        let still = |feature: usize| touched.iter().any(|&(other, _)| other == feature);
        let mut left: Vec<(usize, History)> = previous
            .range(key(0)..=key(usize::MAX))
            .filter_map(|(other, contact)| match *other {
                ContactKey::Wall { feature, .. } if !still(feature) => {
                    Some((feature, contact.history))
                }
                _ => None,
            })
            .collect();
        // A point on an edge belongs to both of its triangles, and round-off decides by which one it is called: it keeps what it
        // remembers before any other feature can take it over.
        let mut renamed = BTreeMap::new();
        if let Shape::Triangles(triangles) = &self.walls[wall].shape {
            let position = self.particles[particle].position;
            let centre = self.walls[wall].carried_back(position, self.time());
            for &(feature, _) in touched {
                let is_new = !previous.contains_key(&key(feature));
                let same = |&(other, _): &(usize, History)| {
                    triangles::share_foot(triangles[other], triangles[feature], centre)
                };
                if is_new && let Some(index) = left.iter().position(same) {
                    renamed.insert(feature, left.remove(index).1);
                }
            }
        }
        touched
            .iter()
            .map(|&(feature, _)| {
                if let Some(contact) = previous.get(&key(feature)) {
                    return contact.history;
                }
                if let Some(&history) = renamed.get(&feature) {
                    return history;
                }
                let near = |&(other, _): &(usize, History)| {
                    self.walls[wall].shape.adjacent(other, feature)
                };
                let next = match &self.walls[wall].shape {
                    Shape::Triangles(triangles) => {
                        let position = self.particles[particle].position;
                        let centre = self.walls[wall].carried_back(position, self.time());
                        let old = left.iter().map(|&(other, _)| triangles[other]);
                        triangles::continued(old, triangles[feature], centre)
                    }
                    _ => left.iter().position(near),
                };
                match next {
                    Some(index) => left.remove(index).1,
                    None => History::default(),
                }
            })
            .collect()
    }

    /// Evaluates the law of one contact, adds force and torque to its partners, and files it.
    fn add_contact(
        &mut self,
        key: ContactKey,
        kinematics: Kinematics,
        (material_a, material_b): (usize, usize),
        mut history: History,
        spring_time: f64,
    ) {
        let law = (self.pair_parameters)(material_a, material_b);
        if kinematics.overlap <= 0.0 && !law.cohesion.acts_apart(&kinematics, &history) {
            return;
        }
        let response = contact_force(
            &law,
            &self.conventions,
            &kinematics,
            &mut history,
            spring_time,
        );
        let (a, b) = match key {
            ContactKey::Pair(a, b) => (a, Some(b)),
            ContactKey::Wall { particle, .. } => (particle, None),
        };
        // Equal and opposite forces on one line through one point, and equal and opposite couples:
        // linear and angular momentum are conserved whatever the law.
        let particle = &mut self.particles[a];
        particle.force += response.force;
        particle.torque += response.couple + kinematics.arm_a.cross(response.force);
        let point = particle.position + kinematics.arm_a;
        if let Some(b) = b {
            let partner = &mut self.particles[b];
            partner.force -= response.force;
            partner.torque -= response.couple + kinematics.arm_b.cross(response.force);
        }
        self.contacts.insert(
            key,
            Contact {
                kinematics,
                point,
                response,
                history,
            },
        );
    }

    /// Geometry and relative motion of two particles, if they touch or are within the reach of cohesion.
    fn pair_kinematics(&self, a: usize, b: usize) -> Option<Kinematics> {
        let (row_a, row_b) = (a, b);
        let uncounted = self.uncounted_overlap(a, b)?;
        let (a, b) = (&self.particles[a], &self.particles[b]);
        if let (Some((one, _)), Some((other, _))) = (a.body, b.body)
            && one == other
        {
            return None;
        }
        let branch = self.periodic_box.minimum_image(a.position - b.position);
        let distance = branch.length();
        // A pair that was glued as it overlapped meets like one with smaller radii.
        let reach = a.radius + b.radius - uncounted;
        let overlap = reach - distance;
        let effective_radius = a.radius * b.radius / reach;
        let law = (self.pair_parameters)(a.material, b.material);
        if overlap <= -law.cohesion.reach(effective_radius) || (a.fixed && b.fixed) {
            return None;
        }
        let normal = branch.try_normalize().unwrap_or(DVec3::X); // concentric: any direction will do
        // The contact point lies halfway through the overlap.
        let [radius_a, radius_b] = [a, b].map(|one| one.radius - 0.5 * uncounted);
        let arm_a = -(radius_a - 0.5 * overlap) * normal;
        let arm_b = (radius_b - 0.5 * overlap) * normal;
        let at = |arm_a: DVec3, arm_b: DVec3| {
            a.velocity + a.angular_velocity.cross(arm_a)
                - (b.velocity + b.angular_velocity.cross(arm_b))
        };
        let relative_velocity = at(arm_a, arm_b);
        let (mut sliding_normal, mut sliding_velocity) = (normal, relative_velocity);
        let mut sliding_distance = distance;
        if self.conventions.sliding_normal == SlidingNormal::HalfStep {
            let earlier = branch - (a.velocity - b.velocity) * self.lag();
            sliding_normal = earlier.try_normalize().unwrap_or(normal);
            sliding_distance = earlier.length();
            let overlap = reach - sliding_distance;
            sliding_velocity = at(
                -(radius_a - 0.5 * overlap) * sliding_normal,
                (radius_b - 0.5 * overlap) * sliding_normal,
            );
        }
        Some(Kinematics {
            normal,
            overlap,
            arm_a,
            arm_b,
            relative_velocity,
            relative_spin: a.angular_velocity - b.angular_velocity,
            sliding_normal,
            sliding_velocity,
            sliding_distance,
            pair: Some(a.velocity - b.velocity),
            effective_mass: 1.0 / (self.mobility(row_a, normal) + self.mobility(row_b, normal)),
            effective_radius,
        })
    }

    /// 1/m of the contact laws: of a pebble over the mass of its body, or over the mass at the contact point. The arm from the
    /// pebble's centre to that point lies along the normal.
    fn mobility(&self, particle: usize, normal: DVec3) -> f64 {
        let particle = &self.particles[particle];
        match particle.body {
            Some((body, k)) if self.contact_point_mass => {
                let body = &self.bodies[body];
                body.mobility(body.lever(k), normal)
            }
            _ => particle.inverse_mass(),
        }
    }

    /// Kinematics of every place where a particle touches a wall. A wall has no end to its mass and no curvature in the contact
    /// laws. The wall stands where it is at t_k, like the particles; its motion is constant, so its velocity is that of the half
    /// step as well, at the place where the particle was then.
    fn wall_kinematics(&self, particle: usize, wall: usize) -> Vec<(usize, Kinematics)> {
        let row = particle;
        let (a, wall) = (&self.particles[particle], &self.walls[wall]);
        if a.fixed {
            return Vec::new();
        }
        let lag = self.lag();
        let earlier = a.position - a.velocity * lag;
        let law = (self.pair_parameters)(a.material, wall.material);
        let reach = a.radius + law.cohesion.reach(a.radius);
        let touches = wall.contacts(a.position, reach, self.time());
        let kinematics = touches.into_iter().map(|touch| {
            let overlap = a.radius - touch.distance;
            let arm_a = -(a.radius - 0.5 * overlap) * touch.normal;
            let at = |arm: DVec3| {
                a.velocity + a.angular_velocity.cross(arm) - wall.motion.velocity_at(earlier + arm)
            };
            let (mut sliding_normal, mut sliding_velocity) = (touch.normal, at(arm_a));
            if self.conventions.sliding_normal == SlidingNormal::HalfStep {
                // Seen from the wall the centre moves and the normal with it; and the wall itself turns.
                let way = a.velocity - wall.motion.velocity_at(earlier);
                let turn = touch.turning * way + wall.motion.angular_velocity().cross(touch.normal);
                sliding_normal = (touch.normal - turn * lag).normalize();
                let distance = touch.distance - way.dot(touch.normal) * lag;
                let overlap = a.radius - distance;
                sliding_velocity = at(-(a.radius - 0.5 * overlap) * sliding_normal);
            }
            let kinematics = Kinematics {
                normal: touch.normal,
                overlap,
                arm_a,
                arm_b: DVec3::ZERO,
                relative_velocity: at(arm_a),
                sliding_normal,
                sliding_velocity,
                sliding_distance: f64::NAN,
                relative_spin: a.angular_velocity - wall.motion.angular_velocity(),
                pair: None,
                effective_mass: 1.0 / self.mobility(row, touch.normal),
                effective_radius: a.radius,
            };
            (touch.feature, kinematics)
        });
        kinematics.collect()
    }

    /// The energies of this instant.
    pub fn energies(&self) -> Energies {
        let mut energies = Energies::default();
        for body in self.bodies.iter().filter(|body| !body.fixed) {
            energies.kinetic += 0.5 * body.mass * body.velocity.length_squared();
            energies.rotational += 0.5 * body.angular_velocity().dot(body.angular_momentum);
            energies.gravitational -= body.mass * self.gravity.dot(body.position);
        }
        let single = |particle: &&Particle| !particle.fixed && particle.body.is_none();
        for particle in self.particles.iter().filter(single) {
            energies.kinetic += 0.5 * particle.mass * particle.velocity.length_squared();
            energies.rotational +=
                0.5 * particle.inertia * particle.angular_velocity.length_squared();
            energies.gravitational -= particle.mass * self.gravity.dot(particle.position);
        }
        energies.elastic = self
            .contacts
            .values()
            .map(|c| c.response.elastic_energy)
            .sum();
        energies
    }

    /// Linear momentum, and angular momentum about the origin, of the particles and bodies that are not fixed
    /// \[kg m/s, kg m²/s\].
    pub fn momentum(&self) -> (DVec3, DVec3) {
        let single = |particle: &&Particle| !particle.fixed && particle.body.is_none();
        let of_bodies = self.bodies.iter().filter(|body| !body.fixed).fold(
            (DVec3::ZERO, DVec3::ZERO),
            |(linear, angular), body| {
                let momentum = body.mass * body.velocity;
                let moment = body.position.cross(momentum) + body.angular_momentum;
                (linear + momentum, angular + moment)
            },
        );
        let free = self.particles.iter().filter(single);
        free.fold(of_bodies, |(linear, angular), particle| {
            let momentum = particle.mass * particle.velocity;
            let spin = particle.inertia * particle.angular_velocity;
            (
                linear + momentum,
                angular + particle.position.cross(momentum) + spin,
            )
        })
    }

    /// Force of the particles on a wall, and their torque on it about a point \[N, N m\].
    pub fn load_on_wall(&self, wall: usize, about: DVec3) -> (DVec3, DVec3) {
        let of_this_wall = self.contacts.iter().filter_map(|(key, contact)| match key {
            ContactKey::Wall { wall: w, .. } if *w == wall => Some(contact),
            _ => None,
        });
        of_this_wall.fold((DVec3::ZERO, DVec3::ZERO), |(force, torque), contact| {
            let response = &contact.response;
            let moment = (contact.point - about).cross(response.force) + response.couple;
            (force - response.force, torque - moment)
        })
    }
}
