//! The guard in a step: ways, crossings and contacts are compared with the limits.

mod crossings;

use glam::DVec3;

use super::finding::{Count, Finding, FindingKind};
use super::{GuardPolicy, SEEN};
use crate::contact::parameter::short;
use crate::forces::{AlarmKind, Alarms, Other, StepContext, Subject, Watch};
use crate::spray::Sprays;
use crate::state::{Pieces, Plain, WallIndex};
use crate::step::{Core, Engine, Exchanged, Part, RunError};

/// Kinds of findings in the order in which a step finds them: long ways before contacts.
const ORDER: [usize; 5] = [3, 4, 0, 1, 2];

/// Counts of the guard of a run.
#[derive(Debug, Clone, Default)]
pub(crate) struct GuardPart {
    /// By kind of contact, then long ways, then vertices that left the domain.
    counts: [Count; 5],
    /// Finds the particles that went through a wall in this step without a contact that shows it.
    crossed: Alarms,
    /// Why the run stops.
    stop: Option<Finding>,
    /// Nothing stops it any more: the last step is made to be looked at.
    off: bool,
    /// Findings of this rank in this step, where there are several.
    found: Vec<Finding>,
    /// Overlap over the smaller radius beyond which a contact is named; `None` if the guard is off.
    overlap: Option<f64>,
}

impl Part for GuardPart {
    fn name(&self) -> &str {
        "guard"
    }

    fn of(core: &mut Core) -> Option<Self> {
        let guard = core.physics().guard;
        let is_off = guard.policy == GuardPolicy::Off;
        Some(Self {
            overlap: (!is_off).then_some(guard.overlap),
            ..Self::default()
        })
    }

    fn after_drift(&mut self, core: &mut Core) {
        self.look_at_ways(core);
    }

    fn after_walls(&mut self, core: &mut Core) {
        self.look_for_crossings(core);
        self.look_for_crossing_vertices(core);
        self.look_for_vertices_outside(core);
    }

    fn after_exchange(&mut self, core: &mut Core, _: &Exchanged) {
        // What leaves at the start was placed outside.
        if core.steps() > 0 {
            self.look_at_leavers(core);
        }
    }

    fn inform<'a>(&'a self, context: &mut StepContext<'a>) {
        if let Some(overlap) = self.overlap {
            context.overlap_limit = overlap;
            context.deep = overlap.min(SEEN);
        }
    }

    fn works_on_ranks(&self) -> bool {
        true
    }

    fn send_to_ranks(&mut self) -> Vec<u8> {
        let found = std::mem::take(&mut self.found);
        if found.is_empty() {
            return Vec::new();
        }
        let found = found.iter().map(|found| (found.index(), found.numbers()));
        let mut bytes = Vec::new();
        found.collect::<Vec<_>>().put(&mut bytes);
        bytes
    }

    fn receive_from_ranks(
        &mut self,
        core: &mut Core,
        messages: &[Vec<u8>],
    ) -> Result<(), RunError> {
        let of_rank = |bytes: &Vec<u8>| <Vec<(usize, Vec<f64>)>>::take(&mut &bytes[..]).ok();
        let found = messages.iter().filter_map(of_rank).flatten();
        let found = found.filter_map(|(kind, numbers)| Finding::from_numbers(kind, &numbers));
        let found: Vec<Finding> = found.collect();
        // One of each kind, in the order in which a step finds them.
        for kind in ORDER {
            let of_kind = found.iter().filter(|found| found.index() == kind);
            let worse = |worst: &'_ Finding, other: &'_ Finding| other.part() > worst.part();
            let worst =
                of_kind.reduce(|worst, other| if worse(worst, other) { other } else { worst });
            if let Some(worst) = worst {
                self.count(core, *worst);
            }
        }
        self.judge(core)
    }

    fn end_step(&mut self, core: &mut Core) -> Result<(), RunError> {
        self.look_at_contacts(core);
        self.judge(core)
    }

    fn warnings(&self, core: &Core) -> Vec<String> {
        self.counted(core)
    }

    fn put(&self, _: &Core, pieces: &mut Pieces) {
        self.save().put(pieces.end());
    }

    fn take(&mut self, _: &mut Core, bytes: &mut &[u8]) -> Result<(), String> {
        *self = Self {
            overlap: self.overlap,
            ..Self::restored(&Vec::take(bytes)?)
        };
        Ok(())
    }
}

impl GuardPart {
    /// How often each kind happened, and the worst of it in numbers: what must be kept to go on later.
    fn save(&self) -> Vec<(u64, Vec<f64>)> {
        let counts = self.counts.iter();
        counts
            .map(|count| {
                let numbers = count.worst.map(|worst| worst.numbers());
                (count.steps, numbers.unwrap_or_default())
            })
            .collect()
    }

    /// From what [`GuardPart::save`] gave; what is no event of ours is forgotten.
    fn restored(saved: &[(u64, Vec<f64>)]) -> Self {
        let mut guard = Self::default();
        for (kind, (steps, numbers)) in saved.iter().enumerate() {
            if let Some(count) = guard.counts.get_mut(kind) {
                count.steps = *steps;
                count.worst = Finding::from_numbers(kind, numbers);
            }
        }
        guard
    }
}

impl GuardPart {
    /// Checks the displacements of this step.
    fn look_at_ways(&mut self, core: &Core) {
        let guard = core.physics().guard;
        let dt = core.physics().time_step;
        let is_short = core.fastest() * dt <= guard.way * core.physics().smallest_radius();
        if is_short || guard.policy == GuardPolicy::Off {
            return;
        }
        let mut worst: Option<(usize, f64)> = None;
        let own = core.own_rows();
        for (row, record) in own.clone().zip(&core.particles.records[own]) {
            let part = record.velocity.length() * dt / record.radius;
            if part > guard.way && worst.is_none_or(|(_, most)| part > most) {
                worst = Some((row, part));
            }
        }
        if let Some((row, part)) = worst {
            let record = &core.particles.records[row];
            let what = FindingKind::Way {
                id: core.particles.ids[row],
                position: record.position,
                part,
                speed: record.velocity.length(),
            };
            self.note(core, what);
        }
    }

    /// Looks for vertices of sheets that have left the domain: all were inside at the start.
    fn look_for_vertices_outside(&mut self, core: &Core) {
        if core.physics().guard.policy == GuardPolicy::Off {
            return;
        }
        let cell = core.cell();
        let (min, max) = cell.faces();
        let mut worst: Option<(Subject, DVec3, f64)> = None;
        for (surface, sheet) in (0..).zip(&core.domain.surfaces) {
            for (vertex, &position) in (0..).zip(&sheet.positions) {
                let beyond = (min - position).max(position - max);
                for axis in 0..3 {
                    let way = beyond[axis];
                    if !cell.is_periodic(axis)
                        && way > 0.0
                        && worst.is_none_or(|(.., most)| way > most)
                    {
                        worst = Some((Subject::Vertex { surface, vertex }, position, way));
                    }
                }
            }
        }
        if let Some((of, position, way)) = worst {
            self.note(core, FindingKind::Left { of, position, way });
        }
    }

    /// Looks at the contacts of the evaluation just made.
    fn look_at_contacts(&mut self, core: &mut Core) {
        let mut alarms = core.contacts.take_alarms();
        alarms.take_from(&mut self.crossed);
        if alarms != Alarms::default() {
            for kind in Alarms::KINDS {
                if let Some(alarm) = alarms.worst(kind) {
                    self.note(core, FindingKind::Contact(kind, alarm));
                }
            }
        }
    }

    fn note(&mut self, core: &Core, what: FindingKind) {
        let (step, time) = (core.steps(), core.time());
        let event = Finding { step, time, what };
        if core.is_divided() {
            self.found.push(event);
        } else {
            self.count(core, event);
        }
    }

    /// Counts what was found.
    fn count(&mut self, core: &Core, event: Finding) {
        let what = event.what;
        let count = &mut self.counts[event.index()];
        count.steps += 1;
        if (count.worst).is_none_or(|worst| event.part() > worst.part()) {
            count.worst = Some(event);
        }
        // A particle that touches a wall from behind is where it should not be, but nothing is wrong with its motion.
        let stops = !matches!(what, FindingKind::Contact(AlarmKind::Behind, _));
        let is_strict = core.physics().guard.policy == GuardPolicy::Strict;
        if stops && is_strict && !self.off && self.stop.is_none() {
            self.stop = Some(event);
        }
    }

    /// Whether the run may go on.
    fn judge(&mut self, core: &Core) -> Result<(), RunError> {
        let Some(event) = self.stop.take() else {
            return Ok(());
        };
        Err(RunError::Guarded {
            step: event.step,
            time: event.time,
            what: reported(core, &event),
            help: help(core, &event),
        })
    }

    /// Counts of events beyond a limit since the start: a line for each kind.
    fn counted(&self, core: &Core) -> Vec<String> {
        let counts = self.counts.iter();
        counts
            .filter_map(|count| {
                let worst = count.worst?;
                let steps = match count.steps {
                    1 => "in 1 step".to_owned(),
                    steps => format!("in {steps} steps, the worst of them"),
                };
                let time = short(worst.time);
                Some(format!(
                    "guard: {steps} at step {} (t = {time} s): {}",
                    worst.step,
                    reported(core, &worst)
                ))
            })
            .collect()
    }
}

impl Engine {
    /// After an error: makes one more step whose contacts are seen, so that the state can be looked at.
    ///
    /// # Errors
    /// If a particle's motion is no longer a number.
    pub fn step_to_look_at(&mut self, watch: Watch) -> Result<(), RunError> {
        if let Some((guard, _)) = self.part_and_core::<GuardPart>() {
            guard.off = true;
        }
        if let Some((sprays, _)) = self.part_and_core::<Sprays>() {
            sprays.lift_limits();
        }
        self.step(Some(watch))?;
        self.complete_step()
    }

    /// Counts of events beyond a limit since the start: a line for each kind.
    #[must_use]
    pub fn guard_warnings(&self) -> Vec<String> {
        let guard = self.part::<GuardPart>();
        guard.map_or_else(Vec::new, |guard| guard.counted(self))
    }
}

fn reported(core: &Core, event: &Finding) -> String {
    let limits = core.physics().guard;
    let place = |x: DVec3| format!("({}, {}, {}) m", short(x.x), short(x.y), short(x.z));
    let (kind, alarm) = match event.what {
        FindingKind::Way {
            id,
            position,
            part,
            speed,
        } => {
            return format!(
                "particle {id} moves by {} of its radius in one step, to {}, at {} m/s (guard.way = {})",
                short(part),
                place(position),
                short(speed),
                short(limits.way)
            );
        }
        FindingKind::Left { of, position, way } => {
            return format!(
                "{} at {} has left the domain by {} m",
                subject(core, of),
                place(position),
                short(way)
            );
        }
        FindingKind::Contact(kind, alarm) => (kind, alarm),
    };
    let (other, radius) = match alarm.other {
        Other::Particle(id) => (format!("particle {id}"), "the smaller radius"),
        Other::Wall(index) => {
            let radius = match alarm.of {
                Subject::Particle(_) => "its radius",
                Subject::Vertex { .. } => "half the thickness",
            };
            (wall(core, index), radius)
        }
    };
    let id = subject(core, alarm.of);
    let (at, speed) = (place(alarm.position), short(alarm.speed.abs()));
    let way = if alarm.speed >= 0.0 {
        "approaching"
    } else {
        "leaving"
    };
    match kind {
        AlarmKind::Overlap => format!(
            "{id} at {at} overlaps {other} by {} of {radius}, {way} at {speed} m/s (guard.overlap = {})",
            short(alarm.part()),
            short(limits.overlap)
        ),
        AlarmKind::Through => format!(
            "{id} at {at} has gone through {other}: its centre is {} m behind it, {way} at {speed} m/s",
            short(alarm.overlap - alarm.radius)
        ),
        AlarmKind::Behind => format!(
            "{id} at {at} touches {other}, which acts on its other side, from behind; it is pushed back from there"
        ),
    }
}

/// A particle, or a vertex with the name of its sheet.
fn subject(core: &Core, of: Subject) -> String {
    match of {
        Subject::Particle(id) => format!("particle {id}"),
        Subject::Vertex { surface, vertex } => {
            let sheet = core.surfaces().get(usize::from(surface));
            let name = sheet.map_or(surface.to_string(), |sheet| sheet.plan().name.clone());
            format!("membranes.{name}: vertex {vertex}")
        }
    }
}

/// The name of a wall, or of the sheet whose shape it borrows.
fn wall(core: &Core, index: WallIndex) -> String {
    let number = index.index();
    let walls = &core.physics().walls;
    match walls.get(number) {
        Some(wall) => format!("wall `{}`", wall.name),
        None => match core.surfaces().get(number.wrapping_sub(walls.len())) {
            Some(sheet) => format!("membrane `{}`", sheet.plan().name),
            None => format!("wall `{index}`"),
        },
    }
}

/// The likely cause, and what to do.
fn help(core: &Core, event: &Finding) -> String {
    let dt = core.physics().time_step;
    let go_on = "guard.policy = \"warn\" goes on and counts";
    match event.what {
        FindingKind::Way { part, .. } => {
            let limit = core.physics().guard.way;
            format!(
                "the time step is too large for this speed (below {} s it is not), or the particle was thrown by a contact that was too deep; {go_on}",
                short(dt * limit / part)
            )
        }
        FindingKind::Left { .. } => format!(
            "hold the sheet (`fixed`, `holds`), let its vertices touch the walls (`walls = true`), or widen domain.min and domain.max; {go_on}"
        ),
        // In a few steps it came as far as it is.
        FindingKind::Contact(_, alarm) if 4.0 * alarm.speed * dt > alarm.overlap => format!(
            "it came so far in less than 4 steps: the time step is too large for this speed; {go_on}"
        ),
        FindingKind::Contact(..) => format!(
            "the contact is too soft for what presses on it (a larger stiffness or Young's modulus, with the smaller time step that it needs), or something was placed, or a wall has come, inside of it; {go_on}"
        ),
    }
}
