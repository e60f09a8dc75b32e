//! Runs that end when results are known.

use std::f64::consts::TAU;
use std::path::Path;

use mercury_common::formats::delimited::push_line;
use mercury_common::formats::table_head;
use mercury_common::readable::{rounded, significant};
use mercury_common::run_tables::RESULTS;
use mercury_common::scene::{Scene, SceneError, SceneErrors, Until, nearest};
use mercury_common::statistics::{FIRST_LOOK, Look, Looks};
use mercury_common::units::{Dimension, Quantity};
use mercury_engine::task::ResultLook;
use mercury_engine::walls::Component;

use super::{NamedResult, PlannedRows};
use crate::output::summary::UntilSummary;
use crate::plan::{Plan, Settled};

/// Periods of a wall that turns or swings for which a run goes on at least.
const PERIODS: f64 = 3.0;

/// Falls through the domain, likewise.
const FALLS: f64 = 20.0;

/// The error at which a result is known: one standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Wanted {
    /// Of the magnitude of the value.
    Share(f64),
    /// In the unit of the result.
    Number(f64),
}

impl Wanted {
    /// Reads `2 %`, or a number in the unit of the result.
    ///
    /// # Errors
    /// The text is neither, or not above 0.
    pub(crate) fn parse(text: &str, unit: &str) -> Result<Self, String> {
        let expected = match unit {
            "1" => "expected a share of the value, \"2 %\", or a number, \"0.01\"".to_owned(),
            unit => format!(
                "expected a share of the value, \"2 %\", or a number with its unit, \"0.1 {unit}\""
            ),
        };
        let positive = |value: f64| match value > 0.0 && value.is_finite() {
            true => Ok(value),
            false => Err("must be above 0".to_owned()),
        };
        let text = text.trim();
        if let Some(share) = text.strip_suffix('%') {
            let share = share.trim().parse::<f64>().map_err(|_| expected)?;
            return positive(0.01 * share).map(Self::Share);
        }
        if let ("1", Ok(number)) = (unit, text.parse::<f64>()) {
            return positive(number).map(Self::Number);
        }
        let dimension = Dimension::of_unit(unit).unwrap_or(Dimension::NUMBER);
        let quantity = Quantity::parse(text).map_err(|problem| format!("{problem}: {expected}"))?;
        let value = quantity.value(dimension);
        let value = value
            .map_err(|found| format!("is {found}, and the result is in {unit}: {expected}"))?;
        positive(value).map(Self::Number)
    }

    /// In the unit of the result, at a value.
    pub(crate) fn at(self, value: f64) -> f64 {
        match self {
            Self::Share(share) => share * value.abs(),
            Self::Number(number) => number,
        }
    }
}

/// A result and the error at which it is known.
#[derive(Debug, Clone, PartialEq)]
struct Aim {
    result: NamedResult,
    wanted: Wanted,
    /// As it was written.
    text: String,
}

/// The results that end a run, and the looks at them.
///
/// Looks follow from the rows alone: never from the clock or from threads. A run that goes on makes them again from its files.
#[derive(Debug, Clone, PartialEq)]
pub struct Aims {
    aims: Vec<Aim>,
    settled: Settled,
    /// Time from which rows count, s.
    from: f64,
    /// Shortest time behind `from`, s, and its reason.
    at_least: (f64, String),
    rows: u64,
    looks: Looks,
    /// Time of the row at which the results were found to be known, s.
    known_at: Option<f64>,
    /// Findings of all looks, in their order.
    found: Vec<ResultLook>,
}

/// What a look found of a result.
#[derive(Debug, Clone, PartialEq)]
struct Seen {
    value: f64,
    look: Look,
    interval: [f64; 2],
    /// Times of the first and the last row that count, s.
    window: [f64; 2],
}

impl Seen {
    /// How much longer the run goes on until the error is the wanted one, s: its square falls as 1/T.
    fn more(&self, wanted: f64) -> f64 {
        let [from, to] = self.window;
        let factor = self.look.counted_error() / wanted;
        (to - from) * (factor * factor - 1.0).max(0.1)
    }
}

/// The results of a scene's `[results]`, and those that end its run.
///
/// # Errors
/// If a result is not valid or not of the run, or its run cannot end by it.
pub fn requested(
    scene: &Scene,
    plan: &Plan,
) -> Result<(Vec<NamedResult>, Option<Aims>), SceneErrors> {
    let mut errors = Vec::new();
    let mut results = Vec::new();
    for request in &scene.results {
        let read = NamedResult::new(&request.name, &request.text);
        match read.and_then(|result| result.check(plan).map(|()| result)) {
            Ok(result) => results.push(result),
            Err(problem) => errors.push(with_help(request.text.error(""), &problem)),
        }
    }
    let aims = Aims::of(&scene.time.until, &results, scene, plan, &mut errors);
    match errors.is_empty() {
        true => Ok((results, aims)),
        false => Err(SceneErrors(errors)),
    }
}

/// An error of the scene with the message and the help of a text.
fn with_help(error: SceneError, problem: &str) -> SceneError {
    let (message, help) = problem.split_once("\nhelp: ").unwrap_or((problem, ""));
    let error = SceneError {
        message: message.to_owned(),
        ..error
    };
    match help {
        "" => error,
        help => error.with_help(help),
    }
}

impl Aims {
    /// Those of `time.until`; `None` if there are none, or there are errors.
    fn of(
        until: &[Until],
        results: &[NamedResult],
        scene: &Scene,
        plan: &Plan,
        errors: &mut Vec<SceneError>,
    ) -> Option<Self> {
        let mut aims: Vec<Aim> = Vec::new();
        for entry in until {
            let name = entry.result.as_str();
            let Some(result) = results.iter().find(|result| result.name == name) else {
                if scene
                    .results
                    .iter()
                    .any(|request| request.name.value == name)
                {
                    // It is wrong itself, and was reported.
                    continue;
                }
                let names = scene.results.iter().map(|request| request.name.as_str());
                let error = entry.result.error(format!("there is no result `{name}`"));
                errors.push(match nearest(name, names) {
                    Some(near) => error.with_help(format!("did you mean `{near}`?")),
                    None => error.with_help(format!(
                        "[results] defines them: {name} = \"mean(walls.NAME.fz, steady..)\""
                    )),
                });
                continue;
            };
            if aims.iter().any(|aim| aim.result.name == name) {
                errors.push(entry.result.error(format!("`{name}` is there twice")));
                continue;
            }
            if let Err(why) = result.has_error() {
                let error = entry
                    .result
                    .error(format!("`{name}` has no error from one run: {why}"));
                errors.push(error.with_help("a study with several seeds gives one"));
                continue;
            }
            if let Some((problem, help)) = PlannedRows::of(result, plan).and_then(|r| r.too_few()) {
                let request = scene.results.iter().find(|r| r.name.value == name);
                let place = request.map_or(&entry.result.place, |r| &r.text.place);
                errors.push(place.error(problem).with_help(help));
                continue;
            }
            match Wanted::parse(&entry.error, &result.unit()) {
                Ok(wanted) => aims.push(Aim {
                    result: result.clone(),
                    wanted,
                    text: entry.error.value.clone(),
                }),
                Err(problem) => errors.push(entry.error.error(problem)),
            }
        }
        if aims.is_empty() {
            return None;
        }
        let settled = plan.settled();
        let starts = aims.iter().map(|aim| aim.result.begin(settled.time));
        let from = starts.fold(f64::NEG_INFINITY, f64::max).max(0.0);
        let by_plan = at_least(plan, from);
        let given = until.iter().filter_map(|entry| entry.at_least.as_ref());
        let given = given.max_by(|a, b| a.total_cmp(b));
        let at_least = match given {
            Some(time) => (time.value, "as given by at_least".to_owned()),
            None => by_plan,
        };
        let end = *scene.time.end;
        if from + at_least.0 > end {
            let place = given.map_or(&until[0].place, |time| &time.place);
            let (needed, why) = (rounded(from + at_least.0, 6), &at_least.1);
            let error = place.error(format!(
                "{needed} s are needed ({why}, behind {} s, {}), and time.end is {end} s",
                rounded(from, 6),
                settled.event
            ));
            errors.push(error.with_help("let time.end be longer, or give at_least in seconds"));
            return None;
        }
        Some(Self {
            aims,
            settled,
            from,
            at_least,
            rows: 0,
            looks: Looks::from_row(FIRST_LOOK),
            known_at: None,
            found: Vec::new(),
        })
    }

    /// Lines for the report of a plan.
    #[must_use]
    pub fn lines(&self) -> Vec<[String; 2]> {
        let mut lines = Vec::new();
        for aim in &self.aims {
            let name = &aim.result.name;
            lines.push([
                "known to".to_owned(),
                format!(
                    "{name} to {} (one standard error); then the run ends",
                    aim.text
                ),
            ]);
        }
        lines.push([
            "not before".to_owned(),
            format!(
                "{} s: {} behind {} s, {}",
                rounded(self.from + self.at_least.0, 6),
                self.at_least.1,
                rounded(self.from, 6),
                self.settled.event
            ),
        ]);
        lines
    }

    /// Whether the results are known: the run ends with the next step.
    #[must_use]
    pub(crate) fn is_known(&self) -> bool {
        self.known_at.is_some()
    }

    /// Whether a run that has come to a time (s) in steps of `dt` (s) has made that step.
    #[must_use]
    pub(crate) fn have_ended(&self, time: f64, dt: f64) -> bool {
        self.known_at.is_some_and(|known| time > known + 0.5 * dt)
    }

    /// Counts a row at a time (s); returns whether the results are to be looked at now.
    #[must_use]
    pub(crate) fn count_row(&mut self, time: f64) -> bool {
        if time + slack(time) < self.from {
            return false;
        }
        self.rows += 1;
        let begins = self.from + self.at_least.0;
        time + slack(time) >= begins && self.looks.is_due(self.rows) && !self.is_known()
    }

    /// Looks at the files of a run up to a time (s); returns what it finds of the results that have an error.
    pub(crate) fn look(&mut self, folder: &Path, prefix: &str, time: f64) -> &[ResultLook] {
        let settled = self.settled.time;
        let before = self.found.len();
        let mut all_hold = true;
        for aim in &self.aims {
            let Some(seen) = aim.seen(folder, prefix, settled, time) else {
                all_hold = false;
                continue;
            };
            let wanted = aim.wanted.at(seen.value);
            let holds = seen.look.is_known_to(wanted);
            all_hold &= holds;
            self.found.push(ResultLook {
                name: aim.result.name.clone(),
                unit: aim.result.unit(),
                time,
                value: seen.value,
                error: seen.look.error,
                interval: seen.interval,
                wanted,
                batches: seen.look.independent,
                window: seen.window,
                is_steady: seen.look.is_steady,
                more: if holds { 0.0 } else { seen.more(wanted) },
            });
        }
        if self.looks.note(self.rows, all_hold) {
            self.known_at = Some(time);
        }
        &self.found[before..]
    }

    /// Content of [`RESULTS`]: a row for each result at each look.
    #[must_use]
    pub(crate) fn table(&self) -> Vec<u8> {
        let columns = RESULTS.columns.iter();
        let mut text =
            table_head::line(columns.map(|column| (column.name, column.unit))).into_bytes();
        for found in &self.found {
            let numbers =
                |numbers: &[f64]| numbers.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>();
            let [low, high] = found.interval;
            let [from, to] = found.window;
            let mut row = numbers(&[found.time]);
            row.extend([found.name.clone(), found.unit.clone()]);
            row.extend(numbers(&[
                found.value,
                found.error,
                low,
                high,
                found.wanted,
                found.batches,
                from,
                to,
            ]));
            row.push(u8::from(found.is_steady).to_string());
            row.extend(numbers(&[found.more]));
            push_line(&mut text, &row);
        }
        text
    }

    /// Makes the looks of a run again that wrote rows at these times (s), from its files.
    pub(crate) fn replay(&mut self, folder: &Path, prefix: &str, times: impl Iterator<Item = f64>) {
        for time in times {
            if self.count_row(time) {
                let _ = self.look(folder, prefix, time);
            }
        }
    }

    /// How well the results are known at the end of a run, with a warning for each that is not known well enough.
    pub(crate) fn summary(&self, folder: &Path, prefix: &str) -> (Vec<UntilSummary>, Vec<String>) {
        let (mut summaries, mut warnings) = (Vec::new(), Vec::new());
        for aim in &self.aims {
            let name = &aim.result.name;
            let seen = aim.seen(folder, prefix, self.settled.time, f64::INFINITY);
            let wanted = seen.as_ref().map(|seen| aim.wanted.at(seen.value));
            let reached = self.is_known();
            let more = match (&seen, wanted) {
                (Some(seen), Some(wanted)) if !reached && wanted > 0.0 => Some(seen.more(wanted)),
                _ => None,
            };
            if !reached {
                warnings.push(aim.missed(name, seen.as_ref(), more));
            }
            summaries.push(UntilSummary {
                result: name.clone(),
                wanted,
                reached,
                more,
            });
        }
        (summaries, warnings)
    }
}

/// Round-off of a time (s) that is a multiple of the step, or was read from a file with ten digits.
pub(super) fn slack(time: f64) -> f64 {
    1e-9 * time.abs()
}

impl Aim {
    /// The result in the files of a run up to a time (s); `None` where it has no error yet.
    fn seen(&self, folder: &Path, prefix: &str, settled: f64, until: f64) -> Option<Seen> {
        let measured = self
            .result
            .measured(folder, prefix, Ok(settled), until)
            .ok()?;
        let known = &measured.estimate;
        let (error, [low, high]) = (known.error?, known.interval?);
        let window = known.window?;
        let look = Look {
            error,
            half_width: 0.5 * (high - low),
            independent: known.batches?,
            difference: measured.difference,
            is_steady: known.steady?,
        };
        Some(Seen {
            value: measured.value,
            look,
            interval: [low, high],
            window,
        })
    }

    /// The warning that a run ended before the result was known.
    fn missed(&self, name: &str, seen: Option<&Seen>, more: Option<f64>) -> String {
        let wanted = &self.text;
        let Some(seen) = seen else {
            return format!(
                "time.until: `{name}` has no error yet, {wanted} are wanted: let time.end be longer"
            );
        };
        let unit = match self.result.unit().as_str() {
            "1" => String::new(),
            unit => format!(" {unit}"),
        };
        let counted = seen.look.counted_error();
        let known = match self.wanted {
            Wanted::Share(_) if seen.value.abs() < 2.0 * seen.look.error => {
                let (value, error) = (significant(seen.value, 2), significant(seen.look.error, 2));
                return format!(
                    "time.until.error: {wanted} of `{name}`, which is {value} ± {error}{unit} and may be zero: give an absolute error, such as error = \"{error}{unit}\""
                );
            }
            Wanted::Share(_) => format!("{} %", significant(100.0 * counted / seen.value.abs(), 2)),
            Wanted::Number(_) => format!("{}{unit}", significant(counted, 2)),
        };
        let more = more.map_or_else(String::new, |more| {
            format!(
                ": some {} s more (--resume --set time.end=...)",
                significant(more, 2)
            )
        });
        format!("time.until: `{name}` is known to {known}, {wanted} are wanted{more}")
    }
}

/// The shortest time behind `from` (s) that a plan needs, and why: three periods of each wall that turns or swings then, 20 falls through the domain.
fn at_least(plan: &Plan, from: f64) -> (f64, String) {
    let physics = plan.physics();
    let mut longest = (0.0, "64 rows".to_owned());
    let gravity = physics.gravity.length();
    if gravity > 0.0 {
        let height = (physics.cell.size() * physics.gravity / gravity)
            .abs()
            .element_sum();
        longest = (
            FALLS * (2.0 * height / gravity).sqrt(),
            format!("{FALLS} falls through the domain"),
        );
    }
    for wall in &physics.walls {
        for component in wall.motion.components() {
            let (period, until, what) = match component {
                Component::Rotation {
                    angular_velocity,
                    until,
                    ..
                } => (TAU / angular_velocity.abs(), *until, "turns"),
                Component::Oscillation {
                    frequency, until, ..
                } => (1.0 / frequency.abs(), *until, "swings"),
                _ => continue,
            };
            let time = PERIODS * period;
            if until > from && time.is_finite() && time > longest.0 {
                longest = (time, format!("{PERIODS} {what} of wall `{}`", wall.name));
            }
        }
    }
    longest
}
