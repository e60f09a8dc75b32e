//! Meshes that span a period of a periodic axis, or more, go on for ever along it.
//!
//! At each of the two faces the triangles that lie within reach of the other one are there once more, shifted by a period, with
//! corners joined to those of the face. So edges at the seam are ordinary edges. Of a mesh that is longer than the period all its
//! images are there, as far as they reach into the domain: where they are one surface, contacts are merged as those of any
//! triangles that are there twice. Histories and reports of contacts name the triangles, edges and corners of the file alone: the
//! copies are known as their originals.

use std::collections::HashMap;

use glam::DVec3;

use super::super::error::WallError;
use super::Mesh;

/// How far the extent of a mesh may be from the period that it spans, in periods; corners at the two faces that agree to within
/// this are joined.
const SEAM: f64 = 1e-6;

/// How far the corners of such a mesh may move along an axis of which it spans a period, over the reach for which it is continued:
/// then what lies within a particle's radius and the skin of a face is still there at the other one.
const ROOM: f64 = 0.04;

/// An axis along which a mesh goes on for ever.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Period {
    /// 0, 1, 2: x, y, z.
    pub axis: usize,
    /// Lower face of the period that holds everything near it, in the mesh's own frame, m.
    pub low: f64,
    /// Length of the period, m.
    pub length: f64,
    /// Number of periods that a copy may be away from its original.
    farthest: u32,
    /// The displacement along the axis by which the mesh covers the domain best, m: whole periods.
    home: f64,
}

impl Period {
    /// The displacement (m) by less than a period that puts the mesh in the same places: within half a period of that which covers
    /// the domain best, so that small motions of a mesh that lies in the domain stay as they are.
    #[must_use]
    pub fn reduced(&self, displacement: f64) -> f64 {
        let periods = ((displacement - self.home) / self.length).round();
        if periods == 0.0 {
            displacement
        } else {
            displacement - periods * self.length
        }
    }

    /// Whole periods by which a centre with this coordinate (m, in the mesh's frame) must be shifted to lie between the faces.
    #[must_use]
    pub fn into_base(&self, coordinate: f64) -> f64 {
        -((coordinate - self.low) / self.length).floor()
    }
}

/// Originals of the triangles of a continued mesh.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Continuation {
    pub periods: Vec<Period>,
    /// For every feature the one of the file that it is a copy of; empty where nothing is continued.
    known_as: Vec<u32>,
    /// Copies of corners, each with its original and how far it is from there, m, by their numbers.
    copies: Vec<(u32, u32, DVec3)>,
    /// Corners of the file at the upper face of a period with those that are the same at the lower one, and the axis.
    seams: Vec<(u32, u32, usize)>,
    /// Where the corners were when the copies were made, m.
    first: Vec<DVec3>,
    /// How far they may move from there along the axes, m.
    room: f64,
}

impl Continuation {
    /// Corners that are the same up to whole periods: the higher number first, which follows the other one.
    pub(super) fn twins(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        let copies = self
            .copies
            .iter()
            .map(|&(copy, original, _)| (copy, original));
        let seams = self.seams.iter().map(|&(upper, lower, _)| (upper, lower));
        copies.chain(seams)
    }

    /// How far corners may move from where they were at first along the axes of the periods, m.
    pub(super) fn room(&self) -> f64 {
        self.room
    }
    /// Whether a corner is a copy.
    pub(super) fn is_copy(&self, corner: u32) -> bool {
        let found = self.copies.binary_search_by_key(&corner, |copy| copy.0);
        found.is_ok()
    }

    /// The places of all corners when those of the file are at `places` (m): their copies follow.
    pub(super) fn followed(&self, places: &[DVec3]) -> Result<Vec<DVec3>, WallError> {
        let mut all = places.to_vec();
        for &(copy, original, shift) in &self.copies {
            all[copy as usize] = all[original as usize] + shift;
        }
        for period in &self.periods {
            let axis = period.axis;
            let gone = |(place, first): (&DVec3, &DVec3)| (place[axis] - first[axis]).abs();
            let mut ways = all.iter().zip(&self.first).map(gone);
            // Not a number is too far.
            if let Some(corner) = ways.position(|way| way > self.room || way.is_nan()) {
                return Err(WallError::OffPeriod { corner, axis });
            }
        }
        for &(upper, lower, axis) in &self.seams {
            let period = self.periods.iter().find(|period| period.axis == axis);
            let length = period.map_or(0.0, |period| period.length);
            let apart = all[upper as usize] - all[lower as usize] - length * DVec3::AXES[axis];
            if apart.length() > 2.0 * SEAM * length {
                let corner = upper as usize;
                return Err(WallError::OffPeriod { corner, axis });
            }
        }
        Ok(all)
    }

    /// The feature of the file that a feature is, or is a copy of.
    #[inline]
    pub(super) fn known_as(&self, feature: u32) -> u32 {
        match self.known_as.get(feature as usize) {
            Some(&original) => original,
            None => feature,
        }
    }
}

/// Triangles by their corners, each with the place of its original in the file, and the corners' places (m).
struct Parts {
    vertices: Vec<DVec3>,
    triangles: Vec<(u32, [u32; 3])>,
    /// Origin of each corner: the one of the file, and how far it is from there, m.
    origins: Vec<(u32, DVec3)>,
    /// Corners at the upper face of a period with those that are the same at the lower one, and the axis.
    seams: Vec<(u32, u32, usize)>,
}

impl Mesh {
    /// Axes along which the mesh goes on for ever.
    #[must_use]
    pub fn periods(&self) -> &[Period] {
        &self.continuation.periods
    }

    /// The mesh continued along those periodic axes of which it spans a period or more: `periods` has axis, lower face of the
    /// domain (m) and length (m) of each periodic axis. `reach` (m): how far from its faces queries can be. Nothing if it spans
    /// none of them.
    #[must_use]
    pub fn continued(&self, periods: &[(usize, f64, f64)], reach: f64) -> Option<Self> {
        let (low, high) = self.bounds();
        let is_longer = |axis: usize, length: f64| high[axis] - low[axis] > (1.0 + SEAM) * length;
        let spans = |&&(axis, min, length): &&(usize, f64, f64)| {
            // Farther away it is outside the domain.
            let is_inside = (low[axis] - min).abs() < length;
            let extent = high[axis] - low[axis];
            is_longer(axis, length) || (extent - length).abs() <= SEAM * length && is_inside
        };
        let spanned: Vec<_> = periods.iter().filter(spans).collect();
        if spanned.is_empty() || !self.periods().is_empty() {
            return None;
        }
        let mut parts = self.parts();
        let own = parts.triangles.len();
        let own_corners = parts.vertices.len() as u32;
        let mut found = Vec::new();
        for &&(axis, min, length) in &spanned {
            if is_longer(axis, length) {
                let farthest = parts.copy_over((axis, min, length), reach);
                found.push(Period {
                    axis,
                    low: min,
                    length,
                    farthest,
                    home: 0.0,
                });
                continue;
            }
            parts.copy_across(axis, low[axis], high[axis], reach);
            let beside = (low[axis] - min) / length;
            // A mesh about a corner of the domain is not better off elsewhere.
            let is_there = beside.abs() <= 0.5 + SEAM;
            let home = if is_there {
                0.0
            } else {
                -beside.round() * length
            };
            found.push(Period {
                axis,
                low: low[axis],
                length,
                farthest: 1,
                home,
            });
        }
        let place_in_file: Vec<u32> = parts.triangles.iter().map(|&(place, _)| place).collect();
        let mut kept: Vec<(u32, [u32; 3])> = (0..)
            .zip(&parts.triangles)
            .map(|(key, &(_, corners))| (key, corners))
            .collect();
        let (mut new, number) = self.rebuilt(parts.vertices, &mut kept);
        // Originals come first, in the order of the file.
        let mut originals = vec![0; own];
        for (facet, &key) in (0..).zip(&new.file_order) {
            if let Some(place) = originals.get_mut(key as usize) {
                *place = facet;
            }
        }
        for place in &mut new.file_order {
            *place = place_in_file[*place as usize];
        }
        let numbered = |corner: u32| number[corner as usize];
        let of_file = |corner: u32| corner < own_corners;
        let mut copies: Vec<(u32, u32, DVec3)> = (0..)
            .zip(&parts.origins)
            .filter(|&(copy, _)| !of_file(copy))
            .map(|(copy, &(original, shift))| (numbered(copy), numbered(original), shift))
            .collect();
        copies.sort_unstable_by_key(|copy| copy.0);
        let mut seams: Vec<(u32, u32, usize)> = parts
            .seams
            .iter()
            .filter(|&&(upper, lower, _)| of_file(upper) && of_file(lower))
            .map(|&(upper, lower, axis)| (numbered(upper), numbered(lower), axis))
            .collect();
        seams.sort_unstable();
        new.continuation = Continuation {
            known_as: new.originals_of_features(&originals),
            periods: found,
            copies,
            seams,
            first: new.vertices.clone(),
            room: ROOM * reach,
        };
        Some(new)
    }

    /// Whether a facet is the file's, and no copy.
    pub(super) fn is_own(&self, facet: usize) -> bool {
        self.continuation.known_as(facet as u32) as usize == facet
    }

    /// The whole periods by which images of the mesh may be away from it, m.
    pub(super) fn image_shifts(&self) -> impl Iterator<Item = DVec3> + '_ {
        let steps = |axis: usize| {
            let period = self
                .periods()
                .iter()
                .find(move |period| period.axis == axis);
            let (length, farthest) =
                period.map_or((0.0, 0), |found| (found.length, found.farthest));
            let farthest = i64::from(farthest);
            (-farthest..=farthest).map(move |periods| periods as f64 * length)
        };
        let all = move |x| steps(1).flat_map(move |y| steps(2).map(move |z| DVec3::new(x, y, z)));
        steps(0).flat_map(all)
    }

    /// How far the feature is from a place near `centre`, squared (m^2), by its nearest image.
    pub(super) fn nearest_image(&self, feature: u32, centre: DVec3, foot: DVec3) -> f64 {
        let mut least = f64::INFINITY;
        for shift in self.image_shifts() {
            let nearest = self.nearest_of(feature, centre + shift);
            least = least.min(nearest.distance_squared(foot + shift));
        }
        least
    }

    fn parts(&self) -> Parts {
        let mut triangles: Vec<(u32, [u32; 3])> = self
            .file_order
            .iter()
            .zip(&self.facets)
            .map(|(&place, facet)| (place, facet.vertices))
            .collect();
        triangles.sort_unstable_by_key(|&(place, _)| place);
        Parts {
            vertices: self.vertices.clone(),
            triangles,
            origins: (0..self.vertices.len() as u32)
                .map(|corner| (corner, DVec3::ZERO))
                .collect(),
            seams: Vec::new(),
        }
    }

    /// For every feature the one of the file that it is a copy of; `originals`: the facets of the file in its order.
    fn originals_of_features(&self, originals: &[u32]) -> Vec<u32> {
        let (faces, edges) = (self.facets.len(), self.topology.edge_count());
        let mut sets = Sets::new(faces + edges + self.vertices.len());
        let features = |facet: usize| {
            let edge = |k: usize| faces + self.facets[facet].edges[k] as usize;
            let corner = |k: usize| faces + edges + self.facets[facet].vertices[k] as usize;
            [
                facet,
                edge(0),
                edge(1),
                edge(2),
                corner(0),
                corner(1),
                corner(2),
            ]
        };
        for (facet, &place) in self.file_order.iter().enumerate() {
            let original = originals[place as usize] as usize;
            for (copy, original) in features(facet).into_iter().zip(features(original)) {
                sets.join(copy, original);
            }
        }
        // Around features of the file everything is there; at the rims of the copies something is missing.
        let mut known_as = vec![u32::MAX; sets.parents.len()];
        for &original in originals {
            for feature in features(original as usize) {
                let set = sets.find(feature);
                known_as[set] = known_as[set].min(feature as u32);
            }
        }
        (0..sets.parents.len())
            .map(|feature| match known_as[sets.find(feature)] {
                u32::MAX => feature as u32,
                original => original,
            })
            .collect()
    }
}

impl Parts {
    /// Adds what lies within `reach` (m) of the two faces of a mesh along an axis once more at the other one.
    fn copy_across(&mut self, axis: usize, low: f64, high: f64, reach: f64) {
        let length = high - low;
        let (down, up) = self.seam(axis, low, high);
        let pairs = down.iter().map(|(&upper, &lower)| (upper, lower, axis));
        self.seams.extend(pairs);
        let count = self.triangles.len();
        let mut copies = [down, up];
        for k in 0..count {
            let (place, corners) = self.triangles[k];
            let along = corners.map(|corner| self.vertices[corner as usize][axis]);
            let least = along.into_iter().fold(f64::INFINITY, f64::min);
            let most = along.into_iter().fold(f64::NEG_INFINITY, f64::max);
            let [down, up] = &mut copies;
            for (is_near, shift, copies) in [
                (most > high - reach, -length, down),
                (least < low + reach, length, up),
            ] {
                if is_near {
                    let corners = corners.map(|corner| {
                        *copies
                            .entry(corner)
                            .or_insert_with(|| self.copied(corner, axis, shift))
                    });
                    self.triangles.push((place, corners));
                }
            }
        }
    }

    /// Adds all images along an axis, but for the original, of what comes within `reach` (m) of the period from `low` (m) on. Returns how many
    /// periods the farthest is away.
    fn copy_over(&mut self, (axis, low, length): (usize, f64, f64), reach: f64) -> u32 {
        let mut farthest = 0;
        let mut copies: HashMap<(i64, u32), u32> = HashMap::new();
        for k in 0..self.triangles.len() {
            let (place, corners) = self.triangles[k];
            let along = corners.map(|corner| self.vertices[corner as usize][axis]);
            let least = along.into_iter().fold(f64::INFINITY, f64::min);
            let most = along.into_iter().fold(f64::NEG_INFINITY, f64::max);
            let first = ((low - reach - most) / length).ceil() as i64;
            let last = ((low + length + reach - least) / length).floor() as i64;
            for periods in (first..=last).filter(|&periods| periods != 0) {
                farthest = farthest.max(periods.unsigned_abs() as u32);
                let shift = periods as f64 * length;
                let corners = corners.map(|corner| {
                    *copies
                        .entry((periods, corner))
                        .or_insert_with(|| self.copied(corner, axis, shift))
                });
                self.triangles.push((place, corners));
            }
        }
        farthest
    }

    /// Adds a corner once more, `shift` (m) along an axis.
    fn copied(&mut self, corner: u32, axis: usize, shift: f64) -> u32 {
        let (original, mut way) = self.origins[corner as usize];
        way[axis] += shift;
        self.origins.push((original, way));
        let mut place = self.vertices[corner as usize];
        place[axis] += shift;
        self.vertices.push(place);
        (self.vertices.len() - 1) as u32
    }

    /// Corners at the upper face with their partners at the lower one, and the other way round.
    fn seam(&self, axis: usize, low: f64, high: f64) -> (HashMap<u32, u32>, HashMap<u32, u32>) {
        let same = SEAM * (high - low);
        let across = (axis + 1) % 3;
        let mut used: Vec<u32> = self.triangles.iter().flat_map(|(_, c)| *c).collect();
        used.sort_unstable();
        used.dedup();
        let at_face = |face: f64| {
            let at = |&&corner: &&u32| (self.vertices[corner as usize][axis] - face).abs() <= same;
            used.iter().filter(at).copied().collect::<Vec<u32>>()
        };
        let place = |corner: u32| self.vertices[corner as usize];
        let mut lower = at_face(low);
        lower.sort_by(|&a, &b| {
            place(a)[across]
                .total_cmp(&place(b)[across])
                .then(a.cmp(&b))
        });
        let (mut down, mut up) = (HashMap::new(), HashMap::new());
        for corner in at_face(high) {
            let mut image = place(corner);
            image[axis] -= high - low;
            let begin = lower.partition_point(|&other| place(other)[across] < image[across] - same);
            let near = lower[begin..]
                .iter()
                .take_while(|&&other| place(other)[across] <= image[across] + same);
            let nearest = near.min_by(|&&a, &&b| {
                let distance = |corner: u32| place(corner).distance_squared(image);
                distance(a).total_cmp(&distance(b)).then(a.cmp(&b))
            });
            if let Some(&other) =
                nearest.filter(|&&other| place(other).distance(image) <= 2.0 * same)
            {
                down.insert(corner, other);
                up.entry(other).or_insert(corner);
            }
        }
        (down, up)
    }
}

/// Sets that grow together.
struct Sets {
    parents: Vec<usize>,
}

impl Sets {
    fn new(count: usize) -> Self {
        Self {
            parents: (0..count).collect(),
        }
    }

    fn find(&mut self, mut item: usize) -> usize {
        while self.parents[item] != item {
            self.parents[item] = self.parents[self.parents[item]];
            item = self.parents[item];
        }
        item
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.find(a), self.find(b));
        self.parents[a.max(b)] = a.min(b);
    }
}
