//! Amounts that an insertion is expected to bring.

use glam::{DVec2, DVec3};
use mercury_common::scene::{Quantity, Total};

use crate::plan::Plan;
use mercury_engine::boundaries::{InsertionPlan, expected_number, volume_within};
use mercury_engine::physics::Physics;

/// Solid fraction, in three and two dimensions, of spheres and discs that are placed at random until no more fit (Torquato 2002, Random
/// Heterogeneous Materials, table 3.1), and of those that are packed at random.
const PLACED: [f64; 2] = [0.38, 0.55];
const PACKED: [f64; 2] = [0.64, 0.84];

/// The particles that an insertion brings at most: limited by its total, its rate and the space.
#[must_use]
pub(crate) fn expected_inserted(insertion: &InsertionPlan, plan: &Plan) -> f64 {
    let densities: Vec<f64> = plan.physics().materials.iter().map(|m| m.density).collect();
    let of_total = |total| {
        let only = InsertionPlan {
            total: Some(total),
            ..insertion.clone()
        };
        expected_number(&only, &densities, plan.physics().dimensions).unwrap_or(f64::INFINITY)
    };
    let [placed, packed] =
        [PLACED, PACKED].map(|part| part[usize::from(plan.physics().dimensions == 2)]);
    let (min, max) = plan.physics().cell.corners();
    let space = |low: DVec3, high: DVec3| match plan.physics().dimensions {
        2 => (high - low).truncate().max(DVec2::ZERO).element_product(),
        _ => (high - low).max(DVec3::ZERO).element_product(),
    };
    let by_total = match insertion.total {
        Some(Total::Full) => {
            let (low, high) = insertion.region.bounds();
            let space = match plan.physics().dimensions {
                2 => space(low.max(min), high.min(max)),
                _ => volume_within(&insertion.region, min, max),
            };
            of_total(Total::Volume(placed * space))
        }
        Some(total) => of_total(total),
        None => f64::INFINITY,
    };
    let end = insertion
        .until
        .min(plan.physics().steps as f64 * plan.physics().time_step);
    let by_rate = match &insertion.rate {
        _ if end < insertion.from => 0.0,
        None => f64::INFINITY,
        Some(rate) => match rate.allowed(insertion.from, end) {
            // The last one may exceed what is allowed.
            (Quantity::Number, number) => number.ceil(),
            (Quantity::Mass, mass) => of_total(Total::Mass(mass)) + 1.0,
            (Quantity::Volume, volume) => of_total(Total::Volume(volume)) + 1.0,
        },
    };
    let by_space = of_total(Total::Volume(packed * space(min, max)));
    by_total.min(by_rate).min(by_space)
}

/// Grains per unit of a quantity of an insertion: per kg, per m^3, or 1.
pub(crate) fn grains_per_unit(
    insertion: &InsertionPlan,
    quantity: Quantity,
    physics: &Physics,
) -> f64 {
    let materials = physics.materials.iter();
    let densities: Vec<f64> = materials.map(|material| material.density).collect();
    let unit = InsertionPlan {
        total: Some(match quantity {
            Quantity::Number => return 1.0,
            Quantity::Mass => Total::Mass(1.0),
            Quantity::Volume => Total::Volume(1.0),
        }),
        ..insertion.clone()
    };
    expected_number(&unit, &densities, physics.dimensions).unwrap_or(0.0)
}
