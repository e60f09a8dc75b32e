//! A part of the step: a feature with a state of its own, and what it does at each place of the step.
//!
//! A part lives in the folder of its feature (`FEATURE/part.rs`) and is named once, in the list of `step/parts.rs`. Its place in
//! the step, its section of a checkpoint and its warnings follow from the functions that it has; all of them may be left out
//! but the name. See `docs/how-to/add-a-force.md`.

use std::any::Any;
use std::ops::Range;

use glam::DVec3;

use super::{Core, RunError};
use crate::forces::{Needs, NewList, Observation, SharedContacts, StepContext};
use crate::physics::{Physics, Plans, Setup};
use crate::state::{Particles, Pieces, WallIndex};
use crate::walls::{WallFilms, WallNow};

/// A part of the step.
///
/// Parts are called in the order of their list and get the same numbers whatever the number of threads; their results must not
/// depend on it either. Functions stand here in the order in which a step calls them.
pub trait Part: Any + Send {
    /// A name for it, unique in the run: that of its section in a checkpoint.
    fn name(&self) -> &str;

    /// The part of a plan that has this feature. Parts from outside leave it out.
    fn of(core: &mut Core) -> Option<Self>
    where
        Self: Sized,
    {
        let _ = core;
        None
    }

    /// Memory that the feature takes in a run, beside what particles, lists and contacts take in any run, bytes: estimated before anything is made.
    #[must_use]
    fn bytes(setup: &Setup, crowd: &SizeEstimate) -> f64
    where
        Self: Sized,
    {
        let _ = (setup, crowd);
        0.0
    }

    /// The critical time step of what the feature does beside the contacts, if it has one; found before the step of a plan is chosen.
    #[must_use]
    fn critical_step(plans: &Plans) -> Option<CriticalStep>
    where
        Self: Sized,
    {
        let _ = plans;
        None
    }

    /// Needs of the part; they stay the same during a whole run.
    fn needs(&self) -> Needs {
        Needs::default()
    }

    /// Columns of particles that it needs, each by its name, with the value of new particles. They are sorted, removed and saved with the
    /// particles. No other column may have that name.
    fn columns(&self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }

    /// A run starts, from a plan and not from a checkpoint: particles and contacts of the start are there, lists and forces not yet.
    fn start(&mut self, core: &mut Core) {
        let _ = core;
    }

    /// Particles have moved; walls have not.
    fn after_drift(&mut self, core: &mut Core) {
        let _ = core;
    }

    /// The meshes that it changes in this step, if it [`needs`](Self::needs) to.
    fn reshape_walls(&mut self, core: &Core) -> Vec<NewShape> {
        let _ = core;
        Vec::new()
    }

    /// Walls have moved, too: kicks what has a motion of its own by so many half steps, as many as particles got in this step, and moves it by
    /// `drift` (s). Without a drift the second half kick of the step is completed, so that the state can be observed.
    ///
    /// # Errors
    /// Why the run cannot go on.
    fn advance(&mut self, core: &mut Core, kicks: u32, drift: f64) -> Result<(), RunError> {
        let _ = (core, kicks, drift);
        Ok(())
    }

    /// Particles, walls and sheets have moved; no particle has come or gone yet.
    fn after_walls(&mut self, core: &mut Core) {
        let _ = core;
    }

    /// Particles are about to be removed.
    fn before_leaving(&mut self, at: &mut Leaving<'_>) {
        let _ = at;
    }

    /// Particles have come and gone, perhaps.
    fn after_exchange(&mut self, core: &mut Core, exchanged: &Exchanged) {
        let _ = (core, exchanged);
    }

    /// Particles are about to be put back into a periodic domain and sorted.
    ///
    /// # Errors
    /// Why the run cannot go on.
    fn before_list(&mut self, core: &mut Core) -> Result<(), RunError> {
        let _ = core;
        Ok(())
    }

    /// There is a new candidate list.
    fn new_list(&mut self, list: &NewList<'_>) {
        let _ = list;
    }

    /// Lists are valid, forces follow.
    ///
    /// # Errors
    /// Why the run cannot go on.
    fn before_forces(&mut self, core: &mut Core) -> Result<(), RunError> {
        let _ = core;
        Ok(())
    }

    /// Adds the data of the part that the laws of contacts need.
    fn inform<'a>(&'a self, context: &mut StepContext<'a>) {
        let _ = context;
    }

    /// The loads of the contacts are known, on particles and on vertices of sheets: adds its own. To those of particles only a part may add
    /// that [`needs`](Needs::after_contacts) to come after them; else particles may have made their next kicks already.
    fn add_loads(&mut self, core: &mut Core) {
        let _ = core;
    }

    /// All loads are known. `sums`: what contacts did, if a part [`needs`](Needs::sums) it in every step.
    fn after_forces(&mut self, core: &mut Core, sums: Option<&Observation>) {
        let _ = (core, sums);
    }

    /// Whether it makes its part of a step where rows are divided among ranks ([`crate::ranks`]).
    fn works_on_ranks(&self) -> bool {
        false
    }

    /// Bytes for the same part on all ranks, at the end of a step; empty in most.
    fn send_to_ranks(&mut self) -> Vec<u8> {
        Vec::new()
    }

    /// Takes what this part has sent on each rank, in their order.
    ///
    /// # Errors
    /// Why the run cannot go on; the same on all ranks.
    fn receive_from_ranks(
        &mut self,
        core: &mut Core,
        messages: &[Vec<u8>],
    ) -> Result<(), RunError> {
        let _ = (core, messages);
        Ok(())
    }

    /// Rows were divided among ranks anew: gives what it keeps of rows that have left this rank to those that compute them now, and names the
    /// rows of others that it reads ([`Core::read_rows`]). At the first call every rank has the whole state.
    fn take_share(&mut self, core: &mut Core) {
        let _ = core;
    }

    /// Brings what it has on each rank to the first one, which observes or saves it until the next step.
    fn collect_from_ranks(&mut self, core: &mut Core) {
        let _ = core;
    }

    /// The end of the step.
    ///
    /// # Errors
    /// Why the run cannot go on.
    fn end_step(&mut self, core: &mut Core) -> Result<(), RunError> {
        let _ = core;
        Ok(())
    }

    /// Adds its share of the present state to an observation of the contacts: energy stored, loads on walls.
    fn observe(&self, core: &Core, observation: &mut Observation) {
        let _ = (core, observation);
    }

    /// The energy that it has taken from the particles since the start, J; negative if it gave some; `None` if it takes none. The audit
    /// counts it among the losses, by the name of the part.
    fn dissipated(&self) -> Option<f64> {
        None
    }

    /// Work that walls have done through it on the particles since the start, and the share of walls with servos, J: where it holds particles to
    /// walls.
    fn wall_work(&self) -> [f64; 2] {
        [0.0; 2]
    }

    /// Whether the run has come to where this part ends it.
    fn ends_run(&self) -> bool {
        false
    }

    /// Warnings for the user at the end of the run, a line each.
    fn warnings(&self, core: &Core) -> Vec<String> {
        let _ = core;
        Vec::new()
    }

    /// Appends its state, by rows or by ids, to a checkpoint.
    fn put(&self, core: &Core, pieces: &mut Pieces) {
        let _ = (core, pieces);
    }

    /// Takes back what [`Part::put`] wrote, and forgets what belongs to another state: a part from outside may have made steps before
    /// ([`Engine::restore_in_place`](super::Engine::restore_in_place)). The core has its state back.
    ///
    /// # Errors
    /// If these bytes cannot be of this part and plan, with the reason.
    fn take(&mut self, core: &mut Core, bytes: &mut &[u8]) -> Result<(), String> {
        let _ = (core, bytes);
        Ok(())
    }
}

/// The mesh of a wall whose corners move.
#[derive(Debug, Clone, PartialEq)]
pub struct NewShape {
    /// Number of the wall in the plan.
    pub wall: WallIndex,
    /// Positions of all corners in the wall's own frame at the end of the step, m.
    pub corners: Vec<DVec3>,
    /// Their velocities in that frame in the middle of the step, m/s, which contacts see; empty: at rest.
    pub velocities: Vec<DVec3>,
}

/// The largest time step at which the integrator bears a feature.
#[derive(Debug, Clone, PartialEq)]
pub struct CriticalStep {
    /// s
    pub time: f64,
    /// Key and name of what sets it.
    pub of: String,
    /// How a user makes it longer.
    pub way_out: &'static str,
}

/// The numbers of a run that its memory depends on.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SizeEstimate {
    /// Particles and pebbles.
    pub rows: f64,
    /// Pairs of them that touch.
    pub touching: f64,
}

/// Particles that are about to be removed.
pub struct Leaving<'a> {
    /// Their rows, and whether each leaves through a face of the domain.
    pub leavers: &'a [(u32, bool)],
    /// All particles.
    pub particles: &'a mut Particles,
    /// All contacts.
    pub contacts: SharedContacts<'a>,
    /// Films of walls.
    pub wall_films: &'a mut WallFilms,
    /// Walls as they are now.
    pub walls: &'a [WallNow],
    /// Physics of the simulation.
    pub physics: &'a Physics,
}

/// Grains that an insertion brought in this step.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Arrival {
    /// The insertion, by its number in the plan.
    pub insertion: usize,
    /// The rows that it brought.
    pub rows: Range<usize>,
    /// Grains that it had brought before.
    pub before: u64,
}

/// Particles that came and went in a step.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Exchanged {
    /// Rows were added or removed.
    pub changed: bool,
    /// Particles that came.
    pub arrivals: Vec<Arrival>,
}
