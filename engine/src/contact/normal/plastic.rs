//! The hysteretic spring of elasto-plastic, cohesive contacts.

use mercury_common::scene::{Key, LawKeys, LawPart, Range};

use super::super::{History, HistoryNumber};
use super::linear::spring_duration;
use super::{Contact, NormalForce, NormalLaw};
use crate::contact::mixing::Pair;
use crate::contact::{PlannedNormal, Scale, SpringAndDashpot};
use crate::lanes::{Mask, Real};

/// Loading along k1, unloading along a stiffness that grows with the largest overlap so far, cohesion along
/// -kc overlap (Luding 2008, eqs. 5-7, and Fig. 1), and a dashpot gamma u_n beside it.
///
/// With delta* = k2max/(k2max - k1) phi_f 2R* and the largest overlap delta_m <= delta*:
/// k2 = k1 + (k2max - k1) delta_m/delta*, delta_0 = (1 - k1/k2) delta_m,
/// f = max(k2 (delta - delta_0), -kc delta); where the cohesive branch is reached, delta_m shrinks with it.
/// phi_f = 0, which makes delta* zero, is the limit of fully plastic unloading: k2 = k2max from the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plastic {
    /// k1, N/m.
    pub loading_stiffness: f64,
    /// k2max >= k1, N/m.
    pub unloading_stiffness: f64,
    /// kc, N/m.
    pub cohesion_stiffness: f64,
    /// phi_f, fraction of 2R*.
    pub penetration_depth: f64,
    /// gamma, kg/s.
    pub dissipation: f64,
    /// Cut tension of the dashpot (cohesion stays).
    pub clamp_tension: bool,
}

/// The largest overlap so far, as far as the cohesive branch has not taken it back, m.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MaxOverlap<L = f64>(pub L);

impl<L: Real> History<L> for MaxOverlap<L> {
    type One = MaxOverlap;
    const LENGTH: usize = 1;

    fn columns() -> Vec<HistoryNumber> {
        vec![("m", "largest overlap so far")]
    }

    fn swapped(self) -> Self {
        self
    }

    fn write(&self, numbers: &mut Vec<L>) {
        numbers.push(self.0);
    }

    fn read(numbers: &[L]) -> Self {
        Self(numbers[0])
    }

    #[inline(always)]
    fn gather(one: impl Fn(usize) -> MaxOverlap) -> Self {
        Self(L::from_lanes(|k| one(k).0))
    }

    #[inline(always)]
    fn lane(&self, k: usize) -> MaxOverlap {
        MaxOverlap(self.0.lane(k))
    }
}

impl Plastic {
    /// k2 and delta_0 for a largest overlap (m).
    #[inline(always)]
    fn unloading<L: Real>(&self, max_overlap: L, limit: L) -> (L, L) {
        let (k1, k2_max) = (self.loading_stiffness, self.unloading_stiffness);
        // A limit of zero or infinity stands for "at once" and "never" (phi_f = 0, k1 = k2max).
        let some = L::ZERO.below(limit);
        let mut share = L::ONE;
        if some.any() {
            share = L::select(some, (max_overlap / limit).min(L::ONE), share);
        }
        let k2 = share * (k2_max - k1) + k1;
        (k2, (L::ONE - L::splat(k1) / k2) * max_overlap)
    }

    /// delta*, the overlap beyond which unloading is elastic along k2max, m.
    #[inline(always)]
    fn limit<L: Real>(&self, effective_radius: L) -> L {
        let (k1, k2_max) = (self.loading_stiffness, self.unloading_stiffness);
        if k2_max > k1 {
            effective_radius * (k2_max / (k2_max - k1) * self.penetration_depth * 2.0)
        } else {
            L::splat(f64::INFINITY)
        }
    }
}

impl NormalLaw for Plastic {
    type History<L: Real> = MaxOverlap<L>;

    fn name(&self) -> &'static str {
        "plastic"
    }

    #[inline(always)]
    fn force<L: Real>(&self, contact: &Contact<L>, history: &mut MaxOverlap<L>) -> NormalForce<L> {
        let overlap = contact.overlap;
        let limit = self.limit(contact.effective_radius);
        let loading = history.0.below(overlap);
        if loading.any() {
            // With phi_f = 0 there is no plastic branch to follow: loading is along k2max from the start.
            history.0 = L::select(loading, overlap.min(limit), history.0);
        }
        let (k2, rest) = self.unloading(history.0, limit);
        let mut elastic = k2 * (overlap - rest);
        let cohesion = overlap * -self.cohesion_stiffness;
        let pulled = elastic.below(cohesion);
        if pulled.any() {
            elastic = L::select(pulled, cohesion, elastic);
            let max_overlap =
                (k2 + self.cohesion_stiffness) / (k2 - self.loading_stiffness) * overlap;
            history.0 = L::select(pulled, max_overlap, history.0);
        }
        let viscous = contact.normal_velocity * -self.dissipation;
        if self.clamp_tension {
            NormalForce {
                elastic,
                viscous: viscous.max(-elastic.max(L::ZERO)),
            }
        } else {
            NormalForce { elastic, viscous }
        }
    }

    fn is_elastic(&self) -> bool {
        false
    }

    fn clamps_tension(&self) -> bool {
        self.clamp_tension
    }

    /// k2 (overlap - delta_0)^2 / 2 where that is compressed, else 0.
    fn energy<L: Real>(&self, contact: &Contact<L>, history: &MaxOverlap<L>) -> L {
        let (k2, rest) = self.unloading(history.0, self.limit(contact.effective_radius));
        let spring = (contact.overlap - rest).max(L::ZERO);
        k2 * 0.5 * spring * spring
    }
}

impl PlannedNormal for Plastic {
    const KEYS: &'static LawKeys = &LawKeys {
        parts: &[LawPart::Normal],
        name: "plastic",
        text: "hysteretic and adhesive: Luding (2008)",
        keys: &[
            Key::new(
                "loading_stiffness",
                "N/m",
                Range::Positive,
                "k1, of first loading",
            ),
            Key::new(
                "unloading_stiffness",
                "N/m",
                Range::NotBelow("loading_stiffness"),
                "k2, of unloading from the plastic limit",
            ),
            Key::new(
                "cohesion_stiffness",
                "N/m",
                Range::NonNegative,
                "kc, of the tensile branch",
            ),
            Key::new(
                "penetration_depth",
                "",
                Range::Fraction,
                "phi_f, overlap of the plastic limit over 2R*",
            ),
            Key::new("dissipation", "kg/s", Range::NonNegative, "gamma").or(0.0),
        ],
        choices: &[],
    };

    fn of_scene(pair: &mut Pair<'_>) -> Option<Self> {
        let [k1, k2, kc, phi, gamma] = pair.numbers([
            "loading_stiffness",
            "unloading_stiffness",
            "cohesion_stiffness",
            "penetration_depth",
            "dissipation",
        ])?;
        if k2 < k1 {
            let message = format!(
                "unloading_stiffness = {k2} of the contacts of {} lies below loading_stiffness = {k1}",
                pair.name()
            );
            pair.error(message, "replace both".to_owned());
            return None;
        }
        Some(Self {
            loading_stiffness: k1,
            unloading_stiffness: k2,
            cohesion_stiffness: kc,
            penetration_depth: phi,
            dissipation: gamma,
            clamp_tension: pair.conventions().clamp_tension,
        })
    }

    /// With k2max, its stiffest branch.
    fn duration(&self, effective_mass: f64, _: f64, _: f64) -> f64 {
        spring_duration(self.unloading_stiffness, self.dissipation, effective_mass)
    }

    fn stiffest(&self, _: f64, _: f64, _: f64) -> (SpringAndDashpot, f64) {
        let spring = SpringAndDashpot {
            stiffness: self.unloading_stiffness,
            dissipation: self.dissipation,
        };
        (spring, 0.0)
    }

    fn spring(&self) -> Option<f64> {
        Some(self.loading_stiffness)
    }

    fn examples(scale: &Scale) -> Vec<Self> {
        let law = Self {
            loading_stiffness: 0.5 * scale.stiffness,
            unloading_stiffness: scale.stiffness,
            cohesion_stiffness: 0.2 * scale.stiffness,
            penetration_depth: 0.05,
            dissipation: 0.05 * scale.critical_dissipation(),
            clamp_tension: false,
        };
        let clamped = Self {
            clamp_tension: true,
            ..law
        };
        // They unload along k2max at once, and never.
        let at_once = Self {
            penetration_depth: 0.0,
            ..law
        };
        let never = Self {
            unloading_stiffness: law.loading_stiffness,
            ..law
        };
        vec![law, clamped, at_once, never]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Vector;

    fn law() -> Plastic {
        Plastic {
            loading_stiffness: 1e4,
            unloading_stiffness: 2e4,
            cohesion_stiffness: 5e3,
            penetration_depth: 0.05,
            dissipation: 0.0,
            clamp_tension: false,
        }
    }

    fn force(law: &Plastic, overlap: f64, history: &mut MaxOverlap) -> f64 {
        let contact = Contact {
            normal: Vector::X,
            distance: 1.0 - overlap,
            overlap,
            effective_radius: 0.25,
            effective_mass: 0.5,
            normal_velocity: 0.0,
            tangential_velocity: Vector::ZERO,
            sliding_normal: Vector::X,
            sliding_distance: 1.0 - overlap,
            centre_velocity: Vector::ZERO,
            spin: Vector::ZERO,
        };
        law.force(&contact, history).total()
    }

    #[test]
    fn follows_the_branches_of_case_t3() {
        let law = law();
        let mut history = MaxOverlap::default();
        assert!((force(&law, 0.02, &mut history) - 200.0).abs() < 1e-10);
        assert!((force(&law, 0.018, &mut history) - 172.0).abs() < 1e-10);
        // the branches meet at (k2 - k1)/(k2 + kc) delta_m = 4000/19000 0.02
        let least = 4000.0 / 19000.0 * 0.02;
        assert!((force(&law, least, &mut history) + 5e3 * least).abs() < 1e-10);
        assert!((5e3 * least - 21.0526315789).abs() < 1e-9);
        // beyond delta* = 0.05 the spring is k2max (delta - 0.025)
        let mut history = MaxOverlap::default();
        assert!((force(&law, 0.08, &mut history) - 1100.0).abs() < 1e-10);
    }

    #[test]
    fn degenerate_parameters_stay_finite() {
        let elastic = Plastic {
            unloading_stiffness: 1e4,
            ..law()
        };
        let mut history = MaxOverlap::default();
        assert!((force(&elastic, 0.02, &mut history) - 200.0).abs() < 1e-10);
        assert!((force(&elastic, 0.01, &mut history) - 100.0).abs() < 1e-10);
        let hard = Plastic {
            penetration_depth: 0.0,
            ..law()
        };
        let mut history = MaxOverlap::default();
        assert!((force(&hard, 0.02, &mut history) - 400.0).abs() < 1e-10);
        assert!((force(&hard, 0.01, &mut history) - 200.0).abs() < 1e-10);
    }
}
