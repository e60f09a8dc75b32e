//! Blocks of rows: the unit of parallel work.

use glam::DVec3;

use crate::particles::Load;

/// Rows in a block for `count` particles: the power of two above count/16, between 1024 and 4096.
///
/// Large blocks have fewer contacts that reach into others, small ones share out better. It must not depend on the number of
/// threads: it fixes the order of summation.
#[must_use]
pub fn block_size(count: usize) -> usize {
    (count / 16).next_power_of_two().clamp(1024, 4096)
}

/// The partner's share of contacts that reach into later blocks, parked by the block that computed them.
#[derive(Debug, Default)]
pub(super) struct Outbox {
    /// One list for each later block.
    lists: Vec<Vec<Parked>>,
}

#[derive(Debug, Clone, Copy)]
struct Parked {
    /// Row within the receiving block.
    row: u32,
    load: Load,
}

impl Outbox {
    /// An empty box of a block that `later` blocks follow.
    pub(super) fn new(later: usize) -> Self {
        Self {
            lists: (0..later).map(|_| Vec::new()).collect(),
        }
    }

    /// Forgets the last step's shares; their memory is used again.
    pub(super) fn clear(&mut self) {
        for list in &mut self.lists {
            list.clear();
        }
    }

    /// Parks a share for the row that lies `ahead` rows behind the start of this block's successor.
    #[inline(always)]
    pub(super) fn park(&mut self, ahead: usize, block_size: usize, force: DVec3, torque: DVec3) {
        // The size is a power of two, so this is a shift and a mask.
        let shift = block_size.trailing_zeros();
        let row = (ahead & (block_size - 1)) as u32;
        self.lists[ahead >> shift].push(Parked {
            row,
            load: Load::new(force, torque),
        });
    }

    /// Adds what is parked for the block `ahead` blocks behind the successor.
    pub(super) fn deliver(&self, ahead: usize, loads: &mut [Load]) {
        if let Some(list) = self.lists.get(ahead) {
            for parked in list {
                loads[parked.row as usize].add(parked.load.force, parked.load.torque);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_powers_of_two_within_their_limits() {
        for (count, size) in [
            (0, 1024),
            (2000, 1024),
            (20_000, 2048),
            (100_000, 4096),
            (10_000_000, 4096),
        ] {
            assert_eq!(block_size(count), size);
        }
    }
}
