//! A tangential law chosen at run time, for scenes in which pairs of materials differ in law.

use super::super::history::TangentialSpring;
use super::{
    Contact, LinearFriction, Mindlin, MindlinRescaled, NoFriction, StoredForce, TangentialLaw,
};
use crate::contact::{History, HistoryNumber};
use crate::lanes::{Real, Vector};

/// One of the tangential laws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AnyTangential {
    /// None.
    None,
    /// Spring, dashpot, Coulomb.
    Linear(LinearFriction),
    /// Mindlin.
    Mindlin(Mindlin),
    /// Mindlin with a rescaled load history.
    MindlinRescaled(MindlinRescaled),
}

/// Room for the history of any of the laws; a contact uses one of them, by its pair of materials.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AnyTangentialHistory<L = f64> {
    /// Of the linear and the plain Mindlin law.
    spring: TangentialSpring<L>,
    /// Of the rescaled law.
    stored: StoredForce<L>,
}

impl<L: Real> History<L> for AnyTangentialHistory<L> {
    const LENGTH: usize = <TangentialSpring<L>>::LENGTH + <StoredForce<L>>::LENGTH;

    fn columns() -> Vec<HistoryNumber> {
        [
            <TangentialSpring<L>>::columns(),
            <StoredForce<L>>::columns(),
        ]
        .concat()
    }

    fn swapped(self) -> Self {
        Self {
            spring: self.spring.swapped(),
            stored: self.stored.swapped(),
        }
    }

    fn write(&self, numbers: &mut Vec<L>) {
        self.spring.write(numbers);
        self.stored.write(numbers);
    }

    fn read(numbers: &[L]) -> Self {
        let (spring, stored) = numbers.split_at(<TangentialSpring<L>>::LENGTH);
        Self {
            spring: TangentialSpring::read(spring),
            stored: StoredForce::read(stored),
        }
    }
}

impl TangentialLaw for AnyTangential {
    type History<L: Real> = AnyTangentialHistory<L>;
    const ACTIVE: bool = true;

    #[inline]
    fn force<L: Real>(
        &self,
        contact: &Contact<L>,
        normal_force: L,
        dt: f64,
        history: &mut AnyTangentialHistory<L>,
    ) -> Vector<L> {
        match self {
            Self::None => Vector::ZERO,
            Self::Linear(law) => law.force(contact, normal_force, dt, &mut history.spring),
            Self::Mindlin(law) => law.force(contact, normal_force, dt, &mut history.spring),
            Self::MindlinRescaled(law) => law.force(contact, normal_force, dt, &mut history.stored),
        }
    }

    fn stiffness<L: Real>(&self, contact: &Contact<L>) -> L {
        match self {
            Self::None => NoFriction.stiffness(contact),
            Self::Linear(law) => law.stiffness(contact),
            Self::Mindlin(law) => law.stiffness(contact),
            Self::MindlinRescaled(law) => law.stiffness(contact),
        }
    }

    fn tangential_overlap(&self, contact: &Contact, history: &AnyTangentialHistory) -> f64 {
        match self {
            Self::None => 0.0,
            Self::Linear(law) => law.tangential_overlap(contact, &history.spring),
            Self::Mindlin(law) => law.tangential_overlap(contact, &history.spring),
            Self::MindlinRescaled(law) => law.tangential_overlap(contact, &history.stored),
        }
    }

    fn energy<L: Real>(&self, contact: &Contact<L>, history: &AnyTangentialHistory<L>) -> L {
        match self {
            Self::None => L::ZERO,
            Self::Linear(law) => law.energy(contact, &history.spring),
            Self::Mindlin(law) => law.energy(contact, &history.spring),
            Self::MindlinRescaled(law) => law.energy(contact, &history.stored),
        }
    }
}
