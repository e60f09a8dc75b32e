//! Lists of the facets near a sphere, so that a step tests only those that may have come to be the nearest.

use glam::{DVec3, Vec3};

use super::super::touch::Touches;
use super::patches::NO_GROUP;
use super::{Mesh, Scratch, Search};

/// Most facets in a list, if a skin of [`LEAST_SKIN`] holds no more.
const LONG: usize = 32;
/// Thickness of the skin of a list over the radius: the least and the largest.
const LEAST_SKIN: f64 = 0.02;
const LARGEST_SKIN: f64 = 0.25;
/// How far ahead of a moving sphere its next list is made, over the skin.
const AHEAD: f64 = 0.7;
/// What single precision may be off by when a list is used, over the largest distance in it.
const SINGLE: f64 = 5e-7;

/// A facet near a sphere, with what tells in a few operations how near it is at least.
///
/// A facet lies in its plane; and, since it is convex, beyond the line in the plane that is normal to the way from the foot of the
/// sphere's centre to the nearest point of the facet. So it is no nearer than that half plane, wherever the sphere goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NearFacet {
    /// Index of the facet.
    pub facet: u32,
    /// Patch and side, if the sphere cannot change sides within the skin.
    pub group: u32,
    /// Distance, m; rounded down.
    distance: f32,
    /// Normal of the plane, and height of the centre over it, m.
    normal: Vec3,
    height: f32,
    /// Direction and length (m) of the way from the foot to the line; 0 if the foot is on the facet.
    way: Vec3,
    gap: f32,
}

impl NearFacet {
    const NONE: Self = Self {
        facet: 0,
        group: NO_GROUP,
        distance: 0.0,
        normal: Vec3::ZERO,
        height: 0.0,
        way: Vec3::ZERO,
        gap: 0.0,
    };

    /// What the square of the distance (m^2) is at least, when the sphere has `moved` (m). `slack`: see [`SINGLE`].
    #[inline]
    fn bound(&self, moved: Vec3, slack: f32) -> f32 {
        let height = ((self.height + self.normal.dot(moved)).abs() - slack).max(0.0);
        let gap = (self.gap - self.way.dot(moved) - slack).max(0.0);
        height * height + gap * gap
    }
}

/// Replaces `bounds` by what the squares of the distances (m^2) of the facets `near` are at least, when the sphere has `moved` (m).
/// Stops where all others are farther than `reach` (m).
#[inline]
pub(super) fn bounds(near: &[NearFacet], moved: DVec3, reach: f64, bounds: &mut Vec<f32>) {
    let way = moved.length();
    let farthest = (reach + way) * (1.0 + 1e-6);
    let slack = (SINGLE * (reach + 2.0 * way)) as f32;
    let moved = moved.as_vec3();
    bounds.clear();
    let within = near
        .iter()
        .take_while(|near| f64::from(near.distance) < farthest);
    bounds.extend(within.map(|near| near.bound(moved, slack)));
}

impl Mesh {
    /// Replaces `out` by the facets closer than `reach` + `skin` (m) to `centre`, at most about [`LONG`] if the skin can be made
    /// thinner for that, but not thinner than `least` (m). Returns the skin with which the list is right. The nearest
    /// facet comes first.
    pub(super) fn list(
        &self,
        centre: DVec3,
        reach: f64,
        (least, mut skin): (f64, f64),
        search: &mut Search,
        out: &mut Vec<NearFacet>,
    ) -> f64 {
        let Search {
            layers,
            leaves,
            candidates,
            found,
            ..
        } = search;
        let limit = reach + skin;
        self.tree.leaves(centre, limit, layers, leaves);
        // First what is quick and without branches, as in the tree.
        candidates.resize(leaves.iter().map(|leaf| leaf.len()).sum(), 0);
        let mut count = 0;
        for index in leaves.iter().cloned().flatten() {
            candidates[count] = index;
            let least = self.facets[index as usize].least_height(centre);
            count += usize::from(least < limit);
        }
        found.clear();
        for &index in &candidates[..count] {
            // Steadied normals are for directions. What is said of the facet here must hold of its corners.
            let facet = self.facets[index as usize].with_own_normal();
            if let Some(nearest) = facet.nearest(centre, limit) {
                found.push((nearest.distance, index, facet.normal, nearest.point));
            }
        }
        if found.len() > LONG {
            // Without the farthest the list is right for a thinner skin.
            let (_, farthest, _) = found.select_nth_unstable_by(LONG, |a, b| a.0.total_cmp(&b.0));
            skin = skin.min((farthest.0 - reach).max(least));
        }
        found.retain(|facet| facet.0 < reach + skin);
        found.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        out.clear();
        out.extend(found.iter().map(|&(distance, index, normal, point)| {
            let height = (centre - point).dot(normal);
            let way = normal * height - (centre - point);
            let gap = way.length();
            // A way that is short against the height has no exact direction.
            let known = gap > 1e-6 * distance;
            NearFacet {
                facet: index,
                group: self.facets[index as usize].group(centre, skin),
                distance: (distance * (1.0 - 1e-7)) as f32,
                normal: normal.as_vec3(),
                height: height as f32,
                way: if known {
                    (way / gap).as_vec3()
                } else {
                    Vec3::ZERO
                },
                gap: if known { gap as f32 } else { 0.0 },
            }
        }));
        skin
    }

    /// The skin with which a list of facets of mean size has about half of [`LONG`] entries: those of a cap whose height is the skin.
    fn usual_skin(&self, radius: f64) -> f64 {
        0.5 * LONG as f64 * self.mean_area / (std::f64::consts::TAU * radius)
    }
}

/// Lists of facets for spheres near meshes. They are made when they are asked for, from the tree of the mesh, with a skin of their
/// own: so the candidate list need not know the facets. They change no result, so they are no part of the state.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct NearMeshes {
    lists: Vec<List>,
    /// The facets of all lists, each in its own room.
    facets: Vec<NearFacet>,
}

/// Where a list stands, and for which place of the sphere it was made.
#[derive(Debug, Clone, Copy, PartialEq)]
struct List {
    /// m, in the wall's frame.
    centre: DVec3,
    /// How far the sphere may move, m; negative before the list is made.
    skin: f64,
    begin: u32,
    count: u32,
    room: u32,
}

impl List {
    const NONE: Self = Self {
        centre: DVec3::ZERO,
        skin: -1.0,
        begin: 0,
        count: 0,
        room: 0,
    };

    fn range(&self) -> std::ops::Range<usize> {
        self.begin as usize..(self.begin + self.count) as usize
    }
}

/// Where to make the next list: ahead of a sphere that goes on as it did, so that it crosses the whole reach of the list.
fn ahead(old: &List, centre: DVec3, skin: f64) -> DVec3 {
    let way = centre - old.centre;
    if old.skin < 0.0 || way.length() > 2.0 * old.skin {
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
        let mut list = self.lists[index];
        // The comparison is false for a place that is not a number.
        let within = list.skin >= 0.0 && centre.distance(list.centre) <= list.skin;
        if !within {
            list = self.make(list, mesh, centre, radius, scratch);
            self.lists[index] = list;
        }
        let moved = centre - list.centre;
        let near = &self.facets[list.range()];
        mesh.touches_of(near, moved, (centre, radius), scratch, touches);
    }

    /// One more than the largest number that was asked for.
    #[must_use]
    pub fn len(&self) -> usize {
        self.lists.len()
    }

    /// Whether nothing was asked for.
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
        let facets = &other.facets[list.range()];
        self.lists[index] = self.store(empty, facets);
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
            skin if (old.count as usize) < LONG / 2 => 1.5 * skin,
            skin => skin,
        };
        let skin = wanted.clamp(least, largest);
        let place = ahead(&old, centre, skin.min(old.skin));
        let Scratch { search, near, .. } = scratch;
        let skin = mesh.list(place, radius, (least, skin), search, near);
        if place.distance(centre) > skin {
            let unmade = List { skin: -1.0, ..old };
            return self.make(unmade, mesh, centre, radius, scratch);
        }
        let list = List {
            centre: place,
            skin,
            ..old
        };
        self.store(list, near)
    }

    /// Writes a list into the room it has, or into new room.
    fn store(&mut self, list: List, near: &[NearFacet]) -> List {
        let count = near.len() as u32;
        let (begin, room) = if count <= list.room {
            (list.begin, list.room)
        } else {
            let begin = self.facets.len() as u32;
            let room = count + count / 2;
            self.facets.resize((begin + room) as usize, NearFacet::NONE);
            (begin, room)
        };
        let list = List {
            begin,
            count,
            room,
            ..list
        };
        self.facets[list.range()].copy_from_slice(near);
        list
    }
}
