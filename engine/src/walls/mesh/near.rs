//! Lists of the facets near a sphere, so that a step tests only those that may have come to be the nearest.

use glam::{DVec3, Vec3};

use super::super::touch::Touches;
use super::leaf::{Bound, LANES};
use super::patches::NO_GROUP;
use super::{Mesh, Scratch, Search};
use crate::memory::prefetch;

/// Most facets in a list, if a skin of [`LEAST_SKIN`] holds no more.
const LONG: usize = 32;
/// Thickness of the skin of a list over the radius: the least and the largest.
const LEAST_SKIN: f64 = 0.02;
const LARGEST_SKIN: f64 = 0.25;
/// How far ahead of a moving sphere its next list is made, over the skin.
const AHEAD: f64 = 0.7;
/// Number of spheres ahead for which lists and facets are prefetched: a few calls take as long as a memory access.
const LISTS_AHEAD: usize = 6;
const FACETS_AHEAD: usize = 3;
/// Largest error of single precision when a list is used, over the largest distance in it.
const SINGLE: f64 = 5e-7;

/// Facets of a [`Pack`].
const PACK: usize = 4;

/// Facets near a sphere, side by side with a bound on their distance that takes a few operations.
///
/// A facet lies in its plane; and, since it is convex, beyond the line in the plane that is normal to the way from the foot of the
/// sphere's centre to the nearest point of the facet. So it is no nearer than that half plane, wherever the sphere goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pack {
    /// Normals of the planes, and heights of the centre over them, m.
    normals: [[f32; PACK]; 3],
    heights: [f32; PACK],
    /// Directions and lengths (m) of the ways from the feet to the lines; 0 if a foot is on the facet.
    ways: [[f32; PACK]; 3],
    gaps: [f32; PACK],
    /// Indices of the facets.
    facets: [u32; PACK],
    /// Patch and side, if the sphere cannot change sides within the skin.
    groups: [u32; PACK],
    /// Distance of the nearest one, m; rounded down.
    distance: f32,
}

impl Pack {
    /// No facets: infinitely far.
    const EMPTY: Self = Self {
        normals: [[0.0; PACK]; 3],
        heights: [f32::INFINITY; PACK],
        ways: [[0.0; PACK]; 3],
        gaps: [0.0; PACK],
        facets: [u32::MAX; PACK],
        groups: [NO_GROUP; PACK],
        distance: f32::INFINITY,
    };

    fn put(&mut self, k: usize, bound: &Bound, (facet, group): (u32, u32)) {
        for axis in 0..3 {
            self.normals[axis][k] = bound.normal[axis];
            self.ways[axis][k] = bound.way[axis];
        }
        self.heights[k] = bound.height;
        self.gaps[k] = bound.gap;
        self.facets[k] = facet;
        self.groups[k] = group;
    }

    /// Lower bounds of the squares of the distances (m^2), when the sphere has `moved` (m). `slack`: see [`SINGLE`].
    #[inline]
    fn bounds(&self, moved: Vec3, slack: f32) -> [f32; PACK] {
        let mut squares = [0.0; PACK];
        for (k, square) in squares.iter_mut().enumerate() {
            let [normal, way] = [&self.normals, &self.ways]
                .map(|lanes| Vec3::new(lanes[0][k], lanes[1][k], lanes[2][k]));
            let height = (self.heights[k] + normal.dot(moved)).abs() - slack;
            let gap = self.gaps[k] - way.dot(moved) - slack;
            let height = if height > 0.0 { height } else { 0.0 };
            let gap = if gap > 0.0 { gap } else { 0.0 };
            *square = height * height + gap * gap;
        }
        squares
    }
}

/// The facets near a place, the nearest first.
#[derive(Clone, Copy)]
pub(super) struct Near<'a> {
    pub packs: &'a [Pack],
    /// Largest error of their distances, m.
    pub slack: f32,
    /// How far facets may have moved since, m.
    pub moved: f64,
}

impl Near<'_> {
    /// Replaces `bounds` by what the squares of the distances (m^2) of the facets are at least, when the sphere has `moved` (m).
    /// Stops where all others are farther than `reach` (m).
    #[inline]
    pub(super) fn bounds(&self, moved: DVec3, reach: f64, bounds: &mut Vec<f32>) {
        let way = moved.length();
        let farthest = (reach + way + self.moved) * (1.0 + 1e-6);
        let slack = self.slack + (SINGLE * (reach + 2.0 * way) + self.moved * (1.0 + 1e-6)) as f32;
        let moved = moved.as_vec3();
        bounds.clear();
        for pack in self.packs {
            if f64::from(pack.distance) >= farthest {
                break;
            }
            bounds.extend_from_slice(&pack.bounds(moved, slack));
        }
    }

    /// Index and group of a facet.
    #[inline]
    pub(super) fn facet(&self, k: usize) -> (usize, u32) {
        let pack = &self.packs[k / PACK];
        // Where facets have moved, patches are others too.
        let group = if self.moved == 0.0 {
            pack.groups[k % PACK]
        } else {
            NO_GROUP
        };
        (pack.facets[k % PACK] as usize, group)
    }

    /// Indices of the facets.
    pub(super) fn facets(&self) -> impl Iterator<Item = usize> {
        let all = self.packs.iter().flat_map(|pack| pack.facets);
        all.filter(|&facet| facet != u32::MAX)
            .map(|facet| facet as usize)
    }
}

impl Mesh {
    /// Replaces `out` by the facets closer than `reach` + `skin` (m) to `centre`, at most about [`LONG`] if the skin can be made
    /// thinner for that, but not thinner than `least` (m). The nearest facet comes first. Returns the skin with which the list is
    /// right, and what its distances may be off by, m.
    pub(super) fn list(
        &self,
        centre: DVec3,
        reach: f64,
        (least, mut skin): (f64, f64),
        search: &mut Search,
        out: &mut Vec<Pack>,
    ) -> (f64, f32) {
        let Search {
            layers,
            leaves,
            bounds,
            found,
            ..
        } = search;
        self.tree.leaves(centre, reach + skin, layers, leaves);
        for &leaf in &*leaves {
            prefetch(&self.leaves[leaf as usize]);
        }
        bounds.clear();
        found.resize(LANES * leaves.len(), 0);
        let (mut count, mut slack) = (0, 0.0);
        for &leaf in &*leaves {
            let of_leaf = self.leaves[leaf as usize].bounds(centre);
            let farthest = of_leaf.farthest(reach + skin);
            for (lane, square) in of_leaf.squares().into_iter().enumerate() {
                let place = bounds.len() * LANES + lane;
                let distance = (square.sqrt() - of_leaf.slack) * (1.0 - 1e-6);
                let distance = if distance > 0.0 { distance } else { 0.0 };
                // Numbers that are not negative have the order of their bits.
                found[count] = u64::from(distance.to_bits()) << 32 | place as u64;
                let real = leaf as usize * LANES + lane < self.facets.len();
                count += usize::from((square < farthest * farthest) & real);
            }
            slack = of_leaf.slack.max(slack);
            bounds.push(of_leaf);
        }
        found.truncate(count);
        let distance = |key: u64| f32::from_bits((key >> 32) as u32);
        if found.len() > LONG {
            // Without the farthest the list is right for a thinner skin.
            let (_, farthest, _) = found.select_nth_unstable(LONG);
            skin = skin.min((f64::from(distance(*farthest)) - reach).max(least));
        }
        found.retain(|&key| f64::from(distance(key)) < reach + skin);
        found.sort_unstable();
        out.clear();
        out.resize(found.len().div_ceil(PACK), Pack::EMPTY);
        for (k, &key) in found.iter().enumerate() {
            let place = key as u32 as usize;
            let (of_leaf, lane) = (&bounds[place / LANES], place % LANES);
            let bound = of_leaf.of(lane);
            let margin = skin + f64::from(of_leaf.tilt);
            let group = bound.patch.group(f64::from(bound.height), margin);
            let facet = leaves[place / LANES] * LANES as u32 + lane as u32;
            let pack = &mut out[k / PACK];
            pack.put(k % PACK, &bound, (facet, group));
            if k % PACK == 0 {
                pack.distance = distance(key);
            }
        }
        (skin, slack)
    }

    /// The skin with which a list of facets of mean size has about half of [`LONG`] entries: those of a cap whose height is the skin.
    fn usual_skin(&self, radius: f64) -> f64 {
        0.5 * LONG as f64 * self.mean_area / (std::f64::consts::TAU * radius)
    }
}

#[cfg(test)]
impl Mesh {
    /// The contacts of a sphere when every facet is tested, whatever tree and lists hold.
    pub(crate) fn touches_of_all(&self, centre: DVec3, radius: f64, out: &mut Touches) {
        let facets: Vec<u32> = (0..self.facets.len() as u32).collect();
        let packs: Vec<Pack> = facets
            .iter()
            .map(|&facet| Pack {
                heights: [0.0, f32::INFINITY, f32::INFINITY, f32::INFINITY],
                facets: [facet, u32::MAX, u32::MAX, u32::MAX],
                distance: 0.0,
                ..Pack::EMPTY
            })
            .collect();
        let near = Near {
            packs: &packs,
            slack: 0.0,
            moved: 0.0,
        };
        let sphere = (centre, radius);
        self.touches_of(near, DVec3::ZERO, sphere, &mut Scratch::default(), out);
    }
}

/// Lists of facets for spheres near meshes. They are made on demand, from the tree of the mesh, with a skin of their own: so the
/// candidate list need not know the facets. They change no result, so they are no part of the state.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct NearMeshes {
    lists: Vec<List>,
    /// The facets of all lists, each list in its own range.
    packs: Vec<Pack>,
}

/// Where a list stands, and for which place of the sphere it was made.
#[derive(Debug, Clone, Copy, PartialEq)]
struct List {
    /// m, in the wall's frame.
    centre: DVec3,
    /// How far the sphere may move, m; negative before the list is made.
    skin: f64,
    /// Largest error of its distances, m.
    slack: f32,
    /// In packs.
    begin: u32,
    count: u32,
    room: u32,
    /// The facet that was nearest last.
    nearest: u32,
    /// How far the corners of the mesh had moved in all when the list was made, m.
    travelled: f64,
    /// Distance by which its facets were behind the corners then, m.
    late: f64,
}

impl List {
    const NONE: Self = Self {
        centre: DVec3::ZERO,
        skin: -1.0,
        slack: 0.0,
        begin: 0,
        count: 0,
        room: 0,
        nearest: u32::MAX,
        travelled: 0.0,
        late: 0.0,
    };

    fn range(&self) -> std::ops::Range<usize> {
        self.begin as usize..(self.begin + self.count) as usize
    }
}

/// Where to make the next list: ahead of a sphere that goes on as it did, so that it crosses the whole reach of the list.
fn ahead(old: &List, centre: DVec3, skin: f64) -> DVec3 {
    let way = centre - old.centre;
    // A list may also end because facets have moved.
    let goes_on = 0.5 * old.skin < way.length() && way.length() <= 2.0 * old.skin;
    if old.skin < 0.0 || !goes_on {
        return centre;
    }
    centre + way * (AHEAD * skin / way.length())
}

impl NearMeshes {
    /// Replaces `touches` by the contacts of a sphere of `radius` (m) at `centre` (m, in the wall's frame). `index`: a number for
    /// this sphere at this mesh, from 0 without large gaps.
    pub fn touches(
        &mut self,
        index: usize,
        mesh: &Mesh,
        centre: DVec3,
        radius: f64,
        scratch: &mut Scratch,
        touches: &mut Touches,
    ) {
        if index >= self.lists.len() {
            self.lists.resize(index + 1, List::NONE);
        }
        self.prefetch_next(index, mesh);
        let mut list = self.lists[index];
        // The comparison is false for a place that is not a number.
        let moved = mesh.travelled() - list.travelled;
        let within = list.skin >= 0.0 && centre.distance(list.centre) + moved <= list.skin;
        if !within {
            list = self.make(list, mesh, centre, radius, scratch);
            self.lists[index] = list;
        }
        let near = Near {
            packs: &self.packs[list.range()],
            slack: list.slack,
            moved: mesh.travelled() - list.travelled + list.late,
        };
        let way = centre - list.centre;
        mesh.touches_of(near, way, (centre, radius), scratch, touches);
        self.lists[index].nearest = scratch.nearest;
    }

    /// Prefetches the data of the spheres with the next numbers: nothing here is in the cache from one step to the next.
    #[inline]
    fn prefetch_next(&self, index: usize, mesh: &Mesh) {
        if let Some(list) = self.lists.get(index + LISTS_AHEAD) {
            prefetch(list);
        }
        let Some(list) = self.lists.get(index + FACETS_AHEAD) else {
            return;
        };
        if let Some(pack) = self.packs[list.range()].first() {
            prefetch(pack);
        }
        if let Some(facet) = mesh.facets.get(list.nearest as usize) {
            prefetch(facet);
        }
    }

    /// One more than the largest number that was queried.
    #[must_use]
    pub fn len(&self) -> usize {
        self.lists.len()
    }

    /// Whether nothing was queried.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.lists.is_empty()
    }

    /// Whether there is a list under a number.
    #[must_use]
    pub fn holds(&self, index: usize) -> bool {
        self.lists.get(index).is_some_and(|list| list.skin >= 0.0)
    }

    /// Takes over the list that `other` [holds](Self::holds) under a number, for the same sphere at the same mesh.
    pub fn take_over(&mut self, index: usize, other: &Self, of: usize) {
        let list = &other.lists[of];
        if index >= self.lists.len() {
            self.lists.resize(index + 1, List::NONE);
        }
        let empty = List {
            begin: 0,
            room: 0,
            ..*list
        };
        let packs = &other.packs[list.range()];
        self.lists[index] = self.store(empty, packs);
    }

    fn make(
        &mut self,
        old: List,
        mesh: &Mesh,
        centre: DVec3,
        radius: f64,
        scratch: &mut Scratch,
    ) -> List {
        let (least, largest) = (LEAST_SKIN * radius, LARGEST_SKIN * radius);
        let wanted = match old.skin {
            skin if skin < 0.0 => mesh.usual_skin(radius),
            skin if (old.count as usize) < LONG / PACK / 2 => 1.5 * skin,
            skin => skin,
        };
        let skin = wanted.clamp(least, largest);
        let place = ahead(&old, centre, skin.min(old.skin));
        let Scratch { search, near, .. } = scratch;
        let late = mesh.late();
        let (skin, slack) = mesh.list(place, radius + late, (least, skin), search, near);
        if place.distance(centre) > skin {
            let unmade = List { skin: -1.0, ..old };
            return self.make(unmade, mesh, centre, radius, scratch);
        }
        let list = List {
            centre: place,
            skin,
            slack,
            travelled: mesh.travelled(),
            late,
            ..old
        };
        self.store(list, near)
    }

    /// Writes a list into its present range, or into a new one.
    fn store(&mut self, list: List, near: &[Pack]) -> List {
        let count = near.len() as u32;
        let (begin, room) = if count <= list.room {
            (list.begin, list.room)
        } else {
            let begin = self.packs.len() as u32;
            let room = count + count / 2;
            self.packs.resize((begin + room) as usize, Pack::EMPTY);
            (begin, room)
        };
        let list = List {
            begin,
            count,
            room,
            ..list
        };
        self.packs[list.range()].copy_from_slice(near);
        list
    }
}

#[cfg(test)]
mod tests {
    use mercury_common::formats::mesh::TriangleMesh;
    use mercury_common::random::Stream;
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Bounds in a list hold wherever the sphere has gone since: also if its foot was hardly beside the facet when the list
        /// was made, so that single precision knows the way there badly, and is far beside it now.
        #[test]
        fn bounds_of_lists_hold_after_moves(
            seed in any::<u64>(),
            size in -2.0..0.5f64,
            beside in -4.0..-0.3f64,
            height in -1.0..1.0f64,
            away in 0.0..4.0f64,
        ) {
            let mut random = Stream::new(seed, "moves", 0);
            let mut any = || {
                2.0 * DVec3::new(random.uniform(), random.uniform(), random.uniform()) - 1.0
            };
            let shift = any() * 10f64.powf(away);
            let corners = [any(), any(), any()].map(|x| x * 10f64.powf(size) + shift);
            let triangles = TriangleMesh {
                vertices: corners.to_vec(),
                triangles: vec![[0, 1, 2]],
                ..TriangleMesh::default()
            };
            let Ok(mesh) = Mesh::new(&triangles, |x| x, false) else { return Ok(()) };
            let facet = &mesh.facets[0];
            let [a, b, _] = facet.corners;
            let outwards = (b - a).cross(facet.normal).normalize();
            let foot = 0.5 * (a + b) + outwards * 10f64.powf(beside);
            let place = foot + facet.normal * height;
            let (mut search, mut packs) = (Search::default(), Vec::new());
            let (_, slack) = mesh.list(place, 2.0, (2.0, 2.0), &mut search, &mut packs);
            let near = Near { packs: &packs, slack, moved: 0.0 };
            prop_assert_eq!(packs.len(), 1);
            for _ in 0..20 {
                let moved = any() * 0.5;
                let mut bounds = Vec::new();
                near.bounds(moved, 3.0, &mut bounds);
                let least = f64::from(bounds[0]).sqrt();
                let exact = facet.nearest(place + moved, f64::INFINITY).unwrap().distance;
                prop_assert!(least <= exact, "{least} of {exact}");
            }
        }
    }
}
