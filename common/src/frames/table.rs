//! A table of frames: its columns, declared once, and the writer and reader that follow from them.

use std::path::{Path, PathBuf};

use super::columns::{ColumnVisitor, Columns, Put, Specs, Take};
use super::{
    ColumnSpec, Frame, FrameReader, FrameSchema, FrameWriteError, FrameWriter, FramesHeader,
    SchemaError,
};
use crate::error::FormatError;

/// Rows at one instant that a file of frames holds, with lists of equal length: particles, contacts, walls, ...
///
/// A type declares its columns once, in [`columns`](Self::columns); the schema of the file, [`TableWriter`] and [`TableReader`]
/// follow.
///
/// ```
/// use mercury_common::frames::{ColumnVisitor, FramesHeader, Table, TableReader, TableWriter};
///
/// /// Temperatures of particles.
/// #[derive(Debug, Clone, PartialEq, Default)]
/// struct Temperatures {
///     time: f64,
///     step: u64,
///     id: Vec<u32>,
///     temperature: Vec<f64>,
/// }
///
/// impl Table for Temperatures {
///     const KIND: &'static str = "temperatures";
///     type Layout = ();
///
///     fn moment(&mut self) -> (&mut f64, &mut u64) {
///         (&mut self.time, &mut self.step)
///     }
///
///     fn columns(&mut self, (): &(), visitor: &mut impl ColumnVisitor) {
///         visitor.column(&mut self.id, &["id"], "1", "number of the particle");
///         visitor.column(&mut self.temperature, &["temperature"], "K", "mean over the particle");
///     }
/// }
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("run.temperatures.arrow");
/// let frame = Temperatures { time: 0.5, step: 10, id: vec![0, 3], temperature: vec![293.0, 301.5] };
/// let mut writer = TableWriter::create(&path, &FramesHeader::default(), &())?;
/// writer.append(frame.clone())?;
/// assert_eq!(TableReader::<Temperatures>::open(&path)?.frame(0)?, frame);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Table: Default {
    /// Name of the content in the file, the value of the schema metadata `kind`.
    const KIND: &'static str;

    /// Facts that are fixed for a whole file: its optional columns, the objects that its rows refer to.
    type Layout: Default;

    /// Time in s and number of time steps made.
    fn moment(&mut self) -> (&mut f64, &mut u64);

    /// Shows the visitor every column in the order of the file, without `time`.
    fn columns(&mut self, layout: &Self::Layout, visitor: &mut impl ColumnVisitor);

    /// Finds the layout of a file. The error is what was found that makes no sense.
    ///
    /// # Errors
    /// When the file contradicts itself.
    fn layout(_: &FrameSchema) -> Result<Self::Layout, String> {
        Ok(Self::Layout::default())
    }

    /// Metadata of the schema that the layout adds to [`FramesHeader::entries`].
    fn metadata(_: &Self::Layout) -> Vec<(String, String)> {
        Vec::new()
    }

    /// Whether the rows make sense, alone and in a file of this layout; the error describes what does not.
    ///
    /// # Errors
    /// When they do not.
    fn check(&self, _: &Self::Layout) -> Result<(), String> {
        Ok(())
    }

    /// Writes what belongs to the layout and has a file of its own beside `path`.
    ///
    /// # Errors
    /// When that file cannot be made.
    fn write_beside(
        _: &Self::Layout,
        _path: &Path,
        _: &FramesHeader,
    ) -> Result<(), FrameWriteError> {
        Ok(())
    }

    /// Reads what [`write_beside`](Self::write_beside) wrote.
    ///
    /// # Errors
    /// When that file cannot be read or is of another run.
    fn read_beside(_: &mut Self::Layout, _path: &Path, _: &FrameSchema) -> Result<(), FormatError> {
        Ok(())
    }

    /// The columns of the file in their order, without `time`.
    #[must_use]
    fn specs(layout: &Self::Layout) -> Vec<ColumnSpec> {
        let mut specs = Specs::default();
        Self::default().columns(layout, &mut specs);
        specs.0
    }

    /// The schema of the file.
    ///
    /// # Errors
    /// When two columns have one name.
    fn schema(layout: &Self::Layout, header: &FramesHeader) -> Result<FrameSchema, SchemaError> {
        let mut entries = header.entries();
        entries.extend(Self::metadata(layout));
        Ok(FrameSchema::new(Self::KIND, Self::specs(layout))?.with_metadata(entries))
    }

    /// The rows as flat columns in the order of [`specs`](Self::specs).
    #[must_use]
    fn into_frame(mut self) -> Frame {
        let (&mut time, &mut step) = self.moment();
        let mut put = Put::default();
        // Columns that have values are put; the writer of frames compares them with the schema of the file.
        self.columns(&Self::Layout::default(), &mut put);
        Frame {
            time,
            step,
            columns: put.0,
        }
    }
}

/// Writes a file of a table, see [`FrameWriter`].
#[derive(Debug)]
pub struct TableWriter<T: Table> {
    frames: FrameWriter,
    layout: T::Layout,
}

impl<T: Table> TableWriter<T>
where
    T::Layout: Clone,
{
    /// Creates a file without frames; a file of that name is replaced. A part with a file of its own beside it is written at
    /// once.
    ///
    /// # Errors
    /// When a file cannot be made.
    pub fn create(
        path: impl Into<PathBuf>,
        header: &FramesHeader,
        layout: &T::Layout,
    ) -> Result<Self, FrameWriteError> {
        let path = path.into();
        T::write_beside(layout, &path, header)?;
        Ok(Self {
            frames: FrameWriter::create(path, T::schema(layout, header)?)?,
            layout: layout.clone(),
        })
    }

    /// Continues a file behind its first `frames` frames, see [`FrameWriter::resume`].
    ///
    /// # Errors
    /// When the file has fewer frames, another layout or another header, or cannot be written.
    pub fn resume(
        path: impl Into<PathBuf>,
        header: &FramesHeader,
        layout: &T::Layout,
        frames: usize,
    ) -> Result<Self, FrameWriteError> {
        Ok(Self {
            frames: FrameWriter::resume(path, T::schema(layout, header)?, frames)?,
            layout: layout.clone(),
        })
    }

    /// Appends a frame.
    ///
    /// # Errors
    /// When its lists are not those of the file or differ in length, when they make no sense ([`Table::check`]), or the file
    /// cannot be written; the frames before stay as they are.
    pub fn append(&mut self, mut frame: T) -> Result<(), FrameWriteError> {
        if let Err(reason) = frame.check(&self.layout) {
            return Err(FrameWriteError::Frame {
                path: self.frames.path().to_owned(),
                step: *frame.moment().1,
                reason,
            });
        }
        self.frames.append(&frame.into_frame())
    }

    /// The file itself: its length, [`FrameWriter::sync`].
    pub fn frames(&self) -> &FrameWriter {
        &self.frames
    }
}

/// Reads a file of a table, see [`FrameReader`].
#[derive(Debug)]
pub struct TableReader<T: Table> {
    frames: FrameReader,
    header: FramesHeader,
    layout: T::Layout,
}

impl<T: Table> TableReader<T> {
    /// Opens a file, and the one beside it if there should be one.
    ///
    /// # Errors
    /// When a file cannot be opened, is no stream of frames, lacks columns of the table, or the one beside it is of another
    /// run.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, FormatError> {
        let mut reader = Self::open_alone(path.as_ref())?;
        T::read_beside(&mut reader.layout, path.as_ref(), reader.frames.schema())?;
        Ok(reader)
    }

    /// Opens a file without the one beside it.
    ///
    /// # Errors
    /// When the file cannot be opened, is no stream of frames, or lacks columns of the table.
    pub fn open_alone(path: impl AsRef<Path>) -> Result<Self, FormatError> {
        let path = path.as_ref();
        let frames = open_kind(path, T::KIND)?;
        let layout =
            T::layout(frames.schema()).map_err(|found| FormatError::of_file(path, found))?;
        require(path, T::KIND, frames.schema(), &T::specs(&layout))?;
        let header =
            FramesHeader::of(frames.schema()).map_err(|[found, expected]| FormatError {
                expected,
                ..FormatError::of_file(path, found)
            })?;
        Ok(Self {
            frames,
            header,
            layout,
        })
    }

    /// Facts about the run from the header of the file.
    pub fn header(&self) -> &FramesHeader {
        &self.header
    }

    /// Facts that are fixed for the whole file.
    pub fn layout(&self) -> &T::Layout {
        &self.layout
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
    /// When there is no such frame, its bytes are damaged, or its rows make no sense ([`Table::check`]).
    pub fn frame(&self, k: usize) -> Result<T, FormatError> {
        let frame = self.frames.frame(k)?;
        self.rows(frame).map_err(|found| {
            FormatError::of_file(self.frames.path(), format!("frame {k}: {found}"))
        })
    }

    /// The rows of a frame of this file, of which some may have been left out.
    ///
    /// # Errors
    /// When the columns are others, or the rows make no sense ([`Table::check`]).
    pub fn rows(&self, frame: Frame) -> Result<T, String> {
        let mut rows = T::default();
        let (time, step) = rows.moment();
        (*time, *step) = (frame.time, frame.step);
        let mut take = Take::new(Columns::new(self.frames.schema(), frame));
        rows.columns(&self.layout, &mut take);
        take.result?;
        rows.check(&self.layout)?;
        Ok(rows)
    }

    /// All frames, one in memory at a time; if the file is damaged, what is wrong comes last, once.
    pub fn iter(&self) -> impl Iterator<Item = Result<T, FormatError>> + '_ {
        let damage = self.frames.damage().cloned().map(Err);
        (0..self.frames.len()).map(|k| self.frame(k)).chain(damage)
    }
}

/// Opens a file that should hold a table of this kind.
pub(super) fn open_kind(path: &Path, kind: &str) -> Result<FrameReader, FormatError> {
    let reader = FrameReader::open(path)?;
    // Files of other programs do not give their kind; there the columns decide.
    let found = reader.schema().kind();
    if !found.is_empty() && found != kind {
        return Err(FormatError {
            expected: format!("frames of {kind}"),
            ..FormatError::of_file(path, format!("frames of {found}"))
        });
    }
    Ok(reader)
}

/// Makes sure that the columns are there; `found` of the error names the first that is not.
pub(super) fn require(
    path: &Path,
    kind: &str,
    schema: &FrameSchema,
    specs: &[ColumnSpec],
) -> Result<(), FormatError> {
    let is_missing = |spec: &&ColumnSpec| schema.index_of(&spec.name).is_none();
    match specs.iter().find(is_missing) {
        Some(missing) => Err(FormatError {
            expected: format!("a table of {kind}"),
            ..FormatError::of_file(path, format!("no column `{}`", missing.name))
        }),
        None => Ok(()),
    }
}
