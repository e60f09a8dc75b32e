//! Dry cohesion: attraction of two bodies without liquid.

use super::{History, Kinematics, Normal};
use crate::closed_forms::{Jkr, VanDerWaals};

/// A law of dry cohesion.
#[derive(Debug, Clone, Copy, Default)]
pub enum Cohesion {
    /// The bodies do not stick.
    #[default]
    None,
    /// A neck joins the bodies from the touch on (Johnson, Kendall & Roberts 1971). Its force takes the place of Hertz' elastic force.
    Jkr {
        /// W \[J/m²\].
        work: f64,
        /// E* \[Pa\].
        modulus: f64,
    },
    /// Constant in contact, linear over the gap: the sum of two branches.
    Linear {
        /// The branches.
        branches: [Branch; 2],
        /// True: it acts over the gap only after a touch.
        after_touch: bool,
    },
    /// Attraction of two spheres (Hamaker 1937), moved so that it ends at zero.
    VanDerWaals {
        /// Hamaker's constant A \[J\].
        hamaker: f64,
        /// Least separation z₀ \[m\].
        separation: f64,
        /// Gap beyond which nothing acts \[m\].
        range: f64,
    },
}

/// A pull of f = force + per_radius R* in contact, and of max(0, f − fall s) over a gap s.
#[derive(Debug, Clone, Copy)]
pub struct Branch {
    /// Part of f that all sizes share \[N\].
    pub force: f64,
    /// Part of f that grows with R* \[N/m\].
    pub per_radius: f64,
    /// Slope over the gap \[N/m\]; infinite: nothing acts there.
    pub fall: f64,
    /// 1 attracts, −1 repels.
    pub sign: f64,
}

impl Branch {
    fn pull(&self, gap: f64, effective_radius: f64) -> f64 {
        let most = self.force + self.per_radius * effective_radius;
        if gap <= 0.0 {
            return self.sign * most;
        }
        if self.fall.is_infinite() {
            return 0.0;
        }
        self.sign * (most - self.fall * gap).max(0.0)
    }

    fn end(&self, effective_radius: f64) -> f64 {
        (self.force + self.per_radius * effective_radius) / self.fall
    }
}

impl Cohesion {
    fn neck(work: f64, modulus: f64, kinematics: &Kinematics) -> Jkr {
        Jkr {
            work,
            radius: kinematics.effective_radius,
            modulus,
        }
    }

    /// Gap within which it may act between bodies of this R* \[m\].
    pub fn reach(&self, effective_radius: f64) -> f64 {
        match *self {
            Cohesion::None => 0.0,
            Cohesion::Jkr { work, modulus } => Jkr {
                work,
                radius: effective_radius,
                modulus,
            }
            .longest_gap(),
            Cohesion::Linear { branches, .. } => {
                let ends = branches.map(|branch| branch.end(effective_radius));
                ends[0].max(ends[1])
            }
            Cohesion::VanDerWaals { range, .. } => range,
        }
    }

    /// Whether it acts on two that do not overlap.
    pub fn acts_apart(&self, kinematics: &Kinematics, history: &History) -> bool {
        let within = -kinematics.overlap < self.reach(kinematics.effective_radius);
        let begins_with_a_touch = matches!(
            self,
            Cohesion::None
                | Cohesion::Jkr { .. }
                | Cohesion::Linear {
                    after_touch: true,
                    ..
                }
        );
        within && (history.touched || !begins_with_a_touch)
    }

    /// Radius of the neck of two that touch \[m\]; `None` for laws that pull beside the normal force.
    pub(super) fn neck_radius(&self, kinematics: &Kinematics) -> Option<f64> {
        match *self {
            Cohesion::Jkr { work, modulus } => {
                Self::neck(work, modulus, kinematics).radius_at(kinematics.overlap)
            }
            _ => None,
        }
    }

    /// Normal force of a neck of radius `a`, friction's load and the energy \[N, N, J\]: the dashpot is that of Hertz' contact with this radius.
    pub(super) fn joined(
        &self,
        a: f64,
        normal: &Normal,
        kinematics: &Kinematics,
    ) -> (f64, f64, f64) {
        let (Cohesion::Jkr { work, modulus }, Normal::Hertz { damping, .. }) = (*self, *normal)
        else {
            panic!("a neck needs Hertz' law");
        };
        let neck = Self::neck(work, modulus, kinematics);
        let dashpot = damping * (kinematics.effective_mass * 4.0 / 3.0 * modulus * a).sqrt();
        let force = neck.force(a) - dashpot * kinematics.normal_velocity();
        // Thornton 1991.
        let load = force + 2.0 * neck.pull_off();
        (force, load, neck.energy(a))
    }

    /// Pull \[N\] of laws that act beside the normal force, and their energy \[J\].
    pub(super) fn pull(&self, kinematics: &Kinematics) -> (f64, f64) {
        let (gap, radius) = (-kinematics.overlap, kinematics.effective_radius);
        match *self {
            Cohesion::None | Cohesion::Jkr { .. } => (0.0, 0.0),
            Cohesion::Linear { branches, .. } => {
                let mut sum = (0.0, 0.0);
                for branch in branches {
                    let pull = branch.pull(gap, radius);
                    let at_touch = branch.pull(gap.max(0.0), radius);
                    // Work over the rest of the gap, a triangle, and in contact that of the constant pull.
                    let rest = branch.end(radius) - gap.max(0.0);
                    let in_gap = 0.5 * at_touch * rest.max(0.0);
                    sum.0 += pull;
                    sum.1 -= in_gap + pull * (-gap).max(0.0);
                }
                sum
            }
            Cohesion::VanDerWaals {
                hamaker,
                separation,
                range,
            } => {
                let law = VanDerWaals {
                    hamaker,
                    separation,
                    range,
                    radius,
                };
                let pull = law.pull(gap);
                let energy = law.work_from(gap.clamp(0.0, range)) + pull * (-gap).max(0.0);
                (pull, -energy)
            }
        }
    }
}
