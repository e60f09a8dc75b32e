//! A tangential law chosen at run time.

use mercury_common::scene::LawKeys;

use super::{Contact, LinearFriction, Mindlin, MindlinRescaled, NoFriction, TangentialLaw};
use crate::contact::HistoryNumber;
use crate::contact::any::{Holds, any_law};
use crate::contact::mixing::{Friction, Pair};
use crate::contact::{AnyNormal, PlannedTangential, StiffestTangential};
use crate::lanes::{Real, Vector};

macro_rules! tangential_laws {
    ($($variant:ident($law:ident)),*; named: $($named:ident),*) => {
        any_law!(TangentialLaw: AnyTangential remembers AnyTangentialHistory { [None = NoFriction] $($variant($law)),* });

        impl AnyTangential {
            /// Keys of each of them in scenes.
            pub const KEYS: &'static [&'static LawKeys] = &[$($named::KEYS),*];

            /// The law of two materials by the table of keys that is read for them.
            pub(in crate::contact) fn of_scene(
                pair: &mut Pair<'_>,
                normal: &AnyNormal,
                friction: Friction,
            ) -> Option<Self> {
                $(if pair.requests($named::KEYS) {
                    return $named::of_scene(pair, normal, friction);
                })*
                None
            }

            /// Where it is stiffest, at a contact radius (m), for m* (kg).
            #[must_use]
            pub fn stiffest(&self, effective_mass: f64, radius: f64) -> Option<StiffestTangential> {
                match self {
                    Self::None => None,
                    $(Self::$variant(law) => Some(law.stiffest(effective_mass, radius)),)*
                }
            }
        }

        impl TangentialLaw for AnyTangential {
            type History<L: Real> = AnyTangentialHistory<L>;
            const ACTIVE: bool = true;

            fn name(&self) -> &'static str {
                match self {
                    Self::None => NoFriction.name(),
                    $(Self::$variant(law) => law.name(),)*
                }
            }

            #[inline(always)]
            fn acts(&self) -> bool {
                !matches!(self, Self::None)
            }

            fn columns(&self) -> Vec<HistoryNumber> {
                match self {
                    Self::None => NoFriction.columns(),
                    $(Self::$variant(law) => law.columns(),)*
                }
            }

            #[inline]
            fn force<L: Real>(
                &self,
                contact: &Contact<L>,
                normal_force: L,
                dt: f64,
                history: &mut AnyTangentialHistory<L>,
            ) -> Vector<L> {
                match self {
                    Self::None => NoFriction.force(contact, normal_force, dt, &mut ()),
                    $(Self::$variant(law) => {
                        let mut own = Holds::<$law, L>::own(history);
                        let force = law.force(contact, normal_force, dt, &mut own);
                        *history = Holds::<$law, L>::hold(own);
                        force
                    })*
                }
            }

            fn stiffness<L: Real>(&self, contact: &Contact<L>) -> L {
                match self {
                    Self::None => NoFriction.stiffness(contact),
                    $(Self::$variant(law) => law.stiffness(contact),)*
                }
            }

            fn tangential_overlap(&self, contact: &Contact, history: &AnyTangentialHistory) -> f64 {
                match self {
                    Self::None => NoFriction.tangential_overlap(contact, &()),
                    $(Self::$variant(law) => law.tangential_overlap(contact, &Holds::<$law, f64>::own(history)),)*
                }
            }

            fn slip(
                &self,
                contact: &Contact,
                normal_force: f64,
                dt: f64,
                history: [&AnyTangentialHistory; 2],
            ) -> f64 {
                match self {
                    Self::None => NoFriction.slip(contact, normal_force, dt, [&(); 2]),
                    $(Self::$variant(law) => {
                        let own = history.map(|history| Holds::<$law, f64>::own(history));
                        law.slip(contact, normal_force, dt, [&own[0], &own[1]])
                    })*
                }
            }

            fn energy<L: Real>(&self, contact: &Contact<L>, history: &AnyTangentialHistory<L>) -> L {
                match self {
                    Self::None => NoFriction.energy(contact, &()),
                    $(Self::$variant(law) => law.energy(contact, &Holds::<$law, L>::own(history)),)*
                }
            }
        }
    };
}

// The laws beside none, and those of them that a scene can name; Mindlin's keys choose between its two.
tangential_laws!(
    Linear(LinearFriction),
    Mindlin(Mindlin),
    MindlinRescaled(MindlinRescaled);
    named: LinearFriction, Mindlin
);
