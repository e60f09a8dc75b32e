//! The start: from a plan to the state whose first forces are known.

use std::sync::Arc;

use super::{Audit, Engine, Lists, LoadSeries, RunError};
use crate::boundaries::Boundaries;
use crate::forces::{ContactForces, ForcePass, Forces, Watch, contact_loop};
use crate::neighbours::Skin;
use crate::plan::Plan;
use crate::state::{Particles, inverse_inertia_factor};
use crate::walls::WallNow;

impl Engine {
    /// The state at the start of a planned run, its first forces evaluated, for `threads` threads.
    ///
    /// # Errors
    /// If threads cannot be started, or the start is not a number.
    pub fn new(plan: Arc<Plan>, threads: usize) -> Result<Self, RunError> {
        Self::with_forces(plan, Vec::new(), threads)
    }

    /// The same, without records of the first contacts unless `records`: there are more of them than particles.
    ///
    /// # Errors
    /// As [`Engine::new`].
    pub fn with_records(plan: Arc<Plan>, threads: usize, records: bool) -> Result<Self, RunError> {
        let contacts = contact_loop(plan.physics().laws());
        Self::unstarted(plan, contacts, Vec::new(), threads)?.started(records)
    }

    /// The same with other forces beside the contacts.
    ///
    /// # Errors
    /// As [`Engine::new`].
    pub fn with_forces(
        plan: Arc<Plan>,
        others: Vec<Box<dyn ForcePass>>,
        threads: usize,
    ) -> Result<Self, RunError> {
        let contacts = contact_loop(plan.physics().laws());
        Self::unstarted(plan, contacts, others, threads)?.started(true)
    }

    /// The same with contact laws that no scene can name: a [`ContactLoop`](crate::forces::ContactLoop) over the materials of the
    /// plan, and how the log calls it. Of the plan's own laws only counts whether particles turn.
    ///
    /// # Errors
    /// As [`Engine::new`].
    pub fn with_contacts(
        plan: Arc<Plan>,
        contacts: (Box<dyn ContactForces>, String),
        threads: usize,
    ) -> Result<Self, RunError> {
        Self::unstarted(plan, contacts, Vec::new(), threads)?.started(true)
    }

    /// With its first lists, its first forces evaluated, and with `records` of their contacts.
    pub(super) fn started(mut self, records: bool) -> Result<Self, RunError> {
        self.exchange_particles();
        self.keep_lists_valid(0.0)?;
        let spring_time = if self.plan.physics().startup_increment() {
            self.plan.physics().time_step()
        } else {
            0.0
        };
        let watch = Watch {
            records,
            audit: None,
        };
        self.evaluate_forces(spring_time, Some(watch), false);
        self.answer_loads();
        // The first step begins with its own half kick alone.
        self.kick_due = false;
        Ok(self)
    }

    /// The particles and walls of a plan as they are placed, without lists and forces.
    pub(super) fn unstarted(
        plan: Arc<Plan>,
        (contacts, law_names): (Box<dyn ContactForces>, String),
        others: Vec<Box<dyn ForcePass>>,
        threads: usize,
    ) -> Result<Self, RunError> {
        let forces = Forces::new(contacts, others);
        let needs = forces.needs();
        let images = plan.physics().images();
        let mut particles = Particles::new(plan.physics().orientations() || needs.orientations);
        for new in plan.physics().particles() {
            let (record, mass, prescribed) =
                new.build(plan.physics().materials(), plan.physics().dimensions());
            particles.push(record, mass, prescribed);
        }
        for new in plan.physics().bodies() {
            new.add_to(&mut particles, plan.physics().clumps());
        }
        let pool = match threads {
            0 | 1 => None,
            _ => {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
                Some(Arc::new(
                    pool.map_err(|error| RunError::Threads(error.to_string()))?,
                ))
            }
        };
        let walls = WallNow::all(plan.physics().walls(), plan.physics().time_step(), &images);
        let has_servos = plan
            .physics()
            .walls()
            .iter()
            .any(|wall| wall.motion.servo(0.0).is_some());
        let radii = [
            plan.physics().smallest_radius(),
            plan.physics().mean_radius(),
            plan.physics().largest_radius(),
        ];
        let skin = Skin::first(radii, needs.range, &images);
        Ok(Self {
            boundaries: Boundaries::new(
                plan.physics().insertions(),
                plan.physics().deletions(),
                &plan.physics().setting(),
            ),
            inverse_inertia: inverse_inertia_factor(plan.physics().dimensions()),
            turns: plan.physics().laws().turns(),
            plan,
            particles,
            forces,
            law_names,
            images,
            walls,
            lists: Lists::new(skin),
            has_servos,
            step: 0,
            kick_due: false,
            drifted: None,
            pool,
            audit: Audit::default(),
            load_series: LoadSeries::default(),
        })
    }
}
