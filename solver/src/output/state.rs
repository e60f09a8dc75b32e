//! The state at one time in the order of every file: by id, positions inside the periodic domain.

use glam::{DQuat, DVec3};

use super::Moment;
use crate::forces::Observation;
use crate::neighbours::Images;
use crate::particles::{FIXED, Load, Particle};

/// A [`Moment`] in the order of ids.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// Time, s.
    pub time: f64,
    /// Steps made.
    pub step: u64,
    /// A frame is due.
    pub frame: bool,
    /// The contacts are due.
    pub contacts: bool,
    /// The files for ParaView are due.
    pub vtk: bool,
    /// Particles, positions wrapped into the periodic domain.
    pub particles: Vec<Particle>,
    /// Contact forces on the particles.
    pub loads: Vec<Load>,
    /// Ids, ascending.
    pub ids: Vec<u32>,
    /// Masses, kg.
    pub masses: Vec<f64>,
    /// Orientations, if integrated.
    pub orientations: Option<Vec<DQuat>>,
    /// Place in this order of each of the engine's rows, which the observation speaks of.
    pub rank_of_row: Vec<u32>,
    /// What was seen of the contacts; its rows are the engine's.
    pub observation: Observation,
    /// Dissipated since the start, J, in audited runs.
    pub dissipated: Option<f64>,
}

impl State {
    /// Puts a moment in order.
    #[must_use]
    pub fn new(moment: Moment, images: &Images) -> Self {
        let mut order: Vec<u32> = (0..moment.ids.len() as u32).collect();
        order.sort_unstable_by_key(|&row| moment.ids[row as usize]);
        let mut rank_of_row = vec![0; order.len()];
        for (rank, &row) in order.iter().enumerate() {
            rank_of_row[row as usize] = rank as u32;
        }
        let mut particles = gather(&moment.records, &order);
        for particle in &mut particles {
            particle.position = images.wrap(particle.position);
        }
        Self {
            time: moment.time,
            step: moment.step,
            frame: moment.frame,
            contacts: moment.contacts,
            vtk: moment.vtk,
            particles,
            loads: gather(&moment.loads, &order),
            ids: gather(&moment.ids, &order),
            masses: gather(&moment.masses, &order),
            orientations: moment.orientations.map(|all| gather(&all, &order)),
            rank_of_row,
            observation: moment.observation,
            dissipated: moment.dissipated,
        }
    }

    /// Whether the particle of this rank is fixed.
    #[must_use]
    pub fn is_fixed(&self, rank: usize) -> bool {
        self.particles[rank].flags & FIXED != 0
    }

    /// The rank of a row of the engine.
    #[must_use]
    pub fn rank(&self, row: u32) -> usize {
        self.rank_of_row[row as usize] as usize
    }

    /// Orientation of the particle of this rank; where none is integrated, none has turned.
    #[must_use]
    pub fn orientation(&self, rank: usize) -> DQuat {
        match &self.orientations {
            Some(all) => all[rank],
            None => DQuat::IDENTITY,
        }
    }

    /// Mass (kg) and momentum (kg m/s) of the particles that are not fixed.
    #[must_use]
    pub fn mass_and_momentum(&self) -> (f64, DVec3) {
        let mut sum = (0.0, DVec3::ZERO);
        for (rank, particle) in self.particles.iter().enumerate() {
            if !self.is_fixed(rank) {
                sum.0 += self.masses[rank];
                sum.1 += self.masses[rank] * particle.velocity;
            }
        }
        sum
    }
}

fn gather<T: Copy>(column: &[T], order: &[u32]) -> Vec<T> {
    order.iter().map(|&row| column[row as usize]).collect()
}
