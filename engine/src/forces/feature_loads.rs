//! Loads on the faces, edges and corners of mesh walls, summed up from step to step.
//!
//! Each block of rows sums up its own contacts in their order; when the rows are cut anew, and on each reading, the sums of the
//! blocks are added in the order of the blocks. So the number of threads changes nothing.

use std::collections::{BTreeMap, HashMap};
use std::hash::{BuildHasherDefault, Hasher};

use glam::DVec3;

/// A feature of a wall: indices of the wall and of its face, edge or corner.
pub type FeatureKey = (u16, u32);

/// Loads of contacts on one feature of a wall, summed over force evaluations. Vectors are in the wall's own frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FeatureLoad {
    /// Forces of the particles on the wall, N.
    pub force: DVec3,
    /// Their parts in the tangent planes of the contacts, N.
    pub shear: DVec3,
    /// Normal forces, positive where they press, N.
    pub normal: f64,
    /// Energy dissipated by sliding, J.
    pub slip: f64,
}

impl FeatureLoad {
    /// Adds the loads of another one.
    pub fn add(&mut self, other: &Self) {
        self.force += other.force;
        self.shear += other.shear;
        self.normal += other.normal;
        self.slip += other.slip;
    }

    /// A fraction of it.
    #[must_use]
    pub fn times(&self, part: f64) -> Self {
        Self {
            force: self.force * part,
            shear: self.shear * part,
            normal: self.normal * part,
            slip: self.slip * part,
        }
    }
}

/// The loads on all features that were touched.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FeatureLoads {
    sums: HashMap<FeatureKey, FeatureLoad, BuildHasherDefault<KeyHasher>>,
}

impl FeatureLoads {
    /// Adds the load of one contact.
    #[inline]
    pub fn add(&mut self, key: FeatureKey, load: &FeatureLoad) {
        self.sums.entry(key).or_default().add(load);
    }

    /// Adds all of another one. Each sum grows by one number, so the order within `other` does not matter.
    pub fn merge(&mut self, other: &Self) {
        for (key, load) in &other.sums {
            self.add(*key, load);
        }
    }

    /// The features in order, with their loads.
    #[must_use]
    pub fn sorted(&self) -> Vec<(FeatureKey, FeatureLoad)> {
        let mut all: Vec<_> = self.sums.iter().map(|(&key, &load)| (key, load)).collect();
        all.sort_unstable_by_key(|&(key, _)| key);
        all
    }
}

/// Mixes the two indices of a key; the keys are ours, so collisions cannot be provoked.
#[derive(Debug, Clone, Default)]
struct KeyHasher(u64);

impl Hasher for KeyHasher {
    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_u32(byte.into());
        }
    }

    fn write_u16(&mut self, index: u16) {
        self.write_u32(index.into());
    }

    fn write_u32(&mut self, index: u32) {
        // 2^64 over the golden ratio: multiples of it are spread evenly (Knuth 1998, vol. 3, section 6.4).
        self.0 = (self.0.rotate_left(32) ^ u64::from(index)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    }

    fn finish(&self) -> u64 {
        self.0
    }
}

/// Loads summed over a number of force evaluations.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LoadSums {
    /// Force evaluations.
    pub evaluations: u64,
    /// Sums by feature.
    pub loads: BTreeMap<FeatureKey, FeatureLoad>,
}

impl LoadSums {
    /// Adds the loads of `evaluations` further evaluations.
    pub fn add(&mut self, evaluations: u64, loads: &[(FeatureKey, FeatureLoad)]) {
        self.evaluations += evaluations;
        for (key, load) in loads {
            self.loads.entry(*key).or_default().add(load);
        }
    }
}

crate::state::plain!(FeatureLoad {
    force,
    shear,
    normal,
    slip
});

crate::state::plain!(LoadSums { evaluations, loads });

#[cfg(test)]
mod tests {
    use super::*;

    fn load(normal: f64) -> FeatureLoad {
        FeatureLoad {
            normal,
            ..FeatureLoad::default()
        }
    }

    /// Sums are made per feature in the order of the blocks, whatever order the blocks' tables have.
    #[test]
    fn blocks_add_in_their_order() {
        let keys: Vec<FeatureKey> = (0..100).map(|k| (k as u16 % 3, k * k)).collect();
        let mut forwards = FeatureLoads::default();
        let mut backwards = FeatureLoads::default();
        for block in 0..10 {
            let part = |key: FeatureKey| load(0.1 * f64::from(key.1) + 1e-9 * f64::from(block));
            let (mut one, mut other) = (FeatureLoads::default(), FeatureLoads::default());
            for &key in &keys {
                one.add(key, &part(key));
            }
            for &key in keys.iter().rev() {
                other.add(key, &part(key));
            }
            forwards.merge(&one);
            backwards.merge(&other);
        }
        let sorted = forwards.sorted();
        assert_eq!(sorted, backwards.sorted());
        assert_eq!(sorted.len(), 100);
        assert!(sorted.is_sorted_by_key(|&(key, _)| key));
        let mut sums = LoadSums::default();
        sums.add(2, &sorted);
        sums.add(3, &sorted);
        assert_eq!(sums.evaluations, 5);
        assert_eq!(
            sums.loads[&keys[7]].normal,
            2.0 * sorted
                .iter()
                .find(|(key, _)| *key == keys[7])
                .unwrap()
                .1
                .normal
        );
    }
}
