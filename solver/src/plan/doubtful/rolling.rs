//! Resistance to rolling or torsion that never brings grains to rest.

use super::Finding;
use crate::plan::Plan;
use mercury_engine::contact::AnyRolling;
use mercury_engine::contact::rolling::FrictionSpring;

/// A note on each pair whose resistance to rolling or torsion is a spring without a dashpot: nothing ends the swing of its grains.
pub(super) fn rolling_without_end(plan: &Plan) -> Vec<Finding> {
    let pairs = plan.notes().pairs().iter();
    pairs
        .filter_map(|pair| {
            let AnyRolling::Luding(law) = &pair.law.rolling else {
                return None;
            };
            let springs = [("rolling", &law.rolling), ("torsion", &law.torsion)];
            let swings = |spring: &FrictionSpring| spring.friction > 0.0 && spring.dissipation == 0.0;
            let mut names = springs.iter().filter(|(_, spring)| swings(spring)).map(|(name, _)| *name);
            let name = names.next()?;
            Some(Finding::Remark(format!(
                "{}: {name} has no `dissipation`, so that rolling grains oscillate for ever; give {name} = {{ dissipation = ... }} in kg/s to bring them to rest",
                pair.names.each_ref().map(String::as_str).join(" and "),
            )))
        })
        .collect()
}
