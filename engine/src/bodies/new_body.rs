//! A rigid body to be made.

use glam::{DQuat, DVec3};

use super::{Clump, angular_velocity};
use crate::state::{
    Body, BodyIndex, FIXED, Id, Load, PEBBLE, PRESCRIBED, Particle, Particles, PrescribedBody,
};

/// A body to be made of a clump.
#[derive(Debug, Clone, PartialEq)]
pub struct NewBody {
    /// Index of its clump.
    pub clump: u32,
    /// Factor on all lengths.
    pub scale: f64,
    /// Centre of mass, m.
    pub position: DVec3,
    /// From the principal frame to the global one, of length 1.
    pub orientation: DQuat,
    /// m/s
    pub velocity: DVec3,
    /// In the global frame, rad/s.
    pub angular_velocity: DVec3,
    /// Does not move.
    pub fixed: bool,
    /// Prescribed velocity components, m/s.
    pub prescribed_velocity: [Option<f64>; 3],
    /// Prescribed angular velocity components, global frame, rad/s.
    pub prescribed_angular_velocity: [Option<f64>; 3],
}

impl NewBody {
    /// A free body at rest, at scale 1, principal axes along x, y, z.
    #[must_use]
    pub fn at(position: DVec3, clump: u32) -> Self {
        Self {
            clump,
            scale: 1.0,
            position,
            orientation: DQuat::IDENTITY,
            velocity: DVec3::ZERO,
            angular_velocity: DVec3::ZERO,
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

    /// Its clump, of all clumps.
    #[must_use]
    pub fn clump<'a>(&self, clumps: &'a [Clump]) -> &'a Clump {
        &clumps[self.clump as usize]
    }

    /// Factor on volumes and masses.
    #[must_use]
    pub fn volume_factor(&self) -> f64 {
        self.scale * self.scale * self.scale
    }

    /// Mass, kg.
    #[must_use]
    pub fn mass(&self, clumps: &[Clump]) -> f64 {
        self.clump(clumps).mass * self.volume_factor()
    }

    /// Radius of the smallest sphere about the centre of mass that holds all pebbles, m.
    #[must_use]
    pub fn radius(&self, clumps: &[Clump]) -> f64 {
        self.clump(clumps).radius * self.scale
    }

    /// Centres (m, not wrapped into periodic domains) and radii (m) of the pebbles.
    pub fn spheres<'a>(&'a self, clump: &'a Clump) -> impl Iterator<Item = (DVec3, f64)> + 'a {
        clump.pebbles.iter().map(|pebble| {
            let offset = self.orientation * (pebble.position * self.scale);
            (self.position + offset, pebble.radius * self.scale)
        })
    }

    /// The body, with id, first pebble and number of pebbles still to be filled in.
    #[must_use]
    pub fn body(&self, clumps: &[Clump]) -> Body {
        let clump = self.clump(clumps);
        let cubed = self.volume_factor();
        let mut body = Body {
            id: Id::new(0),
            clump: self.clump,
            material: clump.material,
            flags: if self.fixed { FIXED } else { 0 }
                | if self.is_prescribed() { PRESCRIBED } else { 0 },
            first: 0,
            count: 0,
            position: self.position,
            velocity: self.velocity,
            orientation: self.orientation,
            angular_momentum: DVec3::ZERO,
            angular_velocity: DVec3::ZERO,
            moments: clump.moments * (cubed * self.scale * self.scale),
            mass: clump.mass * cubed,
            volume: clump.volume * cubed,
            radius: clump.radius * self.scale,
            load: Load::default(),
        };
        body.angular_momentum = body.inertia_times(self.angular_velocity);
        // Of the momentum, as in every later step.
        body.angular_velocity =
            angular_velocity(body.orientation, body.angular_momentum, body.moments);
        body
    }

    /// Appends the body and its pebbles; returns its id. Pebbles of fixed bodies count as infinitely heavy in contacts.
    pub fn add_to(&self, particles: &mut Particles, clumps: &[Clump]) -> u32 {
        let clump = self.clump(clumps);
        let body = self.body(clumps);
        let shares = clump.shares();
        let pebbles = self.spheres(clump).zip(&clump.pebbles).zip(&shares);
        let pebbles = pebbles.map(|(((position, radius), pebble), share)| {
            let lever = position - self.position;
            let record = Particle {
                position,
                radius,
                velocity: body.velocity + body.angular_velocity.cross(lever),
                inverse_mass: if self.fixed { 0.0 } else { 1.0 / body.mass },
                angular_velocity: body.angular_velocity,
                material: body.material,
                flags: body.flags | PEBBLE,
            };
            (record, share * body.mass, pebble.position * self.scale)
        });
        let prescribed = self.is_prescribed().then_some(PrescribedBody {
            body: BodyIndex::new(0),
            velocity: self.prescribed_velocity,
            angular_velocity: self.prescribed_angular_velocity,
        });
        particles.push_body(body, pebbles, prescribed)
    }
}
