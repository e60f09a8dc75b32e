//! `<prefix>.fields.NAME.csv`: fields of the continuum, by the code of `mercury-cg`, without frames being stored.

use std::io::ErrorKind;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use mercury_cg::CgError;
use mercury_cg::analysis::Course;
use mercury_cg::input::{check, state_of};
use mercury_cg::output::push_table;
use mercury_common::frames::{ContactColumns, FramesHeader};
use mercury_common::whole_file::{FileError, write_whole};
use rayon::ThreadPool;

use super::body_frames::BodyTable;
use super::contact_frames::{contact_columns, contact_frame};
use super::particle_frames::{ParticleTable, frames_header};
use super::stream::{Beginning, Sink, Stream, TextFile};
use super::{FrameCopy, OutputError};
use crate::plan::FieldPlan;

/// The interval between two files of a growing mean, by the clock, for users who watch it. The last one is written at the end.
const PAUSE: Duration = Duration::from_secs(10);

pub(super) struct FieldTable {
    plan: FieldPlan,
    /// Its bit in what is due.
    bit: u64,
    file: Table,
    header: FramesHeader,
    particles: ParticleTable,
    bodies: Option<BodyTable>,
    /// Nothing where no field follows from contacts.
    contacts: Option<ContactColumns>,
    /// In s.
    time_step: f64,
    /// One thread, beside those that step.
    pool: Arc<ThreadPool>,
    course: Course,
}

/// The file.
enum Table {
    /// A block for each sample, or each smoothed mean, one after the other.
    Blocks(TextFile),
    /// The mean so far, which replaces the one before.
    Mean {
        path: PathBuf,
        /// The time at which it was written, and whether there was a sample since.
        written: Option<Instant>,
        is_behind: bool,
    },
}

impl FieldTable {
    /// Beginning of the endings of all such files.
    pub(super) const BEGIN: &str = "fields.";

    /// Ending of the file of an entry; by this name checkpoints store how far it has come.
    pub(super) fn ending(fields: &FieldPlan) -> String {
        format!("{}{}.csv", Self::BEGIN, fields.name)
    }

    /// The table of the plan's `index`-th entry; continues from the memory of an interrupted run.
    pub(super) fn begin(
        run: &Beginning<'_>,
        index: usize,
        memory: Option<&[u64]>,
        pool: &Arc<ThreadPool>,
    ) -> Result<Self, OutputError> {
        let plan = run.plan;
        let fields = &plan.outputs().files().fields[index];
        let ending = Self::ending(fields);
        let course = match memory {
            None => Course::default(),
            Some(memory) => Course::remembering(&fields.analysis, memory).ok_or_else(|| {
                let found = format!(
                    "the checkpoint remembers other fields than `{}`",
                    fields.name
                );
                CgError::Input(format!("{found}\nhelp: begin anew with --force"))
            })?,
        };
        let file = if fields.is_mean() {
            let path = run.folder.join(run.name(&ending));
            if course.frames() == 0 {
                // Of samples after the checkpoint, which may not come again.
                let removed = std::fs::remove_file(&path);
                let removed = removed.or_else(|error| match error.kind() {
                    ErrorKind::NotFound => Ok(()),
                    _ => Err(error),
                });
                removed.map_err(FileError::of(&path, "the file cannot be removed"))?;
            }
            Table::Mean {
                path,
                written: None,
                is_behind: course.frames() > 0,
            }
        } else {
            Table::Blocks(run.text(&ending, b"")?)
        };
        Ok(Self {
            plan: fields.clone(),
            bit: 1 << index,
            file,
            header: frames_header(plan),
            particles: ParticleTable::new(plan),
            bodies: plan.physics().has_bodies().then(|| BodyTable::new(plan)),
            contacts: (fields.needs_contacts()).then(|| contact_columns(plan, run.history)),
            time_step: plan.physics().time_step,
            pool: Arc::clone(pool),
            course,
        })
    }

    /// The state in the form in which coarse-graining reads it from frames.
    fn state(&self, state: &FrameCopy) -> Result<mercury_cg::state::State, CgError> {
        let particles = self.particles.frame(state);
        let bodies = self.bodies.as_ref().map(|table| table.frame(state));
        let contacts = (self.contacts.as_ref()).map(|columns| contact_frame(state, columns));
        let particles = (&self.particles.columns, &particles);
        let found = state_of(&self.header, particles, bodies.as_ref(), contacts.as_ref())
            .map_err(CgError::Input)?;
        check(&found, &self.plan.name)?;
        Ok(found)
    }

    /// Writes the mean so far.
    fn write_mean(&mut self) -> Result<(), OutputError> {
        let Table::Mean {
            path,
            written,
            is_behind,
        } = &mut self.file
        else {
            return Ok(());
        };
        let analysis = &self.plan.analysis;
        if let Some(block) = self.course.mean(analysis) {
            let mut out = Vec::new();
            push_table(&mut out, analysis, &block, true, false);
            write_whole(path, &out)?;
        }
        *written = Some(Instant::now());
        *is_behind = false;
        Ok(())
    }
}

impl Stream for FieldTable {
    fn write(&mut self, state: &FrameCopy) -> Result<(), OutputError> {
        let looks = self.plan.looks_at(state.time, self.time_step);
        if state.due.fields & self.bit == 0 || !looks {
            return Ok(());
        }
        let found = self.state(state)?;
        let (analysis, course, file) = (&self.plan.analysis, &mut self.course, &mut self.file);
        let pool = &self.pool;
        match file {
            Table::Blocks(file) => {
                let mut first = file.position() == 0;
                let out = &mut file.buffer;
                pool.install(|| {
                    course.add(analysis, found, |block| {
                        push_table(out, analysis, &block, first, true);
                        first = false;
                        Ok(())
                    })
                })?;
                file.flush()
            }
            Table::Mean {
                written, is_behind, ..
            } => {
                pool.install(|| course.add(analysis, found, |_| Ok(())))?;
                *is_behind = true;
                if written.is_none_or(|written| written.elapsed() >= PAUSE) {
                    self.write_mean()?;
                }
                Ok(())
            }
        }
    }

    fn sink(&self) -> Sink<'_> {
        match &self.file {
            Table::Blocks(file) => Sink::Text(file),
            // It is made anew from what is remembered.
            Table::Mean { .. } => Sink::Whole(0),
        }
    }

    fn memory(&self) -> Option<Vec<u64>> {
        Some(self.course.memory())
    }

    fn close(&mut self) -> Result<(), OutputError> {
        match self.file {
            Table::Mean {
                is_behind: true, ..
            } => self.write_mean(),
            Table::Mean { .. } => Ok(()),
            // Smoothed means that no further sample completes. A resumed run removes them again.
            Table::Blocks(ref mut file) => {
                let course = std::mem::take(&mut self.course);
                let analysis = &self.plan.analysis;
                course.finish(analysis, |block| {
                    let first = file.position() == 0 && file.buffer.is_empty();
                    push_table(&mut file.buffer, analysis, &block, first, true);
                    Ok(())
                })?;
                file.flush()
            }
        }
    }
}
