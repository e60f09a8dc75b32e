//! Liquid bridges beyond the solutions that their law was fitted to.

use super::Finding;
use crate::plan::{PairPlan, Plan};
use mercury_engine::contact::adhesion::liquid::{Fit, reduced_diameter};
use mercury_engine::contact::parameter::short;

/// A warning for each pair of materials.
pub(super) fn bridges_beyond_the_fit(plan: &Plan) -> Vec<Finding> {
    let pairs = plan.notes().pairs().iter();
    let found = pairs.filter_map(|pair| beyond_the_fit(plan, pair));
    found.map(Finding::Warning).collect()
}

/// Largest volume over R_D^3, and largest contact angle (rad), of the solutions that the laws of liquid bridges were fitted to.
const FITTED: (f64, f64) = (0.1, 50.0 * std::f64::consts::PI / 180.0);

/// A liquid bridge may be larger than those that its law was fitted to, or meet its particles at a wider angle.
fn beyond_the_fit(plan: &Plan, pair: &PairPlan) -> Option<String> {
    let liquid = (pair.law.adhesion.liquid()).filter(|liquid| liquid.fit != Fit::YoungLaplace)?;
    let diameter = reduced_diameter([plan.physics().smallest_radius(); 2]);
    let volume = liquid.max_volume / (diameter * diameter * diameter);
    let names = pair.names.each_ref().map(String::as_str).join(" and ");
    let law = liquid.fit.name();
    if volume > FITTED.0 {
        Some(format!(
            "{names}: a bridge of max_bridge_volume between the smallest particles has V/R_D^3 = {}; `{law}` was fitted up to {}, and its force is uncertain beyond; give a smaller max_bridge_volume, or the law `young-laplace`, which goes to 0.5",
            short(volume),
            FITTED.0
        ))
    } else if liquid.contact_angle > FITTED.1 {
        Some(format!(
            "{names}: a contact angle of {} degrees; `{law}` was fitted up to 50, and its force is uncertain beyond; is the angle right? `young-laplace` has angles up to 90",
            short(liquid.contact_angle.to_degrees())
        ))
    } else {
        None
    }
}
