//! Reads the tables that name a contact law.

use super::cursor::Fields;
use super::laws::{
    COUPLE_LAWS, Couple, HertzDamping, HertzModulus, LIQUID_LAWS, LOAD_HISTORIES, LinearNormal,
    LiquidLaw, LoadHistory, NORMAL_LAWS, NormalLaw, NormalLawName, OrDefault, RollingLaw,
    TANGENTIAL_LAWS, TangentialLaw, TangentialLawName, TangentialStiffness, TorsionLaw,
};

pub(super) fn number_or_default(fields: &Fields<'_>, key: &'static str) -> Option<OrDefault> {
    let item = fields.get(key)?;
    if item.is_text() {
        return item.keyword("default").map(|()| OrDefault::Default);
    }
    item.non_negative().map(OrDefault::Given)
}

pub(super) fn read_normal(fields: &Fields<'_>) -> Option<NormalLaw> {
    let law = fields.need("law")?.word("normal law", &NORMAL_LAWS)?;
    let read = match law {
        NormalLawName::Hertz => read_hertz(fields),
        NormalLawName::Linear => read_linear_normal(fields).map(NormalLaw::Linear),
        NormalLawName::Plastic => read_plastic(fields),
    };
    fields.finish();
    read
}

fn read_hertz(fields: &Fields<'_>) -> Option<NormalLaw> {
    let effective = fields
        .get("effective_modulus")
        .and_then(|item| item.positive());
    let modulus = if fields.has("effective_modulus") {
        let youngs = ["youngs_modulus", "poisson_ratio"];
        for key in youngs {
            fields.exactly_one(&["effective_modulus", key], false);
            fields.get(key);
        }
        effective.map(|effective_modulus| HertzModulus::Effective { effective_modulus })
    } else {
        let youngs = fields
            .need("youngs_modulus")
            .and_then(|item| item.positive());
        let poisson = fields
            .need("poisson_ratio")
            .and_then(|item| item.poisson_ratio());
        youngs
            .zip(poisson)
            .map(|(youngs_modulus, poisson_ratio)| HertzModulus::Youngs {
                youngs_modulus,
                poisson_ratio,
            })
    };
    let restitution = fields.get("restitution").and_then(|item| item.fraction());
    let damping = fields.get("damping").and_then(|item| item.non_negative());
    fields.exactly_one(&["restitution", "damping"], true);
    let damping = restitution
        .map(HertzDamping::Restitution)
        .or(damping.map(HertzDamping::Damping));
    Some(NormalLaw::Hertz {
        modulus: modulus?,
        damping: damping?,
    })
}

fn read_linear_normal(fields: &Fields<'_>) -> Option<LinearNormal> {
    let restitution = fields.get("restitution").and_then(|item| item.fraction());
    if fields.has("collision_time") {
        let collision_time = fields
            .need("collision_time")
            .and_then(|item| item.positive());
        let mass = fields.need("mass").and_then(|item| item.positive());
        for key in ["stiffness", "dissipation"] {
            fields.exactly_one(&["collision_time", key], false);
            fields.get(key);
        }
        fields.need("restitution");
        return Some(LinearNormal::CollisionTime {
            collision_time: collision_time?,
            restitution: restitution?,
            mass: mass?,
        });
    }
    let stiffness = fields.need("stiffness").and_then(|item| item.positive());
    let dissipation = fields
        .get("dissipation")
        .and_then(|item| item.non_negative());
    fields.exactly_one(&["restitution", "dissipation"], true);
    fields.get("collision_time");
    let stiffness = stiffness?;
    match (restitution, dissipation) {
        (Some(restitution), _) => Some(LinearNormal::Restitution {
            stiffness,
            restitution,
        }),
        (None, dissipation) => Some(LinearNormal::Dissipation {
            stiffness,
            dissipation: dissipation?,
        }),
    }
}

fn read_plastic(fields: &Fields<'_>) -> Option<NormalLaw> {
    let loading = fields
        .need("loading_stiffness")
        .and_then(|item| item.positive());
    let unloading = fields
        .need("unloading_stiffness")
        .and_then(|item| item.positive());
    let cohesion = fields
        .need("cohesion_stiffness")
        .and_then(|item| item.non_negative());
    let penetration = fields
        .need("penetration_depth")
        .and_then(|item| item.fraction());
    let dissipation = match fields.get("dissipation") {
        Some(item) => item.non_negative(),
        None => Some(fields.default("dissipation", 0.0)),
    };
    let (loading_stiffness, unloading_stiffness) = loading.zip(unloading)?;
    if *unloading_stiffness < *loading_stiffness {
        let at_least = loading_stiffness.place.text();
        fields.context.report(unloading_stiffness.error(format!(
            "must be >= loading_stiffness = {at_least}, got {}",
            unloading_stiffness.place.text()
        )));
    }
    Some(NormalLaw::Plastic {
        loading_stiffness,
        unloading_stiffness,
        cohesion_stiffness: cohesion?,
        penetration_depth: penetration?,
        dissipation: dissipation?,
    })
}

pub(super) fn read_tangential(fields: &Fields<'_>) -> Option<TangentialLaw> {
    let law = fields
        .need("law")?
        .word("tangential law", &TANGENTIAL_LAWS)?;
    let friction = fields.need("friction").and_then(|item| item.non_negative());
    let static_friction = fields
        .get("static_friction")
        .and_then(|item| item.non_negative());
    let read =
        match law {
            TangentialLawName::Linear => {
                let stiffness = fields.get("stiffness").and_then(|item| item.non_negative());
                let ratio = fields
                    .get("stiffness_ratio")
                    .and_then(|item| item.non_negative());
                fields.exactly_one(&["stiffness", "stiffness_ratio"], true);
                let dissipation = match fields.get("dissipation") {
                    Some(item) => item.non_negative(),
                    None => Some(fields.default("dissipation", 0.0)),
                };
                let stiffness = stiffness
                    .map(TangentialStiffness::Stiffness)
                    .or(ratio.map(TangentialStiffness::Ratio));
                friction.zip(stiffness).zip(dissipation).map(
                    |((friction, stiffness), dissipation)| TangentialLaw::Linear {
                        stiffness,
                        dissipation,
                        friction,
                        static_friction,
                    },
                )
            }
            TangentialLawName::Mindlin => {
                let damping = number_or_default(fields, "damping").unwrap_or(OrDefault::Default);
                let stiffness_factor = match fields.get("stiffness_factor") {
                    Some(item) => item.positive(),
                    None => Some(fields.default("stiffness_factor", 2.0 / 3.0)),
                };
                let effective_shear_modulus = fields
                    .get("effective_shear_modulus")
                    .and_then(|item| item.positive());
                let load_history = fields
                    .get("load_history")
                    .and_then(|item| item.word("load history", &LOAD_HISTORIES))
                    .unwrap_or(LoadHistory::Secant);
                friction
                    .zip(stiffness_factor)
                    .map(|(friction, stiffness_factor)| TangentialLaw::Mindlin {
                        friction,
                        static_friction,
                        damping,
                        stiffness_factor,
                        effective_shear_modulus,
                        load_history,
                    })
            }
        };
    fields.finish();
    read
}

fn read_couple(fields: &Fields<'_>, what: &str) -> Option<Couple> {
    fields.need("law")?.word(what, &COUPLE_LAWS)?;
    let friction = fields.need("friction").and_then(|item| item.non_negative());
    let static_friction = fields
        .get("static_friction")
        .and_then(|item| item.non_negative());
    let stiffness = number_or_default(fields, "stiffness").unwrap_or(OrDefault::Default);
    let dissipation = match fields.get("dissipation") {
        Some(item) => item.non_negative(),
        None => Some(fields.default("dissipation", 0.0)),
    };
    fields.finish();
    Some(Couple {
        friction: friction?,
        static_friction,
        stiffness,
        dissipation: dissipation?,
    })
}

pub(super) fn read_rolling(fields: &Fields<'_>) -> Option<RollingLaw> {
    read_couple(fields, "rolling law").map(RollingLaw::Luding)
}

pub(super) fn read_torsion(fields: &Fields<'_>) -> Option<TorsionLaw> {
    read_couple(fields, "torsion law").map(TorsionLaw::Luding)
}

pub(super) fn read_liquid(fields: &Fields<'_>) -> Option<LiquidLaw> {
    let law = fields.need("law")?.word("liquid law", &LIQUID_LAWS)?;
    let non_negative = |key, default| match fields.get(key) {
        Some(item) => item.non_negative(),
        None => Some(fields.default(key, default)),
    };
    let surface_tension = fields
        .need("surface_tension")
        .and_then(|item| item.non_negative());
    let contact_angle = fields
        .need("contact_angle_degrees")
        .and_then(|item| item.between(0.0, 180.0));
    let viscosity = non_negative("viscosity", 0.0);
    let max_bridge_volume = fields
        .need("max_bridge_volume")
        .and_then(|item| item.non_negative());
    let min_bridge_volume = non_negative("min_bridge_volume", 0.0);
    let distribution = match fields.get("distribution") {
        Some(item) => item.fraction(),
        None => Some(fields.default("distribution", 1.0)),
    };
    let roughness = number_or_default(fields, "roughness").unwrap_or(OrDefault::Default);
    fields.finish();
    Some(LiquidLaw {
        law,
        surface_tension: surface_tension?,
        contact_angle_degrees: contact_angle?,
        viscosity: viscosity?,
        max_bridge_volume: max_bridge_volume?,
        min_bridge_volume: min_bridge_volume?,
        distribution: distribution?,
        roughness,
    })
}
