//! Work of the program, once its options are read.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::mpsc::sync_channel;

use mercury_cg::CgError;
use mercury_cg::analysis::{Analysis, TimeMode};
use mercury_cg::input::{FrameChoice, Given, Source, States};
use mercury_cg::options::{Scan, Width};
use mercury_cg::output::{Format, Succession};
use mercury_cg::scan;
use mercury_cg::setup::{mean_diameter, refuse_many_images};
use mercury_cg::state::{Contacts, State};
use mercury_common::cli::Progress;
use mercury_common::statistics::FEWEST_BATCHES;
use mercury_common::{machine, readable};

use super::Arguments;
use super::files::{self, Output};

/// Reads, computes and writes; returns the messages.
pub(crate) fn compute(arguments: &Arguments) -> Result<String, CgError> {
    if let Some(threads) = arguments.threads {
        // Only fails where threads run already, and none do.
        let _ = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build_global();
    }
    let input = arguments.input.clone().unwrap_or_default();
    let (wanted, given) = (arguments.wanted(), arguments.given());
    let (mut source, fields) = wanted.open(&input, &given)?;
    let follow = arguments.follow;
    let end = end_of_run(&input);
    match &mut source {
        Source::Run(_) if given != Given::default() => {
            let found = "--density, --fixed and --fstat: the frames of a run say it themselves";
            return Err(CgError::Input(found.to_owned()));
        }
        Source::Run(_) => {}
        _ if follow => {
            let found = "--follow: only the Arrow frames of a run can be followed";
            return Err(CgError::Input(found.to_owned()));
        }
        _ => {}
    }
    for note in source.notes().iter().filter(|_| !arguments.quiet) {
        let _ = writeln!(std::io::stderr(), "note: {note}");
    }
    // Times of frames before the first that is requested.
    let passed = Mutex::new(None::<(f64, f64)>);
    let first = match &mut source {
        // Waits for it.
        Source::Run(run) if follow => {
            let states = Box::new(run.follow(arguments.frames, end.clone()));
            arguments.between(states).next()
        }
        source => {
            let states = source.states(arguments.frames).inspect(|state| {
                if let (Ok(state), Ok(mut passed)) = (state, passed.lock()) {
                    let (first, _) = passed.unwrap_or((state.time, state.time));
                    *passed = Some((first, state.time));
                }
            });
            arguments.between(Box::new(states)).next()
        }
    };
    let first = first.unwrap_or_else(|| {
        let mut found = nothing(&source);
        if let (0, Ok(Some((from, to)))) = (source.skipped().0, passed.into_inner()) {
            found += &format!("\nhelp: its frames are from t = {from} to {to} s (--from, --to)");
        }
        Err(CgError::Input(found))
    })?;
    let mut analysis = wanted.analysis(source.materials(), &first, fields)?;
    analysis.running = follow;
    let expected = match &source {
        Source::Run(run) if !follow => run.len(),
        _ => 1 << 10,
    };
    refuse_beyond_memory(&analysis, &first, expected)?;
    if wanted.fields.is_empty() && !source.has_contacts() && !arguments.quiet {
        let note = "there are no contacts beside the particles; fields of contacts are left out";
        let _ = writeln!(std::io::stderr(), "note: {note}");
    }
    let outputs = outputs(arguments, &source);
    if let Some(scan) = arguments.scan {
        return scan_widths(arguments, &source, &analysis, &first, scan, &outputs);
    }
    let succession = succession(arguments, &analysis);
    let mut writers = outputs
        .iter()
        .map(|path| Output::new(path, succession, follow, wanted.compat, arguments.force))
        .collect::<Result<Vec<_>, _>>()?;
    let (states, count): (States, Option<usize>) = match &mut source {
        Source::Run(run) if follow => (Box::new(run.follow(arguments.frames, end)), None),
        Source::Run(run) if arguments.frames == FrameChoice::All => {
            (run.states(FrameChoice::All), Some(run.len()))
        }
        source => (source.states(arguments.frames), None),
    };
    let states = arguments.between(states);
    let mut flowing = 0;
    let (frames, damage) = std::thread::scope(|scope| {
        // The next frame is read while the last one is computed.
        let (sender, receiver) = sync_channel(1);
        scope.spawn(move || {
            for state in states {
                // The receiver is gone after an error of its own.
                if sender.send(state).is_err() {
                    break;
                }
            }
        });
        let mut progress = Progress::new(arguments.quiet);
        let mut number = 0;
        let states = receiver
            .into_iter()
            .inspect(|state: &Result<State, CgError>| {
                if let Ok(state) = state {
                    flowing += state
                        .particles
                        .flowing
                        .iter()
                        .filter(|&&flows| flows)
                        .count();
                    number += 1;
                    progress.count("frame", number, count);
                }
            });
        analysis.run(states, |block| {
            writers
                .iter_mut()
                .try_for_each(|writer| writer.write(&analysis, &block))
        })
    })?;
    if frames == 0 {
        return Err(damage.unwrap_or_else(|| CgError::Input(nothing(&source))));
    }
    let mut report = String::new();
    for writer in writers {
        let (path, blocks) = writer.finish()?;
        let [blocks, frames, fields, points] = [
            counted(blocks, "time"),
            counted(frames, "frame"),
            counted(analysis.fields.len(), "field"),
            counted(analysis.evaluator.place.len(), "point"),
        ];
        report += &format!(
            "{blocks} from {frames}, {fields} at {points}: {}\n",
            path.display()
        );
    }
    warn(&source, flowing == 0, damage, frames);
    let mut fields = analysis.fields.iter();
    if frames == 1 && fields.any(|field| field.needs_displacement()) {
        let text = "displacements are zero: there is no frame before the only one";
        let _ = writeln!(std::io::stderr(), "warning: {text}");
    }
    if analysis.time == TimeMode::Average && analysis.errors && frames < FEWEST_BATCHES {
        let frames = counted(frames, "frame");
        let _ = writeln!(
            std::io::stderr(),
            "warning: no standard errors of the mean of {frames}: they need {FEWEST_BATCHES}"
        );
    }
    Ok(report)
}

/// The marker of a run that is over.
fn end_of_run(input: &Path) -> PathBuf {
    let name = "summary.json";
    if input.is_dir() {
        input.join(name)
    } else {
        input.with_file_name(name)
    }
}

/// Refuses what does not fit into the memory of the machine, before it is allocated.
fn refuse_beyond_memory(analysis: &Analysis, first: &State, frames: usize) -> Result<(), CgError> {
    let particles = first.particles.len() as f64;
    let contacts = first.contacts.as_ref().map_or(0, Contacts::len) as f64;
    // Where each image is, and where it is sorted to.
    let images = analysis.evaluator.images_of_each(&first.space) - 1.0;
    let images = images * particles.max(contacts) * 2.0 * 64.0;
    let needed = analysis.bytes(particles, contacts, frames as f64) + images;
    match machine::memory() {
        Some(memory) if needed > memory.total => {
            let points = analysis.evaluator.place.len();
            let found = format!(
                "fields at {points} points take some {} of memory; this machine has {memory}",
                readable::bytes(needed)
            );
            let help = "a coarser --grid, fewer --fields, --no-errors, or a smaller --width";
            Err(CgError::Input(format!("{found}\nhelp: {help}")))
        }
        _ => Ok(()),
    }
}

fn outputs(arguments: &Arguments, source: &Source) -> Vec<PathBuf> {
    if arguments.output.is_empty() {
        vec![
            source
                .path()
                .with_file_name(format!("{}.fields.csv", source.prefix())),
        ]
    } else {
        arguments.output.clone()
    }
}

/// Whether there is one block, or may be several.
fn succession(arguments: &Arguments, analysis: &Analysis) -> Succession {
    let one_frame = match arguments.frames {
        FrameChoice::Last => true,
        FrameChoice::Range {
            from, to: Some(to), ..
        } => to == from + 1,
        _ => false,
    };
    if one_frame || analysis.time == TimeMode::Average {
        Succession::Single
    } else {
        Succession::Series
    }
}

/// Prints the notes on the input.
fn warn(source: &Source, empty: bool, damage: Option<CgError>, frames: usize) {
    let say = |text: String| {
        // A closed standard error is not an error here.
        let _ = writeln!(std::io::stderr(), "warning: {text}");
    };
    if empty {
        say("no frame has a flowing particle: all fields are zero".to_owned());
    }
    if let (skipped @ 1.., Some(times)) = source.skipped() {
        let skipped = counted(skipped, "frame");
        say(format!(
            "{skipped} left out: no contacts of their times ({times}, ...)"
        ));
    }
    if let Source::Run(run) = source
        && run.broke_off()
    {
        let name = source.path().display();
        let frames = counted(frames, "frame");
        say(format!(
            "{name}: the run broke off: no process has written it for ten seconds, and there is no summary.json; the {frames} until then were used\nhelp: --follow once more when it has been resumed"
        ));
    }
    if let Some(damage) = damage {
        let frames = counted(frames, "frame");
        say(format!(
            "the input is damaged; {frames} before it were used\n{damage}"
        ));
    }
}

/// Why there is no frame.
fn nothing(source: &Source) -> String {
    let name = source.path().display();
    match source.skipped() {
        (0, _) => format!("{name}: no frame is selected, or the input has none"),
        (count, times) => {
            let (count, times) = (counted(count, "frame"), times.unwrap_or_default());
            let help = "particles and contacts must come from one run";
            format!("{name}: no frame has contacts of its time ({count}: {times})\nhelp: {help}")
        }
    }
}

fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

fn scan_widths(
    arguments: &Arguments,
    source: &Source,
    analysis: &Analysis,
    first: &State,
    scan: Scan,
    outputs: &[PathBuf],
) -> Result<String, CgError> {
    for output in outputs {
        let may = [Format::Csv, Format::Svg, Format::Png];
        if files::is_parquet(output) || !may.contains(&Format::of(output)?) {
            let found = format!(
                "{}: --scan writes a table, .csv, or pictures, .svg and .png",
                output.display()
            );
            return Err(CgError::Input(found));
        }
        if output.exists() && !arguments.force {
            return Err(CgError::Exists(output.clone()));
        }
    }
    let diameter = match scan.from {
        Width::Metres(_) => 1.0,
        Width::Diameters(_) => mean_diameter(first)?,
    };
    let widths = scan.widths(diameter);
    let mut widest = analysis.clone();
    widest.evaluator.kernel.width = widths.last().copied().unwrap_or(diameter);
    refuse_many_images(&widest.evaluator, &first.space)?;
    refuse_beyond_memory(&widest, first, 1 << 10)?;
    let states = || arguments.between(source.states(arguments.frames));
    let (frames, damage) = scan::write(analysis, &widths, states, outputs)?;
    warn(source, false, damage, frames);
    let (widths, frames) = (counted(widths.len(), "width"), counted(frames, "frame"));
    let said = |output: &PathBuf| format!("{widths} from {frames}: {}\n", output.display());
    Ok(outputs.iter().map(said).collect())
}
