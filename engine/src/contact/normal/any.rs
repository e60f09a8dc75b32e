//! A normal law chosen at run time.

/// The enum of the normal laws that a scene can name, each with its variant.
macro_rules! normal_laws {
    ($($variant:ident($law:ident)),*) => {
        $crate::contact::any::any_law!(NormalLaw: AnyNormal remembers AnyNormalHistory { $($variant($law)),* });

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
                        let mut own = $crate::contact::any::Holds::<$law, L>::own(history);
                        let force = law.force(contact, &mut own);
                        *history = $crate::contact::any::Holds::<$law, L>::hold(own);
                        force
                    })*
                }
            }

            fn is_elastic(&self) -> bool {
                match self {
                    $(Self::$variant(law) => law.is_elastic(),)*
                }
            }

            fn clamps_tension(&self) -> bool {
                match self {
                    $(Self::$variant(law) => law.clamps_tension(),)*
                }
            }

            fn energy<L: Real>(&self, contact: &Contact<L>, history: &AnyNormalHistory<L>) -> L {
                match self {
                    $(Self::$variant(law) => law.energy(contact, &$crate::contact::any::Holds::<$law, L>::own(history)),)*
                }
            }
        }

        impl AnyNormal {
            /// Keys of each of them in scenes.
            pub const KEYS: &'static [&'static mercury_common::scene::LawKeys] = &[$(<$law as $crate::contact::PlannedNormal>::KEYS),*];
        }

        impl $crate::contact::PlannedNormal for AnyNormal {
            const KEYS: &'static mercury_common::scene::LawKeys =
                &mercury_common::scene::LawKeys::NONE;

            fn of_scene(pair: &mut $crate::contact::mixing::Pair<'_>) -> Option<Self> {
                $(if pair.requests(<$law as $crate::contact::PlannedNormal>::KEYS) {
                    return <$law as $crate::contact::PlannedNormal>::of_scene(pair).map(Self::$variant);
                })*
                None
            }

            fn duration(&self, effective_mass: f64, effective_radius: f64, speed: f64) -> f64 {
                match self {
                    $(Self::$variant(law) => $crate::contact::PlannedNormal::duration(law, effective_mass, effective_radius, speed),)*
                }
            }

            fn stiffest(
                &self,
                effective_mass: f64,
                effective_radius: f64,
                speed: f64,
            ) -> ($crate::contact::SpringAndDashpot, f64) {
                match self {
                    $(Self::$variant(law) => $crate::contact::PlannedNormal::stiffest(law, effective_mass, effective_radius, speed),)*
                }
            }

            fn spring(&self) -> Option<f64> {
                match self {
                    $(Self::$variant(law) => $crate::contact::PlannedNormal::spring(law),)*
                }
            }

            fn beta(&self) -> Option<f64> {
                match self {
                    $(Self::$variant(law) => $crate::contact::PlannedNormal::beta(law),)*
                }
            }

            fn examples(scale: &$crate::contact::Scale) -> Vec<Self> {
                let mut all = Vec::new();
                $(
                    let of_law = <$law as $crate::contact::PlannedNormal>::examples(scale);
                    all.extend(of_law.into_iter().map(Self::$variant));
                )*
                all
            }
        }
    };
}
