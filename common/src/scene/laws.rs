//! The contact laws a material can name, with their parameters as typed.
//!
//! Nothing is mixed or converted here; where one physical quantity can be given in several ways, an
//! enum says in which it was.

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
