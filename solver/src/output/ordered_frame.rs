//! The state at one time in the order of every file: by id, positions inside the periodic domain.

use glam::{DQuat, DVec3};
use mercury_pictures::EnergyFlows;

use super::frame_copy::TrackPoint;
use super::membrane_files::MembraneState;
use super::wear_files::WearState;
use super::{BudgetRow, Due, FrameCopy};
use mercury_engine::boundaries::{Crossed, Passage};
use mercury_engine::cell::Cell;
use mercury_engine::forces::{LoadSums, Observation};
use mercury_engine::liquid::LiquidRow;
use mercury_engine::spray::Droplet;
use mercury_engine::state::{Bodies, Body, BodyIndex, FIXED, Load, PEBBLE, Particle};
use mercury_engine::walls::WallState;

/// A [`FrameCopy`] in the order of ids.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderedFrame {
    /// Time, s.
    pub time: f64,
    /// Steps made.
    pub step: u64,
    /// Files that it is written to.
    pub due: Due,
    /// Particles, pebbles among them, positions wrapped into the periodic domain.
    pub particles: Vec<Particle>,
    /// Contact forces on the particles.
    pub loads: Vec<Load>,
    /// Ids, ascending.
    pub ids: Vec<u32>,
    /// Masses, kg; of pebbles their share of the body's.
    pub masses: Vec<f64>,
    /// Orientations, if integrated; of pebbles that of their body.
    pub orientations: Option<Vec<DQuat>>,
    /// Rigid bodies by their ids, centres wrapped into the periodic domain; empty without clumps.
    pub bodies: Vec<Body>,
    /// For each rank the place of its body in `bodies`; `None` for spheres of their own. Empty without clumps.
    pub body_of_rank: Vec<Option<BodyIndex>>,
    /// Place in this order of each of the engine's rows, to which the observation refers.
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

impl OrderedFrame {
    /// Puts a moment in order.
    #[must_use]
    pub fn new(moment: FrameCopy, cell: &Cell) -> Self {
        let mut order: Vec<u32> = (0..moment.ids.len() as u32).collect();
        order.sort_unstable_by_key(|&row| moment.ids[row as usize]);
        let mut rank_of_row = vec![0; order.len()];
        for (rank, &row) in order.iter().enumerate() {
            rank_of_row[row as usize] = rank as u32;
        }
        // Column by column, so that memory never holds the whole state twice.
        let mut particles = gather(moment.records, &order);
        for particle in &mut particles {
            particle.position = cell.wrap(particle.position);
        }
        let mut orientations = moment.orientations.map(|all| gather(all, &order));
        let (bodies, body_of_rank) = match &moment.bodies {
            None => (Vec::new(), Vec::new()),
            Some(bodies) => by_rank(bodies, &order, cell),
        };
        if let Some(orientations) = &mut orientations {
            for (orientation, body) in orientations.iter_mut().zip(&body_of_rank) {
                if let Some(body) = body {
                    *orientation = bodies[body.index()].orientation;
                }
            }
        }
        Self {
            time: moment.time,
            step: moment.step,
            due: moment.due,
            particles,
            loads: gather(moment.loads, &order),
            ids: gather(moment.ids, &order),
            masses: gather(moment.masses, &order),
            orientations,
            bodies,
            body_of_rank,
            rank_of_row,
            walls: moment.walls,
            observation: moment.observation,
            flows: moment.flows,
            budget: None,
            load_sums: moment.load_sums,
            crossed: moment.crossed,
            passages: moment.passages,
            tracks: moment.tracks,
            properties: (moment.properties.into_iter())
                .map(|values| gather(values, &order))
                .collect(),
            liquid: moment.liquid,
            droplets: moment.droplets,
            wear: moment.wear,
            membranes: moment.membranes,
        }
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

/// Bodies with wrapped centres, and the place of each rank's body among them.
fn by_rank(bodies: &Bodies, order: &[u32], cell: &Cell) -> (Vec<Body>, Vec<Option<BodyIndex>>) {
    let wrapped = bodies.all.iter().map(|body| Body {
        position: cell.wrap(body.position),
        ..*body
    });
    let of_rank = order.iter().map(|&row| bodies.body_of_row(row as usize));
    (wrapped.collect(), of_rank.collect())
}

fn gather<T: Copy>(column: Vec<T>, order: &[u32]) -> Vec<T> {
    order.iter().map(|&row| column[row as usize]).collect()
}
