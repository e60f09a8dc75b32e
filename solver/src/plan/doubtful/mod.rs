//! Set-ups that can run but are hardly intended: each check looks at the whole plan and reports its findings, with the cause and
//! advice.
//!
//! A check is a function of the plan in a file of its own and a line of [`CHECKS`].

mod closing;
mod disk;
mod fit;
mod gravity;
mod rolling;
mod servo;
mod units;

use super::Plan;
use crate::wear::plan::doubts::wear_without_effect_or_too_fast;

/// Finding of a check.
pub(crate) enum Finding {
    /// A likely mistake: shown before the run and in its report.
    Warning(String),
    /// Shown before the run alone.
    Remark(String),
}

/// All checks, in the order of their messages.
const CHECKS: [fn(&Plan) -> Vec<Finding>; 9] = [
    disk::much_output,
    gravity::particles_that_fall_out,
    wear_without_effect_or_too_fast,
    gravity::insertions_at_rest,
    servo::servos_that_lift_off,
    fit::bridges_beyond_the_fit,
    closing::walls_that_close_over_insertions,
    units::forgotten_units,
    rolling::rolling_without_end,
];

/// Everything that is doubtful about a plan.
pub(super) fn doubts(plan: &Plan) -> impl Iterator<Item = Finding> {
    CHECKS.into_iter().flat_map(|check| check(plan))
}
