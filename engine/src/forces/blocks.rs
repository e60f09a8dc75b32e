//! Blocks of rows: the unit of parallel work.

use glam::DVec3;

use crate::memory::GROWTH;
use crate::state::Load;

/// Rows in a block for `count` particles: about count/16 or up to twice that, between 1000 and 4096, and an even number of blocks
/// of the same size, so that two threads (and nearly so, more) get the same.
///
/// Large blocks have fewer contacts that reach into others, small ones can be distributed more evenly. The size must not depend
/// on the number of threads, because it fixes the order of summation.
#[must_use]
pub fn block_size(count: usize) -> usize {
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

/// The block, counted from the first, and the row within it, of the row that lies `ahead` rows behind the start of the first.
/// Mostly it is in the first or the second block, and this test is faster than a division.
#[inline(always)]
pub(super) fn place(mut ahead: usize, block_size: usize) -> (usize, usize) {
    let mut block = 0;
    while ahead >= block_size {
        ahead -= block_size;
        block += 1;
    }
    (block, ahead)
}

/// The partner's share of contacts that reach into later blocks, parked by the block that computed them.
#[derive(Debug, Default)]
pub(super) struct Outbox {
    /// One list for each later block, up to the last one that a contact has reached: mostly the next few.
    lists: Vec<Vec<Parked>>,
}

/// Packed, unlike [`Load`]: it is written once and read once, and there are about as many as particles.
#[derive(Debug, Clone, Copy)]
struct Parked {
    /// Row within the receiving block.
    row: u32,
    /// N
    force: DVec3,
    /// N m
    torque: DVec3,
}

impl Outbox {
    /// Forgets the last step's shares; their memory is used again.
    pub(super) fn clear(&mut self) {
        for list in &mut self.lists {
            list.clear();
        }
    }

    /// Parks a share for the row that lies `ahead` rows behind the start of this block's successor.
    #[inline(always)]
    pub(super) fn park(&mut self, ahead: usize, block_size: usize, force: DVec3, torque: DVec3) {
        let (block, row) = place(ahead, block_size);
        if block >= self.lists.len() {
            self.lists.resize_with(block + 1, Vec::new);
        }
        self.lists[block].push(Parked {
            row: row as u32,
            force,
            torque,
        });
    }

    /// Adds what is parked for the block `ahead` blocks behind the successor.
    pub(super) fn deliver(&self, ahead: usize, loads: &mut [Load]) {
        if let Some(list) = self.lists.get(ahead) {
            for parked in list {
                loads[parked.row as usize].add(parked.force, parked.torque);
            }
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

    /// Loads that a block parks are delivered to the row that they are for; the number of lists follows from the blocks that are
    /// reached.
    #[test]
    fn lists_reach_as_far_as_contacts() {
        let mut outbox = Outbox::default();
        let force = DVec3::new(1.0, 2.0, 3.0);
        outbox.park(2300, 1000, force, DVec3::ZERO);
        outbox.park(5, 1000, -force, DVec3::ZERO);
        assert_eq!(outbox.lists.len(), 3);
        for (ahead, row, expected) in [(0, 5, -force), (2, 300, force)] {
            let mut loads = vec![Load::new(DVec3::ZERO, DVec3::ZERO); 1000];
            outbox.deliver(ahead, &mut loads);
            let found: Vec<usize> = (0..1000)
                .filter(|&k| loads[k].force != DVec3::ZERO)
                .collect();
            assert_eq!((found, loads[row].force), (vec![row], expected));
        }
        for ahead in [1, 7] {
            let mut loads = [Load::default(); 1000];
            outbox.deliver(ahead, &mut loads);
            assert_eq!(loads, [Load::default(); 1000]);
        }
    }

    #[test]
    fn places_are_those_of_a_division() {
        for ahead in 0..5000 {
            assert_eq!(place(ahead, 1000), (ahead / 1000, ahead % 1000));
        }
    }
}
