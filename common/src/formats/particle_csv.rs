//! The particle table that scenes read: one line per particle, columns found by their names.
//!
//! See `docs/formats/particle-csv.md`.

mod reader;
#[cfg(test)]
mod tests;
mod writer;

use glam::DVec3;

use crate::particle_properties::{PARTICLE_PROPERTIES, ParticleProperty, PropertyValue};
use crate::units::Dimension;

pub use reader::{ParticleTableReader, parse_particle_csv, read_particle_csv};
pub use writer::{push_particle_csv, write_particle_csv};

/// A clump of a table instead of a sphere.
#[derive(Debug, Clone, PartialEq)]
pub struct ClumpCells {
    /// Name of the template.
    pub name: String,
    /// From the principal frame to the global one, [w, x, y, z], of any length but 0; the identity without its columns.
    pub orientation: [f64; 4],
    /// Factor on all lengths, positive; 1 without its column.
    pub scale: f64,
}

/// One particle of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct ParticleRow {
    /// Centre in m; of a clump its centre of mass.
    pub position: DVec3,
    /// Cells of a clump; none for a sphere.
    pub clump: Option<Box<ClumpCells>>,
    /// Radius in m, positive; of a clump 0.
    pub radius: f64,
    /// Name of the material, if the table has one for this particle.
    pub material: Option<String>,
    /// Velocity in m/s; zero without its columns.
    pub velocity: DVec3,
    /// Angular velocity in rad/s in the global frame; zero without its columns.
    pub angular_velocity: DVec3,
    /// [Properties](crate::particle_properties) with values that are not the default.
    pub properties: Vec<PropertyValue>,
    /// Line of the file it was read from, counted from 1.
    pub line: usize,
}

/// The names a header may use beside those of properties; the first four must be there.
const COLUMNS: [&str; 17] = [
    "x", "y", "z", "radius", "material", "vx", "vy", "vz", "wx", "wy", "wz", "clump", "scale",
    "qw", "qx", "qy", "qz",
];

/// Columns that tables of other programs have, and that a start does not need.
const IGNORED: [&str; 15] = [
    "id", "type", "mol", "body", "state", "mass", "density", "volume", "element", "fx", "fy", "fz",
    "tx", "ty", "tz",
];

/// Position of `radius` in [`COLUMNS`].
const RADIUS: usize = 3;
/// Position of `clump` in [`COLUMNS`], which is no number either; what only clumps have stands behind it.
const CLUMP: usize = 11;

/// Number of [`COLUMNS`], from the first, that must be there.
const REQUIRED: usize = 4;

/// Position of `material` in [`COLUMNS`], which is no number.
const MATERIAL: usize = 4;

/// A column that is read.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Named {
    /// Place in [`COLUMNS`].
    Fixed(usize),
    /// Place among the properties.
    Property(usize),
}

impl Named {
    fn of(name: &str) -> Option<Self> {
        let fixed = COLUMNS.iter().position(|known| *known == name);
        let given = |property: &ParticleProperty| property.given.is_some() && property.name == name;
        let property = || PARTICLE_PROPERTIES.iter().position(given);
        fixed
            .map(Self::Fixed)
            .or_else(|| property().map(Self::Property))
    }

    fn name(self) -> &'static str {
        match self {
            Self::Fixed(column) => COLUMNS[column],
            Self::Property(place) => PARTICLE_PROPERTIES[place].name,
        }
    }

    /// Quantity of its numbers; nothing for words, factors and orientations.
    fn dimension(self) -> Option<Dimension> {
        match self {
            Self::Fixed(0..=RADIUS) => Some(Dimension::LENGTH),
            Self::Fixed(5..=7) => Some(Dimension::SPEED),
            Self::Fixed(8..=10) => Some(Dimension::ANGULAR_VELOCITY),
            Self::Fixed(_) => None,
            Self::Property(place) => Dimension::of_unit(PARTICLE_PROPERTIES[place].unit),
        }
    }
}

/// All names that a header may use, in the order of messages.
fn all_names() -> Vec<&'static str> {
    let (all, of_clumps) = COLUMNS.split_at(CLUMP);
    let properties = ParticleProperty::given().map(|property| property.name);
    let all = all.iter().copied().chain(properties);
    all.chain(of_clumps.iter().copied()).collect()
}
