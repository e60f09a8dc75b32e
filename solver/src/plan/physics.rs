//! What a run simulates.

use std::sync::Arc;

use glam::DVec3;

use super::Carried;
use super::getters;
use super::guard::Guard;
use crate::bodies::{Clump, NewBody};
use crate::boundaries::{DeletionPlan, InsertionPlan, Setting};
use crate::contact::SlidingNormal;
use crate::contact::registry::LawTable;
use crate::liquid::LiquidPlan;
use crate::membrane::MembranePlan;
use crate::neighbours::Images;
use crate::spray::SprayPlan;
use crate::state::{Material, NewParticle};
use crate::surface::SurfacePlan;
use crate::walls::Wall;
use crate::wear::WearPlan;

/// What a run simulates: everything that decides how its particles move.
#[derive(Debug, Clone)]
pub struct Physics {
    pub(super) seed: u64,
    pub(super) gravity: DVec3,
    pub(super) dimensions: u8,
    pub(super) time_step: f64,
    pub(super) steps: u64,
    pub(super) until_at_rest: bool,
    pub(super) domain_min: DVec3,
    pub(super) domain_max: DVec3,
    pub(super) periodic: [bool; 3],
    pub(super) materials: Vec<Material>,
    pub(super) laws: LawTable,
    pub(super) sliding_normal: SlidingNormal,
    pub(super) wall_curvature: bool,
    pub(super) startup_increment: bool,
    pub(super) contact_point_mass: bool,
    pub(super) guard: Guard,
    pub(super) liquid: Option<LiquidPlan>,
    pub(super) sprays: Option<SprayPlan>,
    pub(super) walls: Vec<Wall>,
    pub(super) wear: Vec<WearPlan>,
    pub(super) surfaces: Vec<SurfacePlan>,
    pub(super) membranes: Vec<MembranePlan>,
    pub(super) particles: Vec<NewParticle>,
    pub(super) clumps: Vec<Clump>,
    pub(super) bodies: Vec<NewBody>,
    pub(super) carried: Option<Arc<Carried>>,
    pub(super) insertions: Vec<InsertionPlan>,
    pub(super) deletions: Vec<DeletionPlan>,
    pub(super) smallest_radius: f64,
    pub(super) mean_radius: f64,
    pub(super) largest_radius: f64,
    pub(super) orientations: bool,
    pub(super) energy_budget: bool,
}

impl Physics {
    getters! {
        /// Seed of every random choice.
        copy seed: u64;
        /// Gravity, m/s^2.
        copy gravity: DVec3;
        /// 3, or 2 for discs.
        copy dimensions: u8;
        /// Time step, s.
        copy time_step: f64;
        /// Steps to make.
        copy steps: u64;
        /// Also ends when the particles have come to rest.
        copy until_at_rest: bool;
        /// Lower corner of the domain, m.
        copy domain_min: DVec3;
        /// Upper corner of the domain, m.
        copy domain_max: DVec3;
        /// Periodic axes.
        copy periodic: [bool; 3];
        /// Materials in the order of the file.
        borrow materials: [Material];
        /// Laws of all pairs of materials.
        borrow laws: LawTable;
        /// Against which normal velocities of sliding, rolling and torsion are taken.
        copy sliding_normal: SlidingNormal;
        /// R* includes the curvature of walls.
        copy wall_curvature: bool;
        /// Springs advance in the force evaluation before the first step.
        copy startup_increment: bool;
        /// Contacts of clumps are damped by the mass at the contact point instead of that of the whole body.
        copy contact_point_mass: bool;
        /// What a run may not do in silence.
        copy guard: Guard;
        /// Films at the start and rules for liquid, in scenes that have any.
        borrow liquid: Option<LiquidPlan>;
        /// Nozzles, in scenes that have any.
        borrow sprays: Option<SprayPlan>;
        /// Walls.
        borrow walls: [Wall];
        /// How walls wear: at most one entry for each, of meshes alone, in their order.
        borrow wear: [WearPlan];
        /// Sheets.
        borrow surfaces: [SurfacePlan];
        /// Their mechanics, in the same order; none of sheets without inner forces.
        borrow membranes: [MembranePlan];
        /// Particles of the start, in the order of their ids.
        borrow particles: [NewParticle];
        /// Templates of rigid bodies, in the order of the file.
        borrow clumps: [Clump];
        /// Bodies of the start, in the order of their ids, which follow those of `particles`.
        borrow bodies: [NewBody];
        /// Contacts of the start that go on from other runs.
        borrow carried: Option<Arc<Carried>>;
        /// Insertions.
        borrow insertions: [InsertionPlan];
        /// Deletions.
        borrow deletions: [DeletionPlan];
        /// Smallest radius that can occur, m; 0 if there is none.
        copy smallest_radius: f64;
        /// Mean radius expected, m; 0 if there is none.
        copy mean_radius: f64;
        /// Largest radius that can occur, m; 0 if there is none.
        copy largest_radius: f64;
        /// Whether rotations are integrated: something writes them.
        copy orientations: bool;
        /// Whether the energy is audited in every step.
        copy energy_budget: bool;
    }

    /// Smallest, mean and largest radius, m.
    #[must_use]
    pub fn radii(&self) -> [f64; 3] {
        [self.smallest_radius, self.mean_radius, self.largest_radius]
    }

    /// The periodic images of the domain.
    #[must_use]
    pub fn images(&self) -> Images {
        Images::new(self.domain_min, self.domain_max, self.periodic)
    }

    /// Whether rigid bodies are there or come.
    #[must_use]
    pub fn has_bodies(&self) -> bool {
        let mut mixtures = self.insertions.iter().flat_map(|plan| &plan.mixture);
        !self.bodies.is_empty() || mixtures.any(|part| part.clump.is_some())
    }

    /// The setting of its boundaries, beside the insertions and deletions.
    #[must_use]
    pub fn setting(&self) -> Setting<'_> {
        Setting {
            domain: (self.domain_min, self.domain_max),
            periodic: self.periodic,
            dimensions: self.dimensions,
            materials: &self.materials,
            clumps: &self.clumps,
            time_step: self.time_step,
            seed: self.seed,
        }
    }
}
