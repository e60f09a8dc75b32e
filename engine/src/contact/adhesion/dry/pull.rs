//! Forces that are constant in contact and fall linearly over a gap.

use super::super::{AdhesionForce, Contact, NormalForce};
use super::Held;
use crate::lanes::{Mask, Real};

/// F = −f in contact and −max(0, f − k_a s) at a gap s, for each of two branches.
///
/// `reversible` has one branch, which acts before the touch too; that of `irreversible` begins with the touch, which sets
/// f²/(2 k_a) free. `charged` has one for the charges, which may repel, and one for van der Waals forces. `dmt` is the pull
/// f = 2π W R* of Derjaguin, Muller & Toporov (1975), in contact alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pull {
    /// Name of the law.
    pub name: &'static str,
    /// The branches; one that is not needed has no force.
    pub branches: [Branch; 2],
    /// Whether it begins with the touch.
    pub forms_on_contact: bool,
    /// Gap at which it ends between the largest particles, m.
    pub(super) range: f64,
}

/// A force that is constant in contact and falls linearly over a gap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Branch {
    /// f, N: the part that is the same for all sizes.
    pub force: f64,
    /// f over R*, N/m: the part that grows with the size.
    pub force_per_radius: f64,
    /// k_a, N/m; infinite for a force without reach.
    pub stiffness: f64,
    /// 1 for attraction, −1 for repulsion.
    pub sign: f64,
}

impl Branch {
    /// No force.
    pub const NONE: Self = Self {
        force: 0.0,
        force_per_radius: 0.0,
        stiffness: f64::INFINITY,
        sign: 1.0,
    };

    /// f, N, for R* (m).
    #[inline(always)]
    fn strength<L: Real>(&self, effective_radius: L) -> L {
        effective_radius * self.force_per_radius + self.force
    }

    /// max(0, f − k_a s), N.
    #[inline(always)]
    fn over_gap<L: Real>(&self, contact: &Contact<L>, strength: L) -> L {
        let touches = L::ZERO.at_most(contact.overlap);
        let rest = (strength + contact.overlap * self.stiffness).max(L::ZERO);
        L::select(touches, strength, rest)
    }

    /// Gap at which it ends, m, for R* (m).
    fn range(&self, effective_radius: f64) -> f64 {
        self.strength(effective_radius) / self.stiffness
    }
}

impl Pull {
    /// With these branches.
    #[must_use]
    pub fn new(name: &'static str, branches: [Branch; 2], forms_on_contact: bool) -> Self {
        Self {
            name,
            branches,
            forms_on_contact,
            range: 0.0,
        }
    }

    /// The law with its range between particles of radii up to this one (m). R* is not above ten radii at a concave wall.
    pub(super) fn reaching(self, largest_radius: f64) -> Self {
        let ranges = self
            .branches
            .map(|branch| branch.range(10.0 * largest_radius));
        Self {
            range: ranges[0].max(ranges[1]),
            ..self
        }
    }

    /// The largest slope over the gap, N/m; 0 for a force without reach.
    pub(super) fn stiffness(&self) -> f64 {
        let slopes = self.branches.map(|branch| branch.stiffness);
        slopes.into_iter().filter(|slope| slope.is_finite()).sum()
    }

    /// Where it acts: the touch has to come first where it begins with one.
    #[inline(always)]
    fn acts<L: Real>(&self, contact: &Contact<L>, held: &Held<L>) -> L::Mask {
        let touches = L::ZERO.below(contact.overlap);
        if self.forms_on_contact {
            touches | L::ZERO.below(held.0)
        } else {
            touches | !touches
        }
    }

    #[inline(always)]
    pub(super) fn force<L: Real>(
        &self,
        contact: &Contact<L>,
        held: &mut Held<L>,
    ) -> AdhesionForce<L> {
        let acts = self.acts(contact, held);
        let mut pull = L::ZERO;
        for branch in &self.branches {
            let strength = branch.strength(contact.effective_radius);
            pull = pull + branch.over_gap(contact, strength) * branch.sign;
        }
        if self.forms_on_contact {
            let holds = acts & !pull.equals(L::ZERO);
            held.0 = L::select(holds, L::ONE, L::ZERO);
        }
        let pull = if acts.all() {
            pull
        } else {
            L::select(acts, pull, L::ZERO)
        };
        AdhesionForce::along(NormalForce {
            elastic: -pull,
            viscous: L::ZERO,
        })
    }

    /// −f overlap − f²/(2 k_a) in contact and −max(0, f − k_a s)²/(2 k_a) at a gap, J, for each branch that attracts.
    pub(super) fn energy<L: Real>(&self, contact: &Contact<L>, held: &Held<L>) -> L {
        let mut energy = L::ZERO;
        for branch in &self.branches {
            let strength = branch.strength(contact.effective_radius);
            let over_gap = branch.over_gap(contact, strength);
            let stored = over_gap * over_gap * (0.5 / branch.stiffness)
                + strength * contact.overlap.max(L::ZERO);
            energy = energy - stored * branch.sign;
        }
        L::select(self.acts(contact, held), energy, L::ZERO)
    }
}
