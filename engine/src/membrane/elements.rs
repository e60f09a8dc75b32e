//! The elements of a sheet as pure functions: the uniformly strained triangle and the hinge.

use glam::DVec3;

use super::forces::in_lanes;
use crate::lanes::{Real, Vector};

/// A triangle at rest for the law of St. Venant and Kirchhoff, or several in lanes.
///
/// With the edge vectors d1, d2 from the first corner, the metric g_ab = d_a . d_b and that of the rest shape G, the strain is
/// e = (g - G)/2 and the energy per rest area E t/(2 (1 - nu^2)) \[(1 - nu) e:e + nu tr(e)^2\], indices raised by G^-1
/// (Ciarlet 2000, Mathematical Elasticity III). It is exact where the strain is uniform.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strained<L = f64> {
    /// G: 11, 12, 22, m^2.
    metric: [L; 3],
    /// G^-1: 11, 12, 22, 1/m^2.
    inverse: [L; 3],
    /// Rest area, m^2.
    area: L,
}

impl<L: Real> Strained<L> {
    /// `strained(k)` in lane `k`.
    #[inline(always)]
    #[must_use]
    pub fn gather<'a>(strained: impl Fn(usize) -> &'a Strained) -> Self {
        Self {
            metric: [
                in_lanes(|k| strained(k).metric[0]),
                in_lanes(|k| strained(k).metric[1]),
                in_lanes(|k| strained(k).metric[2]),
            ],
            inverse: [
                in_lanes(|k| strained(k).inverse[0]),
                in_lanes(|k| strained(k).inverse[1]),
                in_lanes(|k| strained(k).inverse[2]),
            ],
            area: in_lanes(|k| strained(k).area),
        }
    }

    /// The stress S^ab (11, 12, 22), N/m^3, and the energy, J, with the edge vectors d1 and d2. `stiffness`: E t, N/m.
    #[inline(always)]
    fn stress(&self, [d1, d2]: [Vector<L>; 2], stiffness: f64, nu: f64) -> ([L; 3], L) {
        let [g11, g12, g22] = self.metric;
        let e11 = (d1.dot(d1) - g11) * 0.5;
        let e12 = (d1.dot(d2) - g12) * 0.5;
        let e22 = (d2.dot(d2) - g22) * 0.5;
        self.response([e11, e12, e22], stiffness, nu)
    }

    /// Stress and energy for a strain (11, 12, 22), m^2.
    #[inline(always)]
    fn response(&self, [e11, e12, e22]: [L; 3], stiffness: f64, nu: f64) -> ([L; 3], L) {
        let [h11, h12, h22] = self.inverse;
        // Mixed components, first index up.
        let m11 = h11 * e11 + h12 * e12;
        let m12 = h11 * e12 + h12 * e22;
        let m21 = h12 * e11 + h22 * e12;
        let m22 = h12 * e12 + h22 * e22;
        let trace = m11 + m22;
        let square = m11 * m11 + m12 * m21 * 2.0 + m22 * m22;
        let plane = stiffness / (1.0 - nu * nu);
        let shear = plane * (1.0 - nu);
        let equal = trace * (plane * nu);
        let stress = [
            (m11 * h11 + m12 * h12) * shear + equal * h11,
            (m11 * h12 + m12 * h22) * shear + equal * h12,
            (m21 * h12 + m22 * h22) * shear + equal * h22,
        ];
        let energy = self.area * 0.5 * (square * shear + equal * trace);
        (stress, energy)
    }

    /// Tensions along the sides over their lengths, N/m, from the first, second and third corner on. They are the forces -A0 S^ab d_b on
    /// the second and the third corner, and minus the sum of these on the first: three forces in a plane without sum and torque.
    #[inline(always)]
    #[must_use]
    pub fn tensions(&self, sides: [Vector<L>; 2], stiffness: f64, nu: f64) -> [L; 3] {
        let ([s11, s12, s22], _) = self.stress(sides, stiffness, nu);
        let area = self.area;
        [area * (s11 + s12), -(area * s12), area * (s22 + s12)]
    }
}

impl Strained {
    /// Triangle with these corners at rest.
    #[must_use]
    pub fn new([a, b, c]: [DVec3; 3]) -> Self {
        let (d1, d2) = (b - a, c - a);
        let metric = [d1.dot(d1), d1.dot(d2), d2.dot(d2)];
        let area = 0.5 * d1.cross(d2).length();
        let determinant = 4.0 * area * area;
        let [g11, g12, g22] = metric;
        Self {
            metric,
            inverse: [g22 / determinant, -g12 / determinant, g11 / determinant],
            area,
        }
    }

    /// Energy, J.
    #[must_use]
    pub fn energy(&self, d1: DVec3, d2: DVec3, stiffness: f64, nu: f64) -> f64 {
        self.stress([d1, d2].map(Vector::from), stiffness, nu).1
    }

    /// Second derivative of the energy where the edge vectors change by `rates` times the way along the unit vector `axis`, N/m: twice the energy of
    /// the rate of strain, and the stress times the second derivative of the strain.
    #[must_use]
    pub fn stiffness_along(
        &self,
        [d1, d2]: [DVec3; 2],
        [r1, r2]: [f64; 2],
        axis: DVec3,
        stiffness: f64,
        nu: f64,
    ) -> f64 {
        let (along1, along2) = (d1.dot(axis), d2.dot(axis));
        let rate = [r1 * along1, 0.5 * (r1 * along2 + r2 * along1), r2 * along2];
        let (_, energy) = self.response(rate, stiffness, nu);
        let ([s11, s12, s22], _) = self.stress([d1, d2].map(Vector::from), stiffness, nu);
        2.0 * energy + self.area * (s11 * r1 * r1 + 2.0 * s12 * r1 * r2 + s22 * r2 * r2)
    }

    /// A times the tension (Cauchy stress times thickness), N m.
    #[must_use]
    pub fn tension_times_area(&self, d1: DVec3, d2: DVec3, stiffness: f64, nu: f64) -> Tension {
        let ([s11, s12, s22], _) = self.stress([d1, d2].map(Vector::from), stiffness, nu);
        let mut tension = Tension::default();
        tension.add(self.area * s11, d1, d1);
        tension.add(self.area * s22, d2, d2);
        tension.add(self.area * s12, d1, d2);
        tension.add(self.area * s12, d2, d1);
        tension
    }
}

/// The sides of a triangle as its hinges need them: what hinges exert on corners, and what velocities of corners do to hinges, along the
/// normal over the area.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sides<L> {
    /// Squares of the sides from the first, second and third corner on, m^2.
    squares: [L; 3],
    /// At each corner the product of the side that comes and the side that goes, m^2.
    turns: [L; 3],
}

impl<L: Real> Sides<L> {
    /// Sides from the first corner to the second and the third, m.
    #[inline(always)]
    pub(super) fn new(ab: Vector<L>, ac: Vector<L>) -> Self {
        let bc = ac - ab;
        Self {
            squares: [
                ab.length_squared(),
                bc.length_squared(),
                ac.length_squared(),
            ],
            turns: [-ac.dot(ab), ab.dot(bc), -bc.dot(ac)],
        }
    }

    /// For the corners, of numbers of the sides: the opposite one times its square, the adjacent ones times the turns at their other ends.
    #[inline(always)]
    pub(super) fn returned(&self, [of_ab, of_bc, of_ca]: [L; 3]) -> [L; 3] {
        let ([ab, bc, ca], [at_a, at_b, at_c]) = (self.squares, self.turns);
        [
            of_bc * bc + of_ab * at_b + of_ca * at_c,
            of_ca * ca + of_ab * at_a + of_bc * at_c,
            of_ab * ab + of_bc * at_b + of_ca * at_a,
        ]
    }

    /// For the sides, of numbers of the corners: the same factors the other way round.
    #[inline(always)]
    pub(super) fn shared(&self, [of_a, of_b, of_c]: [L; 3]) -> [L; 3] {
        let ([ab, bc, ca], [at_a, at_b, at_c]) = (self.squares, self.turns);
        [
            of_c * ab + of_a * at_b + of_b * at_a,
            of_a * bc + of_b * at_c + of_c * at_b,
            of_b * ca + of_c * at_a + of_a * at_c,
        ]
    }
}

/// A symmetric tensor: xx, yy, zz, xy, xz, yz.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Tension(pub [f64; 6]);

impl Tension {
    /// Adds `factor` times the symmetric part of a b^T.
    #[inline]
    pub(super) fn add(&mut self, factor: f64, a: DVec3, b: DVec3) {
        let n = &mut self.0;
        n[0] += factor * a.x * b.x;
        n[1] += factor * a.y * b.y;
        n[2] += factor * a.z * b.z;
        n[3] += 0.5 * factor * (a.x * b.y + a.y * b.x);
        n[4] += 0.5 * factor * (a.x * b.z + a.z * b.x);
        n[5] += 0.5 * factor * (a.y * b.z + a.z * b.y);
    }

    /// Adds another.
    pub fn add_all(&mut self, other: &Self) {
        for (own, other) in self.0.iter_mut().zip(other.0) {
            *own += other;
        }
    }

    /// Each component times a factor.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self(self.0.map(|component| component * factor))
    }

    /// Trace.
    #[must_use]
    pub fn trace(&self) -> f64 {
        self.0[0] + self.0[1] + self.0[2]
    }

    /// Its product with a vector.
    #[must_use]
    pub fn product(&self, a: DVec3) -> DVec3 {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        DVec3::new(
            xx * a.x + xy * a.y + xz * a.z,
            xy * a.x + yy * a.y + yz * a.z,
            xz * a.x + yz * a.y + zz * a.z,
        )
    }

    /// The principal values in the plane with this unit normal, larger first.
    #[must_use]
    pub fn principal(&self, normal: DVec3) -> [f64; 2] {
        let (one, other) = normal.any_orthonormal_pair();
        let first = one.dot(self.product(one));
        let second = other.dot(self.product(other));
        let mixed = one.dot(self.product(other));
        let mean = 0.5 * (first + second);
        let half = 0.5 * (first - second);
        let radius = (half * half + mixed * mixed).sqrt();
        [mean + radius, mean - radius]
    }
}

/// Two triangles at an edge: the bending element of Bridson, Marino and Fedkiw (2003).
///
/// x3 and x4 are the ends of the edge in the direction of the first triangle, x1 and x2 the corners beside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fold {
    /// Minus twice the gradient of the angle with respect to x1 ... x4, 1/m.
    pub u: [DVec3; 4],
    /// Sine of half the angle.
    pub half_sine: f64,
    /// Present length of the edge, m.
    pub length: f64,
}

impl Fold {
    /// Fold of four corners and the area vectors of the two triangles (normal times area, m^2).
    #[must_use]
    pub fn new(corners: [DVec3; 4], area1: DVec3, area2: DVec3) -> Self {
        let edge = corners[3] - corners[2];
        let length = edge.length();
        let side = |area: DVec3| {
            let inverse = area.length().recip();
            (area * inverse, inverse)
        };
        let (side1, side2) = (side(area1), side(area2));
        Self {
            u: Self::slopes(corners, length, side1, side2),
            half_sine: Self::half_sine(side1.0, side2.0, edge),
            length,
        }
    }

    /// Minus twice the gradient of the angle with respect to the corners, 1/m: with the length of the edge, m, and of each triangle its normal and the
    /// inverse of its area, 1/m^2.
    #[inline]
    #[must_use]
    pub fn slopes(
        [x1, x2, x3, x4]: [DVec3; 4],
        length: f64,
        (normal1, inverse1): (DVec3, f64),
        (normal2, inverse2): (DVec3, f64),
    ) -> [DVec3; 4] {
        // n/A of both triangles.
        let (over1, over2) = (normal1 * inverse1, normal2 * inverse2);
        let direction = (x4 - x3) * length.recip();
        [
            over1 * length,
            over2 * length,
            over1 * (x1 - x4).dot(direction) + over2 * (x2 - x4).dot(direction),
            -(over1 * (x1 - x3).dot(direction) + over2 * (x2 - x3).dot(direction)),
        ]
    }

    /// Sine of half the angle between two normals at an edge.
    #[inline(always)]
    #[must_use]
    pub fn half_sine(normal1: DVec3, normal2: DVec3, edge: DVec3) -> f64 {
        let half = 0.5 * (normal1 - normal2).length();
        let sign = normal1.cross(normal2).dot(edge);
        if sign < 0.0 { -half } else { half }
    }

    /// The angle, between -pi and pi.
    #[must_use]
    pub fn angle(area1: DVec3, area2: DVec3, edge: DVec3) -> f64 {
        let (n1, n2) = (area1.normalize(), area2.normalize());
        libm::atan2(n1.cross(n2).dot(edge.normalize()), n1.dot(n2))
    }
}

/// Energy of a hinge over its prefactor Ke e0^2/(A1 + A2): 2 \[2 (cos(theta0/2) - cos(theta/2)) - sin(theta0/2) (theta - theta0)\].
#[must_use]
pub fn hinge_energy(angle: f64, rest: f64) -> f64 {
    // As squares of sines, so that small angles keep their digits.
    let (quarter_sum, quarter_difference) = (0.25 * (angle + rest), 0.25 * (angle - rest));
    let cosines = 2.0 * libm::sin(quarter_sum) * libm::sin(quarter_difference);
    2.0 * (2.0 * cosines - libm::sin(0.5 * rest) * (angle - rest))
}
