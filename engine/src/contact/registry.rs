//! The laws of all pairs of materials.

use super::adhesion::liquid::Tables;
use super::{
    AdhesionLaw, AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, NormalLaw, OneOf, PairLaw,
    RollingLaw, TangentialLaw,
};
/// The law of one pair of materials, as planned.
pub type AnyPairLaw = PairLaw<AnyNormal, AnyTangential, AnyRolling, AnyAdhesion>;

/// The laws of all pairs of materials.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LawTable {
    /// Number of materials.
    pub materials: usize,
    /// Row by row, symmetric; `None` for pairs that never meet in the scene.
    pub laws: Vec<Option<AnyPairLaw>>,
    /// Tables of exact liquid bridges that they refer to.
    pub tables: Tables,
}

impl LawTable {
    /// The law between two materials.
    #[must_use]
    pub fn get(&self, one: u32, other: u32) -> Option<&AnyPairLaw> {
        self.laws[one as usize * self.materials + other as usize].as_ref()
    }

    /// Whether liquid bridges form between any pair.
    #[must_use]
    pub fn has_liquid(&self) -> bool {
        (self.laws.iter().flatten()).any(|law| law.adhesion.liquid().is_some())
    }

    /// Whether any pair has dry cohesion.
    #[must_use]
    pub fn has_dry_cohesion(&self) -> bool {
        (self.laws.iter().flatten()).any(|law| law.adhesion.dry().is_some())
    }

    /// Whether any pair feels friction or rolling resistance, so that particles turn.
    #[must_use]
    pub fn turns(&self) -> bool {
        self.laws.iter().flatten().any(|law| {
            law.tangential != AnyTangential::None
                || law.rolling != AnyRolling::None
                || law
                    .adhesion
                    .liquid()
                    .is_some_and(|liquid| liquid.viscosity > 0.0)
        })
    }

    /// The table for a loop that has no other laws than `N`, `T`, `R` and `A`, if it has none; pairs that never meet get the law
    /// of some pair that does.
    pub(crate) fn narrow<N, T, R, A>(&self) -> Option<Vec<PairLaw<N, T, R, A>>>
    where
        N: OneOf<AnyNormal>,
        T: OneOf<AnyTangential>,
        R: OneOf<AnyRolling>,
        A: OneOf<AnyAdhesion>,
    {
        let narrow = |law: &AnyPairLaw| {
            Some(PairLaw {
                normal: N::of(law.normal)?,
                tangential: T::of(law.tangential)?,
                rolling: R::of(law.rolling)?,
                adhesion: A::of(law.adhesion)?,
            })
        };
        let Some(some) = self.laws.iter().flatten().next() else {
            // No pair ever touches, and the table is never read.
            return Some(Vec::new());
        };
        let some = narrow(some)?;
        let laws = self.laws.iter();
        laws.map(|law| law.as_ref().map_or(Some(some), narrow))
            .collect()
    }

    /// The names of the laws of each pair of materials, row by row; empty for pairs that never meet.
    pub fn names_of_pairs(&self) -> Vec<String> {
        let names = |law: &AnyPairLaw| {
            let (normal, tangential) = (law.normal.name(), law.tangential.name());
            [normal, tangential, law.rolling.name(), law.adhesion.name()].join(", ")
        };
        let laws = self.laws.iter();
        laws.map(|law| law.as_ref().map_or_else(String::new, names))
            .collect()
    }

    /// The names of its laws: normal, tangential, rolling, and adhesion if there is any; of each part all that occur.
    pub(crate) fn names(&self) -> String {
        let of_part = |name: &dyn Fn(&AnyPairLaw) -> &'static str| {
            let mut names: Vec<&str> = Vec::new();
            for law in self.laws.iter().flatten() {
                if !names.contains(&name(law)) {
                    names.push(name(law));
                }
            }
            names.join(" or ")
        };
        let mut parts = vec![
            of_part(&|law| law.normal.name()),
            of_part(&|law| law.tangential.name()),
            of_part(&|law| law.rolling.name()),
        ];
        if (self.laws.iter().flatten()).any(|law| law.adhesion != AnyAdhesion::None) {
            parts.push(of_part(&|law| law.adhesion.name()));
        }
        parts.join(", ")
    }
}
