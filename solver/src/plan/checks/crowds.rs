//! Many spheres in one place: found before all pairs are listed, of which there would be too many.

use std::collections::HashMap;

use glam::DVec3;

use crate::plan::particles::StartingSphere;

/// Spheres in a cube any two of which overlap by more than the limit; so many make a list of all pairs long.
const CROWD: usize = 16;

/// Pairs that touch, for each sphere on the average: up to this number they are tested one by one, whatever the limit.
pub(super) const MOST_TOUCHING: usize = 500;

/// The spheres of a cube any two of which overlap by more than a part of the smaller radius. Those of a grain come one after the other.
#[derive(Default)]
struct Cube {
    spheres: usize,
    /// The first grain and the last so far, with the spheres of each.
    first: (usize, usize),
    last: (usize, usize),
    /// Pairs of spheres of one grain, without those of the last.
    inner: usize,
}

impl Cube {
    fn add(&mut self, grain: usize) {
        let pairs = |spheres: usize| spheres * spheres.saturating_sub(1) / 2;
        if self.spheres == 0 {
            (self.first, self.last) = ((grain, 0), (grain, 0));
        }
        if self.last.0 != grain {
            self.inner += pairs(self.last.1);
            self.last = (grain, 0);
        }
        self.last.1 += 1;
        self.first.1 += usize::from(self.first.0 == grain);
        self.spheres += 1;
    }

    /// Spheres that are not of the first grain.
    fn others(&self) -> usize {
        self.spheres - self.first.1
    }

    /// Pairs of spheres of different grains.
    fn pairs(&self) -> f64 {
        let all = |spheres: usize| spheres as f64 * (spheres as f64 - 1.0) / 2.0;
        all(self.spheres) - self.inner as f64 - all(self.last.1)
    }

    fn ends(&self) -> (usize, usize) {
        (self.first.0, self.last.0)
    }
}

/// Cubes of spheres.
#[derive(Default)]
struct Cubes(HashMap<(i32, [u64; 3]), Cube>);

impl Cubes {
    /// Puts a sphere into its cube of those in which any two overlap by more than `limit` of the smaller radius, below 2.
    fn add(&mut self, sphere: &StartingSphere, limit: f64) -> &Cube {
        // Radii of a class differ by less than a factor of two: centres nearer than (2 - limit) of the least overlap by more than the limit.
        let class = libm::ilogb(sphere.radius);
        let edge = (2.0 - limit) * libm::scalbn(1.0, class) / 3.0_f64.sqrt();
        // Cells by the bits of their coordinates, which may be beyond all whole numbers.
        let cell = (sphere.centre / edge).floor() + DVec3::ZERO;
        let key = (class, cell.to_array().map(f64::to_bits));
        let cube = self.0.entry(key).or_default();
        cube.add(sphere.grain);
        cube
    }
}

/// Two overlapping grains, if there are such: spheres that are no pebbles of one body nor both fixed, each two of which overlap
/// by more than `limit` of the smaller radius. Checked before all pairs are listed, as those of a thousand spheres at one point
/// are a million.
pub(super) fn crowded(spheres: &[StartingSphere], limit: f64) -> Option<(usize, usize)> {
    if limit >= 2.0 {
        return None;
    }
    let mut cubes = Cubes::default();
    for sphere in spheres.iter().filter(|sphere| !sphere.fixed) {
        let cube = cubes.add(sphere, limit);
        if cube.others() >= CROWD {
            return Some(cube.ends());
        }
    }
    None
}

/// Two grains of the largest crowd, if there are more pairs than can be looked at: where the limit allows for almost any overlap, and
/// among fixed spheres, which may overlap.
pub(super) fn too_many(spheres: &[StartingSphere], limit: f64) -> Option<(usize, usize)> {
    let mut cubes = Cubes::default();
    // A grain below this limit that can move is in no crowd of more than some thousands.
    for sphere in spheres.iter().filter(|sphere| sphere.fixed || limit > 1.0) {
        cubes.add(sphere, 0.0);
    }
    let all: f64 = cubes.0.values().map(Cube::pairs).sum();
    if all <= MOST_TOUCHING as f64 * spheres.len() as f64 {
        return None;
    }
    // Of equal ones the first, whatever the order in memory.
    let crowds = cubes.0.values().filter(|cube| cube.others() > 0);
    let largest = crowds.max_by_key(|cube| (cube.others(), std::cmp::Reverse(cube.first)))?;
    Some(largest.ends())
}
