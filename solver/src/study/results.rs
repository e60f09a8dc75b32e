//! Numbers of a run by name: `torque = "mean(walls.drum.ty, 1..2)"`.

use std::fs;
use std::path::Path;

use mercury_common::formats::ene::{self, EnergyReader};
use mercury_common::frames::{Column, FLAG_FIXED, FrameReader};
use mercury_common::scene::{listed, nearest};

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
    function: Function,
    source: Source,
    /// From and until, s.
    window: (f64, f64),
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
        let source = source(&path, function)?;
        if matches!(source, Source::Particles { .. })
            && window != (f64::NEG_INFINITY, f64::INFINITY)
        {
            return Err("particles are those of the last frame: no times go with them".to_owned());
        }
        Ok(Self {
            name: name.to_owned(),
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
                let text = fs::read_to_string(&path)
                    .map_err(|error| format!("{}: {error}", path.display()))?;
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

/// The fields of a line of a table, a quote inside quotes doubled.
fn fields(line: &str) -> Vec<String> {
    let (mut fields, mut field, mut in_quotes) = (Vec::new(), String::new(), false);
    let mut letters = line.chars().peekable();
    while let Some(c) = letters.next() {
        match c {
            '"' if in_quotes && letters.peek() == Some(&'"') => {
                letters.next();
                field.push('"');
            }
            '"' => in_quotes = !in_quotes,
            ',' if !in_quotes => fields.push(std::mem::take(&mut field)),
            _ => field.push(c),
        }
    }
    fields.push(field);
    fields
}

/// The values of a column in the rows of a name and times.
fn rows(
    text: &str,
    name: &str,
    material: Option<&str>,
    column: &str,
    (from, to): (f64, f64),
) -> Result<Vec<f64>, String> {
    let mut lines = text.lines();
    let header = fields(lines.next().unwrap_or_default());
    let place = |wanted: &str| {
        let found = header.iter().position(|name| name == wanted);
        found.ok_or_else(|| format!("there is no column `{wanted}`"))
    };
    let (time_at, name_at, column_at) = (place("time")?, place("name")?, place(column)?);
    let material_at = header.iter().position(|name| name == "material");
    let (mut names, mut materials, mut values) =
        (Vec::<String>::new(), Vec::<String>::new(), Vec::new());
    for line in lines {
        let row = fields(line);
        // The last line of a run that was killed.
        if row.len() != header.len() {
            continue;
        }
        if row[name_at] != name {
            if !names.contains(&row[name_at]) {
                names.push(row[name_at].clone());
            }
            continue;
        }
        if let Some(at) = material_at {
            if !materials.contains(&row[at]) {
                materials.push(row[at].clone());
            }
            if material.is_some_and(|material| material != row[at]) {
                continue;
            }
        }
        let number = |at: usize| {
            row[at]
                .parse::<f64>()
                .map_err(|_| format!("`{}` is no number", row[at]))
        };
        if (from..=to).contains(&number(time_at)?) {
            values.push(number(column_at)?);
        }
    }
    if materials.is_empty() && !names.is_empty() && values.is_empty() && !text.contains(name) {
        return Err(format!(
            "nothing is named `{name}`; there are: {}",
            listed(names.iter().map(String::as_str))
        ));
    }
    if material.is_none() && materials.len() > 1 {
        return Err(format!(
            "`{name}` has rows of several materials: name one of {}",
            listed(materials.iter().map(String::as_str))
        ));
    }
    if let Some(material) =
        material.filter(|material| !materials.iter().any(|known| known == material))
    {
        return Err(format!(
            "`{name}` has no rows of `{material}`; there are: {}",
            listed(materials.iter().map(String::as_str))
        ));
    }
    Ok(values)
}

fn energies(
    folder: &Path,
    prefix: &str,
    column: &str,
    (from, to): (f64, f64),
) -> Result<Vec<f64>, String> {
    let path = folder.join(format!("{prefix}.ene"));
    let reader = EnergyReader::open(&path).map_err(|error| error.to_string())?;
    let mut values = Vec::new();
    for row in reader {
        let row = row.map_err(|error| error.to_string())?;
        let c = row.center_of_mass;
        let all = [
            row.time,
            row.gravitational,
            row.translational_kinetic,
            row.rotational_kinetic,
            row.elastic,
            c.x,
            c.y,
            c.z,
        ];
        let at = ene::COLUMNS
            .iter()
            .position(|name| *name == column)
            .unwrap_or(0);
        if (from..=to).contains(&row.time) {
            values.push(all[at]);
        }
    }
    Ok(values)
}

/// Columns of the last frame, rows of what is fixed left out.
fn last_frame(folder: &Path, prefix: &str, columns: &[&str]) -> Result<Vec<Vec<f64>>, String> {
    let path = folder.join(format!("{prefix}.particles.arrow"));
    let reader = FrameReader::open(&path).map_err(|error| error.to_string())?;
    let last = reader
        .len()
        .checked_sub(1)
        .ok_or_else(|| format!("{}: there are no frames", path.display()))?;
    let frame = reader.frame(last).map_err(|error| error.to_string())?;
    let specs = reader.schema().columns();
    let column = |name: &str| {
        let place = specs.iter().position(|spec| spec.name == name);
        place.and_then(|place| frame.columns.get(place))
    };
    let is_fixed = |row: usize| matches!(column("state"), Some(Column::U8(bits)) if bits[row] & FLAG_FIXED != 0);
    let free: Vec<usize> = (0..frame.rows()).filter(|&row| !is_fixed(row)).collect();
    let numbers = |name: &&str| -> Result<Vec<f64>, String> {
        let values = column(name).and_then(Column::as_f64).ok_or_else(|| {
            let known: Vec<&str> = (specs.iter().zip(&frame.columns))
                .filter(|(_, column)| column.as_f64().is_some())
                .map(|(spec, _)| spec.name.as_str())
                .collect();
            let hint = match nearest(name, known.iter().copied()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("there are: {}", listed(known.iter().copied())),
            };
            format!(
                "{}: there is no column `{name}` of numbers; {hint}",
                path.display()
            )
        })?;
        Ok(free.iter().map(|&row| values[row]).collect())
    };
    columns.iter().map(numbers).collect()
}

fn particles(folder: &Path, prefix: &str, column: &str) -> Result<Vec<f64>, String> {
    if column == "speed" {
        let v = last_frame(folder, prefix, &["vx", "vy", "vz"])?;
        let squares = v[0]
            .iter()
            .zip(&v[1])
            .zip(&v[2])
            .map(|((x, y), z)| x * x + y * y + z * z);
        return Ok(squares.map(f64::sqrt).collect());
    }
    Ok(last_frame(folder, prefix, &[column])?.swap_remove(0))
}

/// The slope of a heap about a vertical (z) axis in degrees: that of the straight line through the highest grain in each ring of
/// a mean diameter's width, from the axis to where the surface is two grains high. The axis goes through the mean place of all
/// grains.
fn slope(folder: &Path, prefix: &str) -> Result<f64, String> {
    let columns = last_frame(folder, prefix, &["x", "y", "z", "radius"])?;
    let [x, y, z, radius] = &columns[..] else {
        return Err("there are no places".to_owned());
    };
    surface_slope(x, y, z, radius).ok_or_else(|| {
        "there is no heap: fewer than three rings are higher than two grains".to_owned()
    })
}

fn surface_slope(x: &[f64], y: &[f64], z: &[f64], radius: &[f64]) -> Option<f64> {
    let count = x.len() as f64;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / count;
    let (x0, y0, diameter) = (mean(x), mean(y), 2.0 * mean(radius));
    let floor = z
        .iter()
        .zip(radius)
        .map(|(z, r)| z - r)
        .fold(f64::INFINITY, f64::min);
    let mut highest = Vec::<f64>::new();
    for row in 0..x.len() {
        let (dx, dy) = (x[row] - x0, y[row] - y0);
        let distance = (dx * dx + dy * dy).sqrt();
        let ring = (distance / diameter) as usize;
        // Who rolled far away is no part of the heap.
        if ring < 10_000 {
            highest.resize(highest.len().max(ring + 1), 0.0);
            highest[ring] = highest[ring].max(z[row] + radius[row] - floor);
        }
    }
    let foot = highest.iter().position(|&height| height < 2.0 * diameter);
    let flank = &highest[..foot.unwrap_or(highest.len())];
    if flank.len() < 3 {
        return None;
    }
    // Least squares over the rings.
    let n = flank.len() as f64;
    let at = |k: usize| (k as f64 + 0.5) * diameter;
    let middle = (0..flank.len()).map(at).sum::<f64>() / n;
    let height = flank.iter().sum::<f64>() / n;
    let over: f64 = flank
        .iter()
        .enumerate()
        .map(|(k, h)| (at(k) - middle) * (h - height))
        .sum();
    let under: f64 = (0..flank.len())
        .map(|k| (at(k) - middle) * (at(k) - middle))
        .sum();
    Some(libm::atan(-over / under).to_degrees())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_of_a_cone_is_its_angle() {
        // Grains of diameter 1 on the surface of a cone of 30 degrees, at the middles of 20 rings.
        let (mut x, mut y, mut z) = (Vec::new(), Vec::new(), Vec::new());
        for ring in 0..20 {
            for part in 0..36 {
                let (r, a) = (
                    f64::from(ring) + 0.5,
                    f64::from(part) * std::f64::consts::TAU / 36.0,
                );
                x.push(7.0 + r * a.cos());
                y.push(r * a.sin() - 3.0);
                z.push((20.0 - r) * 30f64.to_radians().tan());
            }
        }
        let angle = surface_slope(&x, &y, &z, &vec![0.5; x.len()]).unwrap();
        // The mean of the places is the axis to round-off; which of a ring's grains is highest does not matter.
        assert!((angle - 30.0).abs() < 1e-9, "{angle}");
        assert_eq!(surface_slope(&x[..4], &y[..4], &z[..4], &[0.5; 4]), None);
        assert_eq!(surface_slope(&[], &[], &[], &[]), None);
    }

    #[test]
    fn values_of_rows() {
        let table =
            "time,name,material,fx\n0,a,m,1\n0,\"b, c\",m,7\n1,a,m,3\n1,a,n,9\n2,a,m,5\n2,a";
        let all = (f64::NEG_INFINITY, f64::INFINITY);
        assert_eq!(
            rows(table, "a", Some("m"), "fx", all).unwrap(),
            [1.0, 3.0, 5.0]
        );
        assert_eq!(
            rows(table, "a", Some("m"), "fx", (0.5, 1.5)).unwrap(),
            [3.0]
        );
        assert_eq!(rows(table, "b, c", None, "fx", all).unwrap(), [7.0]);
        for (name, material, part) in [
            ("a", None, "several materials: name one of m, n"),
            ("a", Some("o"), "no rows of `o`; there are: m, n"),
            ("q", None, "nothing is named `q`; there are: a, b, c"),
        ] {
            let error = rows(table, name, material, "fx", all).unwrap_err();
            assert!(error.contains(part), "{error}");
        }
        assert!(
            rows(table, "a", Some("m"), "fy", all)
                .unwrap_err()
                .contains("`fy`")
        );
        assert!(rows("", "a", None, "fx", all).is_err());
    }

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
