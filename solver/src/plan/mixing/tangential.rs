//! The law of sliding of a pair.

use mercury_common::scene::{
    CoulombLimits, LoadHistory, Located, Material, OrDefault, TangentialLaw, TangentialLawName,
    TangentialOverride, TangentialStiffness,
};

use super::normal::{Normal, elastic_pair, own_stiffness, youngs};
use super::{Origin, Pair};
use crate::contact::normal::effective_shear_modulus;
use crate::contact::{AnyTangential, LinearFriction, Mindlin, MindlinRescaled};

/// What all laws of sliding have.
struct Friction {
    dynamic: f64,
    holding: f64,
}

/// `needs_stiffness`: a rolling law takes its stiffness from this one, so it stays even without friction.
pub(super) fn resolve(
    pair: &mut Pair<'_>,
    normal: &Normal,
    needs_stiffness: bool,
) -> Option<AnyTangential> {
    let replaced = pair
        .contact
        .and_then(|(_, contact)| contact.tangential.as_ref());
    let own = pair.sides.map(|side| side.tangential.as_deref());
    // A material without a law of sliding is smooth.
    let sides = own.map(|law| Some(law.map_or(0.0, friction_of)));
    let over = replaced.and_then(|t| t.friction.as_deref().copied());
    let (dynamic, origin) = pair.mix(over, sides)?;
    if dynamic == 0.0 && !(needs_stiffness && own.iter().any(Option::is_some)) {
        pair.record("tangential.friction", "", 0.0, origin);
        return Some(AnyTangential::None);
    }
    let law = law_name(pair, replaced, own)?;
    pair.record("tangential.friction", "", dynamic, origin);
    let holding = static_friction(pair, replaced, own, dynamic)?;
    let friction = Friction { dynamic, holding };
    match law {
        TangentialLawName::Linear => linear(pair, replaced, own, normal, &friction),
        TangentialLawName::Mindlin => mindlin(pair, replaced, own, normal, &friction),
    }
}

fn friction_of(law: &TangentialLaw) -> f64 {
    match law {
        TangentialLaw::Linear { friction, .. } | TangentialLaw::Mindlin { friction, .. } => {
            **friction
        }
    }
}

fn word(law: TangentialLawName) -> &'static str {
    match law {
        TangentialLawName::Linear => "linear",
        TangentialLawName::Mindlin => "mindlin",
    }
}

fn law_name(
    pair: &mut Pair<'_>,
    replaced: Option<&TangentialOverride>,
    own: [Option<&TangentialLaw>; 2],
) -> Option<TangentialLawName> {
    let named = replaced.and_then(|t| t.law.as_ref()).map(|law| law.value);
    let (law, origin) = match (named, own.map(|law| law.map(TangentialLaw::name))) {
        (Some(law), _) => (law, pair.contact_origin()),
        (None, [Some(a), Some(b)]) if a == b => (a, pair.mixed_origin([true; 2])),
        (None, [Some(a), None]) => (a, pair.mixed_origin([true, false])),
        (None, [None, Some(b)]) => (b, pair.mixed_origin([false, true])),
        (None, laws) => {
            let [a, b] = laws.map(|law| law.map_or("none", word));
            let message = format!(
                "the contacts of {} have no tangential law: `{}` is {a}, `{}` is {b}",
                pair.name(),
                pair.sides[0].name.value,
                pair.sides[1].name.value,
            );
            let help = format!(
                "name it: {}",
                pair.entry("tangential = { law = \"...\", ... }")
            );
            pair.error(message, help);
            return None;
        }
    };
    pair.record_word("tangential.law", word(law), origin);
    Some(law)
}

/// The coefficient at which sliding starts: where nobody says, the one of sliding.
fn static_friction(
    pair: &mut Pair<'_>,
    replaced: Option<&TangentialOverride>,
    own: [Option<&TangentialLaw>; 2],
    dynamic: f64,
) -> Option<f64> {
    let typed = |law: Option<&TangentialLaw>| match law? {
        TangentialLaw::Linear {
            static_friction, ..
        }
        | TangentialLaw::Mindlin {
            static_friction, ..
        } => static_friction.as_deref().copied(),
    };
    let over = replaced.and_then(|t| t.static_friction.as_deref().copied());
    resolve_static(
        pair,
        "tangential.static_friction",
        over,
        own.map(typed),
        own.map(|law| law.map_or(0.0, friction_of)),
        dynamic,
    )
}

/// The static coefficient of sliding, rolling or torsion. A side that gives none counts with its dynamic one.
pub(super) fn resolve_static(
    pair: &mut Pair<'_>,
    key: &'static str,
    over: Option<f64>,
    typed: [Option<f64>; 2],
    dynamic_sides: [f64; 2],
    dynamic: f64,
) -> Option<f64> {
    let (value, origin) = if over.is_none() && typed == [None, None] {
        (dynamic, Origin::Derived("= friction"))
    } else {
        let sides = [0, 1].map(|i| Some(typed[i].unwrap_or(dynamic_sides[i])));
        pair.mix(over, sides)?
    };
    // A mean of equal numbers may differ in the last digits.
    if value < dynamic * (1.0 - 1e-12) {
        let (table, _) = key.split_once('.').unwrap_or((key, ""));
        let message = format!(
            "{key} = {value} of the contacts of {} lies below {table}.friction = {dynamic}",
            pair.name()
        );
        let help = "what holds before it slides needs at least the friction of sliding; give both coefficients";
        pair.error(message, help.to_owned());
        return None;
    }
    let value = value.max(dynamic);
    pair.record(key, "", value, origin);
    Some(value)
}

fn linear(
    pair: &mut Pair<'_>,
    replaced: Option<&TangentialOverride>,
    own: [Option<&TangentialLaw>; 2],
    normal: &Normal,
    friction: &Friction,
) -> Option<AnyTangential> {
    let stiffness_of = |law: Option<&TangentialLaw>| match law? {
        TangentialLaw::Linear { stiffness, .. } => Some(stiffness.clone()),
        TangentialLaw::Mindlin { .. } => None,
    };
    let sides = own.map(stiffness_of);
    let over_k = replaced.and_then(|t| t.stiffness.as_deref().copied());
    let over_ratio = replaced.and_then(|t| t.stiffness_ratio.as_deref().copied());
    let ratio = |side: &Option<TangentialStiffness>| match side {
        Some(TangentialStiffness::Ratio(ratio)) => Some(**ratio),
        _ => None,
    };
    let all_ratios = sides
        .iter()
        .flatten()
        .all(|side| matches!(side, TangentialStiffness::Ratio(_)));
    let (stiffness, origin) = if over_k.is_none() && (over_ratio.is_some() || all_ratios) {
        let ratios = [ratio(&sides[0]), ratio(&sides[1])];
        let (ratio, origin) = pair.need("tangential.stiffness", over_ratio, ratios)?;
        let Some(normal_stiffness) = normal.stiffness else {
            let message = format!(
                "stiffness_ratio has no meaning for the contacts of {}: the stiffness of a hertz contact grows with the overlap",
                pair.name()
            );
            let help =
                "give tangential.stiffness in N/m, or use tangential = { law = \"mindlin\", ... }";
            pair.error(message, help.to_owned());
            return None;
        };
        pair.record("tangential.stiffness_ratio", "", ratio, origin.clone());
        (ratio * normal_stiffness, origin)
    } else {
        let constant = |i: usize| match &sides[i] {
            Some(TangentialStiffness::Stiffness(k)) => Some(**k),
            Some(TangentialStiffness::Ratio(ratio)) => {
                own_stiffness(pair, pair.sides[i]).map(|k| **ratio * k)
            }
            None => None,
        };
        let constants = [constant(0), constant(1)];
        pair.need("tangential.stiffness", over_k, constants)?
    };
    let dissipation_of = |law: Option<&TangentialLaw>| match law? {
        TangentialLaw::Linear { dissipation, .. } => Some(**dissipation),
        TangentialLaw::Mindlin { .. } => None,
    };
    let over = replaced.and_then(|t| t.dissipation.as_deref().copied());
    let (dissipation, dissipation_origin) = pair
        .mix(over, own.map(dissipation_of))
        .unwrap_or((0.0, Origin::Default));
    pair.record("tangential.stiffness", "N/m", stiffness, origin);
    pair.record(
        "tangential.dissipation",
        "kg/s",
        dissipation,
        dissipation_origin,
    );
    Some(AnyTangential::Linear(LinearFriction {
        stiffness,
        dissipation,
        friction: friction.dynamic,
        static_friction: friction.holding,
        rotation: pair.rotation(),
    }))
}

/// The Mindlin parameters of a material with itself.
struct MindlinSide {
    factor: f64,
    damping: OrDefault,
    shear: Option<f64>,
    history: LoadHistory,
}

fn mindlin_side(law: Option<&TangentialLaw>) -> Option<MindlinSide> {
    match law? {
        TangentialLaw::Mindlin {
            damping,
            stiffness_factor,
            effective_shear_modulus,
            load_history,
            ..
        } => Some(MindlinSide {
            factor: **stiffness_factor,
            damping: damping.clone(),
            shear: effective_shear_modulus.as_deref().copied(),
            history: *load_history,
        }),
        TangentialLaw::Linear { .. } => None,
    }
}

fn mindlin(
    pair: &mut Pair<'_>,
    replaced: Option<&TangentialOverride>,
    own: [Option<&TangentialLaw>; 2],
    normal: &Normal,
    friction: &Friction,
) -> Option<AnyTangential> {
    let sides = own.map(mindlin_side);
    let shear = shear_modulus(pair, replaced, &sides)?;
    let number = |value: &Option<Located<f64>>| value.as_deref().copied();
    let over_factor = replaced.and_then(|t| number(&t.stiffness_factor));
    let factors = [0, 1].map(|i| sides[i].as_ref().map(|side| side.factor));
    let (factor, factor_origin) = pair
        .mix(over_factor, factors)
        .unwrap_or((2.0 / 3.0, Origin::Default));

    // beta_t = sqrt(2/3) beta_n (Thornton et al. 2023, eq. 4.8).
    let default = normal.beta.map(|beta| (2.0f64 / 3.0).sqrt() * beta);
    let follows = Origin::Derived("sqrt(2/3) of normal.damping");
    let over = replaced.and_then(|t| t.damping.as_ref());
    let given = |damping: &OrDefault| match damping {
        OrDefault::Given(beta) => Some(**beta),
        OrDefault::Default => None,
    };
    let typed = [0, 1].map(|i| sides[i].as_ref().and_then(|side| given(&side.damping)));
    let damping = match over {
        Some(OrDefault::Given(beta)) => Some((**beta, pair.contact_origin())),
        None if typed != [None, None] => {
            // A side that leaves its damping open counts with the pair's default.
            let has = [0, 1].map(|i| sides[i].is_some());
            let complete = [0, 1].map(|i| typed[i].or(if has[i] { default } else { None }));
            match (default, typed, has) {
                (None, [Some(_), None], [_, true]) | (None, [None, Some(_)], [true, _]) => None,
                _ => pair.mix(None, complete),
            }
        }
        _ => default.map(|beta| (beta, follows)),
    };
    let Some((damping, damping_origin)) = damping else {
        let message = format!(
            "tangential.damping of the contacts of {} has no default: it follows from the damping of a hertz law, and their normal law is another",
            pair.name()
        );
        pair.error(
            message,
            "give tangential = { damping = ... } (0 for none)".to_owned(),
        );
        return None;
    };

    let over_history = replaced.and_then(|t| t.load_history.as_ref().map(|h| h.value));
    let histories: Vec<LoadHistory> = sides.iter().flatten().map(|side| side.history).collect();
    let (history, history_origin) = match (over_history, histories.as_slice()) {
        (Some(history), _) => (history, pair.contact_origin()),
        (None, []) => (LoadHistory::Secant, Origin::Default),
        (None, [only]) => (
            *only,
            pair.mixed_origin([sides[0].is_some(), sides[1].is_some()]),
        ),
        (None, [a, rest @ ..]) if rest.iter().all(|b| a == b) => (*a, pair.mixed_origin([true; 2])),
        (None, _) => {
            let message = format!(
                "the load_history of the contacts of {} is open: one material has \"secant\", the other \"rescale\"",
                pair.name()
            );
            let help = pair.entry("tangential = { load_history = \"...\" }");
            pair.error(message, help);
            return None;
        }
    };
    pair.record("tangential.effective_shear_modulus", "Pa", shear.0, shear.1);
    pair.record("tangential.stiffness_factor", "", factor, factor_origin);
    pair.record("tangential.damping", "", damping, damping_origin);
    let history_word = match history {
        LoadHistory::Secant => "secant",
        LoadHistory::Rescale => "rescale",
    };
    pair.record_word("tangential.load_history", history_word, history_origin);
    let mut law = Mindlin::new(shear.0, factor, damping, friction.dynamic, friction.holding);
    law.cap_total = pair.conventions.coulomb_limits == CoulombLimits::Total;
    Some(match history {
        LoadHistory::Secant => AnyTangential::Mindlin(law),
        LoadHistory::Rescale => AnyTangential::MindlinRescaled(MindlinRescaled { plain: law }),
    })
}

/// G*: given for the pair, else exact from E and nu of both, else the mean of the like-like G*.
fn shear_modulus(
    pair: &mut Pair<'_>,
    replaced: Option<&TangentialOverride>,
    sides: &[Option<MindlinSide>; 2],
) -> Option<(f64, Origin)> {
    let over = replaced.and_then(|t| t.effective_shear_modulus.as_deref().copied());
    let typed = [0, 1].map(|i| sides[i].as_ref().and_then(|side| side.shear));
    let normal = pair
        .contact
        .and_then(|(_, contact)| contact.normal.as_ref());
    let over_e = normal.and_then(|n| n.youngs_modulus.as_deref().copied());
    let over_nu = normal.and_then(|n| n.poisson_ratio.as_deref().copied());
    let constants = pair.sides.map(youngs);
    if over.is_none() && (typed == [None, None] || over_e.is_some()) {
        let origin = if over_e.is_some() || over_nu.is_some() {
            pair.contact_origin()
        } else {
            pair.mixed_origin(constants.map(|c| c.is_some()))
        };
        if let Some([a, b]) = elastic_pair(constants, over_e, over_nu) {
            return Some((effective_shear_modulus(a, b), origin));
        }
    }
    let like_like = |i: usize| {
        let from_constants =
            |material: &Material| youngs(material).map(|one| effective_shear_modulus(one, one));
        typed[i].or_else(|| from_constants(pair.sides[i]))
    };
    let sides = [like_like(0), like_like(1)];
    pair.need("tangential.effective_shear_modulus", over, sides)
}
