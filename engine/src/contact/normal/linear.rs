//! The linear spring and dashpot.

use std::f64::consts::PI;

use mercury_common::scene::{Key, LawKeys, LawPart, LawValues, Mixing, Range};

use super::{Contact, NormalForce, NormalLaw};
use crate::contact::mixing::{Pair, damping_ratio_of, harmonic_mean, restitution_of};
use crate::contact::{PlannedNormal, Scale, SpringAndDashpot};
use crate::lanes::Real;

/// F_n = k overlap - gamma u_n (Cundall & Strack 1979), with gamma fixed or from the restitution.
///
/// With a damping ratio zeta, gamma = 2 zeta sqrt(m* k) for each contact, so that the restitution is the
/// same for every pair of masses.
///
/// ```
/// use mercury_engine::contact::Linear;
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
                libm::exp(-self.dissipation_at(effective_mass) * time / (2.0 * effective_mass))
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

    fn clamps_tension(&self) -> bool {
        self.clamp_tension
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
    let log = libm::log(restitution);
    log.abs() / libm::hypot(PI, log)
}

/// Restitution that a fraction of critical damping, zeta, gives when tensile forces are cut.
///
/// The contact then ends when the force, not the overlap, returns to zero (Schwager & Poeschel 2007), and
/// e(zeta) = exp(-zeta/s (pi - atan2(2 zeta s, 1 - 2 zeta^2))), s = sqrt(1 - zeta^2), which falls to exp(-2)
/// at zeta = 1 and goes on as exp(-zeta/s ln((zeta + s)/(zeta - s))), s = sqrt(zeta^2 - 1).
#[must_use]
pub fn restitution_clamped(zeta: f64) -> f64 {
    let squared = 1.0 - zeta * zeta;
    if squared.abs() < 1e-12 {
        libm::exp(-2.0)
    } else if squared > 0.0 {
        let s = squared.sqrt();
        libm::exp(-zeta / s * (PI - libm::atan2(2.0 * zeta * s, 1.0 - 2.0 * zeta * zeta)))
    } else {
        let s = (-squared).sqrt();
        libm::exp(-zeta / s * libm::log((zeta + s) / (zeta - s)))
    }
}

/// Fraction of critical damping that gives the restitution e in (0, 1] when tensile forces are cut: [`restitution_clamped`] inverted by bisection.
#[must_use]
pub fn damping_ratio_clamped(restitution: f64) -> f64 {
    if restitution >= 1.0 {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, 1.0);
    while restitution_clamped(high) > restitution && high < 1e8 {
        high *= 2.0;
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if restitution_clamped(middle) > restitution {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

const SETTER: Mixing = Mixing::Derived("the stiffness that follows is mixed");

impl PlannedNormal for Linear {
    const KEYS: &'static LawKeys = &LawKeys {
        parts: &[LawPart::Normal],
        name: "linear",
        text: "linear spring and dashpot",
        keys: &[
            Key::new("stiffness", "N/m", Range::Positive, "k"),
            Key::new("dissipation", "kg/s", Range::NonNegative, "gamma"),
            Key::new(
                "restitution",
                "",
                Range::Fraction,
                "e, at every effective mass",
            )
            .mixes(Mixing::Derived(
                "the damping is mixed: harmonic mean of zeta",
            )),
            Key::new(
                "collision_time",
                "s",
                Range::Positive,
                "duration of a collision of two spheres of `mass`",
            )
            .mixes(SETTER),
            Key::new("mass", "kg", Range::Positive, "mass of one sphere").mixes(SETTER),
        ],
        choices: &[
            &[&["stiffness"], &["collision_time", "mass", "restitution"]],
            &[&["restitution"], &["dissipation"]],
        ],
    };

    fn of_scene(pair: &mut Pair<'_>) -> Option<Self> {
        pair.check_restitutions()?;
        let over_setter = (
            pair.over("collision_time"),
            pair.over("restitution"),
            pair.over("mass"),
        );
        let collision = match over_setter {
            (Some(time), Some(e), Some(mass)) => Some(from_collision(pair, time, e, mass).0),
            _ => None,
        };
        let sides = pair.typed().map(|typed| HalfContact::of(pair, typed?));
        let over_stiffness = pair.over("stiffness").or(collision);
        let stiffnesses = sides.map(|side| side.map(|side| side.stiffness));
        let (stiffness, origin) = pair.need("stiffness", over_stiffness, stiffnesses)?;
        pair.record("stiffness", stiffness, origin);

        let contact = pair.contact_origin();
        let over = (pair.over("restitution"), pair.over("dissipation"));
        let (damping, origin) = match (over, sides) {
            ((Some(e), _), _) => (Damping::Ratio(damping_ratio_of(pair, e)), contact),
            ((_, Some(gamma)), _) => (Damping::Dissipation(gamma), contact),
            (_, [Some(a), Some(b)]) => (
                mix_damping(pair, a.damping, b.damping)?,
                pair.mixed_origin([true; 2]),
            ),
            (_, [Some(only), None]) => (only.damping, pair.mixed_origin([true, false])),
            (_, [None, Some(only)]) => (only.damping, pair.mixed_origin([false, true])),
            ((None, None), [None, None]) => {
                pair.need("restitution", None, [None, None])?;
                return None;
            }
        };
        let mut law = match damping {
            Damping::Ratio(zeta) => {
                let e = restitution_of(pair, zeta);
                pair.record("restitution", e, origin.clone());
                pair.record_derived("damping_ratio", "", zeta, origin);
                Self::with_damping_ratio(stiffness, zeta)
            }
            Damping::Dissipation(gamma) => {
                pair.record("dissipation", gamma, origin);
                Self::new(stiffness, gamma)
            }
        };
        law.clamp_tension = pair.conventions().clamp_tension;
        Some(law)
    }

    fn duration(&self, effective_mass: f64, _: f64, _: f64) -> f64 {
        let dissipation = self.dissipation_at(effective_mass);
        spring_duration(self.stiffness, dissipation, effective_mass)
    }

    fn stiffest(&self, effective_mass: f64, _: f64, _: f64) -> (SpringAndDashpot, f64) {
        let spring = SpringAndDashpot {
            stiffness: self.stiffness,
            dissipation: self.dissipation_at(effective_mass),
        };
        (spring, 0.0)
    }

    fn spring(&self) -> Option<f64> {
        Some(self.stiffness)
    }

    fn examples(scale: &Scale) -> Vec<Self> {
        let laws = [
            Self::new(scale.stiffness, 0.2 * scale.critical_dissipation()),
            Self::with_damping_ratio(scale.stiffness, 0.2),
        ];
        let clamped = |law| Self {
            clamp_tension: true,
            ..law
        };
        laws.into_iter().chain(laws.map(clamped)).collect()
    }
}

/// Duration (s) of a collision on a spring (N/m) with a dashpot (kg/s), for m* (kg): pi/sqrt(k/m* - (gamma/2m*)^2); overdamped:
/// that without damping.
pub(super) fn spring_duration(stiffness: f64, dissipation: f64, effective_mass: f64) -> f64 {
    let (squared, rate) = (
        stiffness / effective_mass,
        dissipation / (2.0 * effective_mass),
    );
    let radicand = squared - rate * rate;
    PI / (if radicand > 0.0 { radicand } else { squared }).sqrt()
}

/// Spring and damping of a material with itself.
#[derive(Clone, Copy)]
struct HalfContact {
    stiffness: f64,
    damping: Damping,
}

#[derive(Clone, Copy, PartialEq)]
enum Damping {
    /// zeta.
    Ratio(f64),
    /// gamma, kg/s.
    Dissipation(f64),
}

impl HalfContact {
    fn of(pair: &Pair<'_>, typed: &LawValues) -> Option<Self> {
        let restitution = typed.number("restitution");
        if let Some(time) = typed.number("collision_time") {
            let (stiffness, zeta) = from_collision(pair, time, restitution?, typed.number("mass")?);
            return Some(Self {
                stiffness,
                damping: Damping::Ratio(zeta),
            });
        }
        let damping = match restitution {
            Some(e) => Damping::Ratio(damping_ratio_of(pair, e)),
            None => Damping::Dissipation(typed.number("dissipation")?),
        };
        Some(Self {
            stiffness: typed.number("stiffness")?,
            damping,
        })
    }
}

/// k of two bodies of mass `mass` (kg) that collide in `time` (s) with this restitution, and zeta.
///
/// e = exp(-zeta w0 t_c) whether tension is cut or not, so w0 = |ln e|/(zeta t_c), and k = m* w0^2. Without damping, and
/// for e = 0 (critical, where no time is finite), w0 = pi/t_c.
fn from_collision(pair: &Pair<'_>, time: f64, e: f64, mass: f64) -> (f64, f64) {
    let zeta = damping_ratio_of(pair, e);
    let frequency = if zeta == 0.0 || e == 0.0 {
        PI / time
    } else {
        libm::log(e).abs() / (zeta * time)
    };
    (0.5 * mass * frequency * frequency, zeta)
}

/// The mean of two dampings of one kind; no damping on either side means none.
fn mix_damping(pair: &mut Pair<'_>, a: Damping, b: Damping) -> Option<Damping> {
    use Damping::{Dissipation, Ratio};
    match (a, b) {
        (Ratio(a), Ratio(b)) => Some(Ratio(harmonic_mean(a, b))),
        (Dissipation(a), Dissipation(b)) => Some(Dissipation(harmonic_mean(a, b))),
        (Ratio(none), Dissipation(_)) | (Dissipation(_), Ratio(none)) if none == 0.0 => {
            Some(Ratio(0.0))
        }
        (Ratio(_), Dissipation(none)) | (Dissipation(none), Ratio(_)) if none == 0.0 => {
            Some(Dissipation(0.0))
        }
        _ => {
            let message = format!(
                "the damping of the contacts of {} is ambiguous: one material has a restitution, the other a dissipation",
                pair.name()
            );
            let help = pair.entry("normal = { restitution = ... }");
            pair.error(message, help);
            None
        }
    }
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

    /// Bits that every processor gives, whatever the mathematics library of its system.
    #[test]
    fn bits_of_damping_are_frozen() {
        let mix = |sum: u64, number: f64| sum.rotate_left(5).wrapping_add(number.to_bits());
        let sums = (1..1000).fold([0; 2], |[plain, clamped], k| {
            let e = f64::from(k) / 1000.0;
            [
                mix(plain, damping_ratio(e)),
                mix(clamped, damping_ratio_clamped(e)),
            ]
        });
        assert_eq!(sums, [0x2e15_5710_fefc_ff90, 0xfc6c_36bc_17cd_1adf]);
    }
}
