//! An adhesion law chosen at run time.

use super::liquid::{BridgeEvents, CURVE, Fit};
use super::{AdhesionForce, AdhesionLaw, Bridge, Contact, Liquid, LiquidLaw, NoAdhesion};
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

impl<const N: usize> OneOf<AnyAdhesion> for LiquidLaw<N> {
    fn of(any: AnyAdhesion) -> Option<Self> {
        match any {
            AnyAdhesion::None => Some(Self(Liquid::NONE)),
            // One from which no bridge forms needs no room for a curve.
            AnyAdhesion::Liquid(law)
                if law.fit == Fit::YoungLaplace && law.max_volume > 0.0 && N < CURVE =>
            {
                None
            }
            AnyAdhesion::Liquid(law) => Some(Self(law)),
        }
    }
}

impl AdhesionLaw for AnyAdhesion {
    type History<L: Real> = Bridge<L>;
    type Events = BridgeEvents;
    const ACTIVE: bool = true;
    const FORMS_ON_CONTACT: bool = true;
    const SHEARS: bool = true;

    fn name(&self) -> &'static str {
        match self {
            Self::None => NoAdhesion.name(),
            Self::Liquid(law) => LiquidLaw::<CURVE>(*law).name(),
        }
    }

    fn range(&self) -> f64 {
        self.liquid().map_or(0.0, |liquid| liquid.range)
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
            Self::Liquid(law) => LiquidLaw::<CURVE>(*law).force(contact, dt, bridge),
        }
    }

    fn energy<L: Real>(&self, contact: &Contact<L>, bridge: &Bridge<L>) -> L {
        match self {
            Self::None => L::ZERO,
            Self::Liquid(law) => LiquidLaw::<CURVE>(*law).energy(contact, bridge),
        }
    }

    #[inline]
    fn event<L: Real>(&self, contact: &Contact<L>, bridge: &Bridge<L>) -> L::Mask {
        let liquid = self.liquid().unwrap_or(&Liquid::NONE);
        LiquidLaw::<CURVE>(*liquid).event(contact, bridge)
    }
}
