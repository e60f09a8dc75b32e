//! Observation of the contacts in the steps that are written out or audited.

use glam::DVec3;

use crate::state::{Load, Plain, WallIndex};
use crate::surface::SurfacePoint;
use crate::walls::WallStiffness;

/// Observation to make in a force evaluation.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Watch {
    /// Keep a record of every contact.
    pub records: bool,
    /// Note the loads of each contact, for the audit of a step of `dt` (s; 0 in the evaluation before the first step).
    pub audit: Option<f64>,
}

/// The partner of a particle in a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Partner {
    /// The particle in this row, by the image with this code.
    Particle {
        /// Row.
        row: u32,
        /// Image code of the partner.
        image: u32,
    },
    /// A wall, as partner.
    Wall {
        /// Index of the wall.
        wall: WallIndex,
        /// Image code of the particle.
        image: u32,
    },
}

/// Energy that the springs of contacts store, J.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SpringEnergy {
    /// Energy of elastic normal forces, and of adhesion, which counts negative.
    pub normal: f64,
    /// Energy of normal forces that are not elastic.
    pub plastic: f64,
    /// Energy of tangential springs.
    pub tangential: f64,
    /// Energy of rolling and torsion springs.
    pub rolling: f64,
}

impl SpringEnergy {
    /// The sum over all springs, J.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.normal + self.plastic + self.tangential + self.rolling
    }

    /// Adds `times` the energies of `others`.
    pub fn add(&mut self, other: &Self, times: f64) {
        self.normal += times * other.normal;
        self.plastic += times * other.plastic;
        self.tangential += times * other.tangential;
        self.rolling += times * other.rolling;
    }
}

crate::state::plain!(SpringEnergy {
    normal,
    plastic,
    tangential,
    rolling
});

/// The loads of a contact on its two sides, for the energy audit, which needs velocities that are known only when all forces are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exchange {
    /// Row of A.
    pub row: u32,
    /// The partner B.
    pub partner: Partner,
    /// The number of the sheet and the point of it, if B is one.
    pub sheet: Option<(u16, SurfacePoint)>,
    /// Unit normal from B to A.
    pub normal: DVec3,
    /// Distances from the centres of A and B to the contact point, m; 0 for a wall.
    pub levers: [f64; 2],
    /// Contact point beside A, at the image by which A meets a wall, m.
    pub point: DVec3,
    /// Total force on A, N.
    pub force: DVec3,
    /// The part of it along the normal that dissipates energy, N: the viscous part, and for laws that are not elastic all of it.
    pub lossy: f64,
    /// Its tangential part, N.
    pub tangential: DVec3,
    /// The viscous part of adhesion, N.
    pub adhesive: DVec3,
    /// Couple on A beyond the lever arm of the force, N m.
    pub couple: DVec3,
    /// The part of it by adhesion, N m; all of it dissipates energy.
    pub adhesive_couple: DVec3,
    /// The energy of its springs half a step after these forces, extrapolated from the last step: the particles lose it if one
    /// side of the contact is removed before the next forces.
    pub next_stored: SpringEnergy,
}

/// One contact in the force evaluation.
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
    /// Overlap, m; negative where adhesion acts across a gap.
    pub overlap: f64,
    /// Force on A, N.
    pub force: DVec3,
    /// Its tangential part, N.
    pub tangential: DVec3,
    /// Couple on A beyond the lever arm of the force, N m.
    pub couple: DVec3,
    /// Tangential overlap in the sense of `.fstat`, m.
    pub tangential_overlap: f64,
    /// Volume of the liquid bridge, m^3; 0 where there is none.
    pub bridge_volume: f64,
    /// Force of the liquid bridge on A along the normal, N; negative pulls.
    pub bridge_normal: f64,
    /// Force of the liquid bridge on A in the tangent plane, N.
    pub bridge_shear: DVec3,
    /// Force of dry cohesion on A along the normal, N; negative pulls.
    pub adhesion: f64,
    /// Numbers of the history.
    pub history: Vec<f64>,
}

impl ContactRecord {
    /// Bytes of a record with so many numbers of history, for estimates of memory.
    #[must_use]
    pub fn bytes(history: usize) -> usize {
        // The overhead of the system's allocator.
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
    /// Energy stored in the contacts, J; adhesion counts negative.
    pub elastic_energy: f64,
    /// Audited steps: dissipated in this step as liquid bridges begin and end, J; nothing of it is viscous.
    pub dissipated_by_liquid: f64,
    /// Audited steps: dissipated in this step as dry cohesion begins and ends, J.
    pub dissipated_by_adhesion: f64,
    /// Audited steps: the elastic energy by the springs that store it.
    pub stored: SpringEnergy,
    /// Force and torque (about the wall's reference point) of the particles on each wall, and the power of the wall, W.
    pub walls: Vec<(Load, f64)>,
    /// The stiffness and damping of the contacts of each wall, for servos.
    pub wall_stiffness: Vec<WallStiffness>,
    /// Largest overlap over the smaller radius.
    pub largest_overlap: f64,
    /// Audited steps: the loads of each contact. They stay with the block.
    pub exchanges: Vec<Exchange>,
    /// Records, if requested.
    pub records: Vec<ContactRecord>,
}

crate::state::plain!(ContactRecord {
    row,
    partner,
    feature,
    point,
    normal,
    overlap,
    force,
    tangential,
    couple,
    tangential_overlap,
    bridge_volume,
    bridge_normal,
    bridge_shear,
    adhesion,
    history
});

// Exchanges stay with the block.
crate::state::plain!(Observation {
    particle_contacts,
    wall_contacts,
    elastic_energy,
    dissipated_by_liquid,
    dissipated_by_adhesion,
    stored,
    walls,
    wall_stiffness,
    largest_overlap,
    records;
    exchanges
});

impl Plain for Partner {
    fn put(&self, bytes: &mut Vec<u8>) {
        let (is_wall, number, image) = match *self {
            Self::Particle { row, image } => (false, row, image),
            Self::Wall { wall, image } => (true, u32::from(wall.number()), image),
        };
        (is_wall, (number, image)).put(bytes);
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        let (is_wall, (row, image)) = Plain::take(bytes)?;
        Ok(match is_wall {
            false => Self::Particle { row, image },
            true => Self::Wall {
                wall: WallIndex::new(row as u16),
                image,
            },
        })
    }
}

impl Observation {
    /// An empty observation, with space for the loads of `walls` walls.
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

    /// Adds another observation, without the records of single contacts.
    pub fn merge_sums(&mut self, other: &Self) {
        self.particle_contacts += other.particle_contacts;
        self.wall_contacts += other.wall_contacts;
        self.elastic_energy += other.elastic_energy;
        self.dissipated_by_liquid += other.dissipated_by_liquid;
        self.dissipated_by_adhesion += other.dissipated_by_adhesion;
        self.stored.add(&other.stored, 1.0);
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Each sum for `times` contacts.
    fn seen(times: u32) -> Observation {
        let number = f64::from(times);
        Observation {
            particle_contacts: times.into(),
            wall_contacts: (2 * times).into(),
            elastic_energy: 3.0 * number,
            dissipated_by_liquid: 4.0 * number,
            dissipated_by_adhesion: 6.0 * number,
            stored: SpringEnergy {
                normal: 5.0 * number,
                plastic: 6.0 * number,
                tangential: 7.0 * number,
                rolling: 12.0 * number,
            },
            walls: [8.0, 9.0]
                .map(|of_wall: f64| {
                    let mut load = Load::default();
                    load.add(DVec3::X * of_wall * number, DVec3::Y * of_wall * number);
                    (load, -of_wall * number)
                })
                .to_vec(),
            wall_stiffness: [10.0, 11.0]
                .map(|of_wall: f64| WallStiffness {
                    stiffness: of_wall * number,
                    damping: -of_wall * number,
                })
                .to_vec(),
            ..Observation::default()
        }
    }

    #[test]
    fn blocks_sum_up_to_the_whole() {
        let mut sum = Observation::empty(2);
        sum.merge(&seen(1));
        sum.merge_sums(&seen(2));
        // Whole numbers: no round-off.
        assert_eq!(sum, seen(3));
        let deep = |largest_overlap| Observation {
            largest_overlap,
            ..Observation::default()
        };
        sum.merge(&deep(0.3));
        sum.merge(&deep(0.2));
        assert_eq!(sum.largest_overlap, 0.3);
    }
}
