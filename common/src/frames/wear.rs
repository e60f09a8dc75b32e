//! The tables of worn walls: one row per vertex that is worn, and one per triangle.

use std::collections::HashMap;

use glam::DVec3;

use super::{ColumnVisitor, Table, TableReader, TableWriter};
use crate::formats::mesh::TriangleMesh;
use crate::surfaces::Surface;

/// Worn vertices of mesh walls; all lists have one entry per row.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WearFrame {
    /// Time, in s.
    pub time: f64,
    /// Number of time steps made.
    pub step: u64,
    /// Index of the wall.
    pub wall: Vec<u32>,
    /// Number of the vertex: by first appearance among the corners of the triangles of the wall in `.surfaces.arrow`.
    pub vertex: Vec<u32>,
    /// First place in the wall's own frame, in m.
    pub first: Vec<DVec3>,
    /// Displacement from there in the wall's own frame, in m.
    pub displacement: Vec<DVec3>,
    /// Depth against the first normal, in m; along it where the wall is worn more on the other side.
    pub depth: Vec<f64>,
    /// Volume that waits to be removed there, in m^3.
    pub owed: Vec<f64>,
}

impl WearFrame {
    /// A mesh wall as it is worn, and the depth of each of its vertices, m: 0 for those without a row. Vertices are found by their first
    /// place.
    #[must_use]
    pub fn worn(&self, wall: u32, mesh: &TriangleMesh) -> (TriangleMesh, Vec<f64>) {
        let key = |place: DVec3| place.to_array().map(|x| (x + 0.0).to_bits());
        let rows = (0..self.wall.len()).filter(|&row| self.wall[row] == wall);
        let at: HashMap<[u64; 3], usize> = rows.map(|row| (key(self.first[row]), row)).collect();
        let (mut worn, mut depths) = (mesh.clone(), vec![0.0; mesh.vertices.len()]);
        if at.is_empty() {
            return (worn, depths);
        }
        for (vertex, depth) in worn.vertices.iter_mut().zip(&mut depths) {
            if let Some(&row) = at.get(&key(*vertex)) {
                *vertex += self.displacement[row];
                *depth = self.depth[row];
            }
        }
        (worn, depths)
    }

    /// The surfaces of all walls as they are worn.
    #[must_use]
    pub fn worn_surfaces(&self, surfaces: &[Surface]) -> Vec<Surface> {
        let worn = |(wall, surface): (u32, &Surface)| match surface {
            Surface::Mesh(mesh) => Surface::Mesh(self.worn(wall, mesh).0),
            other => other.clone(),
        };
        (0u32..).zip(surfaces).map(worn).collect()
    }
}

impl Table for WearFrame {
    const KIND: &'static str = "wear";
    type Layout = ();

    fn moment(&mut self) -> (&mut f64, &mut u64) {
        (&mut self.time, &mut self.step)
    }

    fn columns(&mut self, (): &(), visitor: &mut impl ColumnVisitor) {
        let vertex = "number by first appearance among the corners of the wall's triangles in .surfaces.arrow";
        let first = "first place, the wall's own frame";
        let way = "displacement from the first place, the wall's own frame";
        let depth = "depth against the first normal, along it where more is worn on the other side";
        visitor.column(&mut self.wall, &["wall"], "1", "index of the wall");
        visitor.column(&mut self.vertex, &["vertex"], "1", vertex);
        visitor.column(&mut self.first, &["x", "y", "z"], "m", first);
        visitor.column(&mut self.displacement, &["dx", "dy", "dz"], "m", way);
        visitor.column(&mut self.depth, &["depth"], "m", depth);
        let owed = "volume that waits to be removed there";
        visitor.column(&mut self.owed, &["owed"], "m^3", owed);
    }

    fn check(&self, (): &()) -> Result<(), String> {
        let is_place = |row: &usize| {
            self.first[*row].is_finite()
                && self.displacement[*row].is_finite()
                && self.depth[*row].is_finite()
        };
        let rows = self
            .first
            .len()
            .min(self.displacement.len())
            .min(self.depth.len());
        match (0..rows).find(|row| !is_place(row)) {
            Some(row) => Err(format!(
                "row {row}: a place, displacement or depth that is not finite"
            )),
            None => Ok(()),
        }
    }
}

/// Worn triangles of mesh walls; all lists have one entry per row.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WearTriangleFrame {
    /// Time, in s.
    pub time: f64,
    /// Number of time steps made.
    pub step: u64,
    /// Index of the wall.
    pub wall: Vec<u32>,
    /// Index of the triangle among those of its wall in `.surfaces.arrow`.
    pub triangle: Vec<u32>,
    /// Volume that contacts on it wore since the start, in m^3.
    pub owed: Vec<f64>,
    /// Volume between its first place and the present one, in m^3.
    pub removed: Vec<f64>,
}

impl Table for WearTriangleFrame {
    const KIND: &'static str = "wear_triangles";
    type Layout = ();

    fn moment(&mut self) -> (&mut f64, &mut u64) {
        (&mut self.time, &mut self.step)
    }

    fn columns(&mut self, (): &(), visitor: &mut impl ColumnVisitor) {
        let triangle = "index among the triangles of the wall in .surfaces.arrow";
        let owed = "volume that contacts on it wore since the start";
        let removed = "volume between its first place and the present one";
        visitor.column(&mut self.wall, &["wall"], "1", "index of the wall");
        visitor.column(&mut self.triangle, &["triangle"], "1", triangle);
        visitor.column(&mut self.owed, &["owed"], "m^3", owed);
        visitor.column(&mut self.removed, &["removed"], "m^3", removed);
    }
}

/// Writes `<prefix>.wear.arrow`.
pub type WearWriter = TableWriter<WearFrame>;

/// Reads `<prefix>.wear.arrow`.
pub type WearReader = TableReader<WearFrame>;

/// Writes `<prefix>.wear_triangles.arrow`.
pub type WearTriangleWriter = TableWriter<WearTriangleFrame>;

/// Reads `<prefix>.wear_triangles.arrow`.
pub type WearTriangleReader = TableReader<WearTriangleFrame>;

#[cfg(test)]
mod tests {
    use super::super::FramesHeader;
    use super::*;

    fn frame(step: u64, rows: u32) -> WearFrame {
        let places = |scale: f64| {
            let place = |k: u32| DVec3::new(0.1, 0.2, -0.3) * (scale + f64::from(k));
            (0..rows).map(place).collect()
        };
        WearFrame {
            time: 0.1 * step as f64,
            step,
            wall: vec![1; rows as usize],
            vertex: (0..rows).collect(),
            first: places(1.0),
            displacement: places(1e-6),
            depth: vec![1.0 / 3.0; rows as usize],
            owed: vec![1e-15; rows as usize],
        }
    }

    #[test]
    fn worn_vertices_read_back_exactly_and_without_rows_too() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.wear.arrow");
        let header = FramesHeader::default();
        let mut writer = WearWriter::create(&path, &header, &()).unwrap();
        for (step, rows) in [(1, 0), (2, 3)] {
            writer.append(frame(step, rows)).unwrap();
        }
        drop(writer);
        let reader = WearReader::open(&path).unwrap();
        assert_eq!(reader.frame(0).unwrap(), frame(1, 0));
        assert_eq!(reader.frame(1).unwrap(), frame(2, 3));
        let triangles = WearTriangleFrame {
            time: 0.5,
            step: 4,
            wall: vec![1, 1],
            triangle: vec![3, 8],
            owed: vec![1e-12, 0.0],
            removed: vec![0.5e-12, 0.5e-12],
        };
        let path = folder.path().join("run.wear_triangles.arrow");
        let mut writer = WearTriangleWriter::create(&path, &header, &()).unwrap();
        writer.append(triangles.clone()).unwrap();
        drop(writer);
        let reader = WearTriangleReader::open(&path).unwrap();
        assert_eq!(reader.frame(0).unwrap(), triangles);
    }

    #[test]
    fn a_mesh_is_worn_where_its_vertices_are_named() {
        let frame = WearFrame {
            wall: vec![0, 1],
            vertex: vec![0, 2],
            first: vec![DVec3::ZERO, DVec3::Y],
            displacement: vec![DVec3::X, -1e-3 * DVec3::Z],
            depth: vec![5.0, 1e-3],
            owed: vec![0.0; 2],
            ..WearFrame::default()
        };
        // Minus 0 is the same place as 0.
        let corners = [DVec3::new(-0.0, 0.0, 0.0), DVec3::X, DVec3::Y];
        let mesh = TriangleMesh::from_corners(&[corners]);
        let (worn, depths) = frame.worn(1, &mesh);
        assert_eq!(
            worn.vertices,
            [DVec3::ZERO, DVec3::X, DVec3::new(0.0, 1.0, -1e-3)]
        );
        assert_eq!(depths, [0.0, 0.0, 1e-3]);
        let surfaces = frame.worn_surfaces(&[Surface::Mesh(mesh.clone()), Surface::Mesh(mesh)]);
        assert_eq!(surfaces[1], Surface::Mesh(worn));
    }
}
