//! The linear tangential spring and dashpot with Coulomb's limit.

use mercury_common::scene::{CoulombLimits, Key, LawKeys, LawPart, Range};

use super::super::history::TangentialSpring;
use super::super::{Contact, SpringRotation, follow};
use super::coulomb::{STRONGEST_DASHPOT, Slider};
use super::{AnyTangential, FRICTION, STATIC_FRICTION, TangentialLaw};
use crate::contact::mixing::{Friction, Pair};
use crate::contact::{
    AnyNormal, PlannedNormal, PlannedTangential, SpringAndDashpot, StiffestTangential,
};
use crate::lanes::{Mask, Real, Vector};

/// f = -k_t xi - gamma_t u_t within Coulomb's limit (Cundall & Strack 1979; Luding 2008, eqs. 22-24).
///
/// The spring xi follows the contact as it turns and is stretched by u_t dt; when it slides it is set back to what
/// the force it may carry needs. A static friction above the dynamic one gives stick-slip. A dashpot without a spring whose force
/// is always beyond the limit is Coulomb's friction itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearFriction {
    /// k_t, N/m; 0 leaves only the dashpot.
    pub stiffness: f64,
    /// gamma_t, kg/s.
    pub dissipation: f64,
    /// mu while sliding.
    pub friction: f64,
    /// mu while sticking.
    pub static_friction: f64,
    /// How the spring turns with the contact.
    pub rotation: SpringRotation,
    /// How the force is kept within Coulomb's limit; `Elastic` is Mindlin's alone and counts as `Total` in a scene.
    pub limits: CoulombLimits,
}

impl TangentialLaw for LinearFriction {
    type History<L: Real> = TangentialSpring<L>;
    const ACTIVE: bool = true;

    fn name(&self) -> &'static str {
        "linear friction"
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
        let damping = contact.tangential_velocity * L::splat(self.dissipation);
        let slider = Slider::new(
            self.limits,
            normal_force,
            self.friction,
            self.static_friction,
        );
        let (mut force, mut spring);
        if self.stiffness == 0.0 {
            (force, _) = slider.cut(-damping);
            spring = history.0;
        } else {
            let stiffness = L::splat(self.stiffness);
            spring = follow(self.rotation, history.0, contact, dt)
                + contact.tangential_velocity * L::splat(dt);
            let limited = slider.limit(-(spring * stiffness), damping);
            force = limited.force;
            if limited.slides.any() {
                spring = Vector::select(limited.slides, -limited.carried / stiffness, spring);
            }
        }
        if idle.any() {
            force = Vector::select(idle, Vector::ZERO, force);
            spring = Vector::select(idle, history.0, spring);
        }
        history.0 = spring;
        force
    }

    #[inline(always)]
    fn stiffness<L: Real>(&self, _: &Contact<L>) -> L {
        L::splat(self.stiffness)
    }

    /// -|xi|.
    fn tangential_overlap(&self, _: &Contact, history: &TangentialSpring) -> f64 {
        -history.0.length()
    }

    fn slip(
        &self,
        contact: &Contact,
        normal_force: f64,
        dt: f64,
        [before, after]: [&TangentialSpring; 2],
    ) -> f64 {
        if self.stiffness == 0.0 {
            return contact.tangential_velocity.length() * dt;
        }
        let mut unlimited = *before;
        let law = Self {
            friction: f64::INFINITY,
            static_friction: f64::INFINITY,
            ..*self
        };
        law.force(contact, normal_force, dt, &mut unlimited);
        (unlimited.0 - after.0).length()
    }

    fn energy<L: Real>(&self, _: &Contact<L>, history: &TangentialSpring<L>) -> L {
        history.0.length_squared() * (0.5 * self.stiffness)
    }
}

impl PlannedTangential for LinearFriction {
    const KEYS: &'static LawKeys = &LawKeys {
        parts: &[LawPart::Tangential],
        name: "linear",
        text: "linear spring and dashpot with Coulomb's limit",
        keys: &[
            FRICTION,
            STATIC_FRICTION,
            Key::new("stiffness", "N/m", Range::NonNegative, "k_t"),
            Key::new(
                "stiffness_ratio",
                "",
                Range::NonNegative,
                "k_t/k_n, beside a normal law of constant stiffness",
            ),
            Key::new("dissipation", "kg/s", Range::NonNegative, "gamma_t").or(0.0),
        ],
        choices: &[&[&["stiffness"], &["stiffness_ratio"]]],
    };

    fn of_scene(
        pair: &mut Pair<'_>,
        normal: &AnyNormal,
        friction: Friction,
    ) -> Option<AnyTangential> {
        let (constants, ratios) = (pair.sides("stiffness"), pair.sides("stiffness_ratio"));
        let (over_k, over_ratio) = (pair.over("stiffness"), pair.over("stiffness_ratio"));
        let has = pair.typed().map(|typed| typed.is_some());
        let all_ratios = [0, 1].iter().all(|&i| !has[i] || ratios[i].is_some());
        let (stiffness, origin) = if over_k.is_none() && (over_ratio.is_some() || all_ratios) {
            let (ratio, origin) = match pair.mix(over_ratio, ratios) {
                Some(mixed) => mixed,
                None => pair.need("stiffness", None, ratios)?,
            };
            let Some(normal_stiffness) = normal.spring() else {
                let message = format!(
                    "stiffness_ratio has no meaning for the contacts of {}: the stiffness of a {} contact grows with the overlap",
                    pair.name(),
                    crate::contact::NormalLaw::name(normal)
                );
                let help = "give tangential.stiffness in N/m, or use tangential = { law = \"mindlin\", ... }";
                pair.error(message, help.to_owned());
                return None;
            };
            pair.record("stiffness_ratio", ratio, origin.clone());
            (ratio * normal_stiffness, origin)
        } else {
            let own = pair.own_stiffnesses();
            let of_ratio = |i: usize| ratios[i].and_then(|ratio| own[i].map(|k| ratio * k));
            let constants = [0, 1].map(|i| constants[i].or_else(|| of_ratio(i)));
            pair.need("stiffness", over_k, constants)?
        };
        pair.record("stiffness", stiffness, origin);
        let dissipation = pair.number("dissipation")?;
        Some(AnyTangential::Linear(Self {
            stiffness,
            dissipation: dissipation.min(STRONGEST_DASHPOT),
            friction: friction.mu_dynamic,
            static_friction: friction.mu_static,
            rotation: pair.rotation(),
            limits: match pair.conventions().coulomb_limits {
                CoulombLimits::Bounded => CoulombLimits::Bounded,
                CoulombLimits::Elastic | CoulombLimits::Total => CoulombLimits::Total,
            },
        }))
    }
}

impl LinearFriction {
    /// Where it is stiffest: everywhere. Coulomb's limit bounds the dashpot, which has no part in what the step must bear.
    pub(super) fn stiffest(&self, _: f64, _: f64) -> StiffestTangential {
        StiffestTangential {
            spring: SpringAndDashpot {
                stiffness: self.stiffness,
                dissipation: 0.0,
            },
            full: self.stiffness,
            is_bounded: false,
        }
    }
}
