//! Extra skin for the few particles that move farthest.

use super::Skin;
use super::validity::displacement;
use crate::parallel::{each, map_parts};
use crate::state::Particles;

/// One particle of this many gets extra skin.
const FEW: usize = 200;
/// Factor on the way of the rest that a particle must have gone: pairs of particles with extra skin are harder to find.
const WORTH_IT: f64 = 2.0;
/// Factor on the way of a particle while the last list lasted: a fast particle may be accelerating.
const MORE: f64 = 1.5;

/// Distance beyond half the skin that each particle may go before the next list is built, m, by how far it went while the last
/// list lasted; empty if none may go farther.
///
/// The list is built anew when a particle has used up its part of the skin. Where a few move much farther than all others (a stone
/// that falls into a bed, and the grains that it pushes away), they would set the pace for all. So the farthest of each 200 are
/// listed farther out, so that they use up their part at about the same time as the rest: a few more pairs for fewer lists.
#[must_use]
pub fn extra_skins(particles: &Particles, skin: &Skin, parallel: bool) -> Vec<f64> {
    let few = particles.len() / FEW;
    let half = 0.5 * skin.thickness;
    // No pair is listed farther out than the largest skin.
    let most = 0.5 * skin.largest - half;
    if few == 0 || most <= 0.0 {
        return Vec::new();
    }
    let moved = each(particles.len(), parallel, |row| {
        displacement(particles, row)
    });
    let parts = if parallel {
        rayon::current_num_threads()
    } else {
        1
    };
    let farthest = farthest(&moved, few + 1, parts);
    let rest = farthest[0];
    if farthest.iter().all(|&far| far <= WORTH_IT * rest) {
        return Vec::new();
    }
    each(moved.len(), parallel, |row| {
        if moved[row] > rest {
            (half * (MORE * moved[row] / rest - 1.0)).min(most)
        } else {
            0.0
        }
    })
}

/// The `count` largest of all distances, the smallest of them first. Threads select those of each part of the rows, and one thread
/// selects from these.
fn farthest(ways: &[f64], count: usize, parts: usize) -> Vec<f64> {
    let largest = |mut of: Vec<f64>| {
        let below = of.len().saturating_sub(count);
        of.select_nth_unstable_by(below, f64::total_cmp);
        of.split_off(below)
    };
    let parts = ways.chunks(ways.len().div_ceil(parts));
    let of_parts = map_parts(parts.len() > 1, parts, |part| largest(part.to_vec()));
    largest(of_parts.concat())
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use proptest::prelude::*;

    use super::*;
    use crate::state::{MaterialIndex, Particle};

    fn moved_by(ways: impl Iterator<Item = f64>) -> Particles {
        let mut particles = Particles::new(false);
        for way in ways {
            let record = Particle {
                position: DVec3::ZERO,
                radius: 1.0,
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

    #[test]
    fn the_few_that_went_farthest_get_extra_skin() {
        let skin = Skin {
            thickness: 0.1,
            least: 0.01,
            largest: 1.0,
        };
        let few = |ways: &dyn Fn(usize) -> f64, count: usize, skin: &Skin| {
            let particles = moved_by((0..count).map(ways));
            let found = extra_skins(&particles, skin, false);
            assert_eq!(found, extra_skins(&particles, skin, true));
            found
        };
        let far = |k: usize| match k {
            17 => 0.3,
            900 => 5.0,
            k => 1e-5 * k as f64,
        };
        // The sixth from the top is the first without.
        let rest = far(996);
        for (k, extra_skin) in few(&far, 1000, &skin).into_iter().enumerate() {
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
        // No particle stands out, no particle moves, there are few particles or none, there is no space.
        let alike = |k: usize| if k < 2 { 0.19 } else { 0.1 };
        assert!(few(&alike, 1000, &skin).is_empty());
        assert!(few(&|_| 0.0, 1000, &skin).is_empty());
        assert!(few(&|k| k as f64, 199, &skin).is_empty());
        assert!(few(&far, 0, &skin).is_empty());
        let full = Skin {
            largest: 0.1,
            ..skin
        };
        assert!(few(&far, 1000, &full).is_empty());
    }

    proptest! {
        #[test]
        fn the_farthest_of_parts_are_those_of_all(
            ways in prop::collection::vec(0.0..1.0, 1..300),
            place in any::<prop::sample::Index>(),
            parts in 1..9usize,
        ) {
            let count = 1 + place.index(ways.len());
            let mut found = farthest(&ways, count, parts);
            let mut sorted = ways;
            sorted.sort_unstable_by(f64::total_cmp);
            let expected = sorted.split_off(sorted.len() - count);
            prop_assert_eq!(found[0], expected[0]);
            found.sort_unstable_by(f64::total_cmp);
            prop_assert_eq!(found, expected);
        }
    }
}
