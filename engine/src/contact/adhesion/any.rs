//! An adhesion law chosen at run time.

use super::liquid::{BridgeEvent, BridgeEvents, CURVE, Fit};
use super::{
    AdhesionForce, AdhesionLaw, Bridge, Contact, Dry, Held, History, HistoryNumber, LawEvents,
    Liquid, LiquidLaw, NoAdhesion,
};
use crate::contact::OneOf;
use crate::lanes::Real;

/// One of the adhesion laws that a scene can name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AnyAdhesion {
    /// None.
    None,
    /// Liquid bridges.
    Liquid(Liquid),
    /// Dry cohesion.
    Dry(Dry),
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

    /// The dry cohesion, if there is any.
    #[must_use]
    pub fn dry(&self) -> Option<&Dry> {
        match self {
            Self::Dry(Dry::None) => None,
            Self::Dry(dry) => Some(dry),
            _ => None,
        }
    }

    fn as_dry(&self) -> Dry {
        self.dry().copied().unwrap_or(Dry::None)
    }

    fn as_liquid(&self) -> LiquidLaw<CURVE> {
        LiquidLaw(*self.liquid().unwrap_or(&Liquid::NONE))
    }
}

impl OneOf<AnyAdhesion> for NoAdhesion {
    fn of(any: AnyAdhesion) -> Option<Self> {
        (any == AnyAdhesion::None).then_some(Self)
    }
}

impl OneOf<AnyAdhesion> for Dry {
    fn of(any: AnyAdhesion) -> Option<Self> {
        match any {
            AnyAdhesion::None => Some(Self::None),
            AnyAdhesion::Dry(law) => Some(law),
            AnyAdhesion::Liquid(_) => None,
        }
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
            AnyAdhesion::Dry(_) => None,
        }
    }
}

impl OneOf<Self> for AnyAdhesion {
    fn of(any: Self) -> Option<Self> {
        Some(any)
    }
}

/// Memory of a contact in scenes that have liquid bridges and dry cohesion. The numbers of the bridge come last.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AnyMemory<L: Real = f64> {
    /// Of dry cohesion.
    pub held: Held<L>,
    /// Of a liquid bridge.
    pub bridge: Bridge<L>,
}

impl<L: Real> History<L> for AnyMemory<L> {
    type One = AnyMemory;
    const LENGTH: usize = 1 + <Bridge<L> as History<L>>::LENGTH;

    fn columns() -> Vec<HistoryNumber> {
        Vec::new()
    }

    fn swapped(self) -> Self {
        self
    }

    fn write(&self, numbers: &mut Vec<L>) {
        self.held.write(numbers);
        self.bridge.write(numbers);
    }

    fn show(&self, _: &mut Vec<L>) {}

    fn read(numbers: &[L]) -> Self {
        Self {
            held: Held(numbers[0]),
            bridge: Bridge::read(&numbers[1..]),
        }
    }

    #[inline(always)]
    fn gather(one: impl Fn(usize) -> AnyMemory) -> Self {
        Self {
            held: Held::gather(|k| one(k).held),
            bridge: Bridge::gather(|k| one(k).bridge),
        }
    }

    #[inline(always)]
    fn lane(&self, k: usize) -> AnyMemory {
        AnyMemory {
            held: self.held.lane(k),
            bridge: self.bridge.lane(k),
        }
    }
}

/// Events of liquid bridges among contacts some of which are dry.
#[derive(Debug)]
pub struct AnyEvents;

impl LawEvents<AnyMemory> for AnyEvents {
    type Event = BridgeEvent;
    type Memory = Bridge;
    const HAPPEN: bool = true;

    fn event(memory: &AnyMemory) -> BridgeEvent {
        BridgeEvents::event(&memory.bridge)
    }

    #[inline(always)]
    fn end(memory: &AnyMemory) -> Option<BridgeEvent> {
        BridgeEvents::end(&memory.bridge)
    }

    fn memory(memory: &AnyMemory) -> Bridge {
        BridgeEvents::memory(&memory.bridge)
    }

    fn replace(memory: &mut AnyMemory, with: &Bridge) {
        BridgeEvents::replace(&mut memory.bridge, with);
    }
}

impl AdhesionLaw for AnyAdhesion {
    type History<L: Real> = AnyMemory<L>;
    type Events = AnyEvents;
    const ACTIVE: bool = true;
    const SHEARS: bool = true;
    const PRESSES: bool = true;
    const JOINS: bool = true;

    fn name(&self) -> &'static str {
        match self {
            Self::None => NoAdhesion.name(),
            Self::Liquid(law) => LiquidLaw::<CURVE>(*law).name(),
            Self::Dry(law) => law.name(),
        }
    }

    fn forms_on_contact(&self) -> bool {
        self.as_dry().forms_on_contact()
    }

    fn is_joined(&self, contact: &Contact, memory: &AnyMemory) -> bool {
        self.as_dry().is_joined(contact, &memory.held)
    }

    fn as_hertz<L: Real>(&self, contact: &Contact<L>) -> Contact<L> {
        self.as_dry().as_hertz(contact)
    }

    fn is_dry(&self) -> bool {
        self.dry().is_some()
    }

    fn is_one_with_normal(&self) -> bool {
        self.as_dry().is_one_with_normal()
    }

    fn least_films(&self) -> f64 {
        self.as_liquid().least_films()
    }

    fn range(&self) -> f64 {
        match self {
            Self::Dry(law) => law.range(),
            _ => self.liquid().map_or(0.0, |liquid| liquid.range),
        }
    }

    #[inline]
    fn force<L: Real>(
        &self,
        contact: &Contact<L>,
        dt: f64,
        memory: &mut AnyMemory<L>,
    ) -> AdhesionForce<L> {
        match self {
            Self::None => AdhesionForce::NONE,
            Self::Liquid(law) => LiquidLaw::<CURVE>(*law).force(contact, dt, &mut memory.bridge),
            Self::Dry(law) => law.force(contact, dt, &mut memory.held),
        }
    }

    fn energy<L: Real>(&self, contact: &Contact<L>, memory: &AnyMemory<L>) -> L {
        match self {
            Self::None => L::ZERO,
            Self::Liquid(law) => LiquidLaw::<CURVE>(*law).energy(contact, &memory.bridge),
            Self::Dry(law) => law.energy(contact, &memory.held),
        }
    }

    fn loss(
        &self,
        contact: &Contact,
        last: &Contact,
        elastic: f64,
        [before, after]: [&AnyMemory; 2],
    ) -> f64 {
        match self {
            Self::Dry(law) => law.loss(contact, last, elastic, [&before.held, &after.held]),
            _ => (self.as_liquid()).loss(contact, last, elastic, [&before.bridge, &after.bridge]),
        }
    }

    #[inline]
    fn event<L: Real>(&self, contact: &Contact<L>, memory: &AnyMemory<L>) -> L::Mask {
        self.as_liquid().event(contact, &memory.bridge)
    }
}
