//! The contact laws a material can name, with their parameters as typed.
//!
//! Nothing is mixed or converted here; where one physical quantity can be given in several ways, an
//! enum says in which it was.

use super::cursor::Fields;
use super::source::Located;

/// The laws of the normal force by name, for pairs and messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum NormalLawName {
    /// `hertz`
    Hertz,
    /// `linear`
    Linear,
    /// `plastic`
    Plastic,
}

/// The laws of sliding by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TangentialLawName {
    /// `linear`
    Linear,
    /// `mindlin`
    Mindlin,
}

/// The laws of liquid bridges by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LiquidLawName {
    /// `willett`: Willett et al. 2000, the short approximation.
    Willett,
    /// `willett-classical`: Willett et al. 2000, the full fit.
    WillettClassical,
    /// `bagheri`: Bagheri et al. 2024.
    Bagheri,
    /// `lian-seville`: Lian and Seville 2016.
    LianSeville,
}

pub(super) const NORMAL_LAWS: [(&str, NormalLawName); 3] = [
    ("hertz", NormalLawName::Hertz),
    ("linear", NormalLawName::Linear),
    ("plastic", NormalLawName::Plastic),
];

pub(super) const TANGENTIAL_LAWS: [(&str, TangentialLawName); 2] = [
    ("linear", TangentialLawName::Linear),
    ("mindlin", TangentialLawName::Mindlin),
];

pub(super) const LIQUID_LAWS: [(&str, LiquidLawName); 4] = [
    ("willett", LiquidLawName::Willett),
    ("willett-classical", LiquidLawName::WillettClassical),
    ("bagheri", LiquidLawName::Bagheri),
    ("lian-seville", LiquidLawName::LianSeville),
];

/// The only law of rolling and of torsion so far: `luding` (Luding 2008, doi:10.1007/s10035-008-0099-x).
pub(super) const COUPLE_LAWS: [(&str, ()); 1] = [("luding", ())];

/// A number, or the word `default`.
#[derive(Debug, Clone, PartialEq)]
pub enum OrDefault {
    /// The law's own choice.
    Default,
    /// As given.
    Given(Located<f64>),
}

/// The force along the normal.
#[derive(Debug, Clone, PartialEq)]
pub enum NormalLaw {
    /// Hertz (1882) with viscous damping.
    Hertz {
        /// The elastic constants.
        modulus: HertzModulus,
        /// The damping.
        damping: HertzDamping,
    },
    /// Linear spring and dashpot.
    Linear(LinearNormal),
    /// Hysteretic, adhesive: Luding (2008).
    Plastic {
        /// Stiffness of first loading k1, N/m.
        loading_stiffness: Located<f64>,
        /// Largest stiffness of unloading k2, N/m; at least `loading_stiffness`.
        unloading_stiffness: Located<f64>,
        /// Stiffness of the tensile branch kc, N/m.
        cohesion_stiffness: Located<f64>,
        /// Penetration depth phi_f, in [0, 1].
        penetration_depth: Located<f64>,
        /// Dissipation gamma, kg/s.
        dissipation: Located<f64>,
    },
}

impl NormalLaw {
    /// The name of the law.
    #[must_use]
    pub fn name(&self) -> NormalLawName {
        match self {
            NormalLaw::Hertz { .. } => NormalLawName::Hertz,
            NormalLaw::Linear(_) => NormalLawName::Linear,
            NormalLaw::Plastic { .. } => NormalLawName::Plastic,
        }
    }
}

/// How the elasticity of a Hertz contact is given.
#[derive(Debug, Clone, PartialEq)]
pub enum HertzModulus {
    /// By the constants of the material.
    Youngs {
        /// Young's modulus E, Pa.
        youngs_modulus: Located<f64>,
        /// Poisson's ratio.
        poisson_ratio: Located<f64>,
    },
    /// By the effective modulus E* of a contact of the material with itself, Pa.
    Effective {
        /// E*, Pa.
        effective_modulus: Located<f64>,
    },
}

/// How the damping of a Hertz contact is given.
#[derive(Debug, Clone, PartialEq)]
pub enum HertzDamping {
    /// Coefficient of restitution, in [0, 1].
    Restitution(Located<f64>),
    /// Damping coefficient beta in beta sqrt(m* k_n), at least 0.
    Damping(Located<f64>),
}

/// How the linear spring and dashpot are given.
#[derive(Debug, Clone, PartialEq)]
pub enum LinearNormal {
    /// Stiffness with dissipation.
    Dissipation {
        /// Stiffness k, N/m.
        stiffness: Located<f64>,
        /// Dissipation gamma, kg/s.
        dissipation: Located<f64>,
    },
    /// Stiffness with the restitution of the pair's effective mass.
    Restitution {
        /// Stiffness k, N/m.
        stiffness: Located<f64>,
        /// Coefficient of restitution, in [0, 1].
        restitution: Located<f64>,
    },
    /// Duration and restitution of a collision of two spheres of the same mass.
    CollisionTime {
        /// Duration of the contact, s.
        collision_time: Located<f64>,
        /// Coefficient of restitution, in [0, 1].
        restitution: Located<f64>,
        /// Mass of one sphere, kg.
        mass: Located<f64>,
    },
}

/// The force of sliding.
#[derive(Debug, Clone, PartialEq)]
pub enum TangentialLaw {
    /// Linear spring and dashpot with a Coulomb limit.
    Linear {
        /// The spring.
        stiffness: TangentialStiffness,
        /// Dissipation gamma_t, kg/s; default 0.
        dissipation: Located<f64>,
        /// Friction coefficient while sliding.
        friction: Located<f64>,
        /// Friction coefficient that starts sliding; none: that of the pair while sliding.
        static_friction: Option<Located<f64>>,
    },
    /// Mindlin (1949), with Hertz contacts.
    Mindlin {
        /// Friction coefficient while sliding.
        friction: Located<f64>,
        /// Friction coefficient that starts sliding; none: that of the pair while sliding.
        static_friction: Option<Located<f64>>,
        /// Damping coefficient beta_t; by default sqrt(2/3) of the normal one.
        damping: OrDefault,
        /// Factor on 8 G* a; default 2/3.
        stiffness_factor: Located<f64>,
        /// Effective shear modulus G* of the material with itself, Pa; none: from E and Poisson's ratio.
        effective_shear_modulus: Option<Located<f64>>,
        /// What happens to the stored force when the load changes; default secant.
        load_history: LoadHistory,
    },
}

impl TangentialLaw {
    /// The name of the law.
    #[must_use]
    pub fn name(&self) -> TangentialLawName {
        match self {
            TangentialLaw::Linear { .. } => TangentialLawName::Linear,
            TangentialLaw::Mindlin { .. } => TangentialLawName::Mindlin,
        }
    }
}

/// How the tangential spring is given.
#[derive(Debug, Clone, PartialEq)]
pub enum TangentialStiffness {
    /// k_t, N/m.
    Stiffness(Located<f64>),
    /// k_t / k_n.
    Ratio(Located<f64>),
}

/// How the stored tangential force follows the normal load.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LoadHistory {
    /// The displacement is stored; the stiffness is that of the current overlap.
    Secant,
    /// The force is stored; it shrinks with the contact radius when unloading.
    Rescale,
}

pub(super) const LOAD_HISTORIES: [(&str, LoadHistory); 2] = [
    ("secant", LoadHistory::Secant),
    ("rescale", LoadHistory::Rescale),
];

/// Parameters of a couple that resists rolling or torsion.
#[derive(Debug, Clone, PartialEq)]
pub struct Couple {
    /// Coefficient while turning.
    pub friction: Located<f64>,
    /// Coefficient that starts turning; none: that of the pair while turning.
    pub static_friction: Option<Located<f64>>,
    /// Stiffness, N/m; by default k_t of the contact.
    pub stiffness: OrDefault,
    /// Dissipation, kg/s; default 0.
    pub dissipation: Located<f64>,
}

/// The couple against rolling.
#[derive(Debug, Clone, PartialEq)]
pub enum RollingLaw {
    /// Spring, dashpot and limit as for sliding: Luding (2008).
    Luding(Couple),
}

/// The couple against twisting about the normal.
#[derive(Debug, Clone, PartialEq)]
pub enum TorsionLaw {
    /// Spring, dashpot and limit as for sliding: Luding (2008).
    Luding(Couple),
}

/// Liquid bridges.
#[derive(Debug, Clone, PartialEq)]
pub struct LiquidLaw {
    /// Which law.
    pub law: LiquidLawName,
    /// Surface tension, N/m.
    pub surface_tension: Located<f64>,
    /// Contact angle, degrees, in [0, 180].
    pub contact_angle_degrees: Located<f64>,
    /// Dynamic viscosity, Pa s; default 0: no lubrication force.
    pub viscosity: Located<f64>,
    /// Largest volume of a bridge, m3.
    pub max_bridge_volume: Located<f64>,
    /// Smallest volume of a bridge that forms, m3; default 0.
    pub min_bridge_volume: Located<f64>,
    /// Share of a ruptured bridge's liquid that goes to neighbouring bridges, the rest to the films,
    /// in [0, 1]; default 1.
    pub distribution: Located<f64>,
    /// Least gap of the lubrication force, m; by default R*/100.
    pub roughness: OrDefault,
}

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
