//! The particle table that scenes read: one line per particle, columns found by their names.
//!
//! See `docs/formats/particle-csv.md`.

mod cells;
mod reader;
#[cfg(test)]
mod tests;
mod writer;

use glam::DVec3;

pub use reader::{parse_particle_csv, read_particle_csv};
pub use writer::{push_particle_csv, write_particle_csv};

/// One particle of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct ParticleRow {
    /// Centre in m.
    pub position: DVec3,
    /// Radius in m, positive.
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
const COLUMNS: [&str; 12] = [
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
];

/// How many of [`COLUMNS`] must be there.
const REQUIRED: usize = 4;

/// Position of `material` in [`COLUMNS`], the only column that is not a number.
const MATERIAL: usize = 4;
