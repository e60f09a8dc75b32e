//! Dry cohesion of a pair.

use std::f64::consts::PI;

use mercury_common::scene::{LawKeys, LawPart};

use super::{Origin, Pair};
use crate::contact::adhesion::dry::{Branch, Dry, Jkr, KEYS, Pull, VanDerWaals};
use crate::contact::{AnyAdhesion, AnyNormal};

/// Dry cohesion of two materials; `Some(AnyAdhesion::None)` where one of them has no such law.
///
/// Works of adhesion and Hamaker constants mix by the geometric mean (Berthelot 1898), all other numbers by the harmonic mean. The range
/// of the law is still 0 ([`Dry::reaching`]).
pub(super) fn resolve(pair: &mut Pair<'_>, normal: &AnyNormal) -> Option<AnyAdhesion> {
    pair.ask(LawPart::Adhesion, &LawKeys::NONE);
    let own = pair.laws(LawPart::Adhesion);
    let over = (pair.replaced(LawPart::Adhesion)).is_some();
    if own.iter().any(Option::is_none) && !(over && own.iter().any(Option::is_some)) {
        return Some(AnyAdhesion::None);
    }
    let (keys, origin) = pair.common_law(&KEYS)?;
    pair.ask(LawPart::Adhesion, keys);
    pair.record_word("law", keys.name, origin);
    let law = match keys.name {
        "jkr" => jkr(pair, normal)?,
        "dmt" => {
            let work = geometric(pair, "work_of_adhesion")?;
            let branch = Branch {
                force_per_radius: 2.0 * PI * work,
                ..Branch::NONE
            };
            Dry::Pull(Pull::new(keys.name, [branch, Branch::NONE], true))
        }
        "van-der-waals" => {
            let hamaker = geometric(pair, "hamaker")?;
            let [separation, range] = pair.numbers(["separation", "range"])?;
            Dry::VanDerWaals(VanDerWaals {
                hamaker,
                separation,
                range,
            })
        }
        "charged" => charged(pair, keys.name)?,
        name => linear(pair, name)?,
    };
    Some(AnyAdhesion::Dry(law))
}

fn jkr(pair: &mut Pair<'_>, normal: &AnyNormal) -> Option<Dry> {
    let work = geometric(pair, "work_of_adhesion")?;
    let AnyNormal::Hertz(hertz) = normal else {
        let message = format!(
            "adhesion.law = \"jkr\" of the contacts of {} needs the normal law \"hertz\", whose elastic force it replaces",
            pair.name()
        );
        let help = "give normal = { law = \"hertz\", ... }, or take adhesion = { law = \"dmt\", ... } or \"reversible\", which go with any normal law";
        pair.error(message, help.to_owned());
        return None;
    };
    Some(if work > 0.0 {
        Dry::Jkr(Jkr::new(work, hertz.effective_modulus))
    } else {
        Dry::None
    })
}

/// `reversible` or `irreversible`.
fn linear(pair: &mut Pair<'_>, name: &'static str) -> Option<Dry> {
    // A material that gives the work of adhesion has a force that grows with R*: the two kinds do not mix.
    let [forces, works] = ["force", "work_of_adhesion"].map(|key| pair.sides(key));
    let replaced = ["force", "work_of_adhesion"].map(|key| pair.over(key).is_some());
    let [by_force, by_work] = [forces, works].map(|sides| sides.iter().any(Option::is_some));
    if by_force && by_work && replaced == [false; 2] {
        let message = format!(
            "the adhesion of the contacts of {} is ambiguous: one material gives a force, the other a work of adhesion",
            pair.name()
        );
        let help = format!("give one: {}", pair.entry("adhesion = { force = ... }"));
        pair.error(message, help);
        return None;
    }
    let takes_work = replaced[1] || by_work && !replaced[0];
    let [force, force_per_radius] = if takes_work {
        [0.0, 1.5 * PI * geometric(pair, "work_of_adhesion")?]
    } else {
        [pair.number("force")?, 0.0]
    };
    let branch = Branch {
        force,
        force_per_radius,
        stiffness: pair.number("stiffness")?,
        sign: 1.0,
    };
    let forms_on_contact = name == "irreversible";
    let branches = [branch, Branch::NONE];
    Some(Dry::Pull(Pull::new(name, branches, forms_on_contact)))
}

fn charged(pair: &mut Pair<'_>, name: &'static str) -> Option<Dry> {
    let charges = pair.sides("charge");
    if let Some(charge) = pair.over("charge") {
        let message = format!(
            "adhesion.charge = {charge} of the contacts of {}: a pair has two charges",
            pair.name()
        );
        pair.error(message, "give the charge at each material".to_owned());
        return None;
    }
    let [Some(one), Some(other)] = charges else {
        pair.need("charge", None, [None; 2])?;
        return None;
    };
    if let Some(charge) = [one, other]
        .into_iter()
        .find(|charge| charge.fract() != 0.0)
    {
        let message = format!("adhesion.charge = {charge} is none of -1, 0 and 1");
        pair.error(
            message,
            "give the sign of the charge alone; `force` is its strength".to_owned(),
        );
        return None;
    }
    let product = one * other;
    let origin = pair.mixed_origin([true; 2]);
    pair.record_derived("charges", "", product, origin);
    let [force, stiffness, van_der_waals] =
        pair.numbers(["force", "stiffness", "van_der_waals_force"])?;
    let key = "van_der_waals_stiffness";
    let (fall, origin) = (pair.mix(pair.over(key), pair.sides(key)))
        .unwrap_or((stiffness, Origin::Derived("= stiffness")));
    pair.record(key, fall, origin);
    let branch = |force: f64, stiffness: f64, sign: f64| Branch {
        force: force * product.abs(),
        force_per_radius: 0.0,
        stiffness,
        sign,
    };
    let branches = [
        branch(force, stiffness, -product.signum()),
        branch(van_der_waals, fall, 1.0),
    ];
    Some(Dry::Pull(Pull::new(name, branches, false)))
}

/// The value of `[[contacts]]`, else √(a b) of the two materials; it is recorded.
fn geometric(pair: &mut Pair<'_>, key: &str) -> Option<f64> {
    let (value, origin) = match (pair.over(key), pair.sides(key)) {
        (None, [Some(a), Some(b)]) if a != b => ((a * b).sqrt(), Origin::Mixed),
        (over, sides) => pair.need(key, over, sides)?,
    };
    pair.record(key, value, origin);
    Some(value)
}
