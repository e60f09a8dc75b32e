//! The thread that formats and writes, so that stepping need not wait for it.

use std::path::Path;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

use glam::DVec3;
use mercury_pictures::EnergyRow;

use super::body_frames::BodyFrames;
use super::contact_frames::ContactFrames;
use super::data_file::DataFile;
use super::ene_file::EneFile;
use super::fstat_file::FstatFile;
use super::particle_frames::ParticleFrames;
use super::region_counts::RegionCounts;
use super::stream::Stream;
use super::track_file::TrackFile;
use super::triangle_loads::TriangleLoads;
use super::vtk_files::VtkFiles;
use super::wall_frames::WallFrames;
use super::wall_loads::WallLoads;
use super::{Moment, OutputError, State, energies};
use crate::contact::HistoryNumber;
use crate::neighbours::Images;
use crate::plan::Plan;

/// States that may wait to be written before stepping has to.
const QUEUE: usize = 4;

/// A thread that writes what it is sent.
#[derive(Debug)]
pub struct Writer {
    sender: SyncSender<Moment>,
    thread: JoinHandle<Result<Written, OutputError>>,
}

/// What the writer saw pass by.
#[derive(Debug, Clone, PartialEq)]
pub struct Written {
    /// Energies of every frame.
    pub energies: Vec<EnergyRow>,
    /// Momentum of the first state, kg m/s.
    pub initial: DVec3,
    /// Frames in which some overlap exceeded a tenth of the smaller radius.
    pub deep_frames: u64,
    /// The largest overlap over the smaller radius in any of them.
    pub deepest: f64,
    /// The last state.
    pub last: Option<State>,
}

impl Writer {
    /// Makes the files that the plan asks for and starts the thread.
    ///
    /// # Errors
    /// If a file cannot be made, or no thread started.
    pub fn start(
        folder: &Path,
        plan: &Plan,
        history: &[HistoryNumber],
    ) -> Result<Self, OutputError> {
        let streams = streams(folder, plan, history)?;
        let images = Images::new(plan.domain_min, plan.domain_max, plan.periodic);
        let (gravity, dimensions) = (plan.gravity, plan.dimensions);
        let (sender, receiver) = sync_channel(QUEUE);
        let thread = std::thread::Builder::new()
            .name("output".to_owned())
            .spawn(move || write_all(receiver, streams, &images, gravity, dimensions))
            .map_err(|source| OutputError::File {
                path: folder.to_owned(),
                action: "the thread that writes cannot be started",
                source,
            })?;
        Ok(Self { sender, thread })
    }

    /// Hands over a state; waits only while the queue is full. False if the writer has given up: [`Writer::finish`] says why.
    #[must_use]
    pub fn send(&self, moment: Moment) -> bool {
        self.sender.send(moment).is_ok()
    }

    /// Waits until everything is written.
    ///
    /// # Errors
    /// The first error of the writer.
    pub fn finish(self) -> Result<Written, OutputError> {
        drop(self.sender);
        self.thread.join().unwrap_or(Err(OutputError::Lost))
    }
}

/// The files that the plan asks for.
fn streams(
    folder: &Path,
    plan: &Plan,
    history: &[HistoryNumber],
) -> Result<Vec<Box<dyn Stream>>, OutputError> {
    let output = &plan.output;
    let mut streams: Vec<Box<dyn Stream>> = Vec::new();
    if output.data {
        streams.push(Box::new(DataFile::create(folder, plan)?));
    }
    if output.ene {
        streams.push(Box::new(EneFile::create(folder, plan)?));
    }
    if output.fstat {
        streams.push(Box::new(FstatFile::create(folder, plan)?));
    }
    if output.frames {
        streams.push(Box::new(ParticleFrames::create(folder, plan)?));
    }
    if output.frames && !plan.walls.is_empty() {
        streams.push(Box::new(WallFrames::create(folder, plan)?));
    }
    if output.frames && plan.has_bodies() {
        streams.push(Box::new(BodyFrames::create(folder, plan)?));
    }
    if output.frames && output.triangle_loads {
        streams.push(Box::new(TriangleLoads::create(folder, plan)?));
    }
    if output.vtk {
        streams.push(Box::new(VtkFiles::create(folder, plan, history)?));
    }
    if output.frames && output.fstat {
        streams.push(Box::new(ContactFrames::create(folder, plan, history)?));
    }
    if !output.track.is_empty() {
        streams.push(Box::new(TrackFile::create(folder, plan)?));
    }
    if output.walls && !plan.walls.is_empty() {
        streams.push(Box::new(WallLoads::create(folder, plan)?));
    }
    if !plan.regions.is_empty() {
        streams.push(Box::new(RegionCounts::create(folder, plan)?));
    }
    Ok(streams)
}

/// The writer's thread: ends when the sender is gone, or with the first error.
fn write_all(
    receiver: Receiver<Moment>,
    mut streams: Vec<Box<dyn Stream>>,
    images: &Images,
    gravity: DVec3,
    dimensions: u8,
) -> Result<Written, OutputError> {
    let mut written = Written {
        energies: Vec::new(),
        initial: DVec3::ZERO,
        deep_frames: 0,
        deepest: 0.0,
        last: None,
    };
    for moment in receiver {
        let state = State::new(moment, images);
        for stream in &mut streams {
            stream.write(&state)?;
        }
        if written.last.is_none() {
            written.initial = state.mass_and_momentum().1;
        }
        if state.due.frame {
            let row = energies(&state, gravity, dimensions);
            written.energies.push(EnergyRow {
                time: row.time,
                kinetic: row.translational_kinetic,
                rotational: row.rotational_kinetic,
                gravitational: row.gravitational,
                elastic: row.elastic,
                dissipated: state.dissipated,
            });
        }
        let depth = state.observation.largest_overlap;
        written.deep_frames += u64::from(depth > 0.1);
        written.deepest = written.deepest.max(depth);
        written.last = Some(state);
    }
    Ok(written)
}
