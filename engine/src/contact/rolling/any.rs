//! A rolling law chosen at run time.

use mercury_common::scene::LawKeys;

use super::{Contact, Luding, NoRolling, RollingLaw};
use crate::contact::HistoryNumber;
use crate::contact::any::{Holds, any_law};
use crate::contact::mixing::Pair;
use crate::contact::{AnyTangential, PlannedRolling, SpringAndDashpot};
use crate::lanes::{Real, Vector};

macro_rules! rolling_laws {
    ($($variant:ident($law:ident)),*) => {
        any_law!(RollingLaw: AnyRolling remembers AnyRollingHistory { [None = NoRolling] $($variant($law)),* });

        impl AnyRolling {
            /// Keys of each of them in scenes.
            pub const KEYS: &'static [&'static LawKeys] = &[$($law::KEYS),*];

            /// Whether the law of two materials takes its stiffness from the tangential one.
            pub(in crate::contact) fn needs_tangential_stiffness(pair: &mut Pair<'_>) -> bool {
                $(if pair.requests($law::KEYS) {
                    return $law::needs_tangential_stiffness(pair);
                })*
                false
            }

            /// The law of two materials by the table of keys that is read for them.
            pub(in crate::contact) fn of_scene(
                pair: &mut Pair<'_>,
                tangential: &AnyTangential,
            ) -> Option<Self> {
                $(if pair.requests($law::KEYS) {
                    let law = $law::of_scene(pair, tangential)?;
                    return Some(law.map_or(Self::None, Self::$variant));
                })*
                None
            }

            /// Its springs for R* (m) and k_t (N/m): lever (m), spring and dashpot, and its name.
            #[must_use]
            pub fn stiffest(
                &self,
                effective_radius: f64,
                tangential_stiffness: f64,
            ) -> Vec<(f64, SpringAndDashpot, &'static str)> {
                match self {
                    Self::None => Vec::new(),
                    $(Self::$variant(law) => law.stiffest(effective_radius, tangential_stiffness),)*
                }
            }
        }

        impl RollingLaw for AnyRolling {
            type History<L: Real> = AnyRollingHistory<L>;
            const ACTIVE: bool = true;

            fn name(&self) -> &'static str {
                match self {
                    Self::None => NoRolling.name(),
                    $(Self::$variant(law) => law.name(),)*
                }
            }

            fn columns(&self) -> Vec<HistoryNumber> {
                match self {
                    Self::None => NoRolling.columns(),
                    $(Self::$variant(law) => law.columns(),)*
                }
            }

            #[inline]
            fn couple<L: Real>(
                &self,
                contact: &Contact<L>,
                normal_force: L,
                tangential_stiffness: L,
                dt: f64,
                history: &mut AnyRollingHistory<L>,
            ) -> Vector<L> {
                match self {
                    Self::None => Vector::ZERO,
                    $(Self::$variant(law) => {
                        let mut own = Holds::<$law, L>::own(history);
                        let couple = law.couple(contact, normal_force, tangential_stiffness, dt, &mut own);
                        *history = Holds::<$law, L>::hold(own);
                        couple
                    })*
                }
            }

            fn energy<L: Real>(
                &self,
                tangential_stiffness: L,
                history: &AnyRollingHistory<L>,
            ) -> L {
                match self {
                    Self::None => L::ZERO,
                    $(Self::$variant(law) => {
                        law.energy(tangential_stiffness, &Holds::<$law, L>::own(history))
                    })*
                }
            }
        }
    };
}

// The laws that a scene can name, beside none.
rolling_laws!(Luding(Luding));
