//! Particles and contacts at one instant, as plain lists: what fields are made of, wherever it comes from.

use glam::DVec3;

/// The particles; all lists have one entry per particle.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Particles {
    /// The number that names the particle.
    pub id: Vec<u32>,
    /// Index of the material.
    pub material: Vec<u32>,
    /// Whether the particle moves by itself; fixed and driven ones are boundary.
    pub flowing: Vec<bool>,
    /// Centre of mass, m.
    pub position: Vec<DVec3>,
    /// Velocity of the centre of mass, m/s.
    pub velocity: Vec<DVec3>,
    /// Mass, kg; empty if the input has none.
    pub mass: Vec<f64>,
    /// Volume, m^3.
    pub volume: Vec<f64>,
    /// Radius, m; of a body that of the sphere of its volume.
    pub radius: Vec<f64>,
    /// Angular velocity, rad/s; empty if the input has none.
    pub angular_velocity: Vec<DVec3>,
    /// Angular momentum about the centre, kg m^2/s; empty without masses or angular velocities.
    pub spin: Vec<DVec3>,
    /// Volume of the liquid that the particle holds, m^3; empty if the input has none.
    pub liquid: Vec<f64>,
}

impl Particles {
    /// The number of particles.
    #[must_use]
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// Whether there are no particles.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }
}

/// The contact partner of a particle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Partner {
    /// A particle, by its row.
    Particle(u32),
    /// A wall, by its index.
    Wall(u32),
}

/// The contacts; all lists have one entry per contact.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Contacts {
    /// Row of the particle that the force acts on.
    pub particle: Vec<u32>,
    /// The other side.
    pub partner: Vec<Partner>,
    /// Contact point, m, beside the particle where the domain is periodic.
    pub point: Vec<DVec3>,
    /// From the contact point to the centre of the particle, m.
    pub arm: Vec<DVec3>,
    /// From the contact point to the centre of the partner (its image there), m; zero at a wall.
    pub partner_arm: Vec<DVec3>,
    /// Unit normal, from the partner to the particle.
    pub normal: Vec<DVec3>,
    /// Force on the particle, N.
    pub force: Vec<DVec3>,
    /// Couple on the particle beyond the lever arm of the force, N m; empty if the input has none.
    pub couple: Vec<DVec3>,
}

impl Contacts {
    /// The number of contacts.
    #[must_use]
    pub fn len(&self) -> usize {
        self.particle.len()
    }

    /// Whether there are no contacts.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.particle.is_empty()
    }
}

/// The space that the particles live in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Space {
    /// Lower corner of the domain, m.
    pub min: DVec3,
    /// Upper corner of the domain, m.
    pub max: DVec3,
    /// Along which axes the domain repeats.
    pub periodic: [bool; 3],
    /// 2 or 3; in two dimensions all quantities are per metre of depth.
    pub dimensions: u8,
}

impl Default for Space {
    fn default() -> Self {
        Self {
            min: DVec3::ZERO,
            max: DVec3::ZERO,
            periodic: [false; 3],
            dimensions: 3,
        }
    }
}

impl Space {
    /// Length of the domain along an axis, m; 1 along the third axis in two dimensions.
    #[must_use]
    pub fn extent(&self, axis: usize) -> f64 {
        if axis == 2 && self.dimensions == 2 {
            1.0
        } else {
            self.max[axis] - self.min[axis]
        }
    }

    /// The period along an axis, if it has one.
    #[must_use]
    pub fn period(&self, axis: usize) -> Option<f64> {
        let length = self.max[axis] - self.min[axis];
        (self.periodic[axis] && length > 0.0).then_some(length)
    }

    /// The shortest of the periodic images of a distance.
    #[must_use]
    pub fn nearest(&self, mut distance: DVec3) -> DVec3 {
        for axis in 0..3 {
            if let Some(period) = self.period(axis) {
                distance[axis] -= period * (distance[axis] / period).round();
            }
        }
        distance
    }
}

/// Everything at one instant.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct State {
    /// Time, s.
    pub time: f64,
    /// Where the particles live.
    pub space: Space,
    /// The particles.
    pub particles: Particles,
    /// The contacts, if the input has them.
    pub contacts: Option<Contacts>,
    /// Displacement of each particle since an earlier instant, m; NaN for particles that were not there then.
    pub displacement: Option<Vec<DVec3>>,
}
