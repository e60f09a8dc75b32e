//! The facets of a leaf of the tree, side by side in single precision, so that a processor bounds the distances of all at once.

use glam::{DVec3, Vec3};

use super::facet::Facet;
use super::patches::Membership;

/// Facets of a leaf.
pub(super) const LANES: usize = 8;

/// Largest error of single precision, over the distance from the place and the size of the leaf: rounding the place, the corners
/// and the normal, their differences and products of three sums up to less than 20 units of 2^-24.
const SINGLE: f32 = 1.5e-6;

/// The shortest way in the plane that counts, over the same.
const LEAST_GAP: f32 = 1e-3;

type Lanes = [f32; LANES];

/// Up to [`LANES`] facets, in seven cache lines; the last one is repeated where there are fewer.
#[derive(Debug, Clone, PartialEq)]
#[repr(align(64))]
pub(super) struct Leaf {
    /// Origin of the corners, m.
    origin: DVec3,
    corners: [[Lanes; 3]; 3],
    /// Normals of the corners' planes.
    normals: [Lanes; 3],
    patches: [Membership; LANES],
    /// Largest coordinate of a corner, m.
    size: f32,
    /// How far a normal that the facets use is from the one here; rounded up.
    skew: f32,
}

/// Lower bounds of the distances of the facets of a leaf from a place: a facet lies in its plane; and, since it is convex, beyond
/// a line in the plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bounds {
    /// Normals of the planes, and heights of the place over them, m.
    normals: [Lanes; 3],
    heights: Lanes,
    /// Directions in the planes, from the foot of the place to a line normal to them, and its distance, m; 0 where the foot may be on the
    /// facet.
    ways: [Lanes; 3],
    gaps: Lanes,
    patches: [Membership; LANES],
    /// Largest error of lengths, m.
    pub slack: f32,
    /// Largest error of a height over the plane of the normal that the facet uses, m.
    pub tilt: f32,
}

/// Lower bound of the distance of one facet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bound {
    pub normal: Vec3,
    pub height: f32,
    pub way: Vec3,
    pub gap: f32,
    pub patch: Membership,
}

fn pick(lanes: &[Lanes; 3], k: usize) -> Vec3 {
    Vec3::new(lanes[0][k], lanes[1][k], lanes[2][k])
}

fn put(lanes: &mut [Lanes; 3], k: usize, x: Vec3) {
    for (lane, x) in lanes.iter_mut().zip(x.to_array()) {
        lane[k] = x;
    }
}

impl Leaf {
    /// Leaf of at least one facet.
    pub(super) fn new(facets: &[Facet]) -> Self {
        let corners = || facets.iter().flat_map(|facet| facet.corners);
        let low = corners().fold(DVec3::INFINITY, DVec3::min);
        let high = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
        let origin = 0.5 * (low + high);
        let mut leaf = Self {
            origin,
            corners: [[[0.0; LANES]; 3]; 3],
            normals: [[0.0; LANES]; 3],
            patches: [Membership::NONE; LANES],
            size: (high - origin).max(origin - low).max_element() as f32,
            skew: 0.0,
        };
        for k in 0..LANES {
            let facet = &facets[k.min(facets.len() - 1)];
            for (lanes, corner) in leaf.corners.iter_mut().zip(facet.corners) {
                put(lanes, k, (corner - origin).as_vec3());
            }
            put(&mut leaf.normals, k, facet.own_normal().as_vec3());
            leaf.patches[k] = facet.patch;
            leaf.skew = leaf.skew.max(facet.skew);
        }
        leaf
    }

    /// Lower bounds of the distances of the facets from `centre`.
    #[inline]
    pub(super) fn bounds(&self, centre: DVec3) -> Bounds {
        let place = (centre - self.origin).as_vec3();
        let farthest = place.length() + 2.0 * self.size;
        let mut out = Bounds {
            normals: self.normals,
            heights: [0.0; LANES],
            ways: [[0.0; LANES]; 3],
            gaps: [0.0; LANES],
            patches: self.patches,
            slack: SINGLE * farthest,
            tilt: (SINGLE + self.skew) * farthest,
        };
        // Without branches, so that it is done for several lanes at once.
        for k in 0..LANES {
            let normal = pick(&self.normals, k);
            let corners = [0, 1, 2].map(|corner| pick(&self.corners[corner], k));
            let from = corners.map(|corner| place - corner);
            let height = from[0].dot(normal);
            let mut nearest = Vec3::ZERO;
            let mut least = f32::INFINITY;
            for side in 0..3 {
                let along = corners[(side + 1) % 3] - corners[side];
                let part = from[side].dot(along) / along.length_squared();
                // Corners that are the same in single precision give what is not a number.
                let part = if part > 0.0 { part } else { 0.0 };
                let part = if part < 1.0 { part } else { 1.0 };
                let way = along * part - from[side];
                let square = way.length_squared();
                let nearer = square < least;
                let choose = |new: f32, old: f32| if nearer { new } else { old };
                nearest.x = choose(way.x, nearest.x);
                nearest.y = choose(way.y, nearest.y);
                nearest.z = choose(way.z, nearest.z);
                least = choose(square, least);
            }
            let way = nearest + normal * height;
            let length = way.length();
            let way = way * (1.0 / length);
            // A short way keeps something of the height in single precision. It would count as distance when the sphere moves away.
            let way = way - normal * way.dot(normal);
            // Whatever the direction, the facet lies beyond the nearest of its corners along it. That is behind if the foot is inside.
            let [a, b, c] = from.map(|from| -from.dot(way));
            let gap = if a < b { a } else { b };
            let gap = if c < gap { c } else { gap };
            // The direction of a shorter way is not known.
            let known = (length > LEAST_GAP * farthest) & (gap > 0.0);
            let keep = |x: f32| if known { x } else { 0.0 };
            out.heights[k] = height;
            out.gaps[k] = keep(gap);
            out.ways[0][k] = keep(way.x);
            out.ways[1][k] = keep(way.y);
            out.ways[2][k] = keep(way.z);
        }
        out
    }
}

impl Bounds {
    /// The distance to compare with where a facet may be as near as `reach` (m).
    #[inline]
    pub(super) fn farthest(&self, reach: f64) -> f32 {
        (reach * (1.0 + 1e-7)) as f32 + self.slack
    }

    /// Largest underestimate of the distances of facets from a place within `within` (m) of this one, m.
    #[inline]
    pub(super) fn loose(&self, within: f64) -> f32 {
        let farthest = self.slack / SINGLE + within as f32;
        // Of what is beside a facet a short way is not known.
        (LEAST_GAP + 5.0 * SINGLE) * farthest
    }

    /// The squares of the distances, without slack, m^2.
    #[inline]
    pub(super) fn squares(&self) -> Lanes {
        let mut squares = [0.0; LANES];
        for (k, square) in squares.iter_mut().enumerate() {
            *square = self.heights[k] * self.heights[k] + self.gaps[k] * self.gaps[k];
        }
        squares
    }

    #[inline]
    pub(super) fn of(&self, k: usize) -> Bound {
        Bound {
            normal: pick(&self.normals, k),
            height: self.heights[k],
            way: pick(&self.ways, k),
            gap: self.gaps[k],
            patch: self.patches[k],
        }
    }
}

#[cfg(test)]
mod tests {
    use mercury_common::random::Stream;
    use proptest::prelude::*;

    use super::*;

    /// Normals that were steadied after the corners' planes: heights over them are not farther from those here than the tilt.
    #[test]
    fn the_tilt_covers_steadied_normals() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let mut facet = Facet::new(&corners, [0, 1, 2], [0, 1, 2]);
        facet.set_normal(DVec3::new(1e-3, 0.0, 1.0).normalize());
        let leaf = Leaf::new(std::slice::from_ref(&facet));
        for x in [DVec3::new(50.0, 0.0, 1.0), DVec3::new(-50.0, 3.0, 1.0)] {
            let bounds = leaf.bounds(x);
            let off = (f64::from(bounds.heights[0]) - facet.height(x)).abs();
            // Nearly all of it: the sphere is far in the direction in which the normal is off.
            let tilt = f64::from(bounds.tilt);
            assert!(off <= tilt && off > 0.9 * tilt, "{off} of {tilt}");
        }
    }

    proptest! {
        /// Never farther than the facet, wherever the place: above it, beside it, and above its sides to within any distance, where
        /// the direction to the facet is all but lost in single precision. And hardly nearer.
        #[test]
        fn bounds_hold_and_are_tight(
            seed in any::<u64>(),
            count in 1..=LANES,
            thin in 0.0..5.0f64,
            away in 0.0..3.0f64,
            height in -2.0..2.0f64,
            beside in 1.0..12.0f64,
        ) {
            let mut random = Stream::new(seed, "leaf", 0);
            let shift = DVec3::new(3.0, -5.0, 7.0) * 10f64.powf(away);
            let mut any = || {
                2.0 * DVec3::new(random.uniform(), random.uniform(), random.uniform()) - 1.0
            };
            let facets: Vec<Facet> = (0..count)
                .map(|_| {
                    let (a, b) = (any(), any());
                    let c = 0.3 * a + 0.7 * b + any() * 10f64.powf(-thin);
                    let corners = [a, b, c].map(|x| x + shift);
                    Facet::new(&corners, [0, 1, 2], [0, 1, 2])
                })
                .collect();
            let leaf = Leaf::new(&facets);
            for facet in &facets {
                let [a, b, c] = facet.corners;
                let offset = 10f64.powf(-beside);
                let outwards = (b - a).cross(facet.normal).normalize();
                let feet = [
                    (a + b + c) / 3.0,
                    (a + b) / 2.0 + outwards * offset,
                    (a + b) / 2.0 - outwards * offset,
                    a + (a - c).normalize() * offset,
                    a + any(),
                ];
                for foot in feet {
                    let place = foot + facet.normal * height;
                    let bounds = leaf.bounds(place);
                    let slack = f64::from(bounds.slack);
                    let farthest = slack / f64::from(SINGLE);
                    for (k, square) in bounds.squares().into_iter().enumerate() {
                        let other = &facets[k.min(count - 1)];
                        let exact = other.nearest(place, f64::INFINITY).unwrap().distance;
                        let least = f64::from(square).sqrt();
                        prop_assert!(least - slack <= exact, "{least} of {exact}: {other:?}, {place}");
                        let loose = f64::from(LEAST_GAP) * farthest + 2.0 * slack;
                        prop_assert!(least + loose >= exact, "{least} of {exact}: {other:?}, {place}");
                    }
                }
            }
        }
    }
}
