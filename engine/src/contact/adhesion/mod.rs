//! Adhesion: what pulls two particles together, in contact and beyond it.

mod any;
pub mod dry;
pub mod liquid;
pub mod young_laplace;

pub use any::{AnyAdhesion, AnyMemory};
pub use dry::{Dry, Held};
pub use liquid::{Bridge, BridgeEvent, Liquid, LiquidLaw};

use super::{Contact, History, HistoryNumber, NormalForce};
use crate::lanes::{Real, Vector};

/// Force of adhesion on A.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdhesionForce<L = f64> {
    /// Along the normal, N; negative pulls. `elastic` is what follows from overlap and history alone, `viscous` depends on velocities.
    pub normal: NormalForce<L>,
    /// In the tangent plane, N; it acts at the contact point. It is not friction and does not count in its limit.
    pub tangential: Vector<L>,
    /// Couple beyond the lever arm of the force, N m.
    pub couple: Vector<L>,
    /// Force that presses the surfaces together beside the normal law's, in the limits of friction and rolling, N.
    pub friction_load: L,
}

impl<L: Real> AdhesionForce<L> {
    /// Nothing.
    pub const NONE: Self = Self {
        normal: NormalForce::NONE,
        tangential: Vector::ZERO,
        couple: Vector::ZERO,
        friction_load: L::ZERO,
    };

    /// Along the normal alone.
    #[must_use]
    pub fn along(normal: NormalForce<L>) -> Self {
        Self {
            normal,
            ..Self::NONE
        }
    }

    /// `force(k)` in lane `k`.
    #[inline(always)]
    #[must_use]
    pub fn gather(force: impl Fn(usize) -> AdhesionForce) -> Self {
        Self {
            normal: NormalForce::gather(|k| force(k).normal),
            tangential: Vector::gather(|k| force(k).tangential),
            couple: Vector::gather(|k| force(k).couple),
            friction_load: L::from_lanes(|k| force(k).friction_load),
        }
    }

    /// That of the contact in lane `k`.
    #[inline(always)]
    #[must_use]
    pub fn lane(&self, k: usize) -> AdhesionForce {
        AdhesionForce {
            normal: self.normal.lane(k),
            tangential: self.tangential.lane(k),
            couple: self.couple.lane(k),
            friction_load: self.friction_load.lane(k),
        }
    }
}

/// Events of a law's contacts, and the memory that parts of the step share with it; `H` is the history that the law keeps of a contact.
///
/// Events are collected in the force evaluation, logged, and answered after it by any number of readers, which may replace the memory.
pub trait LawEvents<H>: 'static {
    /// Kind of an event.
    type Event: Copy + std::fmt::Debug + Send + Sync + 'static;
    /// The memory of a contact in the form in which parts of the step read and replace it.
    type Memory: Copy + std::fmt::Debug + Send + Sync + 'static;
    /// False where no event ever happens and nothing is shared.
    const HAPPEN: bool;
    /// The event of a contact that was just evaluated and [has one](AdhesionLaw::event).
    fn event(history: &H) -> Self::Event;
    /// The event of a contact that loses its slot; `None` where it has nothing to lose.
    fn end(history: &H) -> Option<Self::Event>;
    /// The memory in a history.
    fn memory(history: &H) -> Self::Memory;
    /// Replaces it.
    fn replace(history: &mut H, with: &Self::Memory);
}

/// Kind of the events of an adhesion law.
pub type EventOf<A> =
    <<A as AdhesionLaw>::Events as LawEvents<<A as AdhesionLaw>::History<f64>>>::Event;

/// Memory that an adhesion law shares.
pub type MemoryOf<A> =
    <<A as AdhesionLaw>::Events as LawEvents<<A as AdhesionLaw>::History<f64>>>::Memory;

/// No events and no shared memory.
#[derive(Debug)]
pub struct NoEvents;

impl<H> LawEvents<H> for NoEvents {
    type Event = ();
    type Memory = ();
    const HAPPEN: bool = false;
    fn event(_: &H) {}
    #[inline(always)]
    fn end(_: &H) -> Option<()> {
        None
    }
    fn memory(_: &H) {}
    fn replace(_: &mut H, (): &()) {}
}

/// An adhesion law; its fields are its parameters for one pair of materials.
///
/// It acts after the normal law and before friction. The limit of friction is the normal law's alone, as in MercuryDPM, unless the
/// law [presses](AdhesionLaw::PRESSES) the surfaces together, as that of Johnson, Kendall and Roberts does.
///
/// It may act at a gap. The overlap of such a contact is negative, the contact point stands halfway across the gap, and all other
/// parts of the pair's law are silent: friction and rolling springs end with the touch, unless the law [joins](AdhesionLaw::JOINS)
/// the surfaces. The memory of adhesion lasts while the gap is below its range, through sorts of the particles and new lists, and is
/// forgotten there.
pub trait AdhesionLaw: Copy + Send + Sync + std::fmt::Debug + 'static {
    /// Memory of the law. A history that differs from its default holds the pair together across a gap.
    type History<L: Real>: History<L, One = Self::History<f64>>;
    /// Its events and what it shares of its memory; [`NoEvents`] for a law that needs no part of the step.
    type Events: LawEvents<Self::History<f64>>;
    /// False for the law that does nothing: pairs then are not looked at before they touch.
    const ACTIVE: bool;
    /// Whether its force may have a part in the tangent plane.
    const SHEARS: bool = false;
    /// Whether it may have a couple.
    const TWISTS: bool = false;
    /// Whether it adds a [load](AdhesionForce::friction_load) to the limits of friction and rolling.
    const PRESSES: bool = false;
    /// Whether a neck may join the surfaces across a gap ([`AdhesionLaw::is_joined`]): the two then touch, and all parts of the pair's law act.
    const JOINS: bool = false;
    /// Whether contacts by this law may have events: its memory is then changed from outside, and is never forgotten without an event.
    const HAS_EVENTS: bool = <Self::Events as LawEvents<Self::History<f64>>>::HAPPEN;

    /// How the plan and the log call it.
    fn name(&self) -> &'static str;

    /// Whether it begins with a touch, as a liquid bridge does, so that pairs which never touched need no evaluation. Otherwise
    /// it acts wherever the gap is below its range, as van der Waals forces do.
    fn forms_on_contact(&self) -> bool;

    /// Whether a neck joins a pair with this memory, whose surfaces are a gap apart.
    #[inline(always)]
    fn is_joined(&self, _: &Contact, _: &Self::History<f64>) -> bool {
        false
    }

    /// The contact by Hertz with the contact radius that this law gives: all parts of a pair that touches are evaluated there, this law too.
    #[inline(always)]
    fn as_hertz<L: Real>(&self, contact: &Contact<L>) -> Contact<L> {
        *contact
    }

    /// Whether it is dry cohesion: its losses are counted beside those of liquid.
    fn is_dry(&self) -> bool {
        false
    }

    /// Whether the elastic forces of the normal law and of this one are parts of one force, which begins and ends with a jump.
    fn is_one_with_normal(&self) -> bool {
        false
    }

    /// Least volume of the films of both sides from which it begins, m^3.
    fn least_films(&self) -> f64 {
        0.0
    }

    /// Unit and meaning of the numbers of its history.
    fn columns(&self) -> Vec<HistoryNumber> {
        <Self::History<f64> as History>::columns()
    }

    /// Gap at which it ends for any pair of these materials, m. One that ends sooner (for smaller particles, less liquid) sets
    /// its history to the default itself.
    fn range(&self) -> f64;

    /// Force on A. Called while the gap is below the range, or once beyond it to end the history, in contact too; the history goes on by `dt` (s).
    fn force<L: Real>(
        &self,
        contact: &Contact<L>,
        dt: f64,
        history: &mut Self::History<L>,
    ) -> AdhesionForce<L>;

    /// Energy of the adhesion, J: 0 for two that are free of each other, negative for two that must be torn apart.
    fn energy<L: Real>(&self, contact: &Contact<L>, history: &Self::History<L>) -> L;

    /// Energy dissipated since the geometry was `last`, J; `elastic` is its elastic force now, N. Histories: before and after the
    /// step. The elastic work, by the trapezoidal rule over the overlaps, which is exact for straight branches, less what its energy
    /// has gained. Adhesion that forms on contact sets its energy free at once.
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
            let mut memory = *before;
            both += self.force(last, 0.0, &mut memory).normal.elastic;
            gain -= self.energy(last, before);
        }
        0.5 * both * (contact.overlap - last.overlap) - gain
    }

    /// Where a contact that was just evaluated has an event; [`LawEvents::event`] says which.
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
    type Events = NoEvents;
    const ACTIVE: bool = false;

    fn name(&self) -> &'static str {
        "no adhesion"
    }

    fn forms_on_contact(&self) -> bool {
        true
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
