//! `mclump`: the command line, nothing else.

mod arguments;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use arguments::{Arguments, MethodName, Protrusion, RouteName};
use mclump::clump::{Input, Options, build, implausible_size, scaled_mesh, scaled_pebbles};
use mclump::descriptors;
use mclump::fidelity::{self, Fidelity};
use mclump::generate::{
    Euclidean, GenerateError, Method, Request, Stop, Tangent, generate, generate_of_volume,
};
use mclump::inertia::comparison::{Route, Settings, row};
use mclump::output::{check_free, contents, paths, with_suffix, write};
use mclump::sizes::{self, SizeProblem};
use mclump::surface::{Prepared, inspect, prepare};
use mclump::table;
use mercury_common::cli::{self, Failure, Outcome, Progress, say};
use mercury_common::error::FormatError;
use mercury_common::formats::clump::{Pebble, Remark};
use mercury_common::formats::mesh::{TriangleMesh, read_mesh};
use mercury_common::formats::pebble_list::read_pebble_list;
use mercury_common::readable::rounded;
use sha2::{Digest as _, Sha256};

/// Surfaces of more triangles are described on request only: it takes a minute at a million.
const MOST_DESCRIBED: usize = 100_000;

const NO_PEBBLES: &str =
    "no clump is written without pebbles: give a pebble list, or --generate tangent --pebbles 100";

fn main() -> ExitCode {
    cli::main(|arguments: Arguments| execute(&arguments))
}

fn execute(arguments: &Arguments) -> Outcome {
    if let Some(shell) = arguments.completions {
        return cli::say_completions::<Arguments>(shell);
    }
    let Files { surface, pebbles } = sort_files(&arguments.files)?;
    let main = pebbles.or(surface).unwrap_or(Path::new(""));
    let name = clump_name(arguments.output.as_deref(), surface.unwrap_or(main));
    let output = match &arguments.output {
        Some(path) => with_suffix(path),
        None => format!("{name}.clump.toml").into(),
    };
    let makes_clump = pebbles.is_some() || arguments.generate.is_some();
    if pebbles.is_some() && arguments.generate.is_some() {
        return Err(Failure::input(
            "--generate makes the pebbles: give the surface alone, without a pebble list",
        ));
    }
    if arguments.generate.is_some() && surface.is_none() {
        return Err(Failure::input(
            "--generate needs a surface: give an STL or OBJ file",
        ));
    }
    let mut progress = Progress::new(arguments.quiet);
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
    let listed = match pebbles {
        Some(path) => {
            source.push(("pebbles".to_owned(), described(path)?));
            Some(read_pebbles(path, arguments.scale)?)
        }
        None => None,
    };
    // Now that the input is known to be good, and before the work begins.
    let files = paths(&output, surface.is_some(), !arguments.no_picture);
    check_free(&files, arguments.force).map_err(Failure::input)?;
    let pebbles = match listed {
        Some(pebbles) => pebbles,
        None => {
            let mesh = prepared.as_ref().map(|prepared| &prepared.mesh);
            generated(arguments, mesh, &mut source, &mut progress)?
        }
    };
    progress.stage("integrating");
    let options = Options {
        density: arguments.density,
        route: arguments.inertia.map(route),
        settings: settings(arguments),
        source,
        checks: Vec::new(),
        generated: arguments.generate.is_some(),
    };
    let fidelity = prepared
        .as_ref()
        .map(|surface| fidelity::compare(&surface.mesh, &pebbles));
    let options = Options {
        checks: fidelity.iter().map(fidelity_check).collect(),
        ..options
    };
    let input = Input {
        name,
        surface: prepared,
        pebbles,
    };
    let mut built = build(&input, &options).map_err(Failure::input)?;
    // The size with which the solver scales clumps.
    let diameter = (6.0 * built.file.volume / std::f64::consts::PI).cbrt();
    (built.file.checks).push(("equal_volume_diameter".into(), diameter.into()));
    progress.stage("writing");
    let files = contents(&built, &output, !arguments.no_picture).map_err(Failure::run)?;
    write(&files).map_err(Failure::run)?;
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
        "{}: {} pebbles, density {} kg/m3, equal-volume diameter {} m\n",
        built.file.name,
        built.file.pebbles.len(),
        arguments.density,
        rounded(diameter, 7)
    );
    text += &table::routes(&built.rows, Some(built.route), arguments.density);
    match &fidelity {
        Some(Ok(fidelity)) => {
            text += &format!("pebbles against the surface:\n{}\n", indented(fidelity));
        }
        Some(Err(error)) => {
            text += &format!("warning: pebbles and surface were not compared: {error}\n");
        }
        None => {}
    }
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

/// Surface and pebbles among the files, by their names.
fn sort_files(files: &[PathBuf]) -> Result<Files<'_>, Failure> {
    let is_surface = |path: &&PathBuf| {
        path.extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("stl") || e.eq_ignore_ascii_case("obj"))
    };
    let surfaces: Vec<&PathBuf> = files.iter().filter(is_surface).collect();
    let lists: Vec<&PathBuf> = files.iter().filter(|path| !is_surface(path)).collect();
    if surfaces.len() > 1 || lists.len() > 1 {
        return Err(Failure::input(format!(
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
        Failure::input(format!(
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

/// Reads and scales a pebble list; lengths that cannot be computed with are refused with their line.
fn read_pebbles(path: &Path, scale: f64) -> Result<Vec<Pebble>, Failure> {
    let list = read_pebble_list(path).map_err(Failure::input)?;
    let pebbles = scaled_pebbles(&list, scale);
    let Some(problem) = sizes::pebble_problem(&pebbles) else {
        return Ok(pebbles);
    };
    let text = std::fs::read_to_string(path).map_err(Failure::input)?;
    let line = (problem.pebble).and_then(|index| sizes::line_of_pebble(path, &text, index));
    Err(Failure::input(FormatError {
        line,
        ..size_error(path, problem, scale)
    }))
}

fn size_error(path: &Path, problem: SizeProblem, scale: f64) -> FormatError {
    let scaled = if scale == 1.0 {
        String::new()
    } else {
        format!(" (with --scale {scale:e})")
    };
    FormatError {
        expected: problem.expected,
        ..FormatError::of_file(path, problem.found + &scaled).with_help(problem.help)
    }
}

/// Reads, scales and checks the surface. One that is only looked at may be open.
fn prepared_surface(arguments: &Arguments, path: &Path, needed: bool) -> Result<Prepared, Failure> {
    let mesh = scaled_mesh(read_mesh(path).map_err(Failure::input)?, arguments.scale);
    if let Some(problem) = sizes::surface_problem(&mesh) {
        return Err(Failure::input(size_error(path, problem, arguments.scale)));
    }
    let of_other = !needed && !arguments.repair;
    match prepare(mesh, arguments.repair) {
        Ok(prepared) => Ok(prepared),
        Err(error) if of_other => {
            let mesh = scaled_mesh(read_mesh(path).map_err(Failure::input)?, arguments.scale);
            let report = inspect(&mesh);
            Err(Failure::input(format!(
                "{}:\n{report}\n{error}",
                path.display()
            )))
        }
        Err(error) => Err(Failure::input(format!("{}: {error}", path.display()))),
    }
}

/// For `[checks]`: lengths in m, the rest relative.
fn fidelity_check(fidelity: &Result<Fidelity, GenerateError>) -> (String, Remark) {
    let numbers = |values: [f64; 3]| Remark::List(values.map(Remark::Number).to_vec());
    let value = match fidelity {
        Ok(fidelity) => Remark::Table(vec![
            ("volume_error".into(), fidelity.volume_error.into()),
            ("moment_errors".into(), numbers(fidelity.moment_errors)),
            ("centre_shift".into(), fidelity.centre_shift.into()),
            ("mean_distance".into(), fidelity.mean_distance.into()),
            ("largest_distance".into(), fidelity.largest_distance.into()),
            ("protrusion".into(), fidelity.protrusion.into()),
        ]),
        Err(error) => error.to_string().into(),
    };
    ("fidelity".to_owned(), value)
}

fn indented(text: &impl std::fmt::Display) -> String {
    let lines: Vec<String> = text
        .to_string()
        .lines()
        .map(|line| format!("  {line}"))
        .collect();
    lines.join("\n")
}

/// A surface without pebbles: what it is like, its mass properties; nothing is written.
fn look(arguments: &Arguments, prepared: Option<&Prepared>) -> Outcome {
    let Some(prepared) = prepared else {
        return Err(Failure::input("a surface or a pebble list is needed"));
    };
    let rows: Vec<_> = row(
        Route::Surface,
        Some(&prepared.mesh),
        &[],
        &settings(arguments),
    )
    .into_iter()
    .collect();
    let size = (prepared.mesh.bounds()).map(|(low, high)| (high - low).max_element());
    let mut warnings = prepared.warnings.clone();
    warnings.extend(size.and_then(implausible_size));
    if arguments.json {
        let mut found = table::routes_json(&rows, arguments.density);
        found["warnings"] = warnings.into();
        return say(&pretty(&found)?);
    }
    let mut text = surface_text(prepared);
    text += &table::routes(&rows, None, arguments.density);
    for warning in &warnings {
        text += &format!("warning: {warning}\n");
    }
    let triangles = prepared.mesh.triangles.len();
    if triangles > MOST_DESCRIBED && !arguments.shape {
        text += &format!(
            "shape: not described, which takes long for {triangles} triangles; --shape does it\n"
        );
        text += NO_PEBBLES;
        return say(&text);
    }
    match descriptors::describe(&prepared.mesh) {
        Ok(shape) => text += &format!("shape:\n{}\n", indented(&shape)),
        Err(error) => text += &format!("shape: not described, {error}\n"),
    }
    text += NO_PEBBLES;
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
    progress: &mut Progress,
) -> Result<Vec<Pebble>, Failure> {
    let (Some(mesh), Some(method)) = (mesh, arguments.generate) else {
        return Err(Failure::input("--generate needs a surface"));
    };
    let request = Request {
        method: match method {
            MethodName::Euclidean => Method::Euclidean(Euclidean::default()),
            MethodName::Tangent => Method::Tangent(Tangent::default()),
            MethodName::Favier => Method::Favier,
        },
        stop: Stop {
            pebbles: arguments.pebbles.map(|n| n as usize),
            volume_error: arguments.fidelity,
        },
        smallest_radius: arguments.smallest_radius.unwrap_or(0.0),
        protrusion: match arguments.protrusion {
            Some(Protrusion::Length(length)) => length,
            Some(Protrusion::Auto) | None => 0.0,
        },
        seed: arguments.seed,
    };
    let word = format!("{method:?}").to_lowercase();
    let mut entries: Vec<(String, Remark)> = vec![("method".into(), word.into())];
    if let Some(number) = arguments.pebbles {
        entries.push(("pebbles".into(), Remark::Whole(number.into())));
    }
    if let Some(fidelity) = arguments.fidelity {
        entries.push(("volume_error".into(), fidelity.into()));
    }
    let is_auto = arguments.protrusion == Some(Protrusion::Auto);
    if is_auto && (arguments.pebbles.is_none() || arguments.fidelity.is_some()) {
        return Err(Failure::input(
            "--protrusion auto makes the volume right for any number of pebbles",
        )
        .with_help("give the number (--pebbles), and no --fidelity"));
    }
    progress.stage("making pebbles");
    let mut tell = |done, total: usize| {
        progress.count("making pebbles:", done, (total > 0).then_some(total));
    };
    let (pebbles, protrusion) = if is_auto {
        generate_of_volume(mesh, &request, &mut tell).map_err(Failure::input)?
    } else {
        let pebbles = generate(mesh, &request, &mut tell).map_err(Failure::input)?;
        (pebbles, request.protrusion)
    };
    if arguments.protrusion.is_some() {
        entries.push(("protrusion".into(), protrusion.into()));
    }
    let seed = i64::try_from(arguments.seed).unwrap_or(i64::MAX);
    entries.push(("seed".into(), Remark::Whole(seed)));
    source.push(("generator".to_owned(), Remark::Table(entries)));
    Ok(pebbles)
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

fn pretty(value: &serde_json::Value) -> Result<String, Failure> {
    serde_json::to_string_pretty(value).map_err(Failure::run)
}
