//! Van der Waals attraction.

use super::super::{AdhesionForce, Contact, NormalForce};
use crate::lanes::Real;

/// F = −A R*/6 [1/(z₀ + s)² − 1/(z₀ + r)²] at a gap 0 ≤ s < r, that of s = 0 in contact: the attraction of two spheres
/// (Hamaker 1937), shifted to end at the range r with 0.
///
/// ```
/// use mercury_engine::contact::adhesion::dry::VanDerWaals;
/// // T29: A = 6.5e-20 J, z0 = 0.4 nm, range 10 nm, R* = 75 µm
/// let law = VanDerWaals { hamaker: 6.5e-20, separation: 4e-10, range: 1e-8 };
/// assert!((law.pull(0.0, 7.5e-5) - 5.070612981e-6).abs() < 1e-15);
/// assert!((law.pull(2e-9, 7.5e-5) - 1.335470086e-7).abs() < 1e-16);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VanDerWaals {
    /// A, J.
    pub hamaker: f64,
    /// z₀, m.
    pub separation: f64,
    /// r, m.
    pub range: f64,
}

impl VanDerWaals {
    /// 1/(z₀ + r), 1/m.
    fn least(&self) -> f64 {
        1.0 / (self.separation + self.range)
    }

    /// The pull at a gap (m; at most the range), N, for R* (m).
    #[inline(always)]
    pub fn pull<L: Real>(&self, gap: L, effective_radius: L) -> L {
        let near = L::ONE / (gap + self.separation);
        let least = self.least();
        effective_radius * (self.hamaker / 6.0) * (near * near - least * least)
    }

    #[inline(always)]
    pub(super) fn force<L: Real>(&self, contact: &Contact<L>) -> AdhesionForce<L> {
        let gap = (-contact.overlap).max(L::ZERO).min(L::splat(self.range));
        AdhesionForce::along(NormalForce {
            elastic: -self.pull(gap, contact.effective_radius),
            viscous: L::ZERO,
        })
    }

    /// −A R*/6 [1/(z₀ + s) − 1/(z₀ + r) − (r − s)/(z₀ + r)²], and in contact the work of the constant pull, J.
    pub(super) fn energy<L: Real>(&self, contact: &Contact<L>) -> L {
        let gap = (-contact.overlap).max(L::ZERO).min(L::splat(self.range));
        let least = self.least();
        let rest = L::splat(self.range) - gap;
        let to_end = L::ONE / (gap + self.separation) - least - rest * (least * least);
        let touch = self.pull(L::ZERO, contact.effective_radius);
        -(contact.effective_radius * (self.hamaker / 6.0) * to_end)
            - touch * contact.overlap.max(L::ZERO)
    }

    /// Its steepest slope, A R*/(3 z₀³) at the touch, N/m, for R* (m).
    pub(super) fn stiffness(&self, effective_radius: f64) -> f64 {
        let separation = self.separation;
        self.hamaker * effective_radius / (3.0 * separation * separation * separation)
    }
}
