//! The one way from frames to files. The driver reads (the next frame while the last one is written), selects, reports its
//! progress, makes sure that nothing is in the way, and hands frame after frame to a [`Sink`], which writes.

use std::path::PathBuf;
use std::sync::mpsc::sync_channel;

use mercury_common::error::FormatError;
use mercury_common::frames::Column;
use mercury_common::plausible;

use crate::output::Output;
use crate::source::Frames;
use crate::{ExportError, Selection, Snapshot, Source, Table};

/// An export that is set up: where from, what of it, and where to.
#[derive(Debug)]
pub struct Job {
    /// The input.
    pub source: Source,
    /// Frames and rows that are exported.
    pub selection: Selection,
    /// The folder for the files.
    pub output: Output,
}

/// Result of an export of frames.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Outcome {
    /// Frames that were given out.
    pub frames: usize,
    /// Damage of the rest of the input.
    pub damage: Option<FormatError>,
    /// Frames that are in the files: fewer than `frames` in a film strip.
    pub written: usize,
    /// Commands for the written files, in lines to copy.
    pub to_copy: String,
    /// Notes for the user.
    pub notes: Vec<String>,
    /// Warnings for the user: something requested is not in the files.
    pub warnings: Vec<String>,
}

/// A kind of output. It states its needs and writes the frames that it is given.
pub trait Sink {
    /// The table of the run whose frames it takes.
    fn table(&self) -> Table {
        Table::Particles
    }

    /// The files whose names are known before anything is read; nothing is written while one of them is in the way.
    fn files(&self) -> Vec<PathBuf> {
        Vec::new()
    }

    /// Whether it has to [look](Self::look) at all frames before the first is written. The input is read twice then.
    fn looks_first(&self) -> bool {
        false
    }

    /// A frame of the first reading.
    ///
    /// # Errors
    /// When the frame has not what the output needs.
    fn look(&mut self, _: &Snapshot) -> Result<(), ExportError> {
        Ok(())
    }

    /// A frame to be written, in order; there is at least one.
    ///
    /// # Errors
    /// When the frame has not what the output needs, or a file cannot be written.
    fn write(&mut self, snapshot: Snapshot) -> Result<(), ExportError>;

    /// Completes the files and returns those that a user opens. `outcome` is the report of the export, and may be added to.
    ///
    /// # Errors
    /// When a file cannot be written.
    fn finish(self: Box<Self>, outcome: &mut Outcome) -> Result<Vec<PathBuf>, ExportError>;
}

/// Writes the frames of a job; `progress` hears the number of each before it is written. A damaged input gives its good
/// frames, and what is wrong in [`Outcome::damage`].
///
/// # Errors
/// When the input cannot be read, no frame is selected, a file of an earlier export is in the way, or the error of the sink.
pub fn export(
    job: &Job,
    mut sink: Box<dyn Sink + '_>,
    mut progress: impl FnMut(usize),
) -> Result<(Outcome, Vec<PathBuf>), ExportError> {
    for file in sink.files() {
        job.output.claim(&file)?;
    }
    let frames = Frames::of(&job.source, sink.table(), &job.selection)?;
    if sink.looks_first() {
        read(&frames, &job.selection, |snapshot| sink.look(&snapshot))?;
    }
    let (is_foreign, mut units) = (matches!(job.source, Source::Lammps(_)), None);
    let mut outcome = read(&frames, &job.selection, |snapshot| {
        progress(snapshot.number);
        if is_foreign && units.is_none() {
            units = forgotten_units(&snapshot);
        }
        sink.write(snapshot)
    })?;
    outcome.notes.extend(units);
    let files = sink.finish(&mut outcome)?;
    Ok((outcome, files))
}

/// A note on a frame of another code, whose numbers look as if they were in other units than SI.
fn forgotten_units(snapshot: &Snapshot) -> Option<String> {
    let numbers = |name: &str| match snapshot.column(name) {
        Some(Column::F64(numbers)) => Some(&numbers[..]),
        _ => None,
    };
    let radii = numbers("radius")?;
    let largest = radii.iter().copied().fold(0.0, f64::max);
    let masses = numbers("mass").zip(numbers("volume"));
    let densities = masses.into_iter().flat_map(|(masses, volumes)| {
        (masses.iter().zip(volumes)).map(|(mass, volume)| mass / volume)
    });
    let size = snapshot
        .header
        .domain
        .map(|(low, high)| (high - low).max_element());
    let note = plausible::forgotten_units(Some(2.0 * largest), densities, size)?;
    Some(format!("{}: {note}", snapshot.path.display()))
}

/// Gives the selected frames with the selected rows to `take`, in order, one after the other; a thread reads ahead by one frame.
fn read(
    frames: &Frames<'_>,
    selection: &Selection,
    mut take: impl FnMut(Snapshot) -> Result<(), ExportError>,
) -> Result<Outcome, ExportError> {
    let mut outcome = Outcome::default();
    let (mut before, mut after) = (0, 0);
    std::thread::scope(|scope| {
        let (sender, receiver) = sync_channel(1);
        scope.spawn(move || {
            for item in frames.chosen(selection.frames) {
                // The receiver is gone after an error of its own.
                if sender.send(item).is_err() {
                    break;
                }
            }
        });
        for item in receiver {
            match item {
                Ok(mut snapshot) => {
                    before += snapshot.frame.rows();
                    selection.apply(&mut snapshot)?;
                    after += snapshot.frame.rows();
                    take(snapshot)?;
                    outcome.frames += 1;
                }
                Err(damage) => outcome.damage = Some(damage),
            }
        }
        Ok::<(), ExportError>(())
    })?;
    if before > 0 && after == 0 {
        let one = frames.table().one();
        outcome
            .warnings
            .push(format!("no {one} is selected in any frame"));
    }
    outcome.written = outcome.frames;
    match (outcome.frames, outcome.damage) {
        (0, Some(damage)) => Err(damage.into()),
        (0, None) => Err(ExportError::Input(frames.none())),
        (_, damage) => Ok(Outcome { damage, ..outcome }),
    }
}
