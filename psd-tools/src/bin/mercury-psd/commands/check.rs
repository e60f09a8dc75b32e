//! `mercury-psd check`

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use mercury_common::cli::{Exit, Failure, Outcome, say};
use mercury_common::sizes::SizeDistribution;
use mercury_psd::charts;
use mercury_psd::check::run::{Run, Selection};
use mercury_psd::check::{Criterion, Finding, Goodness, TwoSamples, Verdict};
use mercury_psd::input::{self, Sizes};
use mercury_psd::report;
use mercury_psd::sample::Sample;
use serde_json::{Value, json};

use super::{draw, say_json};
use crate::arguments::{CheckArguments, Conditions};

/// Particles of one kind, ready to test.
struct Subject {
    name: String,
    sample: Sample,
    /// kg
    mass: Option<f64>,
    /// Whether it is a list with a comment of it.
    by_quota: bool,
    /// Notes of its reading.
    notes: Vec<String>,
}

pub(crate) fn run(arguments: &CheckArguments) -> Outcome {
    let first = Selection {
        at: arguments.at,
        place: arguments.place.clone().map_or_else(Vec::new, |c| c.all),
    };
    let is_two_sample = arguments.versus.is_some()
        || arguments.versus_at.is_some()
        || arguments.versus_where.is_some();
    if is_two_sample && arguments.target.is_some() {
        let message = "--target and --versus: a sample is tested against a distribution or against another sample";
        return Err(Failure::input(message));
    }
    let subjects = subjects(&arguments.subject, &first, arguments)?;
    if is_two_sample {
        return versus(arguments, subjects);
    }
    let mut outcome = Reports::default();
    let (pairs, of_target) = with_targets(arguments, subjects)?;
    let name = arguments.target.as_deref().unwrap_or_default();
    outcome.note(name, &of_target);
    for (subject, target) in pairs {
        outcome.note(&subject.name, &subject.notes);
        let goodness = Goodness::of(
            &subject.sample,
            &target.sizes,
            arguments.level,
            arguments.seed,
        );
        let criterion = match arguments.tolerance {
            Some(tolerance) => Criterion::Tolerance(tolerance),
            None => Criterion::Level(arguments.level),
        };
        let verdict = Verdict::of(&goodness, &subject.sample, &target.sizes, criterion);
        let check = report::Check {
            name: &subject.name,
            sample: &subject.sample,
            target: &target.sizes,
            goodness: &goodness,
            verdict: &verdict,
            level: arguments.level,
            masses: subject.mass.zip(target.mass).map(<[f64; 2]>::from),
            quotas: target.quotas,
        };
        outcome.passed &= verdict.passed();
        outcome.text += &check.text();
        outcome.values.insert(subject.name.clone(), check.json());
        if let Some(stem) = &arguments.output {
            let look = arguments.looking.look();
            let page = charts::checked(
                &subject.name,
                (&subject.sample, check.is_whole_quota()),
                &target.sizes,
                &goodness,
                arguments.level,
                look,
            );
            outcome.pages.push((subject.name.clone(), page));
            outcome.stem = Some(stem.clone());
        }
    }
    outcome.finish(arguments.common.json)
}

/// Combined reports on all kinds of particles.
struct Reports {
    passed: bool,
    text: String,
    values: serde_json::Map<String, Value>,
    /// Notes of the reading of files.
    notes: Vec<String>,
    pages: Vec<(String, mercury_pictures::charts::ChartPage)>,
    stem: Option<PathBuf>,
}

impl Default for Reports {
    fn default() -> Self {
        Self {
            passed: true,
            text: String::new(),
            values: serde_json::Map::new(),
            notes: Vec::new(),
            pages: Vec::new(),
            stem: None,
        }
    }
}

impl Reports {
    /// Adds the notes of the reading of one sample.
    fn note(&mut self, name: &str, notes: &[String]) {
        for note in notes {
            self.text += &format!("{name}: note: {note}\n");
            self.notes.push(format!("{name}: {note}"));
        }
    }

    fn finish(mut self, as_json: bool) -> Outcome {
        if let Some(stem) = &self.stem {
            for (name, page) in &self.pages {
                let mut path = stem.clone().into_os_string();
                if self.pages.len() > 1 {
                    path.push(format!(".{}", name.replace(['/', ' '], "-")));
                }
                self.text += &draw(page, Path::new(&path))?;
            }
        }
        if as_json {
            say_json(&json!({ "passed": self.passed, "notes": self.notes, "kinds": self.values }))?;
        } else {
            say(&self.text)?;
        }
        if self.passed {
            Ok(())
        } else {
            // The report gives the reason.
            Err(Failure::new(Exit::Failed, ""))
        }
    }
}

fn subjects(
    path: &Path,
    selection: &Selection,
    arguments: &CheckArguments,
) -> Result<Vec<Subject>, Failure> {
    let mut subjects = Vec::new();
    if path.is_dir() {
        let run = Run::open(path).map_err(Failure::input)?;
        for (name, group) in run.sizes(selection).map_err(Failure::input)? {
            let sample = Sample::new(group.diameters);
            let sample = sample
                .map_err(|error| Failure::input(format!("{}: {name}: {error}", path.display())))?;
            let mass = Some(group.mass);
            subjects.push(Subject {
                name,
                sample,
                mass,
                by_quota: false,
                notes: Vec::new(),
            });
        }
    } else {
        if *selection != Selection::default() {
            let message = format!(
                "{}: times and places are those of a run folder",
                path.display()
            );
            return Err(Failure::input(message));
        }
        for source in
            input::read(&path.to_string_lossy(), &arguments.of_lists()).map_err(Failure::input)?
        {
            let Sizes::Sample(sample) = source.sizes else {
                let message = format!("{}: a distribution, no list of sizes", path.display());
                return Err(Failure::input(message)
                    .with_help("mercury-psd compare sets distributions side by side"));
            };
            subjects.push(Subject {
                name: source.name,
                sample,
                mass: None,
                by_quota: source.by_quota,
                notes: source.notes,
            });
        }
    }
    if let Some(of) = &arguments.of {
        let names: Vec<String> = subjects
            .iter()
            .map(|subject| subject.name.clone())
            .collect();
        subjects.retain(|subject| subject.name == *of);
        if subjects.is_empty() {
            let message = format!("{}: no particles of \"{of}\"", path.display());
            return Err(
                Failure::input(message).with_help(format!("there are: {}", names.join(", ")))
            );
        }
    }
    if subjects.is_empty() {
        return Err(Failure::input(format!(
            "{}: no inserted particles there",
            path.display()
        )));
    }
    Ok(subjects)
}

/// Target of a kind of particles.
struct Wanted {
    sizes: SizeDistribution,
    mass: Option<f64>,
    quotas: usize,
}

type Pair = (Subject, Wanted);

/// Samples with their targets, and the notes of the reading of the targets.
fn with_targets(
    arguments: &CheckArguments,
    subjects: Vec<Subject>,
) -> Result<(Vec<Pair>, Vec<String>), Failure> {
    let path = &arguments.subject;
    if let Some(target) = &arguments.target {
        let names: Vec<&str> = subjects
            .iter()
            .map(|subject| subject.name.as_str())
            .collect();
        if subjects.len() > 1 {
            let message = format!(
                "{}: several kinds of particles for one target: {}",
                path.display(),
                names.join(", ")
            );
            return Err(Failure::input(message).with_help("choose one with --of"));
        }
        let source = super::source(target, &arguments.of_target())?;
        let Sizes::Distribution(sizes, _) = source.sizes else {
            let message = format!("{target}: a list of sizes, no distribution");
            return Err(Failure::input(message).with_help("--versus tests against another sample"));
        };
        let wanted = |subject: Subject| {
            let wanted = Wanted {
                sizes: sizes.clone(),
                mass: None,
                quotas: usize::from(subject.by_quota),
            };
            (subject, wanted)
        };
        let pairs = subjects.into_iter().map(wanted).collect();
        return Ok((pairs, source.notes));
    }
    if !path.is_dir() {
        let message = format!(
            "{}: a list of sizes does not say what it should be",
            path.display()
        );
        return Err(Failure::input(message).with_help("give --target FILE"));
    }
    let run = Run::open(path).map_err(Failure::input)?;
    let of_plan = run.targets().map_err(Failure::input)?;
    let mut targets: BTreeMap<String, Wanted> = of_plan
        .into_iter()
        .map(|(name, target)| {
            let wanted = Wanted {
                sizes: target.sizes,
                // Of a part, or at one time, the whole mass is not to be expected.
                mass: target
                    .mass
                    .filter(|_| arguments.at.is_none() && arguments.place.is_none()),
                quotas: target.quotas,
            };
            (name, wanted)
        })
        .collect();
    let mut pairs = Vec::new();
    for subject in subjects {
        let Some(wanted) = targets.remove(&subject.name) else {
            let message = format!(
                "{}: the scene has no single distribution for \"{}\": no insertion brings it, or several with different ones",
                path.display(),
                subject.name
            );
            return Err(Failure::input(message).with_help("give --of and --target"));
        };
        pairs.push((subject, wanted));
    }
    if arguments.of.is_none() && !targets.is_empty() {
        let names: Vec<String> = targets.into_keys().collect();
        let message = format!(
            "{}: nothing was inserted of {}",
            path.display(),
            names.join(", ")
        );
        return Err(Failure::run(message).with_help("the kinds that are there: --of"));
    }
    Ok((pairs, Vec::new()))
}

/// Name of one of two samples in a chart.
fn called(path: &Path, at: Option<f64>, place: &Option<Conditions>) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    let mut name = name.to_string_lossy().into_owned();
    if let Some(at) = at {
        name += &format!(" at {at} s");
    }
    if let Some(Conditions { text, .. }) = place {
        name += &format!(", {text}");
    }
    name
}

fn versus(arguments: &CheckArguments, subjects: Vec<Subject>) -> Outcome {
    let path = arguments.versus.as_ref().unwrap_or(&arguments.subject);
    let other_place = match (&arguments.versus_where, &arguments.versus) {
        (None, None) => &arguments.place,
        (own, _) => own,
    };
    let selection = Selection {
        at: match (arguments.versus_at, &arguments.versus) {
            (Some(at), _) => Some(at),
            (None, None) => arguments.at,
            (None, Some(_)) => None,
        },
        place: other_place.clone().map_or_else(Vec::new, |c| c.all),
    };
    let mut others = self::subjects(path, &selection, arguments)?;
    let names = [
        called(&arguments.subject, arguments.at, &arguments.place),
        called(path, selection.at, other_place),
    ];
    let mut outcome = Reports::default();
    let lists = subjects.len() == 1 && others.len() == 1;
    for subject in subjects {
        // Kinds with kinds; two lists have no kinds.
        let found = others
            .iter()
            .position(|other| lists || other.name == subject.name);
        let Some(found) = found else {
            let message = format!(
                "{}: no particles of \"{}\" to compare with",
                path.display(),
                subject.name
            );
            return Err(Failure::input(message).with_help("choose a kind with --of"));
        };
        let other = others.swap_remove(found);
        outcome.note(&subject.name, &subject.notes);
        outcome.note(&other.name, &other.notes);
        let result = TwoSamples::of(&subject.sample, &other.sample, arguments.level);
        outcome.passed &= result.finding(arguments.level) == Finding::Passed;
        outcome.text += &report::two_samples_text(&subject.name, &result, arguments.level);
        outcome.values.insert(
            subject.name.clone(),
            report::two_samples_json(&result, arguments.level),
        );
        if let Some(stem) = &arguments.output {
            let page = charts::two_samples(
                &subject.name,
                [&names[0], &names[1]],
                [&subject.sample, &other.sample],
                &result,
                arguments.looking.look(),
            );
            outcome.pages.push((subject.name.clone(), page));
            outcome.stem = Some(stem.clone());
        }
    }
    for other in others {
        let note = format!("only in {}, compared with nothing", names[1]);
        outcome.note(&other.name, &[note]);
    }
    outcome.finish(arguments.common.json)
}
