//! What a run does in its steps, what it skips, and why; and the memory it needs.

use super::{Plan, expected_number};
use crate::contact::registry::contact_loop;
use crate::contact::{AnyNormal, AnyRolling, AnyTangential};
use crate::state::{Body, BodyPebble, Particle};
use crate::walls::Shape;

/// A part of the simulation that a scene may or may not need.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pass {
    /// What it is.
    pub name: &'static str,
    /// Whether the run has it.
    pub is_done: bool,
    /// Why, or how.
    pub reason: String,
}

/// Every part, in the order of a time step.
#[must_use]
pub fn passes(plan: &Plan) -> Vec<Pass> {
    let pass = |name, is_done, done: &str, skipped: &str| Pass {
        name,
        is_done,
        reason: if is_done { done } else { skipped }.to_owned(),
    };
    let turns = plan.laws.turns();
    let has_rolling = plan
        .pairs
        .iter()
        .any(|pair| pair.law.rolling != AnyRolling::None);
    let has_friction = plan
        .pairs
        .iter()
        .any(|pair| pair.law.tangential != AnyTangential::None);
    let moving = plan.walls.iter().filter(|wall| !wall.motion.is_static());
    let triangles: usize = plan
        .walls
        .iter()
        .map(|wall| match &wall.shape {
            Shape::Mesh(mesh) => mesh.len(),
            _ => 0,
        })
        .sum();
    let ratio = plan.largest_radius / plan.smallest_radius;
    let meshes = plan.walls.iter();
    let meshes = meshes.filter(|wall| matches!(wall.shape, Shape::Mesh(_)));
    let how = match meshes.count() {
        0 => "in closed form",
        count if count == plan.walls.len() => "with the triangles of meshes",
        _ => "in closed form, and with the triangles of meshes",
    };
    vec![
        Pass {
            name: "contact loop",
            is_done: !plan.pairs.is_empty(),
            reason: if plan.pairs.is_empty() {
                "nothing can meet".to_owned()
            } else {
                contact_loop(&plan.laws).1
            },
        },
        pass(
            "friction",
            has_friction,
            "history of a tangential spring for each contact",
            "no pair has a friction coefficient above 0",
        ),
        pass(
            "rotation",
            turns,
            "torques and angular velocities",
            "without friction and rolling resistance no contact turns a particle",
        ),
        pass(
            "rolling and torsion",
            has_rolling,
            "history of two springs for each contact",
            "no pair has rolling or torsion resistance",
        ),
        pass(
            "liquid",
            false,
            "",
            "no material has a liquid law: no films, no bridges, no pairs at a distance",
        ),
        Pass {
            name: "wall contacts",
            is_done: !plan.walls.is_empty(),
            reason: match (plan.walls.len(), moving.count()) {
                (0, _) => "no walls".to_owned(),
                (n, 0) => format!("{how}, {n} at rest"),
                (n, m) => format!("{how}, {} at rest, {m} moving", n - m),
            },
        },
        Pass {
            name: "mesh search",
            is_done: triangles > 0,
            reason: if triangles > 0 {
                format!("with the candidate list, in a tree of boxes; {triangles} triangles in all")
            } else {
                "no wall is a mesh".to_owned()
            },
        },
        Pass {
            name: "grid levels",
            is_done: false,
            reason: if ratio.is_finite() {
                format!("one level, largest over smallest particle {ratio:.3}")
            } else {
                "no particles".to_owned()
            },
        },
        pass(
            "periodic images",
            plan.periodic.contains(&true),
            "one contact per pair, with a shift",
            "no axis is periodic",
        ),
        pass(
            "bodies",
            plan.has_bodies(),
            "loads of the pebbles gathered, bodies moved and turned, pebbles put in place",
            "no clumps",
        ),
        pass(
            "insertion and deletion",
            !plan.insertions.is_empty() || !plan.deletions.is_empty(),
            "in every step while something is due",
            "none planned; particles that leave the domain are removed",
        ),
        pass(
            "contact output",
            plan.output.fstat,
            "contacts are written",
            "output.fstat = false",
        ),
        pass(
            "loads on triangles",
            plan.output.triangle_loads,
            "summed up in every step",
            if triangles > 0 {
                "output.triangle_loads = false"
            } else {
                "no wall is a mesh"
            },
        ),
        pass(
            "energy sums",
            plan.energy_budget,
            "in every step, by mechanism",
            "only where a row is written (output.energy_budget = false)",
        ),
        pass(
            "orientations",
            plan.orientations,
            "written to .data or .track",
            "nothing writes them",
        ),
    ]
}

/// The number of particles and bodies expected: those of the start, and those of insertions that say how many.
pub(super) fn expected_particles(plan: &Plan) -> f64 {
    let densities: Vec<f64> = plan.materials.iter().map(|m| m.density).collect();
    let inserted: f64 = plan
        .insertions
        .iter()
        .filter_map(|insertion| expected_number(insertion, &densities, plan.dimensions))
        .sum();
    (plan.particles.len() + plan.bodies.len()) as f64 + inserted
}

/// Spheres expected among them: particles, and pebbles of bodies.
pub(super) fn expected_spheres(plan: &Plan) -> f64 {
    let pebbles = |clump: u32| plan.clumps[clump as usize].pebbles.len() as f64;
    let densities: Vec<f64> = plan.materials.iter().map(|m| m.density).collect();
    let inserted = plan.insertions.iter().filter_map(|insertion| {
        let number = expected_number(insertion, &densities, plan.dimensions)?;
        let each = insertion.mixture.iter().map(|part| {
            let spheres = part.clump.map_or(1.0, pebbles);
            part.share * spheres
        });
        Some(number * each.sum::<f64>())
    });
    let bodies = plan.bodies.iter().map(|body| pebbles(body.clump));
    plan.particles.len() as f64 + bodies.sum::<f64>() + inserted.sum::<f64>()
}

/// Listed pairs per particle: half of the about twelve that touch or nearly touch in a dense packing, and the skin's.
const PAIRS_PER_PARTICLE: f64 = 10.0;

/// Estimate of the memory (bytes) that the particles expected and their contacts need.
#[must_use]
pub fn memory(plan: &Plan) -> f64 {
    let is_plastic = |pair: &super::PairPlan| matches!(pair.law.normal, AnyNormal::Plastic(_));
    let any = |test: &dyn Fn(&super::PairPlan) -> bool| plan.pairs.iter().any(test);
    let mut history = 0.0;
    if any(&is_plastic) {
        history += 8.0;
    }
    if any(&|pair| pair.law.tangential != AnyTangential::None) {
        history += 32.0;
    }
    if any(&|pair| pair.law.rolling != AnyRolling::None) {
        history += 48.0;
    }
    // The record; force and torque, id, mass, place in the list; the orientation.
    let columns = 48.0 + 4.0 + 8.0 + 24.0 + if plan.orientations { 32.0 } else { 0.0 };
    let record = size_of::<Particle>() as f64;
    // A listed pair: candidate and slot; twice while a list is rebuilt.
    let pair = 2.0 * (16.0 + history);
    let mut bytes = expected_spheres(plan) * (record + columns + PAIRS_PER_PARTICLE * pair);
    if plan.has_bodies() {
        // Every row says whether it is a pebble.
        let pebble = (size_of::<BodyPebble>() + size_of::<u32>()) as f64;
        bytes += expected_spheres(plan) * pebble;
        bytes += expected_particles(plan) * size_of::<Body>() as f64;
    }
    bytes
}
