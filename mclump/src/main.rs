//! `mclump`: the command line, nothing else.

use std::io::{IsTerminal as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::{CommandFactory as _, Parser, ValueEnum};
use clap_complete::Shell;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use mclump::clump::{Input, Options, build, scaled_mesh, scaled_pebbles};
use mclump::generate::{Euclidean, Favier, Method, Request, Stop, Tangent, generate};
use mclump::inertia::comparison::{Route, Settings, row};
use mclump::output::{check_free, contents, paths, write};
use mclump::surface::{Prepared, inspect, prepare};
use mclump::table;
use mercury_common::formats::clump::{Pebble, Remark};
use mercury_common::formats::mesh::{TriangleMesh, read_mesh};
use mercury_common::formats::pebble_list::read_pebble_list;
use sha2::{Digest as _, Sha256};

const EXAMPLES: &str = "\
Examples:
  mclump rod.csv --density 2500                       pebbles x,y,z,r; writes rod.clump.toml
  mclump rod.csv --inertia union                      overlaps of pebbles count once
  mclump celt.stl celt.csv --scale 1e-3               files in mm; inertia from the surface
  mclump celt.stl --generate tangent --pebbles 100    pebbles made for the surface
  mclump celt.stl                                     look at the surface; no clump is written
  mclump celt.stl celt.csv --repair --json            close small holes; result as JSON, for scripts

Files: NAME.clump.toml, NAME.pebbles.csv, NAME.pebbles.vtu and with a surface NAME.surface.stl, NAME.surface.vtu.
Exit codes: 0 done, 1 the clump cannot be made or written, 2 wrong usage or input.";

/// Makes a rigid clump from a surface and pebbles: mass, centre, inertia, principal axes.
#[derive(Debug, Parser)]
#[command(name = "mclump", version, after_help = EXAMPLES)]
struct Arguments {
    /// A surface (.stl, .obj), a pebble list (x,y,z,r per line), or both
    #[arg(value_name = "FILE", required_unless_present = "completions", num_args = 1..=2)]
    files: Vec<PathBuf>,

    /// The clump file [default: NAME.clump.toml in this folder]
    #[arg(short, long, value_name = "NAME.clump.toml")]
    output: Option<PathBuf>,

    /// Where mass, centre and inertia come from [default: surface; without one pebbles, or union where they overlap]
    #[arg(long, value_name = "ROUTE")]
    inertia: Option<RouteName>,

    /// Density in kg/m3
    #[arg(long, value_name = "RHO", default_value_t = 1.0, value_parser = positive)]
    density: f64,

    /// Length in m of one unit of the files: 1e-3 for files in mm
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = positive)]
    scale: f64,

    /// Make pebbles for the surface
    #[arg(long, value_name = "METHOD")]
    generate: Option<MethodName>,

    /// How many pebbles to make
    #[arg(long, value_name = "N", requires = "generate", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pebbles: Option<u32>,

    /// Make pebbles until the volume of their union differs from the surface's by at most this fraction
    #[arg(long, value_name = "FRACTION", requires = "generate", value_parser = positive)]
    fidelity: Option<f64>,

    /// No pebble smaller than this radius in m [default: 1/1000 of the body]
    #[arg(long, value_name = "M", requires = "generate", value_parser = positive)]
    smallest_radius: Option<f64>,

    /// Seed of the generator's random points
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,

    /// Mend the surface: weld vertices, drop doubled triangles, turn inconsistent ones, close small holes
    #[arg(long)]
    repair: bool,

    /// Voxels along the longest edge
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=2000))]
    voxels: u32,

    /// Refine the voxels to this relative accuracy
    #[arg(long, value_name = "FRACTION", value_parser = positive)]
    voxel_tolerance: Option<f64>,

    /// Replace files that are there already
    #[arg(long)]
    force: bool,

    /// No report, only errors
    #[arg(long)]
    quiet: bool,

    /// Print the result as one JSON object on standard output
    #[arg(long)]
    json: bool,

    /// Print completions for a shell and stop
    #[arg(long, value_name = "SHELL")]
    completions: Option<Shell>,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum RouteName {
    /// Signed tetrahedra of the surface
    Surface,
    /// The space that the pebbles cover
    Union,
    /// The same by voxels
    Voxels,
    /// Every pebble for itself
    Pebbles,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum MethodName {
    /// Largest balls by the distance to the surface
    Euclidean,
    /// Balls tangent to the surface, chosen for the volume they add
    Tangent,
    /// One ball per slab, for bodies of revolution
    Favier,
}

/// Why there is no success: the exit code, and what to say.
enum Failure {
    /// Wrong usage or input.
    Input(String),
    /// It cannot be done.
    Run(String),
}

fn input_failure(error: impl std::fmt::Display) -> Failure {
    Failure::Input(error.to_string())
}

fn main() -> ExitCode {
    match execute(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            let (code, message) = match failure {
                Failure::Input(message) => (2, message),
                Failure::Run(message) => (1, message),
            };
            // Whoever closed standard error does not want to know; the exit code tells.
            let _ = writeln!(std::io::stderr(), "{message}");
            ExitCode::from(code)
        }
    }
}

fn execute(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(shell) = arguments.completions {
        let mut out = Vec::new();
        clap_complete::generate(shell, &mut Arguments::command(), "mclump", &mut out);
        return say(&String::from_utf8_lossy(&out));
    }
    let Files { surface, pebbles } = sort_files(&arguments.files)?;
    let main = pebbles.or(surface).unwrap_or(Path::new(""));
    let name = clump_name(arguments.output.as_deref(), surface.unwrap_or(main));
    let output = (arguments.output.clone()).unwrap_or_else(|| format!("{name}.clump.toml").into());
    let makes_clump = pebbles.is_some() || arguments.generate.is_some();
    if pebbles.is_some() && arguments.generate.is_some() {
        return Err(Failure::Input(
            "--generate makes the pebbles: give the surface alone, without a pebble list".into(),
        ));
    }
    if arguments.generate.is_some() && surface.is_none() {
        return Err(Failure::Input(
            "--generate needs a surface: give an STL or OBJ file".into(),
        ));
    }
    if makes_clump {
        check_free(&paths(&output, surface.is_some()), arguments.force).map_err(input_failure)?;
    }
    let progress = Progress::new(arguments.quiet);
    let mut source = Vec::new();
    let prepared = match surface {
        Some(path) => {
            progress.stage("reading the surface");
            source.push(("surface".to_owned(), described(path)?));
            Some(prepared_surface(arguments, path, makes_clump)?)
        }
        None => None,
    };
    if !makes_clump {
        progress.clear();
        return look(arguments, prepared.as_ref());
    }
    source.push(("scale".to_owned(), arguments.scale.into()));
    let pebbles = match pebbles {
        Some(path) => {
            source.push(("pebbles".to_owned(), described(path)?));
            let list = read_pebble_list(path).map_err(input_failure)?;
            scaled_pebbles(&list, arguments.scale)
        }
        None => {
            let mesh = prepared.as_ref().map(|prepared| &prepared.mesh);
            generated(arguments, mesh, &mut source, &progress)?
        }
    };
    progress.stage("integrating");
    let options = Options {
        density: arguments.density,
        route: arguments.inertia.map(route),
        settings: settings(arguments),
        source,
        checks: Vec::new(),
    };
    let input = Input {
        name,
        surface: prepared,
        pebbles,
    };
    let built = build(&input, &options).map_err(input_failure)?;
    progress.stage("writing");
    let files = contents(&built, &output).map_err(|error| Failure::Run(error.to_string()))?;
    write(&files).map_err(|error| Failure::Run(error.to_string()))?;
    progress.clear();
    let written: Vec<PathBuf> = files.into_iter().map(|file| file.path).collect();
    if arguments.json {
        return say(&pretty(&table::json(&built, &written))?);
    }
    if arguments.quiet {
        return Ok(());
    }
    let mut text = String::new();
    if let Some(surface) = &input.surface {
        text += &surface_text(surface);
    }
    text += &format!(
        "{}: {} pebbles, density {} kg/m3\n",
        built.file.name,
        built.file.pebbles.len(),
        arguments.density
    );
    text += &table::routes(&built.rows, Some(built.route), arguments.density);
    for warning in &built.warnings {
        text += &format!("warning: {warning}\n");
    }
    let names: Vec<String> = written
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    text += &format!("written: {}", names.join(", "));
    say(&text)
}

struct Files<'a> {
    surface: Option<&'a Path>,
    pebbles: Option<&'a Path>,
}

/// Which file is the surface and which the pebbles, by their names.
fn sort_files(files: &[PathBuf]) -> Result<Files<'_>, Failure> {
    let is_surface = |path: &&PathBuf| {
        path.extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("stl") || e.eq_ignore_ascii_case("obj"))
    };
    let surfaces: Vec<&PathBuf> = files.iter().filter(is_surface).collect();
    let lists: Vec<&PathBuf> = files.iter().filter(|path| !is_surface(path)).collect();
    if surfaces.len() > 1 || lists.len() > 1 {
        return Err(Failure::Input(format!(
            "{} and {} are both {}: give one surface (.stl, .obj), one pebble list, or one of each",
            files[0].display(),
            files[1].display(),
            if lists.is_empty() {
                "surfaces"
            } else {
                "taken for pebble lists"
            }
        )));
    }
    Ok(Files {
        surface: surfaces.first().map(|path| path.as_path()),
        pebbles: lists.first().map(|path| path.as_path()),
    })
}

/// The name of the output without its endings, or the stem of the main input.
fn clump_name(output: Option<&Path>, input: &Path) -> String {
    let text = |name: &std::ffi::OsStr| name.to_string_lossy().into_owned();
    match output.and_then(Path::file_name).map(text) {
        Some(name) => name
            .strip_suffix(".clump.toml")
            .or_else(|| name.strip_suffix(".toml"))
            .unwrap_or(&name)
            .to_owned(),
        None => input.file_stem().map_or("clump".to_owned(), text),
    }
}

/// The file and its hash, for `[source]`.
fn described(path: &Path) -> Result<Remark, Failure> {
    let unreadable = |error| {
        Failure::Input(format!(
            "{}: the file cannot be read: {error}",
            path.display()
        ))
    };
    let mut file = std::fs::File::open(path).map_err(unreadable)?;
    let mut hash = Sha256::new();
    let mut block = vec![0; 1 << 16];
    loop {
        match std::io::Read::read(&mut file, &mut block).map_err(unreadable)? {
            0 => break,
            n => hash.update(&block[..n]),
        }
    }
    let digits: String = hash
        .finalize()
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    let name = path
        .file_name()
        .map_or(String::new(), |name| name.to_string_lossy().into_owned());
    Ok(Remark::Table(vec![
        ("file".into(), name.into()),
        ("sha256".into(), digits.into()),
    ]))
}

/// Reads, scales and checks the surface. One that is only looked at may be open.
fn prepared_surface(arguments: &Arguments, path: &Path, needed: bool) -> Result<Prepared, Failure> {
    let mesh = scaled_mesh(read_mesh(path).map_err(input_failure)?, arguments.scale);
    let of_other = !needed && !arguments.repair;
    match prepare(mesh, arguments.repair) {
        Ok(prepared) => Ok(prepared),
        Err(error) if of_other => {
            let mesh = scaled_mesh(read_mesh(path).map_err(input_failure)?, arguments.scale);
            let report = inspect(&mesh);
            Err(Failure::Input(format!(
                "{}:\n{report}\n{error}",
                path.display()
            )))
        }
        Err(error) => Err(Failure::Input(format!("{}: {error}", path.display()))),
    }
}

/// A surface without pebbles: what it is like, its mass properties; nothing is written.
fn look(arguments: &Arguments, prepared: Option<&Prepared>) -> Result<(), Failure> {
    let Some(prepared) = prepared else {
        return Err(Failure::Input(
            "a surface or a pebble list is needed".into(),
        ));
    };
    let rows: Vec<_> = row(
        Route::Surface,
        Some(&prepared.mesh),
        &[],
        &settings(arguments),
    )
    .into_iter()
    .collect();
    if arguments.json {
        return say(&pretty(&table::routes_json(&rows, arguments.density))?);
    }
    let mut text = surface_text(prepared);
    text += &table::routes(&rows, None, arguments.density);
    for warning in &prepared.warnings {
        text += &format!("warning: {warning}\n");
    }
    text += "no clump is written without pebbles: give a pebble list, or --generate tangent --pebbles 100";
    say(&text)
}

fn surface_text(surface: &Prepared) -> String {
    let mut text = format!("{}\n", surface.report);
    for done in &surface.done {
        text += &format!("done: {done}\n");
    }
    text
}

fn generated(
    arguments: &Arguments,
    mesh: Option<&TriangleMesh>,
    source: &mut Vec<(String, Remark)>,
    progress: &Progress,
) -> Result<Vec<Pebble>, Failure> {
    let (Some(mesh), Some(method)) = (mesh, arguments.generate) else {
        return Err(Failure::Input("--generate needs a surface".into()));
    };
    let request = Request {
        method: match method {
            MethodName::Euclidean => Method::Euclidean(Euclidean::default()),
            MethodName::Tangent => Method::Tangent(Tangent::default()),
            MethodName::Favier => Method::Favier(Favier::default()),
        },
        stop: Stop {
            pebbles: arguments.pebbles.map(|n| n as usize),
            volume_error: arguments.fidelity,
        },
        smallest_radius: arguments.smallest_radius.unwrap_or(0.0),
        seed: arguments.seed,
        ..Request::default()
    };
    let word = format!("{method:?}").to_lowercase();
    let mut entries: Vec<(String, Remark)> = vec![("method".into(), word.into())];
    if let Some(number) = arguments.pebbles {
        entries.push(("pebbles".into(), Remark::Whole(number.into())));
    }
    if let Some(fidelity) = arguments.fidelity {
        entries.push(("volume_error".into(), fidelity.into()));
    }
    let seed = i64::try_from(arguments.seed).unwrap_or(i64::MAX);
    entries.push(("seed".into(), Remark::Whole(seed)));
    source.push(("generator".to_owned(), Remark::Table(entries)));
    progress.stage("making pebbles");
    generate(mesh, &request, &mut |done, total| {
        progress.count(done, total)
    })
    .map_err(input_failure)
}

fn settings(arguments: &Arguments) -> Settings {
    Settings {
        voxels: arguments.voxels,
        voxel_tolerance: arguments.voxel_tolerance,
        ..Settings::default()
    }
}

fn route(name: RouteName) -> Route {
    match name {
        RouteName::Surface => Route::Surface,
        RouteName::Union => Route::Union,
        RouteName::Voxels => Route::Voxels,
        RouteName::Pebbles => Route::Pebbles,
    }
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("expected a number above 0".to_owned()),
    }
}

/// A line on a terminal that says what is going on; it appears after a second.
struct Progress(Option<ProgressBar>);

impl Progress {
    fn new(quiet: bool) -> Self {
        if quiet || !std::io::stderr().is_terminal() {
            return Self(None);
        }
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
        let style = ProgressStyle::with_template("{spinner} {msg} ({elapsed})");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
        bar.enable_steady_tick(Duration::from_secs(1));
        Self(Some(bar))
    }

    fn stage(&self, what: &'static str) {
        if let Some(bar) = &self.0 {
            bar.set_message(what);
        }
    }

    fn count(&self, done: usize, total: usize) {
        if let Some(bar) = &self.0 {
            bar.set_message(match total {
                0 => format!("making pebbles: {done}"),
                _ => format!("making pebbles: {done} of {total}"),
            });
        }
    }

    fn clear(&self) {
        if let Some(bar) = &self.0 {
            bar.finish_and_clear();
        }
    }
}

fn pretty(value: &serde_json::Value) -> Result<String, Failure> {
    serde_json::to_string_pretty(value).map_err(|error| Failure::Run(error.to_string()))
}

/// Prints on standard output. A reader that has gone away (`| head`) is no failure.
fn say(text: &str) -> Result<(), Failure> {
    match writeln!(std::io::stdout(), "{}", text.trim_end()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::Run(format!("standard output: {error}")))
        }
        _ => Ok(()),
    }
}
