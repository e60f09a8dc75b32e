//! The capillary force of a liquid bridge over its gap: one function per law, from the volume and the contact angle to a
//! [`Curve`].
//!
//! Forces are in units of γ R_D and gaps in units of R_D, with R_D = 2R* (twice the radius at a flat wall) and V* = V/R_D³.

use std::f64::consts::PI;

use libm::{cbrt, cos, exp, log, pow, sin, sqrt, tan};

use super::bridge::SHORT;

/// How the numbers of a [`Curve`] give a force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// F = f (1 + a s)/(1 + p s + q s²), from the numbers f, a, p, q.
    Rational,
    /// F = f exp(−g exp(h x + i x²)) with x = ln(j s), from the numbers f, g, h, i, j.
    Exponential,
    /// That of a [`Bound`](crate::contact::adhesion::young_laplace::Bound), from its numbers but the first, which is the end.
    Exact,
}

/// Volumes over R_D^3 that the fits take: below and above, the shape of the force over s/end stays that of the last volume, as
/// polynomials and powers beyond the data that they were fitted to may have any sign.
const SMALLEST: f64 = 1e-5;
const LARGEST: f64 = 1.0;

fn within_fit(volume: f64) -> f64 {
    volume.clamp(SMALLEST, LARGEST)
}

/// The pull of a bridge over its gap, positive.
pub type Curve = [f64; SHORT];

/// Bagheri, Roy & Pöschel (2024), *Comput. Part. Mech.* 11, 2179: a rational fit to solutions of the Young-Laplace equation.
#[must_use]
pub fn bagheri(volume: f64, angle: f64) -> Curve {
    let v = within_fit(volume);
    let log_v = log(v);
    let f0 = 2.0 * PI * (1.0 - 0.3823 * pow(v, 0.2586));
    let a = 0.4158 * pow(v, 0.2835) + 0.6474;
    let b = 2.267 - 0.2087 * pow(v, 0.3113);
    let contact = f0 * (1.0 - a * pow(sin(angle), b));
    let at = (-0.007815 * log_v * log_v - 0.2105 * log_v - 1.426) * angle * angle * angle
        + (0.6669 * pow(v, -0.01391) - 1.78 * pow(v, 0.8351)) * angle
        + 1.0;
    let above = 0.6717 * pow(v, 0.1995) - 0.3319 * pow(v, 0.4974);
    let below = 13.84 * pow(v, -0.3909) - 12.11 * pow(v, -0.3945);
    let end = end_of_equal_spheres(volume, angle);
    [
        contact,
        above / end,
        at * below * above / end,
        at * below / (end * end),
        0.0,
    ]
}

/// Lian & Seville (2016), *Adv. Colloid Interface Sci.* 227, 53.
///
/// `number` stands for the volume in the fit, and `end` is the gap at which the bridge breaks, in the same unit as gaps. MercuryDPM
/// takes both as numbers in SI units, which the fit does not mean.
#[must_use]
pub fn lian_seville(number: f64, angle: f64, end: f64) -> Curve {
    let v = number.min(LARGEST);
    // Half-filling angle.
    let alpha = pow(v, 0.26) + (0.285 - 0.4594 * angle) * pow(v, 0.6327 + 0.897 * angle);
    let contact = (2.0 * PI - 2.082 * pow(alpha, 0.9197))
        * (cos(angle) - 0.16 * alpha * (1.0 + alpha) * tan(angle));
    let stretch = (1.0 + 0.5 * angle * cos(angle) * cos(alpha + angle)) / end;
    [
        contact,
        0.0,
        0.8438 * pow(alpha, -0.724) * stretch,
        1.3393 * pow(alpha, -1.459) * stretch * stretch,
        0.0,
    ]
}

/// Willett, Adams, Johnson & Seville (2000), *Langmuir* 16, 9396: their short approximation, with the force of an infinitely small
/// bridge at the touch.
#[must_use]
pub fn willett(volume: f64, angle: f64) -> Curve {
    let scale = 1.0 / sqrt(volume);
    [
        2.0 * PI * cos(angle),
        0.0,
        1.05 * scale,
        2.5 * scale * scale,
        0.0,
    ]
}

/// Full fit of the same authors (their appendix).
#[must_use]
pub fn willett_classical(volume: f64, angle: f64) -> Curve {
    let (l, t) = (log(within_fit(volume)), angle);
    let sum = |rows: &[[f64; 3]]| {
        let of_row = |row: &[f64; 3]| row[0] + row[1] * t + row[2] * t * t;
        rows.iter()
            .rev()
            .fold(0.0, |sum, row| sum * l + of_row(row))
    };
    let f1 = sum(&[
        [-0.44507, 0.050832, -1.1466],
        [-0.1119, -0.000411, -0.1490],
        [-0.012101, -0.0036456, -0.01255],
        [-0.0005, -0.0003505, -0.00029076],
    ]);
    let f2 = sum(&[
        [1.9222, -0.57473, -1.2918],
        [-0.0668, -0.1201, -0.22574],
        [-0.0013375, -0.0068988, -0.01137],
    ]);
    let f3 = sum(&[
        [1.268, -0.01396, -0.23566],
        [0.198, 0.092, -0.06418],
        [0.02232, 0.02238, -0.009853],
        [0.0008585, 0.001318, -0.00053],
    ]);
    let f4 = sum(&[
        [-0.010703, 0.073776, -0.34742],
        [0.03345, 0.04543, -0.09056],
        [0.0018574, 0.004456, -0.006257],
    ]);
    [2.0 * PI * exp(f1), f2, f3, f4, 0.5 / sqrt(volume)]
}

/// End of the stable branch between equal spheres, over R_D: (1 + θ/2)(V*^(1/3) + 0.1 V*^(2/3)) (Willett et al. 2000).
#[must_use]
pub fn end_of_equal_spheres(volume: f64, angle: f64) -> f64 {
    let root = cbrt(volume);
    (1.0 + 0.5 * angle) * (root + 0.1 * root * root)
}

/// End for spheres whose radii have the ratio `ratio` (smaller over larger, 0 at a wall): shorter by up to 30 %. Our fit to 209
/// exact ends (V* 1e-4 to 0.1, θ 0 to 50 degrees, all ratios), −5.7 to +4.5 %.
#[must_use]
pub fn end_of_unequal_spheres(volume: f64, angle: f64, ratio: f64) -> f64 {
    let shorter = (1.0 - ratio) * (0.32 + 0.27 * angle) * pow(volume, 0.2);
    end_of_equal_spheres(volume, angle) * (1.0 - shorter)
}
