//! Restitution and damping under the conventions of a scene.

use std::f64::consts::PI;

use super::Pair;
use crate::contact::normal::{damping_ratio, damping_ratio_clamped, restitution_clamped};

/// The fraction of critical damping that gives a restitution under the convention of the scene.
#[must_use]
pub fn damping_ratio_of(pair: &Pair<'_>, restitution: f64) -> f64 {
    if pair.conventions.clamp_tension {
        damping_ratio_clamped(restitution)
    } else {
        damping_ratio(restitution)
    }
}

/// The restitution that a fraction of critical damping gives: the inverse of [`damping_ratio_of`] in closed form.
#[must_use]
pub fn restitution_of(pair: &Pair<'_>, zeta: f64) -> f64 {
    if zeta == 0.0 {
        return 1.0;
    }
    let squared = 1.0 - zeta * zeta;
    if pair.conventions.clamp_tension {
        restitution_clamped(zeta)
    } else if squared <= 0.0 {
        0.0
    } else {
        libm::exp(-PI * zeta / squared.sqrt())
    }
}

impl Pair<'_> {
    /// Complains about a restitution of 0 where tension is cut: no dashpot can give it.
    pub fn check_restitutions(&mut self) -> Option<()> {
        let [a, b] = self.sides("restitution");
        let given = [a, b, self.over("restitution")];
        if self.conventions.clamp_tension && given.contains(&Some(0.0)) {
            self.error(
                "restitution = 0 needs infinite damping where tension is cut (contact.clamp_tension)"
                    .to_owned(),
                "give a restitution above 0, or clamp_tension = false".to_owned(),
            );
            return None;
        }
        Some(())
    }
}
