//! The table of loads on the triangles of mesh walls: one row per triangle that was touched since the frame before.

use glam::DVec3;

use super::{ColumnVisitor, Table, TableReader, TableWriter};

/// Loads on triangles, means over the steps since the frame before; all lists have one entry per row.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TriangleLoadFrame {
    /// Time, in s.
    pub time: f64,
    /// Number of time steps made.
    pub step: u64,
    /// Index of the wall.
    pub wall: Vec<u32>,
    /// Index of the triangle among those of its wall in `.surfaces.arrow`.
    pub triangle: Vec<u32>,
    /// Normal force over area, positive where particles press, in Pa.
    pub pressure: Vec<f64>,
    /// Tangential force of the particles on the triangle over its area, in Pa.
    pub shear: Vec<DVec3>,
    /// Force of the particles on the triangle, in N.
    pub force: Vec<DVec3>,
    /// Power that sliding dissipates over area, in W/m^2.
    pub slip_power: Vec<f64>,
}

impl Table for TriangleLoadFrame {
    const KIND: &'static str = "triangle_loads";
    type Layout = ();

    fn moment(&mut self) -> (&mut f64, &mut u64) {
        (&mut self.time, &mut self.step)
    }

    fn columns(&mut self, (): &(), visitor: &mut impl ColumnVisitor) {
        let triangle = "index among the triangles of the wall in .surfaces.arrow";
        let pressure = "mean normal force over area since the frame before";
        let shear = "mean tangential force of the particles over area since the frame before";
        let force = "mean force of the particles since the frame before";
        let slip = "mean power dissipated by sliding over area since the frame before";
        visitor.column(&mut self.wall, &["wall"], "1", "index of the wall");
        visitor.column(&mut self.triangle, &["triangle"], "1", triangle);
        visitor.column(&mut self.pressure, &["pressure"], "Pa", pressure);
        let names = ["shear_x", "shear_y", "shear_z"];
        visitor.column(&mut self.shear, &names, "Pa", shear);
        visitor.column(&mut self.force, &["fx", "fy", "fz"], "N", force);
        visitor.column(&mut self.slip_power, &["slip_power"], "W/m^2", slip);
    }
}

/// Writes `<prefix>.triangle_loads.arrow`.
pub type TriangleLoadWriter = TableWriter<TriangleLoadFrame>;

/// Reads `<prefix>.triangle_loads.arrow`.
pub type TriangleLoadReader = TableReader<TriangleLoadFrame>;

#[cfg(test)]
mod tests {
    use super::super::{FrameSchema, FrameWriter, FramesHeader};
    use super::*;

    fn frame(step: u64, rows: u32) -> TriangleLoadFrame {
        let vectors = |scale: f64| {
            let vector = |k: u32| DVec3::new(0.1, 0.2, -0.3) * (scale + f64::from(k));
            (0..rows).map(vector).collect()
        };
        TriangleLoadFrame {
            time: 0.1 * step as f64,
            step,
            wall: vec![2; rows as usize],
            triangle: (0..rows).map(|k| 3 * k).collect(),
            pressure: (0..rows).map(|k| 1e5 / f64::from(k + 3)).collect(),
            shear: vectors(1e3),
            force: vectors(0.0),
            slip_power: vec![1.0 / 3.0; rows as usize],
        }
    }

    #[test]
    fn loads_read_back_exactly_and_without_rows_too() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.triangle_loads.arrow");
        let header = FramesHeader {
            walls: vec!["plate".to_owned()],
            ..FramesHeader::default()
        };
        let mut writer = TriangleLoadWriter::create(&path, &header, &()).unwrap();
        writer.append(frame(1, 3)).unwrap();
        writer.append(frame(2, 0)).unwrap();
        writer.append(frame(3, 1)).unwrap();
        drop(writer);
        let mut writer = TriangleLoadWriter::resume(&path, &header, &(), 2).unwrap();
        writer.append(frame(4, 7)).unwrap();
        assert_eq!(writer.frames().len(), 3);
        let reader = TriangleLoadReader::open(&path).unwrap();
        assert_eq!(reader.header().walls, header.walls);
        assert_eq!(reader.frames().len(), 3);
        for (k, expected) in [frame(1, 3), frame(2, 0), frame(4, 7)]
            .into_iter()
            .enumerate()
        {
            assert_eq!(reader.frame(k).unwrap(), expected);
        }
    }

    #[test]
    fn lists_of_different_length_and_other_tables_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.triangle_loads.arrow");
        let mut writer = TriangleLoadWriter::create(&path, &FramesHeader::default(), &()).unwrap();
        let mut wrong = frame(1, 3);
        wrong.pressure.pop();
        assert!(writer.append(wrong).is_err());
        drop(writer);
        let schema = FrameSchema::new("walls", TriangleLoadFrame::specs(&())).unwrap();
        FrameWriter::create(&path, schema).unwrap();
        let error = TriangleLoadReader::open(&path).unwrap_err();
        assert_eq!(error.found, "frames of walls");
        assert_eq!(error.expected, "frames of triangle_loads");
    }
}
