//! Contacts with walls that wear, one record for each contact and force evaluation.

use glam::DVec3;

/// The quantities of a contact of a particle with a wall from which wear is computed. Places and directions are in the wall's own
/// frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rub {
    /// Index of the wall.
    pub wall: u16,
    /// Feature of the wall.
    pub feature: u32,
    /// The nearest point of the surface, m.
    pub foot: DVec3,
    /// Unit normal towards the particle.
    pub normal: DVec3,
    /// Mean |F_n| over the step, N, without adhesion.
    pub load: f64,
    /// |v_t| dt: displacement of the particle's surface along the wall, m.
    pub way: f64,
    /// The part of it beyond the friction spring, m.
    pub slip: f64,
    /// Energy dissipated by sliding, J.
    pub work: f64,
    /// The impact, where the contact begins in this evaluation.
    pub impact: Option<Impact>,
}

crate::state::plain!(Rub {
    wall,
    feature,
    foot,
    normal,
    load,
    way,
    slip,
    work,
    impact
});

crate::state::plain!(Impact {
    mass,
    diameter,
    speed,
    approach
});

/// A particle at its first touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Impact {
    /// Its mass, of a pebble that of its body, kg.
    pub mass: f64,
    /// Its diameter, m.
    pub diameter: f64,
    /// Speed of its centre relative to the wall at the contact point, m/s.
    pub speed: f64,
    /// The part of the speed along the normal, towards the wall, m/s.
    pub approach: f64,
}
