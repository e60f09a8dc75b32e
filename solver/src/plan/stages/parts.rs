//! The first stage: what is in a scene, part by part, before anything is known of how the parts meet.

use mercury_common::scene::{Dimensions, Scene};

use super::Findings;
use crate::plan::bonds::{bonded_start, bonds};
use crate::plan::fields::{FieldPlan, fields};
use crate::plan::fluxes::fluxes;
use crate::plan::insertions::{deletions, insertions};
use crate::plan::membranes::{Sheets, membranes};
use crate::plan::particles::{StartingParticles, starting_particles};
use crate::plan::regions::{DomainBox, regions};
use crate::plan::sprays::sprays;
use crate::plan::usage::{MaterialUse, material_uses};
use crate::plan::walls::walls;
use mercury_engine::bodies::Clump;
use mercury_engine::bonds::{BondPlan, BondedStart};
use mercury_engine::boundaries::{CountedRegion, DeletionPlan, FluxPlan, InsertionPlan};
use mercury_engine::physics::Sizes;
use mercury_engine::spray::SprayPlan;
use mercury_engine::walls::Wall;

/// Parts of a scene.
pub(super) struct Parts {
    /// 2 or 3.
    pub(super) dimensions: u8,
    pub(super) walls: Vec<Wall>,
    pub(super) clumps: Vec<Clump>,
    pub(super) start: StartingParticles,
    pub(super) insertions: Vec<InsertionPlan>,
    pub(super) sprays: Option<SprayPlan>,
    pub(super) regions: Vec<CountedRegion>,
    pub(super) deletions: Vec<DeletionPlan>,
    pub(super) fluxes: Vec<FluxPlan>,
    pub(super) fields: Vec<FieldPlan>,
    pub(super) sheets: Sheets,
    pub(super) bonds: Vec<BondPlan>,
    /// What they glue at the start, where there are any.
    pub(super) bonded: Option<BondedStart>,
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
        let sprays = sprays(scene, &walls, dimensions, warnings, errors);
        let regions = regions(scene, &room, warnings, errors);
        let deletions = deletions(scene, warnings, errors);
        let fluxes = fluxes(scene, errors);
        let fields = fields(scene, &start, &clumps, &insertions, warnings, errors);
        let sheets = membranes(scene, &walls, warnings, remarks, errors);
        let mut uses = material_uses(scene, &start, &clumps, &insertions, &walls);
        for (material, used) in uses.iter_mut().enumerate() {
            used.lightest_vertex = sheets.lightest_vertex(material);
        }
        let bonds = bonds(scene, &walls, warnings, errors);
        let around = (clumps.as_slice(), walls.as_slice());
        let bonded = bonded_start(scene, &bonds, &start, around, &uses, errors);
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
            sprays,
            regions,
            deletions,
            fluxes,
            fields,
            sheets,
            bonds,
            bonded,
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
