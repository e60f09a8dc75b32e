//! The liquid of a pair.

use mercury_common::scene::{LawKeys, LawPart, LiquidSettings};

use super::{Origin, Pair};
use crate::contact::AnyAdhesion;
use crate::contact::adhesion::liquid::{Fit, KEYS, Liquid, Rupture};

/// The liquid bridges of two materials; `Some(AnyAdhesion::None)` where one of them has no liquid law.
///
/// The contact angle mixes by the mean of the cosines, which is exact for small bridges at the touch; all other numbers by the
/// harmonic mean. The range of the law is still 0 ([`Liquid::reaching`]).
pub(super) fn resolve(pair: &mut Pair<'_>, settings: &LiquidSettings) -> Option<AnyAdhesion> {
    pair.ask(LawPart::Liquid, &LawKeys::NONE);
    let own = pair.laws(LawPart::Liquid);
    let over = (pair.replaced(LawPart::Liquid)).is_some();
    if own.iter().any(Option::is_none) && !(over && own.iter().any(Option::is_some)) {
        return Some(AnyAdhesion::None);
    }
    let (keys, origin) = pair.common_law(&KEYS)?;
    let fit = Fit::named(keys.name)?;
    pair.ask(LawPart::Liquid, keys);
    pair.record_word("law", keys.name, origin);
    let [
        surface_tension,
        max_volume,
        viscosity,
        min_volume,
        distribution,
    ] = pair.numbers([
        "surface_tension",
        "max_bridge_volume",
        "viscosity",
        "min_bridge_volume",
        "distribution",
    ])?;
    let contact_angle = contact_angle(pair)?;
    if min_volume > max_volume && max_volume > 0.0 {
        let message = format!(
            "min_bridge_volume = {min_volume:e} m3 of the contacts of {} lies above max_bridge_volume = {max_volume:e} m3",
            pair.name()
        );
        let help = "no bridge could form; give a smaller min_bridge_volume".to_owned();
        pair.error(message, help);
        return None;
    }
    let roughness = pair.mix(pair.over("roughness"), pair.sides("roughness"));
    match &roughness {
        Some((value, origin)) => pair.record("roughness", *value, origin.clone()),
        None => pair.record_word("roughness", "R*/100", Origin::Default),
    }
    let rupture = rupture(pair, fit)?;
    let accuracy = if fit == Fit::YoungLaplace {
        pair.numbers(["accuracy"])?[0]
    } else {
        0.0
    };
    Some(AnyAdhesion::Liquid(Liquid {
        fit,
        lian_seville_volume: pair.conventions().lian_seville_volume,
        rupture,
        surface_tension,
        contact_angle,
        max_volume,
        min_volume,
        distribution,
        viscosity,
        roughness: roughness.map(|(value, _)| value),
        lubrication: pair.conventions().lubrication,
        lubrication_in_contact: settings.lubrication_in_contact,
        range: 0.0,
        accuracy,
        table: 0,
    }))
}

/// Where bridges break; that of a table is the end of its bridges.
fn rupture(pair: &mut Pair<'_>, fit: Fit) -> Option<Rupture> {
    if fit == Fit::YoungLaplace {
        return Some(Rupture::Table);
    }
    let (word, origin) = pair.word("rupture")?;
    let rupture = match word {
        "lian" => Rupture::Lian,
        "willett" => Rupture::Willett,
        "default" if fit == Fit::Willett => Rupture::Lian,
        _ => Rupture::Radii,
    };
    let word = match rupture {
        Rupture::Lian => "lian",
        Rupture::Willett => "willett",
        Rupture::Radii | Rupture::Table => "radii",
    };
    pair.record_word("rupture", word, origin);
    Some(rupture)
}

/// theta, rad; recorded in degrees.
fn contact_angle(pair: &mut Pair<'_>) -> Option<f64> {
    let key = "contact_angle_degrees";
    let (degrees, origin) = match (pair.over(key), pair.sides(key)) {
        (None, [Some(a), Some(b)]) if a != b => {
            let cosine = 0.5 * (libm::cos(a.to_radians()) + libm::cos(b.to_radians()));
            (
                libm::acos(cosine.clamp(-1.0, 1.0)).to_degrees(),
                Origin::Mixed,
            )
        }
        (over, sides) => pair.need(key, over, sides)?,
    };
    pair.record(key, degrees, origin);
    Some(degrees.to_radians())
}
