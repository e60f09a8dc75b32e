//! From the laws that a scene names to a contact loop.

use super::{
    AnyNormal, AnyRolling, AnyTangential, Hertz, Linear, LinearFriction, Luding, Mindlin,
    NoFriction, NoRolling, NormalLaw, OneOf, PairLaw, RollingLaw, TangentialLaw,
};
use crate::forces::{ContactForces, ContactLoop};

/// Makes a loop for a table of laws, if it knows all of them.
type Make = fn(&LawTable) -> Option<Box<dyn ContactForces>>;

/// The combinations of laws that have a loop compiled for them, because many scenes use them. Each takes seconds to compile, in
/// every build of everybody; all others run through the loop that chooses the law at each contact, to the same bytes.
const COMPILED: [Make; 5] = [
    loop_of::<Linear, NoFriction, NoRolling>,
    loop_of::<Linear, LinearFriction, NoRolling>,
    loop_of::<Linear, LinearFriction, Luding>,
    loop_of::<Hertz, Mindlin, NoRolling>,
    loop_of::<Hertz, Mindlin, Luding>,
];

/// The law of one pair of materials, as planned.
pub type AnyPairLaw = PairLaw<AnyNormal, AnyTangential, AnyRolling>;

/// The laws of all pairs of materials.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LawTable {
    /// Number of materials.
    pub materials: usize,
    /// Row by row, symmetric; `None` for pairs that never meet in the scene.
    pub laws: Vec<Option<AnyPairLaw>>,
}

impl LawTable {
    /// The law between two materials.
    #[must_use]
    pub fn get(&self, one: u32, other: u32) -> Option<&AnyPairLaw> {
        self.laws[one as usize * self.materials + other as usize].as_ref()
    }

    /// Whether any pair feels friction or rolling resistance, so that particles turn.
    #[must_use]
    pub fn turns(&self) -> bool {
        self.laws
            .iter()
            .flatten()
            .any(|law| law.tangential != AnyTangential::None || law.rolling != AnyRolling::None)
    }

    /// The table for a loop that knows no other laws than `N`, `T` and `R`, if it has none; pairs that never meet get the law of
    /// some pair that does.
    fn narrow<N, T, R>(&self) -> Option<Vec<PairLaw<N, T, R>>>
    where
        N: OneOf<AnyNormal>,
        T: OneOf<AnyTangential>,
        R: OneOf<AnyRolling>,
    {
        let narrow = |law: &AnyPairLaw| {
            Some(PairLaw {
                normal: N::of(law.normal)?,
                tangential: T::of(law.tangential)?,
                rolling: R::of(law.rolling)?,
            })
        };
        let Some(some) = self.laws.iter().flatten().next() else {
            // Nothing ever touches, and nobody looks at the table.
            return Some(Vec::new());
        };
        let some = narrow(some)?;
        let laws = self.laws.iter();
        laws.map(|law| law.as_ref().map_or(Some(some), narrow))
            .collect()
    }

    /// The names of its laws: normal, tangential, rolling; of each part all that occur.
    fn names(&self) -> String {
        let of_part = |name: &dyn Fn(&AnyPairLaw) -> &'static str| {
            let mut names: Vec<&str> = Vec::new();
            for law in self.laws.iter().flatten() {
                if !names.contains(&name(law)) {
                    names.push(name(law));
                }
            }
            names.join(" or ")
        };
        [
            of_part(&|law| law.normal.name()),
            of_part(&|law| law.tangential.name()),
            of_part(&|law| law.rolling.name()),
        ]
        .join(", ")
    }
}

/// The contact loop for a table of laws: the one that is compiled for its combination, or else the dispatching one. Also its
/// name, for the plan and the log.
#[must_use]
pub fn contact_loop(table: &LawTable) -> (Box<dyn ContactForces>, String) {
    if table.laws.iter().flatten().next().is_none() {
        return (dispatching_loop(table), "no pair can meet".to_owned());
    }
    match COMPILED.iter().find_map(|make| make(table)) {
        Some(compiled) => (compiled, format!("{} (compiled together)", table.names())),
        None => (
            dispatching_loop(table),
            format!("{} (chosen at each contact)", table.names()),
        ),
    }
}

/// The loop that chooses the law at each contact: for any table.
#[must_use]
pub fn dispatching_loop(table: &LawTable) -> Box<dyn ContactForces> {
    let laws: Vec<AnyPairLaw> = table.narrow().unwrap_or_default();
    Box::new(ContactLoop::new(laws, table.materials))
}

/// The loop compiled for these three laws, if the table has no others.
fn loop_of<N, T, R>(table: &LawTable) -> Option<Box<dyn ContactForces>>
where
    N: NormalLaw + OneOf<AnyNormal>,
    T: TangentialLaw + OneOf<AnyTangential>,
    R: RollingLaw + OneOf<AnyRolling>,
{
    let laws = table.narrow::<N, T, R>()?;
    Some(Box::new(ContactLoop::new(laws, table.materials)))
}
