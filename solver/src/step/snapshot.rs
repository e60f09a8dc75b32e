//! The state of a run as sections of bytes: the one list of what a checkpoint holds of the engine.

use std::sync::Arc;

use super::guard::Guard;
use super::{Engine, Lists, RunError, StartOptions};
use crate::forces::SavedSlots;
use crate::plan::Plan;
use crate::state::{DecodeError, Decoder, Encoder, Particles, Pieces, Plain, Sections, whole};
use crate::walls::WallNow;

/// Everything that a run needs to go on bit for bit, beside its plan: also the candidate list, the skin and the count of
/// steps since the list was built, which decide the order of summation in the steps to come.
///
/// Two runs of one plan whose snapshots are equal stay equal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Snapshot(Sections);

/// A part of the engine's state that is written as a section of its own.
struct Section {
    name: &'static str,
    /// Whether runs of this plan have it.
    is_there: fn(&Engine) -> bool,
    /// Appends it.
    put: fn(&Engine, &mut Pieces),
    /// Takes it back. The sections before it are restored already.
    take: fn(&mut Engine, &mut &[u8]) -> Result<(), String>,
}

fn always(_: &Engine) -> bool {
    true
}

fn has_surfaces(engine: &Engine) -> bool {
    !engine.surfaces.is_empty()
}

const CLOCK: &str = "clock";
const PARTICLES: &str = "particles";
const PAIRS: &str = "pairs";
const NEAR_WALLS: &str = "near walls";
const LISTS: &str = "lists";

/// More steps have no time of their own: above it not every whole number is an `f64`.
pub(super) const MOST_STEPS: u64 = 1 << 53;

/// All sections, in the order in which they are written and read.
const SECTIONS: &[Section] = &[
    Section {
        name: CLOCK,
        is_there: always,
        put: |engine, pieces| (engine.step, engine.kick_due).put(pieces.end()),
        take: Engine::take_clock,
    },
    Section {
        name: PARTICLES,
        is_there: always,
        put: |engine, pieces| engine.particles.put_pieces(pieces, engine.pool.as_deref()),
        take: Engine::take_particles,
    },
    Section {
        name: PAIRS,
        is_there: always,
        put: |engine, pieces| {
            let pool = engine.pool.as_deref();
            engine.forces.contacts.put_pairs(pieces, pool);
        },
        take: |engine, bytes| {
            let rows = engine.particles.len();
            engine.forces.contacts.take_pairs(rows, bytes)
        },
    },
    Section {
        name: NEAR_WALLS,
        is_there: always,
        put: |engine, pieces| engine.forces.contacts.put_near_walls(pieces),
        take: |engine, bytes| {
            let counts = (engine.particles.len(), engine.walls.len());
            engine.forces.contacts.take_near_walls(counts, bytes)
        },
    },
    Section {
        name: "other forces",
        is_there: always,
        put: |engine, pieces| engine.forces.saved_others().put(pieces.end()),
        take: |engine, bytes| {
            let saved: Vec<(String, Vec<u8>)> = Plain::take(bytes)?;
            engine.forces.restore_others(&engine.particles, &saved)
        },
    },
    Section {
        name: LISTS,
        is_there: always,
        put: |engine, pieces| engine.lists.put(pieces.end()),
        take: |engine, bytes| {
            engine.lists = Plain::take(bytes)?;
            engine.lists.check(engine.particles.len())
        },
    },
    Section {
        name: "walls",
        is_there: always,
        put: |engine, pieces| {
            let saved: Vec<_> = engine.walls().iter().map(WallNow::save).collect();
            saved.put(pieces.end());
        },
        take: Engine::take_walls,
    },
    Section {
        name: "boundaries",
        is_there: always,
        put: |engine, pieces| engine.boundaries.state().put(pieces.end()),
        take: |engine, bytes| {
            let state = Plain::take(bytes)?;
            engine.boundaries.restore(&state, &engine.particles)
        },
    },
    Section {
        name: "audit",
        is_there: |engine| engine.plan.physics().energy_budget(),
        put: |engine, pieces| {
            engine.audit.put(pieces.end());
            engine.audited.put(pieces.end());
        },
        take: Engine::take_audit,
    },
    Section {
        name: "guard",
        is_there: always,
        put: |engine, pieces| engine.guard.save().put(pieces.end()),
        take: |engine, bytes| {
            engine.guard = Guard::restored(&Vec::take(bytes)?);
            Ok(())
        },
    },
    Section {
        name: "feature loads",
        is_there: |engine| engine.plan.outputs().files().triangle_loads,
        put: |engine, pieces| {
            let in_blocks = engine.forces.contacts.save_feature_loads();
            in_blocks.put(pieces.end());
            engine.load_series.put(pieces.end());
        },
        take: |engine, bytes| {
            let in_blocks: Vec<_> = Plain::take(bytes)?;
            engine.forces.contacts.restore_feature_loads(&in_blocks);
            engine.load_series = Plain::take(bytes)?;
            engine.load_series.check()
        },
    },
    Section {
        name: "surfaces",
        is_there: has_surfaces,
        put: |engine, pieces| engine.saved_surfaces().put(pieces.end()),
        take: |engine, bytes| {
            let saved: Vec<_> = Plain::take(bytes)?;
            engine.restore_surfaces(&saved)
        },
    },
    Section {
        name: "vertices at walls",
        is_there: has_surfaces,
        put: |engine, pieces| engine.forces.contacts.save_vertices().put(pieces.end()),
        take: |engine, bytes| {
            let walls = engine.plan.physics().walls().len();
            let surfaces = engine.surfaces.iter();
            let vertices: Vec<usize> = surfaces.map(|of| of.positions.len()).collect();
            let contacts = &mut engine.forces.contacts;
            contacts.take_vertices((&vertices, walls), bytes)
        },
    },
    Section {
        name: "membranes",
        is_there: |engine| !engine.membranes.is_empty(),
        put: |engine, pieces| engine.saved_membranes().put(pieces.end()),
        take: |engine, bytes| {
            let saved: Vec<_> = Plain::take(bytes)?;
            engine.restore_membranes(&saved)
        },
    },
    Section {
        name: "sleep",
        is_there: |engine| engine.sleep.is_some(),
        put: Engine::put_sleep,
        take: Engine::take_sleep,
    },
    Section {
        name: "liquid",
        is_there: |engine| engine.liquid.is_some(),
        put: |engine, pieces| {
            let liquid = engine.liquid.iter();
            liquid.for_each(|liquid| liquid.save().put(pieces.end()));
        },
        take: |engine, bytes| {
            let saved = Plain::take(bytes)?;
            let mut liquid = engine.liquid.iter_mut();
            liquid.try_for_each(|liquid| liquid.restore(&saved))
        },
    },
    Section {
        name: "sprays",
        is_there: |engine| engine.sprays.is_some(),
        put: |engine, pieces| {
            let sprays = engine.sprays.iter();
            sprays.for_each(|sprays| sprays.state.put(pieces.end()));
        },
        take: |engine, bytes| {
            let mut sprays = engine.sprays.iter_mut();
            sprays.try_for_each(|sprays| sprays.restore(Plain::take(bytes)?))
        },
    },
    Section {
        name: "wear",
        is_there: |engine| engine.wear.is_some(),
        put: |engine, pieces| {
            let wear = engine.wear.iter();
            wear.for_each(|wear| wear.save().put(pieces.end()));
        },
        take: |engine, bytes| {
            let saved = Plain::take(bytes)?;
            let mut wear = engine.wear.iter_mut();
            wear.try_for_each(|wear| wear.restore(&saved))
        },
    },
];

impl Snapshot {
    /// As bytes, with a version and checksums.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        self.0.encode()
    }

    /// From the bytes of [`Snapshot::encode`]. Values are decoded, and checked, when an engine goes on from here.
    ///
    /// # Errors
    /// If the bytes are no state, of another version, cut or damaged.
    pub fn decode(bytes: &[u8]) -> Result<Self, DecodeError> {
        Sections::decode(bytes).map(Self)
    }

    /// From the sections of [`Engine::add_state_to`], which end before the section `end`.
    ///
    /// # Errors
    /// Those of [`Snapshot::decode`].
    pub fn take_from(decoder: &mut Decoder<'_>, end: &str) -> Result<Self, DecodeError> {
        Sections::take_from(decoder, Some(end)).map(Self)
    }

    /// The sections, to look at one by one.
    #[must_use]
    pub fn sections(&self) -> &Sections {
        &self.0
    }

    /// The same with another value in a section, for tests.
    ///
    /// # Errors
    /// Those of [`Sections::get`].
    pub fn edited<T: Plain>(
        &self,
        section: &str,
        edit: impl FnOnce(&mut T),
    ) -> Result<Self, DecodeError> {
        self.0.edited(section, edit).map(Self)
    }

    /// Steps made.
    ///
    /// # Errors
    /// Those of [`Sections::get`].
    pub fn steps(&self) -> Result<u64, DecodeError> {
        self.0.get(CLOCK).map(|(steps, _): (u64, bool)| steps)
    }

    /// All particles with their last loads, row by row.
    ///
    /// # Errors
    /// Those of [`Sections::get`].
    pub fn particles(&self) -> Result<Particles, DecodeError> {
        self.0.get(PARTICLES)
    }

    /// The listed pairs in order, with their histories.
    ///
    /// # Errors
    /// Those of [`Sections::get`].
    pub fn pairs(&self) -> Result<SavedSlots, DecodeError> {
        self.0.get(PAIRS)
    }

    /// The particles near walls in order, with their histories.
    ///
    /// # Errors
    /// Those of [`Sections::get`].
    pub fn near_walls(&self) -> Result<SavedSlots, DecodeError> {
        self.0.get(NEAR_WALLS)
    }

    /// What is known of the candidate lists.
    ///
    /// # Errors
    /// Those of [`Sections::get`].
    pub fn lists(&self) -> Result<Lists, DecodeError> {
        self.0.get(LISTS)
    }
}

impl Engine {
    /// What is known of the candidate lists.
    #[must_use]
    pub fn lists(&self) -> &Lists {
        &self.lists
    }

    /// Appends the sections of [`Engine::snapshot`].
    pub fn add_state_to(&self, encoder: &mut Encoder) {
        let there = SECTIONS.iter().filter(|section| (section.is_there)(self));
        there.for_each(|section| {
            encoder.section_by(section.name, |pieces| (section.put)(self, pieces));
        });
    }

    /// The present state.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        let mut encoder = Encoder::new();
        self.add_state_to(&mut encoder);
        Snapshot(encoder.into_sections())
    }

    /// A run of `plan` that goes on from `snapshot`, which must come from a run of the same plan; the number of threads may
    /// differ. [`Engine::observation`] is empty until the next watched step.
    ///
    /// # Errors
    /// If threads cannot be started, or the snapshot cannot have come from a run of this plan.
    pub fn restore(plan: Arc<Plan>, snapshot: Snapshot, threads: usize) -> Result<Self, RunError> {
        Self::resume(plan, snapshot, StartOptions::threads(threads))
    }

    /// The same for a run that was started with [`Engine::start`], with the same contacts and forces.
    ///
    /// # Errors
    /// Also if these are not the forces of the snapshot.
    pub fn resume(
        plan: Arc<Plan>,
        snapshot: Snapshot,
        options: StartOptions,
    ) -> Result<Self, RunError> {
        Self::unstarted(plan, options)?.restored(&snapshot)
    }

    /// An engine that is not started yet, in the state of a snapshot.
    fn restored(mut self, snapshot: &Snapshot) -> Result<Self, RunError> {
        let mut found = snapshot.0.iter();
        for section in SECTIONS {
            if !(section.is_there)(&self) {
                continue;
            }
            let name = section.name;
            let content = match found.next() {
                Some((next, content)) if next == name => content,
                next => return Err(RunError::other_section(name, next.map(|(name, _)| name))),
            };
            let taken = whole(content, |bytes| (section.take)(&mut self, bytes));
            taken.map_err(|reason| RunError::OtherState {
                section: name.to_owned(),
                reason,
            })?;
        }
        match found.next() {
            Some((name, _)) => Err(RunError::other_section("end", Some(name))),
            None => Ok(self),
        }
    }

    fn take_clock(&mut self, bytes: &mut &[u8]) -> Result<(), String> {
        (self.step, self.kick_due) = Plain::take(bytes)?;
        if self.step > MOST_STEPS {
            return Err("more steps than a run can make".to_owned());
        }
        Ok(())
    }

    fn take_particles(&mut self, bytes: &mut &[u8]) -> Result<(), String> {
        let particles = Particles::take(bytes)?;
        particles.check(self.plan.physics().materials().len())?;
        particles.columns.check_names(&self.particles.columns)?;
        if !particles.may_sleep_so(self.sleep.is_some()) {
            return Err("a particle sleeps that cannot sleep".to_owned());
        }
        self.particles = particles;
        Ok(())
    }

    fn take_walls(&mut self, bytes: &mut &[u8]) -> Result<(), String> {
        let saved: Vec<_> = Plain::take(bytes)?;
        let planned = self.plan.physics().walls();
        if saved.len() != planned.len() {
            let (found, planned) = (saved.len(), planned.len());
            return Err(format!("it has {found} walls, the plan {planned}"));
        }
        let (time, dt) = (self.time(), self.plan.physics().time_step());
        for ((wall, now), saved) in planned.iter().zip(&mut self.walls).zip(&saved) {
            now.restore(wall, saved, (time, dt), &self.images)
                .map_err(|error| format!("walls.{}: {error}", wall.name))?;
        }
        Ok(())
    }
}
