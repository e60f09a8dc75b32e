//! The thread that formats and writes, so that the time loop need not wait for it.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::thread::JoinHandle;

use glam::DVec3;
use mercury_common::whole_file::{FileError, WholeFile};
use mercury_pictures::{EnergyFlows, EnergyRow, SheetEnergies};
use rayon::ThreadPoolBuilder;

use super::budget::{BudgetRow, gap, is_closed, largest_term};
use super::chain::{self, CHAIN, ChainFile, ChainScene};
use super::field_tables::FieldTable;
use super::stream::{Beginning, Sink, Stream};
use super::{FrameCopy, OutputError, STREAMS, energies};
use crate::plan::{POSITIONS, Plan};
use mercury_engine::audit::Losses;
use mercury_engine::cell::Cell;
use mercury_engine::contact::HistoryNumber;
use mercury_engine::state::{Encoder, Piece, Plain};
use mercury_engine::task::{OutputFile, RunEvent, TaskProgress};

/// The number of states that may wait to be written before the time loop has to wait.
const QUEUE: usize = 4;

/// A thread that writes what it is sent.
#[derive(Debug)]
pub struct Writer {
    sender: SyncSender<Message>,
    /// Of checkpoints that are written.
    memory: Receiver<Vec<Piece>>,
    /// The way by which it comes.
    lent: Sender<Vec<Piece>>,
    thread: JoinHandle<Result<(Written, Option<ChainFile>), OutputError>>,
    /// The scene, for the chain.
    scene: Option<Arc<ChainScene>>,
}

/// Messages to the thread.
enum Message {
    /// Write what is due of this state.
    Write(Box<FrameCopy>),
    /// Say how far everything has come.
    Tell(SyncSender<Reported>),
    /// Sync all files to the disk, add their positions, and write this checkpoint.
    Checkpoint(Box<ToWrite>),
    /// Close all files as they are, and answer.
    LetGo(SyncSender<()>),
    /// Go on with these files and sums.
    GoOn(Box<(Files, RunningSums)>),
}

/// The positions of all files, and the growing files.
type Reported = (Positions, Vec<OutputFile>);

/// A checkpoint but for what the writer adds.
#[derive(Debug)]
pub struct ToWrite {
    /// Where to; `None`: only a link is made of it.
    pub path: Option<PathBuf>,
    /// Whether it is a link of the chain.
    pub is_link: bool,
    /// Steps made.
    pub step: u64,
    /// s
    pub time: f64,
    /// All but how far the outputs have come.
    pub state: Encoder,
}

/// The positions of a run's outputs: everything that a later continuation needs.
#[derive(Debug, Clone, PartialEq)]
pub struct Positions {
    /// Of each stream by its name: bytes of text files, frames of all others.
    streams: BTreeMap<String, u64>,
    sums: RunningSums,
    /// The memory of those streams that have any.
    memories: BTreeMap<String, Vec<u64>>,
}

impl Plain for Positions {
    fn put(&self, bytes: &mut Vec<u8>) {
        self.streams.put(bytes);
        self.sums.put(bytes);
        // Of most scenes nothing.
        if !self.memories.is_empty() {
            self.memories.put(bytes);
        }
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        Ok(Self {
            streams: Plain::take(bytes)?,
            sums: Plain::take(bytes)?,
            memories: if bytes.is_empty() {
                BTreeMap::new()
            } else {
                Plain::take(bytes)?
            },
        })
    }
}

/// The sums over all frames that were passed on.
#[derive(Debug, Clone, PartialEq, Default)]
struct RunningSums {
    energies: Vec<EnergyRow>,
    /// The largest term of the energy budget in any frame, J.
    largest_energy: f64,
    initial: Option<DVec3>,
    deep_frames: u64,
    deepest: f64,
}

impl Plain for RunningSums {
    fn put(&self, bytes: &mut Vec<u8>) {
        let energies: Vec<Saved<EnergyRow>> = self.energies.iter().cloned().map(Saved).collect();
        energies.put(bytes);
        self.largest_energy.put(bytes);
        self.initial.put(bytes);
        self.deep_frames.put(bytes);
        self.deepest.put(bytes);
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        let energies: Vec<Saved<EnergyRow>> = Plain::take(bytes)?;
        Ok(Self {
            energies: energies.into_iter().map(|Saved(row)| row).collect(),
            largest_energy: Plain::take(bytes)?,
            initial: Plain::take(bytes)?,
            deep_frames: Plain::take(bytes)?,
            deepest: Plain::take(bytes)?,
        })
    }
}

/// Energies as they are saved: all numbers, in the order of their fields.
struct Saved<T>(T);

/// Makes a struct of numbers [`Plain`] as [`Saved`]; behind the numbers may stand one that is perhaps there (`maybe`), or one that
/// always is (`and`).
macro_rules! saved {
    ($name:ident { $($field:ident),* } $(maybe $maybe:ident)? $(and $nested:ident)?) => {
        impl Plain for Saved<$name> {
            fn put(&self, bytes: &mut Vec<u8>) {
                $(self.0.$field.put(bytes);)*
                $(self.0.$maybe.clone().map(Saved).put(bytes);)?
                $(Saved(self.0.$nested).put(bytes);)?
            }

            fn take(bytes: &mut &[u8]) -> Result<Self, String> {
                Ok(Self($name {
                    $($field: Plain::take(bytes)?,)*
                    $($maybe: <Option<Saved<_>> as Plain>::take(bytes)?.map(|Saved(value)| value),)?
                    $($nested: Saved::take(bytes)?.0,)?
                }))
            }
        }
    };
}

saved!(EnergyRow { time, kinetic, rotational, gravitational, elastic } maybe flows);
saved!(EnergyFlows { dissipated, wall_work, servo_work, inserted, deleted, deleted_elastic, vanished_walls } and sheets);
saved!(SheetEnergies {
    kinetic,
    gravitational,
    stretching,
    bending,
    dissipated,
    pressure_work,
    hold_work
});

impl Positions {
    /// Frames of energies so far.
    #[must_use]
    pub fn frames(&self) -> usize {
        self.sums.energies.len()
    }

    /// Whether two states of a run wrote as much: the same files but its chain, and the same sums. Means of fields are not compared.
    #[must_use]
    pub fn is_alike(&self, other: &Self) -> bool {
        let files = |of: &Self| -> Vec<(String, u64)> {
            let files = of.streams.iter().filter(|(name, _)| *name != CHAIN);
            files.map(|(name, at)| (name.clone(), *at)).collect()
        };
        files(self) == files(other) && self.sums == other.sums
    }

    /// How far each output had come, by its name: bytes of text files, frames of all others.
    #[must_use]
    pub fn streams(&self) -> &BTreeMap<String, u64> {
        &self.streams
    }
}

/// Values that the writer collected.
#[derive(Debug, Clone, PartialEq)]
pub struct Written {
    /// Energies of every frame.
    pub energies: Vec<EnergyRow>,
    /// Energies of the last state and their budget, which a run that was stopped writes to no file.
    pub at_end: Option<BudgetRow>,
    /// Momentum of the first state, kg m/s.
    pub initial: DVec3,
    /// Frames in which some overlap exceeded a tenth of the smaller radius.
    pub deep_frames: u64,
    /// The largest overlap over the smaller radius in any frame.
    pub deepest: f64,
    /// The last state.
    pub last: Option<FrameCopy>,
}

impl Writer {
    /// Makes the files of the plan, or continues them `from` the positions of an interrupted run at a step and a time (s), and starts the thread.
    /// `history` and `losses` name what contacts remember and what takes energy. With a `scene` it writes a chain.
    ///
    /// # Errors
    /// If a file cannot be made or continued, or no thread started.
    pub fn start(
        folder: &Path,
        plan: &Plan,
        (history, losses): (&[HistoryNumber], &Losses),
        from: Option<(Positions, u64, f64)>,
        scene: Option<Arc<ChainScene>>,
        task_progress: &Arc<TaskProgress>,
    ) -> Result<Self, OutputError> {
        let positions = from.as_ref().map(|(positions, ..)| positions);
        let streams = streams(folder, plan, (history, losses), positions)?;
        let chain = scene.as_ref().map(|scene| {
            let at = from.as_ref().and_then(|(positions, step, time)| {
                Some((*positions.streams.get(CHAIN)?, *step, *time))
            });
            ChainFile::begin(folder, plan, &scene.stated, at)
        });
        let files = Files {
            streams,
            chain: chain.transpose()?,
        };
        let sums = from.map_or_else(RunningSums::default, |(positions, ..)| positions.sums);
        let cell = plan.physics().cell;
        let accounting = Accounting {
            gravity: plan.physics().gravity,
            dimensions: plan.physics().dimensions,
            is_closed: is_closed(plan.physics()),
        };
        let (sender, receiver) = sync_channel(QUEUE);
        let (spent, memory) = channel();
        let lent = spent.clone();
        let watched = Watched {
            folder: folder.to_owned(),
            task_progress: Arc::clone(task_progress),
            reported: Vec::new(),
        };
        let thread = std::thread::Builder::new()
            .name("output".to_owned())
            .spawn(move || write_all(receiver, files, sums, &cell, accounting, &spent, watched))
            .map_err(FileError::of(
                folder,
                "the thread that writes cannot be started",
            ))?;
        Ok(Self {
            sender,
            lent,
            memory,
            thread,
            scene,
        })
    }

    /// Passes a state to the writer; waits only while the queue is full. False if the writer has given up: [`Writer::finish`]
    /// gives the reason.
    #[must_use]
    pub fn send(&self, moment: FrameCopy) -> bool {
        self.sender.send(Message::Write(Box::new(moment))).is_ok()
    }

    /// The positions of the files once everything passed on is written; `None` if the writer has given up: [`Writer::finish`]
    /// gives the reason.
    #[must_use]
    pub fn positions(&self) -> Option<Positions> {
        self.reported().map(|(positions, _)| positions)
    }

    /// Positions of the files, and the files that grow.
    #[must_use]
    pub fn reported(&self) -> Option<(Positions, Vec<OutputFile>)> {
        let (answer, reported) = sync_channel(1);
        self.sender.send(Message::Tell(answer)).ok()?;
        reported.recv().ok()
    }

    /// Cuts the files back to earlier positions, those of a step and its time (s), and goes on behind them.
    ///
    /// # Errors
    /// If a file cannot be cut, or the writer has given up.
    pub fn go_back(
        &self,
        folder: &Path,
        plan: &Plan,
        (history, losses): (&[HistoryNumber], &Losses),
        (to, step, time): (&Positions, u64, f64),
    ) -> Result<(), OutputError> {
        let (answer, closed) = sync_channel(1);
        let lost = |_| OutputError::Lost;
        let sent = self.sender.send(Message::LetGo(answer));
        sent.map_err(|_| OutputError::Lost)?;
        closed.recv().map_err(lost)?;
        let streams = streams(folder, plan, (history, losses), Some(to))?;
        let at = to
            .streams
            .get(CHAIN)
            .map(|position| (*position, step, time));
        let scene = self.scene.as_ref().filter(|_| at.is_some());
        let chain = scene.map(|scene| ChainFile::begin(folder, plan, &scene.stated, at));
        let files = Files {
            streams,
            chain: chain.transpose()?,
        };
        let message = Message::GoOn(Box::new((files, to.sums.clone())));
        self.sender.send(message).map_err(|_| OutputError::Lost)
    }

    /// Keeps the memory of a state that is not written for the first checkpoint.
    pub fn lend_memory(&self, state: Encoder) {
        let _ = self.lent.send(state.into_memory());
    }

    /// The memory of a written checkpoint, for the next one; empty if there is none yet.
    #[must_use]
    pub fn spent_memory(&self) -> Vec<Piece> {
        self.memory.try_iter().last().unwrap_or_default()
    }

    /// Passes a checkpoint to the writer, which writes it once everything passed on before is on the disk, with the positions as
    /// its last section. False if the writer has given up.
    #[must_use]
    pub fn write_checkpoint(&self, checkpoint: ToWrite) -> bool {
        let message = Message::Checkpoint(Box::new(checkpoint));
        self.sender.send(message).is_ok()
    }

    /// Waits until everything is written; the chain has no end yet.
    ///
    /// # Errors
    /// The first error of the writer.
    pub fn finish(self) -> Result<(Written, Option<ChainFile>), OutputError> {
        drop(self.sender);
        self.thread.join().unwrap_or(Err(OutputError::Lost))
    }
}

/// A stream, and the name by which its position is stored.
type Named = (String, Box<dyn Stream>);

/// The files of a run.
struct Files {
    streams: Vec<Named>,
    chain: Option<ChainFile>,
}

impl Files {
    /// Brings them to the disk.
    fn sync(&self) -> Result<(), OutputError> {
        for (_, stream) in &self.streams {
            stream.sink().sync()?;
        }
        self.chain.iter().try_for_each(|chain| chain.file().sync())
    }

    /// The growing files that promise equal bytes on any machine, for the chain: all but fields, which are means.
    fn linked(&self) -> Vec<OutputFile> {
        let is_linked = |(name, _): &&Named| !name.starts_with(FieldTable::BEGIN);
        let linked = self.streams.iter().filter(is_linked);
        linked
            .filter_map(|(_, stream)| stream.sink().file())
            .collect()
    }

    /// Appends the link of a state; the file for its checkpoint, if that is to stay.
    fn link(&mut self, checkpoint: &ToWrite) -> Result<Option<PathBuf>, OutputError> {
        let linked = self.linked();
        let Some(chain) = &mut self.chain else {
            return Ok(None);
        };
        let state = chain::sum_of(&checkpoint.state);
        chain.link(checkpoint.step, checkpoint.time, state, &linked)?;
        Ok(chain.to_keep()?)
    }
}

/// The files of the plan.
fn streams(
    folder: &Path,
    plan: &Plan,
    (history, losses): (&[HistoryNumber], &Losses),
    from: Option<&Positions>,
) -> Result<Vec<Named>, OutputError> {
    let beginning = |name: &str| Beginning {
        folder,
        plan,
        history,
        losses,
        // One that the interrupted run did not have begins anew.
        at: from.and_then(|from| from.streams.get(name).copied()),
    };
    let mut streams: Vec<Named> = Vec::new();
    for kind in STREAMS.iter().filter(|kind| (kind.is_wanted)(plan)) {
        let stream = (kind.begin)(&beginning(kind.name))?;
        streams.push((kind.name.to_owned(), stream));
    }
    let fields = &plan.outputs().files().fields;
    if !fields.is_empty() {
        let cannot = FileError::of(folder, "the thread that computes fields cannot be started");
        let pool = ThreadPoolBuilder::new().num_threads(1).build();
        let pool = Arc::new(pool.map_err(|error| cannot(io::Error::other(error)))?);
        for (index, fields) in fields.iter().enumerate() {
            let name = FieldTable::ending(fields);
            let memory = from.and_then(|from| from.memories.get(&name));
            let table =
                FieldTable::begin(&beginning(&name), index, memory.map(Vec::as_slice), &pool)?;
            streams.push((name, Box::new(table)));
        }
    }
    Ok(streams)
}

/// The writer's thread: ends when the sender is gone, or with the first error.
fn write_all(
    receiver: Receiver<Message>,
    mut files: Files,
    mut sums: RunningSums,
    cell: &Cell,
    accounting: Accounting,
    spent: &Sender<Vec<Piece>>,
    mut watched: Watched,
) -> Result<(Written, Option<ChainFile>), OutputError> {
    let mut last = None;
    let mut at_end = None;
    for message in receiver {
        match message {
            Message::Write(moment) => {
                // So that memory holds one state, not the last one beside the next.
                drop(last.take());
                let mut state = moment.in_order_of_ids(cell);
                let budget = sums.take_in(&state, &accounting);
                state.budget = (budget.energies.flows.is_some()).then(|| budget.clone());
                at_end = Some(budget);
                for (_, stream) in &mut files.streams {
                    stream.write(&state)?;
                }
                watched.tell_of(&state, &mut files);
                // They are written, and as large as all particles together.
                state.observation.records = Vec::new();
                last = Some(state);
            }
            Message::Tell(answer) => {
                // The receiver may have been dropped.
                let _ = answer.send((positions(&files, &sums), growing(&files)));
            }
            Message::LetGo(answer) => {
                files.streams.clear();
                files.chain = None;
                let _ = answer.send(());
            }
            Message::GoOn(anew) => {
                (files, sums) = *anew;
                (last, at_end) = (None, None);
            }
            Message::Checkpoint(checkpoint) => {
                let kept = match checkpoint.is_link {
                    true => files.link(&checkpoint)?,
                    false => None,
                };
                let ToWrite {
                    path,
                    step,
                    time,
                    mut state,
                    ..
                } = *checkpoint;
                if path.is_none() && kept.is_none() {
                    // The receiver may have been dropped.
                    let _ = spent.send(state.into_memory());
                    continue;
                }
                files.sync()?;
                state.section(POSITIONS, &positions(&files, &sums));
                let pieces = state.finish_in_pieces();
                // One that stays comes first: a run goes on from the other, and makes no earlier one again.
                for path in kept.iter().chain(&path) {
                    let mut file = WholeFile::create(path)?;
                    for piece in &pieces {
                        file.append(&piece.bytes)?;
                    }
                    file.finish()?;
                }
                if let (Some(_), Some(chain)) = (kept, &files.chain) {
                    chain.thin_out()?;
                }
                if let Some(path) = path.filter(|_| watched.task_progress.has_receiver()) {
                    let bytes = pieces.iter().map(|piece| piece.bytes.len() as u64).sum();
                    watched.task_progress.report(RunEvent::Checkpoint {
                        step,
                        time,
                        file: watched.file(&path, bytes),
                        outputs: growing(&files),
                    });
                }
                let _ = spent.send(pieces);
            }
        }
    }
    let linked = files.linked();
    if let Some(chain) = &mut files.chain {
        chain.note(&linked);
    }
    for (_, stream) in &mut files.streams {
        stream.close()?;
    }
    let written = Written {
        energies: sums.energies,
        at_end,
        initial: sums.initial.unwrap_or_default(),
        deep_frames: sums.deep_frames,
        deepest: sums.deepest,
        last,
    };
    Ok((written, files.chain))
}

fn positions(files: &Files, sums: &RunningSums) -> Positions {
    let streams = &files.streams;
    let chain = files.chain.iter();
    let chain = chain.map(|chain| (CHAIN.to_owned(), chain.file().position()));
    Positions {
        streams: (streams.iter())
            .map(|(name, stream)| (name.clone(), stream.sink().position()))
            .chain(chain)
            .collect(),
        sums: sums.clone(),
        memories: (streams.iter())
            .filter_map(|(name, stream)| Some((name.clone(), stream.memory()?)))
            .collect(),
    }
}

/// The growing files, in the order of the plan.
fn growing(files: &Files) -> Vec<OutputFile> {
    let chain = files.chain.iter();
    let chain = chain.filter_map(|chain| Sink::Text(chain.file()).file());
    let streams = files.streams.iter();
    let streams = streams.filter_map(|(_, stream)| stream.sink().file());
    streams.chain(chain).collect()
}

/// The observer of the run, and what was reported to it.
struct Watched {
    folder: PathBuf,
    task_progress: Arc<TaskProgress>,
    /// The growing files at the last report.
    reported: Vec<OutputFile>,
}

impl Watched {
    /// A file of the run by its name in the folder.
    fn file(&self, path: &Path, bytes: u64) -> OutputFile {
        let name = path.strip_prefix(&self.folder).unwrap_or(path);
        OutputFile {
            name: name.to_string_lossy().into_owned(),
            bytes,
        }
    }

    /// Reports what was written of a state.
    fn tell_of(&mut self, state: &FrameCopy, files: &mut Files) {
        if !self.task_progress.has_receiver() {
            return;
        }
        let all = growing(files);
        let is_new = |file: &&OutputFile| !self.reported.contains(file);
        let mut outputs: Vec<OutputFile> = all.iter().filter(is_new).cloned().collect();
        for path in files
            .streams
            .iter_mut()
            .flat_map(|(_, stream)| stream.made())
        {
            // It is on the disk and is not removed.
            let bytes = std::fs::metadata(&path).map_or(0, |file| file.len());
            outputs.push(self.file(&path, bytes));
        }
        self.reported = all;
        self.task_progress.report(RunEvent::Written {
            step: state.step,
            time: state.time,
            outputs,
        });
    }
}

/// The quantities that the energies of a state need.
struct Accounting {
    /// m/s^2
    gravity: DVec3,
    dimensions: u8,
    /// Whether the energy budget can close.
    is_closed: bool,
}

impl Accounting {
    /// The energies of a state.
    fn row(&self, state: &FrameCopy) -> EnergyRow {
        let row = energies(state, self.gravity, self.dimensions);
        EnergyRow {
            time: row.time,
            kinetic: row.translational_kinetic,
            rotational: row.rotational_kinetic,
            gravitational: row.gravitational,
            elastic: row.elastic,
            flows: state.flows.clone(),
        }
    }
}

impl RunningSums {
    /// Takes in a state, and gives its energies with their budget.
    fn take_in(&mut self, state: &FrameCopy, accounting: &Accounting) -> BudgetRow {
        self.initial
            .get_or_insert_with(|| state.mass_and_momentum().1);
        let row = accounting.row(state);
        let first = self.energies.first().unwrap_or(&row);
        let largest = self.largest_energy.max(largest_term(&row, first));
        let gap = gap(&row, first, largest).filter(|_| accounting.is_closed);
        if state.due.frame {
            self.energies.push(row.clone());
            self.largest_energy = largest;
            let depth = state.observation.largest_overlap;
            self.deep_frames += u64::from(depth > 0.1);
            self.deepest = self.deepest.max(depth);
        }
        BudgetRow { energies: row, gap }
    }
}
