//! How long a candidate list stays valid.

use crate::state::Particles;

/// Upper bound of the largest displacement since the list was built, less the extra skin of who made it.
///
/// The bound grows by the largest speed times the step, which costs nothing. When it reaches its limit, the true largest
/// displacement is taken once and the bound goes on from there, so that particles which rattle about do not force rebuilds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Validity {
    bound: f64,
    /// Steps since the list was built.
    pub steps: u64,
}

impl Validity {
    /// The list is new.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// A step of `dt` (s) was made in which no particle was faster than `speed` (m/s). Returns whether every particle is
    /// surely within `limit` (m), and its `extra_skin` (m; empty for none), of where it was listed.
    pub fn advance(
        &mut self,
        speed: f64,
        dt: f64,
        limit: f64,
        particles: &Particles,
        extra_skin: &[f64],
    ) -> bool {
        self.steps += 1;
        // Round-off of the positions is far below this factor's margin.
        self.bound += speed * dt * (1.0 + 1e-9);
        if self.bound <= limit {
            return true;
        }
        self.bound = (0..particles.len())
            .map(|row| {
                displacement(particles, row) - extra_skin.get(row).copied().unwrap_or_default()
            })
            .fold(0.0, f64::max);
        // Close to the limit a true measurement would be due in every step: rebuild instead.
        self.bound + 2.0 * speed * dt <= 0.97 * limit
    }
}

/// How far a particle is from where it was listed, m.
pub(super) fn displacement(particles: &Particles, row: usize) -> f64 {
    let listed = particles.listed_at[row];
    particles.records[row].position.distance(listed)
}

crate::state::plain!(Validity { bound, steps });
