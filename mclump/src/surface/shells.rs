//! Parts of a surface that are connected by edges: which is outside, which is a cavity.

use glam::DVec3;
use mercury_common::formats::mesh::TriangleMesh;
use rayon::prelude::*;

use super::edges::{Edges, is_collapsed};
use super::report::{Report, plural};
use super::tetrahedron;

/// Point-triangle tests that are spent on finding which shell lies in which.
const MOST_TESTS: usize = 200_000_000;
/// Number of shells beyond which not even the boxes are compared: a broken surface may have as many as triangles.
const MOST_SHELLS: usize = 3000;
const NONE: u32 = u32::MAX;

/// A part of the surface that is connected by edges.
#[derive(Debug, Clone, PartialEq)]
pub struct Shell {
    /// Number of triangles.
    pub triangles: usize,
    /// Signed volume in m3: negative if turned inward. Only means something if the shell is closed.
    pub volume: f64,
    /// Number of closed shells in which it lies: 0 outside, 1 a cavity, 2 a body in a cavity, ...
    pub depth: u32,
    /// One of its triangles.
    pub first_triangle: u32,
    low: DVec3,
    high: DVec3,
}

impl Shell {
    /// Whether it is a hole in another shell, and turned like one.
    #[must_use]
    pub fn is_cavity(&self) -> bool {
        self.depth % 2 == 1 && self.volume < 0.0
    }

    /// Outward at even depth, inward at odd depth.
    #[must_use]
    pub fn is_turned_right(&self) -> bool {
        (self.volume < 0.0) == (self.depth % 2 == 1)
    }
}

/// The shells in the order of their first triangles, and whether their nesting could be found.
pub(super) fn shells(mesh: &TriangleMesh, edges: &Edges) -> (Vec<Shell>, bool) {
    let labels = labels(mesh, edges);
    let mut shells: Vec<Shell> = Vec::new();
    let origin = mesh
        .bounds()
        .map_or(DVec3::ZERO, |(low, high)| low + 0.5 * (high - low));
    for (index, &label) in labels.iter().enumerate() {
        if label == NONE {
            continue;
        }
        let corners = mesh.corners(index);
        if label as usize == shells.len() {
            shells.push(Shell {
                triangles: 0,
                volume: 0.0,
                depth: 0,
                first_triangle: u32::try_from(index).unwrap_or(NONE),
                low: corners[0],
                high: corners[0],
            });
        }
        let shell = &mut shells[label as usize];
        shell.triangles += 1;
        shell.volume += tetrahedron(corners, origin);
        for corner in corners {
            shell.low = shell.low.min(corner);
            shell.high = shell.high.max(corner);
        }
    }
    let known = nest(mesh, &labels, &mut shells);
    (shells, known)
}

/// For each triangle the number of its shell; shells count in the order of their first triangles. Collapsed triangles have none.
pub(super) fn labels(mesh: &TriangleMesh, edges: &Edges) -> Vec<u32> {
    let mut sets = Sets::new(mesh.triangles.len());
    edges.for_each(|_, uses| {
        for pair in uses.windows(2) {
            sets.join(pair[0].triangle, pair[1].triangle, false);
        }
    });
    let mut number_of_root = vec![NONE; mesh.triangles.len()];
    let mut count = 0;
    let mut labels = vec![NONE; mesh.triangles.len()];
    for (triangle, index) in mesh.triangles.iter().zip(0u32..) {
        if is_collapsed(*triangle) {
            continue;
        }
        let (root, _) = sets.root(index);
        let number = &mut number_of_root[root as usize];
        if *number == NONE {
            *number = count;
            count += 1;
        }
        labels[index as usize] = *number;
    }
    labels
}

/// Finds the depth of each shell; false if that would take too long.
fn nest(mesh: &TriangleMesh, labels: &[u32], shells: &mut [Shell]) -> bool {
    let within = |inner: &Shell, outer: &Shell| {
        outer.low.cmple(inner.low).all()
            && outer.high.cmpge(inner.high).all()
            && (outer.high - outer.low) != (inner.high - inner.low)
    };
    if shells.len() > MOST_SHELLS {
        return false;
    }
    let mut pairs = Vec::new();
    let mut tests = 0;
    for (i, inner) in shells.iter().enumerate() {
        for (o, outer) in shells.iter().enumerate() {
            if i != o && within(inner, outer) {
                pairs.push((i, o));
                tests += mesh.triangles.len();
                if tests > MOST_TESTS {
                    return false;
                }
            }
        }
    }
    for (i, o) in pairs {
        let [a, b, c] = mesh.corners(shells[i].first_triangle as usize);
        let turns = winding_number(mesh, labels, o, (a + b + c) / 3.0);
        shells[i].depth += u32::from(turns.abs() > 0.5);
    }
    true
}

/// Winding number of a shell around a point, by the solid angles of its triangles (van Oosterom and Strackee 1983,
/// doi:10.1109/TBME.1983.325207).
fn winding_number(mesh: &TriangleMesh, labels: &[u32], shell: usize, point: DVec3) -> f64 {
    let angles: Vec<f64> = labels
        .par_chunks(4096)
        .enumerate()
        .map(|(chunk, labels)| {
            let mut sum = 0.0;
            for (offset, &label) in labels.iter().enumerate() {
                if label as usize != shell {
                    continue;
                }
                let [a, b, c] = mesh.corners(chunk * 4096 + offset).map(|v| v - point);
                let (la, lb, lc) = (a.length(), b.length(), c.length());
                let numerator = a.dot(b.cross(c));
                let denominator = la * lb * lc + a.dot(b) * lc + a.dot(c) * lb + b.dot(c) * la;
                sum += 2.0 * numerator.atan2(denominator);
            }
            sum
        })
        .collect();
    angles.iter().sum::<f64>() / (4.0 * std::f64::consts::PI)
}

/// Turns round the outer shells that are turned inward, and with `cavities` also shells inside another one that are turned
/// outward; reports what it did.
pub(super) fn turn_outward(
    mesh: &mut TriangleMesh,
    report: &mut Report,
    cavities: bool,
) -> Option<String> {
    let is_wrong = |shell: &Shell| {
        !shell.is_turned_right()
            && shell.volume != 0.0
            && (shell.depth.is_multiple_of(2) || cavities)
    };
    let wrong: Vec<bool> = report.shells.iter().map(is_wrong).collect();
    let count = wrong.iter().filter(|wrong| **wrong).count();
    if count == 0 || !report.nesting_known {
        return None;
    }
    let labels = labels(mesh, &Edges::new(mesh));
    for (triangle, label) in mesh.triangles.iter_mut().zip(labels) {
        if label != NONE && wrong[label as usize] {
            triangle.swap(1, 2);
        }
    }
    let mut inward = 0;
    for (shell, _) in report.shells.iter_mut().zip(&wrong).filter(|(_, w)| **w) {
        inward += usize::from(shell.depth.is_multiple_of(2));
        shell.volume = -shell.volume;
    }
    Some(if count == report.shells.len() {
        "the surface was turned inward (its volume was negative): it is turned round".to_owned()
    } else {
        format!(
            "{} of {} turned round ({inward} inward, {} cavities outward)",
            plural(count, "shell"),
            report.shells.len(),
            count - inward
        )
    })
}

/// Disjoint sets with a parity: whether a member is turned against its root.
pub(super) struct Sets {
    parent: Vec<u32>,
    parity: Vec<bool>,
}

impl Sets {
    pub(super) fn new(length: usize) -> Self {
        Self {
            parent: (0..).take(length).collect(),
            parity: vec![false; length],
        }
    }

    /// The root of a member, and whether the member is turned against it.
    pub(super) fn root(&mut self, member: u32) -> (u32, bool) {
        let mut at = member;
        let mut turned = false;
        while self.parent[at as usize] != at {
            let parent = self.parent[at as usize];
            // Halve the path: grandparent instead of parent.
            let grandparent = self.parent[parent as usize];
            if grandparent != parent {
                self.parity[at as usize] ^= self.parity[parent as usize];
                self.parent[at as usize] = grandparent;
            }
            turned ^= self.parity[at as usize];
            at = self.parent[at as usize];
        }
        (at, turned)
    }

    /// Joins the sets of two members, `opposite` if one is turned against the other. False if they were joined already with another
    /// parity.
    pub(super) fn join(&mut self, a: u32, b: u32, opposite: bool) -> bool {
        let ((root_a, turned_a), (root_b, turned_b)) = (self.root(a), self.root(b));
        let parity = turned_a ^ turned_b ^ opposite;
        if root_a == root_b {
            return !parity;
        }
        // The smaller index becomes the root, so that the result depends on the mesh alone.
        let (keep, drop) = (root_a.min(root_b), root_a.max(root_b));
        self.parent[drop as usize] = keep;
        self.parity[drop as usize] = parity;
        true
    }
}
