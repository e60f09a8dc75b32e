//! The particle data that the force loop reads and writes.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use super::{MaterialIndex, Plain};
use crate::lanes::Quad;

/// The record that the contact loop reads: 96 bytes, position and radius within one cache line.
///
/// For discs (`dimensions = 2`) masses are per unit length.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C, align(32))]
pub struct Particle {
    /// Centre, m. Between two sorts a particle of a periodic scene may stand up to half a skin outside the domain.
    pub position: DVec3,
    /// Radius, m.
    pub radius: f64,
    /// Velocity of the centre, m/s.
    pub velocity: DVec3,
    /// One over the mass, 1/kg; 0 for particles that contacts cannot move (fixed, or fully prescribed). Of a pebble: over the
    /// mass of its body.
    pub inverse_mass: f64,
    /// Angular velocity in the global frame, rad/s.
    pub angular_velocity: DVec3,
    /// Index of the material in the order of the scene file.
    pub material: MaterialIndex,
    /// [`FIXED`], [`PRESCRIBED`] and [`PEBBLE`].
    pub flags: u32,
}

impl Particle {
    /// The record in quads: position and radius, velocity and inverse mass, angular velocity and what is no number.
    #[inline(always)]
    pub(crate) fn quads(&self) -> &[Quad; 3] {
        bytemuck::must_cast_ref(self)
    }

    /// The quads, to be changed.
    #[inline(always)]
    pub(crate) fn quads_mut(&mut self) -> &mut [Quad; 3] {
        bytemuck::must_cast_mut(self)
    }

    /// Whether it does not move freely: fixed, or some components of its motion are prescribed.
    #[must_use]
    pub fn is_constrained(&self) -> bool {
        self.flags & (FIXED | PRESCRIBED) != 0
    }
}

/// The particle never moves; gravity does not act on it.
pub const FIXED: u32 = 1;
/// Some components of its velocities are prescribed.
pub const PRESCRIBED: u32 = 2;
/// The row is a pebble of a rigid body ([`crate::bodies`]), which moves it.
pub const PEBBLE: u32 = 4;

/// The load of the contacts on one particle in one step.
///
/// One cache line, each vector in a half of its own: sums on a particle follow each other closely, and the processor can
/// hand a stored value on to the next load only if both have the same shape.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Load {
    /// Force, N.
    pub force: DVec3,
    unused_force: f64,
    /// Torque about the centre, N m.
    pub torque: DVec3,
    unused_torque: f64,
}

impl Load {
    /// A force (N) and a torque (N m).
    #[inline(always)]
    #[must_use]
    pub fn new(force: DVec3, torque: DVec3) -> Self {
        Self {
            force,
            unused_force: 0.0,
            torque,
            unused_torque: 0.0,
        }
    }

    /// Force and torque, each with a zero behind it.
    #[inline(always)]
    pub(crate) fn quads(&self) -> &[Quad; 2] {
        bytemuck::must_cast_ref(self)
    }

    /// The quads, to be changed.
    #[inline(always)]
    pub(crate) fn quads_mut(&mut self) -> &mut [Quad; 2] {
        bytemuck::must_cast_mut(self)
    }

    /// Adds a force (N) and a torque (N m).
    #[inline(always)]
    pub fn add(&mut self, force: DVec3, torque: DVec3) {
        self.force += force;
        self.torque += torque;
    }
}

/// Volume of a sphere (m^3), or area of a disc (m^2).
#[must_use]
pub fn volume(radius: f64, dimensions: u8) -> f64 {
    if dimensions == 2 {
        std::f64::consts::PI * radius * radius
    } else {
        4.0 / 3.0 * std::f64::consts::PI * radius * radius * radius
    }
}

/// One over the moment of inertia divided by one over the mass times the squared radius: 5/2 for solid
/// spheres (I = 2/5 m R^2), 2 for discs (I = 1/2 m R^2).
#[must_use]
pub fn inverse_inertia_factor(dimensions: u8) -> f64 {
    if dimensions == 2 { 2.0 } else { 2.5 }
}

crate::state::plain!(Particle {
    position,
    radius,
    velocity,
    inverse_mass,
    angular_velocity,
    material,
    flags
});

impl Plain for Load {
    fn put(&self, bytes: &mut Vec<u8>) {
        self.force.put(bytes);
        self.torque.put(bytes);
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        Ok(Self::new(Plain::take(bytes)?, Plain::take(bytes)?))
    }
}
