//! The mass at the contact point of clumps, for scenes that damp by it.

use glam::DVec3;

use super::Pass;
use crate::contact::{NormalLaw, RollingLaw, TangentialLaw};
use crate::particles::{Bodies, NO_PEBBLE, Particle};

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw> Pass<'_, N, T, R> {
    /// 1/m* of two particles, given with their rows, in contact along `normal`, 1/kg.
    #[inline(never)]
    pub(super) fn inverse_mass_at(
        bodies: &Bodies,
        (a, row_a): (&Particle, usize),
        (b, row_b): (&Particle, usize),
        normal: DVec3,
    ) -> f64 {
        Self::mobility(bodies, a, row_a, normal) + Self::mobility(bodies, b, row_b, normal)
    }

    /// The velocity along `normal` that a unit impulse along it at the contact point gives that point, 1/kg:
    /// 1/M + (r x n).I^-1 (r x n), the inverse of the effective mass of impact dynamics (Stronge 2000, section 3.1). The arm from
    /// the pebble's centre to the contact point is along n and does not count. A sphere's is 1/m.
    pub(super) fn mobility(bodies: &Bodies, record: &Particle, row: usize, normal: DVec3) -> f64 {
        let inverse_mass = record.inverse_mass;
        let place = bodies.of_row[row];
        if place == NO_PEBBLE || inverse_mass == 0.0 {
            return inverse_mass;
        }
        let pebble = &bodies.pebbles[place as usize];
        let body = &bodies.all[pebble.body as usize];
        let along = body.orientation.inverse() * normal;
        let arm = pebble.offset.cross(along);
        inverse_mass + arm.dot(arm / body.moments)
    }
}
