//! Memory that is used again from frame to frame.

use std::fmt;

use super::layers::Rows;
use super::spread::Placed;
use crate::sums::Sums;

/// Memory in which a frame is evaluated, to be used again for the next one: the system takes its time to hand out what was given back to it, and
/// threads that need it wait for each other.
#[derive(Default)]
pub struct Scratch {
    /// One for each spread, in the order of [`SPREADS`](crate::sums::SPREADS).
    pub(super) spreads: [SpreadScratch; 5],
}

impl Scratch {
    /// Sums that are no longer needed: the next ones reuse their memory.
    pub fn take_back(&mut self, sums: Sums) {
        for (scratch, values) in self.spreads.iter_mut().zip(sums.values) {
            scratch.sums.buffers.keep(values);
        }
    }
}

impl fmt::Debug for Scratch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Scratch").finish_non_exhaustive()
    }
}

/// Memory in which one spread is evaluated.
#[derive(Default)]
pub(super) struct SpreadScratch {
    pub rows: Rows,
    pub placed: Vec<Placed>,
    pub spare: Vec<Placed>,
    pub sums: SumScratch,
}

/// Memory for sums at points.
#[derive(Default)]
pub(super) struct SumScratch {
    /// Sums of parts of the grid.
    pub parts: Vec<Vec<f64>>,
    /// Sums of all points.
    pub buffers: Buffers,
}

/// Lists of numbers that wait to be used again.
#[derive(Default)]
pub(super) struct Buffers(Vec<Vec<f64>>);

impl Buffers {
    /// Most that wait: as many as one spread has at the same time.
    const MOST: usize = 4;

    /// Buffer of so many zeros.
    pub(super) fn zeros(&mut self, length: usize) -> Vec<f64> {
        let mut buffer = self.taken(length);
        buffer.clear();
        buffer.resize(length, 0.0);
        buffer
    }

    /// A column of this many numbers with arbitrary values: the caller overwrites each of them.
    pub(super) fn any(&mut self, length: usize) -> Vec<f64> {
        let mut buffer = self.taken(length);
        buffer.resize(length, 0.0);
        buffer
    }

    /// The smallest that is large enough, or else the largest.
    fn taken(&mut self, length: usize) -> Vec<f64> {
        self.0.sort_unstable_by_key(Vec::capacity);
        let fits = self.0.partition_point(|buffer| buffer.capacity() < length);
        match self.0.len() {
            0 => Vec::new(),
            waiting => self.0.remove(fits.min(waiting - 1)),
        }
    }

    /// Returns the memory for the next use.
    pub(super) fn keep(&mut self, buffer: Vec<f64>) {
        if buffer.capacity() > 0 && self.0.len() < Self::MOST {
            self.0.push(buffer);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buffers_are_zero_and_come_again() {
        let mut buffers = Buffers::default();
        let mut first = buffers.zeros(100);
        first.fill(1.0);
        let at = first.as_ptr();
        buffers.keep(vec![7.0; 10]);
        buffers.keep(first);
        let again = buffers.zeros(50);
        assert!(again.as_ptr() == at && again == vec![0.0; 50]);
        assert_eq!(buffers.zeros(20), vec![0.0; 20]);
        buffers.keep(again);
        assert_eq!(buffers.any(70).len(), 70);
        for _ in 0..10 {
            buffers.keep(vec![0.0; 5]);
        }
        assert_eq!(buffers.0.len(), Buffers::MOST);
    }
}
