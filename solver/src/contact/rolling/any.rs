//! A rolling law chosen at run time.

use super::{Contact, Luding, NoRolling, RollingLaw};
use crate::contact::HistoryNumber;
use crate::contact::any::{Holds, any_law};
use crate::lanes::{Real, Vector};

macro_rules! rolling_laws {
    ($($variant:ident($law:ident)),*) => {
        any_law!(RollingLaw: AnyRolling remembers AnyRollingHistory { [None = NoRolling] $($variant($law)),* });

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
