//! The state at one time, copied so that the time loop can go on, and put in the order of every file: by id, positions inside the periodic domain.

use glam::{DQuat, DVec3};
use mercury_pictures::EnergyFlows;

use super::budget::{Exchanged, energy_flows};
use super::track_file::{TrackPoint, track_points};
use super::{BudgetRow, Due};
use crate::membranes::output::MembraneState;
use crate::wear::output::WearState;
use mercury_engine::bonds::{Bond, Bonds, Break};
use mercury_engine::boundaries::{Crossed, Passage};
use mercury_engine::cell::Cell;
use mercury_engine::forces::{LoadSums, Observation};
use mercury_engine::liquid::LiquidRow;
use mercury_engine::spray::Droplet;
use mercury_engine::state::{Body, BodyIndex, FIXED, Load, PEBBLE, Particle};
use mercury_engine::step::Engine;
use mercury_engine::walls::WallState;

/// State at one time, as far as it is written. Particles are in the engine's order at first, and by ascending ids behind
/// [`in_order_of_ids`](Self::in_order_of_ids); the place of a particle in this order is its rank.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FrameCopy {
    /// Time, s.
    pub time: f64,
    /// Steps made.
    pub step: u64,
    /// Files that it is written to.
    pub due: Due,
    /// Particles, pebbles among them.
    pub particles: Vec<Particle>,
    /// Contact forces on the particles.
    pub loads: Vec<Load>,
    /// Ids.
    pub ids: Vec<u32>,
    /// Masses, kg; of pebbles their share of the body's.
    pub masses: Vec<f64>,
    /// Orientations, if integrated; in order of ids those of pebbles are that of their body.
    pub orientations: Option<Vec<DQuat>>,
    /// Rigid bodies by their ids; empty without clumps.
    pub bodies: Vec<Body>,
    /// For each rank the place of its body in `bodies`; `None` for spheres of their own. Empty without clumps.
    pub body_of_rank: Vec<Option<BodyIndex>>,
    /// In order of ids the rank of each of the engine's rows, to which the observation refers.
    pub rank_of_row: Vec<u32>,
    /// The walls as they stand, with the velocities of this time.
    pub walls: Vec<WallState>,
    /// Observation of the contacts; its rows are the engine's.
    pub observation: Observation,
    /// The energy balance since the start, in audited runs.
    pub flows: Option<EnergyFlows>,
    /// The energy budget at this time, in audited runs; the writer closes it against the first state.
    pub budget: Option<BudgetRow>,
    /// Loads on features of meshes since the last frame, and since the last files for ParaView, if planned and due.
    pub load_sums: [Option<LoadSums>; 2],
    /// Particles that crossed the flux planes since the last rows, plane by plane, each material by material; empty if no rows
    /// are due.
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
    /// Bonds that hold; empty if no frame and no file for ParaView is due.
    pub bonds: Vec<Bond>,
    /// Bonds that broke since the last frame; empty if no frame is due.
    pub breaks: Vec<Break>,
    /// Worn walls, in scenes that have any.
    pub wear: Option<WearState>,
    /// Sheets, in scenes that have any.
    pub membranes: Option<MembraneState>,
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
        let (time, step) = (engine.time(), engine.steps());
        if due.tracks && !due.beyond_tracks() {
            return Self {
                time,
                step,
                due,
                tracks,
                ..Self::default()
            };
        }
        let load_sums = engine.take_load_sums(due.frame, due.vtk);
        let crossed = match due.rows {
            true => engine.take_crossed(),
            false => Vec::new(),
        };
        let passages = match due.frame {
            true => engine.take_passages(),
            false => Vec::new(),
        };
        let (mut bonds, mut breaks) = (Vec::new(), Vec::new());
        if (due.frame || due.vtk)
            && let Some((part, _)) = engine.part_and_core::<Bonds>()
        {
            bonds = part.all();
            if due.frame {
                breaks = part.take_breaks();
            }
        }
        let observation = engine.take_observation();
        let flows = energy_flows(engine, at_start);
        let particles = &engine.particles;
        let bodies = particles.bodies.as_ref();
        Self {
            time,
            step,
            due,
            particles: particles.records.clone(),
            loads: particles.loads.clone(),
            ids: particles.ids.iter().map(|id| id.number()).collect(),
            masses: particles.masses.clone(),
            orientations: particles.orientations.clone(),
            bodies: bodies.map_or_else(Vec::new, |bodies| bodies.all.clone()),
            body_of_rank: bodies.map_or_else(Vec::new, |bodies| {
                let rows = 0..particles.records.len();
                rows.map(|row| bodies.body_of_row(row)).collect()
            }),
            rank_of_row: Vec::new(),
            walls: (engine.walls().iter().zip(&engine.physics().walls))
                .map(|(now, wall)| now.state_at(wall, time))
                .collect(),
            observation,
            flows,
            budget: None,
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
            bonds,
            breaks,
            wear: engine.wear().map(|wear| WearState::new(wear, (time, step))),
            membranes: MembraneState::of(engine),
        }
    }

    /// Puts particles in the order of ids, and positions inside the periodic domain.
    #[must_use]
    pub fn in_order_of_ids(mut self, cell: &Cell) -> Self {
        let mut order: Vec<u32> = (0..self.ids.len() as u32).collect();
        order.sort_unstable_by_key(|&row| self.ids[row as usize]);
        self.rank_of_row = vec![0; order.len()];
        for (rank, &row) in order.iter().enumerate() {
            self.rank_of_row[row as usize] = rank as u32;
        }
        // Column by column, so that memory never holds the whole state twice.
        gather(&mut self.particles, &order);
        gather(&mut self.loads, &order);
        gather(&mut self.ids, &order);
        gather(&mut self.masses, &order);
        for values in &mut self.properties {
            gather(values, &order);
        }
        if !self.body_of_rank.is_empty() {
            gather(&mut self.body_of_rank, &order);
        }
        for particle in &mut self.particles {
            particle.position = cell.wrap(particle.position);
        }
        for body in &mut self.bodies {
            body.position = cell.wrap(body.position);
        }
        if let Some(orientations) = &mut self.orientations {
            gather(orientations, &order);
            for (orientation, body) in orientations.iter_mut().zip(&self.body_of_rank) {
                if let Some(body) = body {
                    *orientation = self.bodies[body.index()].orientation;
                }
            }
        }
        self
    }

    /// Whether the particle of this rank is fixed.
    #[must_use]
    pub fn is_fixed(&self, rank: usize) -> bool {
        self.particles[rank].flags & FIXED != 0
    }

    /// Whether the particle of this rank is a pebble of a body.
    #[must_use]
    pub fn is_pebble(&self, rank: usize) -> bool {
        self.particles[rank].flags & PEBBLE != 0
    }

    /// The body that the particle of this rank is a pebble of.
    #[must_use]
    pub fn body(&self, rank: usize) -> Option<&Body> {
        let place = self.body_of_rank.get(rank)?.as_ref()?;
        Some(&self.bodies[place.index()])
    }

    /// The rank of a row of the engine.
    #[must_use]
    pub fn rank(&self, row: u32) -> usize {
        self.rank_of_row[row as usize] as usize
    }

    /// Orientation of the particle of this rank; identity where none is integrated.
    #[must_use]
    pub fn orientation(&self, rank: usize) -> DQuat {
        match &self.orientations {
            Some(all) => all[rank],
            None => DQuat::IDENTITY,
        }
    }

    /// Mass (kg) and momentum (kg m/s) of the particles and bodies that are not fixed.
    #[must_use]
    pub fn mass_and_momentum(&self) -> (f64, DVec3) {
        let mut sum = (0.0, DVec3::ZERO);
        for (rank, particle) in self.particles.iter().enumerate() {
            if !self.is_fixed(rank) && !self.is_pebble(rank) {
                sum.0 += self.masses[rank];
                sum.1 += self.masses[rank] * particle.velocity;
            }
        }
        for body in self.bodies.iter().filter(|body| !body.is_fixed()) {
            sum.0 += body.mass;
            sum.1 += body.mass * body.velocity;
        }
        sum
    }
}

fn gather<T: Copy>(column: &mut Vec<T>, order: &[u32]) {
    *column = order.iter().map(|&row| column[row as usize]).collect();
}
