//! Triangle meshes of surfaces: STL (binary and text) and OBJ.
//!
//! See `docs/formats/surface-mesh.md`. Normals, colours, texture and names are not kept: the order of
//! the vertices gives the side outside (counter-clockwise seen from there).

mod obj;
mod stl;
#[cfg(test)]
mod tests;
mod weld;

use std::path::Path;

use glam::DVec3;

use crate::error::FormatError;

pub use obj::push_obj;
pub use stl::push_binary_stl;

/// A surface made of triangles that share vertices.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TriangleMesh {
    /// Corners in the unit of the file (m if the file follows our convention), each once, in the order
    /// of their first use.
    pub vertices: Vec<DVec3>,
    /// Three indices into `vertices` per triangle, in the order of the file. Triangles whose corners
    /// coincide are kept: see [`degenerate_triangles`](Self::degenerate_triangles).
    pub triangles: Vec<[u32; 3]>,
    /// Number of corners of the file that were merged into another one.
    pub welded: usize,
    /// The coordinates are known in single precision only, as those of a binary STL.
    pub is_single_precision: bool,
    /// Oddities of the file with which it could be read all the same, for the user.
    pub warnings: Vec<String>,
}

impl TriangleMesh {
    /// The mesh of triangles given by the places of their corners (m); equal corners become one.
    #[must_use]
    pub fn from_corners(triangles: &[[DVec3; 3]]) -> Self {
        let count = triangles.len() as u32;
        let surface = Surface {
            vertices: triangles.iter().flatten().copied().collect(),
            triangles: (0..count).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect(),
            ..Surface::default()
        };
        weld::weld(&surface, 0.0)
    }

    /// Positions of the corners of a triangle in m.
    #[must_use]
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|index| self.vertices[index as usize])
    }

    /// Indices of the triangles that have two equal corners or an area of exactly 0, in other words no normal.
    #[must_use]
    pub fn degenerate_triangles(&self) -> Vec<usize> {
        (0..self.triangles.len())
            .filter(|&index| {
                let [a, b, c] = self.corners(index);
                (b - a).cross(c - a) == DVec3::ZERO
            })
            .collect()
    }

    /// Smallest and largest coordinates in m; `None` for an empty mesh.
    #[must_use]
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        let first = *self.vertices.first()?;
        let extend = |(low, high): (DVec3, DVec3), v: &DVec3| (low.min(*v), high.max(*v));
        Some(self.vertices.iter().fold((first, first), extend))
    }
}

impl TriangleMesh {
    /// The mesh with each vertex merged with the first earlier one that is at most `tolerance` (m) away.
    #[must_use]
    pub fn welded_within(&self, tolerance: f64) -> Self {
        let surface = Surface {
            vertices: self.vertices.clone(),
            triangles: self.triangles.clone(),
            is_single_precision: self.is_single_precision,
            warnings: self.warnings.clone(),
        };
        let mut mesh = weld::weld(&surface, tolerance.max(0.0));
        mesh.welded += self.welded;
        mesh
    }
}

/// Reads a mesh and merges equal vertices.
///
/// # Errors
/// As [`read_mesh_welded`].
pub fn read_mesh(path: impl AsRef<Path>) -> Result<TriangleMesh, FormatError> {
    read_mesh_welded(path, 0.0)
}

/// Reads a mesh and merges vertices that are at most `tolerance` (m) from an earlier one.
///
/// The name decides between STL and OBJ, the content between binary and text STL.
///
/// # Errors
/// If the file cannot be read, is empty or cut, ends in neither `.stl` nor `.obj`, has a coordinate that is
/// not a finite number, an index without vertex, or no triangle; if `tolerance` is negative or
/// not finite.
pub fn read_mesh_welded(
    path: impl AsRef<Path>,
    tolerance: f64,
) -> Result<TriangleMesh, FormatError> {
    let path = path.as_ref();
    check_tolerance(path, tolerance)?;
    Ok(weld::weld(&read_surface(path)?, tolerance))
}

/// Reads a mesh and merges equal vertices, which keep the order of the file; those that no triangle uses are left out.
///
/// # Errors
/// As [`read_mesh_welded`].
pub fn read_mesh_in_order(path: impl AsRef<Path>) -> Result<TriangleMesh, FormatError> {
    Ok(weld::weld_in_order(&read_surface(path.as_ref())?, 0.0))
}

fn check_tolerance(path: &Path, tolerance: f64) -> Result<(), FormatError> {
    if !(tolerance >= 0.0 && tolerance.is_finite()) {
        let found = format!("the welding tolerance {tolerance}");
        return Err(FormatError {
            expected: "a finite length of at least 0 m".into(),
            ..FormatError::of_file(path, found)
        });
    }
    Ok(())
}

/// Reads the triangles of the file.
fn read_surface(path: &Path) -> Result<Surface, FormatError> {
    let extension = path
        .extension()
        .map(|extension| extension.to_string_lossy().to_lowercase());
    let parse = match extension.as_deref() {
        Some("stl") => stl::parse,
        Some("obj") => obj::parse,
        other => {
            let found = match other {
                Some(other) => format!("the file type .{other}"),
                None => "a file name without type".into(),
            };
            return Err(FormatError {
                expected: "a surface mesh .stl or .obj".into(),
                ..FormatError::of_file(path, found)
            }
            .with_help("export the surface as STL (binary or text) or OBJ"));
        }
    };
    let bytes = super::read_bytes(path)?;
    if bytes.is_empty() {
        return Err(FormatError::of_file(path, "the file is empty"));
    }
    let surface = parse(path, bytes)?;
    if surface.triangles.is_empty() {
        let error = FormatError::of_file(path, "the mesh has no triangles");
        return Err(match surface.warnings.first() {
            Some(warning) => error.with_help(warning),
            None => error,
        });
    }
    Ok(surface)
}

/// Triangles as a file lists them: corners may occur several times.
#[derive(Debug, Default)]
struct Surface {
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    is_single_precision: bool,
    warnings: Vec<String>,
}

impl Surface {
    /// Adds a triangle with corners of its own.
    ///
    /// Returns false if there are more corners than indices.
    #[must_use]
    fn push(&mut self, corners: [DVec3; 3]) -> bool {
        let Ok(first) = u32::try_from(self.vertices.len()) else {
            return false;
        };
        let Some(last) = first.checked_add(2) else {
            return false;
        };
        self.vertices.extend_from_slice(&corners);
        self.triangles.push([first, first + 1, last]);
        true
    }
}

/// The mesh has more corners than 32-bit indices.
fn too_large(path: &Path) -> FormatError {
    FormatError {
        expected: "at most 4294967295 corners".into(),
        ..FormatError::of_file(path, "a mesh with too many corners")
    }
}
