//! Several processes that compute one scene together, to the bytes of one process.
//!
//! A *rank* is a process of the job. Every rank has all rows under their numbers and computes those of its own run of blocks. Blocks, the order
//! of rows and every sum over blocks are those of one process, so that the number of ranks changes no bit.
//!
//! | in | is sent | between |
//! |---|---|---|
//! | each step | records of rows that a contact of another rank reads; shares of contacts for rows of later ranks; the largest speed | neighbours; all |
//! | each list | positions and velocities of all rows; histories of contacts that change their rank | all |
//! | looks, checkpoints | rows, reports and contacts | to the first rank |
//!
//! The first rank makes the run and writes its files; the others follow it, call by call. See `docs/theory/distribution.md`.

mod share;
mod threads;

pub use share::{Across, END, Share, Traffic};
pub use threads::Threads;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The ways in which ranks exchange bytes. All ranks make the same calls in the same order.
pub trait Ranks: Send {
    /// The number of this rank, and how many there are.
    fn place(&self) -> (usize, usize);

    /// Sends bytes to some ranks and receives those of others, which send some here in the same call: in the order of `from`.
    fn exchange(&mut self, to: Vec<(usize, Vec<u8>)>, from: &[usize]) -> Vec<Vec<u8>>;

    /// The bytes of all ranks, in their order.
    fn all(&mut self, own: Vec<u8>) -> Vec<Vec<u8>>;

    /// The bytes of all ranks, in their order, on the first one; nothing on the others.
    fn gather(&mut self, own: Vec<u8>) -> Vec<Vec<u8>>;

    /// The bytes of the first rank, on all of them.
    fn broadcast(&mut self, own: Vec<u8>) -> Vec<u8>;

    /// Replaces each number by the largest of all ranks. None may be NaN.
    fn largest(&mut self, numbers: &mut [f64]);

    /// Replaces each number by the sum over all ranks.
    fn add(&mut self, numbers: &mut [i64]);
}

/// Ranks that make several runs, one after the other: each has a handle.
pub type Team = Arc<Mutex<dyn Ranks>>;

/// The ranks, for one call.
pub fn of_team(team: &Team) -> MutexGuard<'_, dyn Ranks + 'static> {
    team.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Ranks for Team {
    fn place(&self) -> (usize, usize) {
        of_team(self).place()
    }

    fn exchange(&mut self, to: Vec<(usize, Vec<u8>)>, from: &[usize]) -> Vec<Vec<u8>> {
        of_team(self).exchange(to, from)
    }

    fn all(&mut self, own: Vec<u8>) -> Vec<Vec<u8>> {
        of_team(self).all(own)
    }

    fn gather(&mut self, own: Vec<u8>) -> Vec<Vec<u8>> {
        of_team(self).gather(own)
    }

    fn broadcast(&mut self, own: Vec<u8>) -> Vec<u8> {
        of_team(self).broadcast(own)
    }

    fn largest(&mut self, numbers: &mut [f64]) {
        of_team(self).largest(numbers);
    }

    fn add(&mut self, numbers: &mut [i64]) {
        of_team(self).add(numbers);
    }
}
