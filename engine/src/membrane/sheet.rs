//! A sheet at rest: stiffnesses, rest lengths and angles, masses.

use glam::DVec3;

use super::elements::{Fold, Strained};
use super::topology::{NONE, Topology, TopologyError};

/// How a sheet resists stretching.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Elasticity {
    /// A spring along each edge, of stiffness E t (A1 + A2)/l^2; Poisson's ratio is 1/3.
    Springs,
    /// Uniformly strained triangles.
    Continuum {
        /// Poisson's ratio, in (-1, 0.5].
        poisson_ratio: f64,
    },
}

impl Elasticity {
    /// Poisson's ratio.
    #[must_use]
    pub fn poisson_ratio(self) -> f64 {
        match self {
            Self::Springs => 1.0 / 3.0,
            Self::Continuum { poisson_ratio } => poisson_ratio,
        }
    }
}

/// How a sheet resists bending.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bending {
    /// Ke, N m.
    pub stiffness: f64,
    /// Kd, N s.
    pub damping: f64,
    /// Whether hinges are free of moment where they are flat, instead of in the rest shape.
    pub rests_flat: bool,
}

/// Mechanical parameters of a sheet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Law {
    /// Thickness, m.
    pub thickness: f64,
    /// Young's modulus, Pa.
    pub youngs_modulus: f64,
    /// Density, kg/m^3.
    pub density: f64,
    /// Resistance to stretching.
    pub elasticity: Elasticity,
    /// Damping along each edge as a fraction of critical.
    pub damping_ratio: f64,
    /// Drag on vertices, 1/s.
    pub drag: f64,
    /// Resistance to bending; none: limp.
    pub bending: Option<Bending>,
}

impl Law {
    /// E t, N/m.
    #[must_use]
    pub fn stiffness(&self) -> f64 {
        self.youngs_modulus * self.thickness
    }

    /// Ke of a plate of this thickness, E t^3/(12 (1 - nu^2)), N m.
    #[must_use]
    pub fn plate_stiffness(&self) -> f64 {
        let nu = self.elasticity.poisson_ratio();
        let cube = self.thickness * self.thickness * self.thickness;
        self.youngs_modulus * cube / (12.0 * (1.0 - nu * nu))
    }
}

/// An edge at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RestEdge {
    /// Stiffness of the spring, N/m: of both triangles.
    pub stiffness: f64,
    /// Length without force, m.
    pub length: f64,
    /// Energy at that length, J: not 0 where the two triangles do not agree about it.
    pub energy: f64,
    /// Stiffness by the first triangle alone, N/m.
    pub first: f64,
}

/// A hinge at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RestHinge {
    /// Ke e0^2/(A1 + A2) with the edge and the areas at rest, N m.
    pub factor: f64,
    /// Angle without moment.
    pub angle: f64,
    /// Sine of its half.
    pub half_sine: f64,
}

/// A triangle at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RestTriangle {
    /// For the continuum.
    pub strained: Strained,
    /// Area, m^2.
    pub area: f64,
    /// Length of the edge that begins at each corner, m.
    pub lengths: [f64; 3],
}

/// Values of all edges at rest that each step reads.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct RestEdges {
    /// Stiffness times length without force, N.
    pub pull: Vec<f64>,
    /// Over the length without force, 1/m.
    pub inverse: Vec<f64>,
}

/// Values of all hinges at rest that each step reads, as in [`RestHinge`].
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct RestHinges {
    /// N m
    pub factor: Vec<f64>,
    pub half_sine: Vec<f64>,
}

/// Some entries for each vertex, in order.
#[derive(Debug, Clone, PartialEq, Default)]
struct Grouped<T> {
    /// Where the entries of each vertex begin, and the end.
    start: Vec<u32>,
    entries: Vec<T>,
}

impl<T: Ord + Copy> Grouped<T> {
    fn new(vertices: usize, pairs: impl Iterator<Item = (u32, T)>) -> Self {
        let mut pairs: Vec<(u32, T)> = pairs.collect();
        pairs.sort_unstable();
        let mut start = vec![0; vertices + 1];
        for &(vertex, _) in &pairs {
            start[vertex as usize + 1] += 1;
        }
        for k in 0..vertices {
            start[k + 1] += start[k];
        }
        // Without the memory of the pairs, in which it may be made.
        let mut entries: Vec<T> = pairs.into_iter().map(|(_, entry)| entry).collect();
        entries.shrink_to_fit();
        Self { start, entries }
    }

    #[inline]
    fn of(&self, vertex: usize) -> &[T] {
        &self.entries[self.start[vertex] as usize..self.start[vertex + 1] as usize]
    }
}

/// Edges and corners that each vertex sums over.
#[derive(Debug, Clone, PartialEq, Default)]
struct Gathers {
    edges: Grouped<[u32; 2]>,
    corners: Grouped<u32>,
}

/// A sheet: what never changes in a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Sheet {
    pub(super) topology: Topology,
    pub(super) law: Law,
    pub(super) edges: Vec<RestEdge>,
    pub(super) hinges: Vec<RestHinge>,
    pub(super) triangles: Vec<RestTriangle>,
    masses: Vec<f64>,
    /// Values of all edges, component by component.
    pub(super) rest: RestEdges,
    /// Values of all hinges, component by component.
    pub(super) bends: RestHinges,
    /// Ends of all edges.
    pub(super) ends: Vec<[u32; 2]>,
    /// Edges and corners that each vertex sums over.
    gathers: Gathers,
    /// The edges of each triangle, from its first, second and third corner on.
    pub(super) edges_of: Vec<[u32; 3]>,
    /// Triangles and sides that each edge belongs to: four times the triangle, plus the side. On a rim the second triangle is one
    /// behind the last.
    pub(super) sides_of: Vec<[u32; 2]>,
}

impl Sheet {
    /// A sheet whose triangles have these corners at rest, in m, in the order of the triangles of the topology. All lengths are
    /// taken over 1 + `prestrain`. Rest triangles need not be joined as those of the sheet are: a tube may be rolled from a flat strip.
    /// Where they are not, the hinge between them is flat at rest.
    ///
    /// # Errors
    /// If a triangle at rest has no area.
    pub fn new(
        topology: Topology,
        rest: &[[DVec3; 3]],
        prestrain: f64,
        law: Law,
    ) -> Result<Self, TopologyError> {
        Topology::check_areas(rest)?;
        let shrink = 1.0 / (1.0 + prestrain);
        let rest: Vec<[DVec3; 3]> = rest
            .iter()
            .map(|corners| corners.map(|corner| corner * shrink))
            .collect();
        let triangles: Vec<RestTriangle> = rest.iter().map(|&corners| at_rest(corners)).collect();
        let mut masses = vec![0.0; topology.vertices()];
        for (corners, triangle) in topology.triangles().iter().zip(&triangles) {
            let share = law.density * law.thickness * triangle.area / 3.0;
            for &corner in corners {
                masses[corner as usize] += share;
            }
        }
        let mut new = Self {
            edges: Vec::new(),
            hinges: Vec::new(),
            triangles,
            masses,
            rest: RestEdges::default(),
            bends: RestHinges::default(),
            ends: Vec::new(),
            gathers: Gathers::default(),
            edges_of: Vec::new(),
            sides_of: Vec::new(),
            topology,
            law,
        };
        new.find_edges();
        new.find_hinges(&rest);
        new.find_gathers();
        Ok(new)
    }

    fn find_edges(&mut self) {
        let stiffness = self.law.stiffness();
        let part = |triangle: u32, from: u32| {
            let rest = &self.triangles[triangle as usize];
            let corners = self.topology.triangles()[triangle as usize];
            let k = corners.iter().position(|&corner| corner == from);
            let length = rest.lengths[k.unwrap_or(0)];
            (stiffness * rest.area / (length * length), length)
        };
        self.edges = (self.topology.edges().iter())
            .map(|edge| {
                let (first, length) = part(edge.triangles[0], edge.ends[0]);
                if edge.triangles[1] == NONE {
                    return RestEdge {
                        stiffness: first,
                        length,
                        energy: 0.0,
                        first,
                    };
                }
                // The second triangle runs through the edge the other way.
                let (second, other) = part(edge.triangles[1], edge.ends[1]);
                let stiffness = first + second;
                let apart = length - other;
                RestEdge {
                    stiffness,
                    length: (first * length + second * other) / stiffness,
                    energy: 0.5 * first * second / stiffness * apart * apart,
                    first,
                }
            })
            .collect();
    }

    fn find_hinges(&mut self, rest: &[[DVec3; 3]]) {
        let Some(bending) = self.law.bending else {
            return;
        };
        let corner = |triangle: u32, vertex: u32| {
            let corners = self.topology.triangles()[triangle as usize];
            let k = corners.iter().position(|&corner| corner == vertex);
            rest[triangle as usize][k.unwrap_or(0)]
        };
        let area_vector = |triangle: u32| {
            let [a, b, c] = rest[triangle as usize];
            0.5 * (b - a).cross(c - a)
        };
        self.hinges = (self.topology.hinges().iter().zip(&self.edges))
            .map(|(edge, spring)| {
                let [one, other] = edge.triangles;
                let areas = self.triangles[one as usize].area + self.triangles[other as usize].area;
                let ends = edge.ends.map(|end| corner(one, end));
                let far_ends = edge.ends.map(|end| corner(other, end));
                let are_joined =
                    (0..2).all(|k| (ends[k] - far_ends[k]).length() < 1e-6 * spring.length);
                let angle = if bending.rests_flat || !are_joined {
                    0.0
                } else {
                    Fold::angle(area_vector(one), area_vector(other), ends[1] - ends[0])
                };
                RestHinge {
                    factor: bending.stiffness * spring.length * spring.length / areas,
                    angle,
                    half_sine: libm::sin(0.5 * angle),
                }
            })
            .collect();
    }

    /// The edges of each triangle, and for each vertex the corners of triangles that it adds up.
    fn find_gathers(&mut self) {
        let triangles = self.topology.triangles();
        self.edges_of = vec![[NONE; 3]; triangles.len()];
        self.sides_of = vec![[4 * triangles.len() as u32; 2]; self.edges.len()];
        for (index, edge) in (0u32..).zip(self.topology.edges()) {
            let own = edge.triangles.into_iter().filter(|&k| k != NONE);
            for (triangle, place) in own.zip(&mut self.sides_of[index as usize]) {
                let corners = triangles[triangle as usize];
                for k in 0..3 {
                    let side = [corners[k], corners[(k + 1) % 3]];
                    if side == edge.ends || side == [edge.ends[1], edge.ends[0]] {
                        self.edges_of[triangle as usize][k] = index;
                        *place = 4 * triangle + k as u32;
                    }
                }
            }
        }
        let vertices = self.topology.vertices();
        let places = (0u32..).zip(triangles).flat_map(|(triangle, corners)| {
            let places = (4 * triangle..).zip(corners);
            places.map(|(place, &vertex)| (vertex, place))
        });
        self.gathers.corners = Grouped::new(vertices, places);
        let edges = (0u32..).zip(self.topology.edges());
        let ends = edges.flat_map(|(index, edge)| {
            let [a, b] = edge.ends;
            [(a, [index, b]), (b, [index, a])]
        });
        self.gathers.edges = Grouped::new(vertices, ends);
        self.ends = self.topology.edges().iter().map(|edge| edge.ends).collect();
        let edges = self.edges.iter();
        self.rest = RestEdges {
            pull: edges
                .clone()
                .map(|edge| edge.stiffness * edge.length)
                .collect(),
            inverse: edges.map(|edge| edge.length.recip()).collect(),
        };
        let hinges = self.hinges.iter();
        self.bends = RestHinges {
            factor: hinges.clone().map(|hinge| hinge.factor).collect(),
            half_sine: hinges.map(|hinge| hinge.half_sine).collect(),
        };
    }

    /// The edges at a vertex, and the vertex at the other end of each.
    #[inline]
    pub(super) fn edges_at(&self, vertex: usize) -> &[[u32; 2]] {
        self.gathers.edges.of(vertex)
    }

    /// The corners of triangles at a vertex: four times the triangle, plus the place of the corner.
    #[inline]
    pub(super) fn corners_at(&self, vertex: usize) -> &[u32] {
        self.gathers.corners.of(vertex)
    }

    /// Its triangles, edges and rims.
    #[must_use]
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// Mechanical parameters of the sheet.
    #[must_use]
    pub fn law(&self) -> &Law {
        &self.law
    }

    /// Mass of each vertex, kg: a third of each of its triangles.
    #[must_use]
    pub fn masses(&self) -> &[f64] {
        &self.masses
    }

    /// Length without force of each edge, m, in the order of [`Topology::edges`].
    pub fn rest_lengths(&self) -> impl Iterator<Item = f64> + '_ {
        self.edges.iter().map(|edge| edge.length)
    }

    /// Area at rest, m^2.
    #[must_use]
    pub fn rest_area(&self) -> f64 {
        self.triangles.iter().map(|triangle| triangle.area).sum()
    }

    /// Memory that it takes, bytes: for estimates.
    #[must_use]
    pub fn bytes(&self) -> f64 {
        let Gathers { edges, corners } = &self.gathers;
        let (rest, bends) = (&self.rest, &self.bends);
        let bytes = self.topology.bytes()
            + size_of_val(&self.edges[..])
            + size_of_val(&self.hinges[..])
            + size_of_val(&self.triangles[..])
            + size_of_val(&self.masses[..])
            + size_of_val(&rest.pull[..])
            + size_of_val(&rest.inverse[..])
            + size_of_val(&bends.factor[..])
            + size_of_val(&bends.half_sine[..])
            + size_of_val(&self.ends[..])
            + size_of_val(&edges.start[..])
            + size_of_val(&edges.entries[..])
            + size_of_val(&corners.start[..])
            + size_of_val(&corners.entries[..])
            + size_of_val(&self.edges_of[..])
            + size_of_val(&self.sides_of[..]);
        bytes as f64
    }

    /// Coefficients of the dashpots along the edges, N s/m: 2 xi sqrt(m k), 1/m the sum of the inverse masses of both ends.
    /// Between two held vertices 0.
    #[must_use]
    pub fn dashpots(&self, inverse_masses: &[f64]) -> Vec<f64> {
        let dashpot = |(edge, rest): (&super::Edge, &RestEdge)| {
            let inverse: f64 = edge.ends.iter().map(|&k| inverse_masses[k as usize]).sum();
            if inverse > 0.0 {
                2.0 * self.law.damping_ratio * (rest.stiffness / inverse).sqrt()
            } else {
                0.0
            }
        };
        let edges = self.topology.edges().iter().zip(&self.edges);
        edges.map(dashpot).collect()
    }
}

fn at_rest(corners: [DVec3; 3]) -> RestTriangle {
    let [a, b, c] = corners;
    RestTriangle {
        strained: Strained::new(corners),
        area: 0.5 * (b - a).cross(c - a).length(),
        lengths: [(b - a).length(), (c - b).length(), (a - c).length()],
    }
}
