//! The histories of contacts in the form in which outputs show them.

use crate::contact::{
    AdhesionLaw, History, HistoryNumber, NormalLaw, PairLaw, RollingLaw, TangentialLaw,
};

/// The columns that hold the histories of all contacts. Laws with the same numbers share columns; the numbers of other laws are
/// zero.
#[derive(Debug)]
pub(super) struct Memory {
    /// Unit and meaning of each.
    pub(super) columns: Vec<HistoryNumber>,
    /// For each pair of materials: the first column of the normal, the tangential, the rolling and the adhesion law.
    first: Vec<[usize; 4]>,
}

impl Memory {
    /// For the laws of all pairs of materials.
    pub(super) fn of<N, T, R, A>(laws: &[PairLaw<N, T, R, A>]) -> Self
    where
        N: NormalLaw,
        T: TangentialLaw,
        R: RollingLaw,
        A: AdhesionLaw,
    {
        let parts = [
            laws.iter().map(|law| law.normal.columns()).collect(),
            laws.iter().map(|law| law.tangential.columns()).collect(),
            laws.iter().map(|law| law.rolling.columns()).collect(),
            laws.iter().map(|law| law.adhesion.columns()).collect(),
        ];
        Self::arranged(parts)
    }

    /// From the columns of the four parts of each law.
    fn arranged(parts: [Vec<Vec<HistoryNumber>>; 4]) -> Self {
        let mut columns = Vec::new();
        let mut first = vec![[0; 4]; parts[0].len()];
        for (part, of_laws) in parts.iter().enumerate() {
            for (law, own) in of_laws.iter().enumerate() {
                first[law][part] = match of_laws[..law].iter().position(|other| other == own) {
                    Some(other) => first[other][part],
                    None => {
                        columns.extend_from_slice(own);
                        columns.len() - own.len()
                    }
                };
            }
        }
        Self { columns, first }
    }

    /// The numbers of one contact, whose law has this index.
    pub(super) fn show<N: History, T: History, R: History, A: History>(
        &self,
        pair: usize,
        (normal, tangential, rolling, adhesion): &(N, T, R, A),
    ) -> Vec<f64> {
        let mut parts = [const { Vec::new() }; 4];
        normal.show(&mut parts[0]);
        tangential.show(&mut parts[1]);
        rolling.show(&mut parts[2]);
        adhesion.show(&mut parts[3]);
        let mut numbers = vec![0.0; self.columns.len()];
        for (own, first) in parts.iter().zip(self.first[pair]) {
            numbers[first..first + own.len()].copy_from_slice(own);
        }
        numbers
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::normal::{AnyNormalHistory, MaxOverlap};
    use crate::contact::registry::AnyPairLaw;
    use crate::contact::rolling::AnyRollingHistory;
    use crate::contact::tangential::{AnyTangentialHistory, StoredForce};
    use crate::contact::{
        AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, CoulombLimits, Hertz, LinearFriction,
        Mindlin, MindlinRescaled, Plastic, SpringRotation, TangentialSpring,
    };
    use crate::lanes::Vector;

    fn law(normal: AnyNormal, tangential: AnyTangential) -> AnyPairLaw {
        AnyPairLaw {
            normal,
            tangential,
            rolling: AnyRolling::None,
            adhesion: AnyAdhesion::None,
        }
    }

    #[test]
    fn laws_that_remember_the_same_share_their_columns() {
        let hertz = AnyNormal::Hertz(Hertz::new(1e7, 0.1));
        let plastic = AnyNormal::Plastic(Plastic {
            loading_stiffness: 1e4,
            unloading_stiffness: 2e4,
            cohesion_stiffness: 0.0,
            penetration_depth: 0.05,
            dissipation: 0.0,
            clamp_tension: false,
        });
        let linear = AnyTangential::Linear(LinearFriction {
            stiffness: 1e3,
            dissipation: 0.0,
            friction: 0.5,
            static_friction: 0.5,
            rotation: SpringRotation::Project,
            limits: CoulombLimits::Bounded,
        });
        let plain = Mindlin::new(3e6, 1.0, 0.1, 0.5, 0.5);
        let mindlin = AnyTangential::Mindlin(plain);
        let rescaled = AnyTangential::MindlinRescaled(MindlinRescaled { plain });

        let memory = Memory::of(&[law(hertz, mindlin), law(plastic, linear)]);
        let meanings: Vec<&str> = memory.columns.iter().map(|column| column.1).collect();
        assert_eq!(
            meanings,
            [
                "largest overlap so far",
                "tangential spring x",
                "tangential spring y",
                "tangential spring z"
            ]
        );
        let spring = TangentialSpring(Vector::new(1.0, 2.0, 3.0));
        let mindlins = (
            AnyNormalHistory::Hertz(()),
            AnyTangentialHistory::Mindlin(spring),
            AnyRollingHistory::Empty,
            (),
        );
        let linears = (
            AnyNormalHistory::Plastic(MaxOverlap(4.0)),
            AnyTangentialHistory::Linear(spring),
            AnyRollingHistory::Empty,
            (),
        );
        assert_eq!(memory.show(0, &mindlins), [0.0, 1.0, 2.0, 3.0]);
        assert_eq!(memory.show(1, &linears), [4.0, 1.0, 2.0, 3.0]);

        // A single law has the same columns as in a loop of its own.
        let memory = Memory::of(&[law(hertz, rescaled)]);
        assert_eq!(memory.columns, <StoredForce as History>::columns());
        // Both histories of Mindlin's laws side by side.
        let memory = Memory::of(&[law(hertz, rescaled), law(hertz, mindlin)]);
        assert_eq!(memory.columns.len(), 4 + 3);
        assert_eq!(
            memory.show(1, &mindlins),
            [0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0]
        );
        let nothing = (
            AnyNormalHistory::Empty,
            AnyTangentialHistory::Empty,
            AnyRollingHistory::Empty,
            (),
        );
        assert_eq!(memory.show(0, &nothing), [0.0; 7]);
    }
}
