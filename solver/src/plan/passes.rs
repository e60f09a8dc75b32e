//! The parts of a run's step, the skipped parts, and the reasons.

use mercury_common::particle_properties::FILM_VOLUME;

use super::Plan;
use super::levels::levels;
use mercury_engine::contact::parameter::short;
use mercury_engine::contact::{AnyRolling, AnyTangential};
use mercury_engine::forces::contact_loop;
use mercury_engine::walls::Shape;

/// A part of the simulation that a scene may or may not need.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pass {
    /// Name of the pass.
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
    let turns = plan.physics().laws.turns();
    let has_rolling = plan
        .notes()
        .pairs()
        .iter()
        .any(|pair| pair.law.rolling != AnyRolling::None);
    let has_friction = plan
        .notes()
        .pairs()
        .iter()
        .any(|pair| pair.law.tangential != AnyTangential::None);
    let moving = plan
        .physics()
        .walls
        .iter()
        .filter(|wall| !wall.motion.is_static());
    let triangles: usize = plan
        .physics()
        .walls
        .iter()
        .map(|wall| match &wall.shape {
            Shape::Mesh(mesh) => mesh.len(),
            _ => 0,
        })
        .sum();
    let levels = levels(plan).largest;
    let ratio = plan.physics().largest_radius() / plan.physics().smallest_radius();
    let meshes = plan.physics().walls.iter();
    let meshes = meshes.filter(|wall| matches!(wall.shape, Shape::Mesh(_)));
    let how = match meshes.count() {
        0 => "in closed form",
        count if count == plan.physics().walls.len() => "with the triangles of meshes",
        _ => "in closed form, and with the triangles of meshes",
    };
    vec![
        Pass {
            name: "contact loop",
            is_done: !plan.notes().pairs().is_empty(),
            reason: if plan.notes().pairs().is_empty() {
                "nothing can meet".to_owned()
            } else {
                contact_loop(&plan.physics().laws).1
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
            plan.physics().has_property(&FILM_VOLUME),
            if plan.physics().laws.has_liquid() {
                "films on particles, bridges in the slots of contacts, moved after each step"
            } else {
                "films alone, a coating: no pair of materials has a liquid law, so that no bridge forms"
            },
            "no material has a liquid law: no films, no bridges, no pairs at a distance",
        ),
        Pass {
            name: "wall contacts",
            is_done: !plan.physics().walls.is_empty(),
            reason: match (plan.physics().walls.len(), moving.count()) {
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
            is_done: levels.len() > 1,
            reason: match levels.len() {
                _ if !ratio.is_finite() => "no particles".to_owned(),
                1 => format!("one level, largest over smallest particle {ratio:.3}"),
                count => {
                    let largest: Vec<String> = levels.iter().map(|&radius| short(radius)).collect();
                    format!(
                        "{count} levels, for radii up to {} m; each list chooses anew",
                        largest.join(", ")
                    )
                }
            },
        },
        pass(
            "periodic images",
            plan.physics().cell.has_images(),
            "one contact per pair, with a shift",
            "no axis is periodic",
        ),
        pass(
            "bodies",
            plan.physics().has_bodies(),
            "loads of the pebbles gathered, bodies moved and turned, pebbles put in place",
            "no clumps",
        ),
        pass(
            "insertion and deletion",
            !plan.physics().insertions.is_empty() || !plan.physics().deletions.is_empty(),
            "in every step while something is due",
            "none planned; particles that leave the domain are removed",
        ),
        pass(
            "contact output",
            plan.outputs().files().fstat,
            "contacts are written",
            "output.fstat = false",
        ),
        pass(
            "loads on triangles",
            plan.outputs().files().triangle_loads,
            "summed up in every step",
            if triangles > 0 {
                "output.triangle_loads = false"
            } else {
                "no wall is a mesh"
            },
        ),
        pass(
            "energy sums",
            plan.physics().energy_budget,
            "in every step, by mechanism",
            "only where a row is written (output.energy_budget = false)",
        ),
        pass(
            "orientations",
            plan.physics().orientations,
            "written to .data or .track",
            "nothing writes them",
        ),
    ]
}
