//! A normal law chosen at run time.

use mercury_common::scene::LawKeys;

use super::{Contact, Hertz, Linear, NormalForce, NormalLaw, Plastic};
use crate::contact::HistoryNumber;
use crate::contact::any::{Holds, any_law};
use crate::contact::mixing::Pair;
use crate::contact::{PlannedNormal, SpringAndDashpot};
use crate::lanes::Real;

macro_rules! normal_laws {
    ($($variant:ident($law:ident)),*) => {
        any_law!(NormalLaw: AnyNormal remembers AnyNormalHistory { $($variant($law)),* });

        impl NormalLaw for AnyNormal {
            type History<L: Real> = AnyNormalHistory<L>;

            fn name(&self) -> &'static str {
                match self {
                    $(Self::$variant(law) => law.name(),)*
                }
            }

            fn columns(&self) -> Vec<HistoryNumber> {
                match self {
                    $(Self::$variant(law) => law.columns(),)*
                }
            }

            #[inline]
            fn force<L: Real>(
                &self,
                contact: &Contact<L>,
                history: &mut AnyNormalHistory<L>,
            ) -> NormalForce<L> {
                match self {
                    $(Self::$variant(law) => {
                        let mut own = Holds::<$law, L>::own(history);
                        let force = law.force(contact, &mut own);
                        *history = Holds::<$law, L>::hold(own);
                        force
                    })*
                }
            }

            fn is_elastic(&self) -> bool {
                match self {
                    $(Self::$variant(law) => law.is_elastic(),)*
                }
            }

            fn energy<L: Real>(&self, contact: &Contact<L>, history: &AnyNormalHistory<L>) -> L {
                match self {
                    $(Self::$variant(law) => law.energy(contact, &Holds::<$law, L>::own(history)),)*
                }
            }
        }

        impl AnyNormal {
            /// What scenes say of each of them.
            pub const KEYS: &'static [&'static LawKeys] = &[$(<$law as PlannedNormal>::KEYS),*];
        }

        impl PlannedNormal for AnyNormal {
            const KEYS: &'static LawKeys = &LawKeys::NONE;

            fn of_scene(pair: &mut Pair<'_>) -> Option<Self> {
                $(if pair.requests($law::KEYS) {
                    return $law::of_scene(pair).map(Self::$variant);
                })*
                None
            }

            fn duration(&self, effective_mass: f64, effective_radius: f64, speed: f64) -> f64 {
                match self {
                    $(Self::$variant(law) => law.duration(effective_mass, effective_radius, speed),)*
                }
            }

            fn stiffest(
                &self,
                effective_mass: f64,
                effective_radius: f64,
                speed: f64,
            ) -> (SpringAndDashpot, f64) {
                match self {
                    $(Self::$variant(law) => law.stiffest(effective_mass, effective_radius, speed),)*
                }
            }

            fn spring(&self) -> Option<f64> {
                match self {
                    $(Self::$variant(law) => law.spring(),)*
                }
            }

            fn beta(&self) -> Option<f64> {
                match self {
                    $(Self::$variant(law) => law.beta(),)*
                }
            }
        }
    };
}

// The laws that a scene can name.
normal_laws!(Hertz(Hertz), Linear(Linear), Plastic(Plastic));
