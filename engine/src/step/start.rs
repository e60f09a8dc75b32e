//! The start: from a plan to the state whose first forces are known.

use std::sync::Arc;

use glam::DQuat;

use super::calls::Beginning;
use super::core::{Clock, Constants, Core, Domain, Threads};
use super::{Engine, Lists, Part, RunError};
use super::{parts, surfaces};
use crate::boundaries::Boundaries;
use crate::forces::{ContactForces, Needs, SavedContacts, Watch, contact_loop};
use crate::lanes::Width;
use crate::neighbours::Skin;
use crate::physics::{Setup, ToSetup};
use crate::ranks::Share;
use crate::state::{Particles, inverse_inertia_factor};
use crate::task::TaskProgress;
use crate::walls::{WallFilms, WallNow};

/// How a run is started or continued.
pub struct StartOptions {
    /// Threads; 0 counts as 1.
    pub threads: usize,
    /// Contact laws that no scene can name: a [`ContactLoop`](crate::forces::ContactLoop) over the materials of the plan, and how the
    /// log calls it. Of the plan's own laws only counts then whether particles turn.
    pub contacts: Option<(Box<dyn ContactForces>, String)>,
    /// Parts of the step beside those of the plan: forces beside the contacts, for instance.
    pub parts: Vec<Box<dyn Part>>,
    /// Whether the contacts of the start are recorded one by one; there are more of them than particles.
    pub records: bool,
    /// How many numbers are worked on side by side; changes no bit. `None`: what is fastest.
    pub width: Option<Width>,
    /// The progress to which long work reports, and which may request to give it up.
    pub task_progress: Arc<TaskProgress>,
    /// The share of this rank, if several compute the scene.
    pub ranks: Option<Share>,
}

impl StartOptions {
    /// The plan's laws and parts, no others, contacts recorded.
    #[must_use]
    pub fn threads(threads: usize) -> Self {
        Self {
            threads,
            contacts: None,
            parts: Vec::new(),
            records: true,
            width: None,
            task_progress: Arc::default(),
            ranks: None,
        }
    }

    /// Watched by this one.
    #[must_use]
    pub fn task_progress(mut self, task_progress: Arc<TaskProgress>) -> Self {
        self.task_progress = task_progress;
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

    /// With these parts beside those of the plan.
    #[must_use]
    pub fn parts(mut self, parts: Vec<Box<dyn Part>>) -> Self {
        self.parts = parts;
        self
    }

    /// As one of several ranks.
    #[must_use]
    pub fn ranks(mut self, ranks: Option<Share>) -> Self {
        self.ranks = ranks;
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
    /// The state at the start, its first forces evaluated, for `threads` threads.
    ///
    /// # Errors
    /// If threads cannot be started, or the start is not a number.
    pub fn new(setup: impl ToSetup, threads: usize) -> Result<Self, RunError> {
        Self::start(setup, StartOptions::threads(threads))
    }

    /// Starts an engine with more options.
    ///
    /// # Errors
    /// As [`Engine::new`].
    pub fn start(setup: impl ToSetup, mut options: StartOptions) -> Result<Self, RunError> {
        let records = options.records;
        Self::lead_beginning(&mut options, || Beginning::Start { records });
        Self::unstarted(setup.to_setup(), options)?.started(records)
    }

    /// With its first lists, its first forces evaluated, and with `records` of their contacts.
    pub(super) fn started(mut self, records: bool) -> Result<Self, RunError> {
        self.take_up_contacts();
        self.call(|part, core| part.start(core));
        self.exchange_particles()?;
        self.keep_lists_valid()?;
        self.try_call(|part, core| part.before_forces(core))?;
        let spring_time = if self.physics.startup_increment {
            self.physics.time_step
        } else {
            0.0
        };
        let watch = Watch {
            records,
            audit: None,
        };
        self.evaluate_forces(spring_time, Some(watch), false);
        // The first step begins with its own half kick alone.
        self.clock.kick_due = false;
        self.end_steps(Some(watch))?;
        self.collect_here(false);
        Ok(self)
    }

    /// Gives the rows of the start the contacts that go on from other runs, as if a list had held them: the first list carries their
    /// histories over like those of any list.
    fn take_up_contacts(&mut self) {
        let physics = Arc::clone(&self.physics);
        let Some(carried) = &physics.carried else {
            return;
        };
        let Core {
            contacts,
            particles,
            domain,
            ..
        } = &mut self.core;
        // Laws that no scene can name may remember something else.
        if carried.pairs.numbers() == contacts.layout().numbers {
            let rows = particles.len();
            contacts.restore(&SavedContacts::Pairs(rows, &carried.pairs));
            contacts.restore(&SavedContacts::NearWalls(&carried.near_walls));
            domain.boundaries.go_on_from_list(rows);
        }
    }

    /// The particles and walls as they are placed, without lists and forces.
    pub(super) fn unstarted(setup: Setup, options: StartOptions) -> Result<Self, RunError> {
        let Setup { physics, watched } = setup;
        let named = options.contacts;
        let has_own_laws = named.is_some();
        let (contacts, law_names) = named.unwrap_or_else(|| contact_loop(&physics.laws));
        let others = options.parts.iter().map(|part| part.needs());
        let needs = Needs {
            range: contacts.ranges().into_iter().fold(0.0, f64::max),
            ..Needs::default()
        };
        let needs = others.fold(needs, Needs::and);
        let cell = physics.cell;
        let mut particles = Particles::new(physics.orientations || needs.orientations);
        for new in &physics.particles {
            let (record, mass, prescribed) = new.build(&physics.materials, physics.dimensions);
            particles.push(record, mass, prescribed);
        }
        for new in &physics.bodies {
            new.add_to(&mut particles, &physics.clumps);
        }
        for property in &physics.properties {
            let mut values = physics.start_values.iter();
            let values = values.find(|values| values.property == *property);
            particles.begin(property, values);
        }
        let pool = match options.threads {
            0 | 1 => None,
            threads => {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
                Some(Arc::new(
                    pool.map_err(|error| RunError::Threads(error.to_string()))?,
                ))
            }
        };
        let mut walls = WallNow::all(&physics.walls, physics.time_step, &cell);
        let (surfaces, borrowing) = surfaces::start(physics.plans.all(), physics.time_step, &cell)?;
        walls.extend(borrowing);
        let has_servos = physics
            .walls
            .iter()
            .any(|wall| wall.motion.all_servos().next().is_some());
        let skin = Skin::first(physics.radii(), needs.range, &cell);
        let mut boundaries = Boundaries::new(
            &physics.insertions,
            &physics.deletions,
            &watched.fluxes,
            &physics.setting(&cell),
        );
        boundaries.report_to(Arc::clone(&options.task_progress));
        if watched.passages {
            boundaries.list_passages();
        }
        let width = options.width.unwrap_or_else(Width::fastest);
        let mut core = Core {
            clock: Clock::default(),
            domain: Domain {
                cell,
                boundaries,
                walls,
                wall_films: WallFilms::default(),
                surfaces,
            },
            particles,
            lists: Lists::new(skin),
            contacts,
            constants: Constants {
                needs,
                ranges: Vec::new(),
                law_names,
                has_servos,
                inverse_inertia: inverse_inertia_factor(physics.dimensions),
                turns: physics.laws.turns(),
                width,
            },
            threads: Threads {
                task_progress: options.task_progress,
                pool,
                idle_pool: None,
            },
            ranks: options.ranks,
            physics,
            watched,
        };
        let mut parts = parts::all(&mut core);
        let planned_parts = parts.len();
        parts.extend(options.parts);
        if core.ranks.is_some()
            && let Some(part) = parts.iter().find(|part| !part.works_on_ranks())
        {
            return Err(RunError::OnRanks {
                what: part.name().to_owned(),
            });
        }
        for part in &parts {
            core.add_columns(part.as_ref())?;
        }
        let of_parts = parts.iter().map(|part| part.needs());
        let of_parts = of_parts.fold(Needs::default(), Needs::and);
        core.constants.needs = core.constants.needs.and(of_parts);
        // Torques beside those of contacts turn particles too.
        core.constants.turns |= of_parts.orientations;
        if of_parts.orientations && core.particles.orientations.is_none() {
            core.particles.orientations = Some(vec![DQuat::IDENTITY; core.particles.len()]);
        }
        core.constants.ranges = core.contacts.ranges();
        if of_parts.range > 0.0 {
            // What acts beside the contacts does not say between which materials.
            core.constants
                .ranges
                .resize(core.physics.materials.len(), 0.0);
            for range in &mut core.constants.ranges {
                *range = range.max(of_parts.range);
            }
        }
        Ok(Self {
            core,
            parts,
            planned_parts,
            has_own_laws,
        })
    }
}

impl Core {
    /// Adds the columns that a part needs to the particles; an error if one of that name is there.
    pub(super) fn add_columns(&mut self, part: &dyn Part) -> Result<(), RunError> {
        let rows = self.particles.len();
        for (column, default) in part.columns() {
            if self.particles.columns.get(column).is_some() {
                let part = part.name().to_owned();
                return Err(RunError::Column { part, column });
            }
            self.particles.columns.add(column, default, rows);
        }
        Ok(())
    }
}
