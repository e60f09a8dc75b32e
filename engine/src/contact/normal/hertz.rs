//! Hertz' law with the damping that makes the restitution independent of the velocity.

use mercury_common::scene::{Key, LawKeys, LawPart, Mixing, Range};

use super::super::normal::linear::{damping_ratio, damping_ratio_clamped};
use super::elastic::{ELASTIC_CHOICE, ELASTIC_KEYS, modulus_of};
use super::{Contact, NormalForce, NormalLaw};
use crate::contact::mixing::{Pair, restitution_of};
use crate::contact::{PlannedNormal, Scale, SpringAndDashpot};
use crate::lanes::Real;

/// F_n = k_n overlap - beta sqrt(m* k_n) u_n with the secant stiffness k_n = 4/3 E* a, a = sqrt(R* overlap)
/// (Hertz 1882; damping: Tsuji, Tanaka & Ishida 1992, constant from Antypov & Elliott 2011, eq. 17).
///
/// ```
/// use mercury_engine::contact::normal::{Hertz, effective_modulus};
/// let law = Hertz::new(effective_modulus((1e7, 0.3), (1e7, 0.3)), 0.0);
/// assert!((law.effective_modulus - 5494505.494505494).abs() < 1e-6);
/// // two spheres of 5 mm: R* = 2.5 mm, overlap 1e-5 m
/// assert!((law.elastic_force(2.5e-3, 1e-5) / 0.01158343465263 - 1.0).abs() < 1e-12);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hertz {
    /// E*, Pa.
    pub effective_modulus: f64,
    /// beta >= 0; sqrt(5) times the fraction of critical damping.
    pub damping: f64,
    /// 4/3 E*, Pa.
    stiffness_per_radius: f64,
    /// beta sqrt(4/3 E*), so that the dashpot is `dashpot` sqrt(m* a).
    dashpot: f64,
    /// Cut tensile forces.
    pub clamp_tension: bool,
}

impl Hertz {
    /// From E* (Pa) and beta.
    #[must_use]
    pub fn new(effective_modulus: f64, damping: f64) -> Self {
        let stiffness_per_radius = 4.0 / 3.0 * effective_modulus;
        Self {
            effective_modulus,
            damping,
            stiffness_per_radius,
            dashpot: damping * stiffness_per_radius.sqrt(),
            clamp_tension: false,
        }
    }

    /// 4/3 E* sqrt(R* overlap) overlap, N, for R* and overlap in m.
    #[must_use]
    pub fn elastic_force(&self, effective_radius: f64, overlap: f64) -> f64 {
        self.stiffness_per_radius * (effective_radius * overlap).sqrt() * overlap
    }

    /// Duration (s) of an elastic collision at the relative speed v (m/s): 2.868... (m*^2/(R* E*^2 v))^(1/5).
    ///
    /// The constant is 4 sqrt(pi) Gamma(2/5) / (5 Gamma(9/10)) (15/16)^(2/5) (Hertz 1882).
    #[must_use]
    pub fn collision_time(&self, effective_mass: f64, effective_radius: f64, speed: f64) -> f64 {
        let fifth_power = effective_mass * effective_mass
            / (effective_radius * self.effective_modulus * self.effective_modulus * speed);
        2.868_265_699_195_331 * libm::pow(fifth_power, 0.2)
    }

    /// Largest overlap (m) of an elastic collision at the relative speed v (m/s):
    /// (15/16 m* v^2 / (E* sqrt R*))^(2/5).
    #[must_use]
    pub fn largest_overlap(&self, effective_mass: f64, effective_radius: f64, speed: f64) -> f64 {
        let ratio = 15.0 / 16.0 * effective_mass * speed * speed
            / (self.effective_modulus * effective_radius.sqrt());
        libm::pow(ratio, 0.4)
    }
}

impl NormalLaw for Hertz {
    type History<L: Real> = ();

    fn name(&self) -> &'static str {
        "hertz"
    }

    #[inline(always)]
    fn force<L: Real>(&self, contact: &Contact<L>, (): &mut ()) -> NormalForce<L> {
        let radius = contact.contact_radius();
        let force = NormalForce {
            elastic: radius * self.stiffness_per_radius * contact.overlap,
            viscous: (contact.effective_mass * radius).sqrt()
                * -self.dashpot
                * contact.normal_velocity,
        };
        if self.clamp_tension {
            force.clamped()
        } else {
            force
        }
    }

    fn clamps_tension(&self) -> bool {
        self.clamp_tension
    }

    #[inline(always)]
    fn energy<L: Real>(&self, contact: &Contact<L>, (): &()) -> L {
        contact.contact_radius()
            * (0.4 * self.stiffness_per_radius)
            * contact.overlap
            * contact.overlap
    }
}

/// beta for a restitution e in [0, 1]: sqrt(5) |ln e| / sqrt(pi^2 + ln^2 e); sqrt(5) for e = 0
/// (Antypov & Elliott 2011).
#[must_use]
pub fn hertz_damping(restitution: f64) -> f64 {
    5.0f64.sqrt() * damping_ratio(restitution)
}

const DAMPING: Mixing = Mixing::Derived("the damping is mixed: harmonic mean of beta");

/// sqrt(5): beta over the fraction of critical damping (Antypov & Elliott 2011).
const BETA_PER_ZETA: f64 = 2.236_067_977_499_79;

impl PlannedNormal for Hertz {
    const KEYS: &'static LawKeys = &LawKeys {
        parts: &[LawPart::Normal],
        name: "hertz",
        text: "Hertz (1882) with viscous damping",
        keys: &[
            ELASTIC_KEYS[0],
            ELASTIC_KEYS[1],
            ELASTIC_KEYS[2],
            Key::new("restitution", "", Range::Fraction, "e").mixes(DAMPING),
            Key::new(
                "damping",
                "",
                Range::NonNegative,
                "beta in beta sqrt(m* k_n)",
            ),
        ],
        choices: &[ELASTIC_CHOICE, &[&["restitution"], &["damping"]]],
    };

    fn of_scene(pair: &mut Pair<'_>) -> Option<Self> {
        let (modulus, origin) = modulus_of(pair)?;
        pair.check_restitutions()?;
        let (restitutions, betas) = (pair.sides("restitution"), pair.sides("damping"));
        let sides = [0, 1].map(|i| restitutions[i].map(|e| beta_of(pair, e)).or(betas[i]));
        let replaced = pair.over("restitution").map(|e| beta_of(pair, e));
        let replaced = replaced.or(pair.over("damping"));
        let (beta, beta_origin) = pair.need("restitution", replaced, sides)?;

        pair.record("effective_modulus", modulus, origin);
        let restitution = restitution_of(pair, beta / BETA_PER_ZETA);
        pair.record("restitution", restitution, beta_origin.clone());
        pair.record("damping", beta, beta_origin);
        let mut law = Self::new(modulus, beta);
        law.clamp_tension = pair.conventions().clamp_tension;
        Some(law)
    }

    fn duration(&self, effective_mass: f64, effective_radius: f64, speed: f64) -> f64 {
        self.collision_time(effective_mass, effective_radius, speed)
    }

    /// At the overlap of the impact: tangent stiffness 2 E* a.
    fn stiffest(
        &self,
        effective_mass: f64,
        effective_radius: f64,
        speed: f64,
    ) -> (SpringAndDashpot, f64) {
        let overlap = self.largest_overlap(effective_mass, effective_radius, speed);
        let contact_radius = (effective_radius * overlap).sqrt();
        let secant = 4.0 / 3.0 * self.effective_modulus * contact_radius;
        let spring = SpringAndDashpot {
            stiffness: 2.0 * self.effective_modulus * contact_radius,
            dissipation: self.damping * (effective_mass * secant).sqrt(),
        };
        (spring, contact_radius)
    }

    fn beta(&self) -> Option<f64> {
        Some(self.damping)
    }

    fn examples(scale: &Scale) -> Vec<Self> {
        // The tangent stiffness is 2 E* sqrt(R* overlap).
        let modulus = 0.5 * scale.stiffness / (scale.radius * 0.1f64.sqrt());
        let law = Self::new(modulus, 0.5);
        let clamped = Self {
            clamp_tension: true,
            ..law
        };
        vec![law, clamped]
    }
}

/// beta of a restitution under the convention of the scene.
fn beta_of(pair: &Pair<'_>, restitution: f64) -> f64 {
    if pair.conventions().clamp_tension {
        BETA_PER_ZETA * damping_ratio_clamped(restitution)
    } else {
        hertz_damping(restitution)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damping_has_its_tabulated_values() {
        for (e, beta) in [(0.95, 0.03650378), (0.7, 0.25224736), (0.1, 1.32186284)] {
            assert!((hertz_damping(e) - beta).abs() < 5e-9);
        }
        assert!((hertz_damping(0.0) - 5.0f64.sqrt()).abs() < 1e-15);
    }
}
