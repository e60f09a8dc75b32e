//! Numbers of a run by name: `torque = "mean(walls.drum.ty, 1..2)"`.

mod values;

use std::fs;
use std::io;
use std::path::Path;

use mercury_common::formats::ene;
use mercury_common::scene::{listed, nearest};

use values::{energies, particles, rows, slope};

/// What is made of the values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Function {
    Mean,
    Std,
    Min,
    Max,
    First,
    Last,
    Sum,
    Slope,
}

const FUNCTIONS: [(&str, Function); 8] = [
    ("mean", Function::Mean),
    ("std", Function::Std),
    ("min", Function::Min),
    ("max", Function::Max),
    ("first", Function::First),
    ("last", Function::Last),
    ("sum", Function::Sum),
    ("slope", Function::Slope),
];

const SOURCES: [&str; 5] = ["walls", "regions", "flux", "energy", "particles"];

/// Columns of the tables with a row for each name and time.
const WALLS: &str = "fx,fy,fz,tx,ty,tz,power,x,y,z,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz";
const REGIONS: &str = "number,mass,vx,vy,vz,kinetic,solid_fraction";
const FLUX: &str = "forward,backward,mass,volume,px,py,pz,d10,d32,d43";

/// Where the values stand.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Source {
    /// `<prefix>.<file>.csv`: rows of this name (and material).
    Rows {
        file: &'static str,
        name: String,
        material: Option<String>,
        column: String,
    },
    /// `.ene`.
    Energy { column: String },
    /// The last frame, without what is fixed.
    Particles { column: String },
}

/// A number that a study wants of each run.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedResult {
    /// Its name, that of its column.
    pub name: String,
    text: String,
    function: Function,
    source: Source,
    /// From and until, s.
    window: (f64, f64),
}

/// Why a file of a finished run cannot be read, and what to do.
pub(super) fn lost(path: &Path, error: &io::Error) -> String {
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
    /// What is wrong with the text.
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
        let steps = steps(inside);
        let (path, window) = match steps {
            (path, None) => (path, (f64::NEG_INFINITY, f64::INFINITY)),
            (path, Some(window)) => (path, self::window(window)?),
        };
        let source = source(&path, function).map_err(|problem| match in_quotes(&path) {
            Some(quoted) => format!(
                "{problem}\nhelp: names with dots stand in quotes: '{name}={}'",
                text.trim().replace(&path.join("."), &quoted)
            ),
            None => problem,
        })?;
        if matches!(source, Source::Particles { .. })
            && window != (f64::NEG_INFINITY, f64::INFINITY)
        {
            return Err("particles are those of the last frame: no times go with them".to_owned());
        }
        Ok(Self {
            name: name.to_owned(),
            text: text.trim().to_owned(),
            function,
            source,
            window,
        })
    }

    /// Reads `NAME=WHAT`, as `--result` has it.
    ///
    /// # Errors
    /// What is wrong with the text.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (name, what) = text
            .split_once('=')
            .ok_or("there is no `=` in it: expected NAME=FUNCTION(SOURCE.COLUMN)")?;
        Self::new(name.trim(), what)
    }

    /// What it is, as it was written.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The wall that it asks for, if it does.
    #[must_use]
    pub fn wall(&self) -> Option<&str> {
        match &self.source {
            Source::Rows {
                file: "walls",
                name,
                ..
            } => Some(name),
            _ => None,
        }
    }

    /// Its value in the run whose files lie in `folder` and begin with `prefix`.
    ///
    /// # Errors
    /// Why there is none.
    pub fn of_run(&self, folder: &Path, prefix: &str) -> Result<f64, String> {
        if self.function == Function::Slope {
            return slope(folder, prefix);
        }
        let values = match &self.source {
            Source::Rows {
                file,
                name,
                material,
                column,
            } => {
                let path = folder.join(format!("{prefix}.{file}.csv"));
                let text = fs::read_to_string(&path).map_err(|error| lost(&path, &error))?;
                let rows = rows(&text, name, material.as_deref(), column, self.window);
                rows.map_err(|problem| format!("{}: {problem}", path.display()))?
            }
            Source::Energy { column } => energies(folder, prefix, column, self.window)?,
            Source::Particles { column } => particles(folder, prefix, column)?,
        };
        self.value(&values)
    }

    fn value(&self, values: &[f64]) -> Result<f64, String> {
        let (Some(first), Some(last)) = (values.first(), values.last()) else {
            return Err(match self.window {
                (from, to) if from.is_finite() || to.is_finite() => {
                    format!("no rows between {from} and {to} s")
                }
                _ => "there are no values".to_owned(),
            });
        };
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        Ok(match self.function {
            Function::Mean | Function::Slope => mean,
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

/// `FROM..TO`, each of which may be left out.
fn window(text: &str) -> Result<(f64, f64), String> {
    let wrong = || {
        format!(
            "`{}` are no times: expected FROM..TO in s, as in 1..2 or 1..",
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
    let (from, to) = (time(from, f64::NEG_INFINITY)?, time(to, f64::INFINITY)?);
    if from <= to {
        Ok((from, to))
    } else {
        Err(wrong())
    }
}

/// A path with more steps than any has, all between the first and the last as one name in quotes.
fn in_quotes(path: &[String]) -> Option<String> {
    let [first, name @ .., column] = path else {
        return None;
    };
    let most = match first.as_str() {
        "walls" => 1,
        "regions" | "flux" => 2,
        _ => return None,
    };
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
    let rows = |file, columns: &'static str, name: &str, material: Option<&str>, column: &str| {
        let known: Vec<&str> = columns.split(',').collect();
        one_of("column", column, &known)?;
        Ok(Source::Rows {
            file,
            name: name.to_owned(),
            material: material.map(str::to_owned),
            column: column.to_owned(),
        })
    };
    match words[..] {
        ["walls", name, column] => rows("walls", WALLS, name, None, column),
        ["regions", name, column] => rows("regions", REGIONS, name, None, column),
        ["regions", name, material, column] => {
            rows("regions", REGIONS, name, Some(material), column)
        }
        ["flux", name, column] => rows("flux", FLUX, name, None, column),
        ["flux", name, material, column] => rows("flux", FLUX, name, Some(material), column),
        ["energy", column] => {
            one_of("column", column, &ene::COLUMNS)?;
            Ok(Source::Energy {
                column: column.to_owned(),
            })
        }
        ["particles", column] if !column.is_empty() => Ok(Source::Particles {
            column: column.to_owned(),
        }),
        [first, ..] => {
            one_of("source", first, &SOURCES)?;
            Err(format!(
                "`{}` leads nowhere: expected walls.NAME.COLUMN, regions.NAME.COLUMN, regions.NAME.MATERIAL.COLUMN, flux likewise, energy.COLUMN or particles.COLUMN",
                path.join(".")
            ))
        }
        [] => Err("a source is missing".to_owned()),
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
    fn slips_are_told() {
        for (text, part) in [
            ("a", "no `=`"),
            ("a b=mean(energy.time)", "cannot be the name"),
            ("a=mean", "is no result"),
            ("a=mean(walls.drum.ty", "is no result"),
            ("a=meen(walls.drum.ty)", "did you mean `mean`?"),
            ("a=mean(wals.drum.ty)", "did you mean `walls`?"),
            ("a=mean(walls.drum.tt)", "no column `tt`"),
            ("a=mean(walls.drum)", "leads nowhere"),
            (
                "a=mean(walls.box.-z.fz, 1..)",
                "'a=mean(walls.\"box.-z\".fz, 1..)'",
            ),
            ("a=mean(walls.drum.ty, 1)", "are no times"),
            ("a=mean(walls.drum.ty, 2..1)", "are no times"),
            ("a=mean(particles.z, 1..2)", "last frame"),
            ("a=slope(walls.drum.ty)", "slope(particles)"),
            ("a=mean()", "there is no source"),
        ] {
            let error = NamedResult::parse(text).unwrap_err();
            assert!(error.contains(part), "{text}: {error}");
        }
        let named = NamedResult::parse("t = mean(walls.\"my wall.2\".ty, 1..)").unwrap();
        assert_eq!(
            (named.wall(), named.window),
            (Some("my wall.2"), (1.0, f64::INFINITY))
        );
    }
}
