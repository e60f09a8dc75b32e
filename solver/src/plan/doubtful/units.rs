//! Sizes, densities and domains that look as if a unit was forgotten.

use mercury_common::plausible;

use super::Finding;
use crate::plan::Plan;

/// A note on sizes, densities and a domain that look as if a unit was forgotten.
pub(super) fn forgotten_units(plan: &Plan) -> Vec<Finding> {
    let physics = plan.physics();
    let [_, _, largest] = physics.radii();
    let size = physics.cell.size();
    let densities = physics.materials.iter().map(|material| material.density);
    let found =
        plausible::forgotten_units(Some(2.0 * largest), densities, Some(size.max_element()));
    found.into_iter().map(Finding::Remark).collect()
}
