//! The time step on one page; each stage has its own module.
//!
//! The engine is a core (clock, particles, contacts, walls, sheets, lists) and the parts of the plan: features that keep a state
//! of their own, each of which acts at the places of the step that it names ([`Part`]).
//!
//! | stage | module |
//! |---|---|
//! | finish the last kick, kick, drift | `kick`, `motion` |
//! | walls move, and change their shape | `walls` |
//! | loads of contacts on vertices of sheets | `surfaces` |
//! | particles come and go | `exchange` |
//! | lists are kept valid | `lists` |
//! | forces; loads of pebbles gathered; fused with them the kicks and the drift that follow | `forces` |
//! | everything else | the parts, by their list in `parts` |

mod calls;
mod core;
mod error;
mod exchange;
mod forces;
mod kick;
mod lists;
mod motion;
mod part;
mod parts;
mod ranks;
mod snapshot;
mod start;
mod surfaces;
mod walls;

pub use self::core::{Core, Domain};
pub use error::RunError;
pub use lists::Lists;
pub use part::{Arrival, CriticalStep, Exchanged, Leaving, NewShape, Part, SizeEstimate};
pub use parts::{bytes_of_parts, critical_step};
pub(crate) use snapshot::MOST_STEPS;
pub use snapshot::Snapshot;
pub use start::StartOptions;

use std::ops::{Deref, DerefMut};

use crate::forces::{Observation, Watch};
use calls::Call;

/// The engine: the whole state of a run and the way from one step to the next. The part to see and to change between steps
/// is that of the [`Core`].
pub struct Engine {
    core: Core,
    /// In the order in which each place of the step calls them: those of the plan, then those from outside.
    parts: Vec<Box<dyn Part>>,
    /// Number of parts of the plan.
    planned_parts: usize,
    /// Whether the contact laws are from outside of the plan.
    has_own_laws: bool,
}

impl Deref for Engine {
    type Target = Core;

    fn deref(&self) -> &Core {
        &self.core
    }
}

impl DerefMut for Engine {
    fn deref_mut(&mut self) -> &mut Core {
        &mut self.core
    }
}

impl Engine {
    /// Makes one time step: velocity Verlet as kick, drift, kick, rotation alike.
    ///
    /// `watch` selects what to observe of the contacts; the [`Engine::observation`] then belongs to the end of the step.
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
        self.lead(Call::Steps { count, watch });
        self.steps_here(count, watch)
    }

    /// The steps of this rank.
    fn steps_here(&mut self, count: u64, watch: Option<Watch>) -> Result<(), RunError> {
        let pool = self.threads.pool.clone();
        if self.is_divided() {
            self.contacts.forget_others();
        }
        let mut run = || {
            let was_worn = self.is_worn();
            for k in 1..=count {
                let last = k == count;
                self.one_step(if last { watch } else { None }, !last)?;
                if self.is_worn() && !was_worn {
                    break;
                }
            }
            self.end_steps(watch)
        };
        match pool {
            Some(pool) => pool.install(run),
            None => run(),
        }
    }

    /// Whether steps are made by the calling thread alone from now on, although there is a pool; they come out the same.
    pub fn step_alone(&mut self, is_alone: bool) {
        let (from, to) = if is_alone {
            (
                &mut self.core.threads.pool,
                &mut self.core.threads.idle_pool,
            )
        } else {
            (
                &mut self.core.threads.idle_pool,
                &mut self.core.threads.pool,
            )
        };
        if from.is_some() {
            *to = from.take();
        }
    }

    /// The time step: velocity Verlet. `fuse`: what follows the forces, which is the second half kick of this step and the first
    /// half kick and drift of the next, is made together with them where nothing forbids it.
    fn one_step(&mut self, watch: Option<Watch>, fuse: bool) -> Result<(), RunError> {
        let kicks = self.core.begin_step();
        self.meet()?;
        self.core.clock.step += 1;
        self.call(|part, core| part.after_drift(core));
        self.move_walls();
        self.reshape_walls()?;
        let dt = self.physics.time_step;
        self.try_call(|part, core| part.advance(core, kicks, dt))?;
        self.call(|part, core| part.after_walls(core));
        self.exchange_particles()?;
        self.keep_lists_valid()?;
        self.try_call(|part, core| part.before_forces(core))?;
        self.core.fetch_records();
        self.evaluate_forces(dt, watch, fuse);
        self.try_call(|part, core| part.end_step(core))
    }

    /// Does the same with all parts in their order.
    fn call(&mut self, mut act: impl FnMut(&mut dyn Part, &mut Core)) {
        let Self { core, parts, .. } = self;
        parts.iter_mut().for_each(|part| act(part.as_mut(), core));
    }

    /// Calls all parts in their order, until one of them fails.
    fn try_call(
        &mut self,
        mut act: impl FnMut(&mut dyn Part, &mut Core) -> Result<(), RunError>,
    ) -> Result<(), RunError> {
        let Self { core, parts, .. } = self;
        parts
            .iter_mut()
            .try_for_each(|part| act(part.as_mut(), core))
    }

    /// Whether a part has come to where it ends the run.
    #[must_use]
    pub fn is_worn(&self) -> bool {
        self.parts.iter().any(|part| part.ends_run())
    }

    /// Observation of the contacts in the last watched step.
    #[must_use]
    pub fn observation(&self) -> Observation {
        let walls = self.physics.walls.len();
        self.with_parts(self.contacts.observation(walls, true))
    }

    /// Observation of the contacts in the last watched step, without leaving their records behind.
    pub fn take_observation(&mut self) -> Observation {
        let walls = self.physics.walls.len();
        let records = self.contacts.take_records();
        let sums = self.contacts.observation(walls, false);
        self.with_parts(Observation { records, ..sums })
    }

    /// With what parts add to an observation of the contacts.
    fn with_parts(&self, mut observation: Observation) -> Observation {
        for part in &self.parts {
            part.observe(&self.core, &mut observation);
        }
        observation
    }
}
