//! The first stage: what is in a scene, part by part, before anything is known of how the parts meet.

use mercury_common::scene::{Dimensions, Scene};

use super::Findings;
use crate::bonds::plan::{bonded_start, bonds};
use crate::boundaries::plan::fluxes::fluxes;
use crate::boundaries::plan::insertions::{deletions, insertions};
use crate::boundaries::plan::regions::{DomainBox, regions};
use crate::membranes::plan::{lightest_vertex, membranes};
use crate::plan::fields::{FieldPlan, fields};
use crate::plan::particles::{StartingParticles, starting_particles};
use crate::plan::usage::{MaterialUse, material_uses};
use crate::plan::walls::walls;
use crate::sprays::plan::sprays;
use crate::wear::plan::wear;
use mercury_engine::bodies::Clump;
use mercury_engine::boundaries::{CountedRegion, DeletionPlan, FluxPlan, InsertionPlan};
use mercury_engine::physics::{Plans, Sizes};
use mercury_engine::walls::Wall;

/// Parts of a scene.
pub(super) struct Parts {
    /// 2 or 3.
    pub(super) dimensions: u8,
    pub(super) walls: Vec<Wall>,
    pub(super) clumps: Vec<Clump>,
    pub(super) start: StartingParticles,
    pub(super) insertions: Vec<InsertionPlan>,
    pub(super) regions: Vec<CountedRegion>,
    pub(super) deletions: Vec<DeletionPlan>,
    pub(super) fluxes: Vec<FluxPlan>,
    pub(super) fields: Vec<FieldPlan>,
    /// Plans of features but liquid, which depends on the time step.
    pub(super) plans: Plans,
    /// How each material is used.
    pub(super) uses: Vec<MaterialUse>,
    /// Sizes of all particles, of the start and of insertions.
    pub(super) sizes: Sizes,
}

impl Parts {
    /// The parts of a scene, with at most so many sites of each lattice.
    pub(super) fn of(scene: &Scene, most_sites: u64, found: &mut Findings) -> Self {
        let Findings {
            errors,
            warnings,
            remarks,
        } = found;
        let dimensions = match scene.domain.dimensions {
            Dimensions::Two => 2,
            Dimensions::Three => 3,
        };
        let clumps = crate::plan::clumps::clumps(scene, warnings, remarks, errors);
        let mut start = starting_particles(scene, clumps.as_deref(), most_sites, warnings, errors);
        remarks.append(&mut start.remarks);
        let walls = walls(scene, &start.walls, warnings, remarks, errors);
        let room = DomainBox::of(scene, &start);
        let clumps_of = clumps.as_deref();
        let insertions = insertions(scene, &room, clumps_of, dimensions, warnings, errors);
        let clumps = clumps.unwrap_or_default();
        let mut plans = Plans::default();
        plans
            .all_mut()
            .extend(sprays(scene, &walls, dimensions, warnings, errors));
        let regions = regions(scene, &room, warnings, errors);
        let deletions = deletions(scene, warnings, errors);
        let fluxes = fluxes(scene, errors);
        let fields = fields(scene, &start, &clumps, &insertions, warnings, errors);
        plans.all_mut().extend(wear(scene, &walls));
        membranes(scene, &walls, &mut plans, warnings, remarks, errors);
        let mut uses = material_uses(scene, &start, &clumps, &insertions, &walls);
        for (material, used) in uses.iter_mut().enumerate() {
            used.lightest_vertex = lightest_vertex(&plans, material);
        }
        let bonds = bonds(scene, &walls, warnings, errors);
        let around = (clumps.as_slice(), walls.as_slice());
        let bonded = bonded_start(scene, &bonds, &start, around, &uses, errors);
        plans.all_mut().extend(bonds);
        plans.all_mut().extend(bonded);
        let sizes = Sizes::of(
            &densities(scene),
            (&start.particles, &start.bodies),
            &clumps,
            &insertions,
            dimensions,
        );
        Self {
            dimensions,
            walls,
            clumps,
            start,
            insertions,
            regions,
            deletions,
            fluxes,
            fields,
            plans,
            uses,
            sizes,
        }
    }
}

/// Densities of the materials, kg/m^3.
pub(super) fn densities(scene: &Scene) -> Vec<f64> {
    scene
        .materials
        .iter()
        .map(|material| *material.density)
        .collect()
}
