//! From the laws that a scene names to one compiled contact loop.

use super::{
    AnyNormal, AnyRolling, AnyTangential, Hertz, Linear, LinearFriction, Luding, Mindlin,
    MindlinRescaled, NoFriction, NoRolling, PairLaw, Plastic,
};
use crate::forces::{ContactForces, ContactLoop};

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

    /// Whether every pair has the parts that `same` accepts.
    fn all(&self, same: impl Fn(&AnyPairLaw) -> bool) -> bool {
        self.laws.iter().flatten().all(same)
    }

    /// The table with its parts narrowed to concrete laws; pairs that never meet get the law of some pair that does.
    fn narrow<N: Copy, T: Copy, R: Copy>(
        &self,
        normal: impl Fn(AnyNormal) -> Option<N>,
        tangential: impl Fn(AnyTangential) -> Option<T>,
        rolling: impl Fn(AnyRolling) -> Option<R>,
    ) -> Option<Vec<PairLaw<N, T, R>>> {
        let narrow = |law: &AnyPairLaw| {
            Some(PairLaw {
                normal: normal(law.normal)?,
                tangential: tangential(law.tangential)?,
                rolling: rolling(law.rolling)?,
            })
        };
        let some = narrow(self.laws.iter().flatten().next()?)?;
        Some(
            self.laws
                .iter()
                .map(|law| law.as_ref().and_then(&narrow).unwrap_or(some))
                .collect(),
        )
    }
}

/// The contact loop for a table of laws: a specialised one where all pairs agree in their kinds of law, the dispatching one
/// otherwise. Also its name, for the plan.
#[must_use]
pub fn contact_loop(table: &LawTable) -> (Box<dyn ContactForces>, String) {
    // One line for each law: its name, the test whether a pair uses it, and the way to its parameters.
    macro_rules! choose_rolling {
        ($n:expr, $t:expr, $name:expr) => {
            if table.all(|law| law.rolling == AnyRolling::None) {
                let laws = table.narrow($n, $t, |_| Some(NoRolling));
                return finish(laws, table, $name, "no rolling");
            } else if table.all(|law| matches!(law.rolling, AnyRolling::Luding(_))) {
                let rolling = |law| match law {
                    AnyRolling::Luding(law) => Some::<Luding>(law),
                    AnyRolling::None => None,
                };
                return finish(table.narrow($n, $t, rolling), table, $name, "luding");
            }
        };
    }
    macro_rules! choose_tangential {
        ($n:expr, $normal:literal) => {
            if table.all(|law| law.tangential == AnyTangential::None) {
                choose_rolling!($n, |_| Some(NoFriction), concat!($normal, ", frictionless"));
            } else if table.all(|law| matches!(law.tangential, AnyTangential::Linear(_))) {
                let tangential = |law| match law {
                    AnyTangential::Linear(law) => Some::<LinearFriction>(law),
                    _ => None,
                };
                choose_rolling!($n, tangential, concat!($normal, ", linear friction"));
            } else if table.all(|law| matches!(law.tangential, AnyTangential::Mindlin(_))) {
                let tangential = |law| match law {
                    AnyTangential::Mindlin(law) => Some::<Mindlin>(law),
                    _ => None,
                };
                choose_rolling!($n, tangential, concat!($normal, ", mindlin"));
            } else if table.all(|law| matches!(law.tangential, AnyTangential::MindlinRescaled(_))) {
                let tangential = |law| match law {
                    AnyTangential::MindlinRescaled(law) => Some::<MindlinRescaled>(law),
                    _ => None,
                };
                choose_rolling!($n, tangential, concat!($normal, ", rescaled mindlin"));
            }
        };
    }
    if table.all(|law| matches!(law.normal, AnyNormal::Linear(_))) {
        let normal = |law| match law {
            AnyNormal::Linear(law) => Some::<Linear>(law),
            _ => None,
        };
        choose_tangential!(normal, "linear");
    } else if table.all(|law| matches!(law.normal, AnyNormal::Hertz(_))) {
        let normal = |law| match law {
            AnyNormal::Hertz(law) => Some::<Hertz>(law),
            _ => None,
        };
        choose_tangential!(normal, "hertz");
    } else if table.all(|law| matches!(law.normal, AnyNormal::Plastic(_))) {
        let normal = |law| match law {
            AnyNormal::Plastic(law) => Some::<Plastic>(law),
            _ => None,
        };
        choose_tangential!(normal, "plastic");
    }
    let laws = table.narrow(Some, Some, Some);
    finish(laws, table, "mixed laws", "chosen for each pair")
}

fn finish<N, T, R>(
    laws: Option<Vec<PairLaw<N, T, R>>>,
    table: &LawTable,
    name: &str,
    rolling: &str,
) -> (Box<dyn ContactForces>, String)
where
    N: super::NormalLaw,
    T: super::TangentialLaw,
    R: super::RollingLaw,
{
    // Without any pair of laws nothing ever touches; the loop then never looks at the table.
    let laws = laws.unwrap_or_default();
    (
        Box::new(ContactLoop::new(laws, table.materials)),
        format!("{name}, {rolling}"),
    )
}
