//! Is the surface fit for volume integrals? Report and repair.
//!
//! The volume inside a surface is defined where every edge is passed as often in one direction as in the other. [`inspect`]
//! reports whether it is, and what else is odd; [`prepare`] refuses what is not closed, or repairs it on request, and reports its
//! changes. Whether a surface cuts through itself is not checked.

mod edges;
mod holes;
mod repair;
mod report;
mod shells;
#[cfg(test)]
mod tests;

use glam::DVec3;
use mercury_common::formats::mesh::TriangleMesh;
use thiserror::Error;

pub use report::{Report, inspect};
pub use shells::Shell;

/// Under repair, vertices nearer than this fraction of the diagonal of the surface's box are merged: above the
/// rounding of single-precision files (6e-8), far below any feature.
pub const WELD_FRACTION: f64 = 1e-6;
/// Repair closes a hole if its patch has at most this share of the surface's area.
pub const LARGEST_HOLE: f64 = 0.1;

/// A surface without the requested volume.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SurfaceError {
    /// Edges are not passed equally in both directions.
    #[error("{0}")]
    NotClosed(String),
    /// There is nothing inside.
    #[error(
        "the surface encloses no volume ({volume:e} m3 in a box of {diagonal:e} m diagonal): a flat or folded sheet?"
    )]
    NoVolume {
        /// Signed volume in m3.
        volume: f64,
        /// Diagonal of its box in m.
        diagonal: f64,
    },
    /// A coordinate is not finite, or an index has no vertex.
    #[error("triangle {triangle} has a corner that is not a finite point: the mesh is damaged")]
    BadCorner {
        /// The triangle, counted from 1.
        triangle: usize,
    },
}

/// A surface that encloses a volume: closed, turned outward.
#[derive(Debug, Clone, PartialEq)]
pub struct Prepared {
    /// The surface.
    pub mesh: TriangleMesh,
    /// Report on the surface after preparation.
    pub report: Report,
    /// Changes that were made, in words; empty if none.
    pub done: Vec<String>,
    /// Oddities that remain, in words.
    pub warnings: Vec<String>,
}

/// Makes a surface ready for volume integrals. Shells that are turned inward are turned round, cavities excepted. With `repair`
/// vertices are welded, collapsed and doubled triangles dropped, inconsistent ones turned and small holes closed.
///
/// # Errors
/// If the surface is not closed (after the repair), with the edges named; if it encloses nothing; if a corner is not finite.
pub fn prepare(mesh: TriangleMesh, repair: bool) -> Result<Prepared, SurfaceError> {
    let good = |index: &u32| {
        mesh.vertices
            .get(*index as usize)
            .is_some_and(|v| v.is_finite())
    };
    if let Some(bad) = mesh.triangles.iter().position(|t| !t.iter().all(good)) {
        return Err(SurfaceError::BadCorner { triangle: bad + 1 });
    }
    let mut done = Vec::new();
    let mut mesh = mesh;
    let mut report = inspect(&mesh);
    if repair && !report.is_sound() {
        done = repair::repair(&mut mesh);
        report = inspect(&mesh);
    }
    if !report.is_closed() {
        return Err(SurfaceError::NotClosed(report.refusal(&mesh, repair)));
    }
    if let Some(word) = shells::turn_outward(&mut mesh, &mut report, repair) {
        done.push(word);
    }
    let volume: f64 = report.shells.iter().map(|shell| shell.volume).sum();
    let diagonal = diagonal(&mesh);
    // A thousand times the round-off of the sum.
    if volume <= 1e-13 * diagonal.powi(3) {
        return Err(SurfaceError::NoVolume { volume, diagonal });
    }
    let mut warnings = mesh.warnings.clone();
    warnings.extend(report.warnings());
    Ok(Prepared {
        mesh,
        report,
        done,
        warnings,
    })
}

/// Diagonal of the axis-parallel box in m; 0 for an empty mesh.
pub(crate) fn diagonal(mesh: &TriangleMesh) -> f64 {
    mesh.bounds()
        .map_or(0.0, |(low, high)| (high - low).length())
}

/// Signed volume of the tetrahedron of a triangle and an origin.
pub(crate) fn tetrahedron(corners: [DVec3; 3], origin: DVec3) -> f64 {
    let [a, b, c] = corners.map(|corner| corner - origin);
    a.dot(b.cross(c)) / 6.0
}
