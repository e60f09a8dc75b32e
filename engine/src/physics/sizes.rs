//! The sizes of spheres that can occur.

use crate::bodies::{Clump, NewBody};
use crate::boundaries::{InsertionPlan, expected_number};
use crate::state::NewParticle;

/// Weight in the mean radius of an insertion that fills its region: it is large beside single particles.
const FULL_COUNTS_AS: f64 = 1e4;

/// Radii that can occur, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sizes {
    /// The smallest; 0 if there is none.
    pub smallest: f64,
    /// The mean that is expected; 0 if there is none.
    pub mean: f64,
    /// The largest; 0 if there is none.
    pub largest: f64,
    /// Circumscribed, of bodies; 0 without any.
    pub largest_body: f64,
}

impl Sizes {
    /// Sizes of all particles, of the start and of insertions; `densities` of all materials, kg/m^3.
    #[must_use]
    pub fn of(
        densities: &[f64],
        (particles, bodies): (&[NewParticle], &[NewBody]),
        clumps: &[Clump],
        insertions: &[InsertionPlan],
        dimensions: u8,
    ) -> Self {
        let (mut smallest, mut largest, mut sum, mut count) = (f64::INFINITY, 0.0f64, 0.0, 0.0);
        let mut largest_body = 0.0f64;
        for radius in radii(particles, bodies, clumps) {
            smallest = smallest.min(radius);
            largest = largest.max(radius);
            sum += radius;
            count += 1.0;
        }
        for body in bodies {
            largest_body = largest_body.max(clumps[body.clump as usize].radius * body.scale);
        }
        for insertion in insertions {
            let expected = expected_number(insertion, densities, dimensions);
            let expected = expected.unwrap_or(FULL_COUNTS_AS);
            for part in &insertion.mixture {
                // Radii over half the diameter that is drawn, and spheres for each.
                let (least, mean, most, number) = match part.clump {
                    None => (1.0, 1.0, 1.0, 1.0),
                    Some(index) => {
                        let clump = &clumps[index as usize];
                        let unit = 2.0 / clump.equal_volume_diameter();
                        let body = 0.5 * part.sizes.largest() * clump.radius * unit;
                        largest_body = largest_body.max(body);
                        let (least, most) = clump.pebble_radii();
                        (
                            least * unit,
                            clump.mean_pebble_radius() * unit,
                            most * unit,
                            clump.pebbles.len() as f64,
                        )
                    }
                };
                smallest = smallest.min(0.5 * part.sizes.smallest() * least);
                largest = largest.max(0.5 * part.sizes.largest() * most);
                let spheres = expected * part.share * number;
                sum += spheres * 0.5 * part.sizes.mean_diameter() * mean;
                count += spheres;
            }
        }
        if count == 0.0 {
            return Self {
                smallest: 0.0,
                mean: 0.0,
                largest: 0.0,
                largest_body,
            };
        }
        Self {
            smallest,
            mean: sum / count,
            largest,
            largest_body,
        }
    }
}

/// Radii of particles, then of the pebbles of bodies, m.
pub fn radii<'a>(
    particles: &'a [NewParticle],
    bodies: &'a [NewBody],
    clumps: &'a [Clump],
) -> impl Iterator<Item = f64> + Clone + 'a {
    let pebbles = bodies.iter().flat_map(|body| {
        let pebbles = body.clump(clumps).pebbles.iter();
        pebbles.map(|pebble| pebble.radius * body.scale)
    });
    particles
        .iter()
        .map(|particle| particle.radius)
        .chain(pebbles)
}
