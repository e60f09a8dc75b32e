//! The identity of a run in its checkpoint: a resumed run checks that it is the same, and a run that starts from it can interpret
//! the numbers in the state.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::DVec3;

use mercury_engine::cell::Cell;

use super::Plan;

/// The identity of a run, in front of the state itself.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Head {
    /// Version of the program that wrote it.
    pub program: String,
    /// Title of the scene.
    pub title: String,
    /// The statement of the scene: [`Statement::entries`](mercury_common::scene::Statement::entries).
    pub scene: BTreeMap<String, String>,
    /// s
    pub time_step: f64,
    /// Steps made.
    pub step: u64,
    /// m/s^2
    pub gravity: DVec3,
    /// 2 or 3.
    pub dimensions: u8,
    /// The periodic box at the start.
    pub cell: Cell,
    /// Names of the materials, in the order of their numbers.
    pub materials: Vec<String>,
    /// Names of the clumps, in the order of their numbers.
    pub clumps: Vec<String>,
    /// Name of each wall in the order of their numbers, and what decides how its features are numbered.
    pub walls: Vec<(String, String)>,
    /// The material of each.
    pub wall_materials: Vec<u32>,
    /// Names of the laws of each pair of materials, row by row; empty for pairs that never meet.
    pub laws: Vec<String>,
}

mercury_engine::state::plain!(Head {
    program,
    title,
    scene,
    time_step,
    step,
    gravity,
    dimensions,
    cell,
    materials,
    clumps,
    walls,
    wall_materials,
    laws
});

impl Head {
    /// Head of a run of `plan` after so many steps; `scene`: the statement of its scene.
    #[must_use]
    pub fn of(plan: &Plan, scene: &BTreeMap<String, String>, step: u64) -> Self {
        let physics = plan.physics();
        let materials = physics.materials.iter();
        let clumps = physics.clumps.iter();
        let walls = || physics.walls.iter();
        Self {
            program: env!("CARGO_PKG_VERSION").to_owned(),
            title: plan.outputs().title().to_owned(),
            scene: scene.clone(),
            time_step: physics.time_step,
            step,
            gravity: physics.gravity,
            dimensions: physics.dimensions,
            cell: physics.cell,
            materials: materials.map(|material| material.name.clone()).collect(),
            clumps: clumps.map(|clump| clump.name.clone()).collect(),
            walls: walls()
                .map(|wall| (wall.name.clone(), wall.shape.feature_numbering()))
                .collect(),
            wall_materials: walls().map(|wall| wall.material.number()).collect(),
            laws: physics.laws.names_of_pairs(),
        }
    }

    /// s
    #[must_use]
    pub fn time(&self) -> f64 {
        self.step as f64 * self.time_step
    }
}

/// Name of the section of a checkpoint with the positions of the outputs, which the writer adds behind those of the engine.
pub const POSITIONS: &str = "outputs";

/// The two checkpoints of a run, which alternate.
#[must_use]
pub fn checkpoint_paths(folder: &Path, prefix: &str) -> [PathBuf; 2] {
    [0, 1].map(|number| folder.join(format!("{prefix}.{number}.restart")))
}
