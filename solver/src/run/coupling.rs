//! A run that another program drives: walls with a motion from outside, their loads, and states in memory to go back to.

use std::sync::Arc;

use glam::{DQuat, DVec3};

use super::rest_criterion::Rest;
use super::{Ending, Run, RunFailure};
use crate::output::chain::WALL_LOADS;
use crate::output::{OutputError, Positions, Schedule};
use crate::plan::Plan;
use crate::results::Aims;
use mercury_engine::forces::{Observation, StepContext};
use mercury_engine::state::{Load, Pieces, Plain, WallIndex};
use mercury_engine::step::{Core, Part, Snapshot};

/// Where a driven wall stands at the end of its next window, and how it moves until then.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WallDrive {
    /// Place of the wall's reference point at the end, m.
    pub place: DVec3,
    /// Turn of the wall since the start of the run.
    pub turn: DQuat,
    /// Of the reference point, m/s.
    pub velocity: DVec3,
    /// rad/s
    pub angular_velocity: DVec3,
}

impl WallDrive {
    fn numbers(&self) -> ((DVec3, DQuat), [DVec3; 2]) {
        let velocities = [self.velocity, self.angular_velocity];
        ((self.place, self.turn), velocities)
    }
}

/// Loads on all walls in every step, and their means over a window.
///
/// The particles get, by velocity Verlet, half of the first and half of the last load of a window, and all in between. So do the means: mean load times length of the window
/// is the momentum that the wall gave up, to round-off.
#[derive(Debug, Default)]
pub(super) struct WallLoads {
    now: Vec<Load>,
    sums: Vec<Load>,
    steps: u64,
}

impl WallLoads {
    /// Begins the means anew.
    fn begin(&mut self) {
        self.sums = vec![Load::default(); self.now.len()];
        self.steps = 0;
    }

    /// Load of a wall in the last step, and its mean.
    fn of(&self, wall: usize) -> [Load; 2] {
        let now = self.now.get(wall).copied().unwrap_or_default();
        if self.steps == 0 {
            return [now; 2];
        }
        let (sum, steps) = (self.sums[wall], self.steps as f64);
        [now, Load::new(sum.force / steps, sum.torque / steps)]
    }
}

impl Part for WallLoads {
    fn name(&self) -> &str {
        WALL_LOADS
    }

    fn inform<'a>(&'a self, context: &mut StepContext<'a>) {
        context.wall_loads = true;
    }

    fn after_forces(&mut self, core: &mut Core, _: Option<&Observation>) {
        let before = std::mem::take(&mut self.now);
        self.now = core.contacts.wall_loads(core.walls().len());
        // At the start no time has passed.
        if core.steps() == 0 {
            self.begin();
            return;
        }
        for ((sum, before), now) in self.sums.iter_mut().zip(&before).zip(&self.now) {
            for load in [before, now] {
                sum.add(0.5 * load.force, 0.5 * load.torque);
            }
        }
        self.steps += 1;
    }

    fn put(&self, _: &Core, pieces: &mut Pieces) {
        let numbers = |load: &Load| (load.force, load.torque);
        let now: Vec<(DVec3, DVec3)> = self.now.iter().map(numbers).collect();
        let sums: Vec<(DVec3, DVec3)> = self.sums.iter().map(numbers).collect();
        ((now, sums), self.steps).put(pieces.end());
    }

    fn take(&mut self, core: &mut Core, bytes: &mut &[u8]) -> Result<(), String> {
        type Loads = Vec<(DVec3, DVec3)>;
        let ((now, sums), steps): ((Loads, Loads), u64) = Plain::take(bytes)?;
        let walls = core.walls().len();
        if now.len() != walls || sums.len() != walls {
            return Err(format!(
                "it has loads on {} walls, not on {walls}",
                now.len()
            ));
        }
        let load = |(force, torque)| Load::new(force, torque);
        self.now = now.into_iter().map(load).collect();
        self.sums = sums.into_iter().map(load).collect();
        self.steps = steps;
        Ok(())
    }
}

/// State of a run in memory.
#[derive(Debug, Clone)]
pub struct Saved {
    plan: Arc<Plan>,
    snapshot: Snapshot,
    rest: Option<Rest>,
    aims: Option<Aims>,
    observed: Option<Observation>,
    ended: Option<Ending>,
    /// Files, and number of states passed to the writer.
    files: (Arc<Positions>, u64),
}

/// Why a run cannot be coupled as requested.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CouplingError {
    /// There is no wall of that number.
    #[error("no wall {wall}: the run has {count}, counted from 0")]
    NoWall {
        /// The number.
        wall: usize,
        /// Walls of the run.
        count: usize,
    },
    /// The run does not sum up loads.
    #[error("the run was begun without loads on walls")]
    NoLoads,
    /// The state is of another run.
    #[error("the saved state is of another run")]
    OtherRun,
}

impl Run {
    /// Number of a wall by its name.
    #[must_use]
    pub fn wall(&self, name: &str) -> Option<usize> {
        let mut walls = self.plan.physics().walls.iter();
        walls.position(|wall| wall.name == name)
    }

    fn check_wall(&self, wall: usize) -> Result<(), CouplingError> {
        let count = self.plan.physics().walls.len();
        match wall < count {
            true => Ok(()),
            false => Err(CouplingError::NoWall { wall, count }),
        }
    }

    /// Drives a wall with `motion = "external"` in the next window, which is the next [`Self::advance`]. Without it the wall rests.
    ///
    /// # Errors
    /// If there is no such wall, its motion is that of the scene, or a number is not finite.
    pub fn drive_wall(&mut self, wall: usize, drive: WallDrive) -> Result<(), RunFailure> {
        self.check_wall(wall)?;
        // Its numbers are checked now, so that the error comes from here.
        let (to, velocities) = drive.numbers();
        let index = WallIndex::new(wall as u16);
        self.engine
            .next_drive(index, f64::INFINITY, to, velocities)?;
        self.drives.retain(|(other, _)| *other != wall);
        self.drives.push((wall, drive));
        Ok(())
    }

    /// Begins a window that ends with step `until`.
    pub(super) fn begin_window(&mut self, until: u64) -> Result<(), RunFailure> {
        let end = until.min(self.plan.physics().steps) as f64 * self.plan.physics().time_step;
        for (wall, drive) in std::mem::take(&mut self.drives) {
            let (to, velocities) = drive.numbers();
            let wall = WallIndex::new(wall as u16);
            self.engine.drive_wall(wall, end, to, velocities)?;
        }
        if let Some((loads, _)) = self.engine.part_and_core::<WallLoads>() {
            loads.begin();
        }
        Ok(())
    }

    /// Load of the particles on a wall about its reference point: in the last step, and the mean over the last window. Force in N, torque in N m.
    ///
    /// # Errors
    /// If there is no such wall, or the run was begun without [`RunOptions::wall_loads`](super::RunOptions::wall_loads).
    pub fn wall_load(&mut self, wall: usize) -> Result<[Load; 2], CouplingError> {
        self.check_wall(wall)?;
        let part = self.engine.part_and_core::<WallLoads>();
        let (loads, _) = part.ok_or(CouplingError::NoLoads)?;
        Ok(loads.of(wall))
    }

    /// Place of the reference point of a wall (m), and its turn since the start.
    ///
    /// # Errors
    /// If there is no such wall.
    pub fn wall_pose(&self, wall: usize) -> Result<(DVec3, DQuat), CouplingError> {
        self.check_wall(wall)?;
        let state = &self.engine.walls()[wall].state;
        Ok((state.reference, state.pose.rotation))
    }

    /// The present state, to go back to by [`Self::restore`].
    ///
    /// # Errors
    /// If the output failed.
    pub fn save(&mut self) -> Result<Saved, RunFailure> {
        let positions = match self.positions.take() {
            Some(known) if known.1 == self.sent => known,
            _ => {
                let positions = self.writer.positions().ok_or(OutputError::Lost)?;
                (Arc::new(positions), self.sent)
            }
        };
        self.positions = Some(positions.clone());
        Ok(Saved {
            plan: Arc::clone(&self.plan),
            snapshot: self.engine.snapshot(),
            rest: self.rest.clone(),
            aims: self.aims.clone(),
            observed: self.observed.clone(),
            ended: self.ended,
            files: positions,
        })
    }

    /// Goes back to a state of this run. Files are cut back to it, and all that follows comes out as if the steps behind it had never been made.
    ///
    /// # Errors
    /// If the state is of another run, or a file cannot be cut.
    pub fn restore(&mut self, saved: &Saved) -> Result<(), RunFailure> {
        if !Arc::ptr_eq(&self.plan, &saved.plan) {
            return Err(CouplingError::OtherRun.into());
        }
        self.engine.return_to(&saved.snapshot)?;
        let (positions, sent) = &saved.files;
        if *sent != self.sent {
            let history = self.engine.history_columns();
            let columns = (&history[..], &self.engine.audit().losses);
            let to = (&**positions, self.engine.steps(), self.engine.time());
            self.writer
                .go_back(&self.options.folder, &self.plan, columns, to)?;
            self.sent = *sent;
        }
        let dt = self.plan.physics().time_step;
        self.schedule = Schedule::behind(self.plan.outputs().files(), dt, self.engine.steps());
        self.rest.clone_from(&saved.rest);
        self.aims.clone_from(&saved.aims);
        self.observed.clone_from(&saved.observed);
        self.ended = saved.ended;
        self.positions = Some(saved.files.clone());
        self.drives.clear();
        Ok(())
    }
}
