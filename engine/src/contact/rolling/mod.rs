//! Resistance to rolling and torsion.

mod any;
mod luding;

pub use any::{AnyRolling, AnyRollingHistory};
pub use luding::{FrictionSpring, Luding, RollingSprings};

use super::{Contact, History, HistoryNumber};
use crate::lanes::{Real, Vector};

/// A rolling and torsion law; its fields are its parameters for one pair of materials.
pub trait RollingLaw: Copy + Send + Sync + std::fmt::Debug + 'static {
    /// Memory of the law.
    type History<L: Real>: History<L, One = Self::History<f64>>;
    /// False for the law that does nothing.
    const ACTIVE: bool;

    /// How the plan and the log call it.
    fn name(&self) -> &'static str;

    /// Unit and meaning of the numbers of its history.
    fn columns(&self) -> Vec<HistoryNumber> {
        <Self::History<f64> as History>::columns()
    }

    /// Couple on A, N m (B gets the opposite), for the normal force N >= 0 (N) and the tangential stiffness
    /// k_t of the contact (N/m); the history goes on by `dt` (s).
    fn couple<L: Real>(
        &self,
        contact: &Contact<L>,
        normal_force: L,
        tangential_stiffness: L,
        dt: f64,
        history: &mut Self::History<L>,
    ) -> Vector<L>;

    /// Energy stored in the springs, J.
    fn energy<L: Real>(&self, tangential_stiffness: L, history: &Self::History<L>) -> L;
}

/// No resistance to rolling or torsion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoRolling;

impl RollingLaw for NoRolling {
    type History<L: Real> = ();
    const ACTIVE: bool = false;

    fn name(&self) -> &'static str {
        "no rolling"
    }

    #[inline(always)]
    fn couple<L: Real>(&self, _: &Contact<L>, _: L, _: L, _: f64, (): &mut ()) -> Vector<L> {
        Vector::ZERO
    }

    fn energy<L: Real>(&self, _: L, (): &()) -> L {
        L::ZERO
    }
}
