//! Searches near a position: particles in cells, the particles of a level of sizes together.

use std::ops::Range;

use glam::DVec3;

use super::{Grid, Levels};
use crate::cell::Cell;
use crate::state::Particles;

/// Particles in the cells of their levels, at the places at which they were listed.
#[derive(Debug, Clone)]
pub struct Cells {
    levels: Vec<Level>,
}

#[derive(Debug, Clone)]
struct Level {
    grid: Grid,
    rows: Rows,
    /// Largest radius, m.
    largest: f64,
}

/// The rows of a level in the order of its cells.
#[derive(Debug, Clone)]
enum Rows {
    /// The rows of the candidate list, sorted by its own cells.
    Listed,
    /// Other rows.
    Sorted(Vec<u32>),
}

impl Level {
    /// Rows whose radii are at most `largest` (m), in cells of their own.
    fn sort(rows: Vec<u32>, largest: f64, particles: &Particles, domain: &Cell) -> Self {
        let position = |k: usize| domain.wrap(particles.listed_at[rows[k] as usize]);
        let (grid, order) = Grid::sort(rows.len(), position, 2.0 * largest, domain, false);
        let rows = order.iter().map(|&k| rows[k as usize]).collect();
        Self {
            grid,
            rows: Rows::Sorted(rows),
            largest,
        }
    }
}

impl Cells {
    /// The rows of a candidate list that was just built: `grid` holds all rows, sorted.
    #[must_use]
    pub fn of_list(grid: Grid, levels: &Levels, particles: &Particles, domain: &Cell) -> Self {
        let mut all = vec![Level {
            grid,
            rows: Rows::Listed,
            largest: levels.largest[0],
        }];
        all.extend(above(1, 0..particles.len(), levels, particles, domain));
        Self { levels: all }
    }

    /// Some rows, which need not be sorted, at their listed positions.
    #[must_use]
    pub fn sort(rows: Range<usize>, particles: &Particles, domain: &Cell) -> Self {
        let levels = Levels::choose(&particles.records[rows.clone()], 0.0);
        Self {
            levels: above(0, rows, &levels, particles, domain).collect(),
        }
    }

    /// Whether `test` is true of a row. All rows are tested of which an image was listed with its surface within `reach` (m) of `place`; others
    /// may be, and some twice.
    pub fn any_near(
        &self,
        place: DVec3,
        reach: f64,
        domain: &Cell,
        mut test: impl FnMut(usize) -> bool,
    ) -> bool {
        let (low, high) = domain.faces();
        self.levels.iter().any(|level| {
            let reach = reach + level.largest;
            let mut any_at = |position: DVec3, reach: f64| {
                level.grid.any_near(position, reach, |k| match &level.rows {
                    Rows::Listed => test(k),
                    Rows::Sorted(rows) => test(rows[k] as usize),
                })
            };
            // Only images of the place that are within reach of a periodic face have neighbours behind it.
            let is_at = |axis: usize, position: DVec3| {
                !domain.is_periodic(axis)
                    || (position[axis] >= low[axis] - reach && position[axis] <= high[axis] + reach)
            };
            let is_near_face = |axis: usize| {
                domain.is_periodic(axis)
                    && (place[axis] - low[axis]).min(high[axis] - place[axis]) <= reach
            };
            // First in the cell of the position itself: where particles are dense, a hit is most likely there.
            any_at(place, 0.0)
                || any_at(place, reach)
                || ((0..3).any(is_near_face)
                    && domain.images().any(|image| {
                        let position = place + domain.shift(image);
                        (0..3).all(|axis| is_at(axis, position)) && any_at(position, reach)
                    }))
        })
    }
}

/// The levels from `first` on of some rows.
fn above<'a>(
    first: usize,
    rows: Range<usize>,
    levels: &'a Levels,
    particles: &'a Particles,
    domain: &'a Cell,
) -> impl Iterator<Item = Level> + 'a {
    (first..levels.largest.len()).map(move |level| {
        let is_of_level = |&row: &usize| levels.of(particles.records[row].radius) == level;
        let rows = rows.clone().filter(is_of_level).map(|row| row as u32);
        Level::sort(rows.collect(), levels.largest[level], particles, domain)
    })
}

#[cfg(test)]
mod tests {
    use mercury_common::random::Stream;
    use proptest::prelude::*;

    use super::*;
    use crate::cell::NO_SHIFT;
    use crate::neighbours::{Margin, build};
    use crate::state::{MaterialIndex, Particle};

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// All rows within reach are tested, by all images, in cells of a list and in cells of some rows alike.
        #[test]
        fn all_within_reach_are_tested(
            seed in any::<u64>(),
            count in 0usize..300,
            size in prop::array::uniform3(0.5..3.0f64),
            periodic in any::<[bool; 3]>(),
            largest in 0.01..0.2f64,
            reach in 0.0..0.3f64,
        ) {
            let mut random = Stream::new(seed, "cells", 0);
            let size = DVec3::from(size);
            let domain = Cell::new(-0.5 * size, 0.5 * size, periodic);
            let mut particles = Particles::new(false);
            for k in 0..count {
                let at = DVec3::new(random.uniform(), random.uniform(), random.uniform()) - 0.5;
                particles.push(Particle {
                    position: at * size,
                    // One in fifty is large.
                    radius: if k % 50 == 7 { largest } else { 0.05 * largest * (0.5 + random.uniform()) },
                    velocity: DVec3::ZERO,
                    inverse_mass: f64::from(u8::from(k % 5 > 0)),
                    angular_velocity: DVec3::ZERO,
                    material: MaterialIndex::new(0),
                    flags: 0,
                }, 1.0, None);
            }
            let place = (DVec3::new(random.uniform(), random.uniform(), random.uniform()) - 0.5) * size;
            let check = |cells: &Cells, particles: &Particles, first: usize| {
                let mut tested = std::collections::HashSet::new();
                let found = cells.any_near(place, reach, &domain, |row| {
                    tested.insert(row);
                    false
                });
                assert!(!found);
                let codes: Vec<u32> = std::iter::once(NO_SHIFT).chain(domain.images()).collect();
                for row in first..particles.len() {
                    let record = &particles.records[row];
                    let is_near = codes.iter().any(|&image| {
                        let distance = (place + domain.shift(image)).distance(record.position);
                        distance < reach + record.radius
                    });
                    assert!(!is_near || tested.contains(&row), "{row}");
                }
            };
            let first = count / 3;
            check(&Cells::sort(first..count, &particles, &domain), &particles, first);
            let levels = Levels::choose(&particles.records, 0.0);
            let mut extra = Vec::new();
            let built = build(&mut particles, &mut extra, &levels, &Margin::of_skin(0.01 * largest), &domain, false);
            check(&Cells::of_list(built.grid, &levels, &particles, &domain), &particles, 0);
        }
    }
}
