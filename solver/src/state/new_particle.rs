//! A particle to be made, and the material that gives it its mass.

use glam::DVec3;

use super::{FIXED, MaterialIndex, PRESCRIBED, Particle, Prescribed, Row, volume};

/// A material as the engine needs it; its laws stand in a table of their own, by pairs.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Name in the scene.
    pub name: String,
    /// Density, kg/m^3.
    pub density: f64,
}

/// A particle to be made.
#[derive(Debug, Clone, PartialEq)]
pub struct NewParticle {
    /// Centre, m.
    pub position: DVec3,
    /// Radius, m.
    pub radius: f64,
    /// Velocity, m/s.
    pub velocity: DVec3,
    /// Angular velocity, rad/s.
    pub angular_velocity: DVec3,
    /// Index of the material.
    pub material: MaterialIndex,
    /// Does not move.
    pub fixed: bool,
    /// Prescribed velocity components, m/s.
    pub prescribed_velocity: [Option<f64>; 3],
    /// Prescribed angular velocity components, rad/s.
    pub prescribed_angular_velocity: [Option<f64>; 3],
}

impl NewParticle {
    /// A free particle at rest.
    #[must_use]
    pub fn at(position: DVec3, radius: f64, material: MaterialIndex) -> Self {
        Self {
            position,
            radius,
            velocity: DVec3::ZERO,
            angular_velocity: DVec3::ZERO,
            material,
            fixed: false,
            prescribed_velocity: [None; 3],
            prescribed_angular_velocity: [None; 3],
        }
    }

    /// Whether some of its motion is prescribed.
    #[must_use]
    pub fn is_prescribed(&self) -> bool {
        let both = [self.prescribed_velocity, self.prescribed_angular_velocity];
        both.iter().flatten().any(Option::is_some)
    }

    /// The record, the mass (kg) and the prescribed components. Fixed particles count as infinitely heavy in contacts,
    /// prescribed ones keep their mass.
    #[must_use]
    pub fn build(
        &self,
        materials: &[Material],
        dimensions: u8,
    ) -> (Particle, f64, Option<Prescribed>) {
        let density = materials[self.material.index()].density;
        let mass = density * volume(self.radius, dimensions);
        let is_prescribed = self.is_prescribed();
        let record = Particle {
            position: self.position,
            radius: self.radius,
            velocity: self.velocity,
            inverse_mass: if self.fixed { 0.0 } else { 1.0 / mass },
            angular_velocity: self.angular_velocity,
            material: self.material,
            flags: if self.fixed { FIXED } else { 0 } | if is_prescribed { PRESCRIBED } else { 0 },
        };
        let prescribed = is_prescribed.then_some(Prescribed {
            row: Row::new(0),
            velocity: self.prescribed_velocity,
            angular_velocity: self.prescribed_angular_velocity,
        });
        (record, mass, prescribed)
    }
}
