//! A normal law chosen at run time.

use super::{Contact, Hertz, Linear, NormalForce, NormalLaw, Plastic};
use crate::contact::HistoryNumber;
use crate::contact::any::{Holds, any_law};
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

            fn energy<L: Real>(&self, contact: &Contact<L>, history: &AnyNormalHistory<L>) -> L {
                match self {
                    $(Self::$variant(law) => law.energy(contact, &Holds::<$law, L>::own(history)),)*
                }
            }
        }
    };
}

// The laws that a scene can name.
normal_laws!(Linear(Linear), Hertz(Hertz), Plastic(Plastic));
