//! What is seen of the contacts in the steps that are written out or audited.

use glam::DVec3;

use crate::state::{Load, WallIndex};
use crate::walls::WallStiffness;

/// What to see in a force evaluation.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Watch {
    /// Keep a record of every contact.
    pub records: bool,
    /// Add up what each mechanism dissipates in this step of `dt` (s).
    pub audit: Option<f64>,
}

/// The partner of a particle in a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Partner {
    /// The particle in this row, by the image with this code.
    Particle {
        /// Row.
        row: u32,
        /// Image code of the partner.
        image: u32,
    },
    /// A wall.
    Wall {
        /// Index of the wall.
        wall: WallIndex,
        /// Image code of the particle.
        image: u32,
    },
}

/// One contact as the force evaluation saw it.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactRecord {
    /// Row of the first particle (A); of two particles the one with the lower id.
    pub row: u32,
    /// The other side (B).
    pub partner: Partner,
    /// Which face, edge or corner of a wall; of a mesh, [`Mesh::triangles_of`](crate::walls::Mesh::triangles_of) names the
    /// triangles. `u32::MAX` between particles.
    pub feature: u32,
    /// Contact point beside A, m.
    pub point: DVec3,
    /// Unit normal from B to A.
    pub normal: DVec3,
    /// Overlap, m; negative for a bond across a gap.
    pub overlap: f64,
    /// Force on A, N.
    pub force: DVec3,
    /// Its tangential part, N.
    pub tangential: DVec3,
    /// Couple on A beyond the lever arm of the force, N m.
    pub couple: DVec3,
    /// What `.fstat` calls the tangential overlap, m.
    pub tangential_overlap: f64,
    /// Numbers of the history.
    pub history: Vec<f64>,
}

impl ContactRecord {
    /// Bytes of a record with so many numbers of history, for estimates of memory.
    #[must_use]
    pub fn bytes(history: usize) -> usize {
        // What the system's allocator keeps for itself beside the numbers.
        const HEADER: usize = 16;
        size_of::<Self>()
            + if history == 0 {
                0
            } else {
                history * 8 + HEADER
            }
    }
}

/// Sums and records over the contacts of one force evaluation.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Observation {
    /// Pairs of particles that touch.
    pub particle_contacts: u64,
    /// Features of walls that particles touch.
    pub wall_contacts: u64,
    /// Energy stored in the contacts, J; bonds by adhesion count negative.
    pub elastic_energy: f64,
    /// Dissipated in this step by the viscous and plastic normal force and by adhesion, J.
    pub dissipated_normal: f64,
    /// Dissipated in this step by sliding friction and the tangential dashpot, J.
    pub dissipated_tangential: f64,
    /// Dissipated in this step by rolling and torsion resistance, J.
    pub dissipated_rolling: f64,
    /// Work done by the walls on the particles in this step, J.
    pub wall_work: f64,
    /// Force and torque (about the wall's reference point) of the particles on each wall, and the power of the wall, W.
    pub walls: Vec<(Load, f64)>,
    /// How the contacts of each wall answer to its motion, for servos.
    pub wall_stiffness: Vec<WallStiffness>,
    /// Largest overlap over the smaller radius.
    pub largest_overlap: f64,
    /// Records, if asked for.
    pub records: Vec<ContactRecord>,
}

impl Observation {
    /// Of nothing, with room for the loads of `walls` walls.
    #[must_use]
    pub fn empty(walls: usize) -> Self {
        Self {
            walls: vec![(Load::default(), 0.0); walls],
            wall_stiffness: vec![WallStiffness::default(); walls],
            ..Self::default()
        }
    }

    /// Adds another block's observation.
    pub fn merge(&mut self, other: &Self) {
        self.merge_sums(other);
        self.records.extend_from_slice(&other.records);
    }

    /// The same, but for the records of single contacts.
    pub fn merge_sums(&mut self, other: &Self) {
        self.particle_contacts += other.particle_contacts;
        self.wall_contacts += other.wall_contacts;
        self.elastic_energy += other.elastic_energy;
        self.dissipated_normal += other.dissipated_normal;
        self.dissipated_tangential += other.dissipated_tangential;
        self.dissipated_rolling += other.dissipated_rolling;
        self.wall_work += other.wall_work;
        self.largest_overlap = self.largest_overlap.max(other.largest_overlap);
        for (mine, theirs) in self.walls.iter_mut().zip(&other.walls) {
            mine.0.add(theirs.0.force, theirs.0.torque);
            mine.1 += theirs.1;
        }
        for (mine, theirs) in self.wall_stiffness.iter_mut().zip(&other.wall_stiffness) {
            mine.add(theirs);
        }
    }
}
