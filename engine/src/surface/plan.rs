//! Plan of a sheet, as known before the first step of a run.

use glam::DVec3;

use crate::state::MaterialIndex;

/// Faces of a sheet that touch particles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Faces {
    /// Both.
    #[default]
    Both,
    /// The one to which the triangles turn counter-clockwise.
    Front,
}

/// A surface of triangles whose vertices move by forces: a sheet.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfacePlan {
    /// Name as in the scene.
    pub name: String,
    /// Index of its material: its laws are those of the contacts.
    pub material: MaterialIndex,
    /// Thickness, m. Particles touch the triangles themselves, which are the middle of the sheet; vertices touch walls as spheres of half
    /// the thickness.
    pub thickness: f64,
    /// Faces that touch particles.
    pub faces: Faces,
    /// Whether its vertices touch walls.
    pub touches_walls: bool,
    /// Vertices of each triangle, in the order of the file, all turned alike.
    pub triangles: Vec<[u32; 3]>,
    /// First positions of the vertices, m, in the order of the file.
    pub vertices: Vec<DVec3>,
    /// Masses of the vertices, kg; infinite for those that are held.
    pub masses: Vec<f64>,
}

impl SurfacePlan {
    /// Masses of vertices that share the mass of their triangles in thirds, kg, for a `density` in kg/m^3, a `thickness` and
    /// `vertices` in m.
    #[must_use]
    pub fn lumped_masses(
        vertices: &[DVec3],
        triangles: &[[u32; 3]],
        density: f64,
        thickness: f64,
    ) -> Vec<f64> {
        let mut masses = vec![0.0; vertices.len()];
        for corners in triangles {
            let [a, b, c] = corners.map(|k| vertices[k as usize]);
            let area = 0.5 * (b - a).cross(c - a).length();
            for &corner in corners {
                masses[corner as usize] += density * thickness * area / 3.0;
            }
        }
        masses
    }
}
