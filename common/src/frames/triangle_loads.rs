//! The table of loads on the triangles of mesh walls: one row per triangle that was touched since the frame before.

use std::path::{Path, PathBuf};

use glam::DVec3;

use super::table::{Taker, components, index, number, open_table, require, split_vectors};
use super::{
    Column, ColumnKind, ColumnSpec, Frame, FrameReader, FrameSchema, FrameWriteError, FrameWriter,
    FramesHeader,
};
use crate::error::FormatError;

const KIND: &str = "triangle_loads";
const SHEAR: [&str; 3] = ["shear_x", "shear_y", "shear_z"];
const FORCE: [&str; 3] = ["fx", "fy", "fz"];

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

fn specs() -> Vec<ColumnSpec> {
    let mut specs = vec![
        index("wall", ColumnKind::U32, "index of the wall"),
        index(
            "triangle",
            ColumnKind::U32,
            "index among the triangles of the wall in .surfaces.arrow",
        ),
        number(
            "pressure",
            "Pa",
            "mean normal force over area since the frame before",
        ),
    ];
    let shear = "mean tangential force of the particles over area since the frame before";
    specs.extend(components(SHEAR, "Pa", shear));
    let force = "mean force of the particles since the frame before";
    specs.extend(components(FORCE, "N", force));
    let slip = "mean power dissipated by sliding over area since the frame before";
    specs.push(number("slip_power", "W/m^2", slip));
    specs
}

/// Writes `<prefix>.triangle_loads.arrow`.
#[derive(Debug)]
pub struct TriangleLoadWriter {
    frames: FrameWriter,
}

impl TriangleLoadWriter {
    /// Creates a file without frames; a file of that name is replaced.
    ///
    /// # Errors
    /// When the file cannot be made.
    pub fn create(
        path: impl Into<PathBuf>,
        header: &FramesHeader,
    ) -> Result<Self, FrameWriteError> {
        let frames = FrameWriter::create(path, schema(header)?)?;
        Ok(Self { frames })
    }

    /// Continues a file behind its first `frames` frames, see [`FrameWriter::resume`].
    ///
    /// # Errors
    /// When the file has fewer frames or other columns, or cannot be written.
    pub fn resume(
        path: impl Into<PathBuf>,
        header: &FramesHeader,
        frames: usize,
    ) -> Result<Self, FrameWriteError> {
        let frames = FrameWriter::resume(path, schema(header)?, frames)?;
        Ok(Self { frames })
    }

    /// Appends a frame.
    ///
    /// # Errors
    /// When its lists differ in length, or the file cannot be written; the frames before stay as they are.
    pub fn append(&mut self, frame: TriangleLoadFrame) -> Result<(), FrameWriteError> {
        let mut columns = vec![
            Column::U32(frame.wall),
            Column::U32(frame.triangle),
            Column::F64(frame.pressure),
        ];
        columns.extend(split_vectors(&frame.shear));
        columns.extend(split_vectors(&frame.force));
        columns.push(Column::F64(frame.slip_power));
        self.frames.append(&Frame {
            time: frame.time,
            step: frame.step,
            columns,
        })
    }

    /// The file itself: its length, [`FrameWriter::sync`].
    pub fn frames(&self) -> &FrameWriter {
        &self.frames
    }

    /// The file itself, to be cut back.
    pub fn frames_mut(&mut self) -> &mut FrameWriter {
        &mut self.frames
    }
}

fn schema(header: &FramesHeader) -> Result<FrameSchema, super::SchemaError> {
    Ok(FrameSchema::new(KIND, specs())?.with_metadata(header.entries()))
}

/// Reads `<prefix>.triangle_loads.arrow`.
#[derive(Debug)]
pub struct TriangleLoadReader {
    frames: FrameReader,
    header: FramesHeader,
}

impl TriangleLoadReader {
    /// Opens a file of loads on triangles.
    ///
    /// # Errors
    /// When it cannot be opened, is no stream of frames, or lacks columns.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, FormatError> {
        let check = |schema: &FrameSchema| require(schema, &specs());
        let (frames, header, ()) = open_table(path.as_ref(), KIND, check)?;
        Ok(Self { frames, header })
    }

    /// What the file says about its run.
    pub fn header(&self) -> &FramesHeader {
        &self.header
    }

    /// The file itself: number of frames, times, damage.
    pub fn frames(&self) -> &FrameReader {
        &self.frames
    }

    /// Frame `k`, counted from 0.
    ///
    /// # Errors
    /// When there is no such frame, or its bytes are damaged.
    pub fn frame(&self, k: usize) -> Result<TriangleLoadFrame, FormatError> {
        let frame = self.frames.frame(k)?;
        let read = |frame: Frame| {
            let (time, step) = (frame.time, frame.step);
            let mut take = Taker::new(self.frames.schema(), frame);
            Ok(TriangleLoadFrame {
                time,
                step,
                wall: take.u32("wall")?,
                triangle: take.u32("triangle")?,
                pressure: take.f64("pressure")?,
                shear: take.vectors(SHEAR)?,
                force: take.vectors(FORCE)?,
                slip_power: take.f64("slip_power")?,
            })
        };
        read(frame).map_err(|found: String| {
            FormatError::of_file(self.frames.path(), format!("frame {k}: {found}"))
        })
    }
}

#[cfg(test)]
mod tests {
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
        let mut writer = TriangleLoadWriter::create(&path, &header).unwrap();
        writer.append(frame(1, 3)).unwrap();
        writer.append(frame(2, 0)).unwrap();
        writer.append(frame(3, 1)).unwrap();
        drop(writer);
        let mut writer = TriangleLoadWriter::resume(&path, &header, 2).unwrap();
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
        let mut writer = TriangleLoadWriter::create(&path, &FramesHeader::default()).unwrap();
        let mut wrong = frame(1, 3);
        wrong.pressure.pop();
        assert!(writer.append(wrong).is_err());
        drop(writer);
        let schema = FrameSchema::new("walls", specs()).unwrap();
        FrameWriter::create(&path, schema).unwrap();
        let error = TriangleLoadReader::open(&path).unwrap_err();
        assert_eq!(error.found, "frames of walls");
        assert_eq!(error.expected, "frames of triangle_loads");
    }
}
