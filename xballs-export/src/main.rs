//! `mercury-export`: the command line, nothing else.

mod arguments;
mod picture_command;

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use mercury_common::cli::{self, Exit, Failure, Progress};
use mercury_common::formats::number::NumberStyle;
use mercury_common::formats::vtu::VtuOptions;
use mercury_common::readable::counted;
use mercury_common::run_tables::TableSpec;
use mercury_export::output::{Output, ending_of_file, takes_folder};
use mercury_export::query;
use mercury_export::run_table::Format;
use mercury_export::sinks::pictures::{PictureKind, Pictures};
use mercury_export::sinks::{
    Density, Info, Parquet, Stl, Vtu, VtuChoice, Xballs, XballsChoice, csv, data_files, dump,
    particle_tables,
};
use mercury_export::{
    ExportError, FrameChoice, Job, Outcome, Selection, Sink, Source, export, run_table, study_table,
};

use arguments::{Arguments, Command, Common};
use picture_command::Look;

/// Rows of an answer that are printed; a file takes all.
const PRINTED: usize = 1000;

fn main() -> ExitCode {
    cli::main(|arguments: Arguments| match arguments.command {
        Command::Completions { shell } => cli::say_completions::<Arguments>(shell),
        command => execute(command).map_err(|error| {
            let exit = if error.is_input() {
                Exit::Input
            } else {
                Exit::Failed
            };
            Failure::new(exit, error)
        }),
    })
}

/// Each command is a sink, and the folder beside the input that its files go to.
fn execute(command: Command) -> Result<(), ExportError> {
    match command {
        // Answered without an input.
        Command::Completions { .. } => Ok(()),
        Command::Vtu {
            common,
            precision,
            compression,
            no_contacts,
            no_walls,
            clumps,
        } => {
            let choice = VtuChoice {
                options: VtuOptions {
                    precision: precision.into(),
                    compression,
                    parallel: true,
                },
                contacts: !no_contacts,
                walls: !no_walls,
                clumps: clumps.into(),
            };
            run(&common, "vtu", |job| Ok(Box::new(Vtu::new(job, choice)?)))
        }
        Command::Xballs {
            common,
            dimensions,
            info,
            digits,
        } => {
            let choice = XballsChoice {
                dimensions,
                info: match info.as_str() {
                    "material" => Info::Material,
                    "speed" => Info::Speed,
                    _ => Info::Column(info),
                },
                style: digits.map_or(NumberStyle::Shortest, NumberStyle::Digits),
            };
            run(&common, "xballs", |job| {
                Ok(Box::new(Xballs::begin(&job.output, choice)?))
            })
        }
        Command::Csv { common, table } => match table.kind() {
            Ok(table) => run(&common, "csv", |job| Ok(Box::new(csv(&job.output, table)))),
            Err(table) => {
                takes_folder("csv", common.output.as_deref())?;
                whole(&common, table, "csv", None, Format::Csv)
            }
        },
        Command::Parquet { common, .. } if study_table::table_in(&common.input).is_some() => {
            let found = study_table::table_in(&common.input).unwrap_or_default();
            let output = common.output.as_deref();
            let (path, rows) = study_table::to_parquet(&found, output, common.force)?;
            if !common.quiet {
                let _ = writeln!(
                    std::io::stdout(),
                    "{} in {}",
                    counted(rows, "run"),
                    path.display()
                );
            }
            Ok(())
        }
        Command::Parquet { common, table } => {
            let file = common.output.as_deref();
            let file = file.filter(|path| ending_of_file(path).as_deref() == Some("parquet"));
            if file.is_none() {
                takes_folder("parquet", common.output.as_deref())?;
            }
            match table.kind() {
                Ok(table) => run_into(&common, "parquet", file, |job| {
                    Ok(Box::new(Parquet::new(&job.output, table)))
                }),
                Err(table) => whole(&common, table, "parquet", file, Format::Parquet),
            }
        }
        Command::Query {
            input,
            sql,
            output,
            force,
        } => query(&input, &sql, output.as_deref(), force),
        Command::Particles { common } => run(&common, "particles", |job| {
            Ok(Box::new(particle_tables(&job.output)))
        }),
        Command::Lammps { common } => {
            run(&common, "lammps", |job| Ok(Box::new(dump(&job.output)?)))
        }
        Command::Liggghts { common, density } => {
            let density = density.map(Density::new).transpose()?;
            run(&common, "liggghts", |job| {
                Ok(Box::new(data_files(&job.output, density)))
            })
        }
        Command::Stl {
            common,
            scene_frame,
        } => run(&common, "stl", |job| {
            Ok(Box::new(Stl::new(job, scene_frame)?))
        }),
        Command::Png {
            common,
            look,
            strip,
        } => {
            let kind = strip.map_or(PictureKind::Png, PictureKind::Strip);
            draw(&common, &look, "png", kind)
        }
        Command::Svg { common, look } => draw(&common, &look, "svg", PictureKind::Svg),
        Command::Gif {
            common,
            look,
            duration,
        } => draw(&common, &look, "film", PictureKind::Gif(duration)),
        Command::Apng {
            common,
            look,
            duration,
        } => draw(&common, &look, "film", PictureKind::Apng(duration)),
    }
}

/// Writes a table that the run has as text, with a message.
fn whole(
    common: &Common,
    table: &TableSpec,
    beside: &str,
    file: Option<&Path>,
    format: Format,
) -> Result<(), ExportError> {
    let source = Source::open(&common.input)?;
    let output = match file {
        Some(file) => Output::to_file(&source, file, common.force)?,
        None => Output::new(&source, common.output.as_deref(), beside, common.force)?,
    };
    let selection = Selection {
        frames: common.frames,
        region: common.region,
        materials: common.material.clone(),
    };
    let (path, rows) = run_table::export(&source, table, &selection, &output, format)?;
    if !common.quiet {
        let _ = writeln!(
            std::io::stdout(),
            "{} in {}",
            counted(rows, "row"),
            path.display()
        );
    }
    Ok(())
}

/// Answers a query: prints its first rows, or writes it.
fn query(input: &Path, sql: &str, output: Option<&Path>, force: bool) -> Result<(), ExportError> {
    let format = output.map(|path| Ok::<_, ExportError>((path, query::format_of(path)?)));
    let format = format.transpose()?;
    if let Some((path, _)) = format.filter(|(path, _)| !force && path.symlink_metadata().is_ok()) {
        return Err(ExportError::Exists(path.to_owned()));
    }
    let answer = query::tables_in(input)?.query(sql)?;
    for damage in &answer.damage {
        let _ = writeln!(
            std::io::stderr(),
            "warning: only whole frames count\n{damage}"
        );
    }
    match format {
        Some((path, format)) => answer.write(path, format)?,
        None => {
            let rows = answer.first_rows(PRINTED)?;
            let _ = write!(std::io::stdout(), "{}", query::printed(&rows));
        }
    }
    Ok(())
}

fn draw(common: &Common, look: &Look, beside: &str, kind: PictureKind) -> Result<(), ExportError> {
    let choice = look.choice();
    let file = common.output.as_deref();
    let file = match file.map(|path| kind.is_file(path)).transpose()? {
        Some(true) => file,
        _ => None,
    };
    run_into(common, beside, file, |job| {
        Ok(Box::new(Pictures::new(job, choice, kind)?))
    })
}

/// Sets up a job, lets the driver write it, and reports what was done.
fn run(
    common: &Common,
    beside: &str,
    sink: impl for<'a> FnOnce(&'a Job) -> Result<Box<dyn Sink + 'a>, ExportError>,
) -> Result<(), ExportError> {
    takes_folder(beside, common.output.as_deref())?;
    run_into(common, beside, None, sink)
}

/// Runs an export into one file, if one is given.
fn run_into(
    common: &Common,
    beside: &str,
    file: Option<&Path>,
    sink: impl for<'a> FnOnce(&'a Job) -> Result<Box<dyn Sink + 'a>, ExportError>,
) -> Result<(), ExportError> {
    let source = Source::open(&common.input)?;
    let output = match file {
        Some(file) => Output::to_file(&source, file, common.force)?,
        None => Output::new(&source, common.output.as_deref(), beside, common.force)?,
    };
    let selection = Selection {
        frames: common.frames,
        region: common.region,
        materials: common.material.clone(),
    };
    let job = Job {
        source,
        selection,
        output,
    };
    let last = job.source.len_hint().map(|count| count.saturating_sub(1));
    let mut progress = Progress::new(common.quiet);
    let written = export(&job, sink(&job)?, |number| {
        progress.count("frame", number, last);
    });
    progress.clear();
    let (outcome, files) = written?;
    report(&job, common.quiet, outcome, &files);
    Ok(())
}

/// A folder as a sentence ends with it.
fn folder_name(folder: &Path) -> String {
    match folder == Path::new("") || folder == Path::new(".") {
        true => "this folder".to_owned(),
        false => folder.display().to_string(),
    }
}

/// Says what was written, and what is wrong with the input.
fn report(job: &Job, quiet: bool, outcome: Outcome, files: &[PathBuf]) {
    let mut out = String::new();
    if !quiet {
        out = format!(
            "{} in {}\n",
            counted(outcome.written, "frame"),
            folder_name(&job.output.folder)
        );
        let most = 4;
        for file in files.iter().take(most) {
            out += &format!("  {}\n", name(file));
        }
        if let Some(last) = files.last().filter(|_| files.len() > most) {
            out += &format!("  ... {}\n", name(last));
        }
    }
    if !quiet {
        out += &outcome.to_copy;
    }
    let _ = write!(std::io::stdout(), "{out}");
    for note in outcome.notes.iter().filter(|_| !quiet) {
        let _ = writeln!(std::io::stderr(), "note: {note}");
    }
    for warning in &outcome.warnings {
        let _ = writeln!(std::io::stderr(), "warning: {warning}");
    }
    if let Some(damage) = outcome.damage {
        let count = counted(outcome.frames, "frame");
        let what = if job.selection.frames == FrameChoice::All {
            format!("only the first {count} could be used")
        } else {
            format!("the input is damaged; of the requested frames {count} could be used")
        };
        let _ = writeln!(std::io::stderr(), "warning: {what}\n{damage}");
    }
}

fn name(path: &Path) -> String {
    path.file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}
