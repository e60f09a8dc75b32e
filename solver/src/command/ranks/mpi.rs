//! Ranks that are processes of MPI: the only file that names the crate.

use mpi::collective::{CommunicatorCollectives, Root, SystemOperation};
use mpi::datatype::PartitionMut;
use mpi::environment::Universe;
use mpi::point_to_point::{Destination, Source};
use mpi::topology::{Communicator, SimpleCommunicator};
use mpi::{Count, Threading};

use mercury_engine::ranks::Ranks;

/// Most bytes of a message: counts of MPI are whole numbers of 32 bits.
const PIECE: usize = 1 << 30;

/// A process of a job of MPI.
pub(super) struct Mpi {
    world: SimpleCommunicator,
    /// MPI ends with it.
    _universe: Universe,
}

// SAFETY: MPI was initialised so that any thread may call it as long as no two do it at once. All calls need `&mut self`, or no communication
// (`place`), so no two are made at once. The universe ends MPI when it is dropped, which the owner does on the thread that has begun it.
unsafe impl Send for Mpi {}

impl Mpi {
    /// Joins the job that a launcher has begun; once in a process.
    ///
    /// # Errors
    /// If the installation of MPI cannot be used from several threads, one at a time.
    pub(super) fn join() -> Result<Self, String> {
        let Some((universe, threading)) = mpi::initialize_with_threading(Threading::Serialized)
        else {
            return Err("MPI was begun before".to_owned());
        };
        if threading < Threading::Serialized {
            return Err(format!(
                "this installation of MPI allows calls of the first thread alone ({threading:?}); calls of one thread at a time are needed (MPI_THREAD_SERIALIZED)"
            ));
        }
        Ok(Self {
            world: universe.world(),
            _universe: universe,
        })
    }

    /// Number of ranks on this machine, and whether the first of all is among them; all ranks call it.
    pub(super) fn on_this_machine(&self) -> (usize, bool) {
        let here = self.world.split_shared(0);
        let (own, mut lowest) = (self.world.rank(), 0);
        here.all_reduce_into(&own, &mut lowest, SystemOperation::min());
        (here.size() as usize, lowest == 0)
    }

    /// Ends all ranks at once.
    pub(super) fn abort(code: i32) -> ! {
        SimpleCommunicator::world().abort(code)
    }

    /// Lengths of the bytes of all ranks.
    fn lengths(&self, own: usize) -> Vec<u64> {
        let mut lengths = vec![0; self.world.size() as usize];
        self.world.all_gather_into(&(own as u64), &mut lengths[..]);
        lengths
    }
}

/// A message in pieces, the last of which is shorter than the others.
fn pieces(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    let whole = bytes.len() / PIECE;
    (0..=whole).map(|k| &bytes[k * PIECE..bytes.len().min((k + 1) * PIECE)])
}

impl Ranks for Mpi {
    fn place(&self) -> (usize, usize) {
        (self.world.rank() as usize, self.world.size() as usize)
    }

    fn exchange(&mut self, to: Vec<(usize, Vec<u8>)>, from: &[usize]) -> Vec<Vec<u8>> {
        let pieces: Vec<(usize, &[u8])> = (to.iter())
            .flat_map(|(rank, bytes)| pieces(bytes).map(|piece| (*rank, piece)))
            .collect();
        let mut came = Vec::with_capacity(from.len());
        mpi::request::multiple_scope(pieces.len(), |scope, requests| {
            for &(rank, piece) in &pieces {
                let process = self.world.process_at_rank(rank as i32);
                requests.add(process.immediate_send(scope, piece));
            }
            for &rank in from {
                let process = self.world.process_at_rank(rank as i32);
                let mut bytes = process.receive_vec::<u8>().0;
                let mut last = bytes.len();
                while last == PIECE {
                    let more = process.receive_vec::<u8>().0;
                    last = more.len();
                    bytes.extend(more);
                }
                came.push(bytes);
            }
            requests.wait_all(&mut Vec::new());
        });
        came
    }

    fn all(&mut self, own: Vec<u8>) -> Vec<Vec<u8>> {
        let lengths = self.lengths(own.len());
        let total: u64 = lengths.iter().sum();
        let rank = self.world.rank() as usize;
        if total as usize >= PIECE {
            // Rank by rank, in pieces.
            let of_rank = |(from, &length): (usize, &u64)| {
                let mut bytes = match from == rank {
                    true => own.clone(),
                    false => vec![0; length as usize],
                };
                let root = self.world.process_at_rank(from as i32);
                bytes
                    .chunks_mut(PIECE)
                    .for_each(|piece| root.broadcast_into(piece));
                bytes
            };
            return lengths.iter().enumerate().map(of_rank).collect();
        }
        let counts: Vec<Count> = lengths.iter().map(|&length| length as Count).collect();
        let mut ends = Vec::with_capacity(counts.len());
        let starts: Vec<Count> = (counts.iter())
            .scan(0, |end, count| {
                let start = *end;
                *end += count;
                ends.push(*end as usize);
                Some(start)
            })
            .collect();
        let mut bytes = vec![0u8; total as usize];
        if total > 0 {
            let mut parts = PartitionMut::new(&mut bytes[..], &counts[..], &starts[..]);
            self.world.all_gather_varcount_into(&own[..], &mut parts);
        }
        let part = |(&start, &end): (&Count, &usize)| bytes[start as usize..end].to_vec();
        starts.iter().zip(&ends).map(part).collect()
    }

    fn gather(&mut self, own: Vec<u8>) -> Vec<Vec<u8>> {
        let (rank, count) = self.place();
        if rank > 0 {
            self.exchange(vec![(0, own)], &[]);
            return Vec::new();
        }
        let others: Vec<usize> = (1..count).collect();
        let mut all = vec![own];
        all.extend(self.exchange(Vec::new(), &others));
        all
    }

    fn broadcast(&mut self, own: Vec<u8>) -> Vec<u8> {
        let root = self.world.process_at_rank(0);
        let mut length = own.len() as u64;
        root.broadcast_into(&mut length);
        let mut bytes = match self.world.rank() {
            0 => own,
            _ => vec![0; length as usize],
        };
        bytes
            .chunks_mut(PIECE)
            .for_each(|piece| root.broadcast_into(piece));
        bytes
    }

    fn largest(&mut self, numbers: &mut [f64]) {
        let own = numbers.to_vec();
        self.world
            .all_reduce_into(&own[..], numbers, SystemOperation::max());
    }

    fn add(&mut self, numbers: &mut [i64]) {
        let own = numbers.to_vec();
        self.world
            .all_reduce_into(&own[..], numbers, SystemOperation::sum());
    }
}
