//! The text of a result, `FUNCTION(SOURCE.NAME.COLUMN, FROM..TO)`: its functions, its sources and its times.

use mercury_common::run_tables::{ENERGIES, FLUX, REGIONS, Role, TRACK, TableSpec, WALLS};
use mercury_common::scene::{listed, nearest};

use super::NamedResult;

/// Function of the values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Function {
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
pub(super) enum Source {
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
pub(super) struct Window {
    /// From and until, s.
    pub(super) times: (f64, f64),
    /// From the time behind which the scene schedules nothing any more, less the start-up that the rows show.
    pub(super) is_steady: bool,
}

impl Window {
    const ALL: Self = Self {
        times: (f64::NEG_INFINITY, f64::INFINITY),
        is_steady: false,
    };
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
