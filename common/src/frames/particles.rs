//! The table of particles: one row per sphere.

use std::path::{Path, PathBuf};

use glam::{DQuat, DVec3};

use super::table::{
    Taker, components, index, number, open_table, require, split_quaternions, split_vectors,
};
use super::{
    Column, ColumnKind, ColumnSpec, Frame, FrameReader, FrameSchema, FrameWriteError, FrameWriter,
    FramesHeader,
};
use crate::error::FormatError;

/// Bit of [`ParticleFrame::flags`]: the particle does not move.
pub const FLAG_FIXED: u8 = 1;
/// Bit of [`ParticleFrame::flags`]: the motion of the particle is prescribed.
pub const FLAG_PRESCRIBED: u8 = 2;

const KIND: &str = "particles";
const POSITION: [&str; 3] = ["x", "y", "z"];
const VELOCITY: [&str; 3] = ["vx", "vy", "vz"];
const ORIENTATION: [&str; 4] = ["qw", "qx", "qy", "qz"];
const ANGULAR_VELOCITY: [&str; 3] = ["wx", "wy", "wz"];
const FORCE: [&str; 3] = ["fx", "fy", "fz"];
const TORQUE: [&str; 3] = ["tx", "ty", "tz"];

/// Which optional columns a file of particles has; fixed for the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ParticleColumns {
    /// The body that a sphere belongs to.
    pub body: bool,
    /// Orientation as unit quaternion.
    pub orientation: bool,
    /// Angular velocity.
    pub angular_velocity: bool,
    /// Force on the particle.
    pub force: bool,
    /// Torque on the particle.
    pub torque: bool,
    /// Volume of the liquid film.
    pub film_volume: bool,
}

/// The particles at one instant; all lists have one entry per particle.
///
/// An optional list is there when the file's [`ParticleColumns`] say so.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ParticleFrame {
    /// Time, in s.
    pub time: f64,
    /// Number of time steps made.
    pub step: u64,
    /// The number that names the particle, the same for all its life.
    pub id: Vec<u32>,
    /// Index of the material, see [`FramesHeader::materials`].
    pub material: Vec<u32>,
    /// Bits: [`FLAG_FIXED`], [`FLAG_PRESCRIBED`].
    pub flags: Vec<u8>,
    /// Mass, in kg.
    pub mass: Vec<f64>,
    /// Volume, in m^3.
    pub volume: Vec<f64>,
    /// Radius, in m.
    pub radius: Vec<f64>,
    /// Position of the centre, in m.
    pub position: Vec<DVec3>,
    /// Velocity of the centre, in m/s.
    pub velocity: Vec<DVec3>,
    /// The body that the sphere is a part of, if it is of one.
    pub body: Option<Vec<Option<u32>>>,
    /// Rotation from the body frame to the global frame, as unit quaternion.
    pub orientation: Option<Vec<DQuat>>,
    /// Angular velocity in the global frame, in rad/s.
    pub angular_velocity: Option<Vec<DVec3>>,
    /// Force on the particle, in N.
    pub force: Option<Vec<DVec3>>,
    /// Torque on the particle about its centre, in N m.
    pub torque: Option<Vec<DVec3>>,
    /// Volume of the liquid film, in m^3.
    pub film_volume: Option<Vec<f64>>,
}

impl ParticleColumns {
    /// The columns of the file in their order, without `time`.
    pub fn specs(&self) -> Vec<ColumnSpec> {
        let mut specs = vec![
            index(
                "id",
                ColumnKind::U32,
                "number of the particle, for all its life",
            ),
            index("material", ColumnKind::U32, "index of the material"),
        ];
        if self.body {
            let body = "body that the sphere is a part of, null if of none";
            specs.push(index("body", ColumnKind::OptionalU32, body));
        }
        specs.push(index(
            "flags",
            ColumnKind::U8,
            "bit 0: fixed, bit 1: prescribed motion",
        ));
        specs.push(number("mass", "kg", "mass"));
        specs.push(number("volume", "m^3", "volume"));
        specs.push(number("radius", "m", "radius"));
        specs.extend(components(POSITION, "m", "position of the centre"));
        specs.extend(components(VELOCITY, "m/s", "velocity of the centre"));
        if self.orientation {
            let orientation = "unit quaternion, body frame to global frame";
            specs.extend(components(ORIENTATION, "1", orientation));
        }
        if self.angular_velocity {
            let angular_velocity = "angular velocity, global frame";
            specs.extend(components(ANGULAR_VELOCITY, "rad/s", angular_velocity));
        }
        if self.force {
            specs.extend(components(FORCE, "N", "force on the particle"));
        }
        if self.torque {
            specs.extend(components(TORQUE, "N m", "torque about the centre"));
        }
        if self.film_volume {
            specs.push(number("film_volume", "m^3", "volume of the liquid film"));
        }
        specs
    }

    /// The schema of the file.
    ///
    /// # Errors
    /// None for the columns of this table; the type is that of [`FrameSchema::new`].
    pub fn schema(&self, header: &FramesHeader) -> Result<FrameSchema, super::SchemaError> {
        Ok(FrameSchema::new(KIND, self.specs())?.with_metadata(header.entries()))
    }

    fn of(schema: &FrameSchema) -> Result<Self, String> {
        let has = |name: &str| schema.index_of(name).is_some();
        let columns = Self {
            body: has("body"),
            orientation: has(ORIENTATION[0]),
            angular_velocity: has(ANGULAR_VELOCITY[0]),
            force: has(FORCE[0]),
            torque: has(TORQUE[0]),
            film_volume: has("film_volume"),
        };
        require(schema, &columns.specs())?;
        Ok(columns)
    }
}

impl ParticleFrame {
    /// The number of particles.
    pub fn len(&self) -> usize {
        self.id.len()
    }

    /// Whether there are no particles.
    pub fn is_empty(&self) -> bool {
        self.id.is_empty()
    }

    /// Which optional lists are there.
    pub fn columns(&self) -> ParticleColumns {
        ParticleColumns {
            body: self.body.is_some(),
            orientation: self.orientation.is_some(),
            angular_velocity: self.angular_velocity.is_some(),
            force: self.force.is_some(),
            torque: self.torque.is_some(),
            film_volume: self.film_volume.is_some(),
        }
    }

    /// The frame as flat columns in the order of [`ParticleColumns::specs`].
    pub fn into_frame(self) -> Frame {
        let mut columns = vec![Column::U32(self.id), Column::U32(self.material)];
        columns.extend(self.body.map(Column::OptionalU32));
        columns.push(Column::U8(self.flags));
        columns.extend([self.mass, self.volume, self.radius].map(Column::F64));
        columns.extend(split_vectors(&self.position));
        columns.extend(split_vectors(&self.velocity));
        columns.extend(self.orientation.iter().flat_map(|q| split_quaternions(q)));
        for vectors in [&self.angular_velocity, &self.force, &self.torque] {
            columns.extend(vectors.iter().flat_map(|v| split_vectors(v)));
        }
        columns.extend(self.film_volume.map(Column::F64));
        Frame {
            time: self.time,
            step: self.step,
            columns,
        }
    }

    fn of(frame: Frame, schema: &FrameSchema, columns: ParticleColumns) -> Result<Self, String> {
        let (time, step) = (frame.time, frame.step);
        let mut take = Taker::new(schema, frame);
        let mut vectors = |planned: bool, names| planned.then(|| take.vectors(names)).transpose();
        let angular_velocity = vectors(columns.angular_velocity, ANGULAR_VELOCITY)?;
        let force = vectors(columns.force, FORCE)?;
        let torque = vectors(columns.torque, TORQUE)?;
        Ok(Self {
            time,
            step,
            id: take.u32("id")?,
            material: take.u32("material")?,
            flags: take.u8("flags")?,
            mass: take.f64("mass")?,
            volume: take.f64("volume")?,
            radius: take.f64("radius")?,
            position: take.vectors(POSITION)?,
            velocity: take.vectors(VELOCITY)?,
            body: columns
                .body
                .then(|| take.optional_u32("body"))
                .transpose()?,
            orientation: columns
                .orientation
                .then(|| take.quaternions(ORIENTATION))
                .transpose()?,
            angular_velocity,
            force,
            torque,
            film_volume: columns
                .film_volume
                .then(|| take.f64("film_volume"))
                .transpose()?,
        })
    }
}

/// Writes `<prefix>.particles.arrow`, see [`FrameWriter`].
#[derive(Debug)]
pub struct ParticleWriter {
    frames: FrameWriter,
}

impl ParticleWriter {
    /// Creates a file without frames; a file of that name is replaced.
    ///
    /// # Errors
    /// When the file cannot be made.
    pub fn create(
        path: impl Into<PathBuf>,
        columns: ParticleColumns,
        header: &FramesHeader,
    ) -> Result<Self, FrameWriteError> {
        let frames = FrameWriter::create(path, columns.schema(header)?)?;
        Ok(Self { frames })
    }

    /// Continues a file behind its first `frames` frames, see [`FrameWriter::resume`].
    ///
    /// # Errors
    /// When the file has fewer frames, other columns or another header, or cannot be written.
    pub fn resume(
        path: impl Into<PathBuf>,
        columns: ParticleColumns,
        header: &FramesHeader,
        frames: usize,
    ) -> Result<Self, FrameWriteError> {
        let frames = FrameWriter::resume(path, columns.schema(header)?, frames)?;
        Ok(Self { frames })
    }

    /// Appends a frame.
    ///
    /// # Errors
    /// When its lists are not those of the file or differ in length, or the file cannot be written; the frames before
    /// stay as they are.
    pub fn append(&mut self, frame: ParticleFrame) -> Result<(), FrameWriteError> {
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

/// Reads `<prefix>.particles.arrow`, see [`FrameReader`].
#[derive(Debug)]
pub struct ParticleReader {
    frames: FrameReader,
    header: FramesHeader,
    columns: ParticleColumns,
}

impl ParticleReader {
    /// Opens a file of particles.
    ///
    /// # Errors
    /// When the file cannot be opened, is no stream of frames, or lacks columns of a table of particles.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, FormatError> {
        let (frames, header, columns) = open_table(path.as_ref(), KIND, ParticleColumns::of)?;
        Ok(Self {
            frames,
            header,
            columns,
        })
    }

    /// What the file says about its run.
    pub fn header(&self) -> &FramesHeader {
        &self.header
    }

    /// Which optional columns the file has.
    pub fn columns(&self) -> ParticleColumns {
        self.columns
    }

    /// The file itself: number of frames, times, damage.
    pub fn frames(&self) -> &FrameReader {
        &self.frames
    }

    /// Looks for frames that were added since; returns how many there are.
    pub fn refresh(&mut self) -> usize {
        self.frames.refresh()
    }

    /// Frame `k`, counted from 0.
    ///
    /// # Errors
    /// When there is no such frame or its bytes are damaged.
    pub fn frame(&self, k: usize) -> Result<ParticleFrame, FormatError> {
        let frame = self.frames.frame(k)?;
        ParticleFrame::of(frame, self.frames.schema(), self.columns).map_err(|found| {
            FormatError::of_file(self.frames.path(), format!("frame {k}: {found}"))
        })
    }

    /// All frames, one in memory at a time; if the file is damaged, what is wrong comes last, once.
    pub fn iter(&self) -> impl Iterator<Item = Result<ParticleFrame, FormatError>> + '_ {
        let damage = self.frames.damage().cloned().map(Err);
        (0..self.frames.len()).map(|k| self.frame(k)).chain(damage)
    }
}
