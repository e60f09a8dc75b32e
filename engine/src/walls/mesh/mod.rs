//! Walls made of triangles.
//!
//! A sphere touches a mesh wherever the distance from its centre to the surface has a local minimum that is smaller than its
//! radius: on a face, on an edge that is convex there, on a corner. Minima whose directions differ by less than
//! [`SMOOTH_ANGLE`] belong to one smooth concave region that the mesh tessellates; of them only the nearest counts. See
//! `docs/theory/mesh-walls.md`.

mod contacts;
mod crossed;
mod facet;
mod leaf;
mod near;
mod patches;
mod periodic;
mod precision;
mod reshape;
mod saddles;
mod takers;
mod topology;
mod tree;
mod triangles;
mod worn;

use glam::DVec3;
use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::surfaces::Surface;

use super::error::WallError;
use super::pose::Pose;
use super::touch::{Touch, Touches};
use crate::memory::in_large_pages;
use contacts::{Found, Minimum};
use facet::Facet;
use leaf::{Bounds, LANES, Leaf};
pub use near::NearMeshes;
use near::{Near, Pack};
use patches::{Best, find_patches};
use periodic::Continuation;
pub use periodic::Period;
pub use precision::Precision;
pub use saddles::Saddle;
pub use takers::Feature;
use topology::Topology;
use tree::Tree;
pub use worn::{Base, Facing, TurnedPair};

/// Minima whose directions from the sphere's centre differ by less than this are one contact, degrees. A turn tessellated by
/// more facets than 360 over this is smooth from inside.
pub const SMOOTH_ANGLE: f64 = 12.0;

/// A contact may carry its history to one whose foot is nearer than this part of the distance: more than two steps of
/// [`SMOOTH_ANGLE`] span, less than there is between the faces of a corner.
const SAME_PATCH: f64 = 0.5;

/// Normals that are known worse than this are compared with those of neighbours.
const STEADY: f64 = 1e-10;

/// A triangle mesh in its own frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    vertices: Vec<DVec3>,
    /// Sorted in space, in the order of the tree.
    facets: Vec<Facet>,
    /// Place of each facet in the file, where those without area are not counted.
    file_order: Vec<u32>,
    topology: Topology,
    tree: Tree,
    /// The facets by the leaves of the tree.
    leaves: Vec<Leaf>,
    extent: Extent,
    /// Mean area of a triangle, m^2.
    mean_area: f64,
    /// How far corners have moved in all changes together, at most, m.
    travelled: f64,
    /// How far corners had moved when facets, leaves and tree were fitted to them last, m.
    fitted: f64,
    /// Only the side acts where the normals point.
    front_only: bool,
    precision: Precision,
    /// Round-off of positions near the mesh, m.
    round_off: f64,
    left_out: LeftOut,
    continuation: Continuation,
    /// Minima of the distance are contacts as far as they are below their saddles, and none stands for others of its smooth region.
    keeps_all: bool,
}

impl Mesh {
    /// As [`Shape::feature_numbering`](crate::walls::Shape::feature_numbering): by the corners of all facets, in their order.
    pub(super) fn feature_numbering(&self) -> String {
        let mut sum = crc32fast::Hasher::new();
        for facet in &self.facets {
            for number in facet.corners.iter().flat_map(DVec3::to_array) {
                sum.update(&number.to_le_bytes());
            }
        }
        format!(
            "mesh of {} facets, checksum {:08x}",
            self.facets.len(),
            sum.finalize()
        )
    }
}

/// Triangles of the file that do not act.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LeftOut {
    /// Without area, as they are thinner than the [precision](Mesh::precision).
    pub thin: usize,
    /// With a corner farther than [`Mesh::FARTHEST`] from the origin.
    pub far: usize,
}

/// How large a mesh is.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Extent {
    /// Smallest and largest coordinates, m.
    bounds: (DVec3, DVec3),
    /// Middle of the bounds and the largest distance of a vertex from it, m.
    ball: (DVec3, f64),
}

impl Extent {
    /// Extent of those vertices that count.
    fn of(vertices: &[DVec3], counts: impl Fn(u32) -> bool) -> Self {
        let numbered = || (0u32..).zip(vertices);
        let all = || numbered().filter(|(k, _)| counts(*k)).map(|(_, &x)| x);
        let low = all().fold(DVec3::INFINITY, DVec3::min);
        let high = all().fold(DVec3::NEG_INFINITY, DVec3::max);
        let middle = 0.5 * (low + high);
        let square = all().fold(0.0f64, |most, x| most.max(x.distance_squared(middle)));
        Self {
            bounds: (low, high),
            ball: (middle, square.sqrt()),
        }
    }

    /// Round-off of positions nearby, m; corners beyond `largest` (m) are not near to anything.
    fn round_off(&self, largest: f64) -> f64 {
        let (low, high) = self.bounds;
        16.0 * f64::EPSILON * low.abs().max(high.abs()).max_element().min(largest)
    }
}

/// Memory that queries use again.
#[derive(Debug, Clone, Default)]
pub struct Scratch {
    minima: Vec<Minimum>,
    best: Best,
    found: Vec<Found>,
    near: Vec<Pack>,
    bounds: Vec<f32>,
    /// The facet that was nearest, if there was one.
    nearest: u32,
    saddles: Vec<Saddle>,
    joins: saddles::Tree,
    search: Search,
}

/// The part of it that the search for facets uses.
#[derive(Debug, Clone, Default)]
struct Search {
    layers: [Vec<u32>; 2],
    leaves: Vec<u32>,
    bounds: Vec<Bounds>,
    /// Least distance (m), in the upper bits, and place among the bounds of the leaves.
    found: Vec<u64>,
    stack: Vec<u32>,
}

impl Scratch {
    /// Where the contacts of the last query join nearer ones, for meshes that [keep all](Mesh::keeping_all): those that do.
    #[must_use]
    pub fn saddles(&self) -> &[Saddle] {
        &self.saddles
    }
}

impl Mesh {
    /// Triangles with a corner that has a larger coordinate in the scene are left out, m. Bounds in single precision square lengths.
    pub const FARTHEST: f64 = 1e15;

    /// Bytes that it takes, for estimates of memory.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(&self.vertices[..])
            + size_of_val(&self.facets[..])
            + size_of_val(&self.file_order[..])
            + size_of_val(&self.leaves[..])
            + self.tree.bytes()
            + self.topology.bytes()
    }

    /// Memory of a mesh of so many triangles, two at each edge and six at each corner, before there is one, bytes.
    #[must_use]
    pub fn bytes_of(triangles: usize) -> f64 {
        let each = size_of::<Facet>()
            + size_of::<u32>()
            + (size_of::<Leaf>() + Tree::BYTES_OF_LEAF) / LANES;
        let of_vertices = size_of::<DVec3>() / 2;
        (triangles * (each + of_vertices + Topology::BYTES_OF_TRIANGLE)) as f64
    }

    /// The wall of `triangles`; `place` maps its coordinates into the scene (m), a similarity. `front_only`: only the side acts
    /// to which the triangles turn counter-clockwise. Triangles without area to within the precision of the coordinates are
    /// left out, and those with a corner farther than [`Mesh::FARTHEST`].
    ///
    /// # Errors
    /// If a coordinate is not finite or no triangle remains.
    pub fn new(
        triangles: &TriangleMesh,
        place: impl Fn(DVec3) -> DVec3,
        front_only: bool,
    ) -> Result<Self, WallError> {
        let vertices: Vec<DVec3> = triangles.vertices.iter().map(|&x| place(x)).collect();
        for &vertex in &vertices {
            super::error::finite_vector("file", vertex)?;
        }
        let precision = Precision::of(triangles, &vertices, &place);
        let mut left_out = LeftOut::default();
        let mut kept: Vec<(u32, [u32; 3])> = Vec::with_capacity(triangles.triangles.len());
        for &corners in &triangles.triangles {
            let places = corners.map(|k| vertices[k as usize]);
            if places
                .iter()
                .any(|x| x.abs().max_element() > Self::FARTHEST)
            {
                left_out.far += 1;
            } else if !has_area(places, precision.tolerance) {
                left_out.thin += 1;
            } else {
                kept.push((kept.len() as u32, short_sides_first(corners, &vertices)));
            }
        }
        if kept.is_empty() {
            return Err(WallError::NoTriangle {
                count: triangles.triangles.len(),
                precision,
            });
        }
        let (mesh, _) = Self::assembled(vertices, &mut kept, precision, front_only, left_out);
        Ok(mesh)
    }

    /// Mesh of these triangles, each with its place in the file. Also returns the number that each vertex has now; `u32::MAX` for
    /// those that no triangle uses.
    fn assembled(
        vertices: Vec<DVec3>,
        kept: &mut [(u32, [u32; 3])],
        precision: Precision,
        front_only: bool,
        left_out: LeftOut,
    ) -> (Self, Vec<u32>) {
        let tree = Tree::build(&vertices, kept);
        let (vertices, corners, number) = in_order_of_use(&vertices, kept);
        let (topology, edges) = Topology::new(&vertices, &corners, front_only);
        let mut facets = in_large_pages(corners.len());
        let prepared = corners.iter().zip(edges);
        facets.extend(prepared.map(|(&corners, edges)| Facet::new(&vertices, corners, edges)));
        steady_normals(&mut facets, &topology, precision.tolerance);
        find_patches(&mut facets, &topology, vertices.len());
        let mut leaves = in_large_pages(facets.len().div_ceil(LANES));
        leaves.extend(facets.chunks(LANES).map(Leaf::new));
        let area = facets.iter().map(Facet::area).sum::<f64>();
        let extent = Extent::of(&vertices, |_| true);
        let mesh = Self {
            file_order: kept.iter().map(|&(index, _)| index).collect(),
            topology,
            tree,
            leaves,
            mean_area: area / kept.len() as f64,
            extent,
            travelled: 0.0,
            fitted: 0.0,
            front_only,
            precision,
            round_off: extent.round_off(precision.largest),
            left_out,
            continuation: Continuation::default(),
            keeps_all: false,
            vertices,
            facets,
        };
        (mesh, number)
    }

    /// This mesh with more triangles; the number that each vertex has now.
    fn rebuilt(&self, vertices: Vec<DVec3>, kept: &mut [(u32, [u32; 3])]) -> (Self, Vec<u32>) {
        let (precision, front_only) = (self.precision, self.front_only);
        let (mesh, number) = Self::assembled(vertices, kept, precision, front_only, self.left_out);
        let extent = self.extent;
        (Self { extent, ..mesh }, number)
    }

    /// This mesh with a touch for every local minimum of the distance that counts beside nearer ones ([`Saddle`]), the nearest
    /// first: for surfaces that bend around particles.
    #[must_use]
    pub fn keeping_all(mut self) -> Self {
        self.keeps_all = true;
        self.fit();
        self
    }

    /// Whether it acts only where its triangles turn counter-clockwise.
    #[must_use]
    pub fn is_front_only(&self) -> bool {
        self.front_only
    }

    /// Number of triangles that act; continuations along periodic axes do not count.
    #[must_use]
    pub fn len(&self) -> usize {
        (0..self.facets.len())
            .filter(|&facet| self.is_own(facet))
            .count()
    }

    /// Whether there is no triangle; there always is one.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.facets.is_empty()
    }

    /// Triangles of the file that were left out.
    #[must_use]
    pub fn left_out(&self) -> LeftOut {
        self.left_out
    }

    /// How exactly its places are known.
    #[must_use]
    pub fn precision(&self) -> Precision {
        self.precision
    }

    /// Edges with one, two and more triangles: rims, ordinary edges, seams.
    #[must_use]
    pub fn edge_counts(&self) -> [usize; 3] {
        let faces = self.facets.len() as u32;
        let is_own = |edge: u32| self.continuation.known_as(faces + edge) == faces + edge;
        self.topology.edge_counts(is_own)
    }

    /// See [`super::Shape::touches`].
    pub fn touches(&self, centre: DVec3, reach: f64, out: &mut Touches) {
        let mut scratch = Scratch::default();
        let mut packs = Vec::new();
        let search = &mut scratch.search;
        let late = self.late();
        let (_, slack) = self.list(centre, reach + late, (0.0, 0.0), search, &mut packs);
        let near = Near {
            packs: &packs,
            slack,
            moved: late,
        };
        self.touches_of(near, DVec3::ZERO, (centre, reach), &mut scratch, out);
    }

    /// Whether a facet may be closer than `reach` (m) to `centre`: it is to within single precision, or a small box around it is.
    #[must_use]
    pub fn may_be_near(&self, centre: DVec3, reach: f64, scratch: &mut Scratch) -> bool {
        let reach = reach + self.late();
        let near = |leaf: u32| {
            let bounds = self.leaves[leaf as usize].bounds(centre);
            let farthest = bounds.farthest(reach);
            let square = farthest * farthest;
            bounds.squares().into_iter().any(|other| other <= square)
        };
        let stack = &mut scratch.search.stack;
        self.tree.has_near(centre, reach, stack, near)
    }

    /// Whether [`Mesh::may_be_near`] may be true of any place within `within` (m) of `centre`; false only if it does not.
    #[must_use]
    pub fn may_be_near_some(
        &self,
        centre: DVec3,
        within: f64,
        reach: f64,
        scratch: &mut Scratch,
    ) -> bool {
        // Boxes and bounds are in single precision, and each place has its own round-off.
        let reach =
            (reach + within + self.late()) * (1.0 + 4e-6) + 1e-6 * centre.abs().max_element();
        let near = |leaf: u32| {
            let bounds = self.leaves[leaf as usize].bounds(centre);
            let farthest = bounds.farthest(reach) + bounds.loose(within);
            let square = farthest * farthest;
            bounds.squares().into_iter().any(|other| other <= square)
        };
        let stack = &mut scratch.search.stack;
        self.tree.has_near(centre, reach, stack, near)
    }

    /// Replaces the content of `out` by the contacts of a sphere (centre and radius, m) with the facets `near`, which [`Mesh::list`]
    /// found for that radius when the centre was `moved` (m) from where it is now, no more than the skin.
    #[inline]
    fn touches_of(
        &self,
        near: Near<'_>,
        moved: DVec3,
        (centre, reach): (DVec3, f64),
        scratch: &mut Scratch,
        out: &mut Touches,
    ) {
        out.clear();
        near.bounds(moved, reach, &mut scratch.bounds);
        self.collect(near, centre, reach, scratch);
        self.merge(&mut scratch.minima, out);
        if self.keeps_all {
            self.join(near, (centre, reach), scratch, out);
        }
    }

    /// Whether the contact that `feature` had may go on as `touch`: its nearest point to `centre` is near the foot of `touch`.
    /// Returns the square of that distance over the one at which it may not.
    #[must_use]
    pub fn continues(&self, feature: u32, touch: &Touch, centre: DVec3) -> Option<f64> {
        let foot = centre - touch.normal * touch.distance;
        let limit = SAME_PATCH * touch.distance.abs();
        let squared = if self.periods().is_empty() {
            self.nearest_of(feature, centre).distance_squared(foot)
        } else {
            self.nearest_image(feature, centre, foot)
        };
        let part = squared / (limit * limit);
        (part < 1.0).then_some(part)
    }

    /// Surface for pictures and files: the triangles in the order of the file, without those that have no area.
    #[must_use]
    pub fn outline(&self) -> Surface {
        let mut triangles: Vec<(u32, [u32; 3])> = self
            .file_order
            .iter()
            .zip(&self.facets)
            .enumerate()
            .filter(|&(facet, _)| self.is_own(facet))
            .map(|(_, (&index, facet))| (index, facet.vertices))
            .collect();
        triangles.sort_unstable_by_key(|&(index, _)| index);
        Surface::Mesh(TriangleMesh {
            vertices: self.vertices.clone(),
            triangles: triangles.into_iter().map(|(_, corners)| corners).collect(),
            ..TriangleMesh::default()
        })
    }

    /// Smallest and largest coordinates, m.
    #[must_use]
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.extent.bounds
    }

    /// See [`super::Shape::displacement`].
    #[must_use]
    pub fn displacement(&self, from: &Pose, to: &Pose, about: DVec3, reach: f64) -> f64 {
        let moved = |x: DVec3| to.to_global(x).distance(from.to_global(x));
        let relative = from.relative_to(to).rotation;
        let chord = 2.0 * DVec3::new(relative.x, relative.y, relative.z).length();
        // The displacement is a convex function of the point, so it is largest at a corner of any box around the mesh.
        let (low, high) = self.extent.bounds;
        let mut corners = 0.0f64;
        for k in 0..8 {
            let high_on = [k & 1 != 0, k & 2 != 0, k & 4 != 0];
            let pick = |axis: usize| if high_on[axis] { high[axis] } else { low[axis] };
            corners = corners.max(moved(DVec3::new(pick(0), pick(1), pick(2))));
        }
        let (middle, radius) = self.extent.ball;
        corners
            .min(moved(middle) + chord * radius)
            .min(moved(about) + chord * reach)
    }
}

/// The vertices in the order in which the triangles use them, the triangles by their new numbers, and the new number of each vertex:
/// what is near in space is near in memory, which is worth a factor of two on large meshes.
fn in_order_of_use(
    vertices: &[DVec3],
    triangles: &[(u32, [u32; 3])],
) -> (Vec<DVec3>, Vec<[u32; 3]>, Vec<u32>) {
    let mut number = vec![u32::MAX; vertices.len()];
    let mut sorted = Vec::with_capacity(vertices.len());
    let mut renumber = |old: u32| {
        let new = &mut number[old as usize];
        if *new == u32::MAX {
            *new = sorted.len() as u32;
            sorted.push(vertices[old as usize]);
        }
        *new
    };
    let triangles = triangles
        .iter()
        .map(|&(_, corners)| corners.map(&mut renumber))
        .collect();
    (sorted, triangles, number)
}

/// The corners in the same sense of rotation, the one opposite to the longest side first: the normal is most exact from the
/// short sides.
fn short_sides_first([a, b, c]: [u32; 3], vertices: &[DVec3]) -> [u32; 3] {
    let side = |p: u32, q: u32| vertices[p as usize].distance_squared(vertices[q as usize]);
    let (ab, bc, ca) = (side(a, b), side(b, c), side(c, a));
    if bc >= ab && bc >= ca {
        [a, b, c]
    } else if ca >= ab {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// Gives slivers the normal of a wider neighbour where the two differ by no more than the precision of the sliver's corners
/// allows: a tolerance over its height.
fn steady_normals(facets: &mut [Facet], topology: &Topology, tolerance: f64) {
    // The side opposite to the first corner is the longest.
    let height = |facet: &Facet| {
        let [a, b, c] = facet.corners;
        (b - a).cross(c - a).length() / (c - b).length()
    };
    let heights: Vec<f64> = facets.iter().map(height).collect();
    let mut slivers: Vec<usize> = (0..facets.len())
        .filter(|&k| tolerance > STEADY * heights[k])
        .collect();
    if slivers.is_empty() {
        return;
    }
    // The widest at each edge, found once: files hold edges of thousands of triangles.
    let is_wider = |&a: &usize, &b: &usize| heights[a].total_cmp(&heights[b]).then(b.cmp(&a));
    let widest: Vec<Option<usize>> = (0..topology.edge_count() as u32)
        .map(|edge| {
            let around = topology.triangles_at(edge).iter();
            around.map(|&(other, _)| other as usize).max_by(is_wider)
        })
        .collect();
    // Wider ones first, so that a row of slivers takes the normal of what is beside it.
    slivers.sort_by(|&a, &b| heights[b].total_cmp(&heights[a]).then(a.cmp(&b)));
    for k in slivers {
        let own = facets[k].normal;
        let wider = facets[k]
            .edges
            .iter()
            .filter_map(|&edge| widest[edge as usize])
            .filter(|&other| heights[other] > heights[k])
            .max_by(is_wider);
        if let Some(other) = wider {
            let normal = facets[other].normal;
            let normal = if normal.dot(own) < 0.0 {
                -normal
            } else {
                normal
            };
            if normal.distance(own) * heights[k] <= tolerance {
                facets[k].set_normal(normal);
            }
        }
    }
}

/// Whether the smallest height of the triangle is above the tolerance.
fn has_area([a, b, c]: [DVec3; 3], tolerance: f64) -> bool {
    let longest = (b - a).length().max((c - b).length()).max((a - c).length());
    (b - a).cross(c - a).length() > tolerance * longest
}
