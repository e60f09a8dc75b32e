//! The second stage: the laws of all pairs of materials that can meet.

use mercury_common::scene::{Scene, SceneError};

use super::{Findings, Parts};
use crate::liquid::plan::bridges;
use crate::plan::pair::PairPlan;
use crate::plan::usage::{MaterialUse, particles_meet, walls_meet};
use mercury_engine::contact::adhesion::liquid::Tables;
use mercury_engine::contact::mixing::resolve_pair;
use mercury_engine::contact::registry::LawTable;
use mercury_engine::contact::{AdhesionLaw, AnyAdhesion};
use mercury_engine::state::MaterialIndex;

/// The laws of a scene.
pub(super) struct Laws {
    pub(super) pairs: Vec<PairPlan>,
    /// Tables of exact bridges, where a pair needs them.
    tables: Tables,
}

impl Laws {
    /// Laws of all pairs that can meet.
    pub(super) fn of(scene: &Scene, parts: &Parts, found: &mut Findings) -> Self {
        Self {
            pairs: plan_pairs(scene, &parts.uses, &mut found.errors),
            tables: Tables::default(),
        }
    }

    /// Makes the tables of exact bridges, and notes how far bridges and dry cohesion reach.
    pub(super) fn with_bridges(
        mut self,
        scene: &Scene,
        parts: &Parts,
        found: &mut Findings,
    ) -> Self {
        let Parts {
            start,
            clumps,
            insertions,
            sizes,
            ..
        } = parts;
        bridges::larger_than_grains(scene, start, clumps, insertions, &mut found.errors);
        if found.errors.is_empty() {
            let radii = bridges::radii_of_materials(scene, start, clumps, insertions);
            (found.warnings).extend(bridges::wide_ratios(&self.pairs, &radii));
            let (remarks, errors) = (&mut found.remarks, &mut found.errors);
            bridges::poles(scene, &self.pairs, &radii, errors);
            self.tables = bridges::tables(scene, &mut self.pairs, &radii, remarks, errors);
        }
        if sizes.smallest > 0.0 && sizes.smallest.is_finite() {
            for pair in &mut self.pairs {
                match &mut pair.law.adhesion {
                    AnyAdhesion::None => {}
                    AnyAdhesion::Liquid(liquid) => {
                        *liquid = liquid.reaching(sizes.smallest, &self.tables);
                    }
                    AnyAdhesion::Dry(dry) => *dry = dry.reaching(sizes.largest),
                }
            }
            bridges::rough(scene, &self.pairs, &mut found.errors);
        }
        self
    }

    /// Largest gap across which any of them acts, m.
    pub(super) fn range(&self) -> f64 {
        let ranges = self.pairs.iter().map(|pair| pair.law.adhesion.range());
        ranges.fold(0.0, f64::max)
    }

    /// Table of laws for the engine, and the pairs for the report.
    pub(super) fn into_table(self, materials: usize) -> (LawTable, Vec<PairPlan>) {
        let mut laws = LawTable {
            materials,
            laws: vec![None; materials * materials],
            tables: self.tables,
        };
        for pair in &self.pairs {
            let [a, b] = pair.materials.map(|material| material.index());
            laws.laws[a * materials + b] = Some(pair.law);
            laws.laws[b * materials + a] = Some(pair.law);
        }
        (laws, self.pairs)
    }
}

/// Resolves every pair of materials that can meet in the scene.
fn plan_pairs(scene: &Scene, uses: &[MaterialUse], errors: &mut Vec<SceneError>) -> Vec<PairPlan> {
    let mut pairs = Vec::new();
    for a in 0..uses.len() {
        for b in a..uses.len() {
            let between_particles = particles_meet(uses, a, b);
            let at_walls = walls_meet(uses, a, b);
            if !between_particles && !at_walls {
                continue;
            }
            if let Some((law, parameters)) = resolve_pair(scene, [a, b], errors) {
                pairs.push(PairPlan {
                    materials: [MaterialIndex::new(a as u32), MaterialIndex::new(b as u32)],
                    names: [a, b].map(|index| scene.materials[index].name.value.clone()),
                    between_particles,
                    at_walls,
                    law,
                    parameters,
                });
            }
        }
    }
    pairs
}
