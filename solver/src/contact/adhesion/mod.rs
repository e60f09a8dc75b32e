//! Adhesion: what pulls two particles together, in contact and beyond it.

mod any;
pub mod young_laplace;

pub use any::AnyAdhesion;

use super::{Contact, History, HistoryNumber, NormalForce};
use crate::lanes::Real;

/// An adhesion law; its fields are its parameters for one pair of materials.
///
/// It acts along the normal, after the normal law and friction. It does not enter the limit of friction N, which is the normal
/// law's alone (as in MercuryDPM; a law in which adhesion presses the surfaces together, as DMT's, says so by its normal law).
///
/// It may act at a gap. The overlap of such a contact is negative, the contact point stands halfway across the gap, and all other
/// parts of the pair's law are silent: friction and rolling springs end with the touch. What adhesion remembers lasts while the gap
/// is below its range, through sorts of the particles and new lists, and is forgotten there.
pub trait AdhesionLaw: Copy + Send + Sync + std::fmt::Debug + 'static {
    /// What it remembers. A history that differs from its default is a bond, which holds the pair together across a gap.
    type History<L: Real>: History<L, One = Self::History<f64>>;
    /// False for the law that does nothing: pairs then are not looked at before they touch.
    const ACTIVE: bool;
    /// Whether it begins with a touch, as a liquid bridge does, so that pairs which never touched need not be asked. Otherwise it
    /// acts wherever the gap is below its range, as van der Waals forces do.
    const FORMS_ON_CONTACT: bool;

    /// How the plan and the log call it.
    fn name(&self) -> &'static str;

    /// Unit and meaning of the numbers of its history.
    fn columns(&self) -> Vec<HistoryNumber> {
        <Self::History<f64> as History>::columns()
    }

    /// Gap at which it ends for any pair of these materials, m. A bond that ends sooner (for smaller particles, less liquid) sets
    /// its history to the default itself.
    fn range(&self) -> f64;

    /// Force on A along the normal, N; negative pulls. `elastic` is what follows from overlap and history alone, `viscous` depends
    /// on velocities. Called while the gap is below the range, in contact too; the history goes on by `dt` (s).
    fn force<L: Real>(
        &self,
        contact: &Contact<L>,
        dt: f64,
        history: &mut Self::History<L>,
    ) -> NormalForce<L>;

    /// Energy of the bond, J: 0 for two that are free of each other, negative for two that must be torn apart.
    fn energy<L: Real>(&self, contact: &Contact<L>, history: &Self::History<L>) -> L;
}

/// No adhesion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoAdhesion;

impl AdhesionLaw for NoAdhesion {
    type History<L: Real> = ();
    const ACTIVE: bool = false;
    const FORMS_ON_CONTACT: bool = true;

    fn name(&self) -> &'static str {
        "no adhesion"
    }

    fn range(&self) -> f64 {
        0.0
    }

    #[inline(always)]
    fn force<L: Real>(&self, _: &Contact<L>, _: f64, (): &mut ()) -> NormalForce<L> {
        NormalForce::NONE
    }

    fn energy<L: Real>(&self, _: &Contact<L>, (): &()) -> L {
        L::ZERO
    }
}
