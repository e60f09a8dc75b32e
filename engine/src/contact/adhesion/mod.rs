//! Adhesion: what pulls two particles together, in contact and beyond it.

mod any;
pub mod liquid;
pub mod young_laplace;

pub use any::AnyAdhesion;
pub use liquid::{Bridge, Liquid, LiquidLaw};

use super::{Contact, History, HistoryNumber, NormalForce};
use crate::lanes::{Real, Vector};

/// Force of adhesion on A.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdhesionForce<L = f64> {
    /// Along the normal, N; negative pulls. `elastic` is what follows from overlap and history alone, `viscous` depends on velocities.
    pub normal: NormalForce<L>,
    /// In the tangent plane, N; it acts at the contact point. It is not friction and does not count in its limit.
    pub tangential: Vector<L>,
}

impl<L: Real> AdhesionForce<L> {
    /// Nothing.
    pub const NONE: Self = Self {
        normal: NormalForce::NONE,
        tangential: Vector::ZERO,
    };

    /// Along the normal alone.
    #[must_use]
    pub fn along(normal: NormalForce<L>) -> Self {
        Self {
            normal,
            tangential: Vector::ZERO,
        }
    }

    /// `force(k)` in lane `k`.
    #[inline(always)]
    #[must_use]
    pub fn gather(force: impl Fn(usize) -> AdhesionForce) -> Self {
        Self {
            normal: NormalForce::gather(|k| force(k).normal),
            tangential: Vector::gather(|k| force(k).tangential),
        }
    }

    /// That of the contact in lane `k`.
    #[inline(always)]
    #[must_use]
    pub fn lane(&self, k: usize) -> AdhesionForce {
        AdhesionForce {
            normal: self.normal.lane(k),
            tangential: self.tangential.lane(k),
        }
    }
}

/// Event of a contact whose law [requests events](AdhesionLaw::HAS_EVENTS).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BridgeEvent {
    /// Its two sides touch, or their films meet, and nothing is remembered yet.
    Touch,
    /// Its memory ends: the gap is too wide.
    End,
}

impl BridgeEvent {
    /// That of a contact with this bridge.
    #[must_use]
    pub fn of(bridge: &Bridge) -> Self {
        if bridge.wet == 0.0 {
            Self::Touch
        } else {
            Self::End
        }
    }
}

/// An adhesion law; its fields are its parameters for one pair of materials.
///
/// It acts after the normal law and friction. It does not enter the limit of friction N, which is the normal
/// law's alone (as in MercuryDPM; a law in which adhesion presses the surfaces together, as DMT's, has this in its normal law).
///
/// It may act at a gap. The overlap of such a contact is negative, the contact point stands halfway across the gap, and all other
/// parts of the pair's law are silent: friction and rolling springs end with the touch. The memory of adhesion lasts while the
/// gap is below its range, through sorts of the particles and new lists, and is forgotten there.
pub trait AdhesionLaw: Copy + Send + Sync + std::fmt::Debug + 'static {
    /// Memory of the law. A history that differs from its default is a bond, which holds the pair together across a gap.
    type History<L: Real>: History<L, One = Self::History<f64>>;
    /// False for the law that does nothing: pairs then are not looked at before they touch.
    const ACTIVE: bool;
    /// Whether it begins with a touch, as a liquid bridge does, so that pairs which never touched need no evaluation. Otherwise
    /// it acts wherever the gap is below its range, as van der Waals forces do.
    const FORMS_ON_CONTACT: bool;
    /// Whether its force may have a part in the tangent plane.
    const SHEARS: bool = false;
    /// Whether contacts by this law may have events. They are collected in the force evaluation and answered after it: the history
    /// of a bond is then changed from outside, and is never forgotten without an event.
    const HAS_EVENTS: bool = false;

    /// How the plan and the log call it.
    fn name(&self) -> &'static str;

    /// Least volume of the films of both sides from which it begins, m^3.
    fn least_films(&self) -> f64 {
        0.0
    }

    /// Unit and meaning of the numbers of its history.
    fn columns(&self) -> Vec<HistoryNumber> {
        <Self::History<f64> as History>::columns()
    }

    /// Gap at which it ends for any pair of these materials, m. A bond that ends sooner (for smaller particles, less liquid) sets
    /// its history to the default itself.
    fn range(&self) -> f64;

    /// Force on A. Called while the gap is below the range, in contact too; the history goes on by `dt` (s).
    fn force<L: Real>(
        &self,
        contact: &Contact<L>,
        dt: f64,
        history: &mut Self::History<L>,
    ) -> AdhesionForce<L>;

    /// Energy of the bond, J: 0 for two that are free of each other, negative for two that must be torn apart.
    fn energy<L: Real>(&self, contact: &Contact<L>, history: &Self::History<L>) -> L;

    /// Energy that it has dissipated since the geometry was `last`, J; `elastic` is its elastic force now, N. Histories: before
    /// and after the step. The elastic work, by the trapezoidal rule over the overlaps, which is exact for straight branches,
    /// less what the energy of the bond has gained. A bond that forms on contact sets its energy free at once.
    fn loss(
        &self,
        contact: &Contact,
        last: &Contact,
        elastic: f64,
        [before, after]: [&Self::History<f64>; 2],
    ) -> f64 {
        let mut gain = self.energy(contact, after);
        let mut both = elastic;
        if -last.overlap < self.range() {
            let mut bond = *before;
            both += self.force(last, 0.0, &mut bond).normal.elastic;
            gain -= self.energy(last, before);
        }
        0.5 * both * (contact.overlap - last.overlap) - gain
    }

    /// Where a contact that was just evaluated has an event: [`BridgeEvent::Touch`] where the two overlap, else [`BridgeEvent::End`].
    #[inline(always)]
    fn event<L: Real>(&self, contact: &Contact<L>, _: &Self::History<L>) -> L::Mask {
        contact.overlap.below(contact.overlap)
    }
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
    fn force<L: Real>(&self, _: &Contact<L>, _: f64, (): &mut ()) -> AdhesionForce<L> {
        AdhesionForce::NONE
    }

    fn energy<L: Real>(&self, _: &Contact<L>, (): &()) -> L {
        L::ZERO
    }
}
