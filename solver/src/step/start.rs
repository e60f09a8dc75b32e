//! The start: from a plan to the state whose first forces are known.

use std::sync::Arc;

use super::guard::Guard;
use super::sleep::Sleep;
use super::{Audit, Engine, Lists, LoadSeries, RunError};
use super::{surfaces, tracks};
use crate::boundaries::Boundaries;
use crate::forces::{ContactForces, ForcePass, Forces, MotionBound, Watch, contact_loop};
use crate::lanes::Width;
use crate::liquid::Liquids;
use crate::membrane::Moment;
use crate::neighbours::Skin;
use crate::plan::Plan;
use crate::spray::Sprays;
use crate::stage::Stage;
use crate::state::{Particles, inverse_inertia_factor};
use crate::surface::SurfaceMotion;
use crate::walls::WallNow;
use crate::wear::Wear;

/// How a run is started or continued.
pub struct StartOptions {
    /// Threads; 0 counts as 1.
    pub threads: usize,
    /// Contact laws that no scene can name: a [`ContactLoop`](crate::forces::ContactLoop) over the materials of the plan, and how the
    /// log calls it. Of the plan's own laws only counts then whether particles turn.
    pub contacts: Option<(Box<dyn ContactForces>, String)>,
    /// Forces beside the contacts.
    pub forces: Vec<Box<dyn ForcePass>>,
    /// Whether the contacts of the start are recorded one by one; there are more of them than particles.
    pub records: bool,
    /// How many numbers are worked on side by side; changes no bit. `None`: what is fastest.
    pub width: Option<Width>,
    /// The stage to which long work reports, and which may request to give it up.
    pub stage: Arc<Stage>,
}

impl StartOptions {
    /// The plan's laws, no other forces, contacts recorded.
    #[must_use]
    pub fn threads(threads: usize) -> Self {
        Self {
            threads,
            contacts: None,
            forces: Vec::new(),
            records: true,
            width: None,
            stage: Arc::default(),
        }
    }

    /// Watched by this one.
    #[must_use]
    pub fn stage(mut self, stage: Arc<Stage>) -> Self {
        self.stage = stage;
        self
    }

    /// With so many lanes.
    #[must_use]
    pub fn width(mut self, width: Option<Width>) -> Self {
        self.width = width;
        self
    }

    /// With contact laws of their own.
    #[must_use]
    pub fn contacts(mut self, contacts: (Box<dyn ContactForces>, String)) -> Self {
        self.contacts = Some(contacts);
        self
    }

    /// With these forces beside the contacts.
    #[must_use]
    pub fn forces(mut self, forces: Vec<Box<dyn ForcePass>>) -> Self {
        self.forces = forces;
        self
    }

    /// With or without records of the first contacts.
    #[must_use]
    pub fn records(mut self, records: bool) -> Self {
        self.records = records;
        self
    }
}

impl Engine {
    /// The state at the start of a planned run, its first forces evaluated, for `threads` threads.
    ///
    /// # Errors
    /// If threads cannot be started, or the start is not a number.
    pub fn new(plan: Arc<Plan>, threads: usize) -> Result<Self, RunError> {
        Self::start(plan, StartOptions::threads(threads))
    }

    /// The same with more to choose.
    ///
    /// # Errors
    /// As [`Engine::new`].
    pub fn start(plan: Arc<Plan>, options: StartOptions) -> Result<Self, RunError> {
        let records = options.records;
        Self::unstarted(plan, options)?.started(records)
    }

    /// With its first lists, its first forces evaluated, and with `records` of their contacts.
    pub(super) fn started(mut self, records: bool) -> Result<Self, RunError> {
        self.take_up_contacts();
        self.note_first_liquid();
        self.exchange_particles()?;
        self.keep_lists_valid(MotionBound::default())?;
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
        self.forget_rubs();
        // The first step begins with its own half kick alone.
        self.kick_due = false;
        Ok(self)
    }

    /// Gives the rows of the start the contacts that go on from other runs, as if a list had held them: the first list carries their
    /// histories over like those of any list.
    fn take_up_contacts(&mut self) {
        let plan = Arc::clone(&self.plan);
        let Some(carried) = plan.physics().carried() else {
            return;
        };
        let contacts = &mut self.forces.contacts;
        // Laws that no scene can name may remember something else.
        if carried.pairs.numbers() == contacts.saved_numbers() {
            let rows = self.particles.len();
            contacts.restore(rows, &carried.pairs, &carried.near_walls);
            self.boundaries.go_on_from_list(rows);
        }
    }

    /// The particles and walls of a plan as they are placed, without lists and forces.
    pub(super) fn unstarted(plan: Arc<Plan>, options: StartOptions) -> Result<Self, RunError> {
        let named = options.contacts;
        let (contacts, law_names) = named.unwrap_or_else(|| contact_loop(plan.physics().laws()));
        let forces = Forces::new(contacts, options.forces);
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
        let liquid = (plan.physics().liquid().as_ref())
            .map(|of_plan| Liquids::start(of_plan, &mut particles));
        let sprays = plan.physics().sprays().as_ref().map(Sprays::new);
        tracks::start(plan.outputs().files(), &images, &mut particles);
        let pool = match options.threads {
            0 | 1 => None,
            threads => {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
                Some(Arc::new(
                    pool.map_err(|error| RunError::Threads(error.to_string()))?,
                ))
            }
        };
        let mut walls = WallNow::all(plan.physics().walls(), plan.physics().time_step(), &images);
        let wear = Wear::new(plan.physics().wear(), &walls);
        let (mut surfaces, borrowing) = surfaces::start(
            plan.physics().surfaces(),
            plan.physics().time_step(),
            &images,
        )?;
        walls.extend(borrowing);
        let is_near = vec![true; surfaces.len()];
        let stale = vec![false; surfaces.len()];
        let membranes = surfaces::start_membranes(
            (plan.physics().membranes(), &mut surfaces),
            &Moment {
                time: 0.0,
                dt: plan.physics().time_step(),
                gravity: plan.physics().gravity(),
                walls: &walls,
                images: &images,
                has_pool: false,
            },
        );
        for wall in wear.iter().flat_map(|wear| &wear.walls) {
            walls[wall.plan().wall].set_wearing();
        }
        let has_servos = plan
            .physics()
            .walls()
            .iter()
            .any(|wall| wall.motion.all_servos().next().is_some());
        let skin = Skin::first(plan.physics().radii(), needs.range, &images);
        let mut boundaries = Boundaries::new(
            plan.physics().insertions(),
            plan.physics().deletions(),
            plan.outputs().fluxes(),
            &plan.physics().setting(),
        );
        boundaries.tell(Arc::clone(&options.stage));
        let sleep = plan.physics().sleeping().map(|_| Sleep::new());
        let width = options.width.unwrap_or_else(Width::fastest);
        Ok(Self {
            boundaries,
            inverse_inertia: inverse_inertia_factor(plan.physics().dimensions()),
            turns: plan.physics().laws().turns(),
            plan,
            particles,
            forces,
            law_names,
            images,
            walls,
            surfaces,
            vertex_loads: Vec::new(),
            surface_motion: SurfaceMotion::default(),
            membranes,
            is_near,
            stale,
            lists: Lists::new(skin),
            guard: Guard::default(),
            has_servos,
            width,
            stage: options.stage,
            step: 0,
            kick_due: false,
            drifted: None,
            pool,
            idle_pool: None,
            audit: Audit::default(),
            audited: Vec::new(),
            load_series: LoadSeries::default(),
            sleep,
            liquid,
            sprays,
            wear,
        })
    }
}
