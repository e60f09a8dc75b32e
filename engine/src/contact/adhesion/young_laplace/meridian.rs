//! The meridian of a bridge: what three unknown numbers make of it, and the equations that they have to fulfil.
//!
//! Without gravity the mean curvature h is the same all over the free surface, and the pull is the same in every section (Orr,
//! Scriven & Rivas 1975). For the meridian y(x) with the slope angle psi, tan psi = dy/dx, that is
//!
//! ```text
//! y cos psi = a + h y^2,   a = F/(2 pi gamma),   h = (pressure inside - outside)/(2 gamma)
//! ```
//!
//! By the arc length s, u = y^2 then obeys u'' = 2 (1 - 2 a h) - 4 h^2 u. Its solution is elementary, as Kenmotsu (1980) has it
//! for all surfaces of revolution of constant mean curvature:
//!
//! ```text
//! u(s) = u_0 + 2 y_0 sin psi_0 S C + (1 - 2 h y_0 cos psi_0) S^2,   S = sin(h s)/h,   C = cos(h s)
//! ```
//!
//! It is smooth through necks, bulges and points of inflection, for either sign of h and for h = 0. Integrals over s are by Gauss'
//! rule.

use std::f64::consts::PI;
use std::sync::LazyLock;

use super::dual::Dual;

/// Points of Gauss' rule over the meridian. With them the longest gap is right to 4e-7 where the neck is thinnest (a contact angle
/// of 0, at the end of the stable branch), and everything to round-off up to three quarters of it.
const POINTS: usize = 32;

/// Points in (0, 1) and their weights.
pub(super) static GAUSS: LazyLock<[(f64, f64); POINTS]> = LazyLock::new(gauss);

/// Points and weights of Gauss' rule on (0, 1).
fn gauss() -> [(f64, f64); POINTS] {
    let n = POINTS as f64;
    let mut rule = [(0.0, 0.0); POINTS];
    for (k, point) in rule.iter_mut().enumerate() {
        // Newton's iteration for the zeros of Legendre's polynomial
        let mut x = libm::cos(PI * (k as f64 + 0.75) / (n + 0.5));
        let mut slope = 1.0;
        for _ in 0..10 {
            let (mut before, mut now) = (1.0, x);
            for j in 2..=POINTS {
                let j = j as f64;
                (before, now) = (now, ((2.0 * j - 1.0) * x * now - (j - 1.0) * before) / j);
            }
            slope = n * (x * now - before) / (x * x - 1.0);
            x -= now / slope;
        }
        *point = (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope));
    }
    rule
}

/// Half-filling angle at the first sphere (rad), turn h L, length L of the meridian, gap (lengths in R_D).
pub(super) type Unknowns = [f64; 4];

/// A bridge at one gap. Units as the [module](super) has them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bridge {
    /// Gap, R_D.
    pub gap: f64,
    /// Pull, gamma R_D; negative where the bridge pushes.
    pub force: f64,
    /// Half-filling angles at the smaller and the larger sphere, rad; 0 at a plane.
    pub filling: [f64; 2],
    /// Radii of the contact lines on the smaller and the larger sphere, R_D.
    pub wetted: [f64; 2],
    /// Mean curvature: pressure inside minus outside over 2 gamma, 1/R_D.
    pub curvature: f64,
    /// Free (lateral) surface, R_D^2.
    pub area: f64,
    /// Surface energy: the free surface minus cos theta times the wetted ones, gamma R_D^2.
    pub surface_energy: f64,
}

/// Given values: contact angle, volume, and the curvatures of the two spheres. The first of them is no plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Given {
    theta: f64,
    cos: f64,
    sin: f64,
    curvatures: [f64; 2],
    volume: f64,
    scale: f64,
}

impl Given {
    /// Contact angle in rad, volume in R_D^3, curvatures in 1/R_D.
    pub(super) fn new(theta: f64, volume: f64, curvatures: [f64; 2]) -> Self {
        let (sin, cos) = libm::sincos(theta);
        Self {
            theta,
            cos,
            sin,
            curvatures,
            volume,
            scale: libm::cbrt(volume),
        }
    }

    /// Scales of the unknowns: those of lengths along the axis follow the cube root of the volume.
    pub(super) fn units(&self) -> Unknowns {
        [1.0, 1.0, self.scale, self.scale]
    }

    /// A bridge between touching spheres, roughly: a circle as meridian, and the half-filling angle that Lian & Seville (2016)
    /// fitted for equal spheres.
    pub(super) fn guess(&self) -> Unknowns {
        let (v, theta) = (self.volume, self.theta);
        let fit =
            libm::pow(v, 0.26) + (0.285 - 0.4594 * theta) * libm::pow(v, 0.6327 + 0.897 * theta);
        let y = libm::sin(f64::min(fit, 1.2));
        let filling = self.curvatures.map(|c| libm::asin(f64::min(c * y, 0.9)));
        let caps = [0, 1].map(|i| self.curvatures[i] * y * y / (1.0 + libm::cos(filling[i])));
        let height = caps[0] + caps[1];
        let slopes = filling.map(|beta| PI / 2.0 - beta - theta);
        let turned = slopes[0] + slopes[1];
        let rise = libm::sin(slopes[0]) + libm::sin(slopes[1]);
        let length = if rise.abs() > 1e-6 {
            height * turned / rise
        } else {
            height
        };
        [filling[0], 0.5 * (length / y - turned), length, 0.0]
    }

    /// By how much the unknowns miss contact angle, volume and gap, and the derivatives of that.
    pub(super) fn residuals(&self, w: Unknowns) -> ([f64; 3], [[f64; 4]; 3]) {
        let [angle, volume, gap] = self.equations([w[0], w[1], w[2]]);
        let (per_volume, per_gap) = (1.0 / self.volume, 1.0 / self.scale);
        let row = |dual: Dual, scale: f64, last: f64| {
            let [a, b, c] = dual.by.map(|d| d * scale);
            [a, b, c, last]
        };
        (
            [
                angle.value,
                volume.value * per_volume - 1.0,
                (gap.value - w[3]) * per_gap,
            ],
            [
                row(angle, 1.0, 0.0),
                row(volume, per_volume, 0.0),
                row(gap, per_gap, -per_gap),
            ],
        )
    }

    /// A measure of the contact angle at the second sphere (0 where it is right), volume and gap.
    fn equations(&self, x: [f64; 3]) -> [Dual; 3] {
        let [beta, turn, length] = [0, 1, 2].map(|k| Dual::variable(x[k], k));
        let start = self.start(beta, turn, length);
        let last = self.last(&start, turn, length);
        // sin beta = cos(psi + theta) at the contact line
        let angle = (last.u * self.curvatures[1] - last.level * self.cos + last.rise * self.sin)
            / last.u.sqrt();

        let (mut along, mut volume) = (Dual::constant(0.0), Dual::constant(0.0));
        for &(point, weight) in GAUSS.iter() {
            let (u, _) = start.at(point, turn, length);
            let y = u.sqrt();
            let level = (start.a + start.h * u) * weight;
            along = along + level / y;
            volume = volume + level * y;
        }
        let (mut gap, mut volume) = (along * length, volume * length * PI);
        // without the caps of the spheres
        for (curvature, u, cos) in [
            (self.curvatures[0], start.u, start.cos_filling),
            (self.curvatures[1], last.u, last.cos_filling),
        ] {
            let radius = u / (cos + 1.0);
            let height = radius * curvature;
            gap = gap - height;
            volume =
                volume - radius * radius * (-(height * curvature) + 3.0) * (PI / 3.0 * curvature);
        }
        [angle, volume, gap]
    }

    fn start(&self, beta: Dual, turn: Dual, length: Dual) -> Start {
        let (sin, cos) = beta.sin_cos();
        let y = sin * (1.0 / self.curvatures[0]);
        // psi = pi/2 - beta - theta, looking outwards
        let cos_psi = sin * self.cos + cos * self.sin;
        let sin_psi = cos * self.cos - sin * self.sin;
        let h = turn / length;
        Start {
            u: y * y,
            rise: -(y * sin_psi),
            bend: -(h * y * cos_psi * 2.0) + 1.0,
            a: y * cos_psi - h * y * y,
            h,
            cos_filling: cos,
        }
    }

    fn last(&self, start: &Start, turn: Dual, length: Dual) -> Last {
        let (u, rise) = start.at(1.0, turn, length);
        let level = start.a + start.h * u;
        Last {
            u,
            rise,
            level,
            // cos beta = sin(psi + theta)
            cos_filling: (rise * self.cos + level * self.sin) / u.sqrt(),
        }
    }

    /// The bridge that solved unknowns stand for.
    pub(super) fn bridge(&self, w: Unknowns) -> Bridge {
        let [beta, turn, length] = [w[0], w[1], w[2]].map(Dual::constant);
        let start = self.start(beta, turn, length);
        let last = self.last(&start, turn, length);
        let wetted = [start.u.value.sqrt(), last.u.value.sqrt()];
        let mut area = 0.0;
        for &(point, weight) in GAUSS.iter() {
            area += weight * start.at(point, turn, length).0.value.sqrt();
        }
        area *= 2.0 * PI * length.value;
        let caps = start.u.value / (1.0 + start.cos_filling.value)
            + last.u.value / (1.0 + last.cos_filling.value);
        let other = libm::atan2(self.curvatures[1] * wetted[1], last.cos_filling.value);
        Bridge {
            gap: w[3],
            force: 2.0 * PI * start.a.value,
            filling: [w[0], other],
            wetted,
            curvature: start.h.value,
            area,
            surface_energy: area - 2.0 * PI * self.cos * caps,
        }
    }
}

/// The meridian at its first end: y^2, y sin psi towards the other sphere, what multiplies S^2, a, h, the cosine of the half-filling
/// angle.
#[derive(Debug, Clone, Copy)]
struct Start {
    u: Dual,
    rise: Dual,
    bend: Dual,
    a: Dual,
    h: Dual,
    cos_filling: Dual,
}

/// The meridian at its second end: y^2, y sin psi, y cos psi, the cosine of the half-filling angle.
#[derive(Debug, Clone, Copy)]
struct Last {
    u: Dual,
    rise: Dual,
    level: Dual,
    cos_filling: Dual,
}

impl Start {
    /// y^2 and y sin psi at a share of the length.
    fn at(&self, share: f64, turn: Dual, length: Dual) -> (Dual, Dual) {
        let (sinc, cos) = (turn * share).sinc_cos();
        let s = sinc * length * share;
        let h_s = s * self.h;
        let u = self.u + self.rise * s * cos * 2.0 + self.bend * s * s;
        let rise = self.rise * (cos * cos - h_s * h_s) + self.bend * s * cos;
        (u, rise)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_rule_is_exact_for_polynomials() {
        for power in [0, 1, 7, 40, 63] {
            let sum: f64 = GAUSS.iter().map(|(x, w)| w * x.powi(power)).sum();
            assert!((sum * f64::from(power + 1) - 1.0).abs() < 1e-13, "{power}");
        }
    }

    #[test]
    fn derivatives_are_those_of_the_equations() {
        let given = Given::new(0.4, 0.01, [1.3, 0.7]);
        let w = [0.4, -0.3, 0.2, 0.05];
        let (_, by) = given.residuals(w);
        for k in 0..4 {
            let step = 1e-6;
            let at = |sign: f64| {
                let mut w = w;
                w[k] += sign * step;
                given.residuals(w).0
            };
            let (ahead, behind) = (at(1.0), at(-1.0));
            for i in 0..3 {
                // central differences: step^2 times a third derivative of order 1e3, and 1e-16/step of round-off
                let difference = (ahead[i] - behind[i]) / (2.0 * step);
                assert!(
                    (difference - by[i][k]).abs() < 1e-7,
                    "{i} {k}: {difference}"
                );
            }
        }
    }
}
