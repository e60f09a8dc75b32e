//! Bodies that mclump makes of reference shapes, on a table.
//!
//! The shapes (MercuryDPM, BSD-3-Clause) are not part of the project: they lie in `shared/data/shapes` beside it.

mod goemboec;
mod rattleback;

use std::path::{Path, PathBuf};

use glam::{DQuat, DVec3};
use mercury_common::formats::clump::ClumpFile;
use mercury_engine::bodies::Clump;
use mercury_engine::contact::registry::AnyPairLaw;
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, CoulombLimits, Linear, LinearFriction,
    SpringRotation,
};
use mercury_engine::state::MaterialIndex;
use mercury_engine::step::Engine;
use mercury_solver::plan::{Draft, NewBody};

use crate::cases::Case;
use crate::scenes::{plane, start};

/// Where the shapes are.
#[derive(Debug, Clone, PartialEq)]
pub struct Shapes {
    folder: PathBuf,
}

impl Shapes {
    /// The files beside the project; `None` where they are not installed.
    #[must_use]
    pub fn find() -> Option<Self> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/shapes");
        folder.is_dir().then_some(Self { folder })
    }

    fn file(&self, relative: &str) -> PathBuf {
        self.folder.join(relative)
    }
}

/// The checks of one body each, a second or two.
#[must_use]
pub fn quick(shapes: &Shapes) -> Vec<Case> {
    let mut cases = goemboec::quick(shapes);
    cases.extend(rattleback::quick(shapes));
    cases
}

/// All checks.
#[must_use]
pub fn all(shapes: &Shapes) -> Vec<Case> {
    let mut cases = quick(shapes);
    cases.extend(goemboec::slow(shapes));
    cases.extend(rattleback::slow(shapes));
    cases
}

/// Contacts of a body with a table: a linear spring (N/m) with a restitution, and friction.
#[derive(Debug, Clone, Copy)]
struct Table {
    stiffness: f64,
    restitution: f64,
    friction: f64,
    gravity: f64,
    step: f64,
}

impl Table {
    /// A body in the middle of the table.
    fn with(&self, clump: &Clump, body: NewBody) -> Engine {
        let log = -f64::ln(self.restitution);
        let ratio = log / log.hypot(std::f64::consts::PI);
        let law = AnyPairLaw {
            normal: AnyNormal::Linear(Linear::with_damping_ratio(self.stiffness, ratio)),
            tangential: AnyTangential::Linear(LinearFriction {
                stiffness: 2.0 / 7.0 * self.stiffness,
                dissipation: 0.0,
                friction: self.friction,
                static_friction: self.friction,
                rotation: SpringRotation::Project,
                limits: CoulombLimits::Bounded,
            }),
            rolling: AnyRolling::None,
            adhesion: AnyAdhesion::None,
        };
        let domain = (DVec3::splat(-1e3), DVec3::splat(1e3));
        let mut plan = Draft::new(self.step, domain, 1.0, law);
        plan.gravity = -self.gravity * DVec3::Z;
        plan.walls.push(plane(DVec3::ZERO, DVec3::Z));
        start(plan.with_bodies(vec![clump.clone()], vec![body]))
    }
}

/// A clump file as the solver has it.
fn solver_clump(file: &ClumpFile) -> Clump {
    Clump::new(
        &file.name,
        MaterialIndex::new(0),
        file.pebbles.clone(),
        file.mass,
        file.volume,
        file.principal_moments,
    )
    .expect("mclump writes rigid bodies")
}

/// Direction in the frame of the shape's file that points down, where a body touches the table.
fn contact_direction(file: &ClumpFile, orientation: DQuat) -> DVec3 {
    file.rotation * (orientation.inverse() * -DVec3::Z)
}
