//! A clump: the template of rigid bodies.

use crate::state::MaterialIndex;
use glam::{DMat3, DQuat, DVec3};
use mercury_common::formats::clump::Pebble;
use mercury_common::formats::mesh::TriangleMesh;

/// A template of rigid bodies, at scale 1 and with the density of its material.
#[derive(Debug, Clone, PartialEq)]
pub struct Clump {
    /// Name in the scene.
    pub name: String,
    /// Index of the material of its surface.
    pub material: MaterialIndex,
    /// Pebbles in the principal frame, about the centre of mass, m.
    pub pebbles: Vec<Pebble>,
    /// Mass, kg.
    pub mass: f64,
    /// Volume, m^3.
    pub volume: f64,
    /// Principal moments of inertia, kg m^2.
    pub moments: DVec3,
    /// Radius of the smallest sphere about the centre of mass that holds all pebbles, m.
    pub radius: f64,
    /// The mass on which the contacts act that the stiffest pose has at once, over their number, kg; see [`Clump::new`].
    pub contact_mass: f64,
    /// The body's own surface in the principal frame, m, where the clump file names one: used for drawing, not for contacts.
    pub surface: Option<TriangleMesh>,
}

/// Why pebbles and moments are no rigid body.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ClumpError {
    /// Mass, volume, a moment or a radius is not above 0.
    #[error("{what} must be a number above 0, got {value}")]
    NotPositive {
        /// Name of the quantity.
        what: &'static str,
        /// Value that was given.
        value: f64,
    },
    /// The position of a pebble is not a number.
    #[error("pebble {pebble} has no finite position")]
    NotFinite {
        /// Its index, from 0.
        pebble: usize,
    },
    /// There are none.
    #[error("there are no pebbles")]
    NoPebbles,
    /// One moment is larger than the other two together, which no distribution of mass has.
    #[error("the moments {0} kg m^2 fit no body: each must be at most the sum of the other two")]
    Moments(DVec3),
}

impl Clump {
    /// A body of the given pebbles (principal frame, m), mass (kg), volume (m^3) and principal moments (kg m^2).
    ///
    /// `contact_mass` is for the time step. A spring of stiffness k at a point c with the direction n pulls on the mobility
    /// g = 1/M + (c x n).I^-1 (c x n); several springs at once have a largest frequency of at most the root of the sum of k g (the
    /// trace of their matrix). The sum is taken over the pebbles that a plane can touch at once, the largest over some hundred
    /// directions, and inverted. Where a friction spring would see less than the 2/7 of it that a sphere has, that counts.
    ///
    /// # Errors
    /// If this is no body.
    pub fn new(
        name: &str,
        material: MaterialIndex,
        pebbles: Vec<Pebble>,
        mass: f64,
        volume: f64,
        moments: DVec3,
    ) -> Result<Self, ClumpError> {
        let positive = |what, value: f64| {
            if value > 0.0 && value.is_finite() {
                Ok(())
            } else {
                Err(ClumpError::NotPositive { what, value })
            }
        };
        positive("the mass", mass)?;
        positive("the volume", volume)?;
        for moment in moments.to_array() {
            positive("a principal moment", moment)?;
        }
        // The file's digits may round a flat body's moments.
        if 2.0 * moments.max_element() > moments.element_sum() * (1.0 + 1e-9) {
            return Err(ClumpError::Moments(moments));
        }
        if pebbles.is_empty() {
            return Err(ClumpError::NoPebbles);
        }
        let mut radius: f64 = 0.0;
        for (index, pebble) in pebbles.iter().enumerate() {
            if !pebble.position.is_finite() {
                return Err(ClumpError::NotFinite { pebble: index });
            }
            positive("a pebble's radius", pebble.radius)?;
            radius = radius.max(pebble.position.length() + pebble.radius);
        }
        let contact_mass = contact_mass(&pebbles, mass, moments, radius);
        Ok(Self {
            name: name.to_owned(),
            material,
            pebbles,
            mass,
            volume,
            moments,
            radius,
            contact_mass,
            surface: None,
        })
    }

    /// The diameter (m) of a sphere of the same volume: what size distributions mean by the size of a clump.
    #[must_use]
    pub fn equal_volume_diameter(&self) -> f64 {
        libm::cbrt(6.0 * self.volume / std::f64::consts::PI)
    }

    /// Smallest and largest radius of its pebbles, m.
    #[must_use]
    pub fn pebble_radii(&self) -> (f64, f64) {
        let radii = self.pebbles.iter().map(|pebble| pebble.radius);
        radii.fold((f64::INFINITY, 0.0), |(least, most), radius| {
            (least.min(radius), most.max(radius))
        })
    }

    /// Mean radius of its pebbles, m.
    #[must_use]
    pub fn mean_pebble_radius(&self) -> f64 {
        let sum: f64 = self.pebbles.iter().map(|pebble| pebble.radius).sum();
        sum / self.pebbles.len() as f64
    }

    /// The share of the body's mass and volume that files show for each pebble: by the pebbles' own volumes, so that the sum over
    /// the rows of a body is that of the body.
    #[must_use]
    pub fn shares(&self) -> Vec<f64> {
        let cubed = |radius: f64| radius * radius * radius;
        let volumes = self.pebbles.iter().map(|pebble| cubed(pebble.radius));
        let sum: f64 = volumes.clone().sum();
        volumes.map(|volume| volume / sum).collect()
    }

    /// How far the body reaches below and above its centre of mass along x, y, z at a scale and an orientation, m.
    #[must_use]
    pub fn extent(&self, scale: f64, orientation: DQuat) -> (DVec3, DVec3) {
        let (mut below, mut above) = (DVec3::ZERO, DVec3::ZERO);
        for pebble in &self.pebbles {
            let centre = orientation * (pebble.position * scale);
            let radius = DVec3::splat(pebble.radius * scale);
            below = below.max(radius - centre);
            above = above.max(radius + centre);
        }
        (below, above)
    }
}

/// Directions in which [`contact_mass`] looks, beside the principal axes.
const DIRECTIONS: u32 = 400;
/// A pebble counts as touching the same plane as the outermost one if its distance from the plane is at most this part of its
/// radius.
const TOUCHES: f64 = 0.02;

/// See [`Clump::new`].
fn contact_mass(pebbles: &[Pebble], mass: f64, moments: DVec3, reach: f64) -> f64 {
    let golden = std::f64::consts::PI * (3.0 - 5.0f64.sqrt());
    let spread = (0..DIRECTIONS).map(|k| {
        let z = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(DIRECTIONS);
        let angle = golden * f64::from(k);
        let ring = (1.0 - z * z).sqrt();
        let (sin, cos) = libm::sincos(angle);
        DVec3::new(ring * cos, ring * sin, z)
    });
    let axes = DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]);
    let inverse = DMat3::from_diagonal(1.0 / moments);
    let mut largest: f64 = 1.0 / mass;
    for normal in axes.chain(spread) {
        let height = |pebble: &Pebble| pebble.position.dot(normal) + pebble.radius;
        let top = pebbles.iter().map(height).fold(-reach, f64::max);
        let (mut along, mut across) = (0.0, 0.0);
        for pebble in pebbles {
            if height(pebble) < top - TOUCHES * pebble.radius {
                continue;
            }
            let arm = pebble.position.cross(normal);
            along += 1.0 / mass + arm.dot(inverse * arm);
            // The largest over the directions in the plane, bounded by the trace over two of them.
            let point = pebble.position + normal * pebble.radius;
            let (u, v) = normal.any_orthonormal_pair();
            let of = |direction: DVec3| {
                let arm = point.cross(direction);
                1.0 / mass + arm.dot(inverse * arm)
            };
            across += of(u)
                .max(of(v))
                .max(of((u + v).normalize()))
                .max(of((u - v).normalize()));
        }
        largest = largest.max(along).max(across / 3.5);
    }
    1.0 / largest
}
