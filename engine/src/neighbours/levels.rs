//! Levels of sizes, each with cells of its own.

use glam::DVec3;

use crate::state::Particle;

/// Largest number of size classes in the choice of levels: 2^(CLASSES - 1) choices are compared.
const CLASSES: usize = 11;
/// Time to read a run of cells over the time to test a pair (measured; only for speed).
const RUN_OVER_TEST: f64 = 3.0;
/// Another level must save this share of the cost: it also has costs outside of the model.
const WORTH_IT: f64 = 0.1;

/// The distribution of particles over levels by their radius.
///
/// In a single grid the largest particle sets the size of the cells, and small particles test all that lie in them. With levels the
/// particles of one level find each other in cells of their own size, and a larger one looks for smaller ones in the
/// cells of theirs. The idea of choosing levels by a model of the cost is that of Krijgsman, Ogarko & Luding (2014), Comput.
/// Part. Mech. 1, 357; the model here is for sorted cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Levels {
    /// Largest radius of each level, m, ascending; one level at least.
    pub largest: Vec<f64>,
}

impl Levels {
    /// The levels for particles that are listed when closer than `skin` (m), by the least expected number of tests.
    #[must_use]
    pub fn choose(records: &[Particle], skin: f64) -> Self {
        let extent = || {
            let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            for record in records {
                low = low.min(record.position);
                high = high.max(record.position);
            }
            high - low
        };
        Self::for_sizes(
            records.iter().map(|record| (record.radius, 1.0)),
            extent,
            skin,
        )
    }

    /// Levels for particles that do not exist yet: `sizes` gives the expected number for each radius (m), `extent` the extent of
    /// their centres along x, y, z (m).
    #[must_use]
    pub fn for_sizes(
        sizes: impl Iterator<Item = (f64, f64)> + Clone,
        extent: impl FnOnce() -> DVec3,
        skin: f64,
    ) -> Self {
        let (mut least, mut most) = (f64::INFINITY, 0.0f64);
        for (radius, _) in sizes.clone() {
            least = least.min(radius);
            most = most.max(radius);
        }
        // Below a ratio of 2 a second level can never pay.
        if most <= 2.0 * least {
            return Self {
                largest: vec![most],
            };
        }
        let classes = Classes::new(sizes, extent(), least, most);
        let (mut best, mut cost) = (0u32, classes.cost(0, skin));
        for cuts in 1..1u32 << (classes.classes.len() - 1) {
            let candidate = classes.cost(cuts, skin);
            let more = cuts.count_ones().saturating_sub(best.count_ones());
            if candidate < cost * (1.0 - WORTH_IT * f64::from(more.min(1))) {
                (best, cost) = (cuts, candidate);
            }
        }
        Self {
            largest: classes.levels(best).map(|level| level.largest).collect(),
        }
    }

    /// The level of a particle of this radius (m).
    #[inline]
    #[must_use]
    pub fn of(&self, radius: f64) -> usize {
        let below = self.largest.partition_point(|&largest| largest < radius);
        below.min(self.largest.len() - 1)
    }
}

/// Particles of similar size: how many, and the largest radius (m).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Class {
    count: f64,
    largest: f64,
}

/// The quantities on which the cost depends.
struct Classes {
    /// Classes by size, ascending; each holds a particle.
    classes: Vec<Class>,
    /// Extent of the particles' centres, m.
    extent: DVec3,
}

impl Classes {
    fn new(sizes: impl Iterator<Item = (f64, f64)>, extent: DVec3, least: f64, most: f64) -> Self {
        // Classes of a factor of two, wider for a very wide distribution.
        let count = (libm::log2(most / least).ceil() as usize).clamp(1, CLASSES);
        let per_class = count as f64 / libm::log2(most / least);
        let mut classes = vec![Class::default(); count];
        for (radius, expected) in sizes {
            let index = (libm::log2(radius / least) * per_class) as usize;
            let class = &mut classes[index.min(count - 1)];
            class.count += expected;
            class.largest = class.largest.max(radius);
        }
        classes.retain(|class| class.count > 0.0);
        Self { classes, extent }
    }

    /// The levels for a cut behind class `k` for each set bit `k` of `cuts`.
    fn levels(&self, cuts: u32) -> impl Iterator<Item = Class> + '_ {
        let mut level = Class::default();
        let ends = move |k: usize| k + 1 == self.classes.len() || cuts >> k & 1 == 1;
        self.classes
            .iter()
            .enumerate()
            .filter_map(move |(k, class)| {
                level.count += class.count;
                level.largest = class.largest;
                ends(k).then(|| std::mem::take(&mut level))
            })
    }

    /// Expected time of one search, in tests of a pair.
    fn cost(&self, cuts: u32, skin: f64) -> f64 {
        // The part of evenly spread particles that lies in a cube of this edge.
        let part = |edge: f64| {
            let of_axis = |extent: f64| if extent > edge { edge / extent } else { 1.0 };
            of_axis(self.extent.x) * of_axis(self.extent.y) * of_axis(self.extent.z)
        };
        let mut cost = 0.0;
        for (above, large) in self.levels(cuts).enumerate() {
            let cell = 2.0 * large.largest + skin;
            cost += large.count * (0.5 * large.count * part(3.0 * cell) + 5.0 * RUN_OVER_TEST);
            for small in self.levels(cuts).take(above) {
                let cell = 2.0 * small.largest + skin;
                let reach = large.largest + small.largest + skin;
                let across = 2.0 * reach / cell + 1.0;
                let runs = across * across;
                let tests = small.count * part(2.0 * reach + cell);
                cost += large.count * (tests + RUN_OVER_TEST * runs);
            }
        }
        cost
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::MaterialIndex;

    fn packing(radii: &[(usize, f64)], size: DVec3) -> Vec<Particle> {
        let mut random = mercury_common::random::Stream::new(1, "levels test", 0);
        let radii = radii
            .iter()
            .flat_map(|&(count, r)| std::iter::repeat_n(r, count));
        radii
            .map(|radius| Particle {
                position: DVec3::new(random.uniform(), random.uniform(), random.uniform()) * size,
                radius,
                velocity: DVec3::ZERO,
                inverse_mass: 1.0,
                angular_velocity: DVec3::ZERO,
                material: MaterialIndex::new(0),
                flags: 0,
            })
            .collect()
    }

    #[test]
    fn narrow_sizes_have_one_level() {
        let records = packing(&[(500, 1.0), (500, 1.9)], DVec3::splat(20.0));
        assert_eq!(Levels::choose(&records, 0.1).largest, [1.9]);
        assert_eq!(Levels::choose(&[], 0.1).largest, [0.0]);
    }

    #[test]
    fn one_large_sphere_in_a_bed_has_a_level_of_its_own() {
        let records = packing(&[(20_000, 1.0), (1, 20.0)], DVec3::splat(60.0));
        assert_eq!(Levels::choose(&records, 0.1).largest, [1.0, 20.0]);
    }

    #[test]
    fn wide_sizes_have_many_levels_and_every_particle_has_one() {
        // a thousandth of the particles per tenfold size: equal volumes
        let radii = [(1_000_000 / 8, 1.0), (125, 10.0), (1, 100.0)];
        let levels = Levels::choose(&packing(&radii, DVec3::splat(300.0)), 0.1);
        assert_eq!(levels.largest, [1.0, 10.0, 100.0]);
        for (radius, level) in [(0.5, 0), (1.0, 0), (1.1, 1), (10.0, 1), (100.0, 2)] {
            assert_eq!(levels.of(radius), level);
        }
    }

    #[test]
    fn flat_and_single_scenes_have_levels_too() {
        let flat = packing(&[(20_000, 1.0), (1, 30.0)], DVec3::new(300.0, 300.0, 0.0));
        assert_eq!(Levels::choose(&flat, 0.1).largest, [1.0, 30.0]);
        let two = packing(&[(1, 1.0), (1, 30.0)], DVec3::splat(10.0));
        assert_eq!(Levels::choose(&two, 0.1).largest.last(), Some(&30.0));
    }
}
