//! The normal law of a pair.

mod hertz;
mod linear;
mod plastic;

use std::f64::consts::PI;

use mercury_common::scene::{Material, NormalLaw, NormalLawName};

pub(super) use hertz::elastic_pair;
pub(in crate::plan) use hertz::youngs;

use super::{Origin, Pair, harmonic_mean};
use crate::contact::AnyNormal;
use crate::contact::normal::{damping_ratio, damping_ratio_clamped};

/// The normal law and what the other laws of the pair derive from it.
pub(super) struct Normal {
    pub(super) law: AnyNormal,
    /// beta, for Hertz.
    pub(super) beta: Option<f64>,
    /// The constant stiffness that `stiffness_ratio` refers to, N/m: k, or k1 of the plastic law.
    pub(super) stiffness: Option<f64>,
}

pub(super) fn resolve(pair: &mut Pair<'_>) -> Option<Normal> {
    let replaced = pair
        .contact
        .and_then(|(_, contact)| contact.normal.as_ref());
    let [a, b] = pair.sides.map(|side| side.normal.name());
    let (law, origin) = match replaced.and_then(|normal| normal.law.as_ref()) {
        Some(law) => (law.value, pair.contact_origin()),
        None if a == b => (a, pair.mixed_origin([true; 2])),
        None => {
            let message = format!(
                "the contacts of {} have no normal law: `{}` is {}, `{}` is {}",
                pair.name(),
                pair.sides[0].name.value,
                word(a),
                pair.sides[1].name.value,
                word(b),
            );
            let help = format!("name it: {}", pair.entry("normal = { law = \"...\", ... }"));
            pair.error(message, help);
            return None;
        }
    };
    pair.record_word("normal.law", word(law), origin);
    match law {
        NormalLawName::Hertz => hertz::resolve(pair, replaced),
        NormalLawName::Linear => linear::resolve(pair, replaced),
        NormalLawName::Plastic => plastic::resolve(pair, replaced),
    }
}

pub(super) fn word(law: NormalLawName) -> &'static str {
    match law {
        NormalLawName::Hertz => "hertz",
        NormalLawName::Linear => "linear",
        NormalLawName::Plastic => "plastic",
    }
}

/// The fraction of critical damping that gives a restitution under the convention of the scene.
fn zeta(pair: &Pair<'_>, restitution: f64) -> f64 {
    if pair.conventions.clamp_tension {
        damping_ratio_clamped(restitution)
    } else {
        damping_ratio(restitution)
    }
}

/// The restitution that a fraction of critical damping gives: the inverse of [`zeta`] in closed form.
fn restitution(pair: &Pair<'_>, zeta: f64) -> f64 {
    if zeta == 0.0 {
        return 1.0;
    }
    let squared = 1.0 - zeta * zeta;
    match pair.conventions.clamp_tension {
        false if squared <= 0.0 => 0.0,
        false => (-PI * zeta / squared.sqrt()).exp(),
        true if squared.abs() < 1e-12 => (-2.0f64).exp(),
        true if squared > 0.0 => {
            let s = squared.sqrt();
            (-zeta / s * (PI - (2.0 * zeta * s).atan2(1.0 - 2.0 * zeta * zeta))).exp()
        }
        true => {
            let s = (-squared).sqrt();
            (-zeta / s * ((zeta + s) / (zeta - s)).ln()).exp()
        }
    }
}

/// Complains about a restitution of 0 where tension is cut: no dashpot can give it.
fn check_restitution(pair: &mut Pair<'_>, value: f64) -> Option<()> {
    if value == 0.0 && pair.conventions.clamp_tension {
        pair.error(
            "restitution = 0 needs infinite damping where tension is cut (contact.clamp_tension)"
                .to_owned(),
            "give a restitution above 0, or clamp_tension = false".to_owned(),
        );
        return None;
    }
    Some(())
}

/// The stiffness of a material with itself, N/m: k, or k1 of the plastic law; `None` for Hertz.
pub(super) fn own_stiffness(pair: &Pair<'_>, material: &Material) -> Option<f64> {
    match &material.normal.value {
        NormalLaw::Plastic {
            loading_stiffness, ..
        } => Some(**loading_stiffness),
        _ => linear::side(pair, material).map(|side| side.stiffness),
    }
}
