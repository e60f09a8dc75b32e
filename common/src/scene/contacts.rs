//! `[[contacts]]`: what replaces the mixed parameters of a pair of materials, key by key.

use super::MaterialIndex;
use super::cursor::{Context, Fields};
use super::item::Item;
use super::law_reader::number_or_default;
use super::laws::{
    COUPLE_LAWS, LIQUID_LAWS, LOAD_HISTORIES, LiquidLawName, LoadHistory, NORMAL_LAWS,
    NormalLawName, OrDefault, TANGENTIAL_LAWS, TangentialLawName,
};
use super::source::{Located, Place};

/// Parameters of the contacts between two materials (or of one with itself).
#[derive(Debug, Clone, PartialEq)]
pub struct ContactOverride {
    /// The two materials, as listed.
    pub between: [Located<MaterialIndex>; 2],
    /// Where the entry stands.
    pub place: Place,
    /// Of the normal law.
    pub normal: Option<NormalOverride>,
    /// Of the law of sliding.
    pub tangential: Option<TangentialOverride>,
    /// Of the law of rolling.
    pub rolling: Option<CoupleOverride>,
    /// Of the law of torsion.
    pub torsion: Option<CoupleOverride>,
    /// Of the liquid bridges.
    pub liquid: Option<LiquidOverride>,
}

/// Keys of a normal law; those left out are mixed. See [`NormalLaw`](super::NormalLaw) for the meaning.
#[derive(Debug, Clone, PartialEq)]
pub struct NormalOverride {
    /// Where the table stands.
    pub place: Place,
    /// The law; none: that of the two materials.
    pub law: Option<Located<NormalLawName>>,
    /// Hertz: E, Pa, as if both bodies had it.
    pub youngs_modulus: Option<Located<f64>>,
    /// Hertz: Poisson's ratio, as if both bodies had it.
    pub poisson_ratio: Option<Located<f64>>,
    /// Hertz: E* of the pair, Pa.
    pub effective_modulus: Option<Located<f64>>,
    /// Hertz, linear: restitution of the pair, in [0, 1].
    pub restitution: Option<Located<f64>>,
    /// Hertz: beta of the pair.
    pub damping: Option<Located<f64>>,
    /// Linear: k, N/m.
    pub stiffness: Option<Located<f64>>,
    /// Linear, plastic: gamma, kg/s.
    pub dissipation: Option<Located<f64>>,
    /// Linear: duration of the contact, s.
    pub collision_time: Option<Located<f64>>,
    /// Linear: mass that goes with `collision_time`, kg.
    pub mass: Option<Located<f64>>,
    /// Plastic: k1, N/m.
    pub loading_stiffness: Option<Located<f64>>,
    /// Plastic: k2, N/m.
    pub unloading_stiffness: Option<Located<f64>>,
    /// Plastic: kc, N/m.
    pub cohesion_stiffness: Option<Located<f64>>,
    /// Plastic: phi_f, in [0, 1].
    pub penetration_depth: Option<Located<f64>>,
}

/// Keys of a law of sliding; those left out are mixed.
/// See [`TangentialLaw`](super::TangentialLaw) for the meaning.
#[derive(Debug, Clone, PartialEq)]
pub struct TangentialOverride {
    /// Where the table stands.
    pub place: Place,
    /// The law; none: that of the two materials.
    pub law: Option<Located<TangentialLawName>>,
    /// Coefficient while sliding.
    pub friction: Option<Located<f64>>,
    /// Coefficient that starts sliding.
    pub static_friction: Option<Located<f64>>,
    /// Linear: k_t, N/m.
    pub stiffness: Option<Located<f64>>,
    /// Linear: k_t / k_n.
    pub stiffness_ratio: Option<Located<f64>>,
    /// Linear: gamma_t, kg/s.
    pub dissipation: Option<Located<f64>>,
    /// Mindlin: beta_t.
    pub damping: Option<OrDefault>,
    /// Mindlin: factor on 8 G* a.
    pub stiffness_factor: Option<Located<f64>>,
    /// Mindlin: G* of the pair, Pa.
    pub effective_shear_modulus: Option<Located<f64>>,
    /// Mindlin: what happens to the stored force when the load changes.
    pub load_history: Option<Located<LoadHistory>>,
}

/// Keys of a law of rolling or torsion; those left out are mixed.
#[derive(Debug, Clone, PartialEq)]
pub struct CoupleOverride {
    /// Where the table stands.
    pub place: Place,
    /// Coefficient while turning.
    pub friction: Option<Located<f64>>,
    /// Coefficient that starts turning.
    pub static_friction: Option<Located<f64>>,
    /// Stiffness, N/m, or k_t of the contact.
    pub stiffness: Option<OrDefault>,
    /// Dissipation, kg/s.
    pub dissipation: Option<Located<f64>>,
}

/// Keys of the liquid bridges; those left out are mixed. See [`LiquidLaw`](super::LiquidLaw).
#[derive(Debug, Clone, PartialEq)]
pub struct LiquidOverride {
    /// Where the table stands.
    pub place: Place,
    /// The law.
    pub law: Option<Located<LiquidLawName>>,
    /// Surface tension, N/m.
    pub surface_tension: Option<Located<f64>>,
    /// Contact angle, degrees.
    pub contact_angle_degrees: Option<Located<f64>>,
    /// Viscosity, Pa s.
    pub viscosity: Option<Located<f64>>,
    /// Largest volume of a bridge, m3.
    pub max_bridge_volume: Option<Located<f64>>,
    /// Smallest volume of a bridge that forms, m3.
    pub min_bridge_volume: Option<Located<f64>>,
    /// Share of a ruptured bridge's liquid that goes to neighbouring bridges.
    pub distribution: Option<Located<f64>>,
    /// Least gap of the lubrication force, m.
    pub roughness: Option<OrDefault>,
}

/// The words under `law` of the materials, as typed: an override without `law` follows them.
pub(super) struct LawWords {
    /// Of each material, in file order.
    pub(super) normal: Vec<Option<String>>,
    /// Of each material, in file order.
    pub(super) tangential: Vec<Option<String>>,
}

/// Reads all overrides; no pair may be named twice.
pub(super) fn read_all(
    context: &Context,
    items: &[Item<'_>],
    words: &LawWords,
) -> Vec<ContactOverride> {
    let mut all: Vec<ContactOverride> = Vec::new();
    for item in items {
        let Some(new) = read(item, words) else {
            continue;
        };
        let pair = |contact: &ContactOverride| {
            let [a, b] = &contact.between;
            (a.value.min(b.value), a.value.max(b.value))
        };
        if all.iter().any(|other| pair(other) == pair(&new)) {
            let message = "the contacts of these two materials are given twice";
            context.report(
                new.between[0]
                    .error(message)
                    .with_help("put all keys into one entry"),
            );
        } else {
            all.push(new);
        }
    }
    all
}

fn read(item: &Item<'_>, words: &LawWords) -> Option<ContactOverride> {
    let fields = item.table()?;
    let between = fields.need("between").and_then(|item| read_pair(&item));
    let pair = between.as_ref().map(|[a, b]| [a.value, b.value]);
    let table = |key: &'static str| {
        let item = fields.get(key)?;
        Some((item.table()?, item.place))
    };
    let normal =
        table("normal").and_then(|(fields, place)| read_normal(&fields, place, pair, words));
    let tangential = table("tangential")
        .and_then(|(fields, place)| read_tangential(&fields, place, pair, words));
    let rolling =
        table("rolling").and_then(|(fields, place)| read_couple(&fields, place, "rolling law"));
    let torsion =
        table("torsion").and_then(|(fields, place)| read_couple(&fields, place, "torsion law"));
    let liquid = table("liquid").and_then(|(fields, place)| read_liquid(&fields, place));
    fields.finish();
    Some(ContactOverride {
        between: between?,
        place: item.place.clone(),
        normal,
        tangential,
        rolling,
        torsion,
        liquid,
    })
}

fn read_pair(item: &Item<'_>) -> Option<[Located<MaterialIndex>; 2]> {
    let items = item.list()?;
    let [first, second] = items.as_slice() else {
        item.report(format!(
            "expected the names of two materials, got {}",
            items.len()
        ));
        return None;
    };
    let (first, second) = (first.material(), second.material());
    Some([first?, second?])
}

/// The law whose keys may stand in an override: the one it names, else that of both materials.
/// `None` where there is none, which has been reported.
fn law_in_force<L: Copy>(
    fields: &Fields<'_>,
    named: Option<&Located<L>>,
    pair: Option<[MaterialIndex; 2]>,
    words: &[Option<String>],
    laws: &[(&str, L)],
) -> Option<L> {
    if let Some(law) = named {
        return Some(law.value);
    }
    let [a, b] = pair?.map(|index| words.get(index.0).and_then(Option::as_deref));
    if a.is_some() && a == b {
        // An unknown word has been reported at the material.
        return laws
            .iter()
            .find(|(word, _)| Some(*word) == a)
            .map(|&(_, law)| law);
    }
    let name = |word: Option<&str>| word.map_or("none".to_owned(), |word| format!("`{word}`"));
    let place = fields.place();
    let message = format!(
        "the two materials have no law in common: {} and {}",
        name(a),
        name(b)
    );
    fields
        .context
        .report(place.error(message).with_help("name one here with `law`"));
    None
}

fn read_normal(
    fields: &Fields<'_>,
    place: Place,
    pair: Option<[MaterialIndex; 2]>,
    words: &LawWords,
) -> Option<NormalOverride> {
    let mut law = None;
    if let Some(item) = fields.get("law") {
        law = Some(item.word("normal law", &NORMAL_LAWS).map(|value| Located {
            value,
            place: item.place.clone(),
        })?);
    }
    let in_force = law_in_force(fields, law.as_ref(), pair, &words.normal, &NORMAL_LAWS)?;
    let positive = |key| fields.get(key).and_then(|item| item.positive());
    let non_negative = |key| fields.get(key).and_then(|item| item.non_negative());
    let fraction = |key| fields.get(key).and_then(|item| item.fraction());
    let mut read = NormalOverride {
        place,
        law,
        youngs_modulus: None,
        poisson_ratio: None,
        effective_modulus: None,
        restitution: None,
        damping: None,
        stiffness: None,
        dissipation: None,
        collision_time: None,
        mass: None,
        loading_stiffness: None,
        unloading_stiffness: None,
        cohesion_stiffness: None,
        penetration_depth: None,
    };
    match in_force {
        NormalLawName::Hertz => {
            read.youngs_modulus = positive("youngs_modulus");
            read.poisson_ratio = fields
                .get("poisson_ratio")
                .and_then(|item| item.poisson_ratio());
            read.effective_modulus = positive("effective_modulus");
            read.restitution = fraction("restitution");
            read.damping = non_negative("damping");
            fields.exactly_one(&["effective_modulus", "youngs_modulus"], false);
            fields.exactly_one(&["effective_modulus", "poisson_ratio"], false);
            fields.exactly_one(&["restitution", "damping"], false);
        }
        NormalLawName::Linear => {
            read.stiffness = positive("stiffness");
            read.dissipation = non_negative("dissipation");
            read.restitution = fraction("restitution");
            read.collision_time = positive("collision_time");
            read.mass = positive("mass");
            fields.exactly_one(&["restitution", "dissipation"], false);
            fields.exactly_one(&["collision_time", "stiffness"], false);
            if fields.has("collision_time") {
                fields.exactly_one(&["collision_time", "dissipation"], false);
                fields.need("mass");
                fields.need("restitution");
            }
        }
        NormalLawName::Plastic => {
            read.loading_stiffness = positive("loading_stiffness");
            read.unloading_stiffness = positive("unloading_stiffness");
            read.cohesion_stiffness = non_negative("cohesion_stiffness");
            read.penetration_depth = fraction("penetration_depth");
            read.dissipation = non_negative("dissipation");
        }
    }
    fields.finish();
    Some(read)
}

fn read_tangential(
    fields: &Fields<'_>,
    place: Place,
    pair: Option<[MaterialIndex; 2]>,
    words: &LawWords,
) -> Option<TangentialOverride> {
    let mut law = None;
    if let Some(item) = fields.get("law") {
        law = Some(
            item.word("tangential law", &TANGENTIAL_LAWS)
                .map(|value| Located {
                    value,
                    place: item.place.clone(),
                })?,
        );
    }
    let in_force = law_in_force(
        fields,
        law.as_ref(),
        pair,
        &words.tangential,
        &TANGENTIAL_LAWS,
    )?;
    let non_negative = |key| fields.get(key).and_then(|item| item.non_negative());
    let positive = |key| fields.get(key).and_then(|item| item.positive());
    let mut read = TangentialOverride {
        place,
        law,
        friction: non_negative("friction"),
        static_friction: non_negative("static_friction"),
        stiffness: None,
        stiffness_ratio: None,
        dissipation: None,
        damping: None,
        stiffness_factor: None,
        effective_shear_modulus: None,
        load_history: None,
    };
    match in_force {
        TangentialLawName::Linear => {
            read.stiffness = non_negative("stiffness");
            read.stiffness_ratio = non_negative("stiffness_ratio");
            read.dissipation = non_negative("dissipation");
            fields.exactly_one(&["stiffness", "stiffness_ratio"], false);
        }
        TangentialLawName::Mindlin => {
            read.damping = number_or_default(fields, "damping");
            read.stiffness_factor = positive("stiffness_factor");
            read.effective_shear_modulus = positive("effective_shear_modulus");
            read.load_history = fields.get("load_history").and_then(|item| {
                let value = item.word("load history", &LOAD_HISTORIES)?;
                Some(Located {
                    value,
                    place: item.place,
                })
            });
        }
    }
    fields.finish();
    Some(read)
}

fn read_couple(fields: &Fields<'_>, place: Place, what: &str) -> Option<CoupleOverride> {
    if let Some(item) = fields.get("law") {
        item.word(what, &COUPLE_LAWS)?;
    }
    let non_negative = |key| fields.get(key).and_then(|item| item.non_negative());
    let read = CoupleOverride {
        place,
        friction: non_negative("friction"),
        static_friction: non_negative("static_friction"),
        stiffness: number_or_default(fields, "stiffness"),
        dissipation: non_negative("dissipation"),
    };
    fields.finish();
    Some(read)
}

fn read_liquid(fields: &Fields<'_>, place: Place) -> Option<LiquidOverride> {
    let mut law = None;
    if let Some(item) = fields.get("law") {
        law = Some(item.word("liquid law", &LIQUID_LAWS).map(|value| Located {
            value,
            place: item.place.clone(),
        })?);
    }
    let non_negative = |key| fields.get(key).and_then(|item| item.non_negative());
    let read = LiquidOverride {
        place,
        law,
        surface_tension: non_negative("surface_tension"),
        contact_angle_degrees: fields
            .get("contact_angle_degrees")
            .and_then(|item| item.between(0.0, 180.0)),
        viscosity: non_negative("viscosity"),
        max_bridge_volume: non_negative("max_bridge_volume"),
        min_bridge_volume: non_negative("min_bridge_volume"),
        distribution: fields.get("distribution").and_then(|item| item.fraction()),
        roughness: number_or_default(fields, "roughness"),
    };
    fields.finish();
    Some(read)
}
