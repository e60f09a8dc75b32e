//! Triangles that take the loads on the features of a mesh: for surfaces that move by their loads.

use glam::DVec3;

use super::Mesh;

/// A feature of a mesh, with its corners as [`Mesh::corners`] numbers them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Feature {
    /// A triangle, counted as in [`Mesh::outline`].
    Face(u32),
    /// An edge, by its two ends.
    Edge([u32; 2]),
    /// A corner.
    Corner(u32),
}

impl Mesh {
    /// Feature of a number.
    #[inline]
    #[must_use]
    pub fn feature_of(&self, number: u32) -> Feature {
        let (faces, edges) = (self.facets.len() as u32, self.topology.edge_count() as u32);
        match number.checked_sub(faces) {
            None => Feature::Face(self.file_order[number as usize]),
            Some(edge) if edge < edges => Feature::Edge(self.topology.ends(edge)),
            Some(corner) => Feature::Corner(corner - edges),
        }
    }

    /// Number of each corner among the `vertices` (m) of the `triangles` that the mesh was made of; all of these have an area.
    /// The mesh must not have been reshaped since.
    #[must_use]
    pub fn vertex_numbers(&self, vertices: &[DVec3], triangles: &[[u32; 3]]) -> Vec<u32> {
        let mut numbers = vec![u32::MAX; self.vertices.len()];
        for (facet, &index) in self.facets.iter().zip(&self.file_order) {
            let first = triangles[index as usize];
            // The corners of a facet are turned against those of the triangle.
            for corner in facet.vertices {
                let place = self.vertices[corner as usize];
                let same = first.iter().find(|&&k| vertices[k as usize] == place);
                numbers[corner as usize] = same.copied().unwrap_or(u32::MAX);
            }
        }
        numbers
    }

    /// The triangle of the lowest number at each feature, counted as in [`Mesh::outline`]: of a face the face itself. A corner has one
    /// always.
    #[must_use]
    pub fn lowest_triangles(&self) -> Vec<u32> {
        let (faces, edges) = (self.facets.len(), self.topology.edge_count());
        let mut lowest = vec![u32::MAX; faces + edges + self.vertices.len()];
        for (index, (facet, &number)) in self.facets.iter().zip(&self.file_order).enumerate() {
            let edges_of = facet.edges.map(|edge| faces + edge as usize);
            let corners_of = facet.vertices.map(|corner| faces + edges + corner as usize);
            lowest[index] = number;
            for feature in edges_of.into_iter().chain(corners_of) {
                lowest[feature] = lowest[feature].min(number);
            }
        }
        lowest
    }
}
