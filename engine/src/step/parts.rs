//! The one list of the parts of a step.

use std::any::Any;

use super::audit::Auditor;
use super::guard::Guard;
use super::load_series::LoadSeries;
use super::tracks::Tracks;
use super::{Core, Engine, Part};
use crate::liquid::Liquids;
use crate::membrane::Membranes;
use crate::spray::Sprays;
use crate::wear::Wear;

/// The part of a plan that has this feature; it may add columns to the particles of the start.
type Begin = fn(&mut Core) -> Option<Box<dyn Part>>;

/// All parts, in the order in which each place of the step calls them. Forces from outside follow.
const PARTS: &[Begin] = &[
    // Sheets move and are loaded before others look at them.
    |core| boxed(Membranes::of(core)),
    |core| boxed(Sprays::of(core)),
    // The audit reads masses before liquid changes them.
    |core| boxed(Auditor::of(core)),
    |core| boxed(Liquids::of(core)),
    |core| boxed(Tracks::of(core)),
    |core| boxed(LoadSeries::of(core)),
    |core| boxed(Wear::of(core)),
    // What is beyond a limit stops the run when all others have made their step.
    |core| boxed(Guard::of(core)),
];

fn boxed<P: Part>(part: Option<P>) -> Option<Box<dyn Part>> {
    part.map(|part| Box::new(part) as Box<dyn Part>)
}

/// The parts of a plan.
pub(super) fn all(core: &mut Core) -> Vec<Box<dyn Part>> {
    PARTS.iter().filter_map(|begin| begin(core)).collect()
}

impl Engine {
    /// The part of this type, if the plan has it.
    #[must_use]
    pub fn part<P: Part>(&self) -> Option<&P> {
        let mut parts = self.parts.iter();
        parts.find_map(|part| (part.as_ref() as &dyn Any).downcast_ref())
    }

    /// The same, and the core to which it may do something.
    pub(crate) fn part_and_core<P: Part>(&mut self) -> Option<(&mut P, &mut Core)> {
        let mut parts = self.parts.iter_mut();
        let part = parts.find_map(|part| (part.as_mut() as &mut dyn Any).downcast_mut())?;
        Some((part, &mut self.core))
    }

    /// What a user should know at the end of the run, a line each.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let parts = self.parts.iter();
        parts.flat_map(|part| part.warnings(&self.core)).collect()
    }
}
