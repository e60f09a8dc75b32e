//! Every pebble for itself, in closed form: exact where pebbles do not overlap, else overlaps count several times.

use std::f64::consts::PI;

use glam::DVec3;
use mercury_common::formats::clump::Pebble;

use super::{DMat3Sum, MassProperties, RawMoments, pairwise_sum};

/// Volume, centre and second moments of the pebbles, each counted fully; `None` without pebbles.
///
/// A ball of volume V and radius r at d from the centre has the second moment `V (r²/5 E + d dᵀ)`, and so the
/// inertia `V (2/5 r² E + d² E - d dᵀ)`.
///
/// ```
/// use glam::DVec3;
/// use mclump::inertia::pebbles;
/// use mercury_common::formats::clump::Pebble;
///
/// let rod = [-1.0, 0.0, 1.0].map(|x| Pebble { position: DVec3::new(x, 0.0, 0.0), radius: 0.5 });
/// let moments = pebbles::integrate(&rod).map(|rod| rod.principal_moments());
/// // (pi/6) diag(0.3, 2.3, 2.3)
/// let expected = std::f64::consts::PI / 6.0 * DVec3::new(0.3, 2.3, 2.3);
/// assert!(moments.is_some_and(|moments| moments.abs_diff_eq(expected, 1e-14)));
/// ```
#[must_use]
pub fn integrate(pebbles: &[Pebble]) -> Option<MassProperties> {
    let origin = middle(pebbles)?;
    let parts: Vec<RawMoments> = pebbles.iter().map(|p| ball(p, origin)).collect();
    Some(pairwise_sum(&parts).central(origin))
}

/// The third central moments along a direction, summed over pebbles, in m6: `sum V (s³ + 3/5 s r²)` with s the distance
/// of a pebble's centre from `centre` along the unit vector `direction`.
#[must_use]
pub fn third_moment(pebbles: &[Pebble], centre: DVec3, direction: DVec3) -> f64 {
    pebbles
        .iter()
        .map(|pebble| {
            let s = (pebble.position - centre).dot(direction);
            volume(pebble.radius) * s * (s * s + 0.6 * pebble.radius * pebble.radius)
        })
        .sum()
}

/// Volume of a ball.
pub(crate) fn volume(radius: f64) -> f64 {
    4.0 / 3.0 * PI * radius.powi(3)
}

/// Centre of the axis-parallel box around the pebbles: an origin near the body, so that a body far away keeps its digits.
pub(crate) fn middle(pebbles: &[Pebble]) -> Option<DVec3> {
    let (low, high) = bounds(pebbles)?;
    Some(low + 0.5 * (high - low))
}

/// The axis-parallel box around the pebbles.
pub(crate) fn bounds(pebbles: &[Pebble]) -> Option<(DVec3, DVec3)> {
    let first = pebbles.first()?;
    let low = |p: &Pebble| p.position - DVec3::splat(p.radius);
    let high = |p: &Pebble| p.position + DVec3::splat(p.radius);
    Some(pebbles.iter().fold((low(first), high(first)), |(a, b), p| {
        (a.min(low(p)), b.max(high(p)))
    }))
}

fn ball(pebble: &Pebble, origin: DVec3) -> RawMoments {
    let v = volume(pebble.radius);
    let d = pebble.position - origin;
    RawMoments {
        volume: v,
        first: v * d,
        second: DMat3Sum {
            diagonal: v * (d * d + DVec3::splat(pebble.radius * pebble.radius / 5.0)),
            mixed: v * DVec3::new(d.x * d.y, d.x * d.z, d.y * d.z),
        },
    }
}
