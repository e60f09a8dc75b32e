//! The tables of an input: particles, and what a run has beside them, as frames.

use mercury_common::error::FormatError;
use mercury_common::frames::{FrameReader, FramesHeader, TableReader};

use super::{Item, RunSource, Snapshot, Source};
use crate::{ExportError, FrameChoice, Selection, beside, bodies};

/// Table of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Table {
    /// The particles.
    #[default]
    Particles,
    /// The contacts, which only native frames have.
    Contacts,
    /// The bonds, which only native frames have.
    Bonds,
    /// The rigid bodies (clumps), which only native frames have.
    Bodies,
    /// Triangles of walls that are worn, which only native frames have.
    WearTriangles,
}

impl Table {
    /// Name of the table as in names of files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Particles => "particles",
            Self::Contacts => "contacts",
            Self::Bonds => "bonds",
            Self::Bodies => "bodies",
            Self::WearTriangles => "wear_triangles",
        }
    }

    /// One row of it.
    pub(crate) fn one(self) -> &'static str {
        match self {
            Self::Particles => "particle",
            Self::Contacts => "contact",
            Self::Bonds => "bond",
            Self::Bodies => "body",
            Self::WearTriangles => "triangle",
        }
    }
}

/// How to do without a table that is not there or cannot be read.
const SPHERES: &str = "--table particles has the spheres";

/// The frames of one table.
pub(crate) struct Frames<'a> {
    source: &'a Source,
    table: Table,
    /// Reader and header of a table other than the particles.
    beside: Option<(&'a FrameReader, &'a FramesHeader)>,
}

impl<'a> Frames<'a> {
    /// The frames of a table.
    ///
    /// # Errors
    /// When the input has no such table, it cannot be read, or its rows cannot be selected in this way.
    pub(crate) fn of(
        source: &'a Source,
        table: Table,
        selection: &Selection,
    ) -> Result<Self, ExportError> {
        let beside = match table {
            Table::Particles => None,
            Table::Bodies => {
                let reader = bodies::reader(source, SPHERES)?;
                let reader = reader.ok_or_else(|| bodies::missing(source, SPHERES))?;
                Some((reader.frames(), reader.header()))
            }
            Table::WearTriangles => {
                let help = "`wear` at a wall of the scene and frames = true in [output] write them";
                let rows = [table.name(), "worn triangles"];
                let open = |run: &'a RunSource| run.wear_triangles(SPHERES);
                Some(of_run(source, open, rows, help, selection)?)
            }
            Table::Contacts => {
                let help = "fstat = true in [output] of the scene writes them";
                let open = |run: &'a RunSource| run.contacts(SPHERES);
                Some(of_run(source, open, [table.name(); 2], help, selection)?)
            }
            Table::Bonds => {
                let open = |run: &'a RunSource| run.bonds(SPHERES);
                let rows = [table.name(); 2];
                Some(of_run(source, open, rows, beside::NO_BONDS, selection)?)
            }
        };
        Ok(Self {
            source,
            table,
            beside,
        })
    }

    pub(crate) fn table(&self) -> Table {
        self.table
    }

    /// The chosen frames, one in memory at a time; what is wrong with the input comes last, once.
    pub(crate) fn chosen(&self, choice: FrameChoice) -> Box<dyn Iterator<Item = Item> + Send + '_> {
        match self.beside {
            None => self.source.frames(choice),
            Some((reader, header)) => Box::new(native(reader, header, choice)),
        }
    }

    /// Message that no frame is selected.
    pub(crate) fn none(&self) -> String {
        let (path, count) = match self.beside {
            Some((reader, _)) => (reader.path(), Some(reader.len())),
            None => (self.source.path(), self.source.len_hint()),
        };
        let path = path.display();
        match count {
            Some(0) => format!("{path}: the input has no frame"),
            Some(count) => format!("{path}: no frame is selected; there are 0 to {}", count - 1),
            None => format!("{path}: no frame is selected, or the input has none"),
        }
    }
}

/// A table that only runs have, and whose rows cannot be selected as particles are. `kind` is its name, `rows` names its rows, and `help` says which runs
/// have it.
fn of_run<'a, T: mercury_common::frames::Table + 'a>(
    source: &'a Source,
    open: impl FnOnce(&'a RunSource) -> Result<Option<&'a TableReader<T>>, FormatError>,
    [kind, rows]: [&str; 2],
    help: &str,
    selection: &Selection,
) -> Result<(&'a FrameReader, &'a FramesHeader), ExportError> {
    let reader = match source {
        Source::Run(run) => open(run)?,
        Source::Data(_) | Source::Lammps(_) => None,
    };
    let reader = reader.ok_or_else(|| beside::missing(source, kind, "", help))?;
    if selection.is_partial() {
        let found = format!("--region and --material select particles; {rows} have neither");
        return Err(ExportError::Input(found));
    }
    Ok((reader.frames(), reader.header()))
}

/// The chosen frames of a native table, then what is wrong with it.
pub(super) fn native<'a>(
    reader: &'a FrameReader,
    header: &'a FramesHeader,
    choice: FrameChoice,
) -> impl Iterator<Item = Item> + Send + 'a {
    let choice = match choice {
        FrameChoice::Last => FrameChoice::Range {
            from: reader.len().saturating_sub(1),
            to: None,
            every: 1,
        },
        choice => choice,
    };
    let chosen = (0..reader.len()).filter(move |&k| choice.has(k));
    let read = |number: usize| {
        Ok(Snapshot {
            path: reader.path().to_owned(),
            number,
            specs: reader.schema().columns().to_vec(),
            frame: reader.frame(number)?,
            header: header.clone(),
        })
    };
    chosen.map(read).chain(reader.damage().cloned().map(Err))
}
