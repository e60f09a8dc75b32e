//! Where frames come from: a run folder, a file of frames, `.data` files, a script of XBalls that names one, or files of LAMMPS and LIGGGHTS.

mod data;
mod lammps;
mod run;
mod tables;

use std::path::{Path, PathBuf};

use glam::DVec3;
use mercury_common::error::FormatError;
use mercury_common::frames::{Column, ColumnSpec, Frame, FramesHeader};
use mercury_common::run_files::{FRAMES, particles_in, series_number};

use crate::{ExportError, FrameChoice};
use data::DataSource;
pub(crate) use data::EULER;
pub use lammps::LammpsSource;
pub(crate) use run::{RunSource, SheetTables};
pub(crate) use tables::Frames;
pub use tables::Table;

/// The particles at one instant, with all columns that the input has.
#[derive(Debug, Clone, PartialEq)]
pub struct Snapshot {
    /// The file it comes from.
    pub path: PathBuf,
    /// Number of the frame in the input, from 0.
    pub number: usize,
    /// Names, types and units of the columns.
    pub specs: Vec<ColumnSpec>,
    /// The columns.
    pub frame: Frame,
    /// Facts about the run from the input.
    pub header: FramesHeader,
}

impl Snapshot {
    /// A column by its name.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<&Column> {
        let place = self.specs.iter().position(|spec| spec.name == name)?;
        self.frame.columns.get(place)
    }

    /// A column of numbers by its name.
    ///
    /// # Errors
    /// When there is none.
    pub fn numbers(&self, name: &str) -> Result<&[f64], ExportError> {
        let found = self.column(name).and_then(Column::as_f64);
        found.ok_or_else(|| {
            let path = self.path.display();
            ExportError::Input(format!("{path}: no column `{name}` of numbers"))
        })
    }

    /// Three columns as vectors; `None` if one of them is not there.
    #[must_use]
    pub fn vectors(&self, names: [&str; 3]) -> Option<Vec<DVec3>> {
        let place = |name: &str| self.specs.iter().position(|spec| spec.name == name);
        let places = [place(names[0])?, place(names[1])?, place(names[2])?];
        mercury_common::paraview::vectors(&self.frame.columns, places)
    }

    /// The domain, or the box around all particles if the input has none.
    ///
    /// # Errors
    /// When there are neither a domain nor positions.
    pub fn domain(&self) -> Result<(DVec3, DVec3), ExportError> {
        if let Some(domain) = self.header.domain {
            return Ok(domain);
        }
        let radius = self.numbers("radius")?;
        let Some(centres) = self.vectors(["x", "y", "z"]) else {
            let path = self.path.display();
            return Err(ExportError::Input(format!("{path}: no positions x, y, z")));
        };
        let spheres = || centres.iter().zip(radius);
        let min = spheres().fold(DVec3::INFINITY, |low, (x, r)| low.min(*x - *r));
        let max = spheres().fold(DVec3::NEG_INFINITY, |high, (x, r)| high.max(*x + *r));
        Ok(if centres.is_empty() {
            (DVec3::ZERO, DVec3::ZERO)
        } else {
            (min, max)
        })
    }

    /// Number of space dimensions, 3 if the input does not give it.
    #[must_use]
    pub fn dimensions(&self) -> u8 {
        self.header.dimensions.unwrap_or(3)
    }
}

/// Frames of an item and what is wrong with the rest.
type Item = Result<Snapshot, FormatError>;

/// An input, opened.
#[derive(Debug)]
pub enum Source {
    /// Native frames of a run.
    Run(Box<RunSource>),
    /// `.data` in one file or a numbered series.
    Data(DataSource),
    /// A dump or data file of LAMMPS or LIGGGHTS.
    Lammps(LammpsSource),
}

impl Source {
    /// Opens a run folder, `<prefix>.particles.arrow`, `.data`, the first of a series `.data.0000`, or a script `.disp` or
    /// `.xballs`, whose `.data` file is taken; or a dump or data file of LAMMPS or LIGGGHTS, whatever its name.
    ///
    /// # Errors
    /// When there is nothing of this kind, several runs lie in the folder, or the file cannot be opened.
    pub fn open(path: &Path) -> Result<Self, ExportError> {
        if path.is_dir() {
            return Self::open(&particles_in(path)?);
        }
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if name.ends_with(FRAMES) {
            return Ok(Self::Run(Box::new(RunSource::open(path)?)));
        }
        if let Some(found) = LammpsSource::recognise(path) {
            return Ok(Self::Lammps(found));
        }
        if name.ends_with(".disp") || name.ends_with(".xballs") {
            let named = crate::xballs_script::Script::read(path)?.data;
            return Ok(Self::Data(DataSource::open(&named)?));
        }
        if name.ends_with(".data") || series_number(&name).is_some() {
            return Ok(Self::Data(DataSource::open(path)?));
        }
        let found = if path.exists() {
            "neither a run folder nor a file of particles"
        } else {
            "there is no such file or folder"
        };
        let error = FormatError {
            expected: "a folder of mercury-solve, a .particles.arrow, .data, .disp or .xballs file, or a dump or data file of LAMMPS or LIGGGHTS"
                .to_owned(),
            ..FormatError::of_file(path, found)
        };
        Err(error.into())
    }

    /// Beginning of the names of the run's files.
    #[must_use]
    pub fn prefix(&self) -> &str {
        match self {
            Self::Run(run) => run.prefix(),
            Self::Data(data) => data.prefix(),
            Self::Lammps(file) => file.prefix(),
        }
    }

    /// The file of particles; of a series the first.
    #[must_use]
    pub fn path(&self) -> &Path {
        match self {
            Self::Run(run) => run.path(),
            Self::Data(data) => data.path(),
            Self::Lammps(file) => file.path(),
        }
    }

    /// The folder that the input lies in.
    #[must_use]
    pub fn folder(&self) -> &Path {
        match self.path().parent() {
            Some(parent) if parent.as_os_str().is_empty() => Path::new("."),
            Some(parent) => parent,
            None => Path::new("."),
        }
    }

    /// The number of frames, if it is known without reading all.
    #[must_use]
    pub fn len_hint(&self) -> Option<usize> {
        match self {
            Self::Run(run) => Some(run.len()),
            Self::Data(_) | Self::Lammps(_) => None,
        }
    }

    /// The chosen frames, one in memory at a time (of [`FrameChoice::Last`] in a `.data` file two); what is wrong with the
    /// input comes last, once.
    pub fn frames(&self, choice: FrameChoice) -> Box<dyn Iterator<Item = Item> + Send + '_> {
        match self {
            Self::Run(run) => Box::new(run.frames(choice)),
            Self::Data(data) => data.frames(choice),
            Self::Lammps(file) => file.frames(choice),
        }
    }
}
