//! Dry cohesion: adhesion without liquid.

mod jkr;
mod keys;
mod pull;
#[cfg(test)]
mod tests;
mod van_der_waals;

pub use jkr::Jkr;
pub(in crate::contact) use keys::KEYS;
pub use pull::{Branch, Pull};
pub use van_der_waals::VanDerWaals;

use super::{AdhesionForce, AdhesionLaw, Contact, History, HistoryNumber, NoAdhesion, NoEvents};
use crate::contact::{AnyNormal, SpringAndDashpot};
use crate::lanes::Real;

/// A law of dry cohesion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Dry {
    /// None.
    None,
    /// Johnson, Kendall & Roberts (1971).
    Jkr(Jkr),
    /// Forces that are constant in contact and fall linearly over a gap.
    Pull(Pull),
    /// Van der Waals attraction.
    VanDerWaals(VanDerWaals),
}

impl Dry {
    /// The law with its range between particles of radii up to this one (m; infinite sizes are left out).
    #[must_use]
    pub fn reaching(self, largest_radius: f64) -> Self {
        match self {
            Self::Jkr(law) => Self::Jkr(law.reaching(largest_radius)),
            Self::Pull(law) => Self::Pull(law.reaching(largest_radius)),
            Self::None | Self::VanDerWaals(_) => self,
        }
    }

    /// Spring and dashpot of the normal force and of adhesion where they are stiffest in an impact at `speed` (m/s), for m* (kg) and
    /// R* (m), and the contact radius there (m); `None` where the normal law says all.
    #[must_use]
    pub fn stiffest(
        &self,
        normal: &AnyNormal,
        effective_mass: f64,
        effective_radius: f64,
        speed: f64,
    ) -> Option<(SpringAndDashpot, f64)> {
        let spring = |stiffness: f64| SpringAndDashpot {
            stiffness,
            dissipation: 0.0,
        };
        match self {
            Self::None => None,
            Self::Jkr(law) => {
                let beta = match normal {
                    AnyNormal::Hertz(hertz) => hertz.damping,
                    _ => 0.0,
                };
                Some(law.stiffest(beta, effective_mass, effective_radius, speed))
            }
            Self::Pull(law) => {
                let stiffness = law.stiffness();
                (stiffness > 0.0).then(|| (spring(stiffness), 0.0))
            }
            Self::VanDerWaals(law) => Some((spring(law.stiffness(effective_radius)), 0.0)),
        }
    }
}

/// Memory of a contact of dry cohesion: 1 while a touch holds the two together.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Held<L = f64>(pub L);

impl<L: Real> History<L> for Held<L> {
    type One = Held;
    const LENGTH: usize = 1;

    /// The column `adhesion` shows what the memory does.
    fn columns() -> Vec<HistoryNumber> {
        Vec::new()
    }

    fn swapped(self) -> Self {
        self
    }

    fn write(&self, numbers: &mut Vec<L>) {
        numbers.push(self.0);
    }

    fn show(&self, _: &mut Vec<L>) {}

    fn read(numbers: &[L]) -> Self {
        Self(numbers[0])
    }

    #[inline(always)]
    fn gather(one: impl Fn(usize) -> Held) -> Self {
        Self(L::from_lanes(|k| one(k).0))
    }

    #[inline(always)]
    fn lane(&self, k: usize) -> Held {
        Held(self.0.lane(k))
    }
}

impl AdhesionLaw for Dry {
    type History<L: Real> = Held<L>;
    type Events = NoEvents;
    const ACTIVE: bool = true;
    const PRESSES: bool = true;
    const JOINS: bool = true;

    fn name(&self) -> &'static str {
        match self {
            Self::None => NoAdhesion.name(),
            Self::Jkr(_) => "jkr",
            Self::Pull(law) => law.name,
            Self::VanDerWaals(_) => "van-der-waals",
        }
    }

    #[inline(always)]
    fn forms_on_contact(&self) -> bool {
        match self {
            Self::None | Self::Jkr(_) => true,
            Self::Pull(law) => law.forms_on_contact,
            Self::VanDerWaals(_) => false,
        }
    }

    #[inline(always)]
    fn is_joined(&self, contact: &Contact, held: &Held) -> bool {
        match self {
            Self::Jkr(law) => held.0 == 1.0 && -contact.overlap < law.end(contact.effective_radius),
            _ => false,
        }
    }

    #[inline(always)]
    fn as_hertz<L: Real>(&self, contact: &Contact<L>) -> Contact<L> {
        match self {
            Self::Jkr(law) => law.as_hertz(contact),
            _ => *contact,
        }
    }

    fn is_dry(&self) -> bool {
        true
    }

    fn is_one_with_normal(&self) -> bool {
        matches!(self, Self::Jkr(_))
    }

    fn range(&self) -> f64 {
        match self {
            Self::None => 0.0,
            Self::Jkr(law) => law.range,
            Self::Pull(law) => law.range,
            Self::VanDerWaals(law) => law.range,
        }
    }

    #[inline(always)]
    fn force<L: Real>(&self, contact: &Contact<L>, _: f64, held: &mut Held<L>) -> AdhesionForce<L> {
        match self {
            Self::None => AdhesionForce::NONE,
            Self::Jkr(law) => law.force(contact, held),
            Self::Pull(law) => law.force(contact, held),
            Self::VanDerWaals(law) => law.force(contact),
        }
    }

    fn energy<L: Real>(&self, contact: &Contact<L>, held: &Held<L>) -> L {
        match self {
            Self::None => L::ZERO,
            Self::Jkr(law) => law.energy(contact),
            Self::Pull(law) => law.energy(contact, held),
            Self::VanDerWaals(law) => law.energy(contact),
        }
    }
}
