//! The thread that formats and writes, so that stepping need not wait for it.

use std::path::Path;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

use glam::DVec3;
use mercury_common::whole_file::FileError;
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
    sender: SyncSender<Message>,
    thread: JoinHandle<Result<Written, OutputError>>,
}

/// What the thread is told.
#[derive(Debug)]
enum Message {
    /// Write what is due of this state.
    Write(Box<Moment>),
    /// Say how far everything has come.
    Tell(SyncSender<Positions>),
    /// Go back there.
    CutBack(Positions),
}

/// How far the outputs of a run have come: all that must be kept to cut them back later.
#[derive(Debug, Clone, PartialEq)]
pub struct Positions {
    /// Of each stream, in the order in which the plan asks for them.
    streams: Vec<u64>,
    sums: RunningSums,
}

/// The sums over all states that were handed over.
#[derive(Debug, Clone, PartialEq)]
struct RunningSums {
    energies: Vec<EnergyRow>,
    initial: Option<DVec3>,
    deep_frames: u64,
    deepest: f64,
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
        let images = plan.physics().images();
        let (gravity, dimensions) = (plan.physics().gravity(), plan.physics().dimensions());
        let (sender, receiver) = sync_channel(QUEUE);
        let thread = std::thread::Builder::new()
            .name("output".to_owned())
            .spawn(move || write_all(receiver, streams, &images, gravity, dimensions))
            .map_err(FileError::of(
                folder,
                "the thread that writes cannot be started",
            ))?;
        Ok(Self { sender, thread })
    }

    /// Hands over a state; waits only while the queue is full. False if the writer has given up: [`Writer::finish`] says why.
    #[must_use]
    pub fn send(&self, moment: Moment) -> bool {
        self.sender.send(Message::Write(Box::new(moment))).is_ok()
    }

    /// How far the files have come once all that was handed over is written; `None` if the writer has given up:
    /// [`Writer::finish`] says why.
    #[must_use]
    pub fn positions(&self) -> Option<Positions> {
        let (answer, told) = sync_channel(1);
        self.sender.send(Message::Tell(answer)).ok()?;
        told.recv().ok()
    }

    /// Cuts all files back to where they were, as if nothing had been written since. False if the writer has given up.
    #[must_use]
    pub fn cut_back(&self, positions: Positions) -> bool {
        self.sender.send(Message::CutBack(positions)).is_ok()
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
    let output = plan.outputs().files();
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
    if output.frames && !plan.physics().walls().is_empty() {
        streams.push(Box::new(WallFrames::create(folder, plan)?));
    }
    if output.frames && plan.physics().has_bodies() {
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
    if output.walls && !plan.physics().walls().is_empty() {
        streams.push(Box::new(WallLoads::create(folder, plan)?));
    }
    if !plan.outputs().regions().is_empty() {
        streams.push(Box::new(RegionCounts::create(folder, plan)?));
    }
    Ok(streams)
}

/// The writer's thread: ends when the sender is gone, or with the first error.
fn write_all(
    receiver: Receiver<Message>,
    mut streams: Vec<Box<dyn Stream>>,
    images: &Images,
    gravity: DVec3,
    dimensions: u8,
) -> Result<Written, OutputError> {
    let mut sums = RunningSums {
        energies: Vec::new(),
        initial: None,
        deep_frames: 0,
        deepest: 0.0,
    };
    let mut last = None;
    for message in receiver {
        match message {
            Message::Write(moment) => {
                // Memory holds one state, not the last one beside the next.
                drop(last.take());
                let mut state = State::new(*moment, images);
                for stream in &mut streams {
                    stream.write(&state)?;
                }
                sums.take_in(&state, gravity, dimensions);
                // They are written, and as large as all particles together.
                state.observation.records = Vec::new();
                last = Some(state);
            }
            Message::Tell(answer) => {
                let positions = Positions {
                    streams: streams.iter().map(|stream| stream.position()).collect(),
                    sums: sums.clone(),
                };
                // Whoever asked may not want to know any more.
                let _ = answer.send(positions);
            }
            Message::CutBack(positions) => {
                for (stream, position) in streams.iter_mut().zip(positions.streams) {
                    stream.cut_back(position)?;
                }
                sums = positions.sums;
                last = None;
            }
        }
    }
    Ok(Written {
        energies: sums.energies,
        initial: sums.initial.unwrap_or_default(),
        deep_frames: sums.deep_frames,
        deepest: sums.deepest,
        last,
    })
}

impl RunningSums {
    fn take_in(&mut self, state: &State, gravity: DVec3, dimensions: u8) {
        self.initial
            .get_or_insert_with(|| state.mass_and_momentum().1);
        if state.due.frame {
            let row = energies(state, gravity, dimensions);
            self.energies.push(EnergyRow {
                time: row.time,
                kinetic: row.translational_kinetic,
                rotational: row.rotational_kinetic,
                gravitational: row.gravitational,
                elastic: row.elastic,
                dissipated: state.dissipated,
            });
        }
        let depth = state.observation.largest_overlap;
        self.deep_frames += u64::from(depth > 0.1);
        self.deepest = self.deepest.max(depth);
    }
}
