//! For ParaView, pyvista and meshio: series of `.vtu` with a `.pvd` for each kind, and a script that opens them.
//!
//! Kinds: `particles`, `contacts` (as lines), `bridges` (those with liquid, as lines), `bonds` (as lines), `walls` (as triangles where they stand), `bodies` (centres of
//! mass of clumps), `clumps` (their own surfaces), `droplets`, `membranes` (elastic sheets). A further kind is a further series.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use glam::DVec3;
use mercury_common::formats::vtu::{VtuError, VtuOptions};
use mercury_common::frames::{
    BodyReader, BondReader, Column, ContactReader, DropletReader, FrameReader, TriangleLoadFrame,
    TriangleLoadReader, WallReader, WearReader,
};
use mercury_common::paraview::{self, ScriptParts, Series, WallScene};

use super::stl::worn_at;
use crate::beside;
use crate::bodies;
use crate::selection::retain;
use crate::source::{RunSource, SheetTables};
use crate::{ClumpsAs, ExportError, FrameChoice, Job, Outcome, Selection, Sink, Snapshot, Source};

/// Content of the files, and their form.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VtuChoice {
    /// Precision and compression.
    pub options: VtuOptions,
    /// With contacts, where the run has them.
    pub contacts: bool,
    /// With walls, where the run has them.
    pub walls: bool,
    /// How clumps are shown.
    pub clumps: ClumpsAs,
}

/// The series of an input.
pub struct Vtu<'a> {
    job: &'a Job,
    choice: VtuChoice,
    beside: Tables<'a>,
    warnings: Vec<String>,
    files: Vec<PathBuf>,
    particles: Option<Series>,
    /// Frames without particles before the first one that has some.
    empty: Vec<Snapshot>,
    bodies: Option<Series>,
    clumps: Option<Series>,
    /// Times of the first and the last frame, s.
    span: Option<(f64, f64)>,
    /// Number of the frame of each step, and the ids that are selected if not all are.
    steps: HashMap<u64, (usize, Option<Vec<u32>>)>,
}

/// Tables of the run beside its particles that are to be shown.
struct Tables<'a> {
    contacts: Option<&'a ContactReader>,
    walls: Option<&'a WallReader>,
    loads: Option<&'a TriangleLoadReader>,
    wear: Option<&'a WearReader>,
    bodies: Option<&'a BodyReader>,
    bonds: Option<&'a BondReader>,
    droplets: Option<&'a DropletReader>,
    /// The bodies again, where they are shown as their surfaces.
    surfaces: Option<&'a BodyReader>,
    membranes: Option<&'a SheetTables>,
}

impl<'a> Vtu<'a> {
    /// Looks at what there is to show.
    ///
    /// # Errors
    /// When a table that is requested cannot be read.
    pub fn new(job: &'a Job, choice: VtuChoice) -> Result<Self, ExportError> {
        let run = run_of(&job.source);
        let mut warnings = Vec::new();
        let contacts = run
            .filter(|_| choice.contacts)
            .map(|run| run.contacts("--no-contacts leaves contacts out"))
            .transpose()?
            .flatten();
        let walled = run.filter(|_| choice.walls);
        let walls = walled
            .map(|run| run.walls("--no-walls leaves walls out"))
            .transpose()?
            .flatten();
        let loads = walled
            .map(|run| run.triangle_loads("--no-walls leaves walls and the loads on them out"))
            .transpose()?
            .flatten();
        let wear = walled
            .map(|run| run.wear("--no-walls leaves walls and their wear out"))
            .transpose()?
            .flatten();
        let bodies = match bodies::reader(&job.source, "--clumps pebbles shows what there is") {
            // Pebbles are whole without it.
            Err(error) if choice.clumps == ClumpsAs::Pebbles => {
                warnings.push(format!("bodies are left out\n{error}"));
                None
            }
            found => found?,
        };
        let membranes = walled
            .map(|run| run.membranes("--no-walls leaves walls and membranes out"))
            .transpose()?
            .flatten();
        let surfaces = bodies::reader_for(&job.source, choice.clumps)?;
        let droplets =
            run.map(|run| run.droplets("without it droplets are left out: move the file away"));
        let droplets = droplets.transpose()?.flatten();
        let bonds = run.map(|run| run.bonds("without it bonds are left out: move the file away"));
        let bonds = bonds.transpose()?.flatten();
        let output = &job.output;
        let mut files = vec![output.path("paraview.py"), output.path("particles.pvd")];
        files.extend(contacts.map(|_| output.path("contacts.pvd")));
        files.extend(
            contacts
                .filter(|table| has_bridges(table))
                .map(|_| output.path("bridges.pvd")),
        );
        files.extend(bonds.map(|_| output.path("bonds.pvd")));
        files.extend(droplets.map(|_| output.path("droplets.pvd")));
        files.extend(walls.map(|_| output.path("walls.pvd")));
        files.extend(membranes.map(|_| output.path("membranes.pvd")));
        files.extend(bodies.map(|_| output.path("bodies.pvd")));
        files.extend(surfaces.map(|_| output.path("clumps.pvd")));
        Ok(Self {
            job,
            choice,
            beside: Tables {
                contacts,
                walls,
                loads,
                wear,
                bodies,
                bonds,
                droplets,
                surfaces,
                membranes,
            },
            warnings,
            files,
            particles: None,
            empty: Vec::new(),
            bodies: None,
            clumps: None,
            span: None,
            steps: HashMap::new(),
        })
    }

    /// Begins the series of a kind.
    fn series(&self, kind: &str) -> Result<Series, VtuError> {
        let output = &self.job.output;
        let stem = format!("{}.{kind}", output.prefix);
        Series::create(&output.folder, &stem, self.choice.options)
    }

    /// A frame of particles, behind those without any before it.
    fn write_particles(&mut self, snapshot: Snapshot) -> Result<(), ExportError> {
        self.write_empty()?;
        self.list_particles(snapshot)
    }

    /// The frames without particles that were put off.
    fn write_empty(&mut self) -> Result<(), ExportError> {
        for snapshot in std::mem::take(&mut self.empty) {
            self.list_particles(snapshot)?;
        }
        Ok(())
    }

    fn list_particles(&mut self, snapshot: Snapshot) -> Result<(), ExportError> {
        let number = snapshot.number;
        let grid = paraview::particles(&snapshot.specs, snapshot.frame);
        let grid = grid.map_err(|reason| unfit(&snapshot.path, number, &reason))?;
        // Only now, so that a wrong input leaves what is there.
        let list = match &mut self.particles {
            Some(list) => list,
            None => {
                let series = self.series("particles")?;
                self.particles.insert(series)
            }
        };
        list.write(number, &grid)?;
        Ok(())
    }

    /// The bodies at the step of some particles, whose pebbles are hidden where surfaces stand for them.
    fn write_bodies(&mut self, particles: &mut Snapshot) -> Result<(), ExportError> {
        let (step, number) = (particles.frame.step, particles.number);
        let Some(reader) = self.beside.bodies else {
            return Ok(());
        };
        let Some(shown) = bodies::at_step(reader, step, &self.job.selection)? else {
            return Ok(());
        };
        if self.bodies.is_none() {
            let has_surface = |reader: &&BodyReader| {
                let mut kinds = reader.kinds().iter();
                kinds.any(|kind| kind.surface.is_some())
            };
            let surfaces = self.beside.surfaces.filter(has_surface);
            self.clumps = surfaces.map(|_| self.series("clumps")).transpose()?;
            self.bodies = Some(self.series("bodies")?);
        }
        if let Some(list) = &mut self.clumps {
            list.write(number, &paraview::clumps(reader.kinds(), &shown.frame))?;
        }
        if self.choice.clumps == ClumpsAs::Surface {
            shown.hide_pebbles(particles);
        }
        let grid = paraview::particles(&shown.table.specs, shown.table.frame);
        let grid = grid.map_err(|reason| unfit(&particles.path, number, &reason))?;
        if let Some(list) = &mut self.bodies {
            list.write(number, &grid)?;
        }
        Ok(())
    }

    /// All contacts to be shown, and the liquid bridges among them; whether there are any of each.
    fn write_contacts(&self, outcome: &mut Outcome) -> Result<[bool; 2], ExportError> {
        let (Some(reader), Some(run)) = (self.beside.contacts, run_of(&self.job.source)) else {
            return Ok([false; 2]);
        };
        let path = reader.frames().path().display();
        let wanted = |number: &usize| {
            let info = reader.frames().info(*number);
            info.is_some_and(|info| {
                let beside = self.steps.contains_key(&info.step);
                is_wanted(info.time, beside, self.span, &self.job.selection)
            })
        };
        let numbers: Vec<usize> = (0..reader.frames().len()).filter(wanted).collect();
        if numbers.is_empty() {
            if reader.frames().damage().is_none() {
                outcome.notes.push(format!(
                    "{path}: no contacts were written at the times of these frames"
                ));
            }
            return Ok([false; 2]);
        }
        let mut list = self.series("contacts")?;
        let mut bridges = if has_bridges(reader) {
            Some(self.series("bridges")?)
        } else {
            None
        };
        for number in numbers {
            let mut frame = reader.frames().frame(number)?;
            let step = frame.step;
            let specs = reader.frames().schema().columns();
            if let Some((_, Some(ids))) = self.steps.get(&step) {
                keep_contacts(specs, &mut frame.columns, ids);
            }
            let centres = centres(run, step)?;
            let unfit = |reason| ExportError::Input(format!("{path}: {reason}"));
            if let Some(bridges) = &mut bridges {
                let mut wet = frame.clone();
                keep_bridges(specs, &mut wet.columns);
                let grid = paraview::contacts(specs, wet, &centres).map_err(unfit)?;
                bridges.write(number, &grid)?;
            }
            let grid = paraview::contacts(specs, frame, &centres).map_err(unfit)?;
            list.write(number, &grid)?;
        }
        Ok([true, bridges.is_some()])
    }

    /// The bonds at the steps of the particles; whether there are any.
    fn write_bonds(&self) -> Result<bool, ExportError> {
        let Some(reader) = self.beside.bonds else {
            return Ok(false);
        };
        let frames = reader.frames();
        let mut list = None;
        for number in 0..frames.len() {
            let step = frames.info(number).map(|info| info.step);
            let Some((particles, ids)) = step.and_then(|step| self.steps.get(&step)) else {
                continue;
            };
            let mut frame = frames.frame(number)?;
            if let Some(ids) = ids {
                keep_contacts(frames.schema().columns(), &mut frame.columns, ids);
            }
            let rows = reader.rows(frame);
            let rows = rows.map_err(|reason| unfit(frames.path(), number, &reason))?;
            let list = match &mut list {
                Some(list) => list,
                None => list.insert(self.series("bonds")?),
            };
            list.write(*particles, &paraview::bonds(&rows))?;
        }
        Ok(list.is_some())
    }

    /// The droplets in flight at the steps of the particles; whether there are any.
    fn write_droplets(&self) -> Result<bool, ExportError> {
        let Some(reader) = self.beside.droplets else {
            return Ok(false);
        };
        let frames = reader.frames();
        let mut list = None;
        for number in 0..frames.len() {
            let step = frames.info(number).map(|info| info.step);
            let Some((particles, _)) = step.and_then(|step| self.steps.get(&step)) else {
                continue;
            };
            let frame = frames.frame(number)?;
            let path = frames.path();
            let grid = paraview::particles(frames.schema().columns(), frame);
            let grid = grid.map_err(|reason| unfit(path, number, &reason))?;
            let list = match &mut list {
                Some(list) => list,
                None => list.insert(self.series("droplets")?),
            };
            list.write(*particles, &grid)?;
        }
        Ok(list.is_some())
    }

    /// The walls at the steps of the particles; whether there are any.
    fn write_walls(&self) -> Result<bool, ExportError> {
        let Some(reader) = self.beside.walls else {
            return Ok(false);
        };
        let mut list = None;
        let scene = WallScene {
            names: &reader.header().walls,
            surfaces: reader.surfaces(),
            domain: reader.header().domain.unwrap_or_default(),
        };
        for number in 0..reader.frames().len() {
            let step = reader.frames().info(number).map(|info| info.step);
            let Some((particles, _)) = step.and_then(|step| self.steps.get(&step)) else {
                continue;
            };
            let frame = reader.frame(number)?;
            let (path, loads) = triangle_loads(self.beside.loads, frame.step)?;
            let wear = worn_at(self.beside.wear, frame.step)?;
            let grid = paraview::walls(&scene, &frame, loads.as_ref(), wear.as_ref());
            let grid = grid.map_err(|reason| {
                let (path, step) = (path.display(), frame.step);
                ExportError::Input(format!("{path}: at step {step}: {reason}"))
            })?;
            let list = match &mut list {
                Some(list) => list,
                None => list.insert(self.series("walls")?),
            };
            list.write(*particles, &grid)?;
        }
        Ok(list.is_some())
    }

    /// The sheets at the steps of the particles; whether there are any.
    fn write_membranes(&self) -> Result<bool, ExportError> {
        let Some(tables) = self.beside.membranes else {
            return Ok(false);
        };
        let mut list = None;
        for info in tables.vertices.frames().infos() {
            let Some((particles, _)) = self.steps.get(&info.step) else {
                continue;
            };
            let Some((vertices, triangles)) = tables.at_step(info.step)? else {
                continue;
            };
            let grid = paraview::membranes(&vertices, &triangles).map_err(|reason| {
                let path = tables.triangles.frames().path().display();
                ExportError::Input(format!("{path}: at step {}: {reason}", info.step))
            })?;
            let list = match &mut list {
                Some(list) => list,
                None => list.insert(self.series("membranes")?),
            };
            list.write(*particles, &grid)?;
        }
        Ok(list.is_some())
    }

    /// Warnings of tables that end before the frames do.
    fn cut(&self) -> Vec<String> {
        let last = self.span.map(|(_, last)| last);
        let cut = |table: &FrameReader, what, lost| beside::cut(table, what, lost, last);
        let mut warnings = Vec::new();
        if let Some(reader) = self.beside.bodies {
            let lost = match self.choice.clumps {
                ClumpsAs::Pebbles => "later ones are left out",
                ClumpsAs::Surface => "later clumps are shown by their pebbles",
                ClumpsAs::Both => "surfaces of later clumps are left out",
            };
            warnings.extend(cut(reader.frames(), "bodies", lost));
        }
        if let Some(reader) = self.beside.contacts {
            let lost = "later ones are left out";
            warnings.extend(cut(reader.frames(), "contacts", lost));
        }
        if let Some(reader) = self.beside.bonds {
            let lost = "later ones are left out";
            warnings.extend(cut(reader.frames(), "bonds", lost));
        }
        if let Some(reader) = self.beside.droplets {
            let lost = "later ones are left out";
            warnings.extend(cut(reader.frames(), "droplets", lost));
        }
        if let Some(tables) = self.beside.membranes {
            let lost = "later ones are left out";
            warnings.extend(cut(tables.vertices.frames(), "membranes", lost));
            let what = "triangles of membranes";
            warnings.extend(cut(tables.triangles.frames(), what, lost));
        }
        if let Some(reader) = self.beside.walls {
            let lost = "walls are left out of later frames";
            warnings.extend(cut(reader.frames(), "walls", lost));
            if let Some(loads) = self.beside.loads {
                let lost = "later walls are without them";
                warnings.extend(cut(loads.frames(), "loads on triangles", lost));
            }
            if let Some(wear) = self.beside.wear {
                let lost = "later walls are as they were at the start";
                warnings.extend(cut(wear.frames(), "wear", lost));
            }
        }
        warnings
    }
}

impl Sink for Vtu<'_> {
    fn files(&self) -> Vec<PathBuf> {
        self.files.clone()
    }

    fn write(&mut self, mut snapshot: Snapshot) -> Result<(), ExportError> {
        let (time, number) = (snapshot.frame.time, snapshot.number);
        self.span = Some(self.span.map_or((time, time), |(first, _)| (first, time)));
        let ids = snapshot.column("id").and_then(Column::as_u32);
        let partial = self.job.selection.is_partial();
        let ids = partial.then(|| ids.unwrap_or_default().to_vec());
        self.steps.insert(snapshot.frame.step, (number, ids));
        if let Some(reader) = self.beside.bodies {
            bodies::add_clumps(reader, &mut snapshot)?;
        }
        self.write_bodies(&mut snapshot)?;
        if self.particles.is_none() && snapshot.frame.rows() == 0 {
            self.empty.push(snapshot);
            return Ok(());
        }
        self.write_particles(snapshot)
    }

    fn finish(mut self: Box<Self>, outcome: &mut Outcome) -> Result<Vec<PathBuf>, ExportError> {
        // Where surfaces stand for all particles there is nothing to list. Without particles in any frame the list holds the
        // times without any.
        if self.choice.clumps != ClumpsAs::Surface || self.clumps.is_none() {
            self.write_empty()?;
        }
        let [contacts, bridges] = self.write_contacts(outcome)?;
        let parts = ScriptParts {
            particles: self.particles.is_some(),
            contacts,
            bridges,
            bonds: self.write_bonds()?,
            droplets: self.write_droplets()?,
            walls: self.write_walls()?,
            bodies: self.bodies.is_some(),
            clumps: self.clumps.is_some(),
            membranes: self.write_membranes()?,
        };
        outcome.notes.extend(bodies::notes(self.beside.surfaces));
        let cut = self.cut();
        outcome.warnings.extend(self.warnings);
        outcome.warnings.extend(cut);
        let output = &self.job.output;
        let mut files = self.files;
        // A list that names no file is not written, and one of an earlier export is not of these frames.
        for (kind, was_asked, is_written) in [
            ("particles", true, parts.particles),
            ("contacts", self.beside.contacts.is_some(), parts.contacts),
            (
                "bridges",
                self.beside.contacts.is_some_and(has_bridges),
                parts.bridges,
            ),
            ("bonds", self.beside.bonds.is_some(), parts.bonds),
            ("droplets", self.beside.droplets.is_some(), parts.droplets),
            ("walls", self.beside.walls.is_some(), parts.walls),
            ("bodies", self.beside.bodies.is_some(), parts.bodies),
            ("clumps", self.beside.surfaces.is_some(), parts.clumps),
            (
                "membranes",
                self.beside.membranes.is_some(),
                parts.membranes,
            ),
        ] {
            if was_asked && !is_written {
                files.retain(|file| *file != output.path(&format!("{kind}.pvd")));
                output.clear_series(kind)?;
            }
        }
        let script = paraview::script(&output.prefix, parts);
        output.write(&output.path("paraview.py"), script.as_bytes())?;
        Ok(files)
    }
}

pub(super) fn run_of(source: &Source) -> Option<&RunSource> {
    match source {
        Source::Run(run) => Some(run.as_ref()),
        Source::Data(_) | Source::Lammps(_) => None,
    }
}

fn unfit(path: &Path, number: usize, reason: &str) -> ExportError {
    ExportError::Input(format!("{}: frame {number}: {reason}", path.display()))
}

/// Contacts may be written at other times than particles. A selection of a time span includes those too; a selection of frames or
/// particles includes the contacts of just these.
fn is_wanted(time: f64, beside: bool, span: Option<(f64, f64)>, selection: &Selection) -> bool {
    let within = span.is_some_and(|(first, last)| first <= time && time <= last);
    let every = matches!(
        selection.frames,
        FrameChoice::All | FrameChoice::Range { every: 1, .. }
    );
    beside || (within && every && !selection.is_partial())
}

/// Whether a table of contacts has those of liquid bridges.
fn has_bridges(contacts: &ContactReader) -> bool {
    contacts
        .frames()
        .schema()
        .index_of("bridge_volume")
        .is_some()
}

/// Leaves out contacts without a liquid bridge.
fn keep_bridges(specs: &[mercury_common::frames::ColumnSpec], columns: &mut [Column]) {
    let place = specs.iter().position(|spec| spec.name == "bridge_volume");
    let volumes = place.and_then(|place| columns[place].as_f64());
    let keep: Vec<bool> = volumes
        .unwrap_or_default()
        .iter()
        .map(|&volume| volume > 0.0)
        .collect();
    for column in columns {
        retain(column, &keep);
    }
}

/// Leaves out contacts or bonds of particles that are not selected.
fn keep_contacts(
    specs: &[mercury_common::frames::ColumnSpec],
    columns: &mut [Column],
    ids: &[u32],
) {
    let ids: HashSet<u32> = ids.iter().copied().collect();
    let place = |name: &str| specs.iter().position(|spec| spec.name == name);
    let (Some(i), Some(j)) = (place("i"), place("j")) else {
        return;
    };
    let (Column::U32(i), Column::OptionalU32(j)) = (&columns[i], &columns[j]) else {
        return;
    };
    let both = i.iter().zip(j);
    let keep: Vec<bool> = both
        .map(|(i, j)| ids.contains(i) && j.is_none_or(|j| ids.contains(&j)))
        .collect();
    for column in columns {
        retain(column, &keep);
    }
}

/// The loads on the triangles of walls at a step, none if the run did not write them, and their file.
fn triangle_loads(
    reader: Option<&TriangleLoadReader>,
    step: u64,
) -> Result<(PathBuf, Option<TriangleLoadFrame>), ExportError> {
    let Some(reader) = reader else {
        return Ok((PathBuf::new(), None));
    };
    let number = reader.frames().infos().position(|info| info.step == step);
    let frame = number.map(|number| reader.frame(number)).transpose()?;
    Ok((reader.frames().path().to_owned(), frame))
}

/// Positions by id in the particles' frame of a step; empty if there is none.
fn centres(run: &RunSource, step: u64) -> Result<HashMap<u32, DVec3>, ExportError> {
    let frames = run.particles();
    let mut infos = frames.infos();
    let Some(number) = infos.position(|info| info.step == step) else {
        return Ok(HashMap::new());
    };
    let columns = frames.columns(number, &["id", "x", "y", "z"])?;
    let positions = paraview::vectors(&columns, [1, 2, 3]).unwrap_or_default();
    let ids = columns[0].as_u32().unwrap_or_default();
    Ok(ids.iter().copied().zip(positions).collect())
}
