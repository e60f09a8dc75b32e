//! The distribution of the blocks of one force evaluation over the threads of a pool.
//!
//! A block can be finished (what earlier blocks parked for it is added, and its particles move on) as soon as it and all
//! blocks that reach into it are computed, because those are all that read its records. So most blocks are finished
//! while they are still in the cache, as they are on a single thread, and the threads meet once per step.
//!
//! No step waits for a thread that has not arrived yet. On a busy machine a thread may get its next time slice only after
//! milliseconds, and a step takes microseconds; so the blocks of an absent thread are computed by the others.
//!
//! Which thread does what, and when, changes no number: every sum is made in the order of the blocks.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError, RwLock};
use std::time::{Duration, Instant};

use super::across::{parked_for_ranks, take_parked};
use super::block::Block;
use super::contact_batch::BatchColumns;
use super::pass::{Pass, Rows, waits};
use crate::contact::{AdhesionLaw, Histories, NormalLaw, RollingLaw, TangentialLaw};
use crate::forces::blocks::Source;
use crate::forces::{Finish, MotionBound};
use crate::parallel::each_part_by;
use crate::ranks::Across;
use crate::state::{Load, Particle};

/// How long an idle thread checks whether one of its own blocks can be finished, before it leaves that to the calling thread; and
/// how long the calling thread checks whether the others are done, before it yields its core: as long again as it has computed,
/// which is about what the others need, within these limits. The lower limit is the time to wake a thread, the upper one more
/// than the time of a block.
const PATIENCE: [Duration; 2] = [Duration::from_micros(20), Duration::from_micros(500)];
/// The number of pauses between two checks.
const PAUSES: u32 = 4;

/// A block and its rows. No thread ever waits for a lock: nothing reads a block that is being computed, or records that are being
/// changed. The locks only prove this to the
/// compiler.
struct Station<'a, H> {
    block: RwLock<&'a mut Block<H>>,
    records: RwLock<&'a mut [Particle]>,
    loads: Mutex<&'a mut [Load]>,
    /// The earlier blocks that reach into it, ascending.
    sources: &'a [Source],
    /// Blocks that read its records, itself among them, and are not computed yet.
    readers: AtomicUsize,
    finished: AtomicBool,
    fastest: Mutex<MotionBound>,
}

/// The content of a lock. A panic elsewhere ends the run anyway, so a poisoned lock is ignored.
macro_rules! locked {
    ($lock:expr) => {
        $lock.unwrap_or_else(PoisonError::into_inner)
    };
}

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> Pass<'_, N, T, R, A> {
    /// The blocks of this rank, by the threads of `pool`.
    pub(super) fn shared(
        &self,
        blocks: &mut [Block<Histories<N, T, R, A>>],
        own: Range<usize>,
        sources: &[Vec<Source>],
        mut records: &mut [Particle],
        mut loads: &mut [Load],
        finish: &Finish<'_>,
        across: Option<Across<'_>>,
        pool: &rayon::ThreadPool,
    ) -> MotionBound {
        let shares = Shares::new(&blocks[own.clone()], pool.current_num_threads());
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
                // Those of earlier ranks read it for themselves; what they have for it comes when all blocks are computed.
                readers: AtomicUsize::new(
                    sources.partition_point(|source| source.block < own.end)
                        - sources.partition_point(|source| source.block < own.start)
                        + 1
                        + usize::from(waits(sources, &own)),
                ),
                finished: AtomicBool::new(false),
                fastest: Mutex::new(MotionBound::default()),
            });
        }
        let work = |thread: usize| {
            shares.begin(thread);
            let begun = Instant::now();
            // Blocks that this thread has computed and still has to finish: no other thread has them in its cache.
            let mut mine = Vec::new();
            let mut numbers = BatchColumns::new();
            let finish_ready = |mine: &mut Vec<usize>| {
                mine.retain(|&index| !finish_if_ready(&stations, index, finish));
            };
            while let Some(index) = shares.take(thread) {
                let index = own.start + index;
                self.compute_shared(&stations, index, &mut numbers);
                mine.push(index);
                finish_ready(&mut mine);
            }
            let patience = Patience::after(begun.elapsed());
            patience.look(|| {
                finish_ready(&mut mine);
                mine.is_empty()
            });
            patience
        };
        by_all_threads(pool, &work);
        for index in own.clone() {
            if !stations[index].finished.load(Ordering::Relaxed) {
                finish_if_ready(&stations, index, finish);
            }
        }
        if let Some(mut across) = across {
            exchange_parked(&stations, own.clone(), &mut across);
            let waiting = own.filter(|&index| waits(stations[index].sources, &across.own()));
            each_part_by(Some(pool), waiting, |index| {
                stations[index].readers.fetch_sub(1, Ordering::Release);
                finish_if_ready(&stations, index, finish);
            });
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
        numbers: &mut BatchColumns,
    ) {
        let station = &stations[index];
        let mut block = locked!(station.block.write());
        let mut loads = locked!(station.loads.lock());
        {
            let own = locked!(station.records.read());
            let targets = block.outbox.targets.iter();
            let reached =
                targets.map(|to| (to.rows.start, locked!(stations[to.block].records.read())));
            let reached: Vec<_> = reached.collect();
            let records = reached.iter().map(|(start, records)| (*start, &***records));
            let rows = Rows::apart(&own, records.collect());
            self.compute(&mut block, &rows, &mut loads, numbers);
        }
        // A thread that reads a count of zero sees everything that the readers wrote before they decremented it.
        let targets = block.outbox.targets.iter().map(|target| target.block);
        for read in std::iter::once(index).chain(targets) {
            stations[read].readers.fetch_sub(1, Ordering::Release);
        }
    }
}

/// Exchanges what blocks have parked for blocks of other ranks.
fn exchange_parked<H>(stations: &[Station<'_, H>], own: Range<usize>, across: &mut Across<'_>) {
    let parked = {
        let own: Vec<_> = (stations[own].iter())
            .map(|station| locked!(station.block.read()))
            .collect();
        parked_for_ranks(across, own.iter().map(|block| &***block))
    };
    let came = (across.exchange)(parked);
    for (rank, bytes) in came.iter().enumerate().take(across.rank) {
        let shells = &stations[across.cut[rank]..across.cut[rank + 1]];
        let mut shells: Vec<_> = (shells.iter())
            .map(|station| locked!(station.block.write()))
            .collect();
        take_parked(shells.iter_mut().map(|block| &mut ***block), bytes);
    }
}

/// Calls a function on each thread of the pool that is free, with the number of the thread. Not generic, so that it is compiled once for all laws.
fn by_all_threads(pool: &rayon::ThreadPool, work: &(dyn Fn(usize) -> Patience + Sync)) {
    let others = AtomicUsize::new(0);
    let this_thread = || rayon::current_thread_index().unwrap_or_default();
    pool.scope(|scope| {
        for _ in 1..pool.current_num_threads() {
            // When this thread is done, it takes back the blocks that no other thread has taken, and finds nothing left to do in them.
            scope.spawn(|_| {
                others.fetch_add(1, Ordering::Relaxed);
                work(this_thread());
                others.fetch_sub(1, Ordering::Release);
            });
        }
        work(this_thread()).look(|| others.load(Ordering::Acquire) == 0);
    });
}

/// Adds what was parked for one block, and finishes the block if its records are no longer needed.
fn finish_if_ready<H>(stations: &[Station<'_, H>], index: usize, finish: &Finish<'_>) -> bool {
    let station = &stations[index];
    if station.readers.load(Ordering::Acquire) > 0 {
        return false;
    }
    let mut loads = locked!(station.loads.lock());
    for source in station.sources {
        let block = locked!(stations[source.block].block.read());
        block.outbox.deliver(source.target, &mut loads);
    }
    let mut records = locked!(station.records.write());
    *locked!(station.fastest.lock()) = finish(index, &mut records, &loads);
    station.finished.store(true, Ordering::Relaxed);
    true
}

/// The time that a thread keeps checking.
#[derive(Debug, Clone, Copy)]
struct Patience(Duration);

impl Patience {
    /// The patience of a thread that has computed for this time.
    fn after(computed: Duration) -> Self {
        let [least, most] = PATIENCE;
        Self(computed.clamp(least, most))
    }

    /// Checks until `is_over`, or until its time is over.
    fn look(self, mut is_over: impl FnMut() -> bool) {
        if is_over() {
            return;
        }
        let begun = Instant::now();
        while begun.elapsed() < self.0 {
            for _ in 0..PAUSES {
                std::hint::spin_loop();
            }
            if is_over() {
                return;
            }
        }
    }
}

/// Runs of blocks, one for each thread: the data of a thread's last step may still be in its cache.
struct Shares {
    runs: Vec<Run>,
}

struct Run {
    begin: usize,
    end: usize,
    /// Blocks of the run that were taken.
    taken: AtomicUsize,
    /// The thread of the run has arrived.
    is_attended: AtomicBool,
}

impl Shares {
    /// Makes runs of nearly the same amount of work.
    fn new<H>(blocks: &[Block<H>], threads: usize) -> Self {
        Self::of(blocks.iter().map(|block| block.work).collect(), threads)
    }

    /// Shares for the given work of each block.
    fn of(works: Vec<usize>, threads: usize) -> Self {
        let total: usize = works.iter().sum();
        let (mut end, mut before) = (0, 0);
        let runs = (1..=threads).map(|thread| {
            let begin = end;
            // A block belongs to the run in which its middle lies.
            while end < works.len() && (2 * before + works[end]) * threads < 2 * total * thread {
                before += works[end];
                end += 1;
            }
            Run {
                begin,
                end,
                taken: AtomicUsize::new(0),
                is_attended: AtomicBool::new(false),
            }
        });
        Self {
            runs: runs.collect(),
        }
    }

    /// Marks that a thread has arrived at its run.
    fn begin(&self, thread: usize) {
        self.runs[thread].is_attended.store(true, Ordering::Relaxed);
    }

    /// The next block for a thread: from its own run; or from another run with more than one block left, as the last one is done
    /// sooner by the thread that has it in its cache; or from a run whose thread has not arrived.
    fn take(&self, thread: usize) -> Option<usize> {
        let count = self.runs.len();
        (0..count).find_map(|k| {
            let run = &self.runs[(thread + k) % count];
            let blocks = run.end - run.begin;
            let is_known = k > 0 && run.is_attended.load(Ordering::Relaxed);
            let least = if is_known { 2 } else { 1 };
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Three threads, of which the last one does not come: its blocks are done by the others, and each thread that is there does
    /// its own last block.
    #[test]
    fn blocks_of_an_absent_thread_are_done_by_the_others() {
        let shares = Shares::of(vec![1; 12], 3);
        shares.begin(0);
        shares.begin(1);
        let taken: Vec<usize> = std::iter::from_fn(|| shares.take(0)).collect();
        assert_eq!(taken, [3, 0, 1, 2, 7, 4, 5, 11, 8, 9, 10]);
        assert_eq!(shares.take(1), Some(6));
        assert_eq!(shares.take(1), None);
        // A thread that comes now is too late.
        shares.begin(2);
        assert_eq!(shares.take(2), None);
    }

    /// Waiting for something that never comes ends in time; what is there already is seen at once.
    #[test]
    fn patience_ends() {
        let mut looks = 0;
        Patience::after(Duration::ZERO).look(|| {
            looks += 1;
            true
        });
        assert_eq!(looks, 1);
        Patience::after(Duration::from_secs(3600)).look(|| false);
    }
}
