//! Resistance to rolling and torsion.

mod any;
mod luding;

pub use any::AnyRolling;
pub use luding::{FrictionSpring, Luding, RollingSprings};

use glam::DVec3;

use super::{Contact, History};

/// A rolling and torsion law; its fields are its parameters for one pair of materials.
pub trait RollingLaw: Copy + Send + Sync + std::fmt::Debug + 'static {
    /// What it remembers.
    type History: History;
    /// False for the law that does nothing.
    const ACTIVE: bool;

    /// Couple on A, N m (B gets the opposite), for the normal force N >= 0 (N) and the tangential stiffness
    /// k_t of the contact (N/m); the history goes on by `dt` (s).
    fn couple(
        &self,
        contact: &Contact,
        normal_force: f64,
        tangential_stiffness: f64,
        dt: f64,
        history: &mut Self::History,
    ) -> DVec3;

    /// Energy stored in the springs, J.
    fn energy(&self, tangential_stiffness: f64, history: &Self::History) -> f64;
}

/// No resistance to rolling or torsion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoRolling;

impl RollingLaw for NoRolling {
    type History = ();
    const ACTIVE: bool = false;

    #[inline(always)]
    fn couple(&self, _: &Contact, _: f64, _: f64, _: f64, (): &mut ()) -> DVec3 {
        DVec3::ZERO
    }

    fn energy(&self, _: f64, (): &()) -> f64 {
        0.0
    }
}
