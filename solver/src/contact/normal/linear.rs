//! The linear spring and dashpot.

use std::f64::consts::PI;

use super::{Contact, NormalForce, NormalLaw};
use crate::lanes::Real;

/// F_n = k overlap - gamma u_n (Cundall & Strack 1979), with gamma fixed or from the restitution.
///
/// With a damping ratio zeta, gamma = 2 zeta sqrt(m* k) for each contact, so that the restitution is the
/// same for every pair of masses.
///
/// ```
/// use mercury_solver::contact::Linear;
/// // 1 kg spheres that collide in 0.02 s with restitution 0.7: m* = 1/2 kg
/// let law = Linear::new(12496.02677090382, 17.83374719693662);
/// assert!((law.collision_time(0.5).unwrap() - 0.02).abs() < 1e-12);
/// assert!((law.restitution(0.5) - 0.7).abs() < 1e-12);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Linear {
    /// k, N/m.
    pub stiffness: f64,
    /// The part of gamma that does not depend on the masses, kg/s.
    pub dissipation: f64,
    /// zeta, the fraction of critical damping.
    pub damping_ratio: f64,
    /// 2 zeta sqrt(k), so that gamma = `dissipation` + `damping` sqrt(m*).
    damping: f64,
    /// Cut tensile forces.
    pub clamp_tension: bool,
}

impl Linear {
    /// A spring k (N/m) with a dashpot gamma (kg/s).
    #[must_use]
    pub fn new(stiffness: f64, dissipation: f64) -> Self {
        Self {
            stiffness,
            dissipation,
            damping_ratio: 0.0,
            damping: 0.0,
            clamp_tension: false,
        }
    }

    /// A spring k (N/m) with a fraction zeta of critical damping, for every pair of masses.
    #[must_use]
    pub fn with_damping_ratio(stiffness: f64, damping_ratio: f64) -> Self {
        Self {
            stiffness,
            dissipation: 0.0,
            damping_ratio,
            damping: 2.0 * damping_ratio * stiffness.sqrt(),
            clamp_tension: false,
        }
    }

    /// gamma for an effective mass m* (kg), kg/s.
    #[inline(always)]
    #[must_use]
    pub fn dissipation_at<L: Real>(&self, effective_mass: L) -> L {
        if self.damping == 0.0 {
            L::splat(self.dissipation)
        } else {
            effective_mass.sqrt() * self.damping + self.dissipation
        }
    }

    /// Duration of a collision of two bodies of effective mass m* (kg), s; `None` if overdamped.
    #[must_use]
    pub fn collision_time(&self, effective_mass: f64) -> Option<f64> {
        let rate = self.dissipation_at(effective_mass) / (2.0 * effective_mass);
        let radicand = self.stiffness / effective_mass - rate * rate;
        (radicand > 0.0).then(|| PI / radicand.sqrt())
    }

    /// Restitution of a collision, tension not clamped: e = exp(-gamma t_c / (2 m*)); 0 if overdamped.
    #[must_use]
    pub fn restitution(&self, effective_mass: f64) -> f64 {
        match self.collision_time(effective_mass) {
            Some(time) => {
                (-self.dissipation_at(effective_mass) * time / (2.0 * effective_mass)).exp()
            }
            None => 0.0,
        }
    }
}

impl NormalLaw for Linear {
    type History<L: Real> = ();

    fn name(&self) -> &'static str {
        "linear"
    }

    #[inline(always)]
    fn force<L: Real>(&self, contact: &Contact<L>, (): &mut ()) -> NormalForce<L> {
        let force = NormalForce {
            elastic: contact.overlap * self.stiffness,
            viscous: -self.dissipation_at(contact.effective_mass) * contact.normal_velocity,
        };
        if self.clamp_tension {
            force.clamped()
        } else {
            force
        }
    }

    #[inline(always)]
    fn energy<L: Real>(&self, contact: &Contact<L>, (): &()) -> L {
        contact.overlap * (0.5 * self.stiffness) * contact.overlap
    }
}

/// Fraction of critical damping for a restitution e in [0, 1]: |ln e| / sqrt(pi^2 + ln^2 e); 1 for e = 0.
#[must_use]
pub fn damping_ratio(restitution: f64) -> f64 {
    if restitution <= 0.0 {
        return 1.0;
    }
    let log = restitution.ln();
    log.abs() / PI.hypot(log)
}

/// Fraction of critical damping that gives the restitution e in (0, 1] when tensile forces are cut.
///
/// The contact then ends when the force, not the overlap, returns to zero (Schwager & Poeschel 2007), and
/// e(zeta) = exp(-zeta/s (pi - atan2(2 zeta s, 1 - 2 zeta^2))), s = sqrt(1 - zeta^2), which falls to exp(-2)
/// at zeta = 1 and goes on as exp(-zeta/s ln((zeta + s)/(zeta - s))), s = sqrt(zeta^2 - 1). Inverted by bisection.
#[must_use]
pub fn damping_ratio_clamped(restitution: f64) -> f64 {
    if restitution >= 1.0 {
        return 0.0;
    }
    let clamped = |zeta: f64| -> f64 {
        let squared = 1.0 - zeta * zeta;
        if squared.abs() < 1e-12 {
            (-2.0f64).exp()
        } else if squared > 0.0 {
            let s = squared.sqrt();
            (-zeta / s * (PI - (2.0 * zeta * s).atan2(1.0 - 2.0 * zeta * zeta))).exp()
        } else {
            let s = (-squared).sqrt();
            (-zeta / s * ((zeta + s) / (zeta - s)).ln()).exp()
        }
    };
    let (mut low, mut high) = (0.0, 1.0);
    while clamped(high) > restitution && high < 1e8 {
        high *= 2.0;
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if clamped(middle) > restitution {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clamped_restitutions_match_the_published_inverse() {
        // contact-model case T6: true e -> nominal e of the unclamped law
        for (e, nominal) in [
            (0.9, 0.8978874399),
            (0.7, 0.6791937155),
            (0.5, 0.4362877627),
            (0.3, 0.1652189766),
        ] {
            let zeta = damping_ratio_clamped(e);
            assert!(
                (zeta - damping_ratio(nominal)).abs() < 1e-9,
                "e = {e}: zeta = {zeta}"
            );
        }
    }

    #[test]
    fn setters_give_the_collision_they_promise_for_every_pair_of_masses() {
        let zeta = damping_ratio(0.7);
        assert!((zeta - 0.1128084506936).abs() < 1e-12);
        let law = Linear::with_damping_ratio(1e4, zeta);
        for mass in [1e-9, 0.5, 3e4] {
            assert!((law.restitution(mass) - 0.7).abs() < 1e-12);
        }
        // T1: the same constant gamma with 1 kg and 3 kg
        let law = Linear::new(12496.02677090382, 17.83374719693662);
        let mass = 1.0 / (1.0 + 1.0 / 3.0);
        assert!((law.collision_time(mass).unwrap() - 0.0244424440946).abs() < 1e-12);
        assert!((law.restitution(mass) - 0.7478145602066).abs() < 1e-12);
    }
}
