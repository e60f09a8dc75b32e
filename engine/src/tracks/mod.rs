//! Which particles are followed, and by how many periods each was put back into the domain.

mod part;

use glam::DVec3;

pub(crate) use part::Tracks;

/// Name of the column with the track of each particle, counted from 1 in the order of [`Tracking`]; 0:
/// none. Of a clump its first pebble has it.
pub const TRACK: &str = "track";

/// Names of the columns that count the periods by which a tracked particle, or the clump of a tracked pebble, was put back into the domain.
pub const PERIODS: [&str; 3] = ["periods_x", "periods_y", "periods_z"];

/// Which particles and bodies are followed. Track 1 is the first of the particles; those of insertions come behind.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Tracking {
    /// Particles and bodies of the start, by id.
    pub particles: Vec<u32>,
    /// Insertions whose grains are followed, by index.
    pub insertions: Vec<usize>,
    /// Every n-th of these grains, from the first.
    pub every: u64,
}

impl Tracking {
    /// Whether nothing is followed.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.particles.is_empty() && self.insertions.is_empty()
    }

    /// The track of the grains of an insertion, by its index.
    #[must_use]
    pub fn track_of(&self, insertion: usize) -> Option<u32> {
        let place = self
            .insertions
            .iter()
            .position(|index| *index == insertion)?;
        Some((self.particles.len() + place + 1) as u32)
    }
}

/// A tracked particle or body.
pub struct Tracked {
    /// Its row; of a body, that of its first pebble.
    pub row: usize,
    /// Its track.
    pub track: u32,
    /// Centre, m: where it would be in a domain that goes on for ever.
    pub position: DVec3,
}
