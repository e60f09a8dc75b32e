//! The normal law of a pair.

use std::f64::consts::PI;

use mercury_common::scene::{
    HertzDamping, HertzModulus, LinearNormal, Material, NormalLaw, NormalLawName, NormalOverride,
};

use super::{Origin, Pair, harmonic_mean};
use crate::contact::normal::{
    damping_ratio, damping_ratio_clamped, effective_modulus, hertz_damping,
};
use crate::contact::{AnyNormal, Hertz, Linear, Plastic};

/// The normal law and what the other laws of the pair derive from it.
pub(super) struct Normal {
    pub(super) law: AnyNormal,
    /// beta, for Hertz.
    pub(super) beta: Option<f64>,
    /// The constant stiffness that `stiffness_ratio` refers to, N/m: k, or k1 of the plastic law.
    pub(super) stiffness: Option<f64>,
}

/// sqrt(5): beta over the fraction of critical damping (Antypov & Elliott 2011).
const BETA_PER_ZETA: f64 = 2.236_067_977_499_79;

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
        NormalLawName::Hertz => hertz(pair, replaced),
        NormalLawName::Linear => linear(pair, replaced),
        NormalLawName::Plastic => plastic(pair, replaced),
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

fn hertz(pair: &mut Pair<'_>, replaced: Option<&NormalOverride>) -> Option<Normal> {
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
pub(super) fn elastic_pair(
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

/// Spring and damping of a linear material with itself.
#[derive(Clone, Copy)]
struct LinearSide {
    stiffness: f64,
    damping: LinearDamping,
}

#[derive(Clone, Copy, PartialEq)]
enum LinearDamping {
    /// zeta.
    Ratio(f64),
    /// gamma, kg/s.
    Dissipation(f64),
}

/// k of two bodies of mass `mass` (kg) that collide in `time` (s) with this restitution, and zeta.
///
/// e = exp(-zeta w0 t_c) whether tension is cut or not, so w0 = |ln e|/(zeta t_c), and k = m* w0^2. Without damping, and
/// for e = 0 (critical, where no time is finite), w0 = pi/t_c.
fn from_collision(pair: &Pair<'_>, time: f64, e: f64, mass: f64) -> (f64, f64) {
    let zeta = zeta(pair, e);
    let frequency = if zeta == 0.0 || e == 0.0 {
        PI / time
    } else {
        e.ln().abs() / (zeta * time)
    };
    (0.5 * mass * frequency * frequency, zeta)
}

/// k of a linear material with itself, N/m; `None` for other laws.
pub(super) fn own_stiffness(pair: &Pair<'_>, material: &Material) -> Option<f64> {
    match &material.normal.value {
        NormalLaw::Plastic {
            loading_stiffness, ..
        } => Some(**loading_stiffness),
        _ => linear_side(pair, material).map(|side| side.stiffness),
    }
}

fn linear_side(pair: &Pair<'_>, material: &Material) -> Option<LinearSide> {
    let NormalLaw::Linear(law) = &material.normal.value else {
        return None;
    };
    Some(match law {
        LinearNormal::Dissipation {
            stiffness,
            dissipation,
        } => LinearSide {
            stiffness: **stiffness,
            damping: LinearDamping::Dissipation(**dissipation),
        },
        LinearNormal::Restitution {
            stiffness,
            restitution,
        } => LinearSide {
            stiffness: **stiffness,
            damping: LinearDamping::Ratio(zeta(pair, **restitution)),
        },
        LinearNormal::CollisionTime {
            collision_time,
            restitution,
            mass,
        } => {
            let (stiffness, zeta) = from_collision(pair, **collision_time, **restitution, **mass);
            LinearSide {
                stiffness,
                damping: LinearDamping::Ratio(zeta),
            }
        }
    })
}

fn linear(pair: &mut Pair<'_>, replaced: Option<&NormalOverride>) -> Option<Normal> {
    let number = |read: fn(&NormalOverride) -> Option<f64>| replaced.and_then(read);
    let given = number(|n| n.restitution.as_deref().copied());
    let typed = pair.sides.map(|side| match &side.normal.value {
        NormalLaw::Linear(
            LinearNormal::Restitution { restitution, .. }
            | LinearNormal::CollisionTime { restitution, .. },
        ) => Some(**restitution),
        _ => None,
    });
    for value in typed.into_iter().chain([given]).flatten() {
        check_restitution(pair, value)?;
    }
    let collision = match (
        number(|n| n.collision_time.as_deref().copied()),
        given,
        number(|n| n.mass.as_deref().copied()),
    ) {
        (Some(time), Some(e), Some(mass)) => Some(from_collision(pair, time, e, mass).0),
        _ => None,
    };
    let sides = pair.sides.map(|side| linear_side(pair, side));
    let over_stiffness = number(|n| n.stiffness.as_deref().copied()).or(collision);
    let (stiffness, origin) = pair.need(
        "normal.stiffness",
        over_stiffness,
        sides.map(|side| side.map(|side| side.stiffness)),
    )?;
    pair.record("normal.stiffness", "N/m", stiffness, origin);

    let over_dissipation = number(|n| n.dissipation.as_deref().copied());
    let contact = pair.contact_origin();
    let (damping, origin) = match (given, over_dissipation, sides) {
        (Some(e), _, _) => (LinearDamping::Ratio(zeta(pair, e)), contact),
        (_, Some(gamma), _) => (LinearDamping::Dissipation(gamma), contact),
        (_, _, [Some(a), Some(b)]) => (
            mix_damping(pair, a.damping, b.damping)?,
            pair.mixed_origin([true; 2]),
        ),
        (_, _, [Some(only), None]) => (only.damping, pair.mixed_origin([true, false])),
        (_, _, [None, Some(only)]) => (only.damping, pair.mixed_origin([false, true])),
        (None, None, [None, None]) => {
            pair.need("normal.restitution", None, [None, None])?;
            return None;
        }
    };
    let mut law = match damping {
        LinearDamping::Ratio(zeta) => {
            let e = restitution(pair, zeta);
            pair.record("normal.restitution", "", e, origin.clone());
            pair.record("normal.damping_ratio", "", zeta, origin);
            Linear::with_damping_ratio(stiffness, zeta)
        }
        LinearDamping::Dissipation(gamma) => {
            pair.record("normal.dissipation", "kg/s", gamma, origin);
            Linear::new(stiffness, gamma)
        }
    };
    law.clamp_tension = pair.conventions.clamp_tension;
    Some(Normal {
        law: AnyNormal::Linear(law),
        beta: None,
        stiffness: Some(stiffness),
    })
}

/// The mean of two dampings of one kind; no damping on either side means none.
fn mix_damping(pair: &mut Pair<'_>, a: LinearDamping, b: LinearDamping) -> Option<LinearDamping> {
    use LinearDamping::{Dissipation, Ratio};
    match (a, b) {
        (Ratio(a), Ratio(b)) => Some(Ratio(harmonic_mean(a, b))),
        (Dissipation(a), Dissipation(b)) => Some(Dissipation(harmonic_mean(a, b))),
        (Ratio(none), Dissipation(_)) | (Dissipation(_), Ratio(none)) if none == 0.0 => {
            Some(Ratio(0.0))
        }
        (Ratio(_), Dissipation(none)) | (Dissipation(none), Ratio(_)) if none == 0.0 => {
            Some(Dissipation(0.0))
        }
        _ => {
            let message = format!(
                "the damping of the contacts of {} is open: one material has a restitution, the other a dissipation",
                pair.name()
            );
            let help = pair.entry("normal = { restitution = ... }");
            pair.error(message, help);
            None
        }
    }
}

fn plastic(pair: &mut Pair<'_>, replaced: Option<&NormalOverride>) -> Option<Normal> {
    let sides = pair.sides.map(|side| match &side.normal.value {
        NormalLaw::Plastic {
            loading_stiffness,
            unloading_stiffness,
            cohesion_stiffness,
            penetration_depth,
            dissipation,
        } => Some([
            **loading_stiffness,
            **unloading_stiffness,
            **cohesion_stiffness,
            **penetration_depth,
            **dissipation,
        ]),
        _ => None,
    });
    let over = replaced.map(|n| {
        [
            &n.loading_stiffness,
            &n.unloading_stiffness,
            &n.cohesion_stiffness,
            &n.penetration_depth,
            &n.dissipation,
        ]
        .map(|value| value.as_deref().copied())
    });
    const KEYS: [(&str, &str); 5] = [
        ("normal.loading_stiffness", "N/m"),
        ("normal.unloading_stiffness", "N/m"),
        ("normal.cohesion_stiffness", "N/m"),
        ("normal.penetration_depth", ""),
        ("normal.dissipation", "kg/s"),
    ];
    let mut numbers = [0.0; 5];
    for (i, (key, unit)) in KEYS.into_iter().enumerate() {
        let over = over.and_then(|over| over[i]);
        let own = sides.map(|side| side.map(|side| side[i]));
        let (value, origin) = match pair.mix(over, own) {
            None if i == 4 => (0.0, Origin::Default),
            _ => pair.need(key, over, own)?,
        };
        numbers[i] = value;
        pair.record(key, unit, value, origin);
    }
    let [k1, k2, kc, phi, gamma] = numbers;
    if k2 < k1 {
        let message = format!(
            "unloading_stiffness = {k2} of the contacts of {} lies below loading_stiffness = {k1}",
            pair.name()
        );
        pair.error(message, "replace both".to_owned());
        return None;
    }
    Some(Normal {
        law: AnyNormal::Plastic(Plastic {
            loading_stiffness: k1,
            unloading_stiffness: k2,
            cohesion_stiffness: kc,
            penetration_depth: phi,
            dissipation: gamma,
            clamp_tension: pair.conventions.clamp_tension,
        }),
        beta: None,
        stiffness: Some(k1),
    })
}
