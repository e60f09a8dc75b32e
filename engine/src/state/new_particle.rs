//! A particle to be made, and the material that gives it its mass.

use glam::DVec3;

use super::{FIXED, MaterialIndex, PRESCRIBED, Particle, Prescribed, Row, volume};

/// A material in the form that the engine needs; its laws are in a table of their own, by pairs.
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
    /// The prescribed part of its motion. Boxed: few particles have any, and a plan may hold millions of particles.
    pub prescribed: Option<Box<PrescribedMotion>>,
}

/// Components of a motion that are prescribed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PrescribedMotion {
    /// Prescribed components of the velocity, m/s.
    pub velocity: [Option<f64>; 3],
    /// Prescribed components of the angular velocity, rad/s.
    pub angular_velocity: [Option<f64>; 3],
}

impl PrescribedMotion {
    /// These components of the velocity (m/s) and of the angular velocity (rad/s); `None` if there are none.
    #[must_use]
    pub fn boxed(
        velocity: [Option<f64>; 3],
        angular_velocity: [Option<f64>; 3],
    ) -> Option<Box<Self>> {
        let any = velocity
            .iter()
            .chain(&angular_velocity)
            .any(Option::is_some);
        any.then(|| {
            Box::new(Self {
                velocity,
                angular_velocity,
            })
        })
    }
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
            prescribed: None,
        }
    }

    /// Whether some of its motion is prescribed.
    #[must_use]
    pub fn is_prescribed(&self) -> bool {
        let both = self.prescribed_motion();
        let mut components = both.velocity.iter().chain(&both.angular_velocity);
        components.any(Option::is_some)
    }

    /// Prescribed part of its motion.
    #[must_use]
    pub fn prescribed_motion(&self) -> PrescribedMotion {
        self.prescribed.as_deref().copied().unwrap_or_default()
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
        let motion = self.prescribed_motion();
        let prescribed = is_prescribed.then_some(Prescribed {
            row: Row::new(0),
            velocity: motion.velocity,
            angular_velocity: motion.angular_velocity,
        });
        (record, mass, prescribed)
    }
}
