//! Numbers of a run by name: `torque = "mean(walls.drum.ty, 1..2)"`.
//!
//! The requested results are checked against the plan before a run ([`NamedResult::check`]), and read from the files of the run
//! when it is over, with their errors where one run has them.

mod estimate;
mod until;
mod values;

use until::slack;
pub use until::{Aims, Wanted, requested};

use std::fs;
use std::io;
use std::path::Path;

use crate::output::summary::ResultValue;
use crate::output::{counted_materials, particle_columns};
use crate::plan::Plan;
use estimate::{Course, Measured};
use mercury_common::frames::{ParticleColumns, ParticleFrame, Table as _};
use mercury_common::particle_properties::{LIQUID_VOLUME, PARTICLE_PROPERTIES};
use mercury_common::run_tables::{ENERGIES, FLUX, REGIONS, Role, TRACK, TableSpec, WALLS};
use mercury_common::scene::{listed, nearest};
use values::{Row, energies, gravity, particles, rows, slope, slope_note, turning};

/// Function of the values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Function {
    Mean,
    Std,
    Min,
    Max,
    First,
    Last,
    Sum,
    Rate,
    Ratio,
    Tilt,
    Slope,
}

const FUNCTIONS: [(&str, Function); 11] = [
    ("mean", Function::Mean),
    ("std", Function::Std),
    ("min", Function::Min),
    ("max", Function::Max),
    ("first", Function::First),
    ("last", Function::Last),
    ("sum", Function::Sum),
    ("rate", Function::Rate),
    ("ratio", Function::Ratio),
    ("tilt", Function::Tilt),
    ("slope", Function::Slope),
];

const SOURCES: [&str; 6] = ["walls", "regions", "flux", "track", "energy", "particles"];

/// Tables with a row for each name and time, by the names of the sources.
static TABLES: [&TableSpec; 4] = [&WALLS, &REGIONS, &FLUX, &TRACK];

/// The table of a source.
fn table(source: &str) -> Option<&'static TableSpec> {
    TABLES.into_iter().find(|table| table.name() == source)
}

/// Whether rows of a name are material by material.
fn has_materials(table: &TableSpec) -> bool {
    table.column("material").is_some()
}

/// Where the values stand.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Source {
    /// Rows of this name (and material).
    Rows {
        table: &'static TableSpec,
        name: String,
        material: Option<String>,
        column: String,
    },
    /// `.ene`.
    Energy { column: String },
    /// The last frame, without what is fixed.
    Particles { column: String },
}

/// Times whose rows count.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Window {
    /// From and until, s.
    times: (f64, f64),
    /// From the time behind which the scene schedules nothing any more, less the start-up that the rows show.
    is_steady: bool,
}

impl Window {
    const ALL: Self = Self {
        times: (f64::NEG_INFINITY, f64::INFINITY),
        is_steady: false,
    };
}

/// A number to report of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedResult {
    /// Its name, that of its column.
    pub name: String,
    text: String,
    function: Function,
    source: Source,
    /// Denominator of a ratio.
    over: Option<Source>,
    window: Window,
}

/// Why a file of a finished run cannot be read, and what to do.
pub(crate) fn lost(path: &Path, error: &io::Error) -> String {
    let help = match error.kind() {
        io::ErrorKind::NotFound => {
            "; if the scene writes it, remove the folder of the run and give the command again: the run is made anew"
        }
        _ => "",
    };
    format!("{} cannot be read: {error}{help}", path.display())
}

impl NamedResult {
    /// Reads `FUNCTION(SOURCE.NAME.COLUMN, FROM..TO)`.
    ///
    /// # Errors
    /// The name or the text is not valid.
    pub fn new(name: &str, text: &str) -> Result<Self, String> {
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if name.is_empty() || name.len() > 60 || !name.chars().all(plain) {
            return Err(format!(
                "`{name}` cannot be the name of a column: letters, digits, _ and -"
            ));
        }
        let wrong = || {
            format!(
                "`{text}` is no result: expected FUNCTION(SOURCE.COLUMN), as in mean(walls.drum.ty, 1..2) or max(particles.z)"
            )
        };
        let (function, rest) = text.trim().split_once('(').ok_or_else(wrong)?;
        let inside = rest.trim_end().strip_suffix(')').ok_or_else(wrong)?;
        let function = one_of(
            "function",
            function.trim(),
            &FUNCTIONS.map(|(name, _)| name),
        )?;
        let function = FUNCTIONS[function].1;
        let (path, mut rest) = steps(inside);
        let read = |path: &[String]| {
            source(path, function).map_err(|problem| match in_quotes(path) {
                Some(quoted) => format!(
                    "{problem}\nhelp: write names with dots in quotes: '{name}={}'",
                    text.trim().replace(&path.join("."), &quoted)
                ),
                None => problem,
            })
        };
        let source = read(&path)?;
        let mut over = None;
        if function == Function::Ratio {
            // Times where the second column should be.
            let both = rest.filter(|rest| self::window(rest).is_err()).ok_or(
                "a ratio is that of two columns of one table: ratio(walls.lid.fx, walls.lid.fz, 1..)",
            )?;
            let (path, window) = steps(both);
            let below = read(&path)?;
            if !is_one_table(&source, &below) {
                return Err("a ratio is that of two columns of one table".to_owned());
            }
            (over, rest) = (Some(below), window);
        }
        let window = rest.map_or(Ok(Window::ALL), self::window)?;
        if matches!(source, Source::Particles { .. }) && window != Window::ALL {
            return Err("particles are those of the last frame: no times go with them".to_owned());
        }
        Ok(Self {
            name: name.to_owned(),
            text: text.trim().to_owned(),
            function,
            source,
            over,
            window,
        })
    }

    /// Reads `NAME=WHAT`, as `--result` has it.
    ///
    /// # Errors
    /// The text is not of the form `NAME=FUNCTION(SOURCE.COLUMN)`.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (name, what) = text
            .split_once('=')
            .ok_or("there is no `=` in it: expected NAME=FUNCTION(SOURCE.COLUMN)")?;
        Self::new(name.trim(), what)
    }

    /// Definition of the result, as it was written.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The SI unit of its values; `1` where they have none.
    #[must_use]
    pub fn unit(&self) -> String {
        let of_column = |table: &TableSpec, column: &str| {
            let known = table.column(column);
            known.map_or("1", |column| column.unit)
        };
        let unit = match &self.source {
            _ if matches!(self.function, Function::Slope | Function::Tilt) => "deg",
            _ if self.function == Function::Ratio => {
                let units = [Some(&self.source), self.over.as_ref()].map(|source| match source {
                    Some(Source::Rows { table, column, .. }) => of_column(table, column),
                    Some(Source::Energy { column }) => of_column(&ENERGIES, column),
                    _ => "1",
                });
                return match units {
                    [above, below] if above == below => "1".to_owned(),
                    [above, "1"] => above.to_owned(),
                    [above, below] if below.contains([' ', '/']) => format!("{above}/({below})"),
                    [above, below] => format!("{above}/{below}"),
                };
            }
            Source::Rows { table, column, .. } => of_column(table, column),
            Source::Energy { column } => of_column(&ENERGIES, column),
            Source::Particles { column } if column == "speed" => "m/s",
            Source::Particles { column } => {
                return particle_unit(column).unwrap_or_else(|| "1".to_owned());
            }
        };
        match (self.function, unit) {
            (Function::Rate, "1") => "1/s".to_owned(),
            (Function::Rate, "s") => "1".to_owned(),
            (Function::Rate, unit) => format!("{unit}/s"),
            (_, unit) => unit.to_owned(),
        }
    }

    /// Whether the outputs of this plan contain what the result needs.
    ///
    /// # Errors
    /// The run does not write the file or the column; the message lists those that it writes.
    pub fn check(&self, plan: &Plan) -> Result<(), String> {
        let files = plan.outputs().files();
        let off = |key: &str, file: &str| {
            format!(
                "{} needs {file}, and output.{key} = false leaves it out\nhelp: set output.{key} = true, or leave the key out",
                self.text
            )
        };
        if self.function == Function::Tilt {
            for (key, file, is_there) in [
                ("ene", ".ene", files.ene),
                ("frames", ".particles.arrow", files.frames),
            ] {
                if !is_there {
                    return Err(off(key, file));
                }
            }
        }
        match &self.source {
            Source::Rows {
                table,
                name,
                material,
                ..
            } => {
                let tracks = files.track_names();
                let names: Vec<&str> = match table.name() {
                    "track" => tracks.iter().map(String::as_str).collect(),
                    "walls" => (plan.physics().walls.iter())
                        .map(|wall| wall.name.as_str())
                        .collect(),
                    "regions" => (plan.outputs().regions().iter())
                        .map(|region| region.name.as_str())
                        .collect(),
                    _ => (plan.outputs().fluxes().iter())
                        .map(|flux| flux.name.as_str())
                        .collect(),
                };
                there_is(table.row_of, name, &names)?;
                if table.name() == "track" {
                    return Ok(());
                }
                if table.name() == "walls" {
                    return match files.walls {
                        true => Ok(()),
                        false => Err(off("walls", ".walls.csv")),
                    };
                }
                let materials = counted_materials(plan);
                let materials: Vec<&str> =
                    materials.iter().map(|(_, name)| name.as_str()).collect();
                match material {
                    Some(material) => there_is("material of particles", material, &materials),
                    None if materials.len() > 1 => Err(format!(
                        "`{name}` has rows of several materials\nhelp: name one of them: {}.{name}.MATERIAL.COLUMN; there are: {}",
                        table.name(),
                        listed(materials)
                    )),
                    None => Ok(()),
                }
            }
            Source::Energy { .. } if !files.ene => Err(off("ene", ".ene")),
            Source::Energy { .. } => Ok(()),
            Source::Particles { .. } if !files.frames => Err(off("frames", ".particles.arrow")),
            Source::Particles { column } if column == "speed" => Ok(()),
            Source::Particles { column } => {
                let columns = particle_columns(plan);
                let names: Vec<&str> = columns.iter().map(|spec| spec.name.as_str()).collect();
                there_is("column of particles", column, &names)
            }
        }
    }

    /// Rows of one of its sources.
    fn rows(&self, source: &Source, folder: &Path, prefix: &str) -> Result<Vec<Row>, String> {
        match source {
            Source::Rows {
                table,
                name,
                material,
                column,
            } => {
                let path = folder.join(format!("{prefix}.{}", table.file));
                let text = fs::read_to_string(&path).map_err(|error| lost(&path, &error))?;
                let rows = rows(&text, name, material.as_deref(), column);
                rows.map_err(|problem| format!("{}: {problem}", path.display()))
            }
            Source::Energy { column } => energies(folder, prefix, column),
            Source::Particles { .. } => Ok(Vec::new()),
        }
    }

    /// Whether one run gives its error, or why not.
    fn has_error(&self) -> Result<(), &'static str> {
        match (self.function, &self.source) {
            (Function::Slope, _) | (_, Source::Particles { .. }) => Err("it is of one state"),
            (
                Function::Min | Function::Max | Function::First | Function::Last | Function::Sum,
                _,
            ) => Err("it is one value of the window"),
            _ => Ok(()),
        }
    }

    /// Time from which its rows count, s, in a scene that schedules nothing behind `settled` (s).
    fn begin(&self, settled: f64) -> f64 {
        match self.window.is_steady {
            true => settled,
            false => self.window.times.0,
        }
    }

    /// Whether its values are amounts that came since the row before.
    fn is_amount(&self) -> bool {
        let Source::Rows { table, column, .. } = &self.source else {
            return false;
        };
        table.column(column).map(|column| column.role) == Some(Role::Amount)
    }

    /// Its value and error in the run whose files lie in `folder` and begin with `prefix`. `settled`: the time behind which the scene schedules
    /// nothing (s), for `steady` windows. Rows behind `until` (s) do not count.
    fn measured(
        &self,
        folder: &Path,
        prefix: &str,
        settled: Result<f64, String>,
        until: f64,
    ) -> Result<Measured, String> {
        if self.function == Function::Slope {
            return slope(folder, prefix).map(Measured::of_one_state);
        }
        if let Source::Particles { column } = &self.source {
            let values = particles(folder, prefix, column)?;
            return self.value(&values).map(Measured::of_one_state);
        }
        let (_, to) = self.window.times;
        let from = match self.window.is_steady {
            true => self.begin(settled?),
            false => self.begin(0.0),
        };
        let to = to.min(until + slack(until));
        let from = from
            - if self.window.is_steady {
                slack(from)
            } else {
                0.0
            };
        let all = self.rows(&self.source, folder, prefix)?;
        let inside = |row: &&Row| (from..=to).contains(&row.time);
        let values: Vec<f64> = all.iter().filter(inside).map(|row| row.value).collect();
        let course = match self.function {
            Function::Mean => Course::mean(all.iter().filter(inside)),
            Function::Std => Course::deviation(all.iter().filter(inside)),
            Function::Rate => {
                let flows = self.flows(&all, (from, to));
                let flows: Vec<Row> = flows.map(|(_, flow)| flow).collect();
                Course::mean(flows.iter())
            }
            Function::Ratio => {
                let below = self.over.as_ref().unwrap_or(&self.source);
                let below = self.rows(below, folder, prefix)?;
                let below: Vec<Row> = below.iter().filter(inside).copied().collect();
                Course::ratio(all.iter().filter(inside), &below)
            }
            Function::Tilt => {
                let turned = turning(folder, prefix, self.wall(), gravity(folder, prefix)?)?;
                Course::angle(turned.iter().filter(|(row, _)| inside(&row)))
            }
            _ => {
                let why = "it is one value of the window: no error follows from one run";
                return Ok(Measured::without_error(self.value(&values)?, why));
            }
        };
        let measured = course.measured(self.window.is_steady);
        if self.window.is_steady || matches!(self.function, Function::Ratio | Function::Tilt) {
            return measured.ok_or_else(|| self.no_rows((from, to)));
        }
        // Windows given in numbers: the function of all of their rows.
        let value = match self.function {
            Function::Rate => self.rate(&all, self.is_amount())?,
            _ => self.value(&values)?,
        };
        Ok(match measured {
            Some(measured) => measured.with_value(value),
            None => Measured::without_error(value, "it has one row"),
        })
    }

    /// The name of the wall of its source.
    fn wall(&self) -> &str {
        match &self.source {
            Source::Rows { name, .. } => name,
            _ => "",
        }
    }

    /// Its value in the run whose files are in `folder` and begin with `prefix`, or the reason why it has none. `settled` is the time behind which
    /// its scene schedules nothing, s; left out, it is read from the summary of the run.
    #[must_use]
    pub fn read(&self, folder: &Path, prefix: &str, settled: Option<f64>) -> ResultValue {
        let settled = match settled {
            Some(time) => Ok(time),
            None if self.window.is_steady => values::settled(folder),
            None => Ok(0.0),
        };
        let unit = self.unit();
        let read = self.measured(folder, prefix, settled, f64::INFINITY);
        let is_finite = |measured: &Measured| measured.value.is_finite();
        let problem = match &read {
            Err(problem) => Some(problem.clone()),
            Ok(measured) if !is_finite(measured) => Some(format!("is {}", measured.value)),
            Ok(_) => None,
        };
        let read = read.ok().filter(is_finite);
        let note = read.as_ref().and_then(|measured| {
            let notes = [self.note(folder, prefix), measured.note.clone()];
            let notes: Vec<String> = notes.into_iter().flatten().collect();
            (!notes.is_empty()).then(|| notes.join("; "))
        });
        ResultValue {
            of: self.text.clone(),
            value: read.as_ref().map(|measured| measured.value),
            unit,
            problem,
            note,
            estimate: read.map(|measured| measured.estimate),
        }
    }

    /// Remark on its value in a run.
    fn note(&self, folder: &Path, prefix: &str) -> Option<String> {
        match self.function {
            Function::Slope => slope_note(folder, prefix),
            _ => None,
        }
    }

    /// The intervals between rows that lie in a window as a whole, and the change per time in each.
    fn flows<'a>(
        &self,
        rows: &'a [Row],
        (from, to): (f64, f64),
    ) -> impl Iterator<Item = ([Row; 2], Row)> + 'a {
        let is_amount = self.is_amount();
        let pairs = rows.windows(2).map(|pair| [pair[0], pair[1]]);
        let inside = move |[before, row]: &[Row; 2]| {
            // Times are multiples of the step but for round-off.
            let slack = 1e-6 * (row.time - before.time);
            before.time >= from - slack && row.time <= to + slack
        };
        pairs.filter(inside).map(move |[before, row]| {
            let change = row.value - if is_amount { 0.0 } else { before.value };
            let flow = Row {
                time: row.time,
                value: change / (row.time - before.time),
            };
            ([before, row], flow)
        })
    }

    /// Change per time: of `amounts` the sum over the time in which they came, of rows whose time lies in the window as a whole; else the
    /// difference of the last and the first.
    fn rate(&self, rows: &[Row], amounts: bool) -> Result<f64, String> {
        let (from, to) = self.window.times;
        let inside = self.flows(rows, (from, to)).map(|(rows, _)| rows);
        let inside: Vec<[Row; 2]> = inside.collect();
        let (Some([first, _]), Some([_, last])) = (inside.first(), inside.last()) else {
            return Err(format!("a rate needs two rows between {from} and {to} s"));
        };
        let change = match amounts {
            true => inside.iter().map(|[_, row]| row.value).sum(),
            false => last.value - first.value,
        };
        Ok(change / (last.time - first.time))
    }

    /// The message that no row lies in a window.
    fn no_rows(&self, (from, to): (f64, f64)) -> String {
        match from.is_finite() || to.is_finite() {
            true => format!("no rows between {from} and {to} s"),
            false => "there are no values".to_owned(),
        }
    }

    fn value(&self, values: &[f64]) -> Result<f64, String> {
        let (Some(first), Some(last)) = (values.first(), values.last()) else {
            return Err(self.no_rows(self.window.times));
        };
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        Ok(match self.function {
            Function::Mean
            | Function::Rate
            | Function::Ratio
            | Function::Tilt
            | Function::Slope => mean,
            Function::Std if values.len() < 2 => f64::NAN,
            Function::Std => {
                (values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (count - 1.0)).sqrt()
            }
            Function::Min => values.iter().copied().fold(f64::INFINITY, f64::min),
            Function::Max => values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            Function::First => *first,
            Function::Last => *last,
            Function::Sum => values.iter().sum(),
        })
    }
}

/// The unit of a column of frames of particles.
fn particle_unit(column: &str) -> Option<String> {
    let properties = PARTICLE_PROPERTIES.iter().chain([&LIQUID_VOLUME]);
    let all = ParticleColumns::all().with_properties(properties);
    let specs = ParticleFrame::specs(&all);
    let spec = specs.into_iter().find(|spec| spec.name == column)?;
    // As the other tables write it.
    Some(spec.unit.replace('^', ""))
}

/// Whether a name is among those of its kind.
fn there_is(what: &str, name: &str, names: &[&str]) -> Result<(), String> {
    if names.contains(&name) {
        return Ok(());
    }
    let help = match nearest(name, names.iter().copied()) {
        Some(near) => format!("\nhelp: did you mean `{near}`?"),
        None if names.is_empty() => String::new(),
        None => format!("\nhelp: there are: {}", listed(names.iter().copied())),
    };
    Err(format!("there is no {what} `{name}`{help}"))
}

/// Which of the words it is.
fn one_of(what: &str, word: &str, words: &[&str]) -> Result<usize, String> {
    words
        .iter()
        .position(|known| *known == word)
        .ok_or_else(|| {
            let hint = match nearest(word, words.iter().copied()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("there are: {}", listed(words.iter().copied())),
            };
            format!("there is no {what} `{word}`; {hint}")
        })
}

/// The steps of a path, names in quotes as they are, and what stands behind the first comma outside of them.
fn steps(text: &str) -> (Vec<String>, Option<&str>) {
    let (mut steps, mut step, mut quote) = (Vec::new(), String::new(), None);
    for (at, c) in text.char_indices() {
        match (quote, c) {
            (Some(open), _) if c == open => quote = None,
            (Some(_), _) => step.push(c),
            (None, '"' | '\'') => quote = Some(c),
            (None, '.') => steps.push(std::mem::take(&mut step).trim().to_owned()),
            (None, ',') => {
                steps.push(step.trim().to_owned());
                return (steps, Some(&text[at + 1..]));
            }
            _ => step.push(c),
        }
    }
    steps.push(step.trim().to_owned());
    (steps, None)
}

/// `FROM..TO`, each of which may be left out; FROM may be `steady`.
fn window(text: &str) -> Result<Window, String> {
    let wrong = || {
        format!(
            "`{}` are no times: expected FROM..TO in s, as in 1..2, 1.. or steady..",
            text.trim()
        )
    };
    let (from, to) = text.trim().split_once("..").ok_or_else(wrong)?;
    let time = |text: &str, none: f64| match text.trim() {
        "" => Ok(none),
        text => text
            .parse::<f64>()
            .ok()
            .filter(|t| t.is_finite())
            .ok_or_else(wrong),
    };
    let is_steady = from.trim() == "steady";
    let from = match is_steady {
        true => f64::NEG_INFINITY,
        false => time(from, f64::NEG_INFINITY)?,
    };
    let times = (from, time(to, f64::INFINITY)?);
    if times.0 <= times.1 {
        Ok(Window { times, is_steady })
    } else {
        Err(wrong())
    }
}

/// Whether two sources are columns of the same rows.
fn is_one_table(a: &Source, b: &Source) -> bool {
    match (a, b) {
        (
            Source::Rows {
                table,
                name,
                material,
                ..
            },
            Source::Rows {
                table: of_b,
                name: name_of_b,
                material: material_of_b,
                ..
            },
        ) => (table.name(), name, material) == (of_b.name(), name_of_b, material_of_b),
        (Source::Energy { .. }, Source::Energy { .. }) => true,
        _ => false,
    }
}

/// A path with more steps than any has, all between the first and the last as one name in quotes.
fn in_quotes(path: &[String]) -> Option<String> {
    let [first, name @ .., column] = path else {
        return None;
    };
    let most = 1 + usize::from(has_materials(table(first)?));
    (name.len() > most).then(|| format!("{first}.\"{}\".{column}", name.join(".")))
}

fn source(path: &[String], function: Function) -> Result<Source, String> {
    let words: Vec<&str> = path.iter().map(String::as_str).collect();
    if function == Function::Slope {
        return match words[..] {
            ["particles"] => Ok(Source::Particles {
                column: "z".to_owned(),
            }),
            _ => Err("slope is that of a heap: slope(particles)".to_owned()),
        };
    }
    if function == Function::Tilt {
        return match words[..] {
            ["walls", name] => Ok(Source::Rows {
                table: &WALLS,
                name: name.to_owned(),
                material: None,
                column: "wx".to_owned(),
            }),
            _ => Err("tilt is that about the axis of a wall: tilt(walls.NAME)".to_owned()),
        };
    }
    let rows = |table: &'static TableSpec, name: &str, material: Option<&str>, column: &str| {
        let known: Vec<&str> = table.values().map(|column| column.name).collect();
        one_of("column", column, &known)?;
        let role = table.column(column).map(|column| column.role);
        if function == Function::Rate && role == Some(Role::Mean) {
            return Err(format!("`{column}` is a mean: it has no rate"));
        }
        Ok(Source::Rows {
            table,
            name: name.to_owned(),
            material: material.map(str::to_owned),
            column: column.to_owned(),
        })
    };
    let table = words.first().and_then(|first| table(first));
    match (table, &words[..]) {
        (Some(table), [_, name, column]) => rows(table, name, None, column),
        (Some(table), [_, name, material, column]) if has_materials(table) => {
            rows(table, name, Some(material), column)
        }
        (_, ["energy", column]) => {
            let known: Vec<&str> = (ENERGIES.columns.iter())
                .map(|column| column.name)
                .collect();
            one_of("column", column, &known)?;
            Ok(Source::Energy {
                column: (*column).to_owned(),
            })
        }
        (_, ["particles", _]) if function == Function::Rate => {
            Err("particles are those of the last frame: they have no rate".to_owned())
        }
        (_, ["particles", _]) if function == Function::Ratio => {
            Err("a ratio is that of two columns of one table of rows over time".to_owned())
        }
        (_, ["particles", column]) if !column.is_empty() => Ok(Source::Particles {
            column: (*column).to_owned(),
        }),
        (_, [first, ..]) => {
            one_of("source", first, &SOURCES)?;
            Err(format!(
                "`{}` names no result: expected walls.NAME.COLUMN, regions.NAME.COLUMN, regions.NAME.MATERIAL.COLUMN, flux likewise, track.NAME.COLUMN, energy.COLUMN or particles.COLUMN",
                path.join(".")
            ))
        }
        (_, []) => Err("a source is missing".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_of_values() {
        let value = |function: &str, values: &[f64]| {
            NamedResult::new("x", &format!("{function}(walls.drum.ty)"))
                .unwrap()
                .value(values)
        };
        let values = [1.0, 2.0, 6.0];
        for (function, expected) in [
            ("mean", 3.0),
            // Deviations -2, -1, 3: 14 over 2.
            ("std", 7f64.sqrt()),
            ("min", 1.0),
            ("max", 6.0),
            ("first", 1.0),
            ("last", 6.0),
            ("sum", 9.0),
        ] {
            assert_eq!(value(function, &values), Ok(expected), "{function}");
        }
        assert!(value("mean", &[]).is_err());
        assert!(value("std", &[1.0]).unwrap().is_nan());
    }

    #[test]
    fn units_are_those_of_the_columns() {
        for (text, unit) in [
            ("mean(walls.drum.ty)", "N m"),
            ("std(walls.drum.wz)", "rad/s"),
            ("max(regions.bed.solid_fraction)", "1"),
            ("sum(flux.out.mass)", "kg"),
            ("rate(flux.out.mass, 1.0..)", "kg/s"),
            ("rate(flux.out.forward)", "1/s"),
            ("rate(walls.lid.z)", "m/s"),
            ("max(track.ball.fz)", "N"),
            ("last(energy.traKineticEnergy)", "J"),
            ("rate(energy.elasticEnergy)", "J/s"),
            ("max(particles.z)", "m"),
            ("max(particles.volume)", "m3"),
            ("mean(particles.speed)", "m/s"),
            ("slope(particles)", "deg"),
            ("tilt(walls.drum, steady..)", "deg"),
            ("ratio(walls.lid.fx, walls.lid.fz, 1..)", "1"),
            ("ratio(walls.lid.power, walls.lid.vx)", "W/(m/s)"),
        ] {
            assert_eq!(NamedResult::new("x", text).unwrap().unit(), unit, "{text}");
        }
    }

    #[test]
    fn rates_are_amounts_over_the_time_in_which_they_came() {
        // An amount that came since the row before; the last interval is shorter, as at the end of a run.
        let rows: Vec<Row> = [(0.0, 0.0), (0.5, 1.0), (1.0, 2.0), (1.5, 6.0), (1.75, 4.0)]
            .map(|(time, value)| Row { time, value })
            .to_vec();
        let rate = |window: &str, amounts: bool| {
            let text = format!("rate(flux.out.mass, {window})");
            NamedResult::new("x", &text).unwrap().rate(&rows, amounts)
        };
        // 13 in 1.75 s, 12 in the 1.25 s from 0.5 on, 6 in the one interval that lies between 0.9 and 1.6.
        assert_eq!(rate("..", true), Ok(13.0 / 1.75));
        assert_eq!(rate("0.5..", true), Ok(12.0 / 1.25));
        assert_eq!(rate("0.9..1.6", true), Ok(6.0 / 0.5));
        // Of what is there at each time, the difference.
        assert_eq!(rate("0.5..1.5", false), Ok(5.0 / 1.0));
        assert!(rate("1.1..1.4", true).is_err());
        assert!(rate("2..", true).is_err());
    }

    #[test]
    fn slips_are_reported() {
        for (text, part) in [
            ("a", "no `=`"),
            ("a b=mean(energy.time)", "cannot be the name"),
            ("a=mean", "is no result"),
            ("a=mean(walls.drum.ty", "is no result"),
            ("a=meen(walls.drum.ty)", "did you mean `mean`?"),
            ("a=mean(wals.drum.ty)", "did you mean `walls`?"),
            ("a=mean(walls.drum.tt)", "no column `tt`"),
            ("a=mean(walls.drum)", "names no result"),
            (
                "a=mean(walls.box.-z.fz, 1..)",
                "'a=mean(walls.\"box.-z\".fz, 1..)'",
            ),
            ("a=mean(walls.drum.ty, 1)", "are no times"),
            ("a=mean(walls.drum.ty, 2..1)", "are no times"),
            ("a=mean(particles.z, 1..2)", "last frame"),
            ("a=slope(walls.drum.ty)", "slope(particles)"),
            ("a=mean()", "there is no source"),
            ("a=rate(flux.out.d10)", "has no rate"),
            ("a=rate(particles.z)", "no rate"),
            ("a=ratio(walls.lid.fx)", "two columns of one table"),
            ("a=ratio(walls.lid.fx, 1..2)", "two columns of one table"),
            (
                "a=ratio(walls.lid.fx, walls.base.fz)",
                "two columns of one table",
            ),
            ("a=ratio(particles.x, particles.z)", "rows over time"),
            ("a=tilt(walls.drum.ty)", "tilt(walls.NAME)"),
            ("a=mean(walls.lid.fx, ..steady)", "are no times"),
            ("a=mean(walls.lid.fx, stead..)", "are no times"),
        ] {
            let error = NamedResult::parse(text).unwrap_err();
            assert!(error.contains(part), "{text}: {error}");
        }
        let named = NamedResult::parse("t = mean(walls.\"my wall.2\".ty, 1..)").unwrap();
        assert_eq!(named.window.times, (1.0, f64::INFINITY));
        assert!(matches!(named.source, Source::Rows { name, .. } if name == "my wall.2"));
    }
}
