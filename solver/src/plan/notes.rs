//! Notes on a plan.

use super::getters;
use super::{Counted, PairPlan, StartedFrom, StepPlan};

/// Notes on a plan, which decide nothing.
#[derive(Debug, Clone, Default)]
pub struct Notes {
    pub(super) counted: Counted,
    pub(super) pairs: Vec<PairPlan>,
    pub(super) step: StepPlan,
    pub(super) warnings: Vec<String>,
    pub(super) remarks: Vec<String>,
    pub(super) started_from: Vec<StartedFrom>,
}

impl Notes {
    getters! {
        /// What was counted while the start was read and looked over.
        copy counted: Counted;
        /// Every pair of materials that can meet, with all its numbers and where they came from.
        borrow pairs: [PairPlan];
        /// Why the time step is what it is.
        borrow step: StepPlan;
        /// What may be wrong with the run.
        borrow warnings: [String];
        /// What else its user should know.
        borrow remarks: [String];
        /// The runs from which it starts.
        borrow started_from: [StartedFrom];
    }
}
