//! A skin of its own for each level of sizes, and for the few that move farthest.

use super::rows::each;
use super::validity::displacement;
use super::{Levels, Skin};
use crate::state::Particles;

/// One particle of this many of a level gets a skin of its own.
const FEW: usize = 200;
/// How much farther than the rest a particle must have gone: pairs of particles with extra skin are harder to find.
const WORTH_IT: f64 = 2.0;
/// How much farther a particle may go, over what it went while the last list lasted: a fast particle may be accelerating.
const MORE: f64 = 1.5;
/// Least skin of a level over the thickness: a particle that has hardly moved may be hit next.
const LEAST: f64 = 0.125;

/// The additional distance, over half the thickness of the skin, that particles may move before the next list is built, m. Below
/// zero for slow levels, but less than half the thickness.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ExtraSkins {
    /// Of each level of sizes, without the few that move farther; empty if zero for all.
    pub levels: Vec<f64>,
    /// Of each row, more than that of its level for few; empty if zero for all.
    pub rows: Vec<f64>,
}

impl ExtraSkins {
    /// Of a row.
    #[inline]
    #[must_use]
    pub fn of(&self, row: usize) -> f64 {
        self.rows.get(row).copied().unwrap_or_default()
    }

    /// Of a level.
    #[inline]
    #[must_use]
    pub fn of_level(&self, level: usize) -> f64 {
        self.levels.get(level).copied().unwrap_or_default()
    }

    /// Sets the extra skins by how far each particle went while the last list lasted. `widest`: largest skin of the lowest level,
    /// m. Makes the skin thinner if those that went farthest may not go so far.
    ///
    /// The list is built anew when a particle has used up its part of the skin. Where particles of some size move much farther than all others (balls in a mill, dust that
    /// is blown about between stones), or a few of any size (a stone that falls into a bed, and the grains that it pushes away), they would set the pace for all.
    /// So each level of sizes gets skin by how far its particles went, but for the farthest of each 200; and these by how far each of them went: all use up
    /// their part at about the same time.
    #[must_use]
    pub fn measure(
        particles: &Particles,
        skin: &mut Skin,
        levels: &Levels,
        widest: f64,
        parallel: bool,
    ) -> Self {
        // Small particles have at most half the widest skin, large ones half of their own: they are few.
        let most: Vec<f64> = (levels.largest.iter().enumerate())
            .map(|(level, &radius)| {
                if level == 0 {
                    widest
                } else {
                    radius.max(widest)
                }
            })
            .map(|most| 0.5 * most.min(skin.largest))
            .collect();
        if most.len() == 1 && particles.len() < FEW {
            skin.thickness = skin.thickness.min(2.0 * most[0]);
            return Self::default();
        }
        let level = |row: usize| levels.of(particles.records[row].radius);
        let moved = each(particles.len(), parallel, |row| {
            displacement(particles, row)
        });
        let mut ways = vec![Vec::new(); levels.largest.len()];
        if let [all] = &mut ways[..] {
            all.clone_from(&moved);
        } else {
            for (row, &way) in moved.iter().enumerate() {
                ways[level(row)].push(way);
            }
        }
        let ways: Vec<Way> = ways.into_iter().map(Way::of).collect();
        let farthest = ways.iter().map(|way| way.rest).fold(0.0, f64::max);
        let is_farthest = |way: &Way| way.rest == farthest;
        let allowed = (ways.iter().zip(&most))
            .filter(|(way, _)| is_farthest(way))
            .map(|(_, &most)| most);
        skin.thickness = skin.thickness.min(2.0 * allowed.fold(0.0, f64::max));
        let half = 0.5 * skin.thickness;
        let of_levels: Vec<f64> = (ways.iter().zip(&most))
            .map(|(way, &most)| {
                let part = if is_farthest(way) {
                    1.0
                } else {
                    (MORE * way.rest / farthest).clamp(LEAST, 1.0)
                };
                (half * part).min(most) - half
            })
            .collect();
        let stand_out =
            (ways.iter().zip(&most)).any(|(way, &most)| way.few_stand_out && half < most);
        if !stand_out && of_levels.iter().all(|&own| own == 0.0) {
            return Self::default();
        }
        let rows = each(moved.len(), parallel, |row| {
            let level = level(row);
            let (way, own) = (&ways[level], of_levels[level]);
            if way.few_stand_out && moved[row] > way.rest {
                let wanted = half * (MORE * moved[row] / farthest - 1.0);
                wanted.min(most[level] - half).max(own)
            } else {
                own
            }
        });
        Self {
            levels: of_levels,
            rows,
        }
    }
}

/// The displacements of the particles of a level.
#[derive(Debug, Clone, Copy)]
struct Way {
    /// The farthest, but for one of each 200, m.
    rest: f64,
    /// Whether one of these went so much farther that a skin of its own pays.
    few_stand_out: bool,
}

impl Way {
    fn of(mut ways: Vec<f64>) -> Self {
        if ways.is_empty() {
            return Self {
                rest: 0.0,
                few_stand_out: false,
            };
        }
        let place = ways.len() - 1 - ways.len() / FEW;
        let (_, &mut rest, faster) = ways.select_nth_unstable_by(place, f64::total_cmp);
        Self {
            rest,
            few_stand_out: faster.iter().any(|&far| far > WORTH_IT * rest),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::state::{MaterialIndex, Particle};

    fn moved_by(ways: impl Iterator<Item = f64>) -> Particles {
        of_sizes(ways.map(|way| (1.0, way)))
    }

    /// Particles by radius and way.
    fn of_sizes(particles: impl Iterator<Item = (f64, f64)>) -> Particles {
        let ways = particles;
        let mut particles = Particles::new(false);
        for (radius, way) in ways {
            let record = Particle {
                position: DVec3::ZERO,
                radius,
                velocity: DVec3::ZERO,
                inverse_mass: 1.0,
                angular_velocity: DVec3::ZERO,
                material: MaterialIndex::new(0),
                flags: 0,
            };
            particles.push(record, 1.0, None);
            particles.records.last_mut().unwrap().position = DVec3::Y * way;
        }
        particles
    }

    const SKIN: Skin = Skin {
        thickness: 0.1,
        least: 0.01,
        largest: 1.0,
    };

    /// A hundred balls among a thousand grains: the farthest sets the thickness, the others get one and a half of what they used,
    /// a level that rests an eighth of it; the few of a level that are much farther get their own.
    #[test]
    fn each_level_gets_skin_by_how_far_it_went() {
        let levels = Levels {
            largest: vec![1.0, 10.0, 50.0],
        };
        let measure = |all: &Particles, skin: Skin| {
            let mut skin = skin;
            let found = ExtraSkins::measure(all, &mut skin, &levels, 1.2, false);
            (skin.thickness, found)
        };
        let skins = |grains: f64, balls: f64, stone: f64| {
            let grains = (0..1000).map(move |k| (1.0 - 0.5 * f64::from(k % 2), grains));
            let balls = (0..100).map(move |_| (10.0, balls));
            let all = grains.chain(balls).chain([(50.0, stone)]);
            let (thickness, ExtraSkins { levels, rows: all }) = measure(&of_sizes(all), SKIN);
            assert_eq!(thickness, 0.1);
            if all.is_empty() {
                return [0.05; 3];
            }
            assert_eq!(levels, [all[0], all[1000], all[1100]]);
            assert!(all[..1000].iter().all(|&one| one == all[0]));
            assert!(all[1000..1100].iter().all(|&one| one == all[1000]));
            [all[0], all[1000], all[1100]].map(|extra| 0.05 + extra)
        };
        let close = |found: [f64; 3], expected: [f64; 3]| {
            let off = |k: usize| (found[k] - expected[k]).abs() > 1e-15;
            assert!(![0, 1, 2].into_iter().any(off), "{found:?}");
        };
        close(skins(0.04, 0.01, 0.0), [0.05, 0.05 * 0.375, 0.05 / 8.0]);
        close(skins(0.01, 0.04, 0.02), [0.05 * 0.375, 0.05, 0.05 * 0.75]);
        close(skins(0.03, 0.04, 0.04), [0.05; 3]);
        close(skins(0.0, 0.0, 0.0), [0.05; 3]);
        // Grains have at most half a mean radius, balls half of their own; the thickness follows those that went farthest.
        let thick = Skin {
            thickness: 12.0,
            least: 0.01,
            largest: 50.0,
        };
        let bed = |grains: f64, balls: f64| {
            let grains = (0..9).map(move |_| (0.5, grains));
            of_sizes(grains.chain([(10.0, balls)]))
        };
        let (thickness, found) = measure(&bed(0.9, 1.0), thick);
        assert_eq!((thickness, found.rows[9]), (10.0, 0.0));
        assert!((5.0 + found.rows[0] - 0.6).abs() < 1e-15);
        let (thickness, found) = measure(&bed(1.0, 0.01), thick);
        assert_eq!((thickness, found.rows[0]), (1.2, 0.0));
        assert!((0.6 + found.rows[9] - 0.6 / 8.0).abs() < 1e-15);
        // One grain in 200 may stand out from its level, which is slower than the other.
        let grains = (0..1000).map(|k| (1.0, if k == 7 { 0.02 } else { 0.001 }));
        let all = of_sizes(grains.chain((0..100).map(|_| (10.0, 0.04))));
        let all = measure(&all, SKIN).1.rows;
        let expected = |k: usize| match k {
            7 => 0.05 * (1.5 * 0.02 / 0.04),
            0..1000 => 0.05 / 8.0,
            _ => 0.05,
        };
        assert!((0..1100).all(|k| (0.05 + all[k] - expected(k)).abs() < 1e-15));
    }

    #[test]
    fn the_few_that_went_farthest_get_extra_skin() {
        let skin = Skin {
            thickness: 0.1,
            least: 0.01,
            largest: 1.0,
        };
        let far = |k: usize| match k {
            17 => 0.3,
            900 => 5.0,
            k => 1e-5 * k as f64,
        };
        let extra_skin = few(moved_by((0..1000).map(far)), skin);
        // The sixth from the top is the first without.
        let rest = far(996);
        for (k, extra_skin) in extra_skin.into_iter().enumerate() {
            let expected = match k {
                17 | 900 => 0.45,
                k if k > 996 => 0.05 * (1.5 * far(k) / rest - 1.0),
                _ => 0.0,
            };
            assert!(
                (extra_skin - expected).abs() < 1e-12,
                "{k}: {extra_skin}, not {expected}"
            );
        }
        // No particle stands out, no particle moves, there is no space, there are few particles.
        let alike = |k: usize| if k < 2 { 0.19 } else { 0.1 };
        assert!(few(moved_by((0..1000).map(alike)), skin).is_empty());
        assert!(few(moved_by((0..1000).map(|_| 0.0)), skin).is_empty());
        assert!(few(moved_by((0..199).map(|k| k as f64)), skin).is_empty());
        let full = Skin {
            largest: 0.1,
            ..skin
        };
        assert!(few(moved_by((0..1000).map(far)), full).is_empty());
        assert!(few(moved_by(std::iter::empty()), skin).is_empty());
    }

    /// Of particles of one size.
    fn few(particles: Particles, mut skin: Skin) -> Vec<f64> {
        let levels = Levels { largest: vec![1.0] };
        ExtraSkins::measure(&particles, &mut skin, &levels, 1.0, true).rows
    }
}
