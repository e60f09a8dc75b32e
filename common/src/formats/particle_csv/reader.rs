//! Reading particle tables.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use glam::DVec3;
use strsim::levenshtein;

use super::{
    CLUMP, COLUMNS, ClumpCells, IGNORED, MATERIAL, Named, ParticleRow, RADIUS, REQUIRED, all_names,
};
use crate::error::FormatError;
use crate::formats::delimited::{Cell, Cells, detect_separator};
use crate::formats::lines::{LineReader, shorten};
use crate::formats::number::parse_number_of_fortran as parse_number;
use crate::particle_properties::PARTICLE_PROPERTIES;
use crate::scene::{Range, listed};
use crate::units::Quantity;

/// Mistakes of a header that are reported at once.
const MOST_MISTAKES: usize = 20;

/// Reads all rows of a particle table.
///
/// # Errors
/// Errors of [`ParticleTableReader`].
pub fn read_particle_csv(path: impl AsRef<Path>) -> Result<Vec<ParticleRow>, FormatError> {
    let table = ParticleTableReader::open(path).map_err(first)?;
    table.collect()
}

/// The first of at least one.
fn first(mut errors: Vec<FormatError>) -> FormatError {
    errors.swap_remove(0)
}

/// Reads all rows of a particle table from memory; `path` is only used in messages.
///
/// # Errors
/// Errors of [`ParticleTableReader`].
pub fn parse_particle_csv(path: &Path, text: &str) -> Result<Vec<ParticleRow>, FormatError> {
    let table = ParticleTableReader::new(text.as_bytes(), path).map_err(first)?;
    table.collect()
}

/// Reads a particle table row by row: one line is in memory at a time. Rows follow one that is wrong, nothing follows a file that cannot be read.
///
/// # Errors
/// If the file cannot be read or is not text; if a column is unknown, missing, named twice or in a unit of something else; if a line has another
/// number of cells than the header; if a cell is not a finite number; if a radius or scale is not positive, a property
/// is out of its range, or an orientation is of length 0. All mistakes of the header are reported at once, up to 20.
pub struct ParticleTableReader<R> {
    lines: LineReader<R>,
    header: Header,
    finished: bool,
}

impl ParticleTableReader<BufReader<File>> {
    /// Opens a table and reads its header.
    ///
    /// # Errors
    /// Errors of the reader, at least one.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Vec<FormatError>> {
        let path = path.as_ref();
        let file = crate::formats::open(path).map_err(|error| vec![error])?;
        Self::new(BufReader::new(file), path)
    }
}

impl<R: BufRead> ParticleTableReader<R> {
    /// Reads from anything, the header at once; `path` is only used in messages.
    ///
    /// # Errors
    /// Errors of the reader, at least one.
    pub fn new(input: R, path: &Path) -> Result<Self, Vec<FormatError>> {
        let mut lines = LineReader::new(input, path);
        if !lines.advance_to_content().map_err(|error| vec![error])? {
            let error = FormatError::of_file(path, "the table is empty");
            return Err(vec![error.with_help(format!(
                "the first line must name the columns, for example x,y,z,radius (all: {})",
                all_names().join(",")
            ))]);
        }
        let header = Header::parse(Line::of(&lines))?;
        Ok(Self {
            lines,
            header,
            finished: false,
        })
    }

    /// Names of columns that a start does not need: ids, masses, and whatever else tables of other programs hold.
    pub fn ignored(&self) -> impl Iterator<Item = &str> {
        let columns = self.header.names.iter().zip(&self.header.columns);
        columns
            .filter(|(_, column)| column.is_none())
            .map(|(name, _)| name.as_str())
    }

    /// Takes `metres` (above 0) for one unit of the columns `x`, `y`, `z` and `radius`, as far as they name no unit. Returns how many do not.
    pub fn scale_lengths(&mut self, metres: f64) -> usize {
        let mut scaled = 0;
        for column in self.header.columns.iter_mut().flatten() {
            if matches!(column.named, Named::Fixed(0..=RADIUS)) && column.unit.is_none() {
                column.unit = Some(metres);
                scaled += 1;
            }
        }
        scaled
    }

    /// Whether it has velocities in m/s because their columns name no unit.
    pub fn has_plain_velocities(&self) -> bool {
        let mut columns = self.header.columns.iter().flatten();
        columns.any(|column| matches!(column.named, Named::Fixed(5..=7)) && column.unit.is_none())
    }
}

impl<R: BufRead> Iterator for ParticleTableReader<R> {
    type Item = Result<ParticleRow, FormatError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.finished {
            return None;
        }
        let has_line = self.lines.advance_to_content();
        self.finished = !matches!(has_line, Ok(true));
        match has_line {
            Ok(true) => Some(self.header.row(Line::of(&self.lines))),
            Ok(false) => None,
            Err(error) => Some(Err(error)),
        }
    }
}

/// A line of the table with its place.
#[derive(Clone, Copy)]
struct Line<'a> {
    path: &'a Path,
    number: usize,
    text: &'a str,
}

impl<'a> Line<'a> {
    /// The line that a reader is at, without its end.
    fn of<R: BufRead>(lines: &'a LineReader<R>) -> Self {
        Self {
            path: lines.path(),
            number: lines.line_number(),
            text: lines.text(),
        }
    }

    fn error(
        &self,
        byte: usize,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> FormatError {
        let column = self.text[..byte].chars().count() + 1;
        FormatError::at(self.path, self.number, Some(column), found, expected)
    }
}

/// Columns of the table.
struct Header {
    separator: u8,
    /// Meaning of each cell of a line; `None` for a column that is not read.
    columns: Vec<Option<Column>>,
    /// The names.
    names: Vec<String>,
    /// Line of the header, for messages.
    line: usize,
}

/// A column that is read.
#[derive(Clone, Copy)]
struct Column {
    named: Named,
    /// In SI units; none: it is the SI unit.
    unit: Option<f64>,
}

/// A cell of the header: the name, and what stands in brackets behind it.
fn name_and_unit(text: &str) -> (&str, Option<&str>) {
    let Some(open) = text.find(['[', '(']) else {
        return (text, None);
    };
    let unit = text[open + 1..].trim_end();
    let unit = unit.strip_suffix([']', ')']).unwrap_or(unit).trim();
    (text[..open].trim_end(), Some(unit))
}

/// The column of a cell of the header; none for one that is not read.
fn column_of(line: Line<'_>, cell: Cell<'_>) -> Result<Option<Column>, FormatError> {
    let (name, unit) = name_and_unit(cell.text);
    let Some(named) = Named::of(name) else {
        return match IGNORED.contains(&name) {
            true => Ok(None),
            false => Err(unknown_column(line, cell, name)),
        };
    };
    let none = ["", "1", "-"];
    let unit = match (unit.filter(|unit| !none.contains(unit)), named.dimension()) {
        (None, _) => None,
        (Some(unit), dimension) => {
            let size = dimension.and_then(|dimension| {
                let one = Quantity::parse(&format!("1 {unit}")).ok()?;
                one.value(dimension).ok()
            });
            let expected = || match dimension {
                Some(dimension) => format!("{} ({})", dimension.words(), dimension.units()),
                None => "no unit".to_owned(),
            };
            let size = size.filter(|size| *size > 0.0 && size.is_finite());
            let size = size.ok_or_else(|| {
                let found = format!("the unit \"{}\" of column {name}", shorten(unit));
                line.error(cell.start, found, expected())
            })?;
            Some(size)
        }
    };
    Ok(Some(Column { named, unit }))
}

impl Header {
    fn parse(line: Line<'_>) -> Result<Self, Vec<FormatError>> {
        let separator = match detect_separator(line.text) {
            Ok(Some(separator)) => separator,
            // Reported below: one cell cannot name four columns.
            Ok(None) => b',',
            Err(several) => {
                let first = line.text.find(several[1]).unwrap_or(0);
                let names: Vec<_> = several.iter().map(|c| format!("{c:?}")).collect();
                return Err(vec![line.error(
                    first,
                    format!("several separators ({}) in the header", names.join(", ")),
                    "one of comma, semicolon, tab",
                )]);
            }
        };
        let cells: Vec<Cell<'_>> = Cells::new(line.text, separator).collect();
        if cells.iter().all(|cell| parse_number(cell.text).is_some()) {
            let error = line.error(0, "numbers in the first line", "the names of the columns");
            let help = format!("add a line like {}", COLUMNS[..REQUIRED].join(","));
            return Err(vec![error.with_help(help)]);
        }
        let mut columns: Vec<Option<Column>> = Vec::with_capacity(cells.len());
        let mut errors = Vec::new();
        // Names that are there, right or not: one that has a wrong unit is not missing.
        let mut there: Vec<Named> = Vec::new();
        for &cell in &cells {
            if errors.len() == MOST_MISTAKES {
                return Err(errors);
            }
            let named = Named::of(name_and_unit(cell.text).0);
            if let Some(named) = named.filter(|named| there.contains(named)) {
                errors.push(line.error(
                    cell.start,
                    format!("column {} a second time", named.name()),
                    "each column once",
                ));
                continue;
            }
            there.extend(named);
            match column_of(line, cell) {
                Ok(column) => columns.push(column),
                Err(error) => errors.push(error),
            }
        }
        let has = |column: usize| there.contains(&Named::Fixed(column));
        // A table of clumps alone needs no radii.
        let needed = (0..REQUIRED).filter(|&column| column != RADIUS || !has(CLUMP));
        let missing: Vec<&str> = needed
            .filter(|&column| !has(column))
            .map(|column| COLUMNS[column])
            .collect();
        // An unknown column may be the one that is missing.
        if !missing.is_empty() && errors.is_empty() {
            let found = format!("no column {}", listed(missing));
            let error = line.error(0, found, "the columns x, y, z and radius");
            errors.push(error.with_help(format!(
                "add it to the header and to each line, in m or with its unit, as x [mm]; found only {}",
                line.text.trim()
            )));
        }
        let turns = (CLUMP + 2..COLUMNS.len())
            .filter(|&column| has(column))
            .count();
        if has(CLUMP) && !matches!(turns, 0 | 4) {
            let found = "an orientation in part";
            errors.push(line.error(0, found, "all of qw, qx, qy and qz, or none"));
        }
        if !errors.is_empty() {
            return Err(errors);
        }
        Ok(Self {
            separator,
            names: cells.iter().map(|cell| cell.text.to_owned()).collect(),
            columns,
            line: line.number,
        })
    }

    fn row(&self, line: Line<'_>) -> Result<ParticleRow, FormatError> {
        self.cells_of(line).map_err(|error| {
            // A wrong number of cells explains a bad cell better than the cell itself.
            let found = Cells::new(line.text, self.separator).count();
            if found == self.columns.len() {
                error
            } else {
                self.wrong_count(line)
            }
        })
    }

    fn cells_of(&self, line: Line<'_>) -> Result<ParticleRow, FormatError> {
        let mut found = [None; COLUMNS.len()];
        let mut units = [None; COLUMNS.len()];
        let mut properties = Vec::new();
        let mut cells = Cells::new(line.text, self.separator);
        for &column in &self.columns {
            let Some(cell) = cells.next() else {
                return Err(self.wrong_count(line));
            };
            let Some(Column { named, unit }) = column else {
                continue;
            };
            match named {
                Named::Fixed(column) => (found[column], units[column]) = (Some(cell), unit),
                Named::Property(place) => properties.push((place, cell, unit)),
            }
        }
        if cells.next().is_some() {
            return Err(self.wrong_count(line));
        }
        let text = |column: usize| {
            let cell = found[column].filter(|cell| !cell.text.is_empty())?;
            Some(cell.value().into_owned())
        };
        let clump = text(CLUMP);
        // 1 for the scale and for the first number of an orientation that is not given.
        let mut values = [0.0; COLUMNS.len()];
        (values[CLUMP + 1], values[CLUMP + 2]) = (1.0, 1.0);
        for (column, cell) in found.into_iter().enumerate() {
            let Some(cell) = cell.filter(|_| column != MATERIAL && column != CLUMP) else {
                continue;
            };
            // Spheres have no scale and orientation, clumps no radius.
            let is_needless = if column == RADIUS {
                clump.is_some()
            } else {
                column > CLUMP && clump.is_none()
            };
            if !(is_needless && cell.text.is_empty()) {
                values[column] = number(line, cell, column)? * units[column].unwrap_or(1.0);
            }
        }
        // In the order of the table, whatever that of the header.
        properties.sort_unstable_by_key(|(place, ..)| *place);
        let property = |(place, cell, unit): (usize, Cell<'_>, Option<f64>)| {
            let property = &PARTICLE_PROPERTIES[place];
            let range = property.given.map_or(Range::Any, |given| given.range);
            let value = finite(line, cell, property.name)? * unit.unwrap_or(1.0);
            if range.holds(value) {
                return Ok((property, value));
            }
            let expected = format!("a number {} ({})", range.text(), property.unit_of_frames());
            Err(line.error(cell.start, found_in(cell, property.name), expected))
        };
        let properties = properties.into_iter().map(property);
        let mut properties = properties.collect::<Result<Vec<_>, FormatError>>()?;
        properties.retain(|(property, value)| property.differs(*value));
        if clump.is_none() && found[RADIUS].is_none() {
            return Err(line
                .error(0, "a sphere without a radius", "a column radius")
                .with_help("a row without the name of a clump is a sphere"));
        }
        let clump = clump.map(|name| {
            let orientation = [0, 1, 2, 3].map(|part| values[CLUMP + 2 + part]);
            Box::new(ClumpCells {
                name,
                orientation,
                scale: values[CLUMP + 1],
            })
        });
        if clump
            .as_ref()
            .is_some_and(|clump| clump.orientation == [0.0; 4])
        {
            let at = found[CLUMP + 2].map_or(0, |cell| cell.start);
            return Err(line.error(
                at,
                "an orientation of length 0",
                "qw, qx, qy, qz of another length",
            ));
        }
        let vector = |first: usize| DVec3::new(values[first], values[first + 1], values[first + 2]);
        Ok(ParticleRow {
            position: vector(0),
            radius: if clump.is_some() { 0.0 } else { values[RADIUS] },
            clump,
            material: text(MATERIAL),
            velocity: vector(5),
            angular_velocity: vector(8),
            properties,
            line: line.number,
        })
    }

    /// Points at the first cell too many, or at the end of a line with too few.
    fn wrong_count(&self, line: Line<'_>) -> FormatError {
        let surplus = Cells::new(line.text, self.separator).nth(self.columns.len());
        let byte = surplus.map_or(line.text.len(), |cell| cell.start);
        let found = Cells::new(line.text, self.separator).count();
        let error = line.error(
            byte,
            format!("{found} {}", if found == 1 { "cell" } else { "cells" }),
            format!(
                "{} as in the header (line {})",
                self.columns.len(),
                self.line
            ),
        );
        let name = match self.separator {
            b',' => "comma",
            b';' => "semicolon",
            _ => "tab",
        };
        error.with_help(format!("cells are separated by {name} here, as in the header; an unused cell of the material or clump may be empty, a number may not"))
    }
}

fn number(line: Line<'_>, cell: Cell<'_>, column: usize) -> Result<f64, FormatError> {
    let name = COLUMNS[column];
    let value = finite(line, cell, name)?;
    let found = || found_in(cell, name);
    match name {
        "radius" if value <= 0.0 => Err(line
            .error(cell.start, found(), "a radius above 0")
            .with_help("radii are in m; remove the particle if it should not be there")),
        "scale" if value <= 0.0 => Err(line.error(cell.start, found(), "a factor above 0")),
        _ => Ok(value),
    }
}

fn found_in(cell: Cell<'_>, name: &str) -> String {
    format!("\"{}\" in column {name}", shorten(cell.text))
}

/// The number of a cell in the column of this name.
fn finite(line: Line<'_>, cell: Cell<'_>, name: &str) -> Result<f64, FormatError> {
    let found = || found_in(cell, name);
    let Some(value) = parse_number(cell.text) else {
        let error = line.error(cell.start, found(), "a number");
        return Err(if cell.text.is_empty() {
            error.with_help("every particle needs this number: remove the column or fill it")
        } else if parse_number(&cell.text.replacen(',', ".", 1)).is_some() {
            error.with_help("write a decimal point, not a comma")
        } else {
            error
        });
    };
    if !value.is_finite() {
        return Err(line.error(cell.start, found(), "a finite number"));
    }
    Ok(value)
}

fn unknown_column(line: Line<'_>, cell: Cell<'_>, name: &str) -> FormatError {
    let error = line.error(
        cell.start,
        format!("unknown column \"{}\"", shorten(name)),
        format!(
            "one of {}; not read, but no mistake: {}",
            all_names().join(", "),
            IGNORED.join(", ")
        ),
    );
    let lower = name.to_lowercase();
    // A header cell may be a whole misread file: names are short.
    let start: String = lower.chars().take(64).collect();
    // Common names in other programs; slips of the keyboard are found below.
    let meant = match lower.as_str() {
        "r" | "rad" => Some("radius"),
        "d" | "diameter" => {
            return error
                .with_help("radii are wanted: halve the diameters and name the column radius");
        }
        "species" | "mat" => Some("material"),
        "omega_x" | "omegax" => Some("wx"),
        "omega_y" | "omegay" => Some("wy"),
        "omega_z" | "omegaz" => Some("wz"),
        _ => all_names()
            .into_iter()
            .map(|name| (levenshtein(&start, name), name))
            .min()
            .filter(|(distance, name)| *distance <= name.len() / 2)
            .map(|(_, name)| name),
    };
    match meant {
        Some(name) => error.with_help(format!("did you mean {name}?")),
        None if name.split_ascii_whitespace().count() > 1 => {
            error.with_help("separate the columns by comma, semicolon or tab")
        }
        None => error.with_help("remove the column, or start the line with # if it is a comment"),
    }
}
