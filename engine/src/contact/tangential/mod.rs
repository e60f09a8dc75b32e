//! Tangential force laws: sliding friction.

mod any;
mod coulomb;
mod linear;
mod mindlin;
mod mindlin_rescaled;

pub use any::{AnyTangential, AnyTangentialHistory};
pub use linear::LinearFriction;
pub use mindlin::Mindlin;
pub use mindlin_rescaled::{MindlinRescaled, StoredForce};

use mercury_common::scene::{Key, Mixing, Range};

use super::{Contact, History, HistoryNumber};
use crate::lanes::{Real, Vector};

/// The coefficient that every law of sliding, rolling and torsion has.
pub(crate) const FRICTION: Key = Key::new("friction", "", Range::NonNegative, "mu while it slides");

/// The coefficient at which sliding, rolling and torsion start.
pub(crate) const STATIC_FRICTION: Key = Key::new(
    "static_friction",
    "",
    Range::NonNegative,
    "mu while it holds; not below `friction`",
)
.or_open("= `friction`")
.mixes(Mixing::Derived(
    "harmonic mean; a side without one counts with its `friction`",
));

/// A tangential law; its fields are its parameters for one pair of materials.
pub trait TangentialLaw: Copy + Send + Sync + std::fmt::Debug + 'static {
    /// Memory of the law.
    type History<L: Real>: History<L, One = Self::History<f64>>;
    /// False for the law that does nothing: scenes without friction skip rotation.
    const ACTIVE: bool;

    /// How the plan and the log call it.
    fn name(&self) -> &'static str;

    /// False for the law that does nothing; differs from [`TangentialLaw::ACTIVE`] where the law is chosen at run time.
    #[inline(always)]
    fn acts(&self) -> bool {
        Self::ACTIVE
    }

    /// Unit and meaning of the numbers of its history.
    fn columns(&self) -> Vec<HistoryNumber> {
        <Self::History<f64> as History>::columns()
    }

    /// Force on A in the tangent plane, N, for the whole normal force, N (positive where it presses); the history goes on by
    /// `dt` (s).
    fn force<L: Real>(
        &self,
        contact: &Contact<L>,
        normal_force: L,
        dt: f64,
        history: &mut Self::History<L>,
    ) -> Vector<L>;

    /// k_t at this contact, N/m; rolling and torsion springs take it where they have no stiffness of their own.
    fn stiffness<L: Real>(&self, contact: &Contact<L>) -> L;

    /// The number that MercuryDPM prints as "tangential overlap" in `.fstat`, m.
    fn tangential_overlap(&self, contact: &Contact, history: &Self::History<f64>) -> f64;

    /// The way by which the contact has slid in a step of `dt` (s) beyond what the spring took up, m: how far the spring would have
    /// been stretched without Coulomb's limit from where it is. `history`: before and after the step. The normal force presses.
    fn slip(
        &self,
        contact: &Contact,
        normal_force: f64,
        dt: f64,
        history: [&Self::History<f64>; 2],
    ) -> f64;

    /// Energy stored in the spring, J.
    fn energy<L: Real>(&self, contact: &Contact<L>, history: &Self::History<L>) -> L;
}

/// No tangential force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoFriction;

impl TangentialLaw for NoFriction {
    type History<L: Real> = ();
    const ACTIVE: bool = false;

    fn name(&self) -> &'static str {
        "frictionless"
    }

    #[inline(always)]
    fn force<L: Real>(&self, _: &Contact<L>, _: L, _: f64, (): &mut ()) -> Vector<L> {
        Vector::ZERO
    }

    #[inline(always)]
    fn stiffness<L: Real>(&self, _: &Contact<L>) -> L {
        L::ZERO
    }

    fn tangential_overlap(&self, _: &Contact, (): &()) -> f64 {
        0.0
    }

    fn slip(&self, contact: &Contact, _: f64, dt: f64, _: [&(); 2]) -> f64 {
        contact.tangential_velocity.length() * dt
    }

    fn energy<L: Real>(&self, _: &Contact<L>, (): &()) -> L {
        L::ZERO
    }
}
