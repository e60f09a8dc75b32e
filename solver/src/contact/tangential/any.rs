//! A tangential law chosen at run time, for scenes in which pairs of materials differ in law.

use glam::DVec3;

use super::super::history::TangentialSpring;
use super::{
    Contact, LinearFriction, Mindlin, MindlinRescaled, NoFriction, StoredForce, TangentialLaw,
};
use crate::contact::{History, HistoryNumber};

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
pub struct AnyTangentialHistory {
    /// Of the linear and the plain Mindlin law.
    spring: TangentialSpring,
    /// Of the rescaled law.
    stored: StoredForce,
}

impl History for AnyTangentialHistory {
    const LENGTH: usize = TangentialSpring::LENGTH + StoredForce::LENGTH;

    fn columns() -> Vec<HistoryNumber> {
        [TangentialSpring::columns(), StoredForce::columns()].concat()
    }

    fn swapped(self) -> Self {
        Self {
            spring: self.spring.swapped(),
            stored: self.stored.swapped(),
        }
    }

    fn write(&self, numbers: &mut Vec<f64>) {
        self.spring.write(numbers);
        self.stored.write(numbers);
    }

    fn read(numbers: &[f64]) -> Self {
        let (spring, stored) = numbers.split_at(TangentialSpring::LENGTH);
        Self {
            spring: TangentialSpring::read(spring),
            stored: StoredForce::read(stored),
        }
    }
}

impl TangentialLaw for AnyTangential {
    type History = AnyTangentialHistory;
    const ACTIVE: bool = true;

    #[inline]
    fn force(
        &self,
        contact: &Contact,
        normal_force: f64,
        dt: f64,
        history: &mut AnyTangentialHistory,
    ) -> DVec3 {
        match self {
            Self::None => DVec3::ZERO,
            Self::Linear(law) => law.force(contact, normal_force, dt, &mut history.spring),
            Self::Mindlin(law) => law.force(contact, normal_force, dt, &mut history.spring),
            Self::MindlinRescaled(law) => law.force(contact, normal_force, dt, &mut history.stored),
        }
    }

    fn stiffness(&self, contact: &Contact) -> f64 {
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

    fn energy(&self, contact: &Contact, history: &AnyTangentialHistory) -> f64 {
        match self {
            Self::None => 0.0,
            Self::Linear(law) => law.energy(contact, &history.spring),
            Self::Mindlin(law) => law.energy(contact, &history.spring),
            Self::MindlinRescaled(law) => law.energy(contact, &history.stored),
        }
    }
}
