//! Data that the outputs of a run need an engine to watch in every step.

use std::sync::Arc;

use super::Physics;
use crate::boundaries::FluxPlan;

/// Setup that an engine starts from.
#[derive(Debug, Clone)]
pub struct Setup {
    /// Physics of the simulation.
    pub physics: Arc<Physics>,
    /// Data that the engine watches.
    pub watched: Watched,
}

/// Type that an engine can start from: a [`Setup`], or one that holds a setup, as a plan does.
pub trait ToSetup {
    /// The setup.
    fn to_setup(&self) -> Setup;
}

impl ToSetup for Setup {
    fn to_setup(&self) -> Setup {
        self.clone()
    }
}

impl<T: ToSetup> ToSetup for Arc<T> {
    fn to_setup(&self) -> Setup {
        self.as_ref().to_setup()
    }
}

impl Setup {
    /// Nothing is watched.
    #[must_use]
    pub fn unwatched(physics: Arc<Physics>) -> Self {
        let watched = Watched::default();
        Self { physics, watched }
    }
}

/// Data that an engine watches in every step, and could not find out afterwards. It changes nothing in the motion.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Watched {
    /// Planes that count what crosses them.
    pub fluxes: Vec<FluxPlan>,
    /// Whether grains that cross a plane or leave are listed one by one.
    pub passages: bool,
    /// Whether loads on the triangles of meshes are summed up.
    pub triangle_loads: bool,
    /// Whether sums of them over time are read for frames, and for the files for ParaView.
    pub load_sums: [bool; 2],
    /// Particles that are followed.
    pub tracking: Tracking,
}

/// Particles and bodies that are followed. Track 1 is the first of the particles; those of insertions come behind.
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
