//! Plans of insertions, deletions, counted regions and flux planes.

use glam::DVec3;
use mercury_common::curve::Curve;
use mercury_common::particle_properties::PropertyValue;
use mercury_common::scene::{Quantity, Total};
use mercury_common::sizes::SizeDistribution;

use super::Region;
use crate::state::MaterialIndex;

/// A source of particles, resolved.
#[derive(Debug, Clone)]
pub struct InsertionPlan {
    /// Unique among insertions: its random streams follow from it and the seed.
    pub name: String,
    /// Where particles appear; they lie wholly inside.
    pub region: Region,
    /// Ingredients that are inserted; at least one.
    pub mixture: Vec<Ingredient>,
    /// Whether sizes are fixed in advance, one in each equal part of the distribution, instead of drawn independently; needs a total
    /// that is a number, mass or volume.
    pub by_quota: bool,
    /// When it is done; `None`: only `until` ends it.
    pub total: Option<Total>,
    /// How fast particles may come; `None`: as fast as they fit.
    pub rate: Option<Rate>,
    /// Mean velocity, m/s.
    pub velocity_mean: DVec3,
    /// Largest deviation of each component, uniform, m/s.
    pub velocity_spread: DVec3,
    /// Active from this time on, s.
    pub from: f64,
    /// Ends at this time, s; infinite: never.
    pub until: f64,
    /// The number of consecutive failed placements after which its region counts as full; at least 1.
    pub attempts: u64,
    /// Walls, by index, that act on both sides and move through the region while it inserts: particles placed behind them are
    /// counted.
    pub closing: Vec<usize>,
}

/// One ingredient of a mixture: spheres of a material, or bodies of a clump.
#[derive(Debug, Clone)]
pub struct Ingredient {
    /// Index of the material.
    pub material: MaterialIndex,
    /// Index of the clump; `None`: spheres.
    pub clump: Option<u32>,
    /// Its sizes; a clump's is the diameter of a sphere of equal volume.
    pub sizes: SizeDistribution,
    /// Its share by number: of the particles drawn. Shares need not sum to 1.
    pub share: f64,
    /// Properties of its grains that are not the default.
    pub properties: Vec<PropertyValue>,
}

/// The rate of an insertion: the upper limit of the amount inserted by a time.
#[derive(Debug, Clone, PartialEq)]
pub enum Rate {
    /// A steady flow from [`InsertionPlan::from`] on.
    Steady {
        /// Measure of the amount.
        quantity: Quantity,
        /// Particles, kg or m^3 per second.
        per_second: f64,
    },
    /// A table of the cumulative amount over time.
    Table {
        /// Measure of the amount.
        quantity: Quantity,
        /// Cumulative amount (not decreasing) over time (s of the simulation), as [`Curve::cumulative`] continues it: nothing before the first row, going
        /// on at the slope of the last two rows after the last. To stop a flow write its end twice.
        amounts: Curve,
    },
}

/// A region in which particles are removed.
#[derive(Debug, Clone, PartialEq)]
pub struct DeletionPlan {
    /// Unique among deletions.
    pub name: String,
    /// Region; a particle is in it by its centre.
    pub region: Region,
}

/// A region whose content is counted at every output time.
#[derive(Debug, Clone, PartialEq)]
pub struct CountedRegion {
    /// Unique among counted regions.
    pub name: String,
    /// Region; particles are counted by their centres.
    pub region: Region,
    /// Volume of its part within the domain, m^3; per metre of depth in two dimensions. Above 0.
    pub volume: f64,
}

/// A plane through which particles are counted.
#[derive(Debug, Clone, PartialEq)]
pub struct FluxPlan {
    /// Unique among fluxes.
    pub name: String,
    /// A point on the plane, m.
    pub point: DVec3,
    /// Length 1; crossings along it count as positive.
    pub normal: DVec3,
    /// The part of it that counts.
    pub part: FluxPart,
}

/// The part of a flux plane that counts crossings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FluxPart {
    /// Everywhere.
    All,
    /// Within this distance of the point, m.
    Disc(f64),
    /// A rectangle with its middle at the point: its sides, m, at right angles to each other and to the normal.
    Rectangle([DVec3; 2]),
}

impl FluxPart {
    /// Whether it holds a place in the plane, given from its point (m).
    #[must_use]
    pub fn holds(&self, place: DVec3) -> bool {
        match self {
            Self::All => true,
            Self::Disc(radius) => place.length_squared() <= radius * radius,
            Self::Rectangle(sides) => {
                (sides.iter()).all(|side| place.dot(*side).abs() <= 0.5 * side.length_squared())
            }
        }
    }
}
