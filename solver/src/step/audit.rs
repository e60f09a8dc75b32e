//! The energy audit: running sums over the steps.

use crate::forces::Observation;

/// What happened to the energy since the start, J; filled only in audited runs.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Audit {
    /// By viscous and plastic normal forces.
    pub dissipated_normal: f64,
    /// By sliding friction and tangential dashpots.
    pub dissipated_tangential: f64,
    /// By rolling and torsion resistance.
    pub dissipated_rolling: f64,
    /// Done by the walls on the particles.
    pub wall_work: f64,
}

impl Audit {
    /// Dissipated by all mechanisms, J.
    #[must_use]
    pub fn dissipated(&self) -> f64 {
        self.dissipated_normal + self.dissipated_tangential + self.dissipated_rolling
    }

    /// Takes in what one audited step saw.
    pub(super) fn take_in(&mut self, observation: &Observation) {
        self.dissipated_normal += observation.dissipated_normal;
        self.dissipated_tangential += observation.dissipated_tangential;
        self.dissipated_rolling += observation.dissipated_rolling;
        self.wall_work += observation.wall_work;
    }
}

crate::state::plain!(Audit {
    dissipated_normal,
    dissipated_tangential,
    dissipated_rolling,
    wall_work
});
