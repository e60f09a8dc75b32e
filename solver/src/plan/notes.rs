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
        /// Counts made while the start was read and looked over.
        copy counted: Counted;
        /// Every pair of materials that can meet, with all its numbers and where they came from.
        borrow pairs: [PairPlan];
        /// Why the time step is what it is.
        borrow step: StepPlan;
        /// Warnings of likely mistakes.
        borrow warnings: [String];
        /// Further remarks for the user.
        borrow remarks: [String];
        /// The runs from which it starts.
        borrow started_from: [StartedFrom];
    }
}
