//! Report on the properties of a surface.

use std::fmt;

use mercury_common::formats::mesh::TriangleMesh;

use super::edges::{Edges, Use, is_collapsed};
use super::shells::{Shell, shells};

/// Number of edges or triangles that a message names.
const NAMED: usize = 4;

/// Report of [`inspect`]. Edges are pairs of vertices, triangles count from 0 here and from 1 in messages.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// Number of triangles.
    pub triangles: usize,
    /// Number of vertices after welding.
    pub vertices: usize,
    /// Corners of the file that were merged into another one.
    pub welded: usize,
    /// Triangles with two equal corners.
    pub collapsed: Vec<u32>,
    /// Number of other triangles without area; they change no integral.
    pub without_area: usize,
    /// Triangles with the same three vertices as an earlier one.
    pub duplicates: Vec<u32>,
    /// Edges of one triangle only.
    pub open_edges: Vec<[u32; 2]>,
    /// Edges of two triangles that pass them in the same direction.
    pub inconsistent_edges: Vec<[u32; 2]>,
    /// Edges of more than two triangles.
    pub crowded_edges: Vec<[u32; 2]>,
    /// Number of those that are not passed equally in both directions.
    pub uneven_edges: usize,
    /// Number of edges.
    pub edges: usize,
    /// Parts that are connected by edges.
    pub shells: Vec<Shell>,
    /// Whether it is known which shell lies in which ([`Shell::depth`]).
    pub nesting_known: bool,
}

/// Looks at a surface.
#[must_use]
pub fn inspect(mesh: &TriangleMesh) -> Report {
    let edges = Edges::new(mesh);
    let (shells, nesting_known) = shells(mesh, &edges);
    let mut report = Report {
        triangles: mesh.triangles.len(),
        vertices: mesh.vertices.len(),
        welded: mesh.welded,
        collapsed: Vec::new(),
        without_area: 0,
        duplicates: Vec::new(),
        open_edges: Vec::new(),
        inconsistent_edges: Vec::new(),
        crowded_edges: Vec::new(),
        uneven_edges: 0,
        edges: 0,
        shells,
        nesting_known,
    };
    for (triangle, index) in mesh.triangles.iter().zip(0u32..) {
        if is_collapsed(*triangle) {
            report.collapsed.push(index);
        } else {
            let [a, b, c] = mesh.corners(index as usize);
            report.without_area += usize::from((b - a).cross(c - a).length_squared() == 0.0);
        }
    }
    edges.for_each(|edge, uses| {
        report.edges += 1;
        let forward = uses.iter().filter(|u| u.forward).count();
        let even = 2 * forward == uses.len();
        match uses.len() {
            1 => report.open_edges.push(edge),
            2 if !even => report.inconsistent_edges.push(edge),
            2 => {}
            _ => {
                report.crowded_edges.push(edge);
                report.uneven_edges += usize::from(!even);
            }
        }
        if uses.len() >= 2 {
            doubled(mesh, edge, uses, &mut report.duplicates);
        }
    });
    report.duplicates.sort_unstable();
    report.duplicates.dedup();
    report
}

/// Triangles at an edge with the same third vertex as an earlier one. Each is seen at the edge of its two smaller vertices only.
fn doubled(mesh: &TriangleMesh, edge: [u32; 2], uses: &[Use], duplicates: &mut Vec<u32>) {
    let third = |u: &Use| {
        let triangle = mesh.triangles[u.triangle as usize];
        triangle
            .into_iter()
            .find(|vertex| !edge.contains(vertex))
            .unwrap_or(edge[0])
    };
    for (index, current) in uses.iter().enumerate() {
        let vertex = third(current);
        if vertex > edge[1] && uses[..index].iter().any(|other| third(other) == vertex) {
            duplicates.push(current.triangle);
        }
    }
}

impl Report {
    /// Whether every edge is passed as often in one direction as in the other, so that the inside is defined.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.open_edges.is_empty() && self.inconsistent_edges.is_empty() && self.uneven_edges == 0
    }

    /// Whether every edge belongs to exactly two triangles.
    #[must_use]
    pub fn is_manifold(&self) -> bool {
        self.open_edges.is_empty() && self.crowded_edges.is_empty()
    }

    /// Whether neighbours agree on which side is outside.
    #[must_use]
    pub fn is_consistently_oriented(&self) -> bool {
        self.inconsistent_edges.is_empty() && self.uneven_edges == 0
    }

    /// Closed, manifold, without collapsed or doubled triangles.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        self.is_closed()
            && self.is_manifold()
            && self.collapsed.is_empty()
            && self.duplicates.is_empty()
            && self.shells.iter().all(Shell::is_turned_right)
    }

    /// Number of shells that are holes in another one.
    #[must_use]
    pub fn cavities(&self) -> usize {
        self.shells.iter().filter(|shell| shell.is_cavity()).count()
    }

    /// Oddities of a closed surface, in words.
    pub(super) fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if !self.duplicates.is_empty() {
            warnings.push(format!(
                "{} occur twice (triangle {} is the first); --repair drops them",
                plural(self.duplicates.len(), "triangle"),
                self.duplicates[0] + 1
            ));
        }
        if !self.crowded_edges.is_empty() {
            warnings.push(format!(
                "{} belong to more than two triangles: parts touch or overlap there",
                plural(self.crowded_edges.len(), "edge")
            ));
        }
        for (index, shell) in self.shells.iter().enumerate() {
            if !shell.is_turned_right() {
                warnings.push(format!(
                    "shell {} ({}) lies inside another one and is turned outward: what it encloses counts twice. \
                     A cavity must be turned inward; --repair does that",
                    index + 1,
                    plural(shell.triangles, "triangle")
                ));
            }
        }
        let outer = self.shells.iter().filter(|s| s.depth == 0).count();
        if outer > 1 {
            warnings.push(format!(
                "the surface consists of {outer} separate parts; they are taken as one rigid body, and where they overlap \
                 they count twice"
            ));
        }
        if !self.nesting_known {
            warnings.push(
                "the surface has too many parts to see which lies inside which; cavities are taken as the file turns them"
                    .to_owned(),
            );
        }
        warnings
    }

    /// Why the surface has no volume, and what to do.
    pub(super) fn refusal(&self, mesh: &TriangleMesh, repaired: bool) -> String {
        let edge_names = |edges: &[[u32; 2]]| {
            let point = |index: u32| {
                let v = mesh.vertices[index as usize];
                format!("({}, {}, {})", short(v.x), short(v.y), short(v.z))
            };
            let mut names: Vec<String> = edges
                .iter()
                .take(NAMED)
                .map(|[a, b]| format!("    {} - {}", point(*a), point(*b)))
                .collect();
            if edges.len() > NAMED {
                names.push(format!("    and {} more", edges.len() - NAMED));
            }
            names.join("\n")
        };
        let mut lines = vec![format!(
            "the surface is not closed, so it encloses no defined volume{}:",
            if repaired {
                ", also after the repair"
            } else {
                ""
            }
        )];
        if !self.open_edges.is_empty() {
            lines.push(format!(
                "  {} with one triangle only (a hole):",
                plural(self.open_edges.len(), "edge")
            ));
            lines.push(edge_names(&self.open_edges));
        }
        if !self.inconsistent_edges.is_empty() {
            lines.push(format!(
                "  {} whose two triangles disagree on which side is outside:",
                plural(self.inconsistent_edges.len(), "edge")
            ));
            lines.push(edge_names(&self.inconsistent_edges));
        }
        if self.uneven_edges > 0 {
            lines.push(format!(
                "  {} with more than two triangles that do not pair up:",
                plural(self.uneven_edges, "edge")
            ));
            lines.push(edge_names(&self.crowded_edges));
        }
        if !self.duplicates.is_empty() {
            let numbers: Vec<String> = self
                .duplicates
                .iter()
                .take(NAMED)
                .map(|t| (t + 1).to_string())
                .collect();
            lines.push(format!(
                "  {} standing twice (number {})",
                plural(self.duplicates.len(), "triangle"),
                numbers.join(", ")
            ));
        }
        lines.push(if repaired {
            format!(
                "help: repair closes holes of up to {:.0} % of the surface's area and turns triangles; mend the rest in the program \
                 that made the surface",
                100.0 * super::LARGEST_HOLE
            )
        } else {
            "help: --repair welds vertices, drops doubled triangles, turns inconsistent ones and closes small holes; or take \
             --inertia union with pebbles, which needs no closed surface"
                .to_owned()
        });
        lines.join("\n")
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let yes = |flag: bool, otherwise: String| if flag { "yes".to_owned() } else { otherwise };
        writeln!(
            f,
            "{}, {} ({} merged), {}",
            plural(self.triangles, "triangle"),
            plural(self.vertices, "vertex"),
            plural(self.welded, "corner"),
            plural(self.edges, "edge"),
        )?;
        writeln!(
            f,
            "closed: {}",
            yes(
                self.open_edges.is_empty(),
                format!("no, {} open", plural(self.open_edges.len(), "edge"))
            )
        )?;
        writeln!(
            f,
            "manifold: {}",
            yes(
                self.is_manifold(),
                if self.crowded_edges.is_empty() {
                    "no".to_owned()
                } else {
                    format!(
                        "no, {} with more than two triangles",
                        plural(self.crowded_edges.len(), "edge")
                    )
                }
            )
        )?;
        writeln!(
            f,
            "consistently oriented: {}",
            yes(
                self.is_consistently_oriented(),
                format!(
                    "no, at {}",
                    plural(self.inconsistent_edges.len() + self.uneven_edges, "edge")
                )
            )
        )?;
        if !self.collapsed.is_empty() || self.without_area > 0 {
            writeln!(
                f,
                "degenerate: {} with equal corners, {} without area",
                plural(self.collapsed.len(), "triangle"),
                self.without_area
            )?;
        }
        if !self.duplicates.is_empty() {
            writeln!(
                f,
                "standing twice: {}",
                plural(self.duplicates.len(), "triangle")
            )?;
        }
        write!(
            f,
            "shells: {}{}; self-intersection: not checked",
            self.shells.len(),
            match self.cavities() {
                0 => String::new(),
                n => format!(", {n} of them cavities"),
            }
        )
    }
}

/// `1 edge`, `2 edges`, `3 vertices`.
pub(crate) fn plural(number: usize, thing: &str) -> String {
    match (number, thing.strip_suffix("ex")) {
        (1, _) => format!("1 {thing}"),
        (_, Some(stem)) => format!("{number} {stem}ices"),
        _ => format!("{number} {thing}s"),
    }
}

/// A coordinate with at most seven digits.
fn short(x: f64) -> String {
    let rounded: f64 = format!("{x:.6e}").parse().unwrap_or(x);
    if rounded != 0.0 && !(1e-4..1e7).contains(&rounded.abs()) {
        format!("{rounded:e}")
    } else {
        format!("{rounded}")
    }
}
