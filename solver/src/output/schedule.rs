//! When outputs are written: one schedule for all files of a run.

use crate::plan::{FieldPlan, OutputPlan};

/// Files that one state is written to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Due {
    /// A frame: particles, bodies, walls, and rows of all tables that have no interval of their own.
    pub frame: bool,
    /// Rows of loads on walls, regions, fluxes and energies.
    pub rows: bool,
    /// Rows of tracks.
    pub tracks: bool,
    /// The contacts.
    pub contacts: bool,
    /// The files for ParaView.
    pub vtk: bool,
    /// Tables of fields, a bit for each in the order of the plan.
    pub fields: u64,
    /// Those of them that need contacts.
    pub fields_of_contacts: u64,
}

impl Due {
    /// Whether anything is.
    #[must_use]
    pub fn any(self) -> bool {
        self != Self::default()
    }

    /// Files that are due here and not there.
    #[must_use]
    pub fn without(self, other: Self) -> Self {
        Self {
            frame: self.frame && !other.frame,
            rows: self.rows && !other.rows,
            tracks: self.tracks && !other.tracks,
            contacts: self.contacts && !other.contacts,
            vtk: self.vtk && !other.vtk,
            fields: self.fields & !other.fields,
            fields_of_contacts: self.fields_of_contacts & !other.fields,
        }
    }

    /// Files that are due in either of the two.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            frame: self.frame || other.frame,
            rows: self.rows || other.rows,
            tracks: self.tracks || other.tracks,
            contacts: self.contacts || other.contacts,
            vtk: self.vtk || other.vtk,
            fields: self.fields | other.fields,
            fields_of_contacts: self.fields_of_contacts | other.fields_of_contacts,
        }
    }

    /// Whether there is anything beside tracks, which need neither all particles nor an observation of contacts.
    #[must_use]
    pub fn beyond_tracks(self) -> bool {
        Self {
            tracks: false,
            ..self
        }
        .any()
    }

    /// Whether each contact has to be recorded for it.
    #[must_use]
    pub fn needs_records(self) -> bool {
        self.contacts || self.vtk || self.fields_of_contacts != 0
    }
}

/// When frames, rows, contacts, files for ParaView, fields and checkpoints are written. It follows from the plan and the present step
/// of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Schedule {
    frames: Every,
    rows: Every,
    tracks: Option<Every>,
    contacts: Option<Every>,
    vtk: Option<Every>,
    checkpoints: Option<Every>,
    links: Every,
    fields: Vec<Looks>,
    /// In s.
    time_step: f64,
}

/// When a table of fields looks.
#[derive(Debug, Clone, PartialEq)]
struct Looks {
    every: Every,
    plan: FieldPlan,
}

impl Schedule {
    /// As planned, of a run in steps of `time_step` (s) that has made `step` steps and written what was due by then.
    #[must_use]
    pub fn behind(output: &OutputPlan, time_step: f64, step: u64) -> Self {
        let every = |interval| Every::behind(interval, time_step, step);
        Self {
            frames: every(output.interval),
            rows: every(output.rows_interval),
            tracks: output.has_tracks().then(|| every(output.track_interval)),
            contacts: output.fstat.then(|| every(output.fstat_interval)),
            vtk: output.vtk.then(|| every(output.vtk_interval)),
            checkpoints: output.restart_interval.map(every),
            links: every(output.link_interval),
            fields: (output.fields.iter())
                .map(|fields| Looks {
                    every: every(fields.interval),
                    plan: fields.clone(),
                })
                .collect(),
            time_step,
        }
    }

    /// Everything, for the first and the last state.
    #[must_use]
    pub fn everything(&self) -> Due {
        Due {
            frame: true,
            rows: true,
            tracks: self.tracks.is_some(),
            contacts: self.contacts.is_some(),
            vtk: self.vtk.is_some(),
            fields: self.bits(|_| true),
            fields_of_contacts: self.bits(|looks| looks.plan.needs_contacts()),
        }
    }

    /// A bit for each table of fields that this holds for.
    fn bits(&self, is_so: impl Fn(&Looks) -> bool) -> u64 {
        let bits = self.fields.iter().map(is_so).enumerate();
        bits.fold(0, |bits, (k, is)| bits | u64::from(is) << k)
    }

    /// The next step at which anything is due; 0 if at every step.
    #[must_use]
    pub fn next_step(&self) -> u64 {
        let others = self.contacts.iter().chain(&self.vtk).chain(&self.tracks);
        let others = others.chain(self.fields.iter().map(|looks| &looks.every));
        let others = others.chain(&self.checkpoints).chain([&self.links]);
        let others = others.map(Every::next_step).min();
        let both = self.frames.next_step().min(self.rows.next_step());
        both.min(others.unwrap_or(u64::MAX))
    }

    /// Files that are due at the end of this step. Steps are passed in order, once each; those before [`Schedule::next_step`] may
    /// be left out.
    pub fn due(&mut self, step: u64) -> Due {
        let time = step as f64 * self.time_step;
        let fields = (self.fields.iter_mut().enumerate()).fold(0, |bits, (k, looks)| {
            let is_due = looks.every.is_due(step) && looks.plan.looks_at(time, self.time_step);
            bits | u64::from(is_due) << k
        });
        let of_contacts = self.bits(|looks| looks.plan.needs_contacts());
        let is_due = |every: &mut Option<Every>| every.as_mut().is_some_and(|e| e.is_due(step));
        Due {
            frame: self.frames.is_due(step),
            rows: self.rows.is_due(step),
            tracks: is_due(&mut self.tracks),
            contacts: is_due(&mut self.contacts),
            vtk: is_due(&mut self.vtk),
            fields,
            fields_of_contacts: fields & of_contacts,
        }
    }

    /// Whether a checkpoint is due at the end of this step; called like [`Schedule::due`].
    pub fn is_checkpoint_due(&mut self, step: u64) -> bool {
        self.checkpoints.as_mut().is_some_and(|e| e.is_due(step))
    }

    /// Whether a link of the chain is due at the end of this step; called like [`Schedule::due`].
    pub fn is_link_due(&mut self, step: u64) -> bool {
        self.links.is_due(step)
    }
}

/// The steps at which something is written every `interval`: the first step with t >= m `interval` for each whole m > 0, with
/// 1e-6 of a step of slack for round-off. The start and the end are the caller's business.
#[derive(Debug, Clone, PartialEq)]
struct Every {
    /// Steps between two events; not a whole number in general.
    stride: f64,
    /// The event to come, m.
    next: u64,
}

impl Every {
    /// Every `interval` (s) of a run in steps of `time_step` (s), behind this step.
    fn behind(interval: f64, time_step: f64, step: u64) -> Self {
        let stride = interval / time_step;
        let mut every = Self { stride, next: 1 };
        if stride > 1e-6 {
            every.next = every.next_behind(step);
        }
        every
    }

    /// Whether an event comes by the end of a step.
    fn is_passed(&self, event: u64, step: u64) -> bool {
        self.stride * event as f64 - 1e-6 <= step as f64
    }

    /// The first event after a step, and after the earlier events.
    fn next_behind(&self, step: u64) -> u64 {
        let mut next = self.next.max((step as f64 / self.stride) as u64);
        while self.is_passed(next, step) {
            next += 1;
        }
        next
    }

    /// The next step at which something is due; 0 if at every step.
    fn next_step(&self) -> u64 {
        if self.stride <= 1e-6 {
            return 0;
        }
        (self.stride * self.next as f64 - 1e-6).ceil() as u64
    }

    /// Whether something is due at the end of this step. Steps are passed in order, once each; those before [`Every::next_step`]
    /// may be left out.
    fn is_due(&mut self, step: u64) -> bool {
        if self.stride <= 1e-6 {
            return true;
        }
        let due = self.is_passed(self.next, step);
        if due {
            // Several events within one step are one.
            self.next = self.next_behind(step);
        }
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn due(interval: f64, time_step: f64, steps: u64) -> Vec<u64> {
        let mut schedule = Every::behind(interval, time_step, 0);
        let each = |step: &u64| {
            let announced = schedule.next_step().max(*step) == *step;
            let due = schedule.is_due(*step);
            assert_eq!(announced, due, "step {step}");
            due
        };
        (1..=steps).filter(each).collect()
    }

    #[test]
    fn the_first_step_at_or_after_each_multiple() {
        assert_eq!(
            due(0.3, 0.1, 9),
            [3, 6, 9],
            "0.3 is no multiple of 0.1 in binary"
        );
        assert_eq!(due(0.25, 0.1, 10), [3, 5, 8, 10]);
        assert_eq!(due(f64::INFINITY, 0.1, 10), [0u64; 0]);
    }

    #[test]
    fn contacts_are_recorded_for_looks_that_need_them_and_only_while_they_look() {
        let scene = r#"
            [time]
            end = 1.0
            step = 0.1
            [domain]
            min = [0, 0, 0]
            max = [1, 1, 1]
            [output]
            interval = 100.0
            [materials.m]
            density = 2000.0
            normal = { law = "linear", stiffness = 1.0, restitution = 0.7 }
            [[particles]]
            material = "m"
            radius = 0.1
            position = [0.5, 0.5, 0.5]
            [[fields]]
            name = "light"
            fields = ["density", "velocity_gradient", "displacement"]
            interval = 0.1
            [[fields]]
            name = "stressed"
            fields = ["stress"]
            interval = 0.2
            from = 0.6
            until = 0.8
        "#;
        let path = std::path::Path::new("a.toml");
        let unchecked = mercury_common::scene::Files::Unchecked;
        let scene = mercury_common::scene::parse_scene(path, scene, &[], unchecked).unwrap();
        let plan = crate::plan::plan(&scene).unwrap();
        let step = plan.physics().time_step;
        let mut schedule = Schedule::behind(plan.outputs().files(), step, 0);
        let dues = (1..=10).map(|step| schedule.due(step));
        let found: Vec<_> = dues.map(|due| (due.fields, due.needs_records())).collect();
        // 0.6 = 6 x 0.1 up to round-off.
        let expected = |step| match step {
            6 | 8 => (0b11, true),
            _ => (0b01, false),
        };
        assert_eq!(found, (1..=10).map(expected).collect::<Vec<_>>());
        assert!(schedule.everything().needs_records());
    }

    #[test]
    fn an_interval_below_the_step_is_every_step() {
        assert_eq!(due(0.04, 0.1, 5), [1, 2, 3, 4, 5]);
        assert_eq!(due(1e-300, 0.1, 3), [1, 2, 3]);
    }

    #[test]
    fn it_follows_from_the_step_alone() {
        for (interval, time_step) in [(0.3, 0.1), (0.25, 0.1), (0.1, 0.1), (0.04, 0.1), (7.7, 0.1)]
        {
            let mut straight = Every::behind(interval, time_step, 0);
            for step in 1..200 {
                straight.is_due(step);
                assert_eq!(straight, Every::behind(interval, time_step, step), "{step}");
            }
        }
        assert_eq!(
            Every::behind(f64::INFINITY, 0.1, 9).next_step(),
            u64::MAX,
            "never"
        );
    }

    #[test]
    fn round_off_never_delays_an_event() {
        // 10^6 steps of 1e-5 s and frames every 0.01 s: 1000 steps each, although 0.01 / 1e-5 is not exact.
        let steps = due(0.01, 1e-5, 1_000_000);
        assert_eq!(steps.len(), 1000);
        assert!(steps.iter().zip(1..).all(|(&step, m)| step == 1000 * m));
    }
}
