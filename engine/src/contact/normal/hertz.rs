//! Hertz' law with the damping that makes the restitution independent of the velocity.

use std::f64::consts::PI;

use mercury_common::scene::{Key, LawKeys, Mixing, Part, Range};

use super::super::normal::linear::{damping_ratio, damping_ratio_clamped};
use super::{Contact, NormalForce, NormalLaw};
use crate::contact::mixing::{Pair, restitution_of};
use crate::contact::{PlannedNormal, SpringAndDashpot};
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

/// E* of two materials given as (E, nu): 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2, Pa.
#[must_use]
pub fn effective_modulus(one: (f64, f64), other: (f64, f64)) -> f64 {
    1.0 / ((1.0 - one.1 * one.1) / one.0 + (1.0 - other.1 * other.1) / other.0)
}

/// G* of two materials given as (E, nu): 1/G* = (2 - nu1)/G1 + (2 - nu2)/G2, G = E/(2 (1 + nu)), Pa.
#[must_use]
pub fn effective_shear_modulus(one: (f64, f64), other: (f64, f64)) -> f64 {
    let compliance = |(e, nu): (f64, f64)| (2.0 - nu) * 2.0 * (1.0 + nu) / e;
    1.0 / (compliance(one) + compliance(other))
}

/// Rayleigh time of a sphere (s), pi R sqrt(rho/G) / (0.1631 nu + 0.8766) (Thornton 2015): how long a
/// surface wave needs round half of it.
#[must_use]
pub fn rayleigh_time(radius: f64, density: f64, youngs_modulus: f64, poisson_ratio: f64) -> f64 {
    let shear_modulus = youngs_modulus / (2.0 * (1.0 + poisson_ratio));
    PI * radius * (density / shear_modulus).sqrt() / (0.1631 * poisson_ratio + 0.8766)
}

const ELASTIC: Mixing = Mixing::Derived("by the elasticity of the two bodies");
const DAMPING: Mixing = Mixing::Derived("the damping is mixed: harmonic mean of beta");

/// sqrt(5): beta over the fraction of critical damping (Antypov & Elliott 2011).
const BETA_PER_ZETA: f64 = 2.236_067_977_499_79;

impl PlannedNormal for Hertz {
    const KEYS: &'static LawKeys = &LawKeys {
        parts: &[Part::Normal],
        name: "hertz",
        text: "Hertz (1882) with viscous damping",
        keys: &[
            Key::new("youngs_modulus", "Pa", Range::Positive, "E").mixes(ELASTIC),
            Key::new("poisson_ratio", "", Range::PoissonRatio, "nu").mixes(ELASTIC),
            Key::new(
                "effective_modulus",
                "Pa",
                Range::Positive,
                "E* of the material with itself",
            )
            .mixes(ELASTIC),
            Key::new("restitution", "", Range::Fraction, "e").mixes(DAMPING),
            Key::new(
                "damping",
                "",
                Range::NonNegative,
                "beta in beta sqrt(m* k_n)",
            ),
        ],
        choices: &[
            &[&["youngs_modulus", "poisson_ratio"], &["effective_modulus"]],
            &[&["restitution"], &["damping"]],
        ],
    };

    fn of_scene(pair: &mut Pair<'_>) -> Option<Self> {
        let (over_e, over_nu) = (pair.over("youngs_modulus"), pair.over("poisson_ratio"));
        let constants = pair.elastic_constants();
        let typed = pair.sides("effective_modulus");
        let like_like = [0, 1]
            .map(|i| typed[i].or_else(|| constants[i].map(|one| effective_modulus(one, one))));
        let exact = match elastic_pair(constants, over_e, over_nu) {
            Some([a, b]) => Some(effective_modulus(a, b)),
            None if over_e.is_some() || over_nu.is_some() => {
                let message = format!(
                    "E* of the contacts of {} is incomplete: youngs_modulus and poisson_ratio go together",
                    pair.name()
                );
                pair.error(message, "give both, or effective_modulus".to_owned());
                return None;
            }
            None => None,
        };
        let (modulus, origin) = match (pair.over("effective_modulus"), exact) {
            (None, Some(exact)) if over_e.is_some() || over_nu.is_some() => {
                (exact, pair.contact_origin())
            }
            (None, Some(exact)) => (exact, pair.mixed_origin(constants.map(|c| c.is_some()))),
            (modulus, _) => pair.need("effective_modulus", modulus, like_like)?,
        };

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
}

/// beta of a restitution under the convention of the scene.
fn beta_of(pair: &Pair<'_>, restitution: f64) -> f64 {
    if pair.conventions().clamp_tension {
        BETA_PER_ZETA * damping_ratio_clamped(restitution)
    } else {
        hertz_damping(restitution)
    }
}

/// (E, nu) of both bodies: what is replaced counts for both; a body without constants is like the other one.
pub(crate) fn elastic_pair(
    sides: [Option<(f64, f64)>; 2],
    over_e: Option<f64>,
    over_nu: Option<f64>,
) -> Option<[(f64, f64); 2]> {
    let side = |own: Option<(f64, f64)>| {
        let e = over_e.or(own.map(|c| c.0))?;
        Some((e, over_nu.or(own.map(|c| c.1))?))
    };
    match sides.map(side) {
        [Some(a), Some(b)] => Some([a, b]),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moduli_mix_as_the_theory_says() {
        // contact-model case T18
        let (soft, steel) = ((1e7, 0.3), (210e9, 0.25));
        assert!((effective_modulus(soft, steel) / 10988471.91562423 - 1.0).abs() < 1e-14);
        assert!((effective_shear_modulus(soft, steel) / 2262336.80539190 - 1.0).abs() < 1e-14);
        assert!((effective_shear_modulus(soft, soft) / 1131221.719457014 - 1.0).abs() < 1e-14);
        // the harmonic mean of the like-like moduli is the same thing
        let mean = |a: f64, b: f64| 2.0 / (1.0 / a + 1.0 / b);
        let like = mean(
            effective_modulus(soft, soft),
            effective_modulus(steel, steel),
        );
        assert!((like / effective_modulus(soft, steel) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn damping_and_rayleigh_time_have_their_tabulated_values() {
        for (e, beta) in [(0.95, 0.03650378), (0.7, 0.25224736), (0.1, 1.32186284)] {
            assert!((hertz_damping(e) - beta).abs() < 5e-9);
        }
        assert!((hertz_damping(0.0) - 5.0f64.sqrt()).abs() < 1e-15);
        let time = rayleigh_time(5e-3, 2500.0, 1e7, 0.3);
        assert!((time / 4.326991627612e-4 - 1.0).abs() < 1e-12);
    }
}
