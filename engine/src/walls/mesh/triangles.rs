//! Triangles that the features of a mesh belong to, and their sizes: for loads on triangles.

use super::Mesh;

impl Mesh {
    /// The triangles of a feature, ascending: a face's own, all that share an edge or corner; none if there is no such feature.
    /// Triangles are counted as in [`Mesh::outline`].
    pub fn triangles_of(&self, feature: u32, out: &mut Vec<u32>) {
        out.clear();
        let (faces, edges) = (self.facets.len() as u32, self.topology.edge_count() as u32);
        match feature.checked_sub(faces) {
            None => out.push(feature),
            Some(edge) if edge < edges => self.push_triangles_at(edge, out),
            Some(corner) if corner - edges < self.vertices.len() as u32 => {
                for edge in self.topology.edges_at(corner - edges) {
                    self.push_triangles_at(edge, out);
                }
            }
            Some(_) => {}
        }
        for triangle in &mut *out {
            *triangle = self.file_order[*triangle as usize];
        }
        out.sort_unstable();
        out.dedup();
    }

    fn push_triangles_at(&self, edge: u32, out: &mut Vec<u32>) {
        let around = self.topology.triangles_at(edge).iter();
        out.extend(around.map(|&(facet, _)| facet));
    }

    /// Areas of the triangles, m^2, counted as in [`Mesh::outline`].
    #[must_use]
    pub fn areas(&self) -> Vec<f64> {
        let mut areas = vec![0.0; self.len()];
        let own = (0..self.facets.len()).filter(|&facet| self.is_own(facet));
        for (facet, index) in own.map(|k| (&self.facets[k], self.file_order[k])) {
            let [a, b, c] = facet.vertices.map(|k| self.vertices[k as usize]);
            areas[index as usize] = 0.5 * (b - a).cross(c - a).length();
        }
        areas
    }
}
