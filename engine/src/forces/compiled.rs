//! The choice of a contact loop for the laws of a scene.

use super::{ContactForces, ContactLoop};
use crate::contact::adhesion::liquid::{CURVE, SHORT};
use crate::contact::registry::LawTable;
use crate::contact::{
    AdhesionLaw, AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, Dry, Hertz, LiquidLaw, Mindlin,
    NoAdhesion, NoRolling, NormalLaw, OneOf, PairLaw, RollingLaw, TangentialLaw,
};
#[cfg(not(test))]
use crate::contact::{Linear, LinearFriction, Luding, NoFriction};

/// Makes a loop for a table of laws, if it knows all of them.
type Make = fn(&LawTable) -> Option<Box<dyn ContactForces>>;

/// The combinations of laws that have a loop compiled for them, because many scenes use them. Each adds seconds to the compile
/// time of every build; all others run through the loop that chooses the law at each contact, to the same bytes.
#[cfg(not(test))]
const COMPILED: [Make; 7] = [
    loop_of::<Linear, NoFriction, NoRolling>,
    loop_of::<Linear, LinearFriction, NoRolling>,
    loop_of::<Linear, LinearFriction, Luding>,
    loop_of::<Hertz, Mindlin, NoRolling>,
    loop_of::<Hertz, Mindlin, Luding>,
    wet_loop_of::<Hertz, Mindlin, NoRolling, SHORT>,
    wet_loop_of::<Hertz, Mindlin, NoRolling, CURVE>,
];

/// The unit tests compile the crate a second time: one combination is enough for them. `solver/tests/sources/compiled_laws.rs` compares
/// all of them with the dispatching loop.
#[cfg(test)]
const COMPILED: [Make; 1] = [loop_of::<Hertz, Mindlin, NoRolling>];

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
    // Scenes without adhesion need no memory for it, those with dry cohesion alone none for bridges, and formulas of few numbers none for
    // tables of exact bridges.
    any_loop_of::<NoAdhesion>(table)
        .or_else(|| any_loop_of::<Dry>(table))
        .or_else(|| any_loop_of::<LiquidLaw<SHORT>>(table))
        .or_else(|| any_loop_of::<LiquidLaw<CURVE>>(table))
        .or_else(|| any_loop_of::<AnyAdhesion>(table))
        .unwrap_or_else(|| {
            let none: Vec<PairLaw<AnyNormal, AnyTangential, AnyRolling>> = Vec::new();
            Box::new(ContactLoop::new(none, table.materials))
        })
}

/// The loop that chooses all laws but that of adhesion at each contact, if the table has no other adhesion than `A`.
fn any_loop_of<A: AdhesionLaw + OneOf<AnyAdhesion>>(
    table: &LawTable,
) -> Option<Box<dyn ContactForces>> {
    let laws = table.narrow::<AnyNormal, AnyTangential, AnyRolling, A>()?;
    Some(Box::new(ContactLoop::new(laws, table.materials)))
}

/// Loop with liquid bridges of which contacts keep `M` numbers.
#[cfg(not(test))]
fn wet_loop_of<N, T, R, const M: usize>(table: &LawTable) -> Option<Box<dyn ContactForces>>
where
    N: NormalLaw + OneOf<AnyNormal>,
    T: TangentialLaw + OneOf<AnyTangential>,
    R: RollingLaw + OneOf<AnyRolling>,
{
    let laws = table.narrow::<N, T, R, LiquidLaw<M>>()?;
    Some(Box::new(ContactLoop::new(laws, table.materials)))
}

/// The loop compiled for these three laws without adhesion, if the table has no others.
fn loop_of<N, T, R>(table: &LawTable) -> Option<Box<dyn ContactForces>>
where
    N: NormalLaw + OneOf<AnyNormal>,
    T: TangentialLaw + OneOf<AnyTangential>,
    R: RollingLaw + OneOf<AnyRolling>,
{
    let laws = table.narrow::<N, T, R, NoAdhesion>()?;
    Some(Box::new(ContactLoop::new(laws, table.materials)))
}
