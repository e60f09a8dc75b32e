//! A scene of `scenes/stress/` in the engine, and what is measured of it.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Result, anyhow};
use glam::DVec3;
use mercury_common::scene::SceneErrors;
use mercury_engine::forces::Watch;
use mercury_engine::state::{FIXED, PEBBLE, Particle, inverse_inertia_factor};
use mercury_engine::step::{Engine, RunError};
use mercury_solver::plan::{Plan, plan, read_scene, refusal};

use crate::scenes;

/// An engine with a scene.
pub(super) struct Stage {
    pub(super) engine: Engine,
}

/// Energies, J.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Energies {
    pub(super) kinetic: f64,
    pub(super) rotational: f64,
    /// Stored in contacts.
    pub(super) elastic: f64,
}

impl Energies {
    pub(super) fn total(self) -> f64 {
        self.kinetic + self.rotational + self.elastic
    }
}

fn path(scene: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../scenes/stress")
        .join(format!("{scene}.toml"))
}

/// The plan of a scene with `KEY=VALUE` put on top, or why it is refused.
pub(super) fn planned(scene: &str, sets: &[String]) -> Result<Plan, SceneErrors> {
    plan(&read_scene(&path(scene), sets)?)
}

/// Messages of the program on a scene: the refusal, or the warnings if it is accepted.
pub(super) fn complaint(scene: &str, sets: &[String]) -> String {
    let folder = path(scene).with_file_name("").display().to_string();
    match planned(scene, sets) {
        Ok(plan) => format!("taken; warnings: {:?}", plan.notes().warnings()),
        Err(errors) => refusal(&errors).replace(&folder, ""),
    }
}

impl Stage {
    /// The start of a scene with `KEY=VALUE` put on top.
    pub(super) fn open(scene: &str, sets: &[String]) -> Result<Self> {
        let plan = planned(scene, sets).map_err(|errors| anyhow!("{}", refusal(&errors)))?;
        let engine = Engine::new(Arc::new(plan), 1)?;
        Ok(Self { engine })
    }

    /// Makes so many steps, and completes them, with energies of contacts and loads of walls noted.
    pub(super) fn go(&mut self, steps: u64) -> Result<(), RunError> {
        self.engine.steps_at_once(steps, Some(Watch::default()))?;
        self.engine.complete_step()
    }

    pub(super) fn time_step(&self) -> f64 {
        self.engine.physics().time_step
    }

    pub(super) fn len(&self) -> usize {
        self.engine.particles.grains()
    }

    /// Records and masses (kg) of the spheres that are free.
    pub(super) fn free(&self) -> impl Iterator<Item = (&Particle, f64)> {
        let particles = &self.engine.particles;
        let all = particles.records.iter().zip(&particles.masses);
        all.filter(|(record, _)| record.flags & (FIXED | PEBBLE) == 0)
            .map(|(record, &mass)| (record, mass))
    }

    pub(super) fn energies(&self) -> Energies {
        let inverse = inverse_inertia_factor(self.engine.physics().dimensions);
        let (mut kinetic, mut rotational) = (0.0, 0.0);
        for (record, mass) in self.free() {
            kinetic += 0.5 * mass * record.velocity.length_squared();
            let inertia = mass * record.radius * record.radius / inverse;
            rotational += 0.5 * inertia * record.angular_velocity.length_squared();
        }
        Energies {
            kinetic,
            rotational,
            elastic: self.engine.observation().elastic_energy,
        }
    }

    /// Sum of m v, and of m |v|, kg m/s.
    pub(super) fn momentum(&self) -> (DVec3, f64) {
        let mut sums = (DVec3::ZERO, 0.0);
        for (record, mass) in self.free() {
            sums.0 += mass * record.velocity;
            sums.1 += mass * record.velocity.length();
        }
        sums
    }

    /// The particle of an id.
    pub(super) fn particle(&self, id: u32) -> Particle {
        scenes::particle(&self.engine, id)
    }

    /// Whether all positions and velocities are numbers.
    pub(super) fn is_finite(&self) -> bool {
        self.free().all(|(record, _)| {
            record.position.is_finite()
                && record.velocity.is_finite()
                && record.angular_velocity.is_finite()
        })
    }
}

/// The distance to the next number from one of this size.
pub(super) fn ulp(size: f64) -> f64 {
    size.abs().next_up() - size.abs()
}
