//! `<prefix>.regions.csv`: the content of each counted region, material by material.

use glam::DVec3;
use mercury_common::run_tables::{REGIONS, TableSpec};

use crate::output::table_file::{Rows, RunTable};
use crate::output::{Due, FrameCopy};
use crate::plan::Plan;
use mercury_engine::boundaries::CountedRegion;
use mercury_engine::state::{MaterialIndex, volume};

/// A row for each region, each material and each time of rows.
pub(crate) struct RegionCounts {
    regions: Vec<CountedRegion>,
    /// Index and name of every material of present and inserted particles, ascending.
    materials: Vec<(MaterialIndex, String)>,
    dimensions: u8,
}

impl RunTable for RegionCounts {
    const SPEC: &'static TableSpec = &REGIONS;

    fn is_wanted(plan: &Plan) -> bool {
        !plan.outputs().regions().is_empty()
    }

    fn new(plan: &Plan) -> Self {
        Self {
            regions: plan.outputs().regions().to_vec(),
            materials: materials(plan),
            dimensions: plan.physics().dimensions,
        }
    }

    fn is_due(due: Due) -> bool {
        due.rows
    }

    fn push_rows(&self, state: &FrameCopy, rows: &mut Rows<'_>) {
        for region in &self.regions {
            let contents = contents(state, region, &self.materials, self.dimensions);
            for ((_, material), content) in self.materials.iter().zip(contents) {
                // Without mass the velocity is 0: readers need not handle NaN.
                let velocity = if content.mass > 0.0 {
                    content.momentum / content.mass
                } else {
                    DVec3::ZERO
                };
                rows.number(state.time).text(&region.name).text(material);
                rows.counts([content.number]).number(content.mass);
                rows.numbers(velocity.to_array());
                rows.numbers([content.kinetic, content.volume / region.volume])
                    .end();
            }
        }
    }
}

/// The materials of particles and bodies of the start and of insertions, ascending.
#[must_use]
pub fn materials(plan: &Plan) -> Vec<(MaterialIndex, String)> {
    let particles = plan
        .physics()
        .particles
        .iter()
        .map(|particle| particle.material);
    let bodies = plan
        .physics()
        .bodies
        .iter()
        .map(|body| body.clump(&plan.physics().clumps).material);
    let mixtures = plan
        .physics()
        .insertions
        .iter()
        .flat_map(|insertion| &insertion.mixture);
    let mut used: Vec<MaterialIndex> = particles
        .chain(bodies)
        .chain(mixtures.map(|part| part.material))
        .collect();
    used.sort_unstable();
    used.dedup();
    used.into_iter()
        .map(|index| (index, plan.physics().materials[index.index()].name.clone()))
        .collect()
}

/// Amount of one material in one region.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Content {
    /// Particles and bodies.
    pub(crate) number: u64,
    /// kg
    pub(crate) mass: f64,
    /// kg m/s
    pub(crate) momentum: DVec3,
    /// Of translation, J.
    pub(crate) kinetic: f64,
    /// Of the solid, m^3.
    pub(crate) volume: f64,
}

impl Content {
    fn add(&mut self, mass: f64, velocity: DVec3, volume: f64) {
        self.number += 1;
        self.mass += mass;
        self.momentum += mass * velocity;
        self.kinetic += 0.5 * mass * velocity.length_squared();
        self.volume += volume;
    }
}

/// The content of a region, material by material; summed over spheres in the order of their ids, then over bodies in that of
/// theirs. Each counts as a whole where its centre is; fixed ones do not count.
pub(crate) fn contents(
    state: &FrameCopy,
    region: &CountedRegion,
    materials: &[(MaterialIndex, String)],
    dimensions: u8,
) -> Vec<Content> {
    let mut contents = vec![Content::default(); materials.len()];
    let place =
        |material: MaterialIndex| materials.binary_search_by_key(&material, |known| known.0);
    for (rank, particle) in state.particles.iter().enumerate() {
        if state.is_fixed(rank)
            || state.is_pebble(rank)
            || !region.region.contains(particle.position)
        {
            continue;
        }
        if let Ok(place) = place(particle.material) {
            let volume = volume(particle.radius, dimensions);
            contents[place].add(state.masses[rank], particle.velocity, volume);
        }
    }
    for body in state.bodies.iter().filter(|body| !body.is_fixed()) {
        if let (true, Ok(place)) = (region.region.contains(body.position), place(body.material)) {
            contents[place].add(body.mass, body.velocity, body.volume);
        }
    }
    contents
}
