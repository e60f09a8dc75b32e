//! Tables of numbers in comma-separated text with a fixed header.

use std::path::Path;

use mercury_common::formats::number::parse_number;

/// The line of a row, and its numbers.
type Numbered<const N: usize> = (usize, [f64; N]);

/// Reads a file with these columns, in this order; empty lines and lines that begin with `#` are skipped. Each row comes with its line.
///
/// # Errors
/// If the file cannot be read, has another header, no row, or a row with another number of cells or a cell that is no finite number; with
/// the path and the line.
pub(super) fn read<const N: usize>(
    path: &Path,
    columns: [&str; N],
) -> Result<Vec<Numbered<N>>, String> {
    let name = path.display();
    let text = std::fs::read_to_string(path).map_err(|e| format!("{name} cannot be read: {e}"))?;
    parse(&text, columns).map_err(|(line, message)| format!("{name}:{line}: {message}"))
}

fn parse<const N: usize>(
    text: &str,
    columns: [&str; N],
) -> Result<Vec<Numbered<N>>, (usize, String)> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let header = columns.join(",");
    let mut lines = text.lines().enumerate().filter(|(_, line)| {
        let line = line.trim();
        !line.is_empty() && !line.starts_with('#')
    });
    let Some((first, found)) = lines.next() else {
        return Err((
            1,
            format!("the table is empty, expected the header {header}"),
        ));
    };
    if !found.split(',').map(str::trim).eq(columns) {
        let message = format!("expected the header {header}, got {}", found.trim());
        return Err((first + 1, message));
    }
    let mut rows = Vec::new();
    for (index, line) in lines {
        let cells = line.split(',').map(|cell| parse_number(cell.trim()));
        let cells: Option<Vec<f64>> = cells.map(|cell| cell.filter(|x| x.is_finite())).collect();
        match cells.and_then(|cells| <[f64; N]>::try_from(cells).ok()) {
            Some(row) => rows.push((index + 1, row)),
            None => {
                let message = format!("expected {N} finite numbers, got {}", line.trim());
                return Err((index + 1, message));
            }
        }
    }
    if rows.is_empty() {
        return Err((first + 1, "no rows below the header".to_owned()));
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_with_their_lines() {
        let text = "\u{feff}# flow\nt,rate\n\n0, 1e-6\r\n0.5,2e-6\n";
        let rows = parse(text, ["t", "rate"]).unwrap();
        assert_eq!(rows, [(4, [0.0, 1e-6]), (5, [0.5, 2e-6])]);
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        let wrong = |text: &str| parse(text, ["t", "rate"]).unwrap_err();
        assert_eq!(wrong("").0, 1);
        assert_eq!(
            wrong("time,rate\n0,1\n").1,
            "expected the header t,rate, got time,rate"
        );
        assert_eq!(wrong("t,rate\n").1, "no rows below the header");
        for row in ["0", "0,1,2", "0,x", "0,inf", "nan,1", "0,0x1"] {
            let (line, message) = wrong(&format!("t,rate\n{row}\n"));
            assert_eq!(line, 2);
            assert_eq!(message, format!("expected 2 finite numbers, got {row}"));
        }
    }
}
