//! Mindlin's tangential stiffness with a spring that forgets the load at which it was stretched.

use mercury_common::scene::{CoulombLimits, Key, LawKeys, LawPart, Mixing, Range};

use super::super::history::TangentialSpring;
use super::super::{Contact, turn};
use super::coulomb::{STRONGEST_DASHPOT, Slider};
use super::{AnyTangential, FRICTION, MindlinRescaled, STATIC_FRICTION, TangentialLaw};
use crate::contact::mixing::{Friction, Pair};
use crate::contact::normal::{effective_shear_modulus, elastic_pair};
use crate::contact::parameter::Origin;
use crate::contact::{
    AnyNormal, PlannedNormal, PlannedTangential, SpringAndDashpot, StiffestTangential,
};
use crate::lanes::{Mask, Real, Vector};

/// f = -s k_t xi with k_t = 8 G* a, a = sqrt(R* overlap), taken at the present overlap, and while it sticks a dashpot
/// beta_t sqrt(m* k_t) u_t; both within Coulomb's limit (Mindlin 1949; Di Renzo & Di Maio 2005, eq. 17 for s = 2/3;
/// Thornton et al. 2023, eqs. 4.5-4.8).
///
/// s = 1 is Mindlin's no-slip stiffness at constant load; s = 2/3, the default, is exact where xi grows in proportion to
/// the overlap. Because k_t follows the overlap while xi stays, unloading gives back more or less than loading took:
/// [`super::MindlinRescaled`] cures that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mindlin {
    /// G*, Pa.
    pub effective_shear_modulus: f64,
    /// s.
    pub stiffness_factor: f64,
    /// beta_t.
    pub damping: f64,
    /// mu while sliding.
    pub friction: f64,
    /// mu while sticking.
    pub static_friction: f64,
    /// How the force is kept within Coulomb's limit.
    pub limits: CoulombLimits,
    /// 8 G*, Pa.
    stiffness_per_radius: f64,
    /// beta_t sqrt(8 G*), so that the dashpot is `dashpot` sqrt(m* a).
    dashpot: f64,
}

impl Mindlin {
    /// From G* (Pa), the factor s, beta_t and the two friction coefficients.
    #[must_use]
    pub fn new(
        effective_shear_modulus: f64,
        stiffness_factor: f64,
        damping: f64,
        friction: f64,
        static_friction: f64,
    ) -> Self {
        let stiffness_per_radius = 8.0 * effective_shear_modulus;
        Self {
            effective_shear_modulus,
            stiffness_factor,
            damping,
            friction,
            static_friction,
            limits: CoulombLimits::Bounded,
            stiffness_per_radius,
            dashpot: damping * stiffness_per_radius.sqrt(),
        }
    }

    /// This law without a limit: it never slides.
    pub(super) fn without_limit(&self) -> Self {
        Self {
            friction: f64::INFINITY,
            static_friction: f64::INFINITY,
            ..*self
        }
    }

    /// This law, kept within Coulomb's limit in another way.
    #[must_use]
    pub fn with_limits(self, limits: CoulombLimits) -> Self {
        Self { limits, ..self }
    }
}

impl TangentialLaw for Mindlin {
    type History<L: Real> = TangentialSpring<L>;
    const ACTIVE: bool = true;

    fn name(&self) -> &'static str {
        "mindlin"
    }

    #[inline(always)]
    fn force<L: Real>(
        &self,
        contact: &Contact<L>,
        normal_force: L,
        dt: f64,
        history: &mut TangentialSpring<L>,
    ) -> Vector<L> {
        let idle = Slider::idle(self.limits, normal_force);
        if idle.all() || self.friction == 0.0 {
            return Vector::ZERO;
        }
        let radius = contact.contact_radius();
        let stiffness = radius * (self.stiffness_factor * self.stiffness_per_radius);
        let dashpot = (contact.effective_mass * radius).sqrt() * self.dashpot;
        let mut spring = turn(history.0, contact) + contact.tangential_velocity * L::splat(dt);
        let elastic = -(spring * stiffness);
        let damping = contact.tangential_velocity * dashpot;
        let slider = Slider::new(
            self.limits,
            normal_force,
            self.friction,
            self.static_friction,
        );
        let limited = slider.limit(elastic, damping);
        let mut force = limited.force;
        if limited.slides.any() {
            spring = Vector::select(limited.slides, -limited.carried / stiffness, spring);
        }
        if idle.any() {
            force = Vector::select(idle, Vector::ZERO, force);
            spring = Vector::select(idle, history.0, spring);
        }
        history.0 = spring;
        force
    }

    #[inline(always)]
    fn stiffness<L: Real>(&self, contact: &Contact<L>) -> L {
        contact.contact_radius() * self.stiffness_per_radius
    }

    /// The sum of the components, a convention of MercuryDPM that shows the sign in plane problems.
    fn tangential_overlap(&self, _: &Contact, history: &TangentialSpring) -> f64 {
        history.0.x + history.0.y + history.0.z
    }

    fn slip(
        &self,
        contact: &Contact,
        normal_force: f64,
        dt: f64,
        [before, after]: [&TangentialSpring; 2],
    ) -> f64 {
        let mut unlimited = *before;
        (self.without_limit()).force(contact, normal_force, dt, &mut unlimited);
        (unlimited.0 - after.0).length()
    }

    fn energy<L: Real>(&self, contact: &Contact<L>, history: &TangentialSpring<L>) -> L {
        self.stiffness(contact) * (0.5 * self.stiffness_factor) * history.0.length_squared()
    }
}

impl PlannedTangential for Mindlin {
    const KEYS: &'static LawKeys = &LawKeys {
        parts: &[LawPart::Tangential],
        name: "mindlin",
        text: "Mindlin (1949), with Hertz contacts",
        keys: &[
            FRICTION,
            STATIC_FRICTION,
            Key::new(
                "damping",
                "",
                Range::NonNegative,
                "beta_t in beta_t sqrt(m* k_t)",
            )
            .or_word("default", "sqrt(2/3) of the normal one"),
            Key::new(
                "stiffness_factor",
                "",
                Range::Positive,
                "factor on k_t = 8 G* a",
            )
            .or(2.0 / 3.0),
            Key::new(
                "effective_shear_modulus",
                "Pa",
                Range::Positive,
                "G* of the material with itself",
            )
            .or_open("from E and Poisson's ratio")
            .mixes(Mixing::Derived("by the elasticity of the two bodies")),
            Key::new(
                "load_history",
                "",
                Range::Words(&["secant", "rescale"]),
                "secant: the displacement is stored; rescale: the force, which shrinks with the contact radius when unloading",
            )
            .or_word("secant", "")
            .mixes(Mixing::Same),
        ],
        choices: &[],
    };

    fn of_scene(
        pair: &mut Pair<'_>,
        normal: &AnyNormal,
        friction: Friction,
    ) -> Option<AnyTangential> {
        let (shear, shear_origin) = shear_modulus(pair)?;
        let factors = (
            pair.over("stiffness_factor"),
            pair.sides("stiffness_factor"),
        );
        let (damping, damping_origin) = damping(pair, normal)?;
        let (load_history, history_origin) = pair.word("load_history")?;
        pair.record("effective_shear_modulus", shear, shear_origin);
        let (factor, factor_origin) = pair
            .mix(factors.0, factors.1)
            .unwrap_or((2.0 / 3.0, Origin::Default));
        pair.record("stiffness_factor", factor, factor_origin);
        pair.record("damping", damping, damping_origin);
        pair.record_word("load_history", load_history, history_origin);
        let mut law = Self::new(
            shear,
            factor,
            damping.min(STRONGEST_DASHPOT),
            friction.mu_dynamic,
            friction.mu_static,
        );
        law.limits = pair.conventions().coulomb_limits;
        Some(match load_history {
            "rescale" => AnyTangential::MindlinRescaled(MindlinRescaled { plain: law }),
            _ => AnyTangential::Mindlin(law),
        })
    }
}

/// beta_t: by default sqrt(2/3) beta_n (Thornton et al. 2023, eq. 4.8).
fn damping(pair: &mut Pair<'_>, normal: &AnyNormal) -> Option<(f64, Origin)> {
    let default = normal.beta().map(|beta| (2.0f64 / 3.0).sqrt() * beta);
    let follows = Origin::Derived("sqrt(2/3) of normal.damping");
    let replaced = pair.replaced(LawPart::Tangential);
    let over_default = replaced.is_some_and(|values| values.word("damping").is_some());
    let typed = pair.sides("damping");
    let damping = match pair.over("damping") {
        Some(beta) => Some((beta, pair.contact_origin())),
        None if !over_default && typed != [None, None] => {
            // A side that leaves its damping open counts with the pair's default.
            let has = pair.typed().map(|typed| typed.is_some());
            let complete = [0, 1].map(|i| typed[i].or(if has[i] { default } else { None }));
            match (default, typed, has) {
                (None, [Some(_), None], [_, true]) | (None, [None, Some(_)], [true, _]) => None,
                _ => pair.mix(None, complete),
            }
        }
        None => default.map(|beta| (beta, follows)),
    };
    if damping.is_none() {
        let message = format!(
            "tangential.damping of the contacts of {} has no default: it follows from the damping of a hertz law, and their normal law is another",
            pair.name()
        );
        pair.error(
            message,
            "give tangential = { damping = ... } (0 for none)".to_owned(),
        );
    }
    damping
}

/// G*: given for the pair, else exact from E and nu of both, else the mean of the like-like G*.
fn shear_modulus(pair: &mut Pair<'_>) -> Option<(f64, Origin)> {
    let over = pair.over("effective_shear_modulus");
    let typed = pair.sides("effective_shear_modulus");
    let normal = |key: &str| pair.replaced(LawPart::Normal)?.number(key);
    let (over_e, over_nu) = (normal("youngs_modulus"), normal("poisson_ratio"));
    let constants = pair.elastic_constants();
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
    let like_like = [0, 1]
        .map(|i| typed[i].or_else(|| constants[i].map(|one| effective_shear_modulus(one, one))));
    pair.need("effective_shear_modulus", over, like_like)
}

impl Mindlin {
    /// Spring and dashpot at the contact radius `radius` (m), for m* (kg). Their force stays below the friction that an
    /// estimated overlap allows, so beyond its critical step it rattles between the two directions of sliding and does not grow.
    /// Where Coulomb's limit holds for the dashpot too, that has no part in what the step must bear.
    pub(super) fn stiffest(&self, effective_mass: f64, radius: f64) -> StiffestTangential {
        let full = 8.0 * self.effective_shear_modulus * radius;
        StiffestTangential {
            spring: SpringAndDashpot {
                stiffness: self.stiffness_factor * full,
                dissipation: match self.limits {
                    CoulombLimits::Elastic => self.damping * (effective_mass * full).sqrt(),
                    CoulombLimits::Bounded | CoulombLimits::Total => 0.0,
                },
            },
            full,
            is_bounded: true,
        }
    }
}
