//! The linear spring and dashpot of a pair.

use std::f64::consts::PI;

use mercury_common::scene::{LinearNormal, Material, NormalLaw, NormalOverride};

use super::{Normal, Pair, check_restitution, harmonic_mean, restitution, zeta};
use crate::contact::{AnyNormal, Linear};

/// Spring and damping of a linear material with itself.
#[derive(Clone, Copy)]
pub(super) struct LinearSide {
    pub(super) stiffness: f64,
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

/// What a linear material does with itself; `None` for other laws.
pub(super) fn side(pair: &Pair<'_>, material: &Material) -> Option<LinearSide> {
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

pub(super) fn resolve(pair: &mut Pair<'_>, replaced: Option<&NormalOverride>) -> Option<Normal> {
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
    let sides = pair.sides.map(|material| side(pair, material));
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
