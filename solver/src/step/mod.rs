//! The time step on one page; each stage has its own module.
//!
//! | stage | module |
//! |---|---|
//! | finish the last kick, kick, drift | `kick`, `motion` |
//! | walls move, and change their shape | `walls` |
//! | vertices of sheets move, and their meshes follow; loads on them | `surfaces` |
//! | particles out of balance are woken, calm ones put to rest | `sleep` |
//! | particles come and go | `exchange` |
//! | lists are kept valid | `lists` |
//! | droplets leave, fly and are caught | `spray` |
//! | forces; loads of pebbles gathered; fused with them the kicks and the drift that follow | `forces` |
//! | walls lose what these contacts wear, and their surfaces follow | `wear` |
//! | what is beyond a limit is named | `guard`, `crossings` |

mod audit;
mod awake;
mod crossings;
mod error;
mod exchange;
mod forces;
mod guard;
mod kick;
mod lists;
mod load_series;
mod motion;
mod sleep;
mod snapshot;
mod spray;
mod start;
mod surfaces;
#[cfg(test)]
mod tests;
mod tracks;
mod walls;
mod wear;

pub use audit::{Audit, AuditedContact};
pub use error::RunError;
pub use lists::Lists;
pub use load_series::LoadSeries;
pub use sleep::{SavedSleep, SleepCounts};
pub use snapshot::Snapshot;
pub use start::StartOptions;

use std::sync::Arc;

pub(crate) use tracks::Tracked;

use awake::awake;
use guard::Guard;
use sleep::Sleep;

use crate::boundaries::Boundaries;
use crate::contact::HistoryNumber;
use crate::forces::{Forces, MotionBound, Observation, Watch};
use crate::lanes::Width;
use crate::liquid::Liquids;
use crate::membrane::MembraneNow;
use crate::neighbours::Images;
use crate::plan::Plan;
use crate::spray::Sprays;
use crate::stage::Stage;
use crate::state::{Load, Particles};
use crate::surface::{Surface, SurfaceMotion};
use crate::walls::WallNow;
use crate::wear::Wear;

/// The engine: the whole state of a run and the way from one step to the next.
pub struct Engine {
    plan: Arc<Plan>,
    /// All particles.
    pub particles: Particles,
    /// All forces with what they remember of contacts.
    forces: Forces,
    boundaries: Boundaries,
    /// One for each wall of the plan, then one for each sheet, whose shape it borrows.
    walls: Vec<WallNow>,
    /// One for each sheet of the plan.
    surfaces: Vec<Surface>,
    /// Whether particles of the present candidate list are near each of them.
    is_near: Vec<bool>,
    /// Whether the mesh of each of them was left behind, as no particle is near.
    stale: Vec<bool>,
    /// Their mechanics, one for each, or none at all.
    membranes: Vec<MembraneNow>,
    /// What walls did to the vertices of each sheet in the last forces; empty if none touches walls.
    vertex_loads: Vec<Vec<Load>>,
    /// How the sheets moved in this step.
    surface_motion: SurfaceMotion,
    lists: Lists,
    guard: Guard,
    step: u64,
    /// The second half kick of the last step is still to be made; it is made together with the next one.
    kick_due: bool,
    /// The present step was begun when the last one ended: its kicks and drift are made already.
    drifted: Option<MotionBound>,
    /// Running sums of the energy audit.
    audit: Audit,
    /// The contacts of the last forces, in audited runs.
    audited: Vec<AuditedContact>,
    /// Running sums of the loads on the triangles of meshes.
    load_series: LoadSeries,
    /// The state of sleeping particles, if the plan enables sleeping.
    sleep: Option<Sleep>,
    /// Films and bridges, in scenes with liquid.
    liquid: Option<Liquids>,
    /// Droplets, in scenes with sprays.
    sprays: Option<Sprays>,
    /// Walls that wear, in scenes that have any.
    wear: Option<Wear>,

    // What follows never changes.
    law_names: String,
    images: Images,
    /// Whether a wall has a servo.
    has_servos: bool,
    inverse_inertia: f64,
    turns: bool,
    /// How many numbers are worked on side by side.
    width: Width,
    /// The stage to which long work reports.
    stage: Arc<Stage>,
    pool: Option<Arc<rayon::ThreadPool>>,
    /// The pool while steps are made without it.
    idle_pool: Option<Arc<rayon::ThreadPool>>,
}

impl Engine {
    /// Makes one time step: velocity Verlet as kick, drift, kick, rotation alike.
    ///
    /// `watch` says what to see of the contacts; the [`Engine::observation`] then belongs to the end of the step.
    ///
    /// # Errors
    /// If a particle's motion is no longer a number, or if the guard of the plan is strict and something is beyond its limits.
    pub fn step(&mut self, watch: Option<Watch>) -> Result<(), RunError> {
        self.steps_at_once(1, watch)
    }

    /// Makes `count` time steps; `watch` is for the last one. The result is that of `count` calls of [`Engine::step`], to the
    /// bit, but the states in between are not observed, so that each block of particles can go on to the next step while it is in
    /// the cache. Fewer are made where a wall is worn to the depth at which the run ends ([`Engine::is_worn`]): that step is not
    /// observed, and one more must follow.
    ///
    /// # Errors
    /// If a particle's motion is no longer a number, or if the guard of the plan is strict and something is beyond its limits.
    pub fn steps_at_once(&mut self, count: u64, watch: Option<Watch>) -> Result<(), RunError> {
        let pool = self.pool.clone();
        let mut run = || {
            let was_worn = self.is_worn();
            for k in 1..=count {
                let last = k == count;
                self.one_step(if last { watch } else { None }, !last)?;
                if self.is_worn() && !was_worn {
                    break;
                }
            }
            Ok(())
        };
        match pool {
            Some(pool) => pool.install(|| awake(run)),
            None => run(),
        }
    }

    /// Whether steps are made by the calling thread alone from now on, although there is a pool; they come out the same.
    pub fn step_alone(&mut self, is_alone: bool) {
        let (from, to) = if is_alone {
            (&mut self.pool, &mut self.idle_pool)
        } else {
            (&mut self.idle_pool, &mut self.pool)
        };
        if from.is_some() {
            *to = from.take();
        }
    }

    /// The time step: velocity Verlet. `fuse`: what follows the forces, which is the second half kick of this step and the first
    /// half kick and drift of the next, is made together with them where nothing forbids it.
    fn one_step(&mut self, watch: Option<Watch>, fuse: bool) -> Result<(), RunError> {
        // The sheets' part of the kicks is never made ahead.
        let kicks = 1 + u32::from(self.kick_due || self.drifted.is_some());
        let fastest = match self.drifted.take() {
            Some(fastest) => fastest,
            None => self.kick_and_drift(),
        };
        if !fastest.sum_of_squares.is_finite() {
            return Err(self.not_finite());
        }
        self.step += 1;
        let speed = fastest.squared_speed.sqrt();
        self.guard_ways(speed);
        self.move_walls();
        self.reshape_walls()?;
        self.advance_surfaces(kicks, speed)?;
        self.guard_crossings(speed);
        let fastest = self.rouse_and_put_to_rest(fastest);
        self.exchange_particles()?;
        self.guard_leavers();
        self.keep_lists_valid(fastest)?;
        self.settle();
        self.spray(speed)?;
        self.evaluate_forces(self.plan.physics().time_step(), watch, fuse);
        self.guard_membranes()?;
        self.wear_walls()?;
        self.guard_contacts();
        self.guarded()
    }

    /// Time of the present state, s: step number times step, never a running sum.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.step as f64 * self.plan.physics().time_step()
    }

    /// Steps made.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.step
    }

    /// The plan it follows.
    #[must_use]
    pub fn plan(&self) -> &Arc<Plan> {
        &self.plan
    }

    /// Periodic images of the domain.
    #[must_use]
    pub fn images(&self) -> &Images {
        &self.images
    }

    /// Insertions and deletions, and what they counted.
    #[must_use]
    pub fn boundaries(&self) -> &Boundaries {
        &self.boundaries
    }

    /// The walls as they are now, in the order of the plan.
    #[must_use]
    pub fn walls(&self) -> &[WallNow] {
        &self.walls[..self.plan.physics().walls().len()]
    }

    /// What was seen of the contacts in the last watched step.
    #[must_use]
    pub fn observation(&self) -> Observation {
        let mut observation = self.forces.observation(self.plan.physics().walls().len());
        self.add_holds_to_walls(&mut observation);
        observation
    }

    /// The same, without leaving the records of contacts behind.
    pub(crate) fn take_observation(&mut self) -> Observation {
        let mut observation = self
            .forces
            .take_observation(self.plan.physics().walls().len());
        self.add_holds_to_walls(&mut observation);
        observation
    }

    /// The energy balance, if the plan includes it.
    #[must_use]
    pub fn audit(&self) -> Audit {
        let set_free = (self.liquid.as_ref()).map_or(0.0, |liquid| liquid.balance.set_free);
        let mut audit = self.audit;
        audit.dissipated_adhesion += set_free;
        audit
    }

    /// Unit and meaning of the numbers that contacts remember.
    #[must_use]
    pub fn history_columns(&self) -> Vec<HistoryNumber> {
        self.forces.contacts.history_columns()
    }

    /// The laws that the contact loop was compiled for.
    #[must_use]
    pub fn law_names(&self) -> &str {
        &self.law_names
    }

    /// Times the candidate list was built, and the listed pairs of the present one.
    #[must_use]
    pub fn list_statistics(&self) -> (u64, usize) {
        (self.lists.rebuilds, self.forces.contacts.listed())
    }
}
