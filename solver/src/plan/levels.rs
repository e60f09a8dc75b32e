//! The levels of the neighbour search that follow from the sizes that can occur.

use glam::DVec3;

use super::Plan;
use crate::boundaries::plan::insertions::expected_inserted;
use mercury_engine::boundaries::Ingredient;
use mercury_engine::neighbours::{Levels, Skin};
use mercury_engine::physics::radii;

/// The number of points at which a size distribution is sampled.
const QUANTILES: u32 = 64;

/// The levels that the neighbour search would choose for all that is planned, by the skin of the first list.
#[must_use]
pub(super) fn levels(plan: &Plan) -> Levels {
    let physics = plan.physics();
    let cell = physics.cell;
    let skin = Skin::first(physics.radii(), 0.0, &cell).thickness;
    let inserted = inserted_sizes(plan);
    let start = radii(&physics.particles, &physics.bodies, &physics.clumps);
    let sizes = start
        .map(|radius| (radius, 1.0))
        .chain(inserted.iter().copied());
    Levels::for_sizes(sizes, || extent(plan), skin)
}

/// How far the centres of spheres are spread along each axis, m.
fn extent(plan: &Plan) -> DVec3 {
    if !plan.physics().insertions.is_empty() {
        return plan.physics().cell.size();
    }
    let particles = plan
        .physics()
        .particles
        .iter()
        .map(|particle| particle.position);
    let pebbles = plan.physics().bodies.iter().flat_map(|body| {
        let spheres = body.spheres(body.clump(&plan.physics().clumps));
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
    for insertion in &plan.physics().insertions {
        let number = expected_inserted(insertion, plan);
        for part in insertion.mixture.iter().filter(|part| part.share > 0.0) {
            for (diameter, share) in diameters(part) {
                let number = number * part.share * share;
                match part.clump {
                    None => sizes.push((0.5 * diameter, number)),
                    Some(index) => {
                        let clump = &plan.physics().clumps[index as usize];
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
