//! The one list of the parts of a step.

use std::any::Any;

use super::{Core, CriticalStep, Engine, Part, SizeEstimate};
use crate::audit::Auditor;
use crate::bonds::Bonds;
use crate::guard::GuardPart;
use crate::liquid::Liquids;
use crate::membrane::Membranes;
use crate::physics::{Plans, Setup};
use crate::spray::Sprays;
use crate::tracks::Tracks;
use crate::walls::LoadSeries;
use crate::wear::Wear;

/// A kind of part, before there is one.
struct PartKind {
    of: fn(&mut Core) -> Option<Box<dyn Part>>,
    bytes: fn(&Setup, &SizeEstimate) -> f64,
    critical_step: fn(&Plans) -> Option<CriticalStep>,
}

const fn kind<P: Part>() -> PartKind {
    PartKind {
        of: |core| P::of(core).map(|part| Box::new(part) as Box<dyn Part>),
        bytes: P::bytes,
        critical_step: P::critical_step,
    }
}

/// All parts, in the order in which each place of the step calls them. Forces from outside follow.
const PARTS: &[PartKind] = &[
    // Sheets move and are loaded before others look at them.
    kind::<Membranes>(),
    kind::<Sprays>(),
    // The audit reads masses before liquid changes them.
    kind::<Auditor>(),
    kind::<Liquids>(),
    kind::<Tracks>(),
    kind::<LoadSeries>(),
    kind::<Wear>(),
    kind::<Bonds>(),
    // What is beyond a limit stops the run when all others have made their step.
    kind::<GuardPart>(),
];

/// The parts of a plan.
pub(super) fn all(core: &mut Core) -> Vec<Box<dyn Part>> {
    PARTS.iter().filter_map(|kind| (kind.of)(core)).collect()
}

/// Memory that the parts of a setup take together ([`Part::bytes`]).
#[must_use]
pub fn bytes_of_parts(setup: &Setup, crowd: &SizeEstimate) -> f64 {
    PARTS.iter().map(|kind| (kind.bytes)(setup, crowd)).sum()
}

/// The least critical step of what acts beside the contacts ([`Part::critical_step`]).
#[must_use]
pub fn critical_step(plans: &Plans) -> Option<CriticalStep> {
    let all = PARTS.iter().filter_map(|kind| (kind.critical_step)(plans));
    all.min_by(|one, other| one.time.total_cmp(&other.time))
}

impl Engine {
    /// The part of this type, if the plan has it.
    #[must_use]
    pub fn part<P: Part>(&self) -> Option<&P> {
        let mut parts = self.parts.iter();
        parts.find_map(|part| (part.as_ref() as &dyn Any).downcast_ref())
    }

    /// All parts, in the order in which each place of the step calls them.
    pub fn parts(&self) -> impl Iterator<Item = &dyn Part> {
        self.parts.iter().map(AsRef::as_ref)
    }

    /// The part of this type, if the plan has it, and the core, both to be changed.
    pub fn part_and_core<P: Part>(&mut self) -> Option<(&mut P, &mut Core)> {
        let mut parts = self.parts.iter_mut();
        let part = parts.find_map(|part| (part.as_mut() as &mut dyn Any).downcast_mut())?;
        Some((part, &mut self.core))
    }

    /// Warnings for the user at the end of the run, a line each.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let parts = self.parts.iter();
        parts.flat_map(|part| part.warnings(&self.core)).collect()
    }
}
