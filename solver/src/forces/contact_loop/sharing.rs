//! The blocks of one force evaluation, shared out to the threads of a pool.
//!
//! A block can be finished (what earlier blocks parked for it is added, and its particles move on) as soon as it and all
//! blocks that reach into it are computed, because those are all that read its records. So most blocks are finished
//! while they are still in the cache, as they are on a single thread, and the threads meet once per step.
//!
//! Which thread does what, and when, changes no number: every sum is made in the order of the blocks.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError, RwLock};

use super::found::Numbers;
use super::{Block, Pass, Rows};
use crate::contact::{AdhesionLaw, Histories, NormalLaw, RollingLaw, TangentialLaw};
use crate::forces::{Finish, MotionBound};
use crate::state::{Load, Particle};

/// How often a thread looks whether one of its blocks can be finished, before it leaves that to the thread that called. It
/// is enough for the others to compute a block, and not more than a nuisance where threads share a core.
const LOOKS: u32 = 10_000;

/// A block and its rows. No lock is ever waited for: nothing reads a block that is being computed, or records that are
/// being changed. They are there because the compiler cannot know.
struct Station<'a, H> {
    block: RwLock<&'a mut Block<H>>,
    records: RwLock<&'a mut [Particle]>,
    loads: Mutex<&'a mut [Load]>,
    /// The earlier blocks that reach into it, ascending.
    sources: &'a [usize],
    /// Blocks that read its records, itself among them, and are not computed yet.
    readers: AtomicUsize,
    finished: AtomicBool,
    fastest: Mutex<MotionBound>,
}

/// What a lock guards. A panic elsewhere ends the run anyway; until then nothing can be made worse.
macro_rules! locked {
    ($lock:expr) => {
        $lock.unwrap_or_else(PoisonError::into_inner)
    };
}

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> Pass<'_, N, T, R, A> {
    /// All blocks, by the threads of `pool`.
    pub(super) fn shared(
        &self,
        blocks: &mut [Block<Histories<N, T, R, A>>],
        sources: &[Vec<usize>],
        mut records: &mut [Particle],
        mut loads: &mut [Load],
        finish: &Finish<'_>,
        pool: &rayon::ThreadPool,
    ) -> MotionBound {
        let shares = Shares::new(blocks, pool.current_num_threads());
        let mut stations = Vec::with_capacity(blocks.len());
        for (block, sources) in blocks.iter_mut().zip(sources) {
            let (own_records, own_loads);
            (own_records, records) = records.split_at_mut(block.rows.len());
            (own_loads, loads) = loads.split_at_mut(block.rows.len());
            stations.push(Station {
                block: RwLock::new(block),
                records: RwLock::new(own_records),
                loads: Mutex::new(own_loads),
                sources,
                readers: AtomicUsize::new(sources.len() + 1),
                finished: AtomicBool::new(false),
                fastest: Mutex::new(MotionBound::default()),
            });
        }
        pool.broadcast(|thread| {
            // What this thread has computed and still has to finish: nobody else has it in the cache.
            let mut mine = Vec::new();
            let mut numbers = Numbers::new();
            let finish_ready = |mine: &mut Vec<usize>| {
                mine.retain(|&index| !finish_if_ready(&stations, index, finish));
            };
            while let Some(index) = shares.take(thread.index()) {
                self.compute_shared(&stations, index, &mut numbers);
                mine.push(index);
                finish_ready(&mut mine);
            }
            for _ in 0..LOOKS {
                if mine.is_empty() {
                    break;
                }
                std::hint::spin_loop();
                finish_ready(&mut mine);
            }
        });
        for index in 0..stations.len() {
            if !stations[index].finished.load(Ordering::Relaxed) {
                finish_if_ready(&stations, index, finish);
            }
        }
        let fastest = stations
            .into_iter()
            .map(|station| locked!(station.fastest.into_inner()));
        fastest.fold(MotionBound::default(), MotionBound::merge)
    }

    /// Computes the contacts of one block.
    fn compute_shared(
        &self,
        stations: &[Station<'_, Histories<N, T, R, A>>],
        index: usize,
        numbers: &mut Numbers,
    ) {
        let station = &stations[index];
        let mut block = locked!(station.block.write());
        let mut loads = locked!(station.loads.lock());
        {
            let own = locked!(station.records.read());
            let read = |&target: &usize| (target - index, locked!(stations[target].records.read()));
            let reached: Vec<_> = block.targets.iter().map(read).collect();
            let last = reached.last().map_or(0, |&(ahead, _)| ahead);
            let mut from_here: Vec<&[Particle]> = vec![&[]; last + 1];
            from_here[0] = &own;
            for (ahead, records) in &reached {
                from_here[*ahead] = records;
            }
            self.compute(
                &mut block,
                &Rows::apart(from_here, self.block_size),
                &mut loads,
                numbers,
            );
        }
        // Whoever finds no readers left sees all that was written before they counted themselves out.
        for &read in std::iter::once(&index).chain(&block.targets) {
            stations[read].readers.fetch_sub(1, Ordering::Release);
        }
    }
}

/// Adds what was parked for one block, and finishes it, if nobody needs its records any more.
fn finish_if_ready<H>(stations: &[Station<'_, H>], index: usize, finish: &Finish<'_>) -> bool {
    let station = &stations[index];
    if station.readers.load(Ordering::Acquire) > 0 {
        return false;
    }
    let mut loads = locked!(station.loads.lock());
    for &source in station.sources {
        let block = locked!(stations[source].block.read());
        block.outbox.deliver(index - source - 1, &mut loads);
    }
    let mut records = locked!(station.records.write());
    *locked!(station.fastest.lock()) = finish(index, &mut records, &loads);
    station.finished.store(true, Ordering::Relaxed);
    true
}

/// Runs of blocks, one for each thread: what a thread had in the last step may still be in its cache.
struct Shares {
    runs: Vec<Run>,
}

struct Run {
    begin: usize,
    end: usize,
    /// Blocks of the run that were taken.
    taken: AtomicUsize,
}

impl Shares {
    /// Runs of nearly the same work.
    fn new<H>(blocks: &[Block<H>], threads: usize) -> Self {
        let total: usize = blocks.iter().map(|block| block.work).sum();
        let (mut end, mut before) = (0, 0);
        let runs = (1..=threads).map(|thread| {
            let begin = end;
            // A block belongs to the run in which its middle lies.
            while end < blocks.len()
                && (2 * before + blocks[end].work) * threads < 2 * total * thread
            {
                before += blocks[end].work;
                end += 1;
            }
            Run {
                begin,
                end,
                taken: AtomicUsize::new(0),
            }
        });
        Self {
            runs: runs.collect(),
        }
    }

    /// The next block for a thread: of its own run, or else of another's that has more than one left. The last one is sooner
    /// done by the thread that knows it.
    fn take(&self, thread: usize) -> Option<usize> {
        let count = self.runs.len();
        (0..count).find_map(|k| {
            let run = &self.runs[(thread + k) % count];
            let blocks = run.end - run.begin;
            let least = if k == 0 { 1 } else { 2 };
            let take = |taken| (taken + least <= blocks).then_some(taken + 1);
            let taken = run
                .taken
                .fetch_update(Ordering::Relaxed, Ordering::Relaxed, take);
            // The last one first, because it keeps the next run waiting.
            taken.ok().map(|taken| match taken {
                0 => run.end - 1,
                _ => run.begin + taken - 1,
            })
        })
    }
}
