//! `mercury-export`: the command line, nothing else.

mod picture_command;

use std::cell::RefCell;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand, ValueEnum};
use mercury_common::cli::{self, Exit, Failure, Progress};
use mercury_common::formats::number::NumberStyle;
use mercury_common::formats::vtu::{VtuCompression, VtuOptions, VtuPrecision};
use mercury_common::readable::counted;
use mercury_export::output::Output;
use mercury_export::pictures::{self, PictureKind};
use mercury_export::tables::{self, Table};
use mercury_export::vtu::{self, VtuChoice};
use mercury_export::xballs::{self, Info, XballsChoice};
use mercury_export::{
    ClumpsAs, ExportError, FrameChoice, Region, Selection, Source, Told, lammps, particle_csv,
};

use picture_command::Look;

const EXAMPLES: &str = "\
Examples:
  mercury-export vtu drum                        series for ParaView in drum/vtu/
  mercury-export vtu drum --frames last --region \"z=0..0.05\" --precision single -o small
  mercury-export xballs drum                     drum/xballs/drum.data and drum.disp, which starts XBalls
  mercury-export vtu old.data                    a file of MercuryDPM, or the .disp or .xballs that shows it
  mercury-export vtu stones --clumps surface     clumps as their own surfaces, stones.clumps.pvd
  mercury-export csv drum --frames \"every 10\"    a table per frame
  mercury-export parquet drum --table contacts   all contacts of all frames in one table
  mercury-export particles drum --frames last    the table that scenes read: file = \"drum.0010.csv\"
  mercury-export lammps drum                     a dump that OVITO and LAMMPS read
  mercury-export png drum --frames last          the last frame as a picture, drum/png/drum.0050.png
  mercury-export png drum --strip 5 --size 1600x420   five frames side by side
  mercury-export gif drum --colour material --size 640x480   a film in drum/film/drum.gif

INPUT is a run folder, NAME.particles.arrow, NAME.data, NAME.data.0000 (a series), NAME.disp or NAME.xballs.
Exit codes: 0 done (also if the input was cut: its good frames are there, and a warning says so), 1 a file could not be \
written, 2 wrong usage or input.";

/// Turns what the solver wrote into what people look at.
#[derive(Debug, Parser)]
#[command(name = "mercury-export", version, after_help = EXAMPLES)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Series for ParaView, pyvista and meshio: .vtu files, .pvd lists with times, and a script that opens them
    Vtu {
        #[command(flatten)]
        common: Common,
        /// 64 bits per number, or 32 in half the space
        #[arg(long, value_enum, default_value_t)]
        precision: Precision,
        /// none, fast (only what shrinks), or a level from 1 (fast) to 9 (small)
        #[arg(long, default_value = "fast", value_parser = compression, allow_negative_numbers = true)]
        compression: VtuCompression,
        /// Leave contacts out
        #[arg(long)]
        no_contacts: bool,
        /// Leave walls out
        #[arg(long)]
        no_walls: bool,
        /// Clumps as spheres, as their own surfaces (.clumps.pvd), or both
        #[arg(long, value_enum, default_value_t)]
        clumps: ClumpsName,
    },
    /// .data as XBalls and MercuryDPM's tools read it, and the script .disp that starts XBalls
    Xballs {
        #[command(flatten)]
        common: Common,
        /// 2 (format 8) or 3 (format 14) [default: what the input is]
        #[arg(long, value_parser = clap::value_parser!(u8).range(2..=3), allow_negative_numbers = true)]
        dimensions: Option<u8>,
        /// The last column, which XBalls colours by: material, speed, or the name of a column
        #[arg(long, default_value = "material")]
        info: String,
        /// Significant digits (10 is MercuryDPM's look) [default: as many as read back exactly]
        #[arg(long, value_parser = clap::value_parser!(u8).range(1..=17), allow_negative_numbers = true)]
        digits: Option<u8>,
    },
    /// Tables as text, one file per frame
    Csv {
        #[command(flatten)]
        common: Common,
        /// Particles, contacts or bodies (clumps)
        #[arg(long, value_enum, default_value_t)]
        table: TableName,
    },
    /// All frames in one Parquet table, one row group per frame
    Parquet {
        #[command(flatten)]
        common: Common,
        /// Particles, contacts or bodies (clumps)
        #[arg(long, value_enum, default_value_t)]
        table: TableName,
    },
    /// The particle table that scenes read, one file per frame
    Particles {
        #[command(flatten)]
        common: Common,
    },
    /// A text dump of all frames for LAMMPS, LIGGGHTS and OVITO
    Lammps {
        #[command(flatten)]
        common: Common,
    },
    /// Data files for read_data of LAMMPS (atom_style sphere) and LIGGGHTS (granular), one per frame
    Liggghts {
        #[command(flatten)]
        common: Common,
        /// Density of all particles in kg/m^3; needed where the input has no masses (.data)
        #[arg(long, allow_negative_numbers = true)]
        density: Option<f64>,
    },
    /// Pictures of frames: shaded particles, walls, colour bar, scale
    Png {
        #[command(flatten)]
        common: Common,
        #[command(flatten)]
        look: Look,
        /// Instead of a picture of each frame one with N of them side by side
        #[arg(long, value_name = "N", value_parser = strip, allow_negative_numbers = true)]
        strip: Option<usize>,
    },
    /// Pictures of frames as vector graphics
    Svg {
        #[command(flatten)]
        common: Common,
        #[command(flatten)]
        look: Look,
    },
    /// A film as animated GIF: plays anywhere, 255 colours a frame
    Gif {
        #[command(flatten)]
        common: Common,
        #[command(flatten)]
        look: Look,
        /// Seconds that the film takes [default: 20 frames a second]
        #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
        duration: Option<f64>,
    },
    /// A film as animated PNG: all colours, plays in browsers
    Apng {
        #[command(flatten)]
        common: Common,
        #[command(flatten)]
        look: Look,
        /// Seconds that the film takes [default: 20 frames a second]
        #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
        duration: Option<f64>,
    },
    /// Completions for a shell
    Completions {
        /// The shell
        shell: cli::Shell,
    },
}

#[derive(Debug, Args)]
struct Common {
    /// Run folder or file
    #[arg(value_name = "INPUT")]
    input: PathBuf,
    /// Folder for the files [default: a folder named after the command, beside the input]
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// all, last, a number, A..B (without B), A.., ..B, or "every N"
    #[arg(long, default_value = "all", allow_negative_numbers = true)]
    frames: FrameChoice,
    /// Only particles with their centre in a box, as in x=0..0.1,z=..0.05 (m)
    #[arg(long, value_name = "RANGES")]
    region: Option<Region>,
    /// Only particles of this material, by name or index; may be repeated
    #[arg(long, value_name = "NAME", allow_negative_numbers = true)]
    material: Vec<String>,
    /// Replace files of an earlier export
    #[arg(long)]
    force: bool,
    /// No progress and no report, only errors and warnings
    #[arg(long)]
    quiet: bool,
}

#[derive(Debug, Clone, Copy, Default, ValueEnum)]
enum Precision {
    #[default]
    Double,
    Single,
}

#[derive(Debug, Clone, Copy, Default, ValueEnum)]
enum ClumpsName {
    #[default]
    Pebbles,
    Surface,
    Both,
}

impl From<ClumpsName> for ClumpsAs {
    fn from(name: ClumpsName) -> Self {
        match name {
            ClumpsName::Pebbles => Self::Pebbles,
            ClumpsName::Surface => Self::Surface,
            ClumpsName::Both => Self::Both,
        }
    }
}

#[derive(Debug, Clone, Copy, Default, ValueEnum)]
enum TableName {
    #[default]
    Particles,
    Contacts,
    Bodies,
}

impl From<TableName> for Table {
    fn from(name: TableName) -> Self {
        match name {
            TableName::Particles => Self::Particles,
            TableName::Contacts => Self::Contacts,
            TableName::Bodies => Self::Bodies,
        }
    }
}

fn compression(text: &str) -> Result<VtuCompression, String> {
    match text {
        "none" => Ok(VtuCompression::None),
        "fast" => Ok(VtuCompression::Adaptive),
        _ => match text.parse() {
            Ok(level @ 1..=9) => Ok(VtuCompression::Level(level)),
            _ => Err("expected none, fast, or a level from 1 to 9".to_owned()),
        },
    }
}

fn strip(text: &str) -> Result<usize, String> {
    let most = pictures::LONGEST_STRIP;
    let number = text.parse().ok();
    let number = number.filter(|number| (1..=most).contains(number));
    number.ok_or_else(|| format!("expected 1 to {most} frames"))
}

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

/// An export that is set up: where from, what of it, and where to.
struct Job {
    source: Source,
    selection: Selection,
    output: Output,
    quiet: bool,
    /// In a cell, because every command hands out the job while it tells its progress.
    progress: RefCell<Progress>,
}

impl Job {
    fn new(common: &Common, beside: &str) -> Result<Self, ExportError> {
        let source = Source::open(&common.input)?;
        let folder = common.output.as_deref();
        Ok(Self {
            selection: Selection {
                frames: common.frames,
                region: common.region,
                materials: common.material.clone(),
            },
            output: Output::new(&source, folder, beside, common.force)?,
            source,
            quiet: common.quiet,
            progress: RefCell::new(Progress::new(common.quiet)),
        })
    }

    /// Says which frame is being written.
    fn progress(&self, number: usize) {
        let last = self.source.len_hint().map(|count| count.saturating_sub(1));
        self.progress.borrow_mut().count("frame", number, last);
    }

    /// Says what was written, and what is wrong with the input.
    fn report(&self, (told, files): (Told, Vec<PathBuf>)) {
        self.progress.borrow_mut().clear();
        let mut out = String::new();
        if !self.quiet {
            out = format!(
                "{} in {}\n",
                counted(told.written, "frame"),
                self.output.folder.display()
            );
            let most = 4;
            for file in files.iter().take(most) {
                out += &format!("  {}\n", name(file));
            }
            if let Some(last) = files.last().filter(|_| files.len() > most) {
                out += &format!("  ... {}\n", name(last));
            }
        }
        let _ = write!(std::io::stdout(), "{out}");
        for note in told.notes.iter().filter(|_| !self.quiet) {
            let _ = writeln!(std::io::stderr(), "note: {note}");
        }
        for warning in &told.warnings {
            let _ = writeln!(std::io::stderr(), "warning: {warning}");
        }
        if let Some(damage) = told.damage {
            let count = counted(told.frames, "frame");
            let what = if self.selection.frames == FrameChoice::All {
                format!("only the first {count} could be used")
            } else {
                format!("the input is damaged; of the frames asked for {count} could be used")
            };
            let _ = writeln!(std::io::stderr(), "warning: {what}\n{damage}");
        }
    }
}

fn name(path: &Path) -> String {
    path.file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

fn execute(command: Command) -> Result<(), ExportError> {
    match command {
        // Answered without an input.
        Command::Completions { .. } => {}
        Command::Vtu {
            common,
            precision,
            compression,
            no_contacts,
            no_walls,
            clumps,
        } => {
            let job = Job::new(&common, "vtu")?;
            let choice = VtuChoice {
                options: VtuOptions {
                    precision: match precision {
                        Precision::Double => VtuPrecision::Double,
                        Precision::Single => VtuPrecision::Single,
                    },
                    compression,
                    parallel: true,
                },
                contacts: !no_contacts,
                walls: !no_walls,
                clumps: clumps.into(),
            };
            let told = vtu::export(
                &job.source,
                &job.selection,
                &job.output,
                choice,
                |snapshot| {
                    job.progress(snapshot.number);
                },
            )?;
            job.report(told);
        }
        Command::Xballs {
            common,
            dimensions,
            info,
            digits,
        } => {
            let job = Job::new(&common, "xballs")?;
            let choice = XballsChoice {
                dimensions,
                info: match info.as_str() {
                    "material" => Info::Material,
                    "speed" => Info::Speed,
                    _ => Info::Column(info),
                },
                style: digits.map_or(NumberStyle::Shortest, NumberStyle::Digits),
            };
            let told = xballs::export(
                &job.source,
                &job.selection,
                &job.output,
                &choice,
                |snapshot| {
                    job.progress(snapshot.number);
                },
            )?;
            job.report(told);
        }
        Command::Csv { common, table } => {
            let job = Job::new(&common, "csv")?;
            let progress = |number| job.progress(number);
            let told = tables::export_csv(
                &job.source,
                &job.selection,
                table.into(),
                &job.output,
                progress,
            )?;
            job.report(told);
        }
        Command::Parquet { common, table } => {
            let job = Job::new(&common, "parquet")?;
            let progress = |number| job.progress(number);
            let told = tables::export_parquet(
                &job.source,
                &job.selection,
                table.into(),
                &job.output,
                progress,
            )?;
            job.report(told);
        }
        Command::Particles { common } => {
            let job = Job::new(&common, "particles")?;
            let told =
                particle_csv::export(&job.source, &job.selection, &job.output, |snapshot| {
                    job.progress(snapshot.number);
                })?;
            job.report(told);
        }
        Command::Lammps { common } => {
            let job = Job::new(&common, "lammps")?;
            let told = lammps::export_dump(&job.source, &job.selection, &job.output, |snapshot| {
                job.progress(snapshot.number);
            })?;
            job.report(told);
        }
        Command::Png {
            common,
            look,
            strip,
        } => {
            let kind = strip.map_or(PictureKind::Png, PictureKind::Strip);
            draw(&common, &look, "png", kind)?;
        }
        Command::Svg { common, look } => draw(&common, &look, "svg", PictureKind::Svg)?,
        Command::Gif {
            common,
            look,
            duration,
        } => draw(&common, &look, "film", PictureKind::Gif(duration))?,
        Command::Apng {
            common,
            look,
            duration,
        } => draw(&common, &look, "film", PictureKind::Apng(duration))?,
        Command::Liggghts { common, density } => {
            if let Some(density) = density.filter(|d| !(*d > 0.0 && d.is_finite())) {
                let message = format!("--density {density}: expected a positive number, in kg/m^3");
                return Err(ExportError::Input(message));
            }
            let job = Job::new(&common, "liggghts")?;
            let progress = |snapshot: &mercury_export::Snapshot| job.progress(snapshot.number);
            let told = lammps::export_data_files(
                &job.source,
                &job.selection,
                density,
                &job.output,
                progress,
            )?;
            job.report(told);
        }
    }
    Ok(())
}

fn draw(common: &Common, look: &Look, beside: &str, kind: PictureKind) -> Result<(), ExportError> {
    let job = Job::new(common, beside)?;
    let told = pictures::export(
        &job.source,
        &job.selection,
        &job.output,
        &look.choice(),
        kind,
        |snapshot| job.progress(snapshot.number),
    )?;
    job.report(told);
    Ok(())
}
