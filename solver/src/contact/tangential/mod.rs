//! Tangential force laws: sliding friction.

mod any;
mod linear;
mod mindlin;
mod mindlin_rescaled;

pub use any::{AnyTangential, AnyTangentialHistory};
pub use linear::LinearFriction;
pub use mindlin::Mindlin;
pub use mindlin_rescaled::{MindlinRescaled, StoredForce};

use glam::DVec3;

use super::{Contact, History};

/// A tangential law; its fields are its parameters for one pair of materials.
pub trait TangentialLaw: Copy + Send + Sync + std::fmt::Debug + 'static {
    /// What it remembers.
    type History: History;
    /// False for the law that does nothing: scenes without friction skip rotation.
    const ACTIVE: bool;

    /// Force on A in the tangent plane, N, for the normal force N >= 0 (absolute value, N); the history
    /// goes on by `dt` (s).
    fn force(
        &self,
        contact: &Contact,
        normal_force: f64,
        dt: f64,
        history: &mut Self::History,
    ) -> DVec3;

    /// k_t at this contact, N/m; rolling and torsion springs take it where they have no stiffness of their own.
    fn stiffness(&self, contact: &Contact) -> f64;

    /// The number that MercuryDPM prints as "tangential overlap" in `.fstat`, m.
    fn tangential_overlap(&self, contact: &Contact, history: &Self::History) -> f64;

    /// Energy stored in the spring, J.
    fn energy(&self, contact: &Contact, history: &Self::History) -> f64;
}

/// No tangential force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoFriction;

impl TangentialLaw for NoFriction {
    type History = ();
    const ACTIVE: bool = false;

    #[inline(always)]
    fn force(&self, _: &Contact, _: f64, _: f64, (): &mut ()) -> DVec3 {
        DVec3::ZERO
    }

    #[inline(always)]
    fn stiffness(&self, _: &Contact) -> f64 {
        0.0
    }

    fn tangential_overlap(&self, _: &Contact, (): &()) -> f64 {
        0.0
    }

    fn energy(&self, _: &Contact, (): &()) -> f64 {
        0.0
    }
}

/// Cuts a trial force to the Coulomb limits: at most `static_friction` N, and `friction` N once it slides.
/// Returns the force and whether it slides.
#[inline(always)]
fn coulomb(trial: DVec3, static_limit: f64, dynamic_limit: f64) -> (DVec3, bool) {
    let squared = trial.length_squared();
    if squared <= static_limit * static_limit {
        (trial, false)
    } else {
        (trial * (dynamic_limit / squared.sqrt()), true)
    }
}
