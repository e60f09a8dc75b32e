//! The core of an engine: what all parts of a step work on.

use std::sync::Arc;

use crate::boundaries::Boundaries;
use crate::cell::Cell;
use crate::contact::HistoryNumber;
use crate::forces::{ContactForces, MotionBound, Needs};
use crate::lanes::Width;
use crate::physics::{Physics, Setup, Watched};
use crate::ranks::Share;
use crate::state::Particles;
use crate::surface::Surface;
use crate::task::TaskProgress;
use crate::walls::{WallFilms, WallNow};

use super::Lists;

/// Clock, particles, contacts, walls, sheets and lists: lent to each [`Part`](super::Part) of the step.
pub struct Core {
    pub(super) physics: Arc<Physics>,
    /// Quantities that outputs need to be watched in every step.
    pub(super) watched: Watched,
    pub(super) clock: Clock,
    /// Domain, walls and sheets.
    pub domain: Domain,
    /// All particles.
    pub particles: Particles,
    pub(super) lists: Lists,
    /// The contact loop with its memory of contacts.
    pub contacts: Box<dyn ContactForces>,
    pub(super) constants: Constants,
    pub(super) threads: Threads,
    /// The share of this rank, where there are several.
    pub(super) ranks: Option<Share>,
}

/// Domain, walls and sheets, and the particles that enter or leave.
pub struct Domain {
    /// The periodic box.
    pub(super) cell: Cell,
    pub(super) boundaries: Boundaries,
    /// One for each wall of the plan, then one for each sheet, whose shape it borrows. Their number never changes.
    pub walls: Vec<WallNow>,
    /// Liquid on walls.
    pub wall_films: WallFilms,
    /// One for each sheet of the plan.
    pub surfaces: Vec<Surface>,
}

impl Domain {
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

    /// Sheets to be changed, with the walls and the periodic box around them.
    pub fn sheets(&mut self) -> (&mut [Surface], &[WallNow], &Cell) {
        (&mut self.surfaces, &self.walls, &self.cell)
    }
}

/// Steps made, and the motion that is made ahead or still due.
#[derive(Default)]
pub(super) struct Clock {
    pub(super) step: u64,
    /// How particles move in this step.
    pub(super) motion: MotionBound,
    /// The second half kick of the last step is still to be made; it is made together with the next one.
    pub(super) kick_due: bool,
    /// The present step was begun when the last one ended: its kicks and drift are made already.
    pub(super) drifted: Option<MotionBound>,
}

/// Values that never change in a run.
pub(super) struct Constants {
    /// Needs of contacts and parts together.
    pub(super) needs: Needs,
    /// How far beyond contact forces of each material reach, m; empty if none does.
    pub(super) ranges: Vec<f64>,
    pub(super) law_names: String,
    /// Whether a wall has a servo.
    pub(super) has_servos: bool,
    /// m r^2 / I of a sphere or disc.
    pub(super) inverse_inertia: f64,
    /// Whether rotations are integrated.
    pub(super) turns: bool,
    /// How many numbers are worked on side by side.
    pub(super) width: Width,
}

/// Threads, and the progress of long work.
pub(super) struct Threads {
    /// The progress to which long work reports.
    pub(super) task_progress: Arc<TaskProgress>,
    pub(super) pool: Option<Arc<rayon::ThreadPool>>,
    /// The pool while steps are made without it.
    pub(super) idle_pool: Option<Arc<rayon::ThreadPool>>,
}

impl Core {
    /// Time of the present state, s: step number times step, never a running sum.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.clock.step as f64 * self.physics.time_step
    }

    /// Time since the last force evaluation, s: 0 in the first.
    #[must_use]
    pub fn since_last(&self) -> f64 {
        if self.clock.step > 0 {
            self.physics.time_step
        } else {
            0.0
        }
    }

    /// Steps made.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.clock.step
    }

    /// Physics of the simulation.
    #[must_use]
    pub fn physics(&self) -> &Arc<Physics> {
        &self.physics
    }

    /// Quantities that outputs need to be watched in every step.
    #[must_use]
    pub fn watched(&self) -> &Watched {
        &self.watched
    }

    /// Needs of contacts and parts together.
    #[must_use]
    pub fn needs(&self) -> Needs {
        self.constants.needs
    }

    /// Whether a wall has a servo.
    #[must_use]
    pub fn has_servos(&self) -> bool {
        self.constants.has_servos
    }

    /// Whether rotations are integrated.
    #[must_use]
    pub fn turns(&self) -> bool {
        self.constants.turns
    }

    /// m r^2 / I of a sphere, or of a disc in two dimensions.
    #[must_use]
    pub fn inverse_inertia(&self) -> f64 {
        self.constants.inverse_inertia
    }

    /// How many numbers are worked on side by side.
    #[must_use]
    pub fn width(&self) -> Width {
        self.constants.width
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
        &self.domain.cell
    }

    /// Insertions and deletions, and what they counted.
    #[must_use]
    pub fn boundaries(&self) -> &Boundaries {
        &self.domain.boundaries
    }

    /// The walls as they are now, in the order of the plan.
    #[must_use]
    pub fn walls(&self) -> &[WallNow] {
        &self.domain.walls[..self.physics.walls.len()]
    }

    /// The threads of the engine beside the calling one; `None` if it has no others.
    #[must_use]
    pub fn pool(&self) -> Option<&Arc<rayon::ThreadPool>> {
        self.threads.pool.as_ref()
    }

    /// Facts about the candidate lists.
    #[must_use]
    pub fn lists(&self) -> &Lists {
        &self.lists
    }

    /// Largest speed of a particle in this step, m/s.
    #[must_use]
    pub fn fastest(&self) -> f64 {
        self.clock.motion.squared_speed.sqrt()
    }

    /// Unit and meaning of the numbers that contacts remember.
    #[must_use]
    pub fn history_columns(&self) -> Vec<HistoryNumber> {
        self.contacts.layout().columns
    }

    /// The laws that the contact loop was compiled for.
    #[must_use]
    pub fn law_names(&self) -> &str {
        &self.constants.law_names
    }

    /// Times the candidate list was built, and the listed pairs of the present one.
    #[must_use]
    pub fn list_statistics(&self) -> (u64, usize) {
        let own = || self.contacts.count()[0];
        let listed = self.ranks.as_ref().map_or_else(own, |share| share.listed);
        (self.lists.rebuilds, listed)
    }
}
