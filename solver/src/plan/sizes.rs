//! The sizes of spheres that can occur, and the levels of the neighbour search that follow from them.

use glam::DVec3;

use super::Plan;
use super::insertions::{expected_inserted, expected_number};
use crate::bodies::{Clump, NewBody};
use crate::boundaries::{Ingredient, InsertionPlan};
use crate::neighbours::{Levels, Skin};
use crate::state::NewParticle;

/// What an insertion that fills its region counts in the mean radius: it is large beside single particles.
const FULL_COUNTS_AS: f64 = 1e4;

/// Radii that can occur, m.
pub(super) struct Sizes {
    pub(super) smallest: f64,
    pub(super) mean: f64,
    pub(super) largest: f64,
    /// Circumscribed, of bodies; 0 without any.
    pub(super) largest_body: f64,
}

impl Sizes {
    pub(super) fn of(
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
fn radii<'a>(
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

/// The number of points at which a size distribution is sampled.
const QUANTILES: u32 = 64;

/// The levels that the neighbour search would choose for all that is planned, by the skin of the first list.
#[must_use]
pub(super) fn levels(plan: &Plan) -> Levels {
    let physics = plan.physics();
    let images = physics.images();
    let skin = Skin::first(physics.radii(), 0.0, &images).thickness;
    let inserted = inserted_sizes(plan);
    let start = radii(&physics.particles, &physics.bodies, &physics.clumps);
    let sizes = start
        .map(|radius| (radius, 1.0))
        .chain(inserted.iter().copied());
    Levels::for_sizes(sizes, || extent(plan), skin)
}

/// How far the centres of spheres are spread along each axis, m.
fn extent(plan: &Plan) -> DVec3 {
    if !plan.physics().insertions().is_empty() {
        return plan.physics().domain_max() - plan.physics().domain_min();
    }
    let particles = plan
        .physics()
        .particles()
        .iter()
        .map(|particle| particle.position);
    let pebbles = plan.physics().bodies().iter().flat_map(|body| {
        let spheres = body.spheres(body.clump(plan.physics().clumps()));
        spheres.map(|(centre, _)| centre)
    });
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for centre in particles.chain(pebbles) {
        low = low.min(centre);
        high = high.max(centre);
    }
    high - low
}

/// Radii (m) of the spheres that insertions are expected to bring, and how many of each.
fn inserted_sizes(plan: &Plan) -> Vec<(f64, f64)> {
    let mut sizes = Vec::new();
    for insertion in plan.physics().insertions() {
        let number = expected_inserted(insertion, plan);
        for part in insertion.mixture.iter().filter(|part| part.share > 0.0) {
            for (diameter, share) in diameters(part) {
                let number = number * part.share * share;
                match part.clump {
                    None => sizes.push((0.5 * diameter, number)),
                    Some(index) => {
                        let clump = &plan.physics().clumps()[index as usize];
                        let scale = diameter / clump.equal_volume_diameter();
                        let pebbles = clump.pebbles.iter();
                        sizes.extend(pebbles.map(|pebble| (pebble.radius * scale, number)));
                    }
                }
            }
        }
    }
    sizes
}

/// Diameters (m) that stand for a distribution, and the share by number of each.
fn diameters(part: &Ingredient) -> impl Iterator<Item = (f64, f64)> {
    let share = 1.0 / f64::from(QUANTILES);
    (0..QUANTILES).map(move |k| {
        let diameter = match k + 1 {
            QUANTILES => part.sizes.largest(),
            _ => part.sizes.sample_diameter((f64::from(k) + 0.5) * share),
        };
        (diameter, share)
    })
}
