//! State of a simulation between two steps: particles, contacts with their history, the periodic box, and the energies that can
//! be read off them.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};

use super::laws::{ContactForce, History, Kinematics};

/// A solid sphere (or, in two dimensions, a solid disc in the x-y plane).
#[derive(Debug, Clone)]
pub struct Particle {
    /// Position of the centre \[m\].
    pub position: DVec3,
    /// Velocity of the centre \[m/s\]; between steps it belongs to the same instant as `position`.
    pub velocity: DVec3,
    /// Angular velocity in the global frame \[rad/s\].
    pub angular_velocity: DVec3,
    /// Turns the directions of the first instant into the present ones.
    pub orientation: DQuat,
    /// Radius \[m\].
    pub radius: f64,
    /// Mass \[kg\]; per unit length for a disc \[kg/m\]. Kept for fixed particles too, but not used.
    pub mass: f64,
    /// Moment of inertia about any axis of a sphere, about z of a disc \[kg m²\].
    pub inertia: f64,
    /// Index that the pair-parameter function receives.
    pub material: usize,
    /// A fixed particle counts as infinitely heavy: forces never change its velocities, but a
    /// velocity that it has been given does move it.
    pub fixed: bool,
    /// Components of the velocity that keep their present value whatever the forces. Unlike a
    /// fixed particle such a particle has its own mass in the contact laws, and touches walls.
    pub velocity_held: [bool; 3],
    /// Components of the angular velocity that are held.
    pub angular_velocity_held: [bool; 3],
    /// The body that it is a pebble of, and which one; that moves it. Its `mass` is then that of the whole body.
    pub body: Option<(usize, usize)>,
    /// Sum of the contact forces of the last evaluation, without gravity \[N\].
    pub force: DVec3,
    /// Sum of the contact torques about the centre of the last evaluation \[N m\].
    pub torque: DVec3,
}

impl Particle {
    /// A sphere at rest in the origin: m = (4/3) π R³ ρ, I = (2/5) m R².
    pub fn sphere(radius: f64, density: f64) -> Self {
        let mass = 4.0 / 3.0 * PI * radius.powi(3) * density;
        Self::at_rest(radius, mass, 0.4 * mass * radius * radius)
    }

    /// A disc at rest in the origin: m = π R² ρ per unit length, I = m R²/2.
    pub fn disc(radius: f64, density: f64) -> Self {
        let mass = PI * radius * radius * density;
        Self::at_rest(radius, mass, 0.5 * mass * radius * radius)
    }

    fn at_rest(radius: f64, mass: f64, inertia: f64) -> Self {
        Self {
            position: DVec3::ZERO,
            velocity: DVec3::ZERO,
            angular_velocity: DVec3::ZERO,
            orientation: DQuat::IDENTITY,
            radius,
            mass,
            inertia,
            material: 0,
            fixed: false,
            velocity_held: [false; 3],
            angular_velocity_held: [false; 3],
            body: None,
            force: DVec3::ZERO,
            torque: DVec3::ZERO,
        }
    }

    /// This particle elsewhere, moving.
    pub fn placed(mut self, position: DVec3, velocity: DVec3, angular_velocity: DVec3) -> Self {
        self.position = position;
        self.velocity = velocity;
        self.angular_velocity = angular_velocity;
        self
    }

    /// 1/m as the contact laws see it: zero for a fixed particle \[1/kg\].
    pub fn inverse_mass(&self) -> f64 {
        if self.fixed { 0.0 } else { 1.0 / self.mass }
    }
}

/// Periodic axes, with their periods.
#[derive(Debug, Clone, Copy, Default)]
pub struct PeriodicBox {
    /// Lower corner \[m\].
    pub min: DVec3,
    /// Period along x, y, z \[m\]; `None`: the axis is not periodic. A period must exceed twice the
    /// largest diameter, so that no pair can touch through two images at once.
    pub period: [Option<f64>; 3],
}

impl PeriodicBox {
    /// The shortest of all the branch vectors that join two particles and their images.
    pub fn minimum_image(&self, mut branch: DVec3) -> DVec3 {
        for axis in 0..3 {
            if let Some(period) = self.period[axis] {
                branch[axis] -= period * (branch[axis] / period).round();
            }
        }
        branch
    }

    /// The image of a position that lies in `min <= x < min + period`.
    pub fn wrap(&self, mut position: DVec3) -> DVec3 {
        for axis in 0..3 {
            if let Some(period) = self.period[axis] {
                position[axis] -= period * ((position[axis] - self.min[axis]) / period).floor();
            }
        }
        position
    }
}

/// Partners of a contact. The first partner is always A of the contact laws, the second B.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum ContactKey {
    /// Two particles, the lower index first.
    Pair(usize, usize),
    /// A particle and one feature (face, edge, ...) of a wall.
    Wall {
        /// Index of the particle.
        particle: usize,
        /// Index of the wall.
        wall: usize,
        /// Number of the feature, see [`super::walls::WallContact::feature`].
        feature: usize,
    },
}

/// A contact as the last force evaluation saw it.
#[derive(Debug, Clone, Copy)]
pub struct Contact {
    /// Geometry and relative motion.
    pub kinematics: Kinematics,
    /// The contact point \[m\].
    pub point: DVec3,
    /// Force and couple on A, and the energy stored.
    pub response: ContactForce,
    /// Memory of the contact for the next step.
    pub history: History,
}

/// Energies at one instant \[J\] (discs: per unit length). Fixed particles count nowhere, except
/// that the springs of their contacts count as elastic.
#[derive(Debug, Clone, Copy, Default)]
pub struct Energies {
    /// Σ m v²/2.
    pub kinetic: f64,
    /// Σ I ω²/2.
    pub rotational: f64,
    /// −Σ m g·x.
    pub gravitational: f64,
    /// Energy that the springs of all contacts would give back.
    pub elastic: f64,
}

impl Energies {
    /// The sum of the four.
    pub fn total(&self) -> f64 {
        self.kinetic + self.rotational + self.gravitational + self.elastic
    }
}
