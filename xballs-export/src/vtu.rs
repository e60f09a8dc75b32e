//! For ParaView, pyvista and meshio: series of `.vtu` with a `.pvd` for each kind, and a script that opens them.
//!
//! Kinds: `particles`, `contacts` (as lines), `walls` (as triangles where they stand), `bodies` (centres of mass of clumps), `clumps` (their own
//! surfaces). A further kind is a further series.

use std::collections::{HashMap, HashSet};
use std::path::PathBuf;

use glam::DVec3;
use mercury_common::formats::vtu::{VtuError, VtuOptions};
use mercury_common::frames::{Column, FrameReader, TriangleLoadFrame, TriangleLoadReader};
use mercury_common::paraview::{self, ScriptParts, Series, WallScene};

use crate::beside;
use crate::bodies;
use crate::output::Output;
use crate::selection::retain;
use crate::source::RunSource;
use crate::{
    ClumpsAs, ExportError, FrameChoice, Selection, Snapshot, Source, Told, for_each_snapshot,
};

/// What goes into the files, and how.
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

/// Writes the series; `progress` hears of every frame. Returns what was read, and the files to open.
///
/// # Errors
/// When the input cannot be read, a list of an earlier export is in the way, or a file cannot be written.
pub fn export(
    source: &Source,
    selection: &Selection,
    output: &Output,
    choice: VtuChoice,
    mut progress: impl FnMut(&Snapshot),
) -> Result<(Told, Vec<PathBuf>), ExportError> {
    let run = match source {
        Source::Run(run) => Some(run.as_ref()),
        Source::Data(_) => None,
    };
    let mut warnings = Vec::new();
    let contact_reader = run
        .filter(|_| choice.contacts)
        .map(|run| run.contacts("--no-contacts leaves contacts out"))
        .transpose()?
        .flatten();
    let walled = run.filter(|_| choice.walls);
    let wall_reader = walled
        .map(|run| run.walls("--no-walls leaves walls out"))
        .transpose()?
        .flatten();
    let load_reader = walled
        .map(|run| run.triangle_loads("--no-walls leaves walls and the loads on them out"))
        .transpose()?
        .flatten();
    let body_reader = match bodies::reader(source, "--clumps pebbles shows what there is") {
        // Pebbles are whole without it.
        Err(error) if choice.clumps == ClumpsAs::Pebbles => {
            warnings.push(format!("bodies are left out\n{error}"));
            None
        }
        found => found?,
    };
    let surface_reader = bodies::reader_for(source, choice.clumps)?;
    let script = output.path("paraview.py");
    let mut files = vec![script.clone(), output.path("particles.pvd")];
    files.extend(contact_reader.map(|_| output.path("contacts.pvd")));
    files.extend(wall_reader.map(|_| output.path("walls.pvd")));
    files.extend(body_reader.map(|_| output.path("bodies.pvd")));
    files.extend(surface_reader.map(|_| output.path("clumps.pvd")));
    for file in &files {
        output.claim(file)?;
    }
    let series = |kind: &str| -> Result<Series, VtuError> {
        let stem = format!("{}.{kind}", output.prefix);
        Series::create(&output.folder, &stem, choice.options)
    };
    let mut particles: Option<Series> = None;
    let mut span: Option<(f64, f64)> = None;
    let mut steps = HashMap::new();
    let mut body_lists: Option<(Series, Option<Series>)> = None;
    let mut told = for_each_snapshot(source, selection, |mut snapshot| {
        let list = match &mut particles {
            Some(list) => list,
            // Only now, so that a wrong input leaves what is there.
            None => particles.insert(series("particles")?),
        };
        progress(&snapshot);
        let time = snapshot.frame.time;
        span = Some(span.map_or((time, time), |(first, _)| (first, time)));
        let ids = snapshot.column("id").and_then(Column::as_u32);
        let ids = selection
            .is_partial()
            .then(|| ids.unwrap_or_default().to_vec());
        let number = snapshot.number;
        steps.insert(snapshot.frame.step, (number, ids));
        let path = snapshot.path.clone();
        let unfit = |reason| {
            let path = path.display();
            ExportError::Input(format!("{path}: frame {number}: {reason}"))
        };
        if let Some(reader) = body_reader
            && let Some(shown) = bodies::at_step(reader, snapshot.frame.step, selection)?
        {
            let (bodies, clumps) = match &mut body_lists {
                Some(lists) => lists,
                None => {
                    let clumps = surface_reader.map(|_| series("clumps")).transpose()?;
                    body_lists.insert((series("bodies")?, clumps))
                }
            };
            if let Some(clumps) = clumps {
                let grid = paraview::clumps(reader.kinds(), &shown.frame);
                clumps.write(number, &grid)?;
            }
            if choice.clumps == ClumpsAs::Surface {
                shown.hide_pebbles(&mut snapshot);
            }
            let grid = paraview::particles(&shown.table.specs, shown.table.frame).map_err(unfit)?;
            bodies.write(number, &grid)?;
        }
        let grid = paraview::particles(&snapshot.specs, snapshot.frame).map_err(unfit)?;
        list.write(number, &grid)?;
        Ok(())
    })?;
    let last = span.map(|(_, last)| last);
    let cut = |table: &FrameReader, what, lost| beside::cut(table, what, lost, last);
    let mut parts = ScriptParts {
        bodies: body_lists.is_some(),
        clumps: body_lists.is_some_and(|(_, clumps)| clumps.is_some()),
        ..ScriptParts::default()
    };
    if let Some(reader) = body_reader {
        let lost = match choice.clumps {
            ClumpsAs::Pebbles => "later ones are left out",
            ClumpsAs::Surface => "later clumps are shown by their pebbles",
            ClumpsAs::Both => "surfaces of later clumps are left out",
        };
        warnings.extend(cut(reader.frames(), "bodies", lost));
    }
    if let (Some(reader), Some(run)) = (contact_reader, run) {
        warnings.extend(cut(reader.frames(), "contacts", "later ones are left out"));
        let wanted = |number: &usize| {
            let info = reader.frames().info(*number);
            info.is_some_and(|info| {
                let beside = steps.contains_key(&info.step);
                is_wanted(info.time, beside, span, selection)
            })
        };
        let numbers: Vec<usize> = (0..reader.frames().len()).filter(wanted).collect();
        let mut list = (!numbers.is_empty())
            .then(|| series("contacts"))
            .transpose()?;
        parts.contacts = list.is_some();
        if numbers.is_empty() && reader.frames().damage().is_none() {
            let path = reader.frames().path().display();
            told.notes.push(format!(
                "{path}: no contacts were written at the times of these frames"
            ));
        }
        for number in numbers {
            let mut frame = reader.frames().frame(number)?;
            let step = frame.step;
            let specs = reader.frames().schema().columns();
            if let Some((_, Some(ids))) = steps.get(&step) {
                keep_contacts(specs, &mut frame.columns, ids);
            }
            let centres = centres(run, step)?;
            let grid = paraview::contacts(specs, frame, &centres).map_err(|reason| {
                ExportError::Input(format!("{}: {reason}", reader.frames().path().display()))
            })?;
            if let Some(list) = &mut list {
                list.write(number, &grid)?;
            }
        }
    }
    if let Some(reader) = wall_reader {
        let lost = "walls are left out of later frames";
        warnings.extend(cut(reader.frames(), "walls", lost));
        if let Some(loads) = load_reader {
            let lost = "later walls are without them";
            warnings.extend(cut(loads.frames(), "loads on triangles", lost));
        }
        let mut list = None;
        let scene = WallScene {
            names: &reader.header().walls,
            surfaces: reader.surfaces(),
            domain: reader.header().domain.unwrap_or_default(),
        };
        for number in 0..reader.frames().len() {
            let step = reader.frames().info(number).map(|info| info.step);
            if let Some((particles, _)) = step.and_then(|step| steps.get(&step)) {
                let frame = reader.frame(number)?;
                let (path, loads) = triangle_loads(load_reader, frame.step)?;
                let grid = paraview::walls(&scene, &frame, loads.as_ref()).map_err(|reason| {
                    let (path, step) = (path.display(), frame.step);
                    ExportError::Input(format!("{path}: at step {step}: {reason}"))
                })?;
                let list = match &mut list {
                    Some(list) => list,
                    None => list.insert(series("walls")?),
                };
                list.write(*particles, &grid)?;
            }
        }
        parts.walls = list.is_some();
    }
    told.notes.extend(bodies::notes(surface_reader));
    told.warnings.extend(warnings);
    // A list that names no file is not written, and one of an earlier export is not of these frames.
    for (kind, was_asked, is_written) in [
        ("contacts", contact_reader.is_some(), parts.contacts),
        ("walls", wall_reader.is_some(), parts.walls),
        ("bodies", body_reader.is_some(), parts.bodies),
        ("clumps", surface_reader.is_some(), parts.clumps),
    ] {
        if was_asked && !is_written {
            files.retain(|file| *file != output.path(&format!("{kind}.pvd")));
            output.clear_series(kind)?;
        }
    }
    output.write(&script, paraview::script(&output.prefix, parts).as_bytes())?;
    Ok((told, files))
}

/// Contacts may be written at other times than particles. Whoever wants all frames of a span wants those too; whoever picks
/// frames or particles wants the contacts of just these.
fn is_wanted(time: f64, beside: bool, span: Option<(f64, f64)>, selection: &Selection) -> bool {
    let within = span.is_some_and(|(first, last)| first <= time && time <= last);
    let every = matches!(selection.frames, FrameChoice::All | FrameChoice::Range(..));
    beside || (within && every && !selection.is_partial())
}

/// Leaves out contacts of particles that are not selected.
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
