//! The tables of elastic sheets: one row per vertex, and one per triangle.

use glam::DVec3;

use super::{ColumnVisitor, Table, TableReader, TableWriter};
use crate::formats::mesh::TriangleMesh;

/// Bit of [`MembraneFrame::state`]: the vertex is held in a component at least.
pub const VERTEX_HELD: u32 = 1;

/// Vertices of sheets; all lists have one entry per row.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MembraneFrame {
    /// Time, in s.
    pub time: f64,
    /// Number of time steps made.
    pub step: u64,
    /// Index of the sheet, in the order of the scene.
    pub membrane: Vec<u32>,
    /// Number of the vertex in its sheet.
    pub vertex: Vec<u32>,
    /// Bits: [`VERTEX_HELD`].
    pub state: Vec<u32>,
    /// Mass, in kg.
    pub mass: Vec<f64>,
    /// Position, in m.
    pub position: Vec<DVec3>,
    /// Velocity, in m/s.
    pub velocity: Vec<DVec3>,
    /// All forces but that of a hold, in N.
    pub force: Vec<DVec3>,
}

impl Table for MembraneFrame {
    const KIND: &'static str = "membranes";
    type Layout = ();

    fn moment(&mut self) -> (&mut f64, &mut u64) {
        (&mut self.time, &mut self.step)
    }

    fn columns(&mut self, (): &(), visitor: &mut impl ColumnVisitor) {
        let membrane = "index of the sheet, in the order of the scene";
        let vertex = "number of the vertex in its sheet";
        let state = "bit 0: held in a component at least";
        let force = "all forces but that of a hold";
        visitor.column(&mut self.membrane, &["membrane"], "1", membrane);
        visitor.column(&mut self.vertex, &["vertex"], "1", vertex);
        visitor.column(&mut self.state, &["state"], "1", state);
        visitor.column(&mut self.mass, &["mass"], "kg", "mass");
        visitor.column(&mut self.position, &["x", "y", "z"], "m", "position");
        let names = ["vx", "vy", "vz"];
        visitor.column(&mut self.velocity, &names, "m/s", "velocity");
        visitor.column(&mut self.force, &["fx", "fy", "fz"], "N", force);
    }

    fn check(&self, (): &()) -> Result<(), String> {
        let mut rows = self.position.iter();
        match rows.position(|place| !place.is_finite()) {
            Some(row) => Err(format!("row {row}: a position that is not finite")),
            None => Ok(()),
        }
    }
}

/// Triangles of sheets; all lists have one entry per row.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MembraneTriangleFrame {
    /// Time, in s.
    pub time: f64,
    /// Number of time steps made.
    pub step: u64,
    /// Index of the sheet, in the order of the scene.
    pub membrane: Vec<u32>,
    /// Number of the triangle in its sheet.
    pub triangle: Vec<u32>,
    /// Numbers of its vertices.
    pub corners: [Vec<u32>; 3],
    /// Area, in m^2.
    pub area: Vec<f64>,
    /// Principal tensions, larger first, in N/m.
    pub tensions: [Vec<f64>; 2],
    /// Force of the grains on it, in N.
    pub load: Vec<DVec3>,
}

impl Table for MembraneTriangleFrame {
    const KIND: &'static str = "membrane_triangles";
    type Layout = ();

    fn moment(&mut self) -> (&mut f64, &mut u64) {
        (&mut self.time, &mut self.step)
    }

    fn columns(&mut self, (): &(), visitor: &mut impl ColumnVisitor) {
        let membrane = "index of the sheet, in the order of the scene";
        let triangle = "number of the triangle in its sheet";
        visitor.column(&mut self.membrane, &["membrane"], "1", membrane);
        visitor.column(&mut self.triangle, &["triangle"], "1", triangle);
        for (list, name) in self.corners.iter_mut().zip(["a", "b", "c"]) {
            visitor.column(list, &[name], "1", "number of a vertex");
        }
        visitor.column(&mut self.area, &["area"], "m^2", "area");
        let tensions = [("tension_1", "larger"), ("tension_2", "smaller")];
        for (list, (name, which)) in self.tensions.iter_mut().zip(tensions) {
            let words = format!("the {which} principal tension, Cauchy stress times thickness");
            visitor.column(list, &[name], "N/m", &words);
        }
        let load = "force of the grains on it";
        visitor.column(&mut self.load, &["gx", "gy", "gz"], "N", load);
    }
}

/// A sheet at one time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SheetNow {
    /// Vertices and triangles, m.
    pub mesh: TriangleMesh,
    /// Row of each vertex in the [`MembraneFrame`].
    pub vertex_rows: Vec<usize>,
    /// Row of each triangle in the [`MembraneTriangleFrame`].
    pub triangle_rows: Vec<usize>,
}

/// The sheets of two frames of the same time, in the order of the scene.
///
/// # Errors
/// If a triangle has a vertex without a row.
pub fn sheets(
    vertices: &MembraneFrame,
    triangles: &MembraneTriangleFrame,
) -> Result<Vec<SheetNow>, String> {
    let mut sheets: Vec<SheetNow> = Vec::new();
    for (row, &sheet) in vertices.membrane.iter().enumerate() {
        // Rows stand in the order of the sheets, so that a file cannot claim more of them than it has rows.
        let index = sheet as usize;
        if index > sheets.len() || index + 1 < sheets.len() {
            return Err(format!("row {row}: membrane {sheet} is out of order"));
        }
        if index == sheets.len() {
            sheets.push(SheetNow::default());
        }
        let sheet = &mut sheets[index];
        if vertices.vertex[row] as usize != sheet.vertex_rows.len() {
            let vertex = vertices.vertex[row];
            return Err(format!("row {row}: vertex {vertex} is out of order"));
        }
        sheet.mesh.vertices.push(vertices.position[row]);
        sheet.vertex_rows.push(row);
    }
    for (row, &index) in triangles.membrane.iter().enumerate() {
        let corners = [0, 1, 2].map(|k| triangles.corners[k][row]);
        let sheet = sheets.get_mut(index as usize).filter(|sheet| {
            let count = sheet.mesh.vertices.len();
            corners.iter().all(|&corner| (corner as usize) < count)
        });
        let Some(sheet) = sheet else {
            return Err(format!(
                "row {row}: membrane {index} has no vertices {corners:?}"
            ));
        };
        sheet.mesh.triangles.push(corners);
        sheet.triangle_rows.push(row);
    }
    Ok(sheets)
}

/// Writes `<prefix>.membranes.arrow`.
pub type MembraneWriter = TableWriter<MembraneFrame>;

/// Reads `<prefix>.membranes.arrow`.
pub type MembraneReader = TableReader<MembraneFrame>;

/// Writes `<prefix>.membrane_triangles.arrow`.
pub type MembraneTriangleWriter = TableWriter<MembraneTriangleFrame>;

/// Reads `<prefix>.membrane_triangles.arrow`.
pub type MembraneTriangleReader = TableReader<MembraneTriangleFrame>;

#[cfg(test)]
mod tests {
    use super::super::FramesHeader;
    use super::*;

    fn frames() -> (MembraneFrame, MembraneTriangleFrame) {
        let vertices = MembraneFrame {
            time: 0.5,
            step: 4,
            membrane: vec![0, 0, 0, 1, 1, 1],
            vertex: vec![0, 1, 2, 0, 1, 2],
            state: vec![VERTEX_HELD, 0, 0, 0, 0, 0],
            mass: vec![1.0 / 3.0; 6],
            position: vec![
                DVec3::ZERO,
                DVec3::X,
                DVec3::Y,
                DVec3::Z,
                DVec3::X,
                DVec3::Y,
            ],
            velocity: vec![DVec3::ONE; 6],
            force: vec![DVec3::NEG_ONE; 6],
        };
        let triangles = MembraneTriangleFrame {
            time: 0.5,
            step: 4,
            membrane: vec![0, 1],
            triangle: vec![0, 0],
            corners: [vec![0, 0], vec![1, 1], vec![2, 2]],
            area: vec![0.5, 1.0],
            tensions: [vec![2.0, 3.0], vec![1.0, -1.0]],
            load: vec![DVec3::ZERO, DVec3::Z],
        };
        (vertices, triangles)
    }

    #[test]
    fn sheets_read_back_exactly() {
        let folder = tempfile::tempdir().unwrap();
        let (vertices, triangles) = frames();
        let path = folder.path().join("run.membranes.arrow");
        let header = FramesHeader::default();
        let mut writer = MembraneWriter::create(&path, &header, &()).unwrap();
        writer.append(vertices.clone()).unwrap();
        drop(writer);
        let reader = MembraneReader::open(&path).unwrap();
        assert_eq!(reader.frame(0).unwrap(), vertices);
        let path = folder.path().join("run.membrane_triangles.arrow");
        let mut writer = MembraneTriangleWriter::create(&path, &header, &()).unwrap();
        writer.append(triangles.clone()).unwrap();
        drop(writer);
        let reader = MembraneTriangleReader::open(&path).unwrap();
        assert_eq!(reader.frame(0).unwrap(), triangles);
    }

    #[test]
    fn meshes_of_both_frames() {
        let (mut vertices, mut triangles) = frames();
        let both = sheets(&vertices, &triangles).unwrap();
        assert_eq!(both.len(), 2);
        assert_eq!(both[1].mesh.vertices[0], DVec3::Z);
        assert_eq!(both[1].vertex_rows, [3, 4, 5]);
        assert_eq!(both[1].triangle_rows, [1]);
        triangles.corners[2][1] = 3;
        assert!(sheets(&vertices, &triangles).is_err());
        triangles.corners[2][1] = 2;
        vertices.membrane[5] = 7;
        assert!(sheets(&vertices, &triangles).is_err());
        vertices.membrane[5] = 1;
        vertices.vertex[5] = 9;
        assert!(sheets(&vertices, &triangles).is_err());
    }
}
