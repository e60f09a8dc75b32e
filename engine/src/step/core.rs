//! The core of an engine: what all parts of a step work on.

use std::sync::Arc;

use crate::boundaries::Boundaries;
use crate::cell::Cell;
use crate::contact::HistoryNumber;
use crate::forces::{ContactForces, MotionBound, Needs};
use crate::lanes::Width;
use crate::physics::{Physics, Setup, Watched};
use crate::state::Particles;
use crate::surface::Surface;
use crate::task::TaskProgress;
use crate::walls::{WallFilms, WallNow};

use super::Lists;

/// Clock, particles, contacts, walls, sheets and lists: lent to each [`Part`](super::Part) of the step.
pub struct Core {
    pub(crate) physics: Arc<Physics>,
    /// Data that outputs need to be watched in every step.
    pub(crate) watched: Watched,
    /// The periodic box.
    pub(crate) cell: Cell,
    /// All particles.
    pub particles: Particles,
    /// The contact loop with what it remembers of contacts.
    pub(crate) contacts: Box<dyn ContactForces>,
    pub(crate) boundaries: Boundaries,
    /// One for each wall of the plan, then one for each sheet, whose shape it borrows.
    pub(crate) walls: Vec<WallNow>,
    /// Liquid on walls.
    pub(crate) wall_films: WallFilms,
    /// One for each sheet of the plan.
    pub surfaces: Vec<Surface>,
    pub(crate) lists: Lists,
    pub(crate) step: u64,
    /// How particles move in this step.
    pub(crate) motion: MotionBound,
    /// The second half kick of the last step is still to be made; it is made together with the next one.
    pub(super) kick_due: bool,
    /// The present step was begun when the last one ended: its kicks and drift are made already.
    pub(super) drifted: Option<MotionBound>,

    // The fields below never change.
    /// Needs of contacts and parts together.
    pub(crate) needs: Needs,
    /// How far beyond contact forces of each material reach, m; empty if none does.
    pub(super) ranges: Vec<f64>,
    pub(super) law_names: String,
    /// Whether a wall has a servo.
    pub(crate) has_servos: bool,
    pub(crate) inverse_inertia: f64,
    pub(crate) turns: bool,
    /// How many numbers are worked on side by side.
    pub(crate) width: Width,
    /// The progress to which long work reports.
    pub(super) task_progress: Arc<TaskProgress>,
    pub(crate) pool: Option<Arc<rayon::ThreadPool>>,
    /// The pool while steps are made without it.
    pub(super) idle_pool: Option<Arc<rayon::ThreadPool>>,
}

impl Core {
    /// Time of the present state, s: step number times step, never a running sum.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.step as f64 * self.physics.time_step
    }

    /// Time since the last force evaluation, s: 0 in the first.
    #[must_use]
    pub fn since_last(&self) -> f64 {
        if self.step > 0 {
            self.physics.time_step
        } else {
            0.0
        }
    }

    /// Steps made.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.step
    }

    /// Physics of the simulation.
    #[must_use]
    pub fn physics(&self) -> &Arc<Physics> {
        &self.physics
    }

    /// Setup that the engine started from.
    #[must_use]
    pub fn setup(&self) -> Setup {
        Setup {
            physics: Arc::clone(&self.physics),
            watched: self.watched.clone(),
        }
    }

    /// The periodic box as it is now.
    #[must_use]
    pub fn cell(&self) -> &Cell {
        &self.cell
    }

    /// Insertions and deletions, and what they counted.
    #[must_use]
    pub fn boundaries(&self) -> &Boundaries {
        &self.boundaries
    }

    /// The walls as they are now, in the order of the plan.
    #[must_use]
    pub fn walls(&self) -> &[WallNow] {
        &self.walls[..self.physics.walls.len()]
    }

    /// The threads of the engine beside the calling one; `None` if it has no others.
    #[must_use]
    pub fn pool(&self) -> Option<&Arc<rayon::ThreadPool>> {
        self.pool.as_ref()
    }

    /// Facts about the candidate lists.
    #[must_use]
    pub fn lists(&self) -> &Lists {
        &self.lists
    }

    /// Largest speed of a particle in this step, m/s.
    #[must_use]
    pub fn fastest(&self) -> f64 {
        self.motion.squared_speed.sqrt()
    }

    /// Unit and meaning of the numbers that contacts remember.
    #[must_use]
    pub fn history_columns(&self) -> Vec<HistoryNumber> {
        self.contacts.layout().columns
    }

    /// The laws that the contact loop was compiled for.
    #[must_use]
    pub fn law_names(&self) -> &str {
        &self.law_names
    }

    /// Times the candidate list was built, and the listed pairs of the present one.
    #[must_use]
    pub fn list_statistics(&self) -> (u64, usize) {
        (self.lists.rebuilds, self.contacts.listed())
    }
}
