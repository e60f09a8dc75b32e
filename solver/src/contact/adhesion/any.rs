//! An adhesion law chosen at run time.

use super::{AdhesionForce, AdhesionLaw, Bridge, Contact, Liquid, NoAdhesion};
use crate::contact::OneOf;
use crate::lanes::Real;

/// One of the adhesion laws that a scene can name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AnyAdhesion {
    /// None.
    None,
    /// Liquid bridges.
    Liquid(Liquid),
}

impl AnyAdhesion {
    /// The liquid, if there is one from which bridges form.
    #[must_use]
    pub fn liquid(&self) -> Option<&Liquid> {
        match self {
            Self::Liquid(liquid) if liquid.max_volume > 0.0 => Some(liquid),
            _ => None,
        }
    }
}

impl OneOf<AnyAdhesion> for NoAdhesion {
    fn of(any: AnyAdhesion) -> Option<Self> {
        (any == AnyAdhesion::None).then_some(Self)
    }
}

impl OneOf<AnyAdhesion> for Liquid {
    fn of(any: AnyAdhesion) -> Option<Self> {
        Some(match any {
            AnyAdhesion::None => Self::NONE,
            AnyAdhesion::Liquid(liquid) => liquid,
        })
    }
}

impl AdhesionLaw for AnyAdhesion {
    type History<L: Real> = Bridge<L>;
    const ACTIVE: bool = true;
    const FORMS_ON_CONTACT: bool = true;
    const SHEARS: bool = true;
    const HAS_EVENTS: bool = true;

    fn name(&self) -> &'static str {
        match self {
            Self::None => NoAdhesion.name(),
            Self::Liquid(law) => law.name(),
        }
    }

    fn range(&self) -> f64 {
        self.liquid().map_or(0.0, AdhesionLaw::range)
    }

    #[inline]
    fn force<L: Real>(
        &self,
        contact: &Contact<L>,
        dt: f64,
        bridge: &mut Bridge<L>,
    ) -> AdhesionForce<L> {
        match self {
            Self::None => AdhesionForce::NONE,
            Self::Liquid(law) => law.force(contact, dt, bridge),
        }
    }

    fn energy<L: Real>(&self, contact: &Contact<L>, bridge: &Bridge<L>) -> L {
        match self {
            Self::None => L::ZERO,
            Self::Liquid(law) => law.energy(contact, bridge),
        }
    }

    #[inline]
    fn event<L: Real>(&self, contact: &Contact<L>, bridge: &Bridge<L>) -> L::Mask {
        self.liquid()
            .unwrap_or(&Liquid::NONE)
            .event(contact, bridge)
    }
}
