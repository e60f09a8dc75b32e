//! The hysteretic spring of elasto-plastic, cohesive contacts.

use super::super::{History, HistoryNumber};
use super::{Contact, NormalForce, NormalLaw};

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
pub struct MaxOverlap(pub f64);

impl History for MaxOverlap {
    const LENGTH: usize = 1;

    fn columns() -> Vec<HistoryNumber> {
        vec![("m", "largest overlap so far")]
    }

    fn swapped(self) -> Self {
        self
    }

    fn write(&self, numbers: &mut Vec<f64>) {
        numbers.push(self.0);
    }

    fn read(numbers: &[f64]) -> Self {
        Self(numbers[0])
    }
}

impl Plastic {
    /// k2 and delta_0 for a largest overlap (m).
    #[inline(always)]
    fn unloading(&self, max_overlap: f64, limit: f64) -> (f64, f64) {
        let (k1, k2_max) = (self.loading_stiffness, self.unloading_stiffness);
        // A limit of zero or infinity stands for "at once" and "never" (phi_f = 0, k1 = k2max).
        let share = if limit > 0.0 {
            (max_overlap / limit).min(1.0)
        } else {
            1.0
        };
        let k2 = k1 + (k2_max - k1) * share;
        (k2, (1.0 - k1 / k2) * max_overlap)
    }

    /// delta*, the overlap beyond which unloading is elastic along k2max, m.
    #[inline(always)]
    fn limit(&self, effective_radius: f64) -> f64 {
        let (k1, k2_max) = (self.loading_stiffness, self.unloading_stiffness);
        if k2_max > k1 {
            k2_max / (k2_max - k1) * self.penetration_depth * 2.0 * effective_radius
        } else {
            f64::INFINITY
        }
    }
}

impl NormalLaw for Plastic {
    type History = MaxOverlap;

    #[inline(always)]
    fn force(&self, contact: &Contact, history: &mut MaxOverlap) -> NormalForce {
        let overlap = contact.overlap;
        let limit = self.limit(contact.effective_radius);
        if overlap > history.0 {
            // With phi_f = 0 there is no plastic branch to follow: loading is along k2max from the start.
            history.0 = overlap.min(limit);
        }
        let (k2, rest) = self.unloading(history.0, limit);
        let mut elastic = k2 * (overlap - rest);
        let cohesion = -self.cohesion_stiffness * overlap;
        if elastic < cohesion {
            elastic = cohesion;
            history.0 = (k2 + self.cohesion_stiffness) / (k2 - self.loading_stiffness) * overlap;
        }
        let viscous = -self.dissipation * contact.normal_velocity;
        if self.clamp_tension {
            NormalForce {
                elastic,
                viscous: viscous.max(-elastic.max(0.0)),
            }
        } else {
            NormalForce { elastic, viscous }
        }
    }

    /// k2 (overlap - delta_0)^2 / 2 where that is compressed, else 0.
    fn energy(&self, contact: &Contact, history: &MaxOverlap) -> f64 {
        let (k2, rest) = self.unloading(history.0, self.limit(contact.effective_radius));
        let spring = (contact.overlap - rest).max(0.0);
        0.5 * k2 * spring * spring
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

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
            normal: DVec3::X,
            distance: 1.0 - overlap,
            overlap,
            effective_radius: 0.25,
            effective_mass: 0.5,
            normal_velocity: 0.0,
            tangential_velocity: DVec3::ZERO,
            centre_velocity: DVec3::ZERO,
            spin: DVec3::ZERO,
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
