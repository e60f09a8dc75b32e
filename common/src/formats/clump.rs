//! Rigid clumps: pebbles, and the clump file `NAME.clump.toml`.
//!
//! See `docs/formats/clump-file.md`. [`read_clump`] reads it with the look and care of the scene reader, [`push_clump`]
//! writes it so that every number reads back to the same bits.

mod rules;
#[cfg(test)]
mod tests;
mod writer;

use std::path::{Path, PathBuf};

use glam::{DMat3, DVec3};

pub use crate::scene::{parse_clump, read_clump};
pub use rules::ClumpProblem;
pub use writer::push_clump;

/// A sphere that stands for a part of a rigid body. Pebbles of one body may overlap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pebble {
    /// Centre in m.
    pub position: DVec3,
    /// Radius in m, above 0.
    pub radius: f64,
}

/// Content of a clump file: a rigid body in the frame of its principal axes, and how it came about.
///
/// The body frame has its origin in the centre of mass and the principal axes, in the order of ascending moments, as
/// axes. A point `x` of the input is at `rotation^T (x - centre_of_mass)` in the body frame.
#[derive(Debug, Clone, PartialEq)]
pub struct ClumpFile {
    /// Name of the body; not empty.
    pub name: String,
    /// Density in kg/m3, uniform.
    pub density: f64,
    /// Mass in kg.
    pub mass: f64,
    /// Volume in m3; `density * volume` is the mass.
    pub volume: f64,
    /// Centre of mass in m, in the frame of the input.
    pub centre_of_mass: DVec3,
    /// Principal moments of inertia about the centre of mass in kg m2, ascending.
    pub principal_moments: DVec3,
    /// Its columns are the principal axes in the frame of the input: right-handed, orthonormal.
    pub rotation: DMat3,
    /// How mass, centre and moments were found: `surface`, `union`, `voxels` or `pebbles` by `mclump`, `given` where the
    /// file does not give it.
    pub inertia_method: String,
    /// Spheres that touch in place of the body, centres in the body frame; at least one.
    pub pebbles: Vec<Pebble>,
    /// The file (STL, OBJ) of the body's own surface in the body frame, in m, relative to the clump file; for pictures only.
    pub surface: Option<String>,
    /// Where the body came from: files with their hashes, scale. No tool depends on it.
    pub source: Vec<(String, Remark)>,
    /// Checks that were made, with their results. No tool depends on it.
    pub checks: Vec<(String, Remark)>,
}

/// A value of the tables `[source]` and `[checks]`, which are for people.
#[derive(Debug, Clone, PartialEq)]
pub enum Remark {
    /// A number; finite.
    Number(f64),
    /// A whole number.
    Whole(i64),
    /// True or false.
    Flag(bool),
    /// A text.
    Text(String),
    /// A list.
    List(Vec<Remark>),
    /// Keys with values, in their order; keys are unique.
    Table(Vec<(String, Remark)>),
}

impl From<f64> for Remark {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<bool> for Remark {
    fn from(value: bool) -> Self {
        Self::Flag(value)
    }
}

impl From<&str> for Remark {
    fn from(value: &str) -> Self {
        Self::Text(value.to_owned())
    }
}

impl From<String> for Remark {
    fn from(value: String) -> Self {
        Self::Text(value)
    }
}

impl From<DVec3> for Remark {
    fn from(value: DVec3) -> Self {
        Self::List(value.to_array().map(Self::Number).to_vec())
    }
}

impl ClumpFile {
    /// Where the file of the surface is, for a clump file at `path`.
    #[must_use]
    pub fn surface_path(&self, path: &Path) -> Option<PathBuf> {
        let folder = path.parent().unwrap_or(Path::new(""));
        self.surface.as_ref().map(|surface| folder.join(surface))
    }

    /// Reasons why this is not a rigid body, each with its key; empty for a sound one.
    #[must_use]
    pub fn problems(&self) -> Vec<ClumpProblem> {
        rules::problems(self)
    }
}
