//! An adhesion law chosen at run time.

use super::{AdhesionLaw, Contact, NoAdhesion, NormalForce};
use crate::contact::OneOf;
use crate::lanes::Real;

/// One of the adhesion laws: so far none can be named in a scene. With the first, this is written by `any_law` as for the other
/// parts of a contact, and becomes active.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AnyAdhesion {
    /// None.
    None,
}

impl AdhesionLaw for AnyAdhesion {
    type History<L: Real> = ();
    const ACTIVE: bool = false;
    const FORMS_ON_CONTACT: bool = false;

    fn name(&self) -> &'static str {
        match self {
            Self::None => NoAdhesion.name(),
        }
    }

    fn range(&self) -> f64 {
        match self {
            Self::None => NoAdhesion.range(),
        }
    }

    #[inline]
    fn force<L: Real>(&self, contact: &Contact<L>, dt: f64, (): &mut ()) -> NormalForce<L> {
        match self {
            Self::None => NoAdhesion.force(contact, dt, &mut ()),
        }
    }

    fn energy<L: Real>(&self, contact: &Contact<L>, (): &()) -> L {
        match self {
            Self::None => NoAdhesion.energy(contact, &()),
        }
    }
}

impl OneOf<AnyAdhesion> for AnyAdhesion {
    fn of(any: AnyAdhesion) -> Option<Self> {
        Some(any)
    }
}

impl OneOf<AnyAdhesion> for NoAdhesion {
    fn of(any: AnyAdhesion) -> Option<Self> {
        (any == AnyAdhesion::None).then_some(Self)
    }
}
