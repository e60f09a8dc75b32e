//! Extra skin for the few that move farthest.

use super::Skin;
use super::rows::each;
use super::validity::displacement;
use crate::state::Particles;

/// One particle of so many gets extra skin.
const FEW: usize = 200;
/// How much farther than the rest somebody must have gone: pairs of particles with extra skin are harder to find.
const WORTH_IT: f64 = 2.0;
/// How much farther a particle may go, over what it went while the last list lasted: what is fast now may have been speeding up.
const MORE: f64 = 1.5;

/// How much farther than half the skin each particle may go before the next list is built (m), by how far it went while the last one
/// lasted; empty if none gets any.
///
/// The list is built anew when a particle has used up its part of the skin. Where a few move much farther than all others, as a
/// stone that falls into a bed and the grains that it pushes away, they would set the pace for all. So the farthest of each
/// 200 are listed farther out, by as much as lets the rest use up the skin: some pairs more, for fewer lists.
#[must_use]
pub fn extra_skins(particles: &Particles, skin: &Skin, parallel: bool) -> Vec<f64> {
    let few = particles.len() / FEW;
    // So that no pair is listed farther out than the largest skin says.
    let most = 0.5 * (skin.largest - skin.thickness);
    if few == 0 || most <= 0.0 {
        return Vec::new();
    }
    let moved = each(particles.len(), parallel, |row| {
        displacement(particles, row)
    });
    let mut sorted = moved.clone();
    let place = sorted.len() - 1 - few;
    let (_, &mut rest, faster) = sorted.select_nth_unstable_by(place, f64::total_cmp);
    if faster.iter().all(|&far| far <= WORTH_IT * rest) {
        return Vec::new();
    }
    let of = |far: f64| {
        if far > rest {
            (0.5 * skin.thickness * (MORE * far / rest - 1.0)).min(most)
        } else {
            0.0
        }
    };
    each(moved.len(), parallel, |row| of(moved[row]))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

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
        let far = |k: usize| match k {
            17 => 0.3,
            900 => 5.0,
            k => 1e-5 * k as f64,
        };
        let extra_skin = extra_skins(&moved_by((0..1000).map(far)), &skin, false);
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
        // Nobody stands out much, nobody moves, there is no room, there are few.
        assert!(
            extra_skins(
                &moved_by((0..1000).map(|k| if k < 2 { 0.19 } else { 0.1 })),
                &skin,
                false
            )
            .is_empty()
        );
        assert!(extra_skins(&moved_by((0..1000).map(|_| 0.0)), &skin, false).is_empty());
        assert!(extra_skins(&moved_by((0..199).map(|k| k as f64)), &skin, false).is_empty());
        let full = Skin {
            largest: 0.1,
            ..skin
        };
        assert!(extra_skins(&moved_by((0..1000).map(far)), &full, true).is_empty());
    }
}
