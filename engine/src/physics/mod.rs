//! What a run simulates: what an engine starts from.

mod event;
mod guard;
mod inputs;
mod sizes;
mod watched;

pub use event::Event;
pub use guard::{Guard, GuardPolicy};
pub use inputs::{InputError, Inputs};
pub use sizes::{Sizes, radii};
pub use watched::{Setup, ToSetup, Tracking, Watched};

use std::sync::Arc;

use glam::DVec3;

use crate::bodies::{Clump, NewBody};
use crate::boundaries::{DeletionPlan, InsertionPlan, Setting};
use crate::contact::SlidingNormal;
use crate::contact::registry::LawTable;
use crate::forces::SavedSlots;
use crate::liquid::LiquidPlan;
use crate::membrane::MembranePlan;
use crate::neighbours::Images;
use crate::spray::SprayPlan;
use crate::state::{Material, NewParticle};
use crate::surface::SurfacePlan;
use crate::walls::Wall;
use crate::wear::WearPlan;

/// Contacts that continue from other runs, by rows in the order of the ids of the start.
#[derive(Debug, Clone, PartialEq)]
pub struct Carried {
    /// Those of pairs.
    pub pairs: SavedSlots,
    /// Those with walls.
    pub near_walls: SavedSlots,
}

/// What a run simulates: everything that decides how its particles move. Made by [`Inputs::physics`], consistent, and never changed.
#[derive(Debug, Clone)]
pub struct Physics {
    inputs: Inputs,
    sizes: Sizes,
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

    /// What it was made of.
    #[must_use]
    pub fn inputs(&self) -> &Inputs {
        &self.inputs
    }

    /// Seed of every random choice.
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.inputs.seed
    }

    /// Gravity, m/s^2.
    #[must_use]
    pub fn gravity(&self) -> DVec3 {
        self.inputs.gravity
    }

    /// 3, or 2 for discs.
    #[must_use]
    pub fn dimensions(&self) -> u8 {
        self.inputs.dimensions
    }

    /// Time step, s.
    #[must_use]
    pub fn time_step(&self) -> f64 {
        self.inputs.time_step
    }

    /// Steps to make.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.inputs.steps
    }

    /// Also ends when the particles have come to rest.
    #[must_use]
    pub fn until_at_rest(&self) -> bool {
        self.inputs.until_at_rest
    }

    /// Lower corner of the domain, m.
    #[must_use]
    pub fn domain_min(&self) -> DVec3 {
        self.inputs.domain_min
    }

    /// Upper corner of the domain, m.
    #[must_use]
    pub fn domain_max(&self) -> DVec3 {
        self.inputs.domain_max
    }

    /// Periodic axes.
    #[must_use]
    pub fn periodic(&self) -> [bool; 3] {
        self.inputs.periodic
    }

    /// Materials in the order of the file.
    #[must_use]
    pub fn materials(&self) -> &[Material] {
        &self.inputs.materials
    }

    /// Laws of all pairs of materials.
    #[must_use]
    pub fn laws(&self) -> &LawTable {
        &self.inputs.laws
    }

    /// Against which normal velocities of sliding, rolling and torsion are taken.
    #[must_use]
    pub fn sliding_normal(&self) -> SlidingNormal {
        self.inputs.sliding_normal
    }

    /// R* includes the curvature of walls.
    #[must_use]
    pub fn wall_curvature(&self) -> bool {
        self.inputs.wall_curvature
    }

    /// Springs advance in the force evaluation before the first step.
    #[must_use]
    pub fn startup_increment(&self) -> bool {
        self.inputs.startup_increment
    }

    /// Contacts of clumps are damped by the mass at the contact point instead of that of the whole body.
    #[must_use]
    pub fn contact_point_mass(&self) -> bool {
        self.inputs.contact_point_mass
    }

    /// What a run may not do in silence.
    #[must_use]
    pub fn guard(&self) -> Guard {
        self.inputs.guard
    }

    /// Films at the start and rules for liquid, in scenes that have any.
    #[must_use]
    pub fn liquid(&self) -> &Option<LiquidPlan> {
        &self.inputs.liquid
    }

    /// Nozzles, in scenes that have any.
    #[must_use]
    pub fn sprays(&self) -> &Option<SprayPlan> {
        &self.inputs.sprays
    }

    /// Walls.
    #[must_use]
    pub fn walls(&self) -> &[Wall] {
        &self.inputs.walls
    }

    /// How walls wear: at most one entry for each, of meshes alone, in their order.
    #[must_use]
    pub fn wear(&self) -> &[WearPlan] {
        &self.inputs.wear
    }

    /// Sheets.
    #[must_use]
    pub fn surfaces(&self) -> &[SurfacePlan] {
        &self.inputs.surfaces
    }

    /// Their mechanics, in the same order; none of sheets without inner forces.
    #[must_use]
    pub fn membranes(&self) -> &[MembranePlan] {
        &self.inputs.membranes
    }

    /// Particles of the start, in the order of their ids.
    #[must_use]
    pub fn particles(&self) -> &[NewParticle] {
        &self.inputs.particles
    }

    /// Templates of rigid bodies, in the order of the file.
    #[must_use]
    pub fn clumps(&self) -> &[Clump] {
        &self.inputs.clumps
    }

    /// Bodies of the start, in the order of their ids, which follow those of `particles`.
    #[must_use]
    pub fn bodies(&self) -> &[NewBody] {
        &self.inputs.bodies
    }

    /// Contacts of the start that go on from other runs.
    #[must_use]
    pub fn carried(&self) -> &Option<Arc<Carried>> {
        &self.inputs.carried
    }

    /// Insertions.
    #[must_use]
    pub fn insertions(&self) -> &[InsertionPlan] {
        &self.inputs.insertions
    }

    /// Deletions.
    #[must_use]
    pub fn deletions(&self) -> &[DeletionPlan] {
        &self.inputs.deletions
    }

    /// Whether rotations are integrated: something writes them.
    #[must_use]
    pub fn orientations(&self) -> bool {
        self.inputs.orientations
    }

    /// Whether the energy is audited in every step.
    #[must_use]
    pub fn energy_budget(&self) -> bool {
        self.inputs.energy_budget
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

    /// The periodic images of the domain.
    #[must_use]
    pub fn images(&self) -> Images {
        Images::new(
            self.inputs.domain_min,
            self.inputs.domain_max,
            self.inputs.periodic,
        )
    }

    /// Whether rigid bodies are there or come.
    #[must_use]
    pub fn has_bodies(&self) -> bool {
        let mut mixtures = self.inputs.insertions.iter().flat_map(|plan| &plan.mixture);
        !self.inputs.bodies.is_empty() || mixtures.any(|part| part.clump.is_some())
    }

    /// The setting of its boundaries, beside the insertions and deletions.
    #[must_use]
    pub fn setting(&self) -> Setting<'_> {
        Setting {
            domain: (self.inputs.domain_min, self.inputs.domain_max),
            periodic: self.inputs.periodic,
            dimensions: self.inputs.dimensions,
            materials: &self.inputs.materials,
            clumps: &self.inputs.clumps,
            time_step: self.inputs.time_step,
            seed: self.inputs.seed,
        }
    }
}
