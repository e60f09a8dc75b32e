//! Values of a sheet for outputs and the energy budget: energies, tensions, stretches.

use glam::{DVec2, DVec3};

use super::elements::{Fold, Tension, hinge_energy};
use super::sheet::{Elasticity, Sheet};

/// Sums over a sheet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SheetSummary {
    /// Present area, m^2.
    pub area: f64,
    /// Sum of area times tension over the area, N/m.
    pub tension: Tension,
    /// Energy of stretching, J.
    pub stretching: f64,
    /// Energy of the hinges, J.
    pub bending: f64,
    /// Least length of an edge over its length without force.
    pub least_stretch: f64,
    /// Largest.
    pub largest_stretch: f64,
}

/// One triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriangleTension {
    /// Present area, m^2.
    pub area: f64,
    /// Cauchy stress times thickness, N/m, tension positive.
    pub tension: Tension,
    /// Its principal values in the plane of the triangle, N/m, larger first.
    pub principal: [f64; 2],
}

impl Sheet {
    /// Energies, mean tension and stretches.
    #[must_use]
    pub fn seen(&self, positions: &[DVec3]) -> SheetSummary {
        let (mut area, mut tension) = (0.0, Tension::default());
        for index in 0..self.triangles.len() {
            let (own, of_area) = self.tension_times_area(index, positions);
            area += own.length();
            tension.add_all(&of_area);
        }
        let (least_stretch, largest_stretch) = self.stretches(positions);
        SheetSummary {
            area,
            tension: tension.times(1.0 / area),
            stretching: self.stretching_energy(positions),
            bending: self.bending_energy(positions),
            least_stretch,
            largest_stretch,
        }
    }

    /// Least and largest length of an edge over its length without force.
    #[must_use]
    pub fn stretches(&self, positions: &[DVec3]) -> (f64, f64) {
        let mut extremes = (f64::INFINITY, f64::NEG_INFINITY);
        for (edge, rest) in self.topology.edges().iter().zip(&self.edges) {
            let [a, b] = edge.ends.map(|k| positions[k as usize]);
            let stretch = (b - a).length() / rest.length;
            extremes = (extremes.0.min(stretch), extremes.1.max(stretch));
        }
        extremes
    }

    /// Area and tensions of a triangle.
    #[must_use]
    pub fn triangle(&self, index: usize, positions: &[DVec3]) -> TriangleTension {
        let (vector, of_area) = self.tension_times_area(index, positions);
        let area = vector.length();
        let tension = of_area.times(1.0 / area);
        TriangleTension {
            area,
            tension,
            principal: tension.principal(vector / area),
        }
    }

    /// Normal times area, and area times tension: (A0/A) S^ab d_a d_b^T of the continuum; for springs, each as far as it belongs to
    /// the triangle, k (l - l0)/l d d^T over the area.
    fn tension_times_area(&self, index: usize, positions: &[DVec3]) -> (DVec3, Tension) {
        let corners = self.topology.triangles()[index].map(|k| positions[k as usize]);
        let [a, b, c] = corners;
        let rest = &self.triangles[index];
        let stiffness = self.law.stiffness();
        let tension = match self.law.elasticity {
            Elasticity::Continuum { poisson_ratio } => {
                let strained = &rest.strained;
                strained.tension_times_area(b - a, c - a, stiffness, poisson_ratio)
            }
            Elasticity::Springs => {
                let mut tension = Tension::default();
                for k in 0..3 {
                    let (branch, at_rest) = (corners[(k + 1) % 3] - corners[k], rest.lengths[k]);
                    let part = stiffness * rest.area / (at_rest * at_rest);
                    let length = branch.length();
                    tension.add(part * (length - at_rest) / length, branch, branch);
                }
                tension
            }
        };
        (0.5 * (b - a).cross(c - a), tension)
    }

    /// Energy of stretching, J.
    #[must_use]
    pub fn stretching_energy(&self, positions: &[DVec3]) -> f64 {
        match self.law.elasticity {
            Elasticity::Springs => (self.topology.edges().iter().zip(&self.edges))
                .map(|(edge, rest)| {
                    let [a, b] = edge.ends.map(|k| positions[k as usize]);
                    let stretch = (b - a).length() - rest.length;
                    0.5 * rest.stiffness * stretch * stretch + rest.energy
                })
                .sum(),
            Elasticity::Continuum { poisson_ratio } => {
                let stiffness = self.law.stiffness();
                (self.topology.triangles().iter().zip(&self.triangles))
                    .map(|(corners, rest)| {
                        let [a, b, c] = corners.map(|k| positions[k as usize]);
                        let strained = &rest.strained;
                        strained.energy(b - a, c - a, stiffness, poisson_ratio)
                    })
                    .sum()
            }
        }
    }

    /// Energy of the hinges, J.
    #[must_use]
    pub fn bending_energy(&self, positions: &[DVec3]) -> f64 {
        let area = |triangle: u32| {
            let corners = self.topology.triangles()[triangle as usize];
            let [a, b, c] = corners.map(|k| positions[k as usize]);
            0.5 * (b - a).cross(c - a)
        };
        (self.topology.hinges().iter().zip(&self.hinges))
            .map(|(edge, rest)| {
                let [from, to] = edge.ends.map(|k| positions[k as usize]);
                let [one, other] = edge.triangles.map(area);
                rest.factor * hinge_energy(Fold::angle(one, other, to - from), rest.angle)
            })
            .sum()
    }

    /// How far the springs are from a sheet with Poisson's ratio 1/3: the tension of each triangle under uniform strain along a direction
    /// against that of the sheet, as a root mean square over all directions. `None` for the continuum, which is exact.
    #[must_use]
    pub fn scatter(&self) -> Option<Scatter> {
        if self.law.elasticity != Elasticity::Springs {
            return None;
        }
        let mut scatter = Scatter {
            deviation: 0.0,
            worst: 0.0,
        };
        let count = self.triangles.len() as f64;
        for rest in &self.triangles {
            let far = anisotropy(rest.lengths, rest.area);
            scatter.deviation += far * far / count;
            scatter.worst = scatter.worst.max(far);
        }
        scatter.deviation = scatter.deviation.sqrt();
        Some(scatter)
    }
}

/// Relative difference of the tension along a strained direction from E t 9/8 e, root mean square over directions.
///
/// The springs of a triangle give E t e sum(cos^4 (phi - phi_k)) = E t e \[9/8 + Re(e^-2i phi S2)/2 + Re(e^-4i phi S4)/8\] with
/// S_m = sum(e^(i m phi_k)) over the directions of the sides: both are 0 for equilateral triangles.
fn anisotropy(lengths: [f64; 3], area: f64) -> f64 {
    let [a, b, c] = lengths;
    let x = (a * a + c * c - b * b) / (2.0 * a);
    let y = 2.0 * area / a;
    let sides = [(a, 0.0), (x - a, y), (-x, -y)];
    let (mut second, mut fourth) = (DVec2::ZERO, DVec2::ZERO);
    for ((x, y), length) in sides.into_iter().zip(lengths) {
        let direction = DVec2::new(x, y) / length;
        let double = direction.rotate(direction);
        second += double;
        fourth += double.rotate(double);
    }
    let squares = second.length_squared() / 8.0 + fourth.length_squared() / 128.0;
    squares.sqrt() * 8.0 / 9.0
}

/// How far springs are from a sheet, in parts of the sheet's tension.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scatter {
    /// Root of the mean square over the triangles.
    pub deviation: f64,
    /// Value of the worst triangle.
    pub worst: f64,
}
