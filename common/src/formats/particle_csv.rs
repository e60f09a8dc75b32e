//! The particle table that scenes read: one line per particle, columns found by their names.
//!
//! See `docs/formats/particle-csv.md`.

mod cells;
mod reader;
#[cfg(test)]
mod tests;
mod writer;

use glam::DVec3;

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
    /// What it is if it is a clump.
    pub clump: Option<Box<ClumpCells>>,
    /// Radius in m, positive; of a clump 0.
    pub radius: f64,
    /// Name of the material, if the table has one for this particle.
    pub material: Option<String>,
    /// Velocity in m/s; zero without its columns.
    pub velocity: DVec3,
    /// Angular velocity in rad/s in the global frame; zero without its columns.
    pub angular_velocity: DVec3,
    /// Volume of the liquid film in m^3, at least 0; zero without its column.
    pub film_volume: f64,
    /// Line of the file it was read from, counted from 1.
    pub line: usize,
}

/// The names a header may use; the first four must be there.
const COLUMNS: [&str; 18] = [
    "x",
    "y",
    "z",
    "radius",
    "material",
    "vx",
    "vy",
    "vz",
    "wx",
    "wy",
    "wz",
    "film_volume",
    "clump",
    "scale",
    "qw",
    "qx",
    "qy",
    "qz",
];

/// Columns that tables of other programs have, and that a start does not need.
const IGNORED: [&str; 15] = [
    "id", "type", "mol", "body", "state", "mass", "density", "volume", "element", "fx", "fy", "fz",
    "tx", "ty", "tz",
];

/// Position of `radius` in [`COLUMNS`].
const RADIUS: usize = 3;
/// Position of `clump` in [`COLUMNS`], which is no number either; what only clumps have stands behind it.
const CLUMP: usize = 12;

/// How many of [`COLUMNS`] must be there.
const REQUIRED: usize = 4;

/// Position of `material` in [`COLUMNS`], which is no number.
const MATERIAL: usize = 4;
