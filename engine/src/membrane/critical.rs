//! The largest stable time step of a sheet.

use glam::{DMat3, DVec3};

use super::elements::Fold;
use super::pressure::Load;
use super::sheet::{Elasticity, Sheet};
use super::topology::NONE;
use super::{HoldCourse, MembranePlan};

/// Upper bounds of the eigenvalues of a sheet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rates {
    /// Rate of stiffness over mass, 1/s^2: omega^2.
    pub stiffness: f64,
    /// Rate of damping over mass, 1/s: 2 z omega.
    pub damping: f64,
}

impl Rates {
    /// The largest stable step, s: h with h^2 omega^2/4 + h z omega = 1, which is 2/omega (sqrt(1 + z^2) - z). Dashpots see the
    /// velocities half a step before.
    #[must_use]
    pub fn critical_step(&self) -> f64 {
        let omega = self.stiffness.sqrt();
        let z = 0.5 * self.damping / omega;
        // Equal to the formula above, without a difference of large numbers.
        2.0 / omega / ((1.0 + z * z).sqrt() + z)
    }
}

impl MembranePlan {
    /// Whether every vertex is held from the start to the end, in all directions. Walls may vanish, and holds on them with it.
    #[must_use]
    pub fn is_all_held(&self) -> bool {
        let mut is_held = vec![false; self.sheet.masses().len()];
        let always = self.holds.iter().filter(|hold| {
            let whole = match &hold.ramp {
                HoldCourse::Velocity(components) => components.iter().all(Option::is_some),
                HoldCourse::Motion(_) => true,
                HoldCourse::Wall(_) => false,
            };
            whole && hold.from <= 0.0 && hold.until.is_infinite()
        });
        for &vertex in always.flat_map(|hold| &hold.vertices) {
            is_held[vertex as usize] = true;
        }
        is_held.into_iter().all(|held| held)
    }

    /// Upper bounds of the eigenvalues at the start, held vertices infinitely heavy in dashpots.
    #[must_use]
    pub fn rates(&self) -> Rates {
        let mut inverse_masses: Vec<f64> = (self.sheet.masses().iter())
            .map(|mass| mass.recip())
            .collect();
        for hold in &self.holds {
            for &vertex in &hold.vertices {
                inverse_masses[vertex as usize] = 0.0;
            }
        }
        let dashpots = self.sheet.dashpots(&inverse_masses);
        let positions = &self.surface.vertices;
        (self.sheet).rates(positions, &dashpots, &self.load, self.first_volume)
    }
}

impl Sheet {
    /// Upper bounds of the eigenvalues at this shape: the largest of any single triangle with a third of its mass at each corner, and of
    /// any hinge, the mass of each vertex shared among its hinges (the sums of both are bounds where both act), and of the enclosed fluid.
    /// `positions` in m; `first`: volume at the start, m^3.
    #[must_use]
    pub fn rates(&self, positions: &[DVec3], dashpots: &[f64], load: &Load, first: f64) -> Rates {
        let mut rates = self.triangle_rates(dashpots);
        let bending = self.hinge_rates(positions);
        rates.stiffness += bending.stiffness + self.fluid_rate(positions, load, first);
        rates.damping += bending.damping + self.law.drag;
        rates
    }

    /// Each triangle is three bars whose lengths are all that its strain can be written in: with B the change of lengths by
    /// displacements, the eigenvalues of M^-1 B^T K B other than 0 are those of K G, G = B M^-1 B^T.
    fn triangle_rates(&self, dashpots: &[f64]) -> Rates {
        // Dashpot of each side of a triangle, the part of the triangle.
        let mut sides = vec![[0.0; 3]; self.triangles.len()];
        for ((edge, rest), dashpot) in self.topology.edges().iter().zip(&self.edges).zip(dashpots) {
            let first = rest.first / rest.stiffness;
            for (k, part) in [first, 1.0 - first].into_iter().enumerate() {
                let triangle = edge.triangles[k];
                if triangle != NONE {
                    let corners = self.topology.triangles()[triangle as usize];
                    // The side begins where the triangle enters the edge.
                    let side = corners.iter().position(|&corner| corner == edge.ends[k]);
                    sides[triangle as usize][side.unwrap_or(0)] += part * dashpot;
                }
            }
        }
        let mut rates = Rates {
            stiffness: 0.0,
            damping: 0.0,
        };
        for (rest, dashpots) in self.triangles.iter().zip(sides) {
            let third = self.law.density * self.law.thickness * rest.area / 3.0;
            let lengths = rest.lengths;
            let mut g = [[0.0; 3]; 3];
            for i in 0..3 {
                for j in 0..3 {
                    g[i][j] = if i == j {
                        2.0 / third
                    } else {
                        // The cosine of the angle between the two sides, which is opposite to the third.
                        let k = 3 - i - j;
                        let [a, b, c] = [lengths[i], lengths[j], lengths[k]];
                        (a * a + b * b - c * c) / (2.0 * a * b) / third
                    };
                }
            }
            let k = match self.law.elasticity {
                Elasticity::Springs => {
                    let part = |length: f64| self.law.stiffness() * rest.area / (length * length);
                    diagonal(lengths.map(part))
                }
                Elasticity::Continuum { poisson_ratio } => {
                    strain_stiffness(lengths, rest.area, self.law.stiffness(), poisson_ratio)
                }
            };
            rates.stiffness = rates.stiffness.max(largest_eigenvalue(&k, &g));
            rates.damping = rates
                .damping
                .max(largest_eigenvalue(&diagonal(dashpots), &g));
        }
        rates
    }

    /// A hinge has one mode: its stiffness is the prefactor times the squared gradient of the angle.
    fn hinge_rates(&self, positions: &[DVec3]) -> Rates {
        let mut rates = Rates {
            stiffness: 0.0,
            damping: 0.0,
        };
        let Some(bending) = self.law.bending else {
            return rates;
        };
        let mut counts = vec![0.0; self.masses().len()];
        let corners_of = |edge: &super::Edge| {
            [
                edge.opposite[0],
                edge.opposite[1],
                edge.ends[0],
                edge.ends[1],
            ]
        };
        for edge in self.topology.hinges() {
            for corner in corners_of(edge) {
                counts[corner as usize] += 1.0;
            }
        }
        let area = |triangle: u32| {
            let corners = self.topology.triangles()[triangle as usize];
            let [a, b, c] = corners.map(|k| positions[k as usize]);
            0.5 * (b - a).cross(c - a)
        };
        for (edge, rest) in self.topology.hinges().iter().zip(&self.hinges) {
            let corners = corners_of(edge);
            let fold = Fold::new(
                corners.map(|k| positions[k as usize]),
                area(edge.triangles[0]),
                area(edge.triangles[1]),
            );
            // u is minus twice the gradient.
            let sum: f64 = (0..4)
                .map(|k| {
                    let vertex = corners[k] as usize;
                    fold.u[k].length_squared() * counts[vertex] / self.masses()[vertex]
                })
                .sum();
            rates.stiffness = rates.stiffness.max(0.25 * rest.factor * sum);
            rates.damping = rates.damping.max(bending.damping * fold.length * sum);
        }
        rates
    }

    /// The enclosed fluid has one mode too.
    fn fluid_rate(&self, positions: &[DVec3], load: &Load, first: f64) -> f64 {
        if !load.needs_volume() {
            return 0.0;
        }
        let gradient = self.volume_gradient(positions);
        let terms = gradient.iter().zip(self.masses());
        let sum: f64 = terms
            .map(|(slope, mass)| slope.length_squared() / mass)
            .sum();
        load.stiffness(first) * sum
    }
}

fn diagonal([a, b, c]: [f64; 3]) -> [[f64; 3]; 3] {
    [[a, 0.0, 0.0], [0.0, b, 0.0], [0.0, 0.0, c]]
}

/// Stiffness of the uniformly strained triangle against changes of its side lengths, N/m.
fn strain_stiffness(lengths: [f64; 3], area: f64, stiffness: f64, nu: f64) -> [[f64; 3]; 3] {
    // The triangle in its plane: corners at 0, (a, 0) and (x, y).
    let [a, b, c] = lengths;
    let x = (a * a + c * c - b * b) / (2.0 * a);
    let y = 2.0 * area / a;
    let sides = [(a, 0.0), (x - a, y), (-x, -y)];
    // Strain of each side: cos^2 e_xx + sin^2 e_yy + cos sin g_xy.
    let rows = [0, 1, 2].map(|k| {
        let (cos, sin) = (sides[k].0 / lengths[k], sides[k].1 / lengths[k]);
        [cos * cos, sin * sin, cos * sin]
    });
    let inverse = inverted(&rows);
    let plane = stiffness / (1.0 - nu * nu);
    let elastic = [
        [plane, nu * plane, 0.0],
        [nu * plane, plane, 0.0],
        [0.0, 0.0, 0.5 * (1.0 - nu) * plane],
    ];
    let mut k = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            let mut sum = 0.0;
            for p in 0..3 {
                for q in 0..3 {
                    sum += inverse[p][i] * elastic[p][q] * inverse[q][j];
                }
            }
            k[i][j] = area * sum / (lengths[i] * lengths[j]);
        }
    }
    k
}

fn inverted(m: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    // Rows as columns: the inverse of the transposed matrix is the transposed inverse.
    DMat3::from_cols_array_2d(m).inverse().to_cols_array_2d()
}

/// The largest eigenvalue of K G, both symmetric, neither with negative eigenvalues: that of L^T K L with G = L L^T.
fn largest_eigenvalue(k: &[[f64; 3]; 3], g: &[[f64; 3]; 3]) -> f64 {
    let l = cholesky(g);
    let mut a = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            for p in 0..3 {
                for q in 0..3 {
                    a[i][j] += l[p][i] * k[p][q] * l[q][j];
                }
            }
        }
    }
    // Closed form by the angle of the characteristic polynomial (Smith 1961, Commun. ACM 4, 168).
    let mean = (a[0][0] + a[1][1] + a[2][2]) / 3.0;
    let off = a[0][1] * a[0][1] + a[0][2] * a[0][2] + a[1][2] * a[1][2];
    let squares: f64 = (0..3).map(|i| (a[i][i] - mean) * (a[i][i] - mean)).sum();
    let p = ((squares + 2.0 * off) / 6.0).sqrt();
    if p <= 1e-14 * mean {
        return mean;
    }
    let b = |i: usize, j: usize| (a[i][j] - if i == j { mean } else { 0.0 }) / p;
    let determinant = b(0, 0) * (b(1, 1) * b(2, 2) - b(1, 2) * b(2, 1))
        - b(0, 1) * (b(1, 0) * b(2, 2) - b(1, 2) * b(2, 0))
        + b(0, 2) * (b(1, 0) * b(2, 1) - b(1, 1) * b(2, 0));
    let angle = libm::acos((0.5 * determinant).clamp(-1.0, 1.0)) / 3.0;
    mean + 2.0 * p * libm::cos(angle)
}

/// Lower triangle L with G = L L^T; a negative pivot, by round-off only, counts as 0.
fn cholesky(g: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let mut l = [[0.0_f64; 3]; 3];
    for i in 0..3 {
        for j in 0..=i {
            let products: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
            let sum = g[i][j] - products;
            if i == j {
                l[i][i] = sum.max(0.0).sqrt();
            } else if l[j][j] > 0.0 {
                l[i][j] = sum / l[j][j];
            }
        }
    }
    l
}
