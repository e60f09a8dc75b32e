//! State of worn walls in a checkpoint: of the vertices and triangles that are worn alone.

use glam::DVec3;

use super::Wear;
use super::worn::{Worn, WornThrough};

/// State of all worn walls that must be kept to go on later, in the order of the plan.
#[derive(Debug, Clone, PartialEq)]
pub struct SavedWear {
    /// One for each wall that wears.
    pub walls: Vec<SavedWorn>,
}

crate::state::plain!(SavedWear { walls });

/// State of a worn wall that must be kept.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SavedWorn {
    /// Nodes that have moved, owe something, or are held, ascending.
    nodes: Vec<u32>,
    displacements: Vec<DVec3>,
    waiting: Vec<f64>,
    left: Vec<f64>,
    /// Bit 0: blocked, bit 1: worn through.
    flags: Vec<u32>,
    /// Triangles with contacts, and what they owed.
    triangles: Vec<u32>,
    triangle_owed: Vec<f64>,
    /// Owed in front, behind, placed; the largest move.
    sums: [f64; 4],
    moves: u64,
    /// Where it was worn through, and in which move; empty if it was not.
    worn_through: Vec<(DVec3, u64)>,
    is_worn: bool,
}

crate::state::plain!(SavedWorn {
    nodes,
    displacements,
    waiting,
    left,
    flags,
    triangles,
    triangle_owed,
    sums,
    moves,
    worn_through,
    is_worn
});

impl Wear {
    /// State that must be kept to go on later.
    #[must_use]
    pub fn save(&self) -> SavedWear {
        SavedWear {
            walls: self.walls.iter().map(Worn::save).collect(),
        }
    }

    /// Goes on from what [`Wear::save`] gave.
    ///
    /// # Errors
    /// If it is of other walls; what is wrong.
    pub fn restore(&mut self, saved: &SavedWear) -> Result<(), String> {
        if saved.walls.len() != self.walls.len() {
            return Err(format!(
                "it has {} walls that wear, the plan {}",
                saved.walls.len(),
                self.walls.len()
            ));
        }
        for (wall, saved) in self.walls.iter_mut().zip(&saved.walls) {
            wall.restore(saved)?;
        }
        self.note_move();
        Ok(())
    }
}

impl SavedWorn {
    /// Whether the run had come to a depth at which it ends.
    #[must_use]
    pub fn is_worn(&self) -> bool {
        self.is_worn
    }
}

impl Worn {
    pub(super) fn save(&self) -> SavedWorn {
        let mut saved = SavedWorn {
            sums: [self.front, self.back, self.placed, self.largest_move],
            moves: self.moves,
            worn_through: (self.worn_through.iter())
                .map(|found| (found.place, found.moves))
                .collect(),
            is_worn: self.is_worn,
            ..SavedWorn::default()
        };
        for node in 0..self.skin.nodes() {
            let flags = u32::from(self.blocked[node]) | u32::from(self.through[node]) << 1;
            let (way, waiting) = (self.displacement[node], self.waiting[node]);
            if way != DVec3::ZERO || waiting != 0.0 || flags != 0 {
                saved.nodes.push(node as u32);
                saved.displacements.push(way);
                saved.waiting.push(waiting);
                saved.left.push(self.left[node]);
                saved.flags.push(flags);
            }
        }
        for (triangle, &owed) in (0u32..).zip(&self.triangle_owed) {
            if owed != 0.0 {
                saved.triangles.push(triangle);
                saved.triangle_owed.push(owed);
            }
        }
        saved
    }

    pub(super) fn restore(&mut self, saved: &SavedWorn) -> Result<(), String> {
        let count = saved.nodes.len();
        let lengths = [
            saved.displacements.len(),
            saved.waiting.len(),
            saved.left.len(),
            saved.flags.len(),
        ];
        let is_ascending = |list: &[u32], most: usize| {
            list.is_sorted_by(|a, b| a < b)
                && list.last().is_none_or(|&last| (last as usize) < most)
        };
        let fits = lengths.iter().all(|&length| length == count)
            && saved.triangles.len() == saved.triangle_owed.len()
            && is_ascending(&saved.nodes, self.skin.nodes())
            && is_ascending(&saved.triangles, self.skin.triangles.len());
        if !fits {
            return Err("it has wear of vertices or triangles that are not there".to_owned());
        }
        for (k, &node) in saved.nodes.iter().enumerate() {
            let index = node as usize;
            self.displacement[index] = saved.displacements[k];
            self.waiting[index] = saved.waiting[k];
            self.left[index] = saved.left[k];
            self.blocked[index] = saved.flags[k] & 1 != 0;
            self.through[index] = saved.flags[k] & 2 != 0;
            if self.waiting[index] != 0.0 {
                self.owes[index] = true;
                self.owing.push(node);
            }
        }
        for (&triangle, &owed) in saved.triangles.iter().zip(&saved.triangle_owed) {
            self.triangle_owed[triangle as usize] = owed;
        }
        [self.front, self.back, self.placed, self.largest_move] = saved.sums;
        self.moves = saved.moves;
        let found = saved.worn_through.first();
        self.worn_through = found.map(|&(place, moves)| WornThrough { place, moves });
        self.is_worn = saved.is_worn;
        for &node in &saved.nodes {
            for &triangle in self.skin.around(node) {
                self.removed[triangle as usize] = self.lost(triangle);
            }
        }
        (0..self.skin.nodes() as u32).for_each(|node| self.measure(node));
        Ok(())
    }
}
