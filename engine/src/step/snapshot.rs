//! The state of a run as sections of bytes: the one list of what a checkpoint holds of the engine.

use super::calls::Beginning;
use super::{Core, Engine, Lists, Part, RunError, StartOptions};
use crate::cell::Cell;
use crate::forces::{ContactCounts, ContactSection, SavedSlots};
use crate::physics::ToSetup;
use crate::state::{DecodeError, Decoder, Encoder, Particles, Pieces, Plain, Sections, whole};
use crate::walls::{Drive, WallNow};

/// Everything that a run needs to go on bit for bit, beside its plan: also the candidate list, the skin and the count of
/// steps since the list was built, which decide the order of summation in the steps to come.
///
/// Two runs of one plan whose snapshots are equal stay equal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Snapshot(Sections);

/// A section of a checkpoint that holds something of the core; each part of the step has one more.
struct Section {
    name: &'static str,
    /// Whether runs of this plan have it.
    is_there: fn(&Core) -> bool,
    /// Appends it.
    put: fn(&Core, &mut Pieces),
    /// Takes it back. The sections before it are restored already.
    take: fn(&mut Core, &mut &[u8]) -> Result<(), String>,
}

fn always(_: &Core) -> bool {
    true
}

fn has_surfaces(core: &Core) -> bool {
    !core.domain.surfaces.is_empty()
}

/// Whether sliding at walls is summed up from step to step.
fn has_sliding(core: &Core) -> bool {
    core.domain.walls.iter().any(WallNow::wears) || core.watched.triangle_loads
}

const CLOCK: &str = "clock";
const CELL: &str = "cell";
const PARTICLES: &str = "particles";
const PAIRS: &str = "pairs";
const NEAR_WALLS: &str = "near walls";
const LISTS: &str = "lists";

/// More steps have no time of their own: above it not every whole number is an `f64`.
pub(crate) const MOST_STEPS: u64 = 1 << 53;

/// The sections of the core, in the order in which they are written and read; those of the parts follow in theirs.
const SECTIONS: &[Section] = &[
    Section {
        name: CLOCK,
        is_there: always,
        put: |core, pieces| (core.clock.step, core.clock.kick_due).put(pieces.end()),
        take: Core::take_clock,
    },
    Section {
        name: CELL,
        is_there: always,
        put: |core, pieces| core.domain.cell.put(pieces.end()),
        take: Core::take_cell,
    },
    Section {
        name: PARTICLES,
        is_there: always,
        put: |core, pieces| {
            core.particles
                .put_pieces(pieces, core.threads.pool.as_deref())
        },
        take: Core::take_particles,
    },
    Section {
        name: "walls",
        is_there: always,
        put: |core, pieces| {
            let saved: Vec<_> = core.walls().iter().map(WallNow::save).collect();
            saved.put(pieces.end());
        },
        take: Core::take_walls,
    },
    Section {
        name: "driven walls",
        is_there: |core| core.walls().iter().any(|wall| wall.drive().is_some()),
        put: |core, pieces| {
            let drives = core.walls().iter().filter_map(WallNow::drive);
            drives.copied().collect::<Vec<_>>().put(pieces.end());
        },
        take: Core::take_drives,
    },
    Section {
        name: PAIRS,
        is_there: always,
        put: |core, pieces| core.put_contacts(ContactSection::Pairs, pieces),
        take: |core, bytes| core.take_contacts(ContactSection::Pairs, bytes),
    },
    Section {
        name: NEAR_WALLS,
        is_there: always,
        put: |core, pieces| core.put_contacts(ContactSection::NearWalls, pieces),
        take: |core, bytes| core.take_contacts(ContactSection::NearWalls, bytes),
    },
    Section {
        name: "friction at walls",
        is_there: has_sliding,
        put: |core, pieces| core.put_contacts(ContactSection::Friction, pieces),
        take: |core, bytes| core.take_contacts(ContactSection::Friction, bytes),
    },
    Section {
        name: LISTS,
        is_there: always,
        put: |core, pieces| core.lists.put(pieces.end()),
        take: |core, bytes| {
            core.lists = Plain::take(bytes)?;
            core.lists.check(core.particles.len())
        },
    },
    Section {
        name: "boundaries",
        is_there: always,
        put: |core, pieces| core.domain.boundaries.state().put(pieces.end()),
        take: |core, bytes| {
            let state = Plain::take(bytes)?;
            core.domain
                .boundaries
                .restore(&state, &core.particles, &core.domain.cell)
        },
    },
    Section {
        name: "passages",
        is_there: |core| core.watched.passages,
        put: |core, pieces| core.domain.boundaries.passages().to_vec().put(pieces.end()),
        take: |core, bytes| {
            let passages = Plain::take(bytes)?;
            core.domain.boundaries.restore_passages(passages);
            Ok(())
        },
    },
    Section {
        name: "surfaces",
        is_there: has_surfaces,
        put: |core, pieces| core.saved_surfaces().put(pieces.end()),
        take: |core, bytes| {
            let saved: Vec<_> = Plain::take(bytes)?;
            core.restore_surfaces(&saved)
        },
    },
    Section {
        name: "vertices at walls",
        is_there: has_surfaces,
        put: |core, pieces| core.put_contacts(ContactSection::Vertices, pieces),
        take: |core, bytes| core.take_contacts(ContactSection::Vertices, bytes),
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
        Sections::take_from(decoder, end).map(Self)
    }

    /// The sections, to look at one by one.
    #[must_use]
    pub fn sections(&self) -> &Sections {
        &self.0
    }

    /// This snapshot with another value in a section, for tests.
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

    /// Facts about the candidate lists.
    ///
    /// # Errors
    /// Those of [`Sections::get`].
    pub fn lists(&self) -> Result<Lists, DecodeError> {
        self.0.get(LISTS)
    }
}

impl Engine {
    /// Appends the sections of [`Engine::snapshot`].
    pub fn add_state_to(&self, encoder: &mut Encoder) {
        let core = &self.core;
        let there = SECTIONS.iter().filter(|section| (section.is_there)(core));
        there.for_each(|section| {
            encoder.section_by(section.name, |pieces| (section.put)(core, pieces));
        });
        for part in &self.parts {
            encoder.section_by(part.name(), |pieces| part.put(core, pieces));
        }
    }

    /// The present state.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        let mut encoder = Encoder::new();
        self.add_state_to(&mut encoder);
        Snapshot(encoder.into_sections())
    }

    /// An engine that goes on from `snapshot`, which must come from one of the same setup; the number of threads may
    /// differ. [`Engine::observation`] is empty until the next watched step.
    ///
    /// # Errors
    /// If threads cannot be started, or the snapshot cannot have come from this setup.
    pub fn restore(
        setup: impl ToSetup,
        snapshot: Snapshot,
        threads: usize,
    ) -> Result<Self, RunError> {
        Self::resume(setup, snapshot, StartOptions::threads(threads))
    }

    /// Resumes a run that was started with [`Engine::start`], with the same contacts and forces.
    ///
    /// # Errors
    /// Also if these are not the forces of the snapshot.
    pub fn resume(
        setup: impl ToSetup,
        snapshot: Snapshot,
        mut options: StartOptions,
    ) -> Result<Self, RunError> {
        Self::lead_beginning(&mut options, || Beginning::Resume(snapshot.encode()));
        let mut engine = Self::unstarted(setup.to_setup(), options)?;
        take_state(&mut engine.core, &mut engine.parts, &snapshot)?;
        engine.divide();
        if engine.is_divided() {
            engine.call(|part, core| part.collect_from_ranks(core));
        }
        Ok(engine)
    }

    /// Goes to the state of `snapshot`, which must come from a run of the same setup with the same contact laws and parts. Threads,
    /// lanes, and the laws and parts from outside of the plan stay. It takes the memory of two states until it returns, and of three
    /// with laws or parts from outside.
    ///
    /// # Errors
    /// If the snapshot cannot have come from this setup. The engine stays as it was then.
    pub fn restore_in_place(&mut self, snapshot: &Snapshot) -> Result<(), RunError> {
        let has_others = self.has_own_laws || self.parts.len() > self.planned_parts;
        // What is from outside takes its sections one by one, and may have taken some when one is refused.
        let before = has_others.then(|| self.snapshot());
        let taken = self.go_to(snapshot);
        if let (Err(_), Some(before)) = (&taken, before) {
            self.go_to(&before)?;
        }
        taken
    }

    /// Goes back to a state of this engine itself: as [`Self::restore_in_place`], without a copy of the present state for the case that the
    /// snapshot is refused.
    ///
    /// # Errors
    /// If the snapshot is of another engine. This one cannot go on then.
    pub fn return_to(&mut self, snapshot: &Snapshot) -> Result<(), RunError> {
        self.go_to(snapshot)
    }

    fn go_to(&mut self, snapshot: &Snapshot) -> Result<(), RunError> {
        let options = StartOptions::threads(1).task_progress(self.threads.task_progress.clone());
        // All that is of the plan begins anew, so that nothing of the present state is left.
        let mut next = Self::unstarted(self.setup(), options)?;
        let outside = self.parts.split_off(self.planned_parts);
        let columns = outside
            .iter()
            .try_for_each(|part| next.core.add_columns(part.as_ref()));
        next.parts.extend(outside);
        self.exchange_options(&mut next);
        let taken = columns.and_then(|()| take_state(&mut next.core, &mut next.parts, snapshot));
        if taken.is_ok() {
            std::mem::swap(self, &mut next);
        } else {
            self.exchange_options(&mut next);
            self.parts.extend(next.parts.drain(self.planned_parts..));
        }
        taken
    }

    /// Exchanges what the options of a start decide.
    fn exchange_options(&mut self, other: &mut Self) {
        let (a, b) = (&mut self.core, &mut other.core);
        std::mem::swap(&mut a.constants, &mut b.constants);
        std::mem::swap(&mut a.threads, &mut b.threads);
        if self.has_own_laws {
            std::mem::swap(&mut a.contacts, &mut b.contacts);
            other.has_own_laws = true;
        }
    }
}

/// Takes the state of a snapshot into a core that is not started yet, and its parts.
fn take_state(
    core: &mut Core,
    parts: &mut [Box<dyn Part>],
    snapshot: &Snapshot,
) -> Result<(), RunError> {
    let mut found = snapshot.0.iter();
    for section in SECTIONS {
        if (section.is_there)(core) {
            let name = section.name;
            take_section(found.next(), name, |bytes| (section.take)(core, bytes))?;
        }
    }
    for part in parts {
        let name = part.name().to_owned();
        take_section(found.next(), &name, |bytes| part.take(core, bytes))?;
    }
    match found.next() {
        Some((name, _)) => Err(RunError::other_section("end", Some(name))),
        None => Ok(()),
    }
}

/// Takes the section that was found, which must have this name.
fn take_section(
    found: Option<(&str, &[u8])>,
    name: &str,
    take: impl FnOnce(&mut &[u8]) -> Result<(), String>,
) -> Result<(), RunError> {
    let content = match found {
        Some((found, content)) if found == name => content,
        found => return Err(RunError::other_section(name, found.map(|(name, _)| name))),
    };
    whole(content, take).map_err(|reason| RunError::OtherState {
        section: name.to_owned(),
        reason,
    })
}

impl Core {
    fn put_contacts(&self, section: ContactSection, pieces: &mut Pieces) {
        self.contacts
            .put(section, pieces, self.threads.pool.as_deref());
    }

    fn take_contacts(&mut self, section: ContactSection, bytes: &mut &[u8]) -> Result<(), String> {
        let surfaces = self.domain.surfaces.iter();
        let counts = ContactCounts {
            rows: self.particles.len(),
            walls: self.domain.walls.len(),
            walls_of_vertices: self.physics.walls.len(),
            vertices: surfaces.map(|of| of.positions.len()).collect(),
        };
        self.contacts.take(section, &counts, bytes)
    }

    fn take_clock(&mut self, bytes: &mut &[u8]) -> Result<(), String> {
        (self.clock.step, self.clock.kick_due) = Plain::take(bytes)?;
        if self.clock.step > MOST_STEPS {
            return Err("more steps than a run can make".to_owned());
        }
        Ok(())
    }

    fn take_cell(&mut self, bytes: &mut &[u8]) -> Result<(), String> {
        let cell = Cell::take(bytes)?;
        // It is at rest, so that of the plan is that of every state.
        if cell != self.physics.cell {
            let text = |cell: &Cell| {
                format!(
                    "{} to {}, periodic {:?}",
                    cell.low(),
                    cell.high(),
                    cell.periodic()
                )
            };
            let (found, planned) = (text(&cell), text(&self.physics.cell));
            return Err(format!("it is {found}, that of the plan {planned}"));
        }
        self.domain.cell = cell;
        Ok(())
    }

    fn take_particles(&mut self, bytes: &mut &[u8]) -> Result<(), String> {
        let particles = Particles::take(bytes)?;
        particles.check(self.physics.materials.len())?;
        particles.columns.check_names(&self.particles.columns)?;
        self.particles = particles;
        Ok(())
    }

    /// Behind the walls.
    fn take_drives(&mut self, bytes: &mut &[u8]) -> Result<(), String> {
        let saved: Vec<Drive> = Plain::take(bytes)?;
        let (time, dt) = (self.time(), self.physics.time_step);
        let walls = self.physics.walls.iter().zip(&mut self.domain.walls);
        let mut driven: Vec<_> = walls.filter(|(_, now)| now.drive().is_some()).collect();
        if saved.len() != driven.len() {
            let (found, planned) = (saved.len(), driven.len());
            return Err(format!("it has {found} driven walls, the plan {planned}"));
        }
        for ((wall, now), drive) in driven.iter_mut().zip(saved) {
            now.restore_drive(wall, drive, (time, dt), &self.domain.cell);
        }
        Ok(())
    }

    fn take_walls(&mut self, bytes: &mut &[u8]) -> Result<(), String> {
        let saved: Vec<_> = Plain::take(bytes)?;
        let planned = &self.physics.walls;
        if saved.len() != planned.len() {
            let (found, planned) = (saved.len(), planned.len());
            return Err(format!("it has {found} walls, the plan {planned}"));
        }
        let (time, dt) = (self.time(), self.physics.time_step);
        for ((wall, now), saved) in planned.iter().zip(&mut self.domain.walls).zip(&saved) {
            now.restore(wall, saved, (time, dt), &self.domain.cell)
                .map_err(|error| format!("walls.{}: {error}", wall.name))?;
        }
        Ok(())
    }
}
