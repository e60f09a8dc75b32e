//! The pairs of a candidate list that are not found in the cells of the lowest level.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::Grid;
use super::list::{Candidate, Members, near};
use crate::cell::{Cell, NO_SHIFT, opposite};

/// Pairs that are near only through a periodic face, and those of the higher levels, by their lower row.
pub(super) struct OtherPairs {
    pairs: Vec<(u32, Candidate)>,
}

impl OtherPairs {
    /// Those among the members.
    pub(super) fn find(members: &Members, grid: &Grid, domain: &Cell, parallel: bool) -> Self {
        if members.largest.len() == 1 && !domain.has_images() {
            return Self { pairs: Vec::new() };
        }
        let search = Search {
            members,
            grid,
            above: (1..members.largest.len())
                .map(|level| Above::new(members, level, domain, parallel))
                .collect(),
            domain,
        };
        let rows = &members.rows;
        let add = |mut pairs: Vec<_>, row| {
            search.pairs_of(row, &mut pairs);
            pairs
        };
        let mut pairs = if parallel {
            let of_run = |run: &Range<usize>| run.clone().into_par_iter().with_min_len(256);
            let rows = rows.par_iter().flat_map(of_run);
            let parts: Vec<Vec<_>> = rows.fold(Vec::new, add).collect();
            parts.concat()
        } else {
            rows.iter().cloned().flatten().fold(Vec::new(), add)
        };
        // No two are equal, so their order does not depend on the sort algorithm.
        let key = |&(row, candidate): &(u32, Candidate)| (row, candidate.partner, candidate.image);
        if parallel {
            pairs.par_sort_unstable_by_key(key);
        } else {
            pairs.sort_unstable_by_key(key);
        }
        Self { pairs }
    }

    /// Pairs whose lower row is `row` or a later one.
    pub(super) fn from(&self, row: u32) -> &[(u32, Candidate)] {
        &self.pairs[self.pairs.partition_point(|pair| pair.0 < row)..]
    }
}

/// The particles of a level above the lowest, in cells of their own.
struct Above {
    grid: Grid,
    /// Rows in the order of the cells.
    rows: Vec<u32>,
}

impl Above {
    fn new(members: &Members, level: usize, domain: &Cell, parallel: bool) -> Self {
        let of_level = |&row: &usize| usize::from(members.level[row]) == level;
        let rows = members.rows.iter().cloned().flatten().filter(of_level);
        let rows: Vec<u32> = rows.map(|row| row as u32).collect();
        let position = |k: usize| DVec3::from_array(members.all[rows[k] as usize].position);
        let cell = 2.0 * members.largest[level];
        let (grid, order) = Grid::sort(rows.len(), position, cell, domain, parallel);
        let rows = order.iter().map(|&k| rows[k as usize]).collect();
        Self { grid, rows }
    }
}

/// The search for the pairs that are not found in the cells of the lowest level.
struct Search<'a> {
    members: &'a Members,
    /// Cells of the lowest level; they hold all rows.
    grid: &'a Grid,
    /// Levels from the second on.
    above: Vec<Above>,
    domain: &'a Cell,
}

impl Search<'_> {
    /// Adds the pairs of a particle with particles of its own level and of all lower levels.
    fn pairs_of(&self, row: usize, pairs: &mut Vec<(u32, Candidate)>) {
        let Members {
            all,
            level,
            largest,
            ..
        } = self.members;
        let spot = all[row];
        let own = usize::from(level[row]);
        // In the lowest level those without a shift are known from the cells.
        let here = (own > 0).then_some(NO_SHIFT);
        let domain = self.domain;
        let (low, high) = domain.faces();
        // Particles with extra skin need not be the largest.
        let farthest = largest[..=own].iter().copied().fold(0.0, f64::max);
        for image in here.into_iter().chain(domain.images()) {
            let position = DVec3::from_array(spot.position) + domain.shift(image);
            // Only images that stand within reach of a periodic face can have a neighbour behind it; along the
            // other axes particles may stand outside the domain.
            let reach = spot.radius.abs() + farthest;
            let outside = (low - position).max(position - high);
            if (0..3).any(|axis| domain.is_periodic(axis) && outside[axis] > reach) {
                continue;
            }
            for (lower, largest) in largest[..=own].iter().enumerate() {
                let reach = spot.radius.abs() + largest;
                let mut test = |other: usize| {
                    // Of two particles of a level the one in the higher row searches.
                    if lower == own && other >= row {
                        return;
                    }
                    let position = position.to_array();
                    if !near(all[other], position, spot.radius) {
                        return;
                    }
                    pairs.push(if other < row {
                        let partner = row as u32;
                        (other as u32, Candidate { partner, image })
                    } else {
                        let (partner, image) = (other as u32, opposite(image));
                        (row as u32, Candidate { partner, image })
                    });
                };
                if lower > 0 {
                    let Above { grid, rows } = &self.above[lower - 1];
                    grid.visit_near(position, reach, |k| test(rows[k] as usize));
                } else {
                    self.grid.visit_near(position, reach, |other| {
                        if level[other] == 0 {
                            test(other);
                        }
                    });
                }
            }
        }
    }
}
