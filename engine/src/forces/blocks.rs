//! Blocks of rows: the unit of parallel work.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use crate::memory::GROWTH;
use crate::state::{Load, Plain};

/// Rows in a block, where a test wants small ones; 0: by the number of particles.
static FIXED: AtomicUsize = AtomicUsize::new(0);

/// Gives all blocks of this process so many rows from now on, so that small scenes have many of them. It has to be called before an engine
/// starts, and changes the last bits of its numbers.
pub fn fix_block_size(rows: usize) {
    FIXED.store(rows, Ordering::Relaxed);
}

/// Rows in a block for `count` particles: about count/16 or up to twice that, between 1000 and 4096, and an even number of blocks
/// of the same size, so that two threads (and nearly so, more) get the same.
///
/// Large blocks have fewer contacts that reach into others, small ones can be distributed more evenly. The size must not depend
/// on the number of threads, because it fixes the order of summation.
#[must_use]
pub fn block_size(count: usize) -> usize {
    let fixed = FIXED.load(Ordering::Relaxed);
    if fixed > 0 {
        return fixed;
    }
    let about = (count / 16).next_power_of_two().clamp(1024, 4096);
    let blocks = match count.div_ceil(about) {
        0 | 1 => 1,
        more => more.next_multiple_of(2),
    };
    count.div_ceil(blocks).max(1)
}

/// The bytes of the outboxes of all blocks for this many rows and touching pairs, for estimates of memory.
#[must_use]
pub fn parked_bytes(rows: f64, touching: f64) -> f64 {
    // Rows are sorted by cells that are about a diameter wide, layer by layer, and a contact is half a diameter long along any axis: half
    // of all reach into the next layer. A block is about as long as a layer, or shorter.
    let layer = libm::pow(rows, 2.0 / 3.0);
    let crossing = 0.5 * (layer / block_size(rows as usize) as f64).min(1.0);
    GROWTH * crossing * touching * size_of::<Parked>() as f64
}

/// The shares of partners in later blocks, parked by the block that computed them, target by target.
#[derive(Debug, Default)]
pub(super) struct Outbox {
    /// The later blocks that listed pairs reach, ascending: mostly the next few.
    pub(super) targets: Vec<Target>,
}

/// A later block that pairs of a block reach, and what is parked for it.
#[derive(Debug)]
pub(super) struct Target {
    /// Index of the block.
    pub(super) block: usize,
    /// Its rows, counted from the first row of the block that reaches it.
    pub(super) rows: Range<usize>,
    parked: Vec<Parked>,
}

/// A block that reaches into a later one, and the place of the later one among its targets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Source {
    /// Index of the earlier block.
    pub(super) block: usize,
    /// Place in [`Outbox::targets`].
    pub(super) target: usize,
}

/// Packed, unlike [`Load`]: it is written once and read once, and there are about as many as particles.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Parked {
    /// Row within the receiving block.
    row: u64,
    /// N
    force: DVec3,
    /// N m
    torque: DVec3,
}

impl Outbox {
    /// An empty one of the block `own` for pairs with these partners, all of them rows of later blocks.
    pub(super) fn of(own: usize, partners: impl Iterator<Item = usize>, block_size: usize) -> Self {
        let mut blocks: Vec<usize> = Vec::new();
        for partner in partners {
            let block = partner / block_size;
            // Mostly the block of the partner before.
            if !blocks.iter().rev().any(|&known| known == block) {
                blocks.push(block);
            }
        }
        blocks.sort_unstable();
        let target = |block: usize| Target {
            block,
            rows: (block - own) * block_size..(block - own + 1) * block_size,
            parked: Vec::new(),
        };
        Self {
            targets: blocks.into_iter().map(target).collect(),
        }
    }

    /// Forgets the last step's shares; their memory is used again.
    pub(super) fn clear(&mut self) {
        for target in &mut self.targets {
            target.parked.clear();
        }
    }

    /// Parks a share for the row that lies `ahead` rows behind the first one of this block.
    #[inline(always)]
    pub(super) fn park(&mut self, ahead: usize, force: DVec3, torque: DVec3) {
        for target in &mut self.targets {
            if ahead < target.rows.end {
                target.parked.push(Parked {
                    row: (ahead - target.rows.start) as u64,
                    force,
                    torque,
                });
                return;
            }
        }
        debug_assert!(false, "the row is in no target");
    }

    /// Adds what is parked for a target.
    pub(super) fn deliver(&self, target: usize, loads: &mut [Load]) {
        for parked in &self.targets[target].parked {
            loads[parked.row as usize].add(parked.force, parked.torque);
        }
    }
}

impl Target {
    /// Appends what is parked.
    pub(super) fn put(&self, bytes: &mut Vec<u8>) {
        (self.parked.len() as u32).put(bytes);
        bytes.extend_from_slice(bytemuck::cast_slice(&self.parked));
    }

    /// Takes what another rank has parked, in place of what was there.
    pub(super) fn take(&mut self, bytes: &mut &[u8]) {
        self.parked.clear();
        let count = u32::take(bytes).unwrap_or_default() as usize;
        if let Some((front, rest)) = bytes.split_at_checked(count * size_of::<Parked>()) {
            self.parked
                .extend(bytemuck::pod_collect_to_vec::<u8, Parked>(front));
            *bytes = rest;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_even_in_number_and_size() {
        for (count, size) in [
            (0, 1),
            (1000, 1000),
            (2000, 1000),
            (20_000, 2000),
            (100_000, 3847),
            (10_000_000, 4096),
        ] {
            assert_eq!(block_size(count), size);
        }
        for count in (0..200_000).step_by(37) {
            let size = block_size(count);
            assert!((1..=4096).contains(&size));
            assert!(count <= 1024 || count.div_ceil(size) % 2 == 0, "{count}");
        }
    }

    /// Loads that a block parks are delivered to the row that they are for; there are lists for blocks that pairs reach alone, however
    /// far away these are.
    #[test]
    fn there_is_a_list_for_each_block_that_is_reached() {
        let partners = [5005, 7000, 900_000, 5006, 7999, 900_001];
        let mut outbox = Outbox::of(4, partners.into_iter(), 1000);
        let blocks: Vec<usize> = outbox.targets.iter().map(|target| target.block).collect();
        assert_eq!(blocks, [5, 7, 900]);
        let force = DVec3::new(1.0, 2.0, 3.0);
        for step in 0..2 {
            outbox.clear();
            for (number, partner) in (1..).zip(partners) {
                outbox.park(partner - 4000, f64::from(number) * force, DVec3::ZERO);
            }
            for (target, expected) in [
                [(5, 1.0), (6, 4.0)],
                [(0, 2.0), (999, 5.0)],
                [(0, 3.0), (1, 6.0)],
            ]
            .into_iter()
            .enumerate()
            {
                let mut loads = vec![Load::default(); 1000];
                outbox.deliver(target, &mut loads);
                let found = loads
                    .iter()
                    .enumerate()
                    .filter(|(_, load)| load.force != DVec3::ZERO);
                let found: Vec<_> = found.map(|(row, load)| (row, load.force)).collect();
                assert_eq!(
                    found,
                    expected.map(|(row, times)| (row, times * force)),
                    "step {step}"
                );
            }
        }
    }
}
