//! `mercury-cg`: the command line, nothing else.

mod command;
mod files;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{ArgAction, Parser, ValueEnum};
use glam::DVec3;
use mercury_cg::analysis::{Reference, TimeMode};
use mercury_cg::coordinates::Coordinates;
use mercury_cg::evaluate::Mirrors;
use mercury_cg::fields::{FIELDS, Field};
use mercury_cg::input::{FrameChoice, Given, States};
use mercury_cg::kernel::{FAST_CUTOFF, FAST_TOLERANCE, KernelShape};
use mercury_cg::options::{self, Cells, Density, Limits, Scan, Smoothing, Spacing, Width};
use mercury_cg::output::Format;
use mercury_cg::setup::Wanted;
use mercury_common::cli::{self, Exit, Failure, Outcome};

const EXAMPLES: &str = "\
Examples:
  mercury-cg chute --coordinates Z --average time -o profile.csv -o profile.svg
                                       mean profiles over the height, with standard errors
  mercury-cg drum --coordinates XZ --width 1.5d --frames last -o drum.vti
  mercury-cg dense2k.data --density 2500 --grid 20x20x20 --width 0.004 -o dense2k.stat
  mercury-cg chute --coordinates Z --scan 0.3d..4d/12 -o widths.csv
                                       the fields at many widths: where is the plateau?
  mercury-cg silo --coordinates RZ --spacing 0.005 --fields velocity,shear_rate,inertial_number -o silo.csv
  mercury-cg drum --follow --coordinates XZ -o drum.vti
                                       a series for ParaView while the solver runs

INPUT is a run folder, NAME.particles.arrow, NAME.data (with NAME.fstat beside it), NAME.data.0000 (a series), or \
a .restart of MercuryDPM; .data, .fstat and .restart may be packed (.gz, .zst, .xz, .bz2).
The ending of -o says what is written: .csv and .parquet tables, .stat MercuryCG's layout, .vti image data for ParaView, .svg and .png \
pictures of profiles (one coordinate) and maps (two). Maps leave quotients (velocity, temperature, ...) blank where what they are \
divided by (the density, ...) is below 5 % of its largest value in the map.
Fields with units and definitions: mercury-cg --list-fields.
Exit codes: 0 done (also if the input was cut: its good frames are used, and a warning says so), 1 a file could not be \
written, 2 wrong usage or input.";

/// Turns particles and contacts into fields of the continuum: density, velocity, stress, ...
#[derive(Debug, Parser)]
#[command(name = "mercury-cg", version, after_help = EXAMPLES)]
struct Arguments {
    /// Run folder or file
    #[arg(value_name = "INPUT", required_unless_present_any = ["list_fields", "completions"])]
    input: Option<PathBuf>,
    /// Files to write, .csv, .parquet, .stat, .vti, .svg or .png; may be repeated [default: PREFIX.fields.csv beside the input]
    #[arg(short, long, value_name = "FILE")]
    output: Vec<PathBuf>,
    /// Names of fields with commas between; standard and all stand for several
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    fields: Vec<String>,
    /// Print all fields with units and definitions and stop
    #[arg(long)]
    list_fields: bool,

    /// Resolved coordinates: O (none), X to XYZ, R, RZ, Rphi, RphiZ; fields are means over the others [default: XYZ, in 2D XY]
    #[arg(long, value_name = "NAMES", help_heading = "Where")]
    coordinates: Option<Coordinates>,
    /// Cells along each resolved coordinate, as in 20x40; fields are those in their middles
    #[arg(long, value_name = "CELLS", help_heading = "Where")]
    grid: Option<Cells>,
    /// Or the size of cells, for all or for each coordinate, as in 0.002x0.001 (m, rad) [default: the width]
    #[arg(long, value_name = "LENGTHS", help_heading = "Where")]
    spacing: Option<Spacing>,
    /// Limits of the grid, as in x=0..0.1,z=0..0.05 [default: those of the domain]
    #[arg(long, value_name = "RANGES", help_heading = "Where")]
    limits: Option<Limits>,
    /// Points from a table instead of a grid, one in each line
    #[arg(long, value_name = "FILE", help_heading = "Where")]
    points: Option<PathBuf>,
    /// Direction of the axis of cylindrical coordinates
    #[arg(long, value_enum, help_heading = "Where")]
    axis: Option<Axis>,
    /// A point on that axis, as in 0.05,0,0.05 [default: the middle of the domain]
    #[arg(long, value_name = "X,Y,Z", value_parser = options::point, allow_hyphen_values = true, help_heading = "Where")]
    through: Option<DVec3>,

    /// Function that particles are spread by
    #[arg(long, value_enum, default_value_t, help_heading = "Kernel")]
    kernel: KernelName,
    /// Its width in m or with its unit as in "4 mm", or in mean diameters as in 1.5d: standard deviation (gaussian) or radius (others) [default: 1d]
    #[arg(long, value_name = "WIDTH", help_heading = "Kernel")]
    width: Option<Width>,
    /// Many widths at equal ratios, FROM..TO/COUNT as in 0.5d..4d/12: a table with the width as first column, and pictures of fields over the width
    #[arg(long, value_name = "WIDTHS", conflicts_with_all = ["width", "follow", "smooth"], help_heading = "Kernel")]
    scan: Option<Scan>,
    /// Where a gaussian is cut, in widths [default: 4]
    #[arg(long, value_name = "WIDTHS", value_parser = cutoff, help_heading = "Kernel")]
    cutoff: Option<f64>,
    /// Error of line integrals of a gaussian on grids, relative to their largest value [default: 1e-3]
    #[arg(long, value_name = "ERROR", value_parser = tolerance, help_heading = "Kernel")]
    tolerance: Option<f64>,
    /// No error beyond rounding: cut-off 8.8, tolerance 1e-16
    #[arg(long, conflicts_with_all = ["cutoff", "tolerance", "fast", "compat"], help_heading = "Kernel")]
    exact: bool,
    /// For a first look: cut-off 2.5, tolerance 5e-2; fields are right to 6 % of their largest value
    #[arg(long, conflicts_with_all = ["cutoff", "tolerance", "compat"], help_heading = "Kernel")]
    fast: bool,
    /// Faces of the domain that mirror particles and contacts, as in -z or -x,+x
    #[arg(long, value_name = "FACES", value_parser = options::mirrors, allow_hyphen_values = true, help_heading = "Kernel")]
    mirror: Option<Mirrors>,
    /// The conventions of another program: cut-off 3, no periodic images, 6 digits
    #[arg(long, value_enum, help_heading = "Kernel")]
    compat: Option<Compat>,

    /// all, last, a number, A..B (without B), A.., ..B, "every N", or A..B/N
    #[arg(long, default_value = "all", help_heading = "Time")]
    frames: FrameChoice,
    /// No frames before this time (s)
    #[arg(
        long,
        value_name = "TIME",
        allow_negative_numbers = true,
        help_heading = "Time"
    )]
    from: Option<f64>,
    /// No frames after this time (s)
    #[arg(
        long,
        value_name = "TIME",
        allow_negative_numbers = true,
        help_heading = "Time"
    )]
    to: Option<f64>,
    /// One mean over all frames, with standard errors from 16 frames on
    #[arg(long, value_enum, help_heading = "Time")]
    average: Option<Average>,
    /// Means weighted by a Gaussian in time: its width, and the distance of output times (s)
    #[arg(
        long,
        value_name = "WIDTH,STEP",
        conflicts_with = "average",
        help_heading = "Time"
    )]
    smooth: Option<Smoothing>,
    /// No standard errors, which take memory on large grids
    #[arg(long, help_heading = "Time")]
    no_errors: bool,
    /// Displacement and strain are those since the first frame, instead of the frame before
    #[arg(long, help_heading = "Time")]
    since_first: bool,
    /// Go on while the solver runs, until its summary.json is there; what is written can be read at any time
    #[arg(long, help_heading = "Time")]
    follow: bool,

    /// Fields of this material beside those of all, by name or index; may be repeated
    #[arg(long, value_name = "NAME", help_heading = "Particles")]
    material: Vec<String>,
    /// Fields of each material beside those of all
    #[arg(long, help_heading = "Particles")]
    by_material: bool,
    /// Density of the particles of .data files, or INDEX=DENSITY of one material; may be repeated (kg/m^3; 2D: kg/m^2)
    #[arg(long, value_name = "DENSITY", help_heading = "Particles")]
    density: Vec<Density>,
    /// Fixed particles of .data files by their numbers, as in 0..100,120 (ranges without their end)
    #[arg(long, value_name = "NUMBERS", value_parser = options::ids, action = ArgAction::Set, help_heading = "Particles")]
    fixed: Option<IdRanges>,
    /// The contacts of .data files, if they do not lie beside them
    #[arg(long, value_name = "FILE", help_heading = "Particles")]
    fstat: Option<PathBuf>,

    /// Threads [default: all cores]; the output is the same
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Replace files that are there
    #[arg(long)]
    force: bool,
    /// No progress and no report, only errors and warnings
    #[arg(long)]
    quiet: bool,
    /// Print completions for a shell and exit
    #[arg(long, value_name = "SHELL")]
    completions: Option<cli::Shell>,
}

/// Ranges of numbers, both ends included.
type IdRanges = Vec<(u32, u32)>;

#[derive(Debug, Clone, Copy, Default, ValueEnum)]
enum KernelName {
    #[default]
    Gaussian,
    Lucy,
    Linear,
    Heaviside,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Axis {
    X,
    Y,
    Z,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Compat {
    Mercury,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Average {
    Time,
}

fn cutoff(text: &str) -> Result<f64, String> {
    let value = text
        .parse()
        .ok()
        .filter(|value| (1.0..=38.0).contains(value));
    value.ok_or_else(|| "expected 1 to 38 widths".to_owned())
}

fn tolerance(text: &str) -> Result<f64, String> {
    let value = text
        .parse()
        .ok()
        .filter(|value| (1e-16..=0.1).contains(value));
    value.ok_or_else(|| "expected 1e-16 to 0.1".to_owned())
}

fn main() -> ExitCode {
    cli::main(|arguments: Arguments| {
        if let Some(shell) = arguments.completions {
            return cli::say_completions::<Arguments>(shell);
        }
        if arguments.list_fields {
            return cli::say(&list_of_fields());
        }
        execute(&arguments)
    })
}

fn list_of_fields() -> String {
    let line = |field: &Field| {
        let (name, unit, definition) = (field.name, field.unit, field.definition);
        format!("{name:<22}{unit:<12}{definition}\n")
    };
    FIELDS.iter().map(line).collect()
}

fn execute(arguments: &Arguments) -> Outcome {
    let report = command::compute(arguments).map_err(|error| {
        let exit = if error.is_input() {
            Exit::Input
        } else {
            Exit::Failed
        };
        Failure::new(exit, error)
    })?;
    if arguments.quiet {
        Ok(())
    } else {
        cli::say(&report)
    }
}

impl Arguments {
    fn wanted(&self) -> Wanted {
        let time = match (self.average, self.smooth) {
            (Some(Average::Time), _) => Some(TimeMode::Average),
            (None, Some(smooth)) => Some(TimeMode::Smooth {
                width: smooth.width,
                step: smooth.step,
            }),
            (None, None) => None,
        };
        let pick = |exact: f64, fast: f64, given: Option<f64>| match (self.exact, self.fast) {
            (true, _) => Some(exact),
            (_, true) => Some(fast),
            _ => given,
        };
        let is_gaussian = matches!(self.kernel, KernelName::Gaussian);
        let cut =
            pick(8.8, FAST_CUTOFF, self.cutoff).filter(|_| is_gaussian || self.cutoff.is_some());
        Wanted {
            fields: self
                .fields
                .iter()
                .map(|name| name.trim().to_ascii_lowercase())
                .collect(),
            coordinates: self.coordinates,
            grid: self.grid.clone(),
            spacing: self.spacing.clone(),
            limits: self.limits.clone().unwrap_or_default(),
            points: self.points.clone(),
            shape: match self.kernel {
                KernelName::Gaussian => KernelShape::Gaussian,
                KernelName::Lucy => KernelShape::Lucy,
                KernelName::Linear => KernelShape::Linear,
                KernelName::Heaviside => KernelShape::Heaviside,
            },
            width: self.width,
            cutoff: cut,
            tolerance: pick(1e-16, FAST_TOLERANCE, self.tolerance),
            compat: self.compat.is_some(),
            mirrors: self.mirror.unwrap_or_default(),
            axis: self.axis.map(|axis| axis as usize),
            through: self.through,
            materials: self.material.clone(),
            by_material: self.by_material,
            time,
            errors: !self.no_errors,
            reference: if self.since_first {
                Reference::First
            } else {
                Reference::Previous
            },
            stat: self
                .output
                .iter()
                .any(|path| matches!(Format::of(path), Ok(Format::Stat))),
        }
    }

    fn given(&self) -> Given {
        let mut given = Given {
            fixed: self.fixed.clone().unwrap_or_default(),
            fstat: self.fstat.clone(),
            ..Given::default()
        };
        for density in &self.density {
            match *density {
                Density::All(density) => given.density = Some(density),
                Density::Of(index, density) => {
                    given.densities.insert(index, density);
                }
            }
        }
        given
    }

    /// The states between both times.
    fn between<'a>(&self, states: States<'a>) -> States<'a> {
        let (from, to) = (
            self.from.unwrap_or(f64::NEG_INFINITY),
            self.to.unwrap_or(f64::INFINITY),
        );
        Box::new(states.filter(move |state| match state {
            Ok(state) => (from..=to).contains(&state.time),
            Err(_) => true,
        }))
    }
}
