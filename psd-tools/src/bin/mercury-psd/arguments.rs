//! Arguments of the command line.

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{ArgGroup, Args, Parser, Subcommand, ValueEnum};
use mercury_common::cli::{Shell, positive};
use mercury_common::sizes::table::{self, Model, Options, SizeKind, ValueKind};
use mercury_common::sizes::{ClassModel, Weighting};
use mercury_psd::charts::{Look, Shares};
use mercury_psd::check::run::Condition;
use mercury_psd::draw::Method;
use mercury_psd::fit::Family;

const EXAMPLES: &str = "\
Examples:
  mercury-psd stats grain.psd.csv                                         d10, d50, d90, means by number ... volume
  mercury-psd stats '{ kind = \"lognormal\", median_diameter = 3e-3, sigma = 0.2, weighting = \"volume\" }'
  mercury-psd convert grain.psd.csv --to cumulative-number -o number.csv
  mercury-psd fit grain.psd.csv --count 2000 -o grain                     writes grain.psd.toml, grain.svg, grain.png
  mercury-psd compare grain.psd.csv grain.psd.toml
  mercury-psd sample grain.psd.csv --number 10000 -o sizes.csv
  mercury-psd check hopper                                                the sizes of a run against its scene
  mercury-psd plot grain.psd.csv --log --axis probability -o grain

FILE: a table with a header (diameter [mm],cumulative volume [%]), a list of sizes (radius [m]), a law (.toml, or { kind = ... } as in
a scene), a run folder. Files without header: --size radius --unit m --type cumulative-number; of a target --target-size, --target-unit, --target-type.
Exit codes: 0 done, 1 a check failed or has too few particles, or a file cannot be written, 2 wrong usage or input.";

/// Particle size distributions: statistics, conversion, fits, samples, plots, and the check of what a run inserted.
#[derive(Debug, Parser)]
#[command(name = "mercury-psd", version, after_help = EXAMPLES, arg_required_else_help = true)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Quantiles, mean diameters, span, specific surface, by number, length, area and volume
    Stats(StatsArguments),
    /// Write a distribution as a table of another type, after cutting, squeezing or scaling it
    Convert(ConvertArguments),
    /// Fit laws by maximum likelihood
    Fit(FitArguments),
    /// Compare two or more distributions or samples with the first
    Compare(CompareArguments),
    /// Draw diameters
    Sample(SampleArguments),
    /// Draw cumulative curves and densities as SVG and PNG
    Plot(PlotArguments),
    /// Test whether the sizes of a run, or of a list, are of a distribution; exit code 1 if not
    Check(CheckArguments),
    /// Print completions for a shell
    Completions {
        /// bash, zsh, fish, elvish or powershell
        shell: Shell,
    },
}

/// How files are read.
#[derive(Debug, Args)]
pub(crate) struct Reading {
    /// Meaning of the sizes of files without header
    #[arg(long, value_name = "WORD", value_parser = words(&SIZES))]
    pub(crate) size: Option<SizeKind>,

    /// The unit of the sizes: m, cm, mm, um or nm
    #[arg(long, value_name = "UNIT", value_parser = unit)]
    pub(crate) unit: Option<f64>,

    /// Meaning of the second column: cumulative|fraction|retained|cumulative-retained, a hyphen, number|length|area|volume|mass
    #[arg(long = "type", value_name = "TYPE", value_parser = table::parse_type)]
    pub(crate) values: Option<(ValueKind, Weighting)>,

    /// Distribution inside a class: number-uniform (default), quantity-uniform or log-uniform of what was measured, or
    /// volume-uniform, ...
    #[arg(long, value_name = "MODEL", value_parser = model)]
    pub(crate) in_class: Option<Model>,

    /// Read like MercuryDPM: negative shares count as 0, all shares are divided by the last, a class is put in front
    #[arg(long, value_name = "CODE")]
    pub(crate) compat: Option<Compat>,
}

/// How the target of a check is read, where that is otherwise than its sizes.
#[derive(Debug, Args)]
pub(crate) struct TargetReading {
    /// Meaning of the sizes of a target without header [default: as --size]
    #[arg(long, value_name = "WORD", value_parser = words(&SIZES), requires = "target")]
    pub(crate) target_size: Option<SizeKind>,

    /// The unit of the target's sizes [default: as --unit]
    #[arg(long, value_name = "UNIT", value_parser = unit, requires = "target")]
    pub(crate) target_unit: Option<f64>,

    /// Meaning of the target's second column [default: as --type]; a list of sizes has none
    #[arg(long, value_name = "TYPE", value_parser = table::parse_type, requires = "target")]
    pub(crate) target_type: Option<(ValueKind, Weighting)>,
}

impl Reading {
    pub(crate) fn options(&self) -> Options {
        Options {
            size: self.size,
            per_metre: self.unit,
            values: self.values,
            model: self.in_class,
            mercury: self.compat.is_some(),
        }
    }
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum Compat {
    /// MercuryDPM
    Mercury,
}

/// Arguments of every command: how its files are read, what is printed.
#[derive(Debug, Args)]
pub(crate) struct Common {
    #[command(flatten)]
    pub(crate) reading: Reading,

    /// Print the result as one JSON object on standard output
    #[arg(long)]
    pub(crate) json: bool,
}

/// How charts look.
#[derive(Debug, Args)]
pub(crate) struct Looking {
    /// Diameters by their logarithm
    #[arg(long)]
    pub(crate) log: bool,

    /// The axis of cumulative shares: normal laws are straight on probability (with --log lognormal ones), with --log Rosin-Rammler laws on rosin-rammler
    #[arg(long, value_name = "AXIS", default_value = "linear", value_parser = words(&AXES))]
    pub(crate) axis: Shares,
}

impl Looking {
    pub(crate) fn look(&self) -> Look {
        Look {
            log: self.log,
            shares: self.axis,
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct StatsArguments {
    /// Tables, lists, laws or runs
    #[arg(value_name = "FILE", required = true)]
    pub(crate) files: Vec<String>,

    /// Further mean diameters D[p,q]
    #[arg(long, value_name = "P,Q", value_parser = pair, allow_negative_numbers = true)]
    pub(crate) mean: Vec<(i32, i32)>,

    #[command(flatten)]
    pub(crate) common: Common,
}

#[derive(Debug, Args)]
#[command(group(ArgGroup::new("reshaping").args(["cut", "squeeze"]).multiple(true)))]
pub(crate) struct ConvertArguments {
    /// A table, list, law or run of one kind of particles
    #[arg(value_name = "FILE")]
    pub(crate) file: String,

    /// Content of the written table [default: what was measured, cumulative]
    #[arg(long, value_name = "TYPE", value_parser = table::parse_type)]
    pub(crate) to: Option<(ValueKind, Weighting)>,

    /// The unit of the sizes to write
    #[arg(long, value_name = "UNIT", default_value = "mm")]
    pub(crate) to_unit: String,

    /// Write radii
    #[arg(long)]
    pub(crate) to_radius: bool,

    /// Write percent
    #[arg(long)]
    pub(crate) percent: bool,

    /// Number of classes into which a law or list is divided
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) classes: u32,

    /// Leave what lies between two quantiles
    #[arg(long, value_name = "LOW,HIGH", value_parser = quantiles)]
    pub(crate) cut: Option<[f64; 2]>,

    /// Bring sizes nearer to the median by this factor
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true, value_parser = positive)]
    pub(crate) squeeze: Option<f64>,

    /// Multiply all sizes
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true, value_parser = positive)]
    pub(crate) scale: Option<f64>,

    /// The weighting of the quantiles of --cut and of the median of --squeeze [default: what was measured]
    #[arg(long, value_name = "QUANTITY", value_parser = words(&QUANTITIES), requires = "reshaping")]
    pub(crate) by: Option<Weighting>,

    /// The file; .toml writes a law as in a scene [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) common: Common,
}

#[derive(Debug, Args)]
pub(crate) struct FitArguments {
    /// A table or a list of sizes
    #[arg(value_name = "FILE")]
    pub(crate) file: String,

    /// Families [default: all]: lognormal, normal, rosin-rammler, ggs, two-lognormal, two-normal, two-rosin-rammler
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub(crate) family: Vec<Family>,

    /// Number of particles in the shares of a table [default: as many as make the best family just probable]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = positive)]
    pub(crate) count: Option<f64>,

    /// Draws of the bootstrap for p-values; 0: none
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=100_000))]
    pub(crate) bootstrap: u32,

    /// 1 - level is the confidence of intervals
    #[arg(long, value_name = "LEVEL", default_value_t = 0.05, allow_negative_numbers = true, value_parser = level)]
    pub(crate) level: f64,

    /// Seed of the bootstrap
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,

    /// Writes NAME.psd.toml (the family of the least BIC), NAME.svg and NAME.png
    #[arg(short, long, value_name = "NAME")]
    pub(crate) output: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) looking: Looking,

    #[command(flatten)]
    pub(crate) common: Common,
}

#[derive(Debug, Args)]
pub(crate) struct CompareArguments {
    /// Two or more tables, lists, laws or runs; the first is the reference
    #[arg(value_name = "FILE", required = true)]
    pub(crate) files: Vec<String>,

    /// 1 - level is the confidence of intervals between samples
    #[arg(long, value_name = "LEVEL", default_value_t = 0.05, allow_negative_numbers = true, value_parser = level)]
    pub(crate) level: f64,

    /// Writes NAME.svg and NAME.png
    #[arg(short, long, value_name = "NAME")]
    pub(crate) output: Option<PathBuf>,

    /// The weighting of the shares in the chart
    #[arg(long, value_name = "QUANTITY", default_value = "volume", value_parser = words(&QUANTITIES))]
    pub(crate) by: Weighting,

    #[command(flatten)]
    pub(crate) looking: Looking,

    #[command(flatten)]
    pub(crate) common: Common,
}

#[derive(Debug, Args)]
pub(crate) struct SampleArguments {
    /// A table or law
    #[arg(value_name = "FILE")]
    pub(crate) file: String,

    /// Number of diameters
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000_000))]
    pub(crate) number: u32,

    /// random: independent; quota: one in each of N classes of equal number
    #[arg(long, value_name = "METHOD", default_value = "random", value_parser = words(&METHODS))]
    pub(crate) method: Method,

    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,

    /// The unit to write
    #[arg(long, value_name = "UNIT", default_value = "m")]
    pub(crate) to_unit: String,

    /// Write radii
    #[arg(long)]
    pub(crate) to_radius: bool,

    /// The file [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) common: Common,
}

#[derive(Debug, Args)]
pub(crate) struct PlotArguments {
    /// Tables, lists, laws or runs
    #[arg(value_name = "FILE", required = true)]
    pub(crate) files: Vec<String>,

    /// Writes NAME.svg and NAME.png
    #[arg(short, long, value_name = "NAME")]
    pub(crate) output: PathBuf,

    /// The weighting of the shares
    #[arg(long, value_name = "QUANTITY", default_value = "volume", value_parser = words(&QUANTITIES))]
    pub(crate) by: Weighting,

    /// Heading
    #[arg(long, value_name = "TEXT", default_value = "")]
    pub(crate) title: String,

    #[command(flatten)]
    pub(crate) looking: Looking,

    #[command(flatten)]
    pub(crate) common: Common,
}

#[derive(Debug, Args)]
pub(crate) struct CheckArguments {
    /// A run folder, or a list of sizes
    #[arg(value_name = "RUN|SIZES")]
    pub(crate) subject: PathBuf,

    /// The distribution that it should be of [default for a run: that of its scene]
    #[arg(long, value_name = "FILE")]
    pub(crate) target: Option<String>,

    /// Only particles of this material or clump
    #[arg(long, value_name = "NAME")]
    pub(crate) of: Option<String>,

    /// Only those in the run at this time in s (the nearest frame) [default: all that were ever inserted]
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub(crate) at: Option<f64>,

    /// Only those in a part of the run: z<0.05 or x>=0,z<0.1 (m)
    #[arg(long = "where", value_name = "CONDITIONS", value_parser = conditions)]
    pub(crate) place: Option<Conditions>,

    #[command(flatten)]
    pub(crate) target_reading: TargetReading,

    /// Instead of a target: those at this other time
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub(crate) versus_at: Option<f64>,

    /// Instead of a target: those in this other part
    #[arg(long, value_name = "CONDITIONS", value_parser = conditions)]
    pub(crate) versus_where: Option<Conditions>,

    /// Instead of a target: this other run or list
    #[arg(long, value_name = "RUN|SIZES", conflicts_with = "target")]
    pub(crate) versus: Option<PathBuf>,

    /// A good sample fails with at most this probability
    #[arg(long, value_name = "LEVEL", default_value_t = 0.01, allow_negative_numbers = true, value_parser = level)]
    pub(crate) level: f64,

    /// Instead of the tests: d10, d50 and d90 by number and volume may be off by this share
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true, value_parser = positive)]
    pub(crate) tolerance: Option<f64>,

    /// Writes NAME.svg and NAME.png; for several kinds of particles NAME.KIND.svg ...
    #[arg(short, long, value_name = "NAME")]
    pub(crate) output: Option<PathBuf>,

    /// Seed of the random curves behind the band of volumes
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,

    #[command(flatten)]
    pub(crate) looking: Looking,

    #[command(flatten)]
    pub(crate) common: Common,
}

impl CheckArguments {
    /// How lists are read: they have sizes alone, --type is the target's.
    pub(crate) fn of_lists(&self) -> Options {
        Options {
            values: None,
            ..self.common.reading.options()
        }
    }

    /// How the target is read.
    pub(crate) fn of_target(&self) -> Options {
        let of = &self.target_reading;
        let options = self.common.reading.options();
        Options {
            size: of.target_size.or(options.size),
            per_metre: of.target_unit.or(options.per_metre),
            values: of.target_type.or(options.values),
            ..options
        }
    }
}

const SIZES: [(&str, SizeKind); 3] = [
    ("diameter", SizeKind::Diameter),
    ("radius", SizeKind::Radius),
    ("sieve", SizeKind::Sieve),
];
const QUANTITIES: [(&str, Weighting); 4] = [
    ("number", Weighting::Number),
    ("length", Weighting::Length),
    ("area", Weighting::Area),
    ("volume", Weighting::Volume),
];
const METHODS: [(&str, Method); 2] = [("random", Method::Random), ("quota", Method::Quota)];
const AXES: [(&str, Shares); 3] = [
    ("linear", Shares::Linear),
    ("probability", Shares::Probability),
    ("rosin-rammler", Shares::RosinRammler),
];

/// One of these words; help and completions list them.
fn words<T: Copy + Send + Sync>(
    known: &'static [(&'static str, T)],
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(known.iter().map(|(word, _)| *word)).try_map(move |word| {
        let found = known.iter().find(|(name, _)| *name == word);
        found.map(|(_, value)| *value).ok_or("an unknown word")
    })
}

/// A list that clap takes as one value.
#[derive(Debug, Clone)]
pub(crate) struct Conditions {
    pub(crate) all: Vec<Condition>,
    /// Conditions as typed.
    pub(crate) text: String,
}

fn conditions(text: &str) -> Result<Conditions, String> {
    Condition::parse_all(text).map(|all| Conditions {
        all,
        text: text.to_owned(),
    })
}

fn unit(text: &str) -> Result<f64, String> {
    table::parse_size_unit(text).ok_or_else(|| "expected m, cm, mm, um or nm".to_owned())
}

fn model(text: &str) -> Result<Model, String> {
    match text {
        "quantity-uniform" => Ok(Model::UniformInMeasured),
        "log-uniform" => Ok(Model::LogUniformInMeasured),
        _ => ClassModel::from_word(text).map(Model::Of).ok_or_else(|| {
            let words: Vec<&str> = ClassModel::all().map(|(word, _)| word).collect();
            format!(
                "expected quantity-uniform, log-uniform or one of {}",
                words.join(", ")
            )
        }),
    }
}

fn pair(text: &str) -> Result<(i32, i32), String> {
    let wrong = || "expected two different whole numbers from -6 to 6, such as 3,2".to_owned();
    let (p, q) = text.split_once(',').ok_or_else(wrong)?;
    let number = |text: &str| {
        text.trim()
            .parse::<i32>()
            .ok()
            .filter(|n| (-6..=6).contains(n))
    };
    match (number(p), number(q)) {
        (Some(p), Some(q)) if p != q => Ok((p, q)),
        _ => Err(wrong()),
    }
}

fn quantiles(text: &str) -> Result<[f64; 2], String> {
    let wrong = || "expected two quantiles 0 <= LOW < HIGH <= 1, such as 0.01,0.99".to_owned();
    let (low, high) = text.split_once(',').ok_or_else(wrong)?;
    match (low.trim().parse::<f64>(), high.trim().parse::<f64>()) {
        (Ok(low), Ok(high)) if 0.0 <= low && low < high && high <= 1.0 => Ok([low, high]),
        _ => Err(wrong()),
    }
}

fn level(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(level) if level > 0.0 && level < 1.0 => Ok(level),
        _ => Err("expected a probability between 0 and 1, such as 0.01".to_owned()),
    }
}
