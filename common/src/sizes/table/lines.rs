//! The lines of a table: header, cells, numbers.

use std::path::Path;

use super::header::{Columns, Contradiction, Head, SizeKind, ValueKind};
use super::{Model, Options};
use crate::error::FormatError;
use crate::formats::lines::shorten;
use crate::formats::number::parse_number;
use crate::scene::Weighting;
use crate::sizes::ClassModel;

/// One row of numbers, before any rule.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Line of the file, counted from 1.
    pub line: usize,
    /// The size, in the unit of the table; 0 for the pan.
    pub size: f64,
    /// The value; unused for a list of sizes.
    pub value: f64,
}

/// The comment with the distribution inside a class.
const MODEL_MARK: &str = "in-class:";

/// The comment of a list whose sizes were drawn by quota. Other words behind the colon do not matter here.
pub const BY_QUOTA: [&str; 2] = ["sampling", "quota"];

const EXAMPLE: &str = "a header such as: diameter [mm],cumulative volume [%]";
const TYPES: &str = "cumulative, fraction (of the class that ends there), retained (on the sieve) or cumulative retained (on it and all larger ones), by number, length, area, volume or mass";

#[derive(Clone, Copy)]
struct Line<'a> {
    path: &'a Path,
    number: usize,
    text: &'a str,
}

impl Line<'_> {
    fn error(&self, byte: usize, found: impl Into<String>, expected: &str) -> FormatError {
        let column = self.text[..byte].chars().count() + 1;
        FormatError::at(self.path, self.number, Some(column), found, expected)
    }
}

#[derive(Clone, Copy)]
struct Cell<'a> {
    text: &'a str,
    start: usize,
}

/// Where size and value stand in a row, and how rows are cut.
struct Layout {
    separator: Option<char>,
    size: usize,
    value: Option<usize>,
    /// Number of cells that a row may have.
    columns: usize,
}

/// Content of the lines.
pub(super) struct Read {
    /// Meaning of the columns.
    pub(super) columns: Columns,
    pub(super) rows: Vec<Row>,
    /// Notes of what was left out.
    pub(super) notes: Vec<String>,
    pub(super) by_quota: bool,
}

/// Reads all lines.
pub(super) fn read(path: &Path, text: &str, options: &Options) -> Result<Read, FormatError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut notes = Vec::new();
    let mut model = None;
    let mut by_quota = false;
    let mut head: Option<(Columns, Layout)> = None;
    let mut rows = Vec::new();
    for (index, text) in text.lines().enumerate() {
        let line = Line {
            path,
            number: index + 1,
            text,
        };
        if let Some(comment) = text.trim_start().strip_prefix('#') {
            if let Some(word) = comment.trim().strip_prefix(MODEL_MARK) {
                model = Some(parse_model(line, word.trim())?);
            }
            if let Some((key, word)) = comment.split_once(':') {
                by_quota |= [key.trim(), word.trim()] == BY_QUOTA;
            }
            continue;
        }
        let content = text.split('#').next().unwrap_or("");
        if content.trim().is_empty() {
            continue;
        }
        let Some((_, layout)) = &head else {
            let separator = separator(content);
            let cells = cells(content, separator);
            let is_header = cells
                .first()
                .is_some_and(|c| number(c.text, separator).is_none());
            let (mut columns, layout) = if is_header {
                header(line, &cells, separator, options, &mut notes)?
            } else {
                (
                    without_header(line, &cells, options)?,
                    Layout {
                        separator,
                        size: 0,
                        value: options.values.map(|_| 1),
                        columns: if options.values.is_some() { 2 } else { 1 },
                    },
                )
            };
            if let Some(wanted) = options.model.or(model.map(Model::Of)) {
                let measured = columns.values.map_or(Weighting::Number, |(_, w)| w);
                columns.model = wanted.resolve(measured);
            }
            if !is_header {
                rows.push(row(line, &cells, &layout)?);
            }
            head = Some((columns, layout));
            continue;
        };
        let cells = cells(content, layout.separator);
        rows.push(row(line, &cells, layout)?);
    }
    match head {
        Some((columns, _)) => Ok(Read {
            columns,
            rows,
            notes,
            by_quota,
        }),
        None => Err(FormatError {
            expected: EXAMPLE.to_owned(),
            ..FormatError::of_file(path, "the table is empty")
        }),
    }
}

fn parse_model(line: Line<'_>, word: &str) -> Result<ClassModel, FormatError> {
    ClassModel::from_word(word).ok_or_else(|| {
        let words: Vec<&str> = ClassModel::all().map(|(word, _)| word).collect();
        let found = format!("\"{}\" for the model inside a class", shorten(word));
        line.error(0, found, &format!("one of {}", words.join(", ")))
    })
}

/// The separator of a line: semicolon or tab if there is one, else comma; none: blanks.
fn separator(line: &str) -> Option<char> {
    [';', '\t', ','].into_iter().find(|&c| line.contains(c))
}

fn cells(line: &str, separator: Option<char>) -> Vec<Cell<'_>> {
    let cell = |text: &str| text.as_ptr() as usize - line.as_ptr() as usize;
    let trimmed = line.trim();
    match separator {
        Some(separator) => trimmed
            .strip_suffix(separator)
            .unwrap_or(trimmed)
            .split(separator)
            .map(|text| {
                let text = text.trim();
                Cell {
                    text,
                    start: cell(text),
                }
            })
            .collect(),
        None => trimmed
            .split_whitespace()
            .map(|text| Cell {
                text,
                start: cell(text),
            })
            .collect(),
    }
}

/// A number; with a decimal comma where commas do not separate cells.
fn number(text: &str, separator: Option<char>) -> Option<f64> {
    let text = text.trim_matches('"').trim();
    parse_number(text).or_else(|| {
        let has_decimal_comma =
            separator != Some(',') && text.matches(',').count() == 1 && !text.contains('.');
        if has_decimal_comma {
            parse_number(&text.replace(',', "."))
        } else {
            None
        }
    })
}

fn header(
    line: Line<'_>,
    cells: &[Cell<'_>],
    separator: Option<char>,
    options: &Options,
    notes: &mut Vec<String>,
) -> Result<(Columns, Layout), FormatError> {
    // Blanks in a header are parts of names; a header without separator is one column.
    let whole;
    let cells = if separator.is_none() {
        let text = line.text.split('#').next().unwrap_or("").trim();
        let start = line.text.len() - line.text.trim_start().len();
        whole = [Cell { text, start }];
        &whole[..]
    } else {
        cells
    };
    let heads: Vec<Head<'_>> = cells.iter().map(|cell| Head::of(cell.text)).collect();
    let contradicts = |index: usize, contradiction: &Contradiction| {
        line.error(
            cells[index].start,
            format!("\"{}\" with {contradiction}", shorten(cells[index].text)),
            "a name with one meaning",
        )
    };
    let mut sizes = Vec::new();
    for (index, head) in heads.iter().enumerate() {
        let size = head.size().map_err(|words| contradicts(index, &words))?;
        sizes.extend(size.map(|size| (index, size)));
    }
    let (size_column, of_header) = match sizes[..] {
        [(index, size)] => (index, Some(size)),
        [] if options.size.is_some() => (0, None),
        [] => {
            let error = line.error(
                cells.first().map_or(0, |cell| cell.start),
                "a header without a column of sizes",
                EXAMPLE,
            );
            return Err(
                error.with_help("name it diameter, radius or sieve, with its unit in brackets")
            );
        }
        [_, (second, _), ..] => {
            let found = format!(
                "\"{}\", a second column of sizes",
                shorten(cells[second].text)
            );
            return Err(line
                .error(cells[second].start, found, "one")
                .with_help("take out the columns that are not wanted"));
        }
    };
    let size = options.size.or(of_header);
    let per_metre = match (options.per_metre, heads[size_column].unit) {
        (Some(per_metre), _) => per_metre,
        (None, Some(unit)) => super::parse_size_unit(unit).ok_or_else(|| {
            let found = format!("the unit \"{}\" of the sizes", shorten(unit));
            line.error(cells[size_column].start, found, "m, cm, mm, um or nm")
        })?,
        (None, None) => {
            return Err(no_unit(line, cells[size_column].start));
        }
    };
    let mut value_columns = Vec::new();
    for (index, head) in heads.iter().enumerate() {
        if index == size_column {
            continue;
        }
        match head.values() {
            Ok(values) => value_columns.extend(values.map(|values| (index, values))),
            // The command line gives the meaning of its values.
            Err(_) if options.values.is_some() => {
                value_columns.push((index, (ValueKind::Cumulative, None)))
            }
            Err(words) => {
                return Err(contradicts(index, &words).with_help("retained is what stays on a sieve, passing what falls through it; number, length, area and volume (mass) exclude each other"));
            }
        }
    }
    let mut value = None;
    let mut values = options.values;
    match value_columns[..] {
        [(index, (kind, weighting))] => {
            value = Some(index);
            // Sieves are weighed.
            let sieved = kind.is_of_sieves() || size == Some(SizeKind::Sieve);
            let weighting = weighting.or(sieved.then_some(Weighting::Volume));
            if values.is_none() {
                let Some(weighting) = weighting else {
                    let found = format!(
                        "\"{}\", which does not say of what",
                        shorten(cells[index].text)
                    );
                    return Err(line.error(cells[index].start, found, TYPES));
                };
                values = Some((kind, weighting));
            }
        }
        [] if options.values.is_some() && cells.len() > 1 => {
            value = Some(usize::from(size_column == 0));
        }
        [] if cells.len() > 1 => {
            let other = usize::from(size_column == 0);
            let found = format!("the column \"{}\"", shorten(cells[other].text));
            let error = line.error(cells[other].start, found, TYPES);
            return Err(error.with_help("a list of sizes has one column"));
        }
        [] => {
            if values.is_some() {
                return Err(line.error(cells[size_column].start, "one column", "sizes and shares"));
            }
        }
        [_, (second, _), ..] => {
            let found = format!(
                "\"{}\", a second column of shares",
                shorten(cells[second].text)
            );
            return Err(line
                .error(cells[second].start, found, "one")
                .with_help("take out the columns that are not wanted"));
        }
    }
    let unit = match value {
        Some(index) => heads[index].value_unit().map_err(|unit| {
            let found = format!("the unit \"{}\" of the shares", shorten(&unit));
            line.error(cells[index].start, found, "%, - (1 is all), g, kg or count")
        })?,
        None => None,
    };
    for (index, cell) in cells.iter().enumerate() {
        if index != size_column && Some(index) != value {
            notes.push(format!("the column \"{}\" is not read", shorten(cell.text)));
        }
    }
    let columns = Columns {
        size: size.unwrap_or(SizeKind::Diameter),
        per_metre,
        values,
        unit,
        model: ClassModel::default(),
        mercury: options.mercury,
    };
    let layout = Layout {
        separator,
        size: size_column,
        value,
        columns: heads.len(),
    };
    Ok((columns, layout))
}

fn no_unit(line: Line<'_>, byte: usize) -> FormatError {
    line.error(byte, "sizes without a unit", "for example diameter [mm]")
        .with_help("units are m, cm, mm, um and nm; mercury-psd also takes --unit mm")
}

fn without_header(
    line: Line<'_>,
    cells: &[Cell<'_>],
    options: &Options,
) -> Result<Columns, FormatError> {
    let (Some(size), Some(per_metre)) = (options.size, options.per_metre) else {
        let error = line.error(cells.first().map_or(0, |c| c.start), "no header", EXAMPLE);
        return Err(error.with_help(
            "mercury-psd also takes --size diameter --unit mm --type cumulative-volume",
        ));
    };
    if cells.len() > 1 && options.values.is_none() {
        let error = line.error(cells[1].start, "a second column and no header", EXAMPLE);
        return Err(error.with_help("mercury-psd also takes --type cumulative-volume"));
    }
    Ok(Columns {
        size,
        per_metre,
        values: options.values,
        unit: None,
        model: ClassModel::default(),
        mercury: options.mercury,
    })
}

fn row(line: Line<'_>, cells: &[Cell<'_>], layout: &Layout) -> Result<Row, FormatError> {
    let value_of = |column: usize, name: &str| -> Result<f64, FormatError> {
        let Some(cell) = cells.get(column).filter(|cell| !cell.text.is_empty()) else {
            let end = line.text.trim_end().len();
            return Err(line.error(
                cells.get(column).map_or(end, |cell| cell.start),
                format!("no {name} in this row"),
                "a number",
            ));
        };
        if name == "size" && cell.text.eq_ignore_ascii_case("pan") {
            return Ok(0.0);
        }
        let found = || format!("\"{}\" for the {name}", shorten(cell.text));
        match number(cell.text, layout.separator) {
            Some(number) if number.is_finite() => Ok(number),
            Some(_) => Err(line.error(cell.start, found(), "a finite number")),
            None => {
                let error = line.error(cell.start, found(), "a number");
                Err(if cell.text.matches(',').count() == 1 {
                    error.with_help("write a decimal point, or separate the columns by semicolons")
                } else {
                    error
                })
            }
        }
    };
    let size = value_of(layout.size, "size")?;
    let value = match layout.value {
        Some(column) => value_of(column, "share")?,
        None => 0.0,
    };
    // A further cell has no header, and "2,0,5" is a decimal comma; spreadsheets leave empty cells.
    if let Some(cell) = (cells.iter().skip(layout.columns)).find(|cell| !cell.text.is_empty()) {
        let found = format!("\"{}\", one value too many", shorten(cell.text));
        let error = line.error(cell.start, found, &format!("{} per row", layout.columns));
        return Err(error.with_help("write a decimal point, or separate the columns by semicolons"));
    }
    Ok(Row {
        line: line.number,
        size,
        value,
    })
}
