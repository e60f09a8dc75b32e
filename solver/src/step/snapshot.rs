//! The state of a run as one plain value.

use std::sync::Arc;

use super::{Audit, Engine, LoadSeries, RunError};
use crate::boundaries::BoundaryState;
use crate::forces::{SavedLoads, SavedSlot};
use crate::neighbours::{Skin, Validity};
use crate::plan::Plan;
use crate::state::Particles;
use crate::walls::{Pose, ServoState};

/// Everything that a run needs to go on bit for bit, beside its plan: also the candidate list, the skin and the count of
/// steps since the list was built, which decide the order of summation in the steps to come.
///
/// Two runs of one plan whose snapshots are equal stay equal.
#[derive(Debug, Clone, PartialEq)]
pub struct Snapshot {
    /// Steps made.
    pub step: u64,
    /// All particles with their last loads, row by row.
    pub particles: Particles,
    /// The listed pairs in order, with their histories.
    pub pairs: Vec<SavedSlot>,
    /// The particles near walls in order, with their histories.
    pub near_walls: Vec<SavedSlot>,
    /// Thickness of the skin, and its limits.
    pub skin: Skin,
    /// How much farther than half the skin each particle may go, m; empty if none may.
    pub leeway: Vec<f64>,
    /// How much of the skin is used up.
    pub validity: Validity,
    /// Poses of the walls when the list was built.
    pub listed_poses: Vec<Pose>,
    /// How far the servos of the walls have come: one for each wall, or empty where no wall has one.
    pub servos: Vec<ServoState>,
    /// The second half kick of the last step is still to be made.
    pub kick_due: bool,
    /// Rows were added or removed since the list was built.
    pub rows_changed: bool,
    /// How often the list was built.
    pub rebuilds: u64,
    /// Insertions and deletions, and what they counted.
    pub boundaries: BoundaryState,
    /// Running sums of the energy audit.
    pub audit: Audit,
    /// Loads on features of meshes as they lie in the blocks, and the sums taken from there.
    pub feature_loads: (Vec<SavedLoads>, LoadSeries),
}

impl Engine {
    /// The present state.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        let (pairs, near_walls) = self.forces.save();
        Snapshot {
            step: self.step,
            particles: self.particles.clone(),
            pairs,
            near_walls,
            skin: self.skin,
            leeway: self.leeway.clone(),
            validity: self.validity,
            listed_poses: self.listed_poses.clone(),
            servos: self.servos.clone(),
            kick_due: self.kick_due,
            rows_changed: self.rows_changed,
            rebuilds: self.rebuilds,
            boundaries: self.boundaries.state(),
            audit: self.audit,
            feature_loads: (self.forces.save_feature_loads(), self.load_series.clone()),
        }
    }

    /// A run of `plan` that goes on from `snapshot`, which must come from a run of the same plan; the number of threads may
    /// differ. [`Engine::observation`] is empty until the next watched step.
    ///
    /// # Errors
    /// If threads cannot be started.
    pub fn restore(plan: Arc<Plan>, snapshot: Snapshot, threads: usize) -> Result<Self, RunError> {
        let mut engine = Self::unstarted(plan, threads)?;
        let rows = snapshot.particles.len();
        engine
            .forces
            .restore(rows, &snapshot.pairs, &snapshot.near_walls);
        let (in_blocks, taken) = snapshot.feature_loads;
        engine.forces.restore_feature_loads(&in_blocks);
        engine.load_series = taken;
        engine.step = snapshot.step;
        engine.particles = snapshot.particles;
        engine.skin = snapshot.skin;
        engine.leeway = snapshot.leeway;
        engine.validity = snapshot.validity;
        engine.listed_poses = snapshot.listed_poses;
        engine.servos = snapshot.servos;
        engine.kick_due = snapshot.kick_due;
        engine.rows_changed = snapshot.rows_changed;
        engine.rebuilds = snapshot.rebuilds;
        engine.boundaries.restore(&snapshot.boundaries, rows);
        engine.audit = snapshot.audit;
        let (time, dt) = (engine.time(), engine.plan.time_step);
        engine.wall_states = engine
            .plan
            .walls
            .iter()
            .enumerate()
            .map(|(index, wall)| {
                let driven = engine.servos.get(index).copied().unwrap_or_default();
                wall.driven_state(time, dt, &driven)
            })
            .collect();
        Ok(engine)
    }
}
