//! Validity of a candidate list over time.

use std::ops::Range;

use rayon::prelude::*;

use crate::parallel::RUN;
use crate::state::Particles;

/// Upper bound of the share of its skin that a particle has used up since the list was built: of half the thickness and the own
/// extra skin.
///
/// The bound grows by the largest speed over half the skin times the step, which costs nothing. When it reaches 1, the used
/// shares are measured once and the bound continues from there, so that particles which rattle about do not force rebuilds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Validity {
    bound: f64,
    /// Steps since the list was built.
    pub steps: u64,
}

impl Validity {
    /// A step was made in which no particle used up more than `part` of its skin. Returns whether every particle is surely within its
    /// skin of where it was listed; otherwise `measure` is called, which returns [`used`] of all particles.
    pub fn advance(&mut self, part: f64, measure: impl FnOnce() -> (f64, bool)) -> bool {
        self.steps += 1;
        // Round-off of the positions is far below this factor's margin.
        self.bound += part * (1.0 + 1e-9);
        if self.bound <= 1.0 {
            return true;
        }
        let lasts;
        (self.bound, lasts) = measure();
        // Close to the limit a true measurement would be due in every step: rebuild instead.
        lasts
    }
}

/// The largest share that one of some rows has used up of its skin, which is `limit` (m) and its `extra_skin` (m; empty for none); and
/// whether all last for two more steps of `dt` (s). `parallel`: with the threads of the pool from within which it is called.
#[must_use]
pub fn used(
    particles: &Particles,
    rows: Range<usize>,
    (limit, extra_skin): (f64, &[f64]),
    dt: f64,
    parallel: bool,
) -> (f64, bool) {
    largest(rows, parallel, |row| {
        let own = limit + extra_skin.get(row).copied().unwrap_or_default();
        let way = displacement(particles, row);
        let next = particles.records[row].velocity.length() * dt;
        (way / own, way + 2.0 * next <= 0.97 * own)
    })
}

/// The largest of the numbers of all rows, and whether all conditions hold.
fn largest(
    rows: Range<usize>,
    parallel: bool,
    of_row: impl Fn(usize) -> (f64, bool) + Sync + Send,
) -> (f64, bool) {
    let none = (0.0, true);
    let both = |a: (f64, bool), b: (f64, bool)| (a.0.max(b.0), a.1 & b.1);
    if parallel {
        let rows = rows.into_par_iter().with_min_len(RUN);
        rows.map(of_row).reduce(|| none, both)
    } else {
        rows.map(of_row).fold(none, both)
    }
}

/// How far a particle is from where it was listed, m.
pub(super) fn displacement(particles: &Particles, row: usize) -> f64 {
    let listed = particles.listed_at[row];
    particles.records[row].position.distance(listed)
}

crate::state::plain!(Validity { bound, steps });

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use proptest::prelude::*;

    use super::*;
    use crate::state::{MaterialIndex, Particle};

    proptest! {
        /// Particles set out at any speed, with more skin than most or less, along a line, so that the way is the displacement:
        /// as long as the list counts as valid, no particle is beyond its own limit; it is valid for most of that time if the
        /// speeds do not change.
        #[test]
        fn no_particle_goes_beyond_its_own_skin(
            ones in prop::collection::vec((0.0..1.0f64, -0.9..5.0f64), 1..20),
            (with_extra, changes, parallel) in any::<(bool, bool, bool)>(),
            start in 0u32..200,
        ) {
            let (limit, dt) = (1e-3, 1e-5);
            let extra: Vec<f64> = ones.iter().map(|one| one.1 * limit).collect();
            let extra = if with_extra { &extra[..] } else { &[] };
            let mut particles = Particles::new(false);
            for _ in &ones {
                let record = Particle {
                    position: DVec3::ZERO,
                    radius: 1.0,
                    velocity: DVec3::ZERO,
                    inverse_mass: 1.0,
                    angular_velocity: DVec3::ZERO,
                    material: MaterialIndex::new(0),
                    flags: 0,
                };
                particles.push(record, 1.0, None);
            }
            let mut validity = Validity::default();
            let own = |row: usize| limit + extra.get(row).copied().unwrap_or_default();
            for step in 0..100_000 {
                let mut part = 0.0f64;
                for (row, (record, &(speed, _))) in particles.records.iter_mut().zip(&ones).enumerate() {
                    let speed = if changes && step < start { 0.1 * speed } else { speed };
                    record.velocity = DVec3::Y * speed;
                    record.position += record.velocity * dt;
                    // Some have less than they could have, as few of a level do.
                    let said = if row % 3 == 0 { own(row).min(limit) } else { own(row) };
                    part = part.max(speed * dt / said);
                }
                let valid = validity.advance(part, || {
                    used(&particles, 0..ones.len(), (limit, extra), dt, parallel)
                });
                let used = (0..ones.len()).map(|row| displacement(&particles, row) / own(row));
                let used = used.fold(0.0, f64::max);
                if !valid {
                    // At least as far as the margin, and the two steps of the particle that is nearest to its limit.
                    let steps = (0..ones.len()).map(|row| 2.0 * ones[row].0 * dt / own(row));
                    let steps = steps.fold(0.0, f64::max);
                    prop_assert!(used + steps > 0.97 - 1e-9, "given up at {used} of the skin");
                    return Ok(());
                }
                prop_assert!(used <= 1.0 + 1e-9, "a particle has gone {used} of the own skin");
            }
        }
    }
}
