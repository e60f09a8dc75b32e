//! All particles of a run, row by row.

use glam::{DQuat, DVec3};
use rayon::prelude::*;

use super::{FIXED, Load, PRESCRIBED, Particle};

/// Components of motion that a scene prescribes for one particle; `None` is free.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prescribed {
    /// Row of the particle, kept up to date by [`Particles::keep`].
    pub row: u32,
    /// Velocity components, m/s.
    pub velocity: [Option<f64>; 3],
    /// Angular velocity components, rad/s.
    pub angular_velocity: [Option<f64>; 3],
}

/// All particles of a run. Every column that is present has one entry per row.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Particles {
    /// What the contact loop reads.
    pub records: Vec<Particle>,
    /// What contacts did in the last force evaluation.
    pub loads: Vec<Load>,
    /// The number by which users know the particle: 0, 1, 2 ... in order of creation, never used twice.
    pub ids: Vec<u32>,
    /// Mass, kg (per unit length in 2D); also of fixed particles.
    pub masses: Vec<f64>,
    /// Position when the neighbour list was built, m.
    pub listed_at: Vec<DVec3>,
    /// Rotation since creation, only when something writes it.
    pub orientations: Option<Vec<DQuat>>,
    /// Particles with prescribed components, in no particular order; few.
    pub prescribed: Vec<Prescribed>,
    /// The id of the next particle.
    pub next_id: u32,
}

impl Particles {
    /// No particles yet; `with_orientation` decides whether rotations are integrated.
    #[must_use]
    pub fn new(with_orientation: bool) -> Self {
        Self {
            orientations: with_orientation.then(Vec::new),
            ..Self::default()
        }
    }

    /// Number of particles.
    #[must_use]
    pub fn len(&self) -> usize {
        self.records.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.records.is_empty()
    }

    /// Appends a particle of the given mass (kg) and returns its id.
    pub fn push(&mut self, record: Particle, mass: f64, prescribed: Option<Prescribed>) -> u32 {
        let id = self.next_id;
        self.next_id += 1;
        if let Some(prescribed) = prescribed {
            self.prescribed.push(Prescribed {
                row: self.records.len() as u32,
                ..prescribed
            });
        }
        self.records.push(record);
        self.loads.push(Load::default());
        self.ids.push(id);
        self.masses.push(mass);
        self.listed_at.push(record.position);
        if let Some(orientations) = &mut self.orientations {
            orientations.push(DQuat::IDENTITY);
        }
        id
    }

    /// Keeps the rows that `stay` names, in that order.
    pub fn keep(&mut self, stay: &[u32]) {
        gather(&mut self.loads, stay, false);
        gather(&mut self.listed_at, stay, false);
        self.reorder(stay, false);
    }

    /// Puts the row `order[k]` into row `k`, but for the loads and the listed positions: the list that is made for the new order
    /// brings new ones. `parallel`: with the threads of the pool from within which it is called.
    pub(crate) fn reorder(&mut self, order: &[u32], parallel: bool) {
        if !self.prescribed.is_empty() {
            let mut new_row = vec![u32::MAX; self.len()];
            for (new, &old) in order.iter().enumerate() {
                new_row[old as usize] = new as u32;
            }
            for prescribed in &mut self.prescribed {
                prescribed.row = new_row[prescribed.row as usize];
            }
            self.prescribed
                .retain(|prescribed| prescribed.row != u32::MAX);
        }
        gather(&mut self.records, order, parallel);
        gather(&mut self.ids, order, parallel);
        gather(&mut self.masses, order, parallel);
        if let Some(orientations) = &mut self.orientations {
            gather(orientations, order, parallel);
        }
    }

    /// Whether the particle in `row` is fixed.
    #[must_use]
    pub fn is_fixed(&self, row: usize) -> bool {
        self.records[row].flags & FIXED != 0
    }

    /// Whether some of the particle's motion is prescribed.
    #[must_use]
    pub fn is_prescribed(&self, row: usize) -> bool {
        self.records[row].flags & PRESCRIBED != 0
    }

    /// Rows in order of their ids: the order of every output.
    #[must_use]
    pub fn rows_by_id(&self) -> Vec<u32> {
        let mut rows: Vec<u32> = (0..self.len() as u32).collect();
        rows.sort_unstable_by_key(|&row| self.ids[row as usize]);
        rows
    }
}

/// Row `order[k]` of a column becomes row `k`.
fn gather<T: Copy + Send + Sync>(column: &mut Vec<T>, order: &[u32], parallel: bool) {
    let row = |&row: &u32| column[row as usize];
    *column = if parallel {
        order.par_iter().with_min_len(1024).map(row).collect()
    } else {
        order.iter().map(row).collect()
    };
}
