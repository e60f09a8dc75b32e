//! Physics of a run, from which an engine starts.

mod event;
mod inputs;
mod plans;
mod sizes;
mod watched;

pub use event::ScheduledChange;
pub use inputs::{InputError, Inputs};
pub(crate) use inputs::{number, positive, present};
pub use plans::{FeaturePlan, Plans};
pub use sizes::{Sizes, radii};
pub use watched::{Setup, ToSetup, Watched};

use std::ops::Deref;

use mercury_common::particle_properties::ParticleProperty;

use crate::boundaries::BoundaryContext;
use crate::cell::Cell;
use crate::forces::SavedSlots;

/// Contacts that continue from other runs, by rows in the order of the ids of the start.
#[derive(Debug, Clone, PartialEq)]
pub struct Carried {
    /// Histories of pairs.
    pub pairs: SavedSlots,
    /// Histories of contacts with walls.
    pub near_walls: SavedSlots,
}

/// Physics of a run: everything that decides how its particles move. Made by [`Inputs::physics`], consistent, and never changed.
///
/// Its numbers are the fields of the [`Inputs`]: `physics.time_step`. The functions here compute.
#[derive(Debug, Clone)]
pub struct Physics {
    inputs: Inputs,
    sizes: Sizes,
}

impl Deref for Physics {
    type Target = Inputs;

    fn deref(&self) -> &Inputs {
        &self.inputs
    }
}

impl Physics {
    /// Names the walls that move into the region of each insertion, which counts what it places behind them.
    #[must_use]
    pub fn with_closing_walls(mut self, closing: Vec<Vec<usize>>) -> Self {
        for (insertion, walls) in self.inputs.insertions.iter_mut().zip(closing) {
            insertion.closing = walls;
        }
        self
    }

    /// Drops the spheres and bodies of the start, which a plan holds beside the particles that are made of them. What was found of them stays.
    pub(crate) fn forget_grains(&mut self) {
        self.inputs.particles = Vec::new();
        self.inputs.bodies = Vec::new();
        self.inputs.start_values = Vec::new();
    }

    /// Inputs that it was made of.
    #[must_use]
    pub fn inputs(&self) -> &Inputs {
        &self.inputs
    }

    /// Smallest radius that can occur, m; 0 if there is none.
    #[must_use]
    pub fn smallest_radius(&self) -> f64 {
        self.sizes.smallest
    }

    /// Mean radius expected, m; 0 if there is none.
    #[must_use]
    pub fn mean_radius(&self) -> f64 {
        self.sizes.mean
    }

    /// Largest radius that can occur, m; 0 if there is none.
    #[must_use]
    pub fn largest_radius(&self) -> f64 {
        self.sizes.largest
    }

    /// Smallest, mean and largest radius, m.
    #[must_use]
    pub fn radii(&self) -> [f64; 3] {
        [self.sizes.smallest, self.sizes.mean, self.sizes.largest]
    }

    /// Whether all particles have a property.
    #[must_use]
    pub fn has_property(&self, property: &ParticleProperty) -> bool {
        self.inputs.properties.contains(&property)
    }

    /// Whether rigid bodies are there or come.
    #[must_use]
    pub fn has_bodies(&self) -> bool {
        let mut mixtures = self.inputs.insertions.iter().flat_map(|plan| &plan.mixture);
        !self.inputs.bodies.is_empty() || mixtures.any(|part| part.clump.is_some())
    }

    /// The setting of its boundaries in the present cell, beside the insertions and deletions.
    #[must_use]
    pub fn setting<'a>(&'a self, cell: &'a Cell) -> BoundaryContext<'a> {
        BoundaryContext {
            cell,
            dimensions: self.inputs.dimensions,
            materials: &self.inputs.materials,
            clumps: &self.inputs.clumps,
            time_step: self.inputs.time_step,
            seed: self.inputs.seed,
        }
    }
}
