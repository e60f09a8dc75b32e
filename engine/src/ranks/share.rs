//! The share of one rank: its blocks and rows, and what goes over to other ranks.

use std::ops::Range;
use std::time::{Duration, Instant};

use bytemuck::{bytes_of, bytes_of_mut};
use glam::{DQuat, DVec3};

use super::Ranks;
use crate::state::{Load, Particle, Particles, Plain};

/// Messages and bytes that were sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Traffic {
    /// In steps: records and shares of contacts.
    pub messages: u64,
    /// In steps.
    pub bytes: u64,
    /// With new lists.
    pub bytes_of_lists: u64,
    /// To the first rank, for looks and checkpoints.
    pub bytes_of_looks: u64,
}

/// The way from one rank to the others while contacts are evaluated or carried over.
pub struct Across<'a> {
    /// The number of this rank.
    pub rank: usize,
    /// First block of each rank, and the number of blocks at the end.
    pub cut: &'a [usize],
    /// Sends bytes to each rank and returns what each has sent here; nothing goes to this rank itself.
    pub exchange: &'a mut dyn FnMut(Vec<Vec<u8>>) -> Vec<Vec<u8>>,
}

impl Across<'_> {
    /// The rank of a block.
    #[must_use]
    pub fn rank_of(&self, block: usize) -> usize {
        rank_of(self.cut, block)
    }

    /// The blocks of this rank.
    #[must_use]
    pub fn own(&self) -> Range<usize> {
        self.cut[self.rank]..self.cut[self.rank + 1]
    }
}

/// The blocks and rows of one rank, and its way to the others.
pub struct Share {
    ranks: Box<dyn Ranks>,
    /// First block of each rank, and the number of blocks at the end; empty before the first list, when every rank has all.
    cut: Vec<usize>,
    block_size: usize,
    rows: usize,
    /// The rows of other ranks that this one reads, by rank.
    read: Vec<(usize, Vec<u32>)>,
    /// The rows of this rank that others read, by rank.
    sent: Vec<(usize, Vec<u32>)>,
    /// The rows that other things than contacts read, with their orientations; `None` where nothing but contacts reads rows.
    beside_contacts: Option<Vec<u32>>,
    /// Whether all rows are as their ranks have them.
    is_complete: bool,
    /// The time that it took to compute own rows since the last division.
    busy: Duration,
    /// Whether the first rank has ended the run.
    has_ended: bool,
    /// Listed pairs of all ranks.
    pub listed: usize,
    /// Messages and bytes that it has sent.
    pub traffic: Traffic,
    /// Messages and bytes of all ranks until the last look.
    pub total: Traffic,
}

impl Share {
    /// Of a rank, before the first list.
    #[must_use]
    pub fn new(ranks: Box<dyn Ranks>) -> Self {
        Self {
            ranks,
            cut: Vec::new(),
            block_size: 1,
            rows: 0,
            read: Vec::new(),
            sent: Vec::new(),
            beside_contacts: None,
            is_complete: true,
            busy: Duration::ZERO,
            has_ended: false,
            listed: 0,
            traffic: Traffic::default(),
            total: Traffic::default(),
        }
    }

    /// The ways to exchange bytes.
    pub fn ranks(&mut self) -> &mut dyn Ranks {
        self.ranks.as_mut()
    }

    /// The first rank has ended the run.
    pub fn note_end(&mut self) {
        self.has_ended = true;
    }

    /// The number of this rank, and how many there are.
    #[must_use]
    pub fn place(&self) -> (usize, usize) {
        self.ranks.place()
    }

    /// Whether this is the first rank, which makes the run.
    #[must_use]
    pub fn is_first(&self) -> bool {
        self.place().0 == 0
    }

    /// Whether rows are divided among the ranks: from the first list on.
    #[must_use]
    pub fn is_divided(&self) -> bool {
        !self.cut.is_empty()
    }

    /// Divides rows into blocks of a size, and these among the ranks: at first as many to each as nearly as possible, later so that each is busy for
    /// as long as the others, by the times since the last division. They change no byte.
    pub fn divide(&mut self, rows: usize, block_size: usize) {
        let blocks = rows.div_ceil(block_size);
        let (_, count) = self.place();
        let busy = std::mem::take(&mut self.busy).as_secs_f64();
        let times = self.ranks.all(busy.to_le_bytes().to_vec());
        let time = |bytes: &Vec<u8>| f64::take(&mut &bytes[..]).unwrap_or_default();
        let times: Vec<f64> = times.iter().map(time).collect();
        self.cut = balanced(&self.cut, &times, blocks)
            .unwrap_or_else(|| (0..=count).map(|rank| blocks * rank / count).collect());
        (self.rows, self.block_size) = (rows, block_size);
        self.beside_contacts = None;
        self.is_complete = true;
    }

    /// First block of each rank, and the number of blocks.
    #[must_use]
    pub fn cut(&self) -> &[usize] {
        &self.cut
    }

    /// The rows of a rank.
    fn rows_of(&self, rank: usize) -> Range<usize> {
        let first = |rank: usize| (self.cut[rank] * self.block_size).min(self.rows);
        first(rank)..first(rank + 1)
    }

    /// The rows of this rank among so many; all of them before the first list. Rows behind the divided ones, which have just come, are in none.
    #[must_use]
    pub fn own_rows(&self, rows: usize) -> Range<usize> {
        match self.is_divided() {
            true => self.rows_of(self.place().0),
            false => 0..rows,
        }
    }

    /// Sends bytes to each rank and returns what each sends here.
    pub fn exchange_all(&mut self, mut out: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        let (own, count) = self.place();
        let others: Vec<usize> = (0..count).filter(|&rank| rank != own).collect();
        let to: Vec<_> = (others.iter())
            .map(|&rank| (rank, std::mem::take(&mut out[rank])))
            .collect();
        self.traffic.bytes_of_lists += bytes_in(&to);
        let came = self.ranks.exchange(to, &others);
        let mut all = vec![Vec::new(); count];
        others
            .iter()
            .zip(came)
            .for_each(|(&rank, bytes)| all[rank] = bytes);
        all
    }

    /// Sends bytes to all ranks in a step, and returns those of all in their order.
    pub fn to_all(&mut self, own: Vec<u8>) -> Vec<Vec<u8>> {
        self.traffic.messages += u64::from(!own.is_empty());
        self.traffic.bytes += own.len() as u64;
        self.ranks.all(own)
    }

    /// The rank of a row.
    #[must_use]
    pub fn rank_of_row(&self, row: u32) -> usize {
        rank_of(&self.cut, row as usize / self.block_size)
    }

    /// Adds rows that are read beside those that contacts read, until rows are divided anew; all ranks do it.
    pub fn read_beside_contacts(&mut self, rows: &[u32]) {
        let beside = self.beside_contacts.get_or_insert_default();
        beside.extend_from_slice(rows);
        beside.sort_unstable();
        beside.dedup();
    }

    /// Notes which rows of other ranks this one reads, those that contacts read (ascending) among them, and which rows of this one others read.
    pub fn note_readers(&mut self, by_contacts: &[u32]) {
        let (own, count) = self.place();
        let mut rows = by_contacts.to_vec();
        if let Some(beside) = &self.beside_contacts {
            rows.extend_from_slice(beside);
            rows.sort_unstable();
            rows.dedup();
        }
        let mut wanted = vec![Vec::new(); count];
        for row in rows {
            wanted[self.rank_of_row(row)].push(row);
        }
        wanted[own].clear();
        let bytes = |rows: &Vec<u32>| bytemuck::cast_slice(rows).to_vec();
        let came = self.exchange_all(wanted.iter().map(bytes).collect());
        let some = |all: Vec<Vec<u32>>| {
            let all = all.into_iter().enumerate();
            all.filter(|(_, rows)| !rows.is_empty()).collect()
        };
        let rows = |bytes: &Vec<u8>| bytemuck::pod_collect_to_vec(bytes);
        self.read = some(wanted);
        self.sent = some(came.iter().map(rows).collect());
    }

    /// All rows move: those of other ranks are no longer as these have them.
    pub fn note_motion(&mut self) {
        self.is_complete = !self.is_divided();
    }

    /// Sends to ranks what they read of this one, and returns what this one reads, in the order of `read`.
    fn bring_read(&mut self, to: Vec<(usize, Vec<u8>)>) -> Vec<Vec<u8>> {
        self.traffic.messages += to.len() as u64;
        self.traffic.bytes += bytes_in(&to);
        let from: Vec<usize> = self.read.iter().map(|(rank, _)| *rank).collect();
        self.ranks.exchange(to, &from)
    }

    /// Brings up to date the records that this rank reads, with orientations where not only contacts read them.
    pub fn fetch_records(&mut self, particles: &mut Particles) {
        if self.is_complete {
            return;
        }
        let records = &mut particles.records;
        let orientations = particles.orientations.as_mut();
        let mut orientations = orientations.filter(|_| self.beside_contacts.is_some());
        let pack = |(rank, rows): &(usize, Vec<u32>)| {
            let mut bytes = Vec::with_capacity(rows.len() * MOTION);
            for row in rows.iter().map(|&row| row as usize) {
                put_motion(&records[row], &mut bytes);
                if let Some(orientations) = &orientations {
                    bytes.extend_from_slice(bytes_of(&orientations[row]));
                }
            }
            (*rank, bytes)
        };
        let to = self.sent.iter().map(pack).collect();
        let came = self.bring_read(to);
        for ((_, rows), bytes) in self.read.iter().zip(came) {
            let size = bytes.len() / rows.len();
            for (row, bytes) in rows.iter().zip(bytes.chunks_exact(size)) {
                let row = *row as usize;
                let Some((motion, orientation)) = bytes.split_first_chunk() else {
                    continue;
                };
                take_motion(motion, &mut records[row]);
                if let Some(orientations) = &mut orientations {
                    bytes_of_mut(&mut orientations[row]).copy_from_slice(orientation);
                }
            }
        }
    }

    /// Brings up to date the loads on the particles that contacts of this rank read.
    pub fn fetch_loads(&mut self, loads: &mut [Load]) {
        let pack = |(rank, rows): &(usize, Vec<u32>)| {
            let loads = rows.iter().map(|&row| bytes_of(&loads[row as usize]));
            (*rank, loads.collect::<Vec<_>>().concat())
        };
        let to = self.sent.iter().map(pack).collect();
        let came = self.bring_read(to);
        for ((_, rows), bytes) in self.read.iter().zip(came) {
            for (&row, load) in rows.iter().zip(bytes.chunks_exact(size_of::<Load>())) {
                bytes_of_mut(&mut loads[row as usize]).copy_from_slice(load);
            }
        }
    }

    /// The rows of other ranks that contacts of this one read.
    pub fn rows_of_others(&self) -> impl Iterator<Item = u32> {
        self.read.iter().flat_map(|(_, rows)| rows).copied()
    }

    /// The way to the ranks that exchange shares of contacts in each step: those that read rows of this one have shares for it.
    pub fn with_shares<T>(&mut self, work: impl FnOnce(Option<Across<'_>>) -> T) -> T {
        if !self.is_divided() {
            return work(None);
        }
        let rank = self.place().0;
        let Self {
            ranks,
            cut,
            read,
            sent,
            traffic,
            busy,
            ..
        } = self;
        let (begun, mut waited) = (Instant::now(), Duration::ZERO);
        let mut exchange = |mut out: Vec<Vec<u8>>| {
            let since = Instant::now();
            let to = read
                .iter()
                .map(|(rank, _)| (*rank, std::mem::take(&mut out[*rank])));
            let to: Vec<_> = to.collect();
            traffic.messages += to.len() as u64;
            traffic.bytes += bytes_in(&to);
            let from: Vec<usize> = sent.iter().map(|(rank, _)| *rank).collect();
            let came = ranks.exchange(to, &from);
            let mut all = vec![Vec::new(); cut.len() - 1];
            from.iter()
                .zip(came)
                .for_each(|(&rank, bytes)| all[rank] = bytes);
            waited += since.elapsed();
            all
        };
        let result = work(Some(Across {
            rank,
            cut,
            exchange: &mut exchange,
        }));
        *busy += begun.elapsed().saturating_sub(waited);
        result
    }

    /// Counts more time that it took to compute own rows.
    pub fn note_work(&mut self, time: Duration) {
        self.busy += time;
    }

    /// The way to all ranks, while lists are built.
    pub fn with_all<T>(&mut self, work: impl FnOnce(Across<'_>) -> T) -> T {
        let (rank, cut) = (self.place().0, self.cut.clone());
        let mut exchange = |out| self.exchange_all(out);
        work(Across {
            rank,
            cut: &cut,
            exchange: &mut exchange,
        })
    }

    /// Brings all rows up to date on every rank, as the order of rows, insertions and removals need them: positions, velocities, orientations.
    pub fn complete(&mut self, particles: &mut Particles) {
        if self.is_complete {
            return;
        }
        let bytes = pack_rows(particles, self.own_rows(particles.len()), false);
        self.traffic.bytes_of_lists += bytes.len() as u64;
        let all = self.ranks.all(bytes);
        self.take_rows(&all, particles, false);
        self.is_complete = true;
    }

    /// Brings the records of some rows up to date on every rank: of the same rows on each, ascending.
    pub fn complete_some(&mut self, records: &mut [Particle], rows: &[u32]) {
        if self.is_complete || rows.is_empty() {
            return;
        }
        let (own, count) = self.place();
        let begins = |rank: usize| {
            let first = self.rows_of(rank).start;
            rows.partition_point(|&row| (row as usize) < first)
        };
        let ends: Vec<usize> = (1..count).map(begins).chain([rows.len()]).collect();
        let of_rank =
            |rank: usize| &rows[rank.checked_sub(1).map_or(0, |one| ends[one])..ends[rank]];
        let mut bytes = Vec::new();
        (of_rank(own).iter()).for_each(|&row| put_motion(&records[row as usize], &mut bytes));
        let all = self.to_all(bytes);
        for rank in (0..count).filter(|&rank| rank != own) {
            for (&row, motion) in of_rank(rank).iter().zip(all[rank].as_chunks().0) {
                take_motion(motion, &mut records[row as usize]);
            }
        }
    }

    /// The bytes of all ranks on the first one, for a look; nothing on the others.
    pub fn gather(&mut self, own: Vec<u8>) -> Vec<Vec<u8>> {
        self.traffic.bytes_of_looks += own.len() as u64;
        self.ranks.gather(own)
    }

    /// Brings all rows up to date on the first rank, with the loads on them.
    pub fn collect(&mut self, particles: &mut Particles) {
        if !self.is_divided() {
            return;
        }
        let bytes = pack_rows(particles, self.own_rows(particles.len()), true);
        let all = self.gather(bytes);
        self.take_rows(&all, particles, true);
        let Traffic {
            messages,
            bytes,
            bytes_of_lists,
            bytes_of_looks,
        } = self.traffic;
        let own = [messages, bytes, bytes_of_lists, bytes_of_looks];
        let mut sums = own.map(|number| number as i64);
        self.ranks.add(&mut sums);
        let [messages, bytes, bytes_of_lists, bytes_of_looks] = sums.map(|sum| sum as u64);
        self.total = Traffic {
            messages,
            bytes,
            bytes_of_lists,
            bytes_of_looks,
        };
    }

    fn take_rows(&self, all: &[Vec<u8>], particles: &mut Particles, with_loads: bool) {
        let own = self.place().0;
        for (rank, bytes) in all.iter().enumerate().filter(|(rank, _)| *rank != own) {
            unpack_rows(bytes, particles, self.rows_of(rank), with_loads);
        }
    }

    /// Brings the loads on all pebbles to every rank: each moves all bodies.
    pub fn complete_pebbles(&mut self, particles: &mut Particles) {
        let Some(bodies) = particles.bodies.as_ref().filter(|_| self.is_divided()) else {
            return;
        };
        let (own, count) = self.place();
        let rows: Vec<Range<usize>> = (0..count).map(|rank| self.rows_of(rank)).collect();
        let pebbles = |rank: usize| {
            let rows = rows[rank].clone();
            rows.filter(|&row| bodies.of_row[row].is_some())
        };
        let mut bytes = Vec::new();
        pebbles(own).for_each(|row| bytes.extend_from_slice(bytes_of(&particles.loads[row])));
        let sent = bytes.len() as u64;
        let all = self.ranks.all(bytes);
        let others = (0..all.len()).filter(|&rank| rank != own);
        for rank in others {
            for (row, load) in pebbles(rank).zip(all[rank].chunks_exact(size_of::<Load>())) {
                bytes_of_mut(&mut particles.loads[row]).copy_from_slice(load);
            }
        }
        self.traffic.messages += 1;
        self.traffic.bytes += sent;
    }
}

impl std::fmt::Debug for Share {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (rank, count) = self.place();
        write!(f, "rank {rank} of {count}")
    }
}

/// The first rank ends the run of all; the others wait for that.
impl Drop for Share {
    fn drop(&mut self) {
        if std::thread::panicking() {
            return;
        }
        while !self.has_ended {
            let end = self.ranks.broadcast(vec![END]);
            self.has_ended = end == [END];
        }
    }
}

/// In place of a beginning or a call: there is none any more.
pub const END: u8 = 0;

/// First block of each rank, and the number of blocks, so that ranks are busy for the same time: blocks of a rank are taken to cost what they cost on
/// average. Half of the way there, as the next times may differ. `None` without times.
fn balanced(cut: &[usize], times: &[f64], blocks: usize) -> Option<Vec<usize>> {
    let (&before, total) = (cut.last()?, times.iter().sum::<f64>());
    if before == 0 || total <= 0.0 {
        return None;
    }
    // In shares of the blocks, as there may be more or fewer now.
    let place = |block: usize| block as f64 / before as f64;
    let (mut rank, mut spent) = (0, 0.0);
    let ranks = times.len();
    let inner = (1..ranks).map(|next| {
        let wanted = total * next as f64 / ranks as f64;
        while rank + 1 < ranks && spent + times[rank] < wanted {
            spent += times[rank];
            rank += 1;
        }
        let part = ((wanted - spent) / times[rank]).clamp(0.0, 1.0);
        let (start, end) = (place(cut[rank]), place(cut[rank + 1]));
        let even = start + part * (end - start);
        let half = 0.5 * (even + place(cut[next]));
        (half * blocks as f64).round() as usize
    });
    let mut new: Vec<usize> = std::iter::once(0).chain(inner).chain([blocks]).collect();
    (1..new.len()).for_each(|k| new[k] = new[k].clamp(new[k - 1], blocks));
    Some(new)
}

/// The rank of a block, by the first block of each.
fn rank_of(cut: &[usize], block: usize) -> usize {
    cut.partition_point(|first| *first <= block) - 1
}

fn bytes_in(messages: &[(usize, Vec<u8>)]) -> u64 {
    messages.iter().map(|(_, bytes)| bytes.len() as u64).sum()
}

/// Bytes of the position and the velocities of a particle.
const MOTION: usize = 3 * size_of::<DVec3>();

/// Appends what changes of a record.
fn put_motion(record: &Particle, bytes: &mut Vec<u8>) {
    bytes.extend_from_slice(bytes_of(&record.position));
    bytes.extend_from_slice(bytes_of(&record.velocity));
    bytes.extend_from_slice(bytes_of(&record.angular_velocity));
}

fn take_motion(motion: &[u8; MOTION], record: &mut Particle) {
    let vectors: [DVec3; 3] = bytemuck::pod_read_unaligned(motion);
    [record.position, record.velocity, record.angular_velocity] = vectors;
}

/// Bytes of the columns that change from step to step, of some rows.
fn pack_rows(particles: &Particles, rows: Range<usize>, with_loads: bool) -> Vec<u8> {
    let mut bytes = Vec::new();
    let records = &particles.records[rows.clone()];
    records
        .iter()
        .for_each(|record| put_motion(record, &mut bytes));
    if let Some(orientations) = &particles.orientations {
        for orientation in &orientations[rows.clone()] {
            bytes.extend_from_slice(bytes_of(orientation));
        }
    }
    if with_loads {
        bytes.extend_from_slice(bytemuck::cast_slice(&particles.loads[rows]));
    }
    bytes
}

fn unpack_rows(mut bytes: &[u8], particles: &mut Particles, rows: Range<usize>, with_loads: bool) {
    let mut next = |size: usize| {
        let (front, rest) = bytes.split_at(size * rows.len());
        bytes = rest;
        front
    };
    let motions = next(MOTION).as_chunks().0;
    for (record, motion) in particles.records[rows.clone()].iter_mut().zip(motions) {
        take_motion(motion, record);
    }
    if let Some(orientations) = &mut particles.orientations {
        let turned = next(size_of::<DQuat>()).chunks_exact(size_of::<DQuat>());
        for (orientation, bytes) in orientations[rows.clone()].iter_mut().zip(turned) {
            bytes_of_mut(orientation).copy_from_slice(bytes);
        }
    }
    if with_loads {
        let loads = next(size_of::<Load>());
        bytemuck::cast_slice_mut(&mut particles.loads[rows.clone()]).copy_from_slice(loads);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Blocks of any costs: after some divisions no rank is busy for longer than the mean by more than two of the dearest blocks.
        #[test]
        fn ranks_become_equally_busy(
            costs in prop::collection::vec(0.1..5.0f64, 20..200),
            ranks in 1usize..8,
            grows in any::<bool>(),
        ) {
            let blocks = costs.len();
            let time = |cut: &[usize], rank: usize| costs[cut[rank]..cut[rank + 1]].iter().sum::<f64>();
            let mut cut: Vec<usize> = (0..=ranks).map(|rank| blocks * rank / ranks).collect();
            for _ in 0..40 {
                let times: Vec<f64> = (0..ranks).map(|rank| time(&cut, rank)).collect();
                cut = balanced(&cut, &times, blocks).unwrap();
                prop_assert!(cut.is_sorted() && cut[0] == 0 && cut[ranks] == blocks);
            }
            let mean = costs.iter().sum::<f64>() / ranks as f64;
            let dearest = costs.iter().copied().fold(0.0, f64::max);
            for rank in 0..ranks {
                prop_assert!(time(&cut, rank) <= mean + 2.0 * dearest, "{cut:?}");
            }
            // More blocks are divided likewise.
            let times: Vec<f64> = (0..ranks).map(|rank| time(&cut, rank)).collect();
            let more = if grows { 2 * blocks } else { blocks / 3 };
            let next = balanced(&cut, &times, more).unwrap();
            prop_assert!(next.is_sorted() && next[0] == 0 && next[ranks] == more);
        }
    }

    #[test]
    fn without_times_there_is_no_balance() {
        assert_eq!(balanced(&[], &[], 4), None);
        assert_eq!(balanced(&[0, 0, 0], &[0.0, 0.0], 4), None);
        assert_eq!(balanced(&[0, 2, 4], &[0.0, 0.0], 4), None);
        // A rank without blocks gets some.
        assert_eq!(balanced(&[0, 4, 4], &[1.0, 0.0], 4), Some(vec![0, 3, 4]));
    }
}
