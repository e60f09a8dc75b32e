//! Number of particles in the total of an insertion.

use mercury_common::scene::Total;
use mercury_common::sizes::SizeDistribution;

use super::{Ingredient, InsertionPlan};
use crate::state::volume;

/// Points of the rule by which the mean area of discs is found; the quantile function is monotonic, so the error is at
/// most the range of areas over this number.
const AREA_POINTS: u32 = 4096;

/// Mean volume of the particles (m^3), or mean area of discs (m^2), by number.
#[must_use]
pub fn mean_volume(sizes: &SizeDistribution, dimensions: u8) -> f64 {
    if dimensions != 2 {
        return sizes.mean_volume();
    }
    let area = |i: u32| {
        let u = (f64::from(i) + 0.5) / f64::from(AREA_POINTS);
        volume(0.5 * sizes.sample_diameter(u), 2)
    };
    (0..AREA_POINTS).map(area).sum::<f64>() / f64::from(AREA_POINTS)
}

/// The particles that an insertion is expected to bring, where its total gives them.
#[must_use]
pub fn expected_number(
    insertion: &InsertionPlan,
    densities: &[f64],
    dimensions: u8,
) -> Option<f64> {
    let mean = |weight: &dyn Fn(&Ingredient) -> f64| -> f64 {
        let parts = insertion.mixture.iter();
        parts
            .map(|part| part.share * weight(part) * mean_volume(&part.sizes, dimensions))
            .sum()
    };
    match insertion.total? {
        Total::Number(number) => Some(number as f64),
        Total::Volume(volume) => Some(volume / mean(&|_| 1.0)),
        Total::Mass(mass) => Some(mass / mean(&|part| densities[part.material.index()])),
        Total::Full => None,
    }
}
