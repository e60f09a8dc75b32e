//! The state at one time, copied so that the time loop can go on.

use glam::{DQuat, DVec3};
use mercury_pictures::EnergyFlows;

use super::Due;
use super::budget::{Exchanged, energy_flows};
use super::membrane_files::MembraneState;
use super::wear_files::WearState;
use mercury_engine::boundaries::{Crossed, Passage};
use mercury_engine::forces::{LoadSums, Observation};
use mercury_engine::liquid::LiquidRow;
use mercury_engine::spray::Droplet;
use mercury_engine::state::{Bodies, Load, Particle};
use mercury_engine::step::Engine;
use mercury_engine::tracks::Tracked;
use mercury_engine::walls::WallState;

/// Copy of one state, for the files. Rows are in the engine's order.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameCopy {
    /// Time, s.
    pub time: f64,
    /// Steps made.
    pub step: u64,
    /// Files that it is written to.
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
    /// Observation of the contacts.
    pub observation: Observation,
    /// The energy balance since the start, in audited runs.
    pub flows: Option<EnergyFlows>,
    /// Loads on features of meshes since the last frame, and since the last files for ParaView, if planned and due.
    pub load_sums: [Option<LoadSums>; 2],
    /// Particles that crossed the flux planes since the last frame, plane by plane, each material by material; empty if no frame
    /// is due.
    pub crossed: Vec<Crossed>,
    /// The grains that crossed a plane or left since the last frame, if they are listed; empty if no frame is due.
    pub passages: Vec<Passage>,
    /// The tracked particles and bodies, by track and id; empty if no rows of tracks are due.
    pub tracks: Vec<TrackPoint>,
    /// The properties of the physics, column by column; behind them, in scenes with liquid, that which each particle holds, m^3.
    pub properties: Vec<Vec<f64>>,
    /// Where the liquid is, in scenes that have any.
    pub liquid: Option<LiquidRow>,
    /// Droplets in flight, by ascending id.
    pub droplets: Vec<Droplet>,
    /// Worn walls, in scenes that have any.
    pub wear: Option<WearState>,
    /// Sheets, in scenes that have any.
    pub membranes: Option<MembraneState>,
}

/// A tracked particle or body at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackPoint {
    /// Of which track, counted from 1.
    pub track: u32,
    /// Id; of a body that of its first pebble.
    pub id: u32,
    /// Centre, m, along periodic axes as in a domain that goes on for ever.
    pub position: DVec3,
    /// Velocity, m/s.
    pub velocity: DVec3,
    /// Angular velocity, rad/s.
    pub angular_velocity: DVec3,
    /// Orientation.
    pub orientation: DQuat,
    /// Force (N) and torque about the centre (N m) of all contacts.
    pub load: Load,
}

/// All of them.
fn track_points(engine: &Engine) -> Vec<TrackPoint> {
    let particles = &engine.particles;
    let point = |tracked: Tracked| {
        let (row, track, position) = (tracked.row, tracked.track, tracked.position);
        let id = particles.ids[row].number();
        let body = particles.bodies.as_ref();
        let body = body.and_then(|bodies| Some(&bodies.all[bodies.body_of_row(row)?.index()]));
        let (velocity, angular_velocity, orientation, load) = match body {
            Some(body) => (
                body.velocity,
                body.angular_velocity,
                body.orientation,
                body.load,
            ),
            None => {
                let record = &particles.records[row];
                let all = particles.orientations.as_ref();
                let orientation = all.map_or(DQuat::IDENTITY, |all| all[row]);
                let load = particles.loads[row];
                (record.velocity, record.angular_velocity, orientation, load)
            }
        };
        TrackPoint {
            track,
            id,
            position,
            velocity,
            angular_velocity,
            orientation,
            load,
        }
    };
    let mut points: Vec<TrackPoint> = engine.tracked().into_iter().map(point).collect();
    points.sort_unstable_by_key(|point| (point.track, point.id));
    points
}

impl FrameCopy {
    /// Copies an engine whose step is complete, and was observed unless tracks alone are due; moves the sums that are due out of
    /// it. `at_start`: the gains and losses before the first step.
    #[must_use]
    pub fn take(engine: &mut Engine, due: Due, at_start: &Exchanged) -> Self {
        let tracks = match due.tracks {
            true => track_points(engine),
            false => Vec::new(),
        };
        if due.tracks && !due.beyond_tracks() {
            return Self::of_tracks(engine, due, tracks);
        }
        let load_sums = engine.take_load_sums(due.frame, due.vtk);
        let (crossed, passages) = if due.frame {
            (engine.take_crossed(), engine.take_passages())
        } else {
            (Vec::new(), Vec::new())
        };
        let observation = engine.take_observation();
        let flows = energy_flows(engine, at_start);
        let particles = &engine.particles;
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
            walls: (engine.walls().iter().zip(&engine.physics().walls))
                .map(|(now, wall)| now.state_at(wall, engine.time()))
                .collect(),
            observation,
            flows,
            load_sums,
            crossed,
            passages,
            tracks,
            properties: (engine.physics().properties.iter())
                .filter_map(|property| particles.columns.get(property.name))
                .map(<[f64]>::to_vec)
                .chain(engine.liquid_volumes())
                .collect(),
            liquid: engine.liquid(),
            droplets: (engine.sprays())
                .map_or_else(Vec::new, |sprays| sprays.state.droplets.clone()),
            wear: engine
                .wear()
                .map(|wear| WearState::new(wear, (engine.time(), engine.steps()))),
            membranes: MembraneState::of(engine),
        }
    }

    /// Rows of tracks and nothing else.
    fn of_tracks(engine: &Engine, due: Due, tracks: Vec<TrackPoint>) -> Self {
        Self {
            time: engine.time(),
            step: engine.steps(),
            due,
            records: Vec::new(),
            loads: Vec::new(),
            ids: Vec::new(),
            masses: Vec::new(),
            orientations: None,
            bodies: None,
            walls: Vec::new(),
            observation: Observation::default(),
            flows: None,
            load_sums: [None, None],
            crossed: Vec::new(),
            passages: Vec::new(),
            tracks,
            properties: Vec::new(),
            liquid: None,
            droplets: Vec::new(),
            wear: None,
            membranes: None,
        }
    }
}
