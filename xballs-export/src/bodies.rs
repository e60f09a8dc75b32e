//! Rigid bodies of a run: as their pebbles, or as their own surfaces.

use std::collections::HashSet;

use mercury_common::frames::{BodyFrame, BodyReader, Column};
use mercury_common::paraview::{clump_column, clump_spec};

use crate::beside;
use crate::selection::retain;
use crate::{ExportError, Selection, Snapshot, Source};

/// How clumps are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ClumpsAs {
    /// Every pebble is a sphere.
    #[default]
    Pebbles,
    /// Bodies are their own surfaces; those whose clump has none are pebbles.
    Surface,
    /// Surfaces, and all pebbles too.
    Both,
}

/// The bodies of one instant that are selected: by their centres of mass and their materials.
#[derive(Debug)]
pub(crate) struct Shown {
    /// Bodies as a table.
    pub(crate) table: Snapshot,
    /// Frame of the same bodies.
    pub(crate) frame: BodyFrame,
    /// Ids of all bodies of the run with surfaces of their own, selected or not.
    with_surface: HashSet<u32>,
}

/// The table of bodies of a run, if it has one; `help`: how to do without it if it cannot be read.
///
/// # Errors
/// When the file cannot be read.
pub(crate) fn reader<'a>(
    source: &'a Source,
    help: &str,
) -> Result<Option<&'a BodyReader>, ExportError> {
    match source {
        Source::Run(run) => Ok(run.bodies(help)?),
        Source::Data(_) | Source::Lammps(_) => Ok(None),
    }
}

/// How to do without surfaces.
const PEBBLES: &str = "--clumps pebbles shows what there is";

/// The table that `clumps` needs: none for pebbles.
///
/// # Errors
/// When surfaces are requested of an input that has no table of bodies, or they cannot be read.
pub(crate) fn reader_for(
    source: &Source,
    clumps: ClumpsAs,
) -> Result<Option<&BodyReader>, ExportError> {
    if clumps == ClumpsAs::Pebbles {
        return Ok(None);
    }
    if let Source::Run(run) = source {
        run.surfaces(PEBBLES)?;
    }
    match reader(source, PEBBLES)? {
        Some(reader) => Ok(Some(reader)),
        None => Err(missing(source, PEBBLES)),
    }
}

/// Error of a missing table of bodies.
pub(crate) fn missing(source: &Source, help: &str) -> ExportError {
    let why = ": the run has no clumps, or is of an earlier version";
    beside::missing(source, "bodies", why, help)
}

/// Notes on clumps that cannot be shown as surfaces.
pub(crate) fn notes(reader: Option<&BodyReader>) -> Vec<String> {
    let kinds = reader.map_or(&[][..], BodyReader::kinds).iter();
    let without = kinds.filter(|kind| kind.surface.is_none());
    without
        .map(|kind| {
            format!(
                "the run holds no surface of clump `{}`, so its pebbles are shown (its clump file names none, or the file could \
                 not be read when the run began: its plan says); `mclump SURFACE PEBBLES` or `mclump SURFACE --generate ...` \
                 writes a clump file with one",
                kind.name
            )
        })
        .collect()
}

/// Gives particles that may be pebbles a column `clump`: the kind of clump that each is of, which is not known if the table has no bodies of that step.
///
/// # Errors
/// When the file is damaged.
pub(crate) fn add_clumps(reader: &BodyReader, particles: &mut Snapshot) -> Result<(), ExportError> {
    let mut infos = reader.frames().infos();
    let step = particles.frame.step;
    let columns = match infos.position(|info| info.step == step) {
        Some(number) => reader.frames().columns(number, &["id", "clump"])?,
        None => Vec::new(),
    };
    let [ids, clumps] = [0, 1].map(|k| {
        let column = columns.get(k).and_then(Column::as_u32);
        column.unwrap_or_default()
    });
    if let Some(Column::OptionalU32(body)) = particles.column("body") {
        let column = clump_column(body, ids, clumps);
        particles.specs.push(clump_spec());
        particles.frame.columns.push(column);
    }
    Ok(())
}

/// The bodies at the time of some particles; none if the table does not have that step.
///
/// # Errors
/// When the file is damaged, or a selection fits no body's columns.
pub(crate) fn at_step(
    reader: &BodyReader,
    step: u64,
    selection: &Selection,
) -> Result<Option<Shown>, ExportError> {
    let mut infos = reader.frames().infos();
    let Some(number) = infos.position(|info| info.step == step) else {
        return Ok(None);
    };
    let unfit = |found: String| {
        let path = reader.frames().path().display();
        ExportError::Input(format!("{path}: frame {number}: {found}"))
    };
    let frame = reader.frames().frame(number)?;
    let all = reader.rows(frame.clone()).map_err(unfit)?;
    let bodies = all.id.iter().zip(&all.clump);
    let with_surface = bodies
        .filter(|(_, clump)| reader.kinds()[**clump as usize].surface.is_some())
        .map(|(&id, _)| id)
        .collect();
    let mut table = Snapshot {
        path: reader.frames().path().to_owned(),
        number,
        specs: reader.frames().schema().columns().to_vec(),
        frame,
        header: reader.header().clone(),
    };
    selection.apply(&mut table)?;
    let frame = reader.rows(table.frame.clone()).map_err(unfit)?;
    Ok(Some(Shown {
        table,
        frame,
        with_surface,
    }))
}

impl Shown {
    /// Leaves out the pebbles of bodies that have surfaces of their own.
    pub(crate) fn hide_pebbles(&self, particles: &mut Snapshot) {
        let Some(Column::OptionalU32(body)) = particles.column("body") else {
            return;
        };
        let hidden = |body: &Option<u32>| body.is_some_and(|id| self.with_surface.contains(&id));
        let keep: Vec<bool> = body.iter().map(|body| !hidden(body)).collect();
        for column in &mut particles.frame.columns {
            retain(column, &keep);
        }
    }
}
