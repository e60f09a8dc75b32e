//! A wall that wears, as it is now.

use glam::DVec3;

use super::WearPlan;
use super::skin::Skin;
use crate::forces::Rub;
use crate::walls::Mesh;

/// A wall that wears: what its vertices owe, and how far they have moved.
///
/// Volumes of nodes and triangles are signed: positive where the wall is worn on the side of its normals.
#[derive(Debug, Clone, PartialEq)]
pub struct Worn {
    pub(super) plan: WearPlan,
    pub(super) skin: Skin,
    /// Displacements of the nodes from their first places, m: apart from the coordinates, so that none is lost to round-off far
    /// from the origin.
    pub(super) displacement: Vec<DVec3>,
    /// Volume that each node owes and has not placed, m^3.
    pub(super) waiting: Vec<f64>,
    /// Part of it that the last move could not place, m^3.
    pub(super) left: Vec<f64>,
    /// Nodes that owe something, in the order in which they began to; which they are.
    pub(super) owing: Vec<u32>,
    pub(super) owes: Vec<bool>,
    /// Nodes at which the last move that wanted to move them was shortened.
    pub(super) blocked: Vec<bool>,
    /// Nodes where the body is worn through.
    pub(super) through: Vec<bool>,
    /// Summed up over all contacts, m^3.
    pub(super) triangle_owed: Vec<f64>,
    /// Volume that each triangle has lost: the swept one, against its normal, m^3.
    pub(super) removed: Vec<f64>,
    /// Sums over all contacts on the side of the normals, and on the other, m^3.
    pub(super) front: f64,
    pub(super) back: f64,
    /// Volume that all moves have placed, m^3.
    pub(super) placed: f64,
    pub(super) moves: u64,
    /// The largest move of a vertex at once, over what `step` allows.
    pub(super) largest_move: f64,
    pub(super) worn_through: Option<WornThrough>,
    pub(super) is_worn: bool,

    // The fields below follow from the displacements.
    /// Areas of the triangles at each node, m^2.
    pub(super) areas: Vec<f64>,
    /// The volume at which each node moves by `step` of its shortest edge, m^3.
    pub(super) limits: Vec<f64>,
    /// A node has reached its limit.
    pub(super) is_due: bool,
    /// Distance of others from each triangle when that was looked at last (m), plus twice `travelled` then.
    pub(super) clear: Vec<f64>,
    /// How far nodes have moved in all moves together, at most, and in the last one, m.
    pub(super) travelled: f64,
    pub(super) last_way: f64,
    /// Triangles that the last move has moved, ascending.
    pub(super) moved: Vec<u32>,
    /// Triangles at a feature, in the making.
    scratch: Vec<u32>,
}

/// Where a thin body was worn through first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WornThrough {
    /// The place, own frame, m.
    pub place: DVec3,
    /// Number of the move.
    pub moves: u64,
}

/// A worn wall in numbers: a row of `.wear.csv`. Volumes in m^3.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WearRow {
    /// Volume by the law, of all contacts.
    pub owed: f64,
    /// Signed volume between the first surface and the present one, positive on the side that owes more.
    pub removed: f64,
    /// Volume that is owed and not yet placed.
    pub pending: f64,
    /// Owed by contacts on the side of the normals.
    pub front: f64,
    /// Owed by contacts on the other side.
    pub back: f64,
    /// Depth of the deepest vertex, m.
    pub max_depth: f64,
    /// Its first place, own frame, m.
    pub place: DVec3,
    /// Moves of the surface.
    pub moves: u64,
    /// Vertices at which the last move was shortened.
    pub blocked: u64,
}

/// A vertex of a worn wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WornVertex {
    /// Its number: by first appearance among the corners of the triangles of the file.
    pub vertex: u32,
    /// First place, own frame, m.
    pub first: DVec3,
    /// Displacement, own frame, m.
    pub displacement: DVec3,
    /// Depth on the side that owes more, against its first normal, m.
    pub depth: f64,
    /// Volume that is owed and not yet placed, m^3.
    pub owed: f64,
}

impl Worn {
    /// Memory that a wall of this mesh takes beside it, bytes: for estimates.
    #[must_use]
    pub fn bytes_of(mesh: &Mesh) -> f64 {
        let (corners, triangles) = (mesh.corners().len(), mesh.triangles().len());
        let of_nodes =
            size_of::<DVec3>() + 4 * size_of::<f64>() + 3 * size_of::<bool>() + size_of::<u32>();
        let of_triangles = 3 * size_of::<f64>() + size_of::<u32>();
        (corners * of_nodes + triangles * of_triangles) as f64 + Skin::bytes_of(corners, triangles)
    }

    /// Unworn.
    #[must_use]
    pub fn new(plan: WearPlan, mesh: &Mesh) -> Self {
        let skin = Skin::new(mesh);
        let (nodes, triangles) = (skin.nodes(), skin.triangles.len());
        let mut worn = Self {
            plan,
            displacement: vec![DVec3::ZERO; nodes],
            waiting: vec![0.0; nodes],
            left: vec![0.0; nodes],
            owing: Vec::new(),
            owes: vec![false; nodes],
            blocked: vec![false; nodes],
            through: vec![false; nodes],
            triangle_owed: vec![0.0; triangles],
            removed: vec![0.0; triangles],
            front: 0.0,
            back: 0.0,
            placed: 0.0,
            moves: 0,
            largest_move: 0.0,
            worn_through: None,
            is_worn: false,
            areas: vec![0.0; nodes],
            limits: vec![0.0; nodes],
            is_due: false,
            clear: vec![0.0; triangles],
            travelled: 0.0,
            last_way: 0.0,
            moved: Vec::new(),
            scratch: Vec::new(),
            skin,
        };
        (0..nodes as u32).for_each(|node| worn.measure(node));
        worn
    }

    /// Largest part of its limit by which a volume (m^3) that one contact wears at once moves a vertex: at the vertex with the
    /// lowest limit.
    #[must_use]
    pub fn part_of_step(&self, volume: f64) -> f64 {
        let least = self.limits.iter().copied().fold(f64::INFINITY, f64::min);
        volume / least
    }

    /// Plan of the wall.
    #[must_use]
    pub fn plan(&self) -> &WearPlan {
        &self.plan
    }

    /// Finds area and limit of a node where the surface is now.
    pub(super) fn measure(&mut self, node: u32) {
        let (mut area, mut shortest) = (0.0, f64::INFINITY);
        for &triangle in self.skin.around(node) {
            let sides = self.skin.sides(triangle, &self.displacement);
            area += 0.5 * sides[0].cross(sides[1]).length();
            let nodes = self.skin.nodes_of(triangle);
            for (side, ends) in sides.iter().zip([[0, 1], [0, 2], [1, 2]]) {
                if ends.iter().any(|&end| nodes[end] == node) {
                    shortest = shortest.min(side.length());
                }
            }
        }
        self.areas[node as usize] = area;
        self.limits[node as usize] = self.plan.step * shortest * area / 3.0;
    }

    /// Adds what a contact wears; `mesh` is the surface as it is.
    pub fn note(&mut self, rub: &Rub, mesh: &Mesh) {
        let volume = self.plan.acceleration * self.plan.law.volume(rub);
        if volume == 0.0 {
            return;
        }
        let base = mesh.base(rub.feature, rub.foot);
        let is_front = rub.normal.dot(base.normal) >= 0.0;
        let signed = if is_front { volume } else { -volume };
        if is_front {
            self.front += volume;
        } else {
            self.back += volume;
        }
        let mut around = std::mem::take(&mut self.scratch);
        mesh.triangles_of(rub.feature, &mut around);
        let share = signed / around.len().max(1) as f64;
        for &triangle in &around {
            self.triangle_owed[triangle as usize] += share;
        }
        self.scratch = around;
        for (corner, weight) in base.corners.into_iter().zip(base.weights) {
            if weight > 0.0 {
                self.owe(self.skin.node_of[corner as usize], weight * signed);
            }
        }
    }

    /// A node owes more.
    pub(super) fn owe(&mut self, node: u32, volume: f64) {
        let index = node as usize;
        self.waiting[index] += volume;
        if !std::mem::replace(&mut self.owes[index], true) {
            self.owing.push(node);
        }
        let waiting = self.waiting[index];
        if self.plan.moves {
            self.is_due |= (waiting - self.left[index]).abs() >= self.limits[index];
        }
        if self.plan.until_depth.is_finite() && !self.blocked[index] {
            let ahead = self.depth_along(node) + 3.0 * waiting / self.areas[index];
            let is_deep = ahead.abs() >= self.plan.until_depth;
            self.is_due |= is_deep && self.plan.moves;
            self.is_worn |= is_deep && !self.plan.moves;
        }
    }

    /// Whether the surface is to move.
    #[must_use]
    pub fn is_due(&self) -> bool {
        self.is_due
    }

    /// Whether it owes anything that a move could place.
    #[must_use]
    pub fn is_owing(&self) -> bool {
        self.plan.moves && !self.owing.is_empty()
    }

    /// Whether it has reached its `until_depth`.
    #[must_use]
    pub fn is_worn(&self) -> bool {
        self.is_worn
    }

    /// How far a node has moved against its first normal, m.
    pub(super) fn depth_along(&self, node: u32) -> f64 {
        let index = node as usize;
        -self.displacement[index].dot(self.skin.normals[index])
    }

    /// 1 where the side of the normals owes more, else -1.
    fn sign(&self) -> f64 {
        if self.front >= self.back { 1.0 } else { -1.0 }
    }

    /// Depth of a node on the side that owes more, m: of a wear map what it would be.
    fn depth(&self, node: u32) -> f64 {
        let along = if self.plan.moves {
            self.depth_along(node)
        } else {
            3.0 * self.waiting[node as usize] / self.areas[node as usize]
        };
        self.sign() * along
    }

    /// Volume between the first surface and the present one, against the normals, m^3.
    pub(super) fn removed_along(&self) -> f64 {
        self.removed.iter().sum()
    }

    /// In numbers.
    #[must_use]
    pub fn row(&self) -> WearRow {
        let mut deepest = (0.0, DVec3::ZERO);
        for &vertex in &self.skin.vertices {
            let depth = self.depth(self.skin.node_of[vertex as usize]);
            if depth > deepest.0 {
                deepest = (depth, self.skin.first[vertex as usize]);
            }
        }
        let removed = self.sign() * self.removed_along();
        let net = (self.front - self.back).abs();
        let of_node =
            |node: usize| u64::from(self.blocked[node]) * u64::from(self.skin.members[node]);
        WearRow {
            owed: self.front + self.back,
            removed,
            pending: net - removed,
            front: self.front,
            back: self.back,
            max_depth: deepest.0,
            place: deepest.1,
            moves: self.moves,
            blocked: (0..self.skin.nodes()).map(of_node).sum(),
        }
    }

    /// The vertices that have moved or owe something, by their numbers.
    pub fn vertices(&self) -> impl Iterator<Item = WornVertex> + '_ {
        let sign = self.sign();
        (0u32..)
            .zip(&self.skin.vertices)
            .filter_map(move |(vertex, &corner)| {
                let node = self.skin.node_of[corner as usize];
                let index = node as usize;
                let (displacement, waiting) = (self.displacement[index], self.waiting[index]);
                let is_worn = displacement != DVec3::ZERO || waiting != 0.0;
                is_worn.then(|| WornVertex {
                    vertex,
                    first: self.skin.first[corner as usize],
                    displacement,
                    depth: self.depth(node),
                    owed: sign * waiting / f64::from(self.skin.members[index]),
                })
            })
    }

    /// Volume that a triangle has lost, m^3. Never -0: an interrupted run is to write the same bytes.
    pub(super) fn lost(&self, triangle: u32) -> f64 {
        0.0 - self.skin.swept(triangle, &self.displacement)
    }

    /// The triangles that owed or lost something: place in the file, what contacts on them owed, and what they have lost, m^3, on the side that owes
    /// more.
    pub fn triangles(&self) -> impl Iterator<Item = (u32, f64, f64)> + '_ {
        let sign = self.sign();
        let both = self.triangle_owed.iter().zip(&self.removed);
        (0u32..)
            .zip(both)
            .filter_map(move |(triangle, (&owed, &removed))| {
                let is_worn = owed != 0.0 || removed != 0.0;
                is_worn.then_some((triangle, sign * owed, sign * removed))
            })
    }

    /// Displacements of the corners of the mesh, m.
    pub fn corner_displacements(&self) -> impl Iterator<Item = DVec3> + '_ {
        // A corner of no triangle of the file is a copy without an original; it stays.
        (self.skin.node_of.iter()).map(|&node| {
            self.displacement
                .get(node as usize)
                .copied()
                .unwrap_or_default()
        })
    }

    /// Places of the corners of the mesh where the surface is now, m.
    #[must_use]
    pub fn corners(&self) -> Vec<DVec3> {
        let first = self.skin.first.iter();
        first
            .zip(self.corner_displacements())
            .map(|(&first, way)| first + way)
            .collect()
    }

    /// The largest move of a vertex at once, over what `step` allows.
    #[must_use]
    pub fn largest_move(&self) -> f64 {
        self.largest_move
    }

    /// Where the body was worn through first.
    #[must_use]
    pub fn worn_through(&self) -> Option<WornThrough> {
        self.worn_through
    }
}
