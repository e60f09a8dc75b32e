//! The mass at the contact point of clumps, for scenes that damp by it.

use glam::DVec3;

use crate::state::{Bodies, Particle};

/// The velocity along `normal` that a unit impulse along it at the contact point gives that point, 1/kg:
/// 1/M + (r x n).I^-1 (r x n), the inverse of the effective mass of impact dynamics (Stronge 2000, section 3.1). The arm from
/// the pebble's centre to the contact point is along n and does not count. A sphere's is 1/m.
#[inline(never)]
pub(super) fn mobility(bodies: &Bodies, row: usize, record: &Particle, normal: DVec3) -> f64 {
    let Some(pebble) = bodies.of_row[row].filter(|_| record.inverse_mass != 0.0) else {
        return record.inverse_mass;
    };
    let pebble = &bodies.pebbles[pebble.index()];
    let body = &bodies.all[pebble.body.index()];
    let along = body.orientation.inverse() * normal;
    let arm = pebble.offset.cross(along);
    record.inverse_mass + arm.dot(arm / body.moments)
}
