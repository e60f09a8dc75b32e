//! Pebble lists: one sphere per line, `x,y,z,r` in m.
//!
//! See `docs/formats/pebble-list.md`. Cells are separated by commas, semicolons or blanks; a header is optional; blank lines and
//! comments (`#`, `%` or `//` to the end of the line) are skipped.

use std::path::Path;

use glam::DVec3;

use super::clump::Pebble;
use super::lines::shorten;
use super::number::{NumberStyle, parse_number, push_number};
use crate::error::FormatError;

/// Columns by name, as a header may call them.
const NAMES: [&[&str]; 4] = [&["x"], &["y"], &["z"], &["r", "radius"]];

/// Reads a pebble list.
///
/// # Errors
/// If the file cannot be read or is not UTF-8; if a line has not four finite numbers or a radius is not above 0; if a header has other
/// columns than x, y, z and r (or radius); if there is no pebble.
pub fn read_pebble_list(path: impl AsRef<Path>) -> Result<Vec<Pebble>, FormatError> {
    let path = path.as_ref();
    let bytes = super::read_bytes(path)?;
    let text = std::str::from_utf8(&bytes).map_err(|error| {
        let line = 1 + bytes[..error.valid_up_to()]
            .iter()
            .filter(|&&b| b == b'\n')
            .count();
        FormatError::at(path, line, None, "bytes that are not text", "a list of pebbles x,y,z,r")
            .with_help("a surface needs a name that ends in .stl or .obj; a table must be saved as CSV in UTF-8")
    })?;
    parse_pebble_list(path, text)
}

/// Reads a pebble list from memory; `path` is used in messages only.
///
/// # Errors
/// As [`read_pebble_list`].
pub fn parse_pebble_list(path: &Path, text: &str) -> Result<Vec<Pebble>, FormatError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut order = [0, 1, 2, 3];
    let mut first = true;
    let mut pebbles = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let line = Line {
            path,
            number: index + 1,
            text: line,
        };
        let cells = cells(without_comment(line.text));
        if cells.is_empty() {
            continue;
        }
        if std::mem::take(&mut first) && cells.iter().all(|cell| parse_number(cell.text).is_none())
        {
            order = header(line, &cells)?;
            continue;
        }
        pebbles.push(pebble(line, &cells, order)?);
    }
    if pebbles.is_empty() {
        return Err(FormatError {
            expected: "at least one line x,y,z,r".into(),
            ..FormatError::of_file(path, "the list has no pebbles")
        });
    }
    Ok(pebbles)
}

/// Appends a pebble list with a header.
pub fn push_pebble_list(pebbles: &[Pebble], style: NumberStyle, out: &mut Vec<u8>) {
    out.extend_from_slice(b"x,y,z,r\n");
    for pebble in pebbles {
        for value in pebble.position.to_array() {
            push_number(out, value, style);
            out.push(b',');
        }
        push_number(out, pebble.radius, style);
        out.push(b'\n');
    }
}

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

struct Cell<'a> {
    text: &'a str,
    start: usize,
}

fn without_comment(line: &str) -> &str {
    let end = ["#", "%", "//"]
        .iter()
        .filter_map(|mark| line.find(mark))
        .min();
    &line[..end.unwrap_or(line.len())]
}

/// The cells of a line; none for a blank line. A separator at the end of the line is ignored.
fn cells(line: &str) -> Vec<Cell<'_>> {
    let offset = |text: &str| text.as_ptr() as usize - line.as_ptr() as usize;
    let cell = |text| Cell {
        text,
        start: offset(text),
    };
    let trimmed = line.trim();
    let separator = [';', ','].into_iter().find(|&c| trimmed.contains(c));
    match separator {
        _ if trimmed.is_empty() => Vec::new(),
        Some(separator) => {
            let trimmed = trimmed.strip_suffix(separator).unwrap_or(trimmed);
            trimmed
                .split(separator)
                .map(|text| cell(text.trim()))
                .collect()
        }
        None => trimmed.split_whitespace().map(cell).collect(),
    }
}

/// For x, y, z and radius the cell that holds it.
fn header(line: Line<'_>, cells: &[Cell<'_>]) -> Result<[usize; 4], FormatError> {
    let mut order = [usize::MAX; 4];
    for (index, cell) in cells.iter().enumerate() {
        let name = cell.text.trim_matches('"').to_lowercase();
        let Some(column) = NAMES
            .iter()
            .position(|names| names.contains(&name.as_str()))
        else {
            let error = line.error(
                cell.start,
                format!("the column \"{}\"", shorten(cell.text)),
                "the columns x, y, z and r",
            );
            return Err(if name == "d" || name == "diameter" {
                error.with_help("radii are wanted: halve the diameters and name the column r")
            } else {
                error.with_help("remove the column, or begin the line with # if it is a comment")
            });
        };
        if order[column] != usize::MAX {
            return Err(line.error(
                cell.start,
                format!("a second column {name}"),
                "each of x, y, z and r once",
            ));
        }
        order[column] = index;
    }
    match order.iter().position(|&index| index == usize::MAX) {
        Some(missing) => Err(line.error(
            line.text.trim_end().len(),
            format!("a header without {}", NAMES[missing][0]),
            "the columns x, y, z and r",
        )),
        None => Ok(order),
    }
}

fn pebble(line: Line<'_>, cells: &[Cell<'_>], order: [usize; 4]) -> Result<Pebble, FormatError> {
    if cells.len() != 4 {
        let at = cells
            .get(4)
            .map_or(line.text.trim_end().len(), |cell| cell.start);
        let found = format!(
            "{} {}",
            cells.len(),
            if cells.len() == 1 { "value" } else { "values" }
        );
        return Err(line
            .error(at, found, "four numbers: x, y, z and the radius")
            .with_help(
                "values are separated by commas, semicolons or blanks, and have a decimal point",
            ));
    }
    let mut values = [0.0; 4];
    for (column, value) in values.iter_mut().enumerate() {
        let cell = &cells[order[column]];
        let name = NAMES[column].last().copied().unwrap_or("");
        let found = || format!("\"{}\" for {name}", shorten(cell.text));
        *value = match parse_number(cell.text) {
            Some(value) if value.is_finite() => value,
            Some(_) => return Err(line.error(cell.start, found(), "a finite number")),
            None => {
                let error = line.error(cell.start, found(), "a number");
                return Err(
                    if parse_number(&cell.text.replacen(',', ".", 1)).is_some() {
                        error.with_help("write a decimal point, not a comma")
                    } else {
                        error
                    },
                );
            }
        };
        if column == 3 && *value <= 0.0 {
            return Err(line
                .error(cell.start, found(), "a radius above 0")
                .with_help("a pebble is x,y,z and its radius"));
        }
    }
    Ok(Pebble {
        position: DVec3::new(values[0], values[1], values[2]),
        radius: values[3],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference_data::shared;
    use proptest::prelude::*;

    fn parse(text: &str) -> Result<Vec<Pebble>, String> {
        parse_pebble_list(Path::new("p.csv"), text).map_err(|error| error.to_string())
    }

    #[test]
    fn every_usual_way_of_writing_is_read() {
        let expected = vec![
            Pebble {
                position: DVec3::new(1.0, -2.5, 3e-3),
                radius: 0.5,
            },
            Pebble {
                position: DVec3::ZERO,
                radius: 2.0,
            },
        ];
        for text in [
            "1,-2.5,3e-3,0.5\n0,0,0,2\n",
            "1;-2.5;3e-3;0.5\r\n0;0;0;2",
            "1 -2.5 3e-3 0.5\n\n 0\t0  0 2 \n",
            "\u{feff}x, y, z, r\n1, -2.5,  3e-3,0.5\n0,0,0,2",
            "# pebbles of a pear\nX Y Z Radius\n1 -2.5 3e-3 0.5 // the first\n% no more\n0 0 0 2 # the last",
            "r;z;y;x\n0.5;3e-3;-2.5;1;\n2;0;0;0;",
            "\"x\",\"y\",\"z\",\"r\"\n1,-2.5,3e-3,0.5\n0,0,0,2",
        ] {
            assert_eq!(parse(text).as_ref(), Ok(&expected), "{text:?}");
        }
    }

    #[test]
    fn mistakes_have_their_place() {
        for (text, expected) in [
            (
                "",
                "p.csv: the list has no pebbles, expected at least one line x,y,z,r",
            ),
            (
                "x,y,z,r\n# none\n",
                "p.csv: the list has no pebbles, expected at least one line x,y,z,r",
            ),
            (
                "0,0,0,1\n0,0,1\n",
                "p.csv:2:6: 3 values, expected four numbers: x, y, z and the radius\nhelp: values are separated by commas, semicolons or blanks, and have a decimal point",
            ),
            (
                "0 0 0 1 7\n",
                "p.csv:1:9: 5 values, expected four numbers: x, y, z and the radius\nhelp: values are separated by commas, semicolons or blanks, and have a decimal point",
            ),
            (
                "0,0,0,1\n\n0,zero,0,1\n",
                "p.csv:3:3: \"zero\" for y, expected a number",
            ),
            (
                "0;0;0;0,5\n",
                "p.csv:1:7: \"0,5\" for radius, expected a number\nhelp: write a decimal point, not a comma",
            ),
            (
                "0,0,nan,1\n",
                "p.csv:1:5: \"nan\" for z, expected a finite number",
            ),
            (
                "0,0,0,0\n",
                "p.csv:1:7: \"0\" for radius, expected a radius above 0\nhelp: a pebble is x,y,z and its radius",
            ),
            (
                "x,y,z,d\n0,0,0,1\n",
                "p.csv:1:7: the column \"d\", expected the columns x, y, z and r\nhelp: radii are wanted: halve the diameters and name the column r",
            ),
            (
                "x,y,r\n0,0,1\n",
                "p.csv:1:6: a header without z, expected the columns x, y, z and r",
            ),
            (
                "x,y,z,z,r\n",
                "p.csv:1:7: a second column z, expected each of x, y, z and r once",
            ),
        ] {
            assert_eq!(parse(text).unwrap_err(), expected, "{text:?}");
        }
    }

    #[test]
    fn bytes_that_are_not_text_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.csv");
        std::fs::write(&path, b"0,0,0,1\n\xff\xfe").unwrap();
        let error = read_pebble_list(&path).unwrap_err();
        assert_eq!((error.line, error.column), (Some(2), None));
        assert!(error.help.unwrap().contains(".stl or .obj"));
    }

    #[test]
    fn the_shared_lists_read() {
        let Some(folder) = shared("data/shapes/pebbles") else {
            return;
        };
        for (name, count) in [
            ("clump01_shipped.csv", 3),
            ("clump02_shipped.csv", 10),
            ("clump03_shipped.csv", 182),
            ("clump04_shipped.csv", 500),
            ("rattleback_500_input.csv", 500),
        ] {
            assert_eq!(
                read_pebble_list(folder.join(name)).unwrap().len(),
                count,
                "{name}"
            );
        }
    }

    proptest! {
        #[test]
        fn the_round_trip_is_exact(
            values in prop::collection::vec(([prop::num::f64::NORMAL, prop::num::f64::NORMAL, prop::num::f64::NORMAL], 1e-300..1e300), 1..20),
        ) {
            let pebbles: Vec<Pebble> = values.iter().map(|(position, radius)| Pebble { position: DVec3::from_array(*position), radius: *radius }).collect();
            let mut out = Vec::new();
            push_pebble_list(&pebbles, NumberStyle::Shortest, &mut out);
            prop_assert_eq!(parse(&String::from_utf8(out).unwrap()).unwrap(), pebbles);
        }

        #[test]
        fn garbage_never_panics(text in "([0-9.xyzr,; #%/\n\té-]{0,9}){0,20}", bytes in any::<String>()) {
            let _ = parse(&text);
            let _ = parse(&bytes);
        }
    }
}
