//! The state at one time, copied so that the time loop can go on.

use glam::DQuat;

use super::Due;
use super::wear_files::WearState;
use crate::boundaries::Crossed;
use crate::forces::{LoadSums, Observation};
use crate::liquid::LiquidRow;
use crate::state::{Bodies, FILM_VOLUME, Load, Particle};
use crate::step::Engine;
use crate::walls::WallState;

/// What is written of one time. Rows are in the engine's order.
#[derive(Debug, Clone, PartialEq)]
pub struct Moment {
    /// Time, s.
    pub time: f64,
    /// Steps made.
    pub step: u64,
    /// What is written of it.
    pub due: Due,
    /// Particles.
    pub records: Vec<Particle>,
    /// Contact forces on the particles.
    pub loads: Vec<Load>,
    /// Ids.
    pub ids: Vec<u32>,
    /// Masses, kg.
    pub masses: Vec<f64>,
    /// Orientations, if integrated.
    pub orientations: Option<Vec<DQuat>>,
    /// Rigid bodies, in scenes with clumps.
    pub bodies: Option<Bodies>,
    /// The walls as they stand, with the velocities of this time.
    pub walls: Vec<WallState>,
    /// What was seen of the contacts.
    pub observation: Observation,
    /// Dissipated since the start, J, in audited runs.
    pub dissipated: Option<f64>,
    /// Loads on features of meshes since the last frame, and since the last files for ParaView, if planned and due.
    pub load_sums: [Option<LoadSums>; 2],
    /// What crossed the flux planes since the last frame, plane by plane, each material by material; empty if no frame is due.
    pub crossed: Vec<Crossed>,
    /// Liquid films on the particles, m^3, and where the liquid is; in scenes that have any.
    pub liquid: Option<(Vec<f64>, LiquidRow)>,
    /// Worn walls, in scenes that have any.
    pub wear: Option<WearState>,
}

impl Moment {
    /// Of an engine whose step is complete and was watched; takes the sums that are due out of it.
    #[must_use]
    pub fn take(engine: &mut Engine, due: Due) -> Self {
        let load_sums = engine.take_load_sums(due.frame, due.vtk);
        let crossed = if due.frame {
            engine.take_crossed()
        } else {
            Vec::new()
        };
        let observation = engine.take_observation();
        let particles = &engine.particles;
        let audit = engine.audit();
        Self {
            time: engine.time(),
            step: engine.steps(),
            due,
            records: particles.records.clone(),
            loads: particles.loads.clone(),
            ids: particles.ids.iter().map(|id| id.number()).collect(),
            masses: particles.masses.clone(),
            orientations: particles.orientations.clone(),
            bodies: particles.bodies.clone(),
            walls: (engine.walls().iter().zip(engine.plan().physics().walls()))
                .map(|(now, wall)| now.state_at(wall, engine.time()))
                .collect(),
            observation,
            dissipated: engine
                .plan()
                .physics()
                .energy_budget()
                .then(|| audit.dissipated()),
            load_sums,
            crossed,
            liquid: engine.liquid().map(|row| {
                let films = particles.columns.get(FILM_VOLUME).unwrap_or_default();
                (films.to_vec(), row)
            }),
            wear: engine
                .wear()
                .map(|wear| WearState::new(wear, (engine.time(), engine.steps()))),
        }
    }
}
