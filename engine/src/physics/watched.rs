//! Data that the outputs of a run need an engine to watch in every step.

use std::sync::Arc;

use super::Physics;
use crate::boundaries::FluxPlan;
use crate::tracks::Tracking;

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
