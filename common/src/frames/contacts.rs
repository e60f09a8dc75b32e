//! The table of contacts: one row per contact of two particles or of a particle and a wall.

use std::path::{Path, PathBuf};

use glam::DVec3;

use super::table::{Taker, components, index, number, open_table, require, split_vectors};
use super::{
    Column, ColumnKind, ColumnSpec, Frame, FrameReader, FrameSchema, FrameWriteError, FrameWriter,
    FramesHeader,
};
use crate::error::FormatError;

const KIND: &str = "contacts";
const POINT: [&str; 3] = ["px", "py", "pz"];
const BRANCH: [&str; 3] = ["bx", "by", "bz"];
const NORMAL: [&str; 3] = ["nx", "ny", "nz"];
const FORCE: [&str; 3] = ["fx", "fy", "fz"];
const TORQUE: [&str; 3] = ["tx", "ty", "tz"];

/// Unit and meaning of one number that a contact law remembers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HistoryColumn {
    /// The SI unit.
    pub unit: String,
    /// What the law keeps there.
    pub description: String,
}

/// Which optional columns a file of contacts has; fixed for the file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ContactColumns {
    /// Couple on particle i beyond the lever arm of the force.
    pub torque: bool,
    /// The numbers that the contact laws remember, columns `h0`, `h1`, ...
    pub history: Vec<HistoryColumn>,
}

/// The contacts at one instant; all lists have one entry per contact.
///
/// A contact is of particle `i` with *either* particle `j` *or* wall `wall`: of the two, exactly one is there.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ContactFrame {
    /// Time, in s.
    pub time: f64,
    /// Number of time steps made.
    pub step: u64,
    /// Id of the particle that force and torque act on.
    pub i: Vec<u32>,
    /// Id of the other particle.
    pub j: Vec<Option<u32>>,
    /// Index of the wall, see [`FramesHeader::walls`].
    pub wall: Vec<Option<u32>>,
    /// Contact point, in m, beside particle i where the domain is periodic.
    pub point: Vec<DVec3>,
    /// Branch vector, in m: from the centre of j (its image nearest to i), for a wall from the contact point, to the
    /// centre of i.
    pub branch: Vec<DVec3>,
    /// Unit normal, from j or the wall towards i.
    pub normal: Vec<DVec3>,
    /// Force on i, in N; j or the wall gets the opposite.
    pub force: Vec<DVec3>,
    /// Overlap, in m; negative for particles that pull over a gap.
    pub overlap: Vec<f64>,
    /// Couple on i, in N m, beyond the lever arm of the force: rolling and torsion resistance.
    pub torque: Option<Vec<DVec3>>,
    /// What the contact laws remember: one list per entry of [`ContactColumns::history`].
    pub history: Vec<Vec<f64>>,
}

impl ContactColumns {
    /// The columns of the file in their order, without `time`.
    pub fn specs(&self) -> Vec<ColumnSpec> {
        let mut specs = vec![
            index(
                "i",
                ColumnKind::U32,
                "id of the particle that the force acts on",
            ),
            index(
                "j",
                ColumnKind::OptionalU32,
                "id of the other particle, null at a wall",
            ),
            index(
                "wall",
                ColumnKind::OptionalU32,
                "index of the wall, null between particles",
            ),
        ];
        specs.extend(components(POINT, "m", "contact point"));
        let branch =
            "from the centre of j (nearest image) or the point on the wall to the centre of i";
        specs.extend(components(BRANCH, "m", branch));
        specs.extend(components(
            NORMAL,
            "1",
            "unit normal, from j or the wall towards i",
        ));
        specs.extend(components(FORCE, "N", "force on i"));
        specs.push(number("overlap", "m", "overlap, negative over a gap"));
        if self.torque {
            let torque = "couple on i beyond the lever arm of the force";
            specs.extend(components(TORQUE, "N m", torque));
        }
        for (k, history) in self.history.iter().enumerate() {
            specs.push(number(
                &format!("h{k}"),
                &history.unit,
                &history.description,
            ));
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
        let spec = |k: usize| {
            let place = schema.index_of(&format!("h{k}"))?;
            let spec = &schema.columns()[place];
            Some(HistoryColumn {
                unit: spec.unit.clone(),
                description: spec.description.clone().unwrap_or_default(),
            })
        };
        let columns = Self {
            torque: schema.index_of(TORQUE[0]).is_some(),
            history: (0..).map_while(spec).collect(),
        };
        require(schema, &columns.specs())?;
        Ok(columns)
    }
}

/// The row, if any, that has both or neither of particle j and wall.
fn neither_or_both(j: &[Option<u32>], wall: &[Option<u32>]) -> Option<String> {
    let mut rows = j.iter().zip(wall);
    let row = rows.position(|(j, wall)| j.is_some() == wall.is_some())?;
    Some(format!(
        "contact {row} must have either a particle j or a wall"
    ))
}

impl ContactFrame {
    /// The number of contacts.
    pub fn len(&self) -> usize {
        self.i.len()
    }

    /// Whether there are no contacts.
    pub fn is_empty(&self) -> bool {
        self.i.is_empty()
    }

    /// The frame as flat columns in the order of [`ContactColumns::specs`].
    pub fn into_frame(self) -> Frame {
        let mut columns = vec![
            Column::U32(self.i),
            Column::OptionalU32(self.j),
            Column::OptionalU32(self.wall),
        ];
        for vectors in [&self.point, &self.branch, &self.normal, &self.force] {
            columns.extend(split_vectors(vectors));
        }
        columns.push(Column::F64(self.overlap));
        columns.extend(self.torque.iter().flat_map(|v| split_vectors(v)));
        columns.extend(self.history.into_iter().map(Column::F64));
        Frame {
            time: self.time,
            step: self.step,
            columns,
        }
    }

    fn of(frame: Frame, schema: &FrameSchema, columns: &ContactColumns) -> Result<Self, String> {
        let (time, step) = (frame.time, frame.step);
        let mut take = Taker::new(schema, frame);
        let contacts = Self {
            time,
            step,
            i: take.u32("i")?,
            j: take.optional_u32("j")?,
            wall: take.optional_u32("wall")?,
            point: take.vectors(POINT)?,
            branch: take.vectors(BRANCH)?,
            normal: take.vectors(NORMAL)?,
            force: take.vectors(FORCE)?,
            overlap: take.f64("overlap")?,
            torque: columns.torque.then(|| take.vectors(TORQUE)).transpose()?,
            history: (0..columns.history.len())
                .map(|k| take.f64(&format!("h{k}")))
                .collect::<Result<_, _>>()?,
        };
        match neither_or_both(&contacts.j, &contacts.wall) {
            Some(found) => Err(found),
            None => Ok(contacts),
        }
    }
}

/// Writes `<prefix>.contacts.arrow`, see [`FrameWriter`].
#[derive(Debug)]
pub struct ContactWriter {
    frames: FrameWriter,
}

impl ContactWriter {
    /// Creates a file without frames; a file of that name is replaced.
    ///
    /// # Errors
    /// When the file cannot be made.
    pub fn create(
        path: impl Into<PathBuf>,
        columns: &ContactColumns,
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
        columns: &ContactColumns,
        header: &FramesHeader,
        frames: usize,
    ) -> Result<Self, FrameWriteError> {
        let frames = FrameWriter::resume(path, columns.schema(header)?, frames)?;
        Ok(Self { frames })
    }

    /// Appends a frame.
    ///
    /// # Errors
    /// When its lists are not those of the file or differ in length, when a contact has not exactly one of particle j
    /// and wall, or the file cannot be written; the frames before stay as they are.
    pub fn append(&mut self, frame: ContactFrame) -> Result<(), FrameWriteError> {
        if let Some(reason) = neither_or_both(&frame.j, &frame.wall) {
            return Err(FrameWriteError::Frame {
                path: self.frames.path().to_owned(),
                step: frame.step,
                reason,
            });
        }
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

/// Reads `<prefix>.contacts.arrow`, see [`FrameReader`].
#[derive(Debug)]
pub struct ContactReader {
    frames: FrameReader,
    header: FramesHeader,
    columns: ContactColumns,
}

impl ContactReader {
    /// Opens a file of contacts.
    ///
    /// # Errors
    /// When the file cannot be opened, is no stream of frames, or lacks columns of a table of contacts.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, FormatError> {
        let (frames, header, columns) = open_table(path.as_ref(), KIND, ContactColumns::of)?;
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
    pub fn columns(&self) -> &ContactColumns {
        &self.columns
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
    pub fn frame(&self, k: usize) -> Result<ContactFrame, FormatError> {
        let frame = self.frames.frame(k)?;
        ContactFrame::of(frame, self.frames.schema(), &self.columns).map_err(|found| {
            FormatError::of_file(self.frames.path(), format!("frame {k}: {found}"))
        })
    }

    /// All frames, one in memory at a time; if the file is damaged, what is wrong comes last, once.
    pub fn iter(&self) -> impl Iterator<Item = Result<ContactFrame, FormatError>> + '_ {
        let damage = self.frames.damage().cloned().map(Err);
        (0..self.frames.len()).map(|k| self.frame(k)).chain(damage)
    }
}
