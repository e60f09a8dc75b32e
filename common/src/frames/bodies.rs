//! The table of rigid bodies: one row per body; what its kind looks like stands in a file beside it.

use std::path::{Path, PathBuf};

use glam::{DQuat, DVec3};

use super::clump_surfaces::{self, ClumpKind};
use super::table::{
    Taker, components, index, number, open_table, require, split_quaternions, split_vectors,
};
use super::{
    Column, ColumnKind, ColumnSpec, Frame, FrameReader, FrameSchema, FrameWriteError, FrameWriter,
    FramesHeader,
};
use crate::error::FormatError;

const KIND: &str = "bodies";
const POSITION: [&str; 3] = ["x", "y", "z"];
const VELOCITY: [&str; 3] = ["vx", "vy", "vz"];
const ORIENTATION: [&str; 4] = ["qw", "qx", "qy", "qz"];
const ANGULAR_VELOCITY: [&str; 3] = ["wx", "wy", "wz"];
const MOMENTS: [&str; 3] = ["ix", "iy", "iz"];
const FORCE: [&str; 3] = ["fx", "fy", "fz"];
const TORQUE: [&str; 3] = ["tx", "ty", "tz"];

/// The rigid bodies at one instant; all lists have one entry per body.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BodyFrame {
    /// Time, in s.
    pub time: f64,
    /// Number of time steps made.
    pub step: u64,
    /// The number that names the body, the column `body` of its pebbles among the particles.
    pub id: Vec<u32>,
    /// Index of its clump, see [`BodyReader::kinds`].
    pub clump: Vec<u32>,
    /// Index of the material of its surface, see [`FramesHeader::materials`].
    pub material: Vec<u32>,
    /// Bits: [`FLAG_FIXED`](super::FLAG_FIXED), [`FLAG_PRESCRIBED`](super::FLAG_PRESCRIBED).
    pub flags: Vec<u8>,
    /// Mass, in kg.
    pub mass: Vec<f64>,
    /// Volume, in m^3.
    pub volume: Vec<f64>,
    /// Size, relative to the clump's file.
    pub scale: Vec<f64>,
    /// Radius of the smallest sphere about the centre of mass that holds all pebbles, in m.
    pub radius: Vec<f64>,
    /// Centre of mass, in m.
    pub position: Vec<DVec3>,
    /// Velocity of the centre of mass, in m/s.
    pub velocity: Vec<DVec3>,
    /// Rotation from the principal frame to the global frame, as unit quaternion.
    pub orientation: Vec<DQuat>,
    /// Angular velocity in the global frame, in rad/s.
    pub angular_velocity: Vec<DVec3>,
    /// Moments of inertia about the axes of the principal frame, in kg m^2.
    pub principal_moments: Vec<DVec3>,
    /// What contacts do to the body: force, in N.
    pub force: Vec<DVec3>,
    /// What contacts do to the body: torque about the centre of mass, in N m.
    pub torque: Vec<DVec3>,
}

impl BodyFrame {
    /// The columns of the file in their order, without `time`.
    #[must_use]
    pub fn specs() -> Vec<ColumnSpec> {
        let flags = "bit 0: fixed, bit 1: prescribed motion";
        let id = "number of the body, as in the column `body` of particles";
        let radius = "radius of the smallest sphere about the centre that holds the pebbles";
        let mut specs = vec![
            index("id", ColumnKind::U32, id),
            index("clump", ColumnKind::U32, "index of the clump"),
            index("material", ColumnKind::U32, "index of the material"),
            index("flags", ColumnKind::U8, flags),
            number("mass", "kg", "mass"),
            number("volume", "m^3", "volume"),
            number("scale", "1", "size relative to the clump's file"),
            number("radius", "m", radius),
        ];
        let orientation = "unit quaternion, principal frame to global frame";
        let angular_velocity = "angular velocity, global frame";
        let moments = "moment of inertia about an axis of the principal frame";
        let torque = "torque of the contacts about the centre of mass";
        specs.extend(components(POSITION, "m", "centre of mass"));
        specs.extend(components(VELOCITY, "m/s", "velocity of the centre"));
        specs.extend(components(ORIENTATION, "1", orientation));
        specs.extend(components(ANGULAR_VELOCITY, "rad/s", angular_velocity));
        specs.extend(components(MOMENTS, "kg m^2", moments));
        specs.extend(components(FORCE, "N", "force of the contacts"));
        specs.extend(components(TORQUE, "N m", torque));
        specs
    }

    /// The number of bodies.
    #[must_use]
    pub fn len(&self) -> usize {
        self.id.len()
    }

    /// Whether there are no bodies.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.id.is_empty()
    }

    /// The frame as flat columns in the order of [`BodyFrame::specs`].
    #[must_use]
    pub fn into_frame(self) -> Frame {
        let mut columns: Vec<Column> = [self.id, self.clump, self.material]
            .map(Column::U32)
            .into_iter()
            .collect();
        columns.push(Column::U8(self.flags));
        columns.extend([self.mass, self.volume, self.scale, self.radius].map(Column::F64));
        columns.extend(split_vectors(&self.position));
        columns.extend(split_vectors(&self.velocity));
        columns.extend(split_quaternions(&self.orientation));
        for vectors in [
            &self.angular_velocity,
            &self.principal_moments,
            &self.force,
            &self.torque,
        ] {
            columns.extend(split_vectors(vectors));
        }
        Frame {
            time: self.time,
            step: self.step,
            columns,
        }
    }

    fn of(frame: Frame, schema: &FrameSchema) -> Result<Self, String> {
        let (time, step) = (frame.time, frame.step);
        let mut take = Taker::new(schema, frame);
        Ok(Self {
            time,
            step,
            id: take.u32("id")?,
            clump: take.u32("clump")?,
            material: take.u32("material")?,
            flags: take.u8("flags")?,
            mass: take.f64("mass")?,
            volume: take.f64("volume")?,
            scale: take.f64("scale")?,
            radius: take.f64("radius")?,
            position: take.vectors(POSITION)?,
            velocity: take.vectors(VELOCITY)?,
            orientation: take.quaternions(ORIENTATION)?,
            angular_velocity: take.vectors(ANGULAR_VELOCITY)?,
            principal_moments: take.vectors(MOMENTS)?,
            force: take.vectors(FORCE)?,
            torque: take.vectors(TORQUE)?,
        })
    }
}

fn schema(header: &FramesHeader, kinds: &[ClumpKind]) -> Result<FrameSchema, super::SchemaError> {
    let mut entries = header.entries();
    entries.extend(clump_surfaces::entries(kinds));
    Ok(FrameSchema::new(KIND, BodyFrame::specs())?.with_metadata(entries))
}

/// Writes `<prefix>.bodies.arrow`, and `<prefix>.clumps.arrow` if a kind of clump has a surface of its own.
#[derive(Debug)]
pub struct BodyWriter {
    frames: FrameWriter,
}

impl BodyWriter {
    /// Creates a file without frames for bodies of these kinds; a file of that name is replaced. The triangles of
    /// surfaces are written at once.
    ///
    /// # Errors
    /// When a file cannot be made.
    pub fn create(
        path: impl Into<PathBuf>,
        header: &FramesHeader,
        kinds: &[ClumpKind],
    ) -> Result<Self, FrameWriteError> {
        let path = path.into();
        clump_surfaces::write(&path, header, kinds)?;
        let frames = FrameWriter::create(path, schema(header, kinds)?)?;
        Ok(Self { frames })
    }

    /// Continues a file behind its first `frames` frames, see [`FrameWriter::resume`].
    ///
    /// # Errors
    /// When the file has fewer frames, another header or other kinds, or cannot be written.
    pub fn resume(
        path: impl Into<PathBuf>,
        header: &FramesHeader,
        kinds: &[ClumpKind],
        frames: usize,
    ) -> Result<Self, FrameWriteError> {
        let frames = FrameWriter::resume(path, schema(header, kinds)?, frames)?;
        Ok(Self { frames })
    }

    /// Appends a frame.
    ///
    /// # Errors
    /// When its lists differ in length, or the file cannot be written; the frames before stay as they are.
    pub fn append(&mut self, frame: BodyFrame) -> Result<(), FrameWriteError> {
        self.frames.append(&frame.into_frame())
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

/// Reads `<prefix>.bodies.arrow`, and `<prefix>.clumps.arrow` if a kind of clump has a surface of its own.
#[derive(Debug)]
pub struct BodyReader {
    frames: FrameReader,
    header: FramesHeader,
    kinds: Vec<ClumpKind>,
}

impl BodyReader {
    /// Opens a file of bodies.
    ///
    /// # Errors
    /// When the file (or that of the surfaces) cannot be opened, is no stream of frames, lacks columns, or the surfaces are
    /// not those that it speaks of.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, FormatError> {
        let mut reader = Self::open_without_surfaces(path.as_ref())?;
        reader.kinds = clump_surfaces::read(path.as_ref(), reader.frames.schema())?;
        Ok(reader)
    }

    /// Opens a file of bodies alone: its kinds have names and no surfaces.
    ///
    /// # Errors
    /// When the file cannot be opened, is no stream of frames, or lacks columns.
    pub fn open_without_surfaces(path: impl AsRef<Path>) -> Result<Self, FormatError> {
        let check = |schema: &FrameSchema| require(schema, &BodyFrame::specs());
        let (frames, header, ()) = open_table(path.as_ref(), KIND, check)?;
        let kinds = clump_surfaces::names(frames.schema());
        Ok(Self {
            frames,
            header,
            kinds,
        })
    }

    /// What the file says about its run.
    pub fn header(&self) -> &FramesHeader {
        &self.header
    }

    /// The clumps in the order of their indices.
    pub fn kinds(&self) -> &[ClumpKind] {
        &self.kinds
    }

    /// The file itself: number of frames, times, damage.
    pub fn frames(&self) -> &FrameReader {
        &self.frames
    }

    /// Frame `k`, counted from 0.
    ///
    /// # Errors
    /// When there is no such frame, its bytes are damaged, or it speaks of a clump that the file does not name.
    pub fn frame(&self, k: usize) -> Result<BodyFrame, FormatError> {
        let frame = self.frames.frame(k)?;
        self.bodies(frame).map_err(|found| {
            FormatError::of_file(self.frames.path(), format!("frame {k}: {found}"))
        })
    }

    /// The bodies of a frame of this file, of which rows may have been left out.
    ///
    /// # Errors
    /// When the columns are others, or a body is of a clump that the file does not name.
    pub fn bodies(&self, frame: Frame) -> Result<BodyFrame, String> {
        let frame = BodyFrame::of(frame, self.frames.schema())?;
        let known = self.kinds.len();
        match frame.clump.iter().find(|&&clump| clump as usize >= known) {
            Some(clump) => Err(format!("a body of clump {clump}; the file names {known}")),
            None => Ok(frame),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::formats::mesh::TriangleMesh;

    fn kinds() -> Vec<ClumpKind> {
        let a = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let b = [DVec3::X, DVec3::splat(0.1), DVec3::Y];
        vec![
            ClumpKind {
                name: "bean".to_owned(),
                surface: None,
            },
            ClumpKind {
                name: "stone".to_owned(),
                surface: Some(TriangleMesh::from_corners(&[a, b])),
            },
        ]
    }

    fn header() -> FramesHeader {
        FramesHeader {
            title: "grains".to_owned(),
            materials: vec!["rock".to_owned()],
            ..FramesHeader::default()
        }
    }

    /// `rows` bodies whose numbers are all different and not exact in decimals.
    fn frame(step: u64, rows: u32, seed: f64) -> BodyFrame {
        let number = |k: u32, column: u32| seed + f64::from(k) / 3.0 + f64::from(column) / 7.0;
        let numbers = |column| (0..rows).map(|k| number(k, column)).collect();
        let vectors = |column| -> Vec<DVec3> {
            let vector = |k| {
                DVec3::new(
                    number(k, column),
                    -number(k, column + 1),
                    number(k, column + 2),
                )
            };
            (0..rows).map(vector).collect()
        };
        BodyFrame {
            time: 0.1 * step as f64,
            step,
            id: (0..rows).map(|k| 3 * k).collect(),
            clump: (0..rows).map(|k| k % 2).collect(),
            material: vec![0; rows as usize],
            flags: (0..rows).map(|k| (k % 4) as u8).collect(),
            mass: numbers(0),
            volume: numbers(1),
            scale: numbers(2),
            radius: numbers(3),
            position: vectors(4),
            velocity: vectors(7),
            orientation: vectors(10)
                .iter()
                .map(|&turn| DQuat::from_scaled_axis(turn))
                .collect(),
            angular_velocity: vectors(13),
            principal_moments: vectors(16),
            force: vectors(19),
            torque: vectors(22),
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]
        #[test]
        fn bodies_read_back_exactly(rows in prop::collection::vec(0..5u32, 1..4), seed in -1e3..1e3f64) {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("run.bodies.arrow");
            let written: Vec<BodyFrame> = rows
                .iter()
                .zip(1..)
                .map(|(&rows, step)| frame(step, rows, seed))
                .collect();
            let mut writer = BodyWriter::create(&path, &header(), &kinds()).unwrap();
            writer.append(written[0].clone()).unwrap();
            drop(writer);
            let mut writer = BodyWriter::resume(&path, &header(), &kinds(), 1).unwrap();
            for frame in &written[1..] {
                writer.append(frame.clone()).unwrap();
            }
            let reader = BodyReader::open(&path).unwrap();
            prop_assert_eq!(reader.kinds(), &kinds()[..]);
            prop_assert_eq!(&reader.header().materials, &header().materials);
            prop_assert_eq!(reader.frames().len(), written.len());
            for (k, expected) in written.iter().enumerate() {
                prop_assert_eq!(&reader.frame(k).unwrap(), expected);
            }
        }
    }

    #[test]
    fn bodies_without_surfaces_leave_one_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.bodies.arrow");
        BodyWriter::create(&path, &header(), &kinds()[..1]).unwrap();
        assert!(!folder.path().join("run.clumps.arrow").exists());
        assert_eq!(BodyReader::open(&path).unwrap().kinds(), &kinds()[..1]);
    }

    #[test]
    fn what_is_missing_or_of_another_run_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.bodies.arrow");
        let surfaces = folder.path().join("run.clumps.arrow");
        let mut writer = BodyWriter::create(&path, &header(), &kinds()).unwrap();
        let mut wrong = frame(1, 1, 0.0);
        wrong.clump = vec![2];
        writer.append(wrong).unwrap();
        let error = BodyReader::open(&path).unwrap().frame(0).unwrap_err();
        assert_eq!(error.found, "frame 0: a body of clump 2; the file names 2");

        std::fs::remove_file(&surfaces).unwrap();
        let error = BodyReader::open(&path).unwrap_err().to_string();
        let expected = "run.clumps.arrow: the file cannot be opened";
        assert!(error.contains(expected), "{error}");

        let other = folder.path().join("other.bodies.arrow");
        let mut larger = kinds();
        larger[1].surface = Some(TriangleMesh::from_corners(&[[
            DVec3::ZERO,
            DVec3::X,
            DVec3::Z,
        ]]));
        BodyWriter::create(&other, &header(), &larger).unwrap();
        std::fs::rename(folder.path().join("other.clumps.arrow"), &surfaces).unwrap();
        let error = BodyReader::open(&path).unwrap_err();
        assert_eq!(error.found, "1 triangles of clump 1");
        assert!(error.expected.starts_with("2, as "), "{}", error.expected);
    }
}
