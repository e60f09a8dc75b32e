//! Hertz' law of a pair.

use mercury_common::scene::{HertzDamping, HertzModulus, Material, NormalLaw, NormalOverride};

use super::{Normal, Pair, check_restitution, restitution};
use crate::contact::normal::{damping_ratio_clamped, effective_modulus, hertz_damping};
use crate::contact::{AnyNormal, Hertz};

/// sqrt(5): beta over the fraction of critical damping (Antypov & Elliott 2011).
const BETA_PER_ZETA: f64 = 2.236_067_977_499_79;

/// Elastic constants (E, nu) of a material, if it gives them.
pub(in crate::plan) fn youngs(material: &Material) -> Option<(f64, f64)> {
    match &material.normal.value {
        NormalLaw::Hertz {
            modulus:
                HertzModulus::Youngs {
                    youngs_modulus,
                    poisson_ratio,
                },
            ..
        } => Some((**youngs_modulus, **poisson_ratio)),
        _ => None,
    }
}

pub(super) fn resolve(pair: &mut Pair<'_>, replaced: Option<&NormalOverride>) -> Option<Normal> {
    let number = |read: fn(&NormalOverride) -> Option<f64>| replaced.and_then(read);
    let modulus = number(|n| n.effective_modulus.as_deref().copied());
    let (over_e, over_nu) = (
        number(|n| n.youngs_modulus.as_deref().copied()),
        number(|n| n.poisson_ratio.as_deref().copied()),
    );
    let constants = pair.sides.map(youngs);
    let like_like = pair.sides.map(|side| match &side.normal.value {
        NormalLaw::Hertz {
            modulus: HertzModulus::Effective { effective_modulus },
            ..
        } => Some(**effective_modulus),
        _ => youngs(side).map(|one| effective_modulus(one, one)),
    });
    let exact = match elastic_pair(constants, over_e, over_nu) {
        Some([a, b]) => Some(effective_modulus(a, b)),
        None if over_e.is_some() || over_nu.is_some() => {
            let message = format!(
                "E* of the contacts of {} is incomplete: youngs_modulus and poisson_ratio go together",
                pair.name()
            );
            pair.error(message, "give both, or effective_modulus".to_owned());
            return None;
        }
        None => None,
    };
    let (modulus, origin) = match (modulus, exact) {
        (None, Some(exact)) if over_e.is_some() || over_nu.is_some() => {
            (exact, pair.contact_origin())
        }
        (None, Some(exact)) => (exact, pair.mixed_origin(constants.map(|c| c.is_some()))),
        (modulus, _) => pair.need("normal.effective_modulus", modulus, like_like)?,
    };

    let given_restitution = number(|n| n.restitution.as_deref().copied());
    let given_beta = number(|n| n.damping.as_deref().copied());
    let mut restitutions = Vec::from_iter(given_restitution);
    let sides = pair.sides.map(|side| match &side.normal.value {
        NormalLaw::Hertz { damping, .. } => Some(match damping {
            HertzDamping::Restitution(e) => {
                restitutions.push(**e);
                beta_of(pair, **e)
            }
            HertzDamping::Damping(beta) => **beta,
        }),
        _ => None,
    });
    for value in restitutions {
        check_restitution(pair, value)?;
    }
    let replaced_beta = given_restitution.map(|e| beta_of(pair, e)).or(given_beta);
    let (beta, beta_origin) = pair.need("normal.restitution", replaced_beta, sides)?;

    pair.record("normal.effective_modulus", "Pa", modulus, origin);
    pair.record(
        "normal.restitution",
        "",
        restitution(pair, beta / BETA_PER_ZETA),
        beta_origin.clone(),
    );
    pair.record("normal.damping", "", beta, beta_origin);
    let mut law = Hertz::new(modulus, beta);
    law.clamp_tension = pair.conventions.clamp_tension;
    Some(Normal {
        law: AnyNormal::Hertz(law),
        beta: Some(beta),
        stiffness: None,
    })
}

/// beta of a restitution under the convention of the scene.
fn beta_of(pair: &Pair<'_>, restitution: f64) -> f64 {
    if pair.conventions.clamp_tension {
        BETA_PER_ZETA * damping_ratio_clamped(restitution)
    } else {
        hertz_damping(restitution)
    }
}

/// (E, nu) of both bodies: what is replaced counts for both; a body without constants is like the other one.
pub(in crate::plan::mixing) fn elastic_pair(
    sides: [Option<(f64, f64)>; 2],
    over_e: Option<f64>,
    over_nu: Option<f64>,
) -> Option<[(f64, f64); 2]> {
    let side = |own: Option<(f64, f64)>| {
        let e = over_e.or(own.map(|c| c.0))?;
        Some((e, over_nu.or(own.map(|c| c.1))?))
    };
    match sides.map(side) {
        [Some(a), Some(b)] => Some([a, b]),
        _ => None,
    }
}
