//! Ranks that are threads of one process, for tests.

use std::sync::mpsc::{Receiver, Sender, channel};

use super::Ranks;

/// A rank that is a thread; messages go through channels.
pub struct Threads {
    number: usize,
    /// To each rank.
    to: Vec<Sender<Vec<u8>>>,
    /// From each rank.
    from: Vec<Receiver<Vec<u8>>>,
}

impl Threads {
    /// So many ranks, each for a thread of its own.
    #[must_use]
    pub fn team(count: usize) -> Vec<Self> {
        let ends = (0..count).map(|_| (0..count).map(|_| channel()).unzip());
        let ends: Vec<(Vec<_>, Vec<_>)> = ends.collect();
        // `receivers[a][b]` gets what `senders[a][b]` sends: from `a` to `b`.
        let (senders, receivers): (Vec<_>, Vec<_>) = ends.into_iter().unzip();
        let mut from: Vec<Vec<_>> = (0..count).map(|_| Vec::new()).collect();
        for of_sender in receivers {
            for (to, receiver) in of_sender.into_iter().enumerate() {
                from[to].push(receiver);
            }
        }
        let ranks = senders.into_iter().zip(from).enumerate();
        ranks
            .map(|(number, (to, from))| Self { number, to, from })
            .collect()
    }

    /// Sends bytes. A rank that has ended in disorder ends the others.
    fn send(&self, to: usize, bytes: Vec<u8>) {
        assert!(self.to[to].send(bytes).is_ok(), "rank {to} has ended");
    }

    fn receive(&self, from: usize) -> Vec<u8> {
        match self.from[from].recv() {
            Ok(bytes) => bytes,
            Err(_) => panic!("rank {from} has ended"),
        }
    }

    /// Numbers of all ranks, merged into `numbers`.
    fn reduce<const N: usize, T: Copy>(
        &mut self,
        numbers: &mut [T],
        put: impl Fn(T) -> [u8; N],
        take: impl Fn([u8; N]) -> T,
        merge: impl Fn(T, T) -> T,
    ) {
        let own = numbers.iter().flat_map(|&number| put(number)).collect();
        let all = self.all(own);
        for (rank, bytes) in all.iter().enumerate() {
            if rank != self.number {
                for (number, &bytes) in numbers.iter_mut().zip(bytes.as_chunks().0) {
                    *number = merge(*number, take(bytes));
                }
            }
        }
    }
}

impl Ranks for Threads {
    fn place(&self) -> (usize, usize) {
        (self.number, self.to.len())
    }

    fn exchange(&mut self, to: Vec<(usize, Vec<u8>)>, from: &[usize]) -> Vec<Vec<u8>> {
        for (rank, bytes) in to {
            self.send(rank, bytes);
        }
        from.iter().map(|&rank| self.receive(rank)).collect()
    }

    fn all(&mut self, own: Vec<u8>) -> Vec<Vec<u8>> {
        for rank in 0..self.to.len() {
            self.send(rank, own.clone());
        }
        (0..self.from.len())
            .map(|rank| self.receive(rank))
            .collect()
    }

    fn gather(&mut self, own: Vec<u8>) -> Vec<Vec<u8>> {
        self.send(0, own);
        match self.number {
            0 => (0..self.from.len())
                .map(|rank| self.receive(rank))
                .collect(),
            _ => Vec::new(),
        }
    }

    fn broadcast(&mut self, own: Vec<u8>) -> Vec<u8> {
        if self.number == 0 {
            for rank in 1..self.to.len() {
                self.send(rank, own.clone());
            }
            return own;
        }
        self.receive(0)
    }

    fn largest(&mut self, numbers: &mut [f64]) {
        self.reduce(numbers, f64::to_le_bytes, f64::from_le_bytes, f64::max);
    }

    fn add(&mut self, numbers: &mut [i64]) {
        self.reduce(numbers, i64::to_le_bytes, i64::from_le_bytes, |a, b| a + b);
    }
}
