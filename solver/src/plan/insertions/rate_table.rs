//! Tables of what is to be inserted over time.

use std::path::Path;

use mercury_common::formats::number::parse_number;

/// Reads a table `t,cumulative`: a header, then rows of ascending time and not decreasing amount.
pub(super) fn read_rate_table(path: &Path) -> Result<Vec<[f64; 2]>, String> {
    let name = path.display();
    let text = std::fs::read_to_string(path).map_err(|e| format!("{name} cannot be read: {e}"))?;
    parse_rate_table(&text).map_err(|(line, message)| format!("{name}:{line}: {message}"))
}

fn parse_rate_table(text: &str) -> Result<Vec<[f64; 2]>, (usize, String)> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut lines = text.lines().enumerate().filter(|(_, line)| {
        let line = line.trim();
        !line.is_empty() && !line.starts_with('#')
    });
    let cells = |line: &str| -> Vec<String> {
        line.split(',').map(|cell| cell.trim().to_owned()).collect()
    };
    let Some((number, header)) = lines.next() else {
        return Err((
            1,
            "the table is empty, expected the header t,cumulative".to_owned(),
        ));
    };
    if cells(header) != ["t", "cumulative"] {
        let found = header.trim();
        return Err((
            number + 1,
            format!("expected the header t,cumulative, got {found}"),
        ));
    }
    let mut rows: Vec<[f64; 2]> = Vec::new();
    for (index, line) in lines {
        let fail = |message: String| Err((index + 1, message));
        let numbers: Vec<Option<f64>> = cells(line)
            .iter()
            .map(|cell| parse_number(cell).filter(|number| number.is_finite()))
            .collect();
        let &[Some(time), Some(amount)] = numbers.as_slice() else {
            return fail(format!("expected two numbers, got {}", line.trim()));
        };
        match rows.last() {
            Some(&[before, _]) if time <= before => {
                return fail(format!(
                    "t = {time} does not lie after {before}, the row before"
                ));
            }
            Some(&[_, before]) if amount < before => {
                return fail(format!(
                    "cumulative = {amount} lies below {before}, the row before"
                ));
            }
            None if amount < 0.0 => return fail(format!("cumulative = {amount} is negative")),
            _ => rows.push([time, amount]),
        }
    }
    if rows.is_empty() {
        return Err((number + 1, "no rows below the header".to_owned()));
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::parse_rate_table;

    #[test]
    fn rate_tables_are_read_and_their_mistakes_named() {
        let rows = parse_rate_table("# feed\nt,cumulative\n0, 0\n\n1.5,2\n");
        assert_eq!(rows, Ok(vec![[0.0, 0.0], [1.5, 2.0]]));
        for (text, line, message) in [
            (
                "",
                1,
                "the table is empty, expected the header t,cumulative",
            ),
            (
                "t,mass\n0,0\n",
                1,
                "expected the header t,cumulative, got t,mass",
            ),
            ("t,cumulative\n", 1, "no rows below the header"),
            ("t,cumulative\n0,x\n", 2, "expected two numbers, got 0,x"),
            (
                "t,cumulative\n0,1,2\n",
                2,
                "expected two numbers, got 0,1,2",
            ),
            (
                "t,cumulative\n0,inf\n",
                2,
                "expected two numbers, got 0,inf",
            ),
            ("t,cumulative\n0,-1\n", 2, "cumulative = -1 is negative"),
            (
                "t,cumulative\n0,1\n0,2\n",
                3,
                "t = 0 does not lie after 0, the row before",
            ),
            (
                "t,cumulative\n0,1\n1,0\n",
                3,
                "cumulative = 0 lies below 1, the row before",
            ),
        ] {
            assert_eq!(
                parse_rate_table(text),
                Err((line, message.to_owned())),
                "{text:?}"
            );
        }
    }
}
