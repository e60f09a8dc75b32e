//! A line of comma-separated values.

/// Cells with commas between them and the end of the line. Cells with a comma, a quote or an end of line are in quotes, with
/// quotes within them doubled (RFC 4180).
///
/// ```
/// use mercury_common::formats::csv_line::csv_line;
/// assert_eq!(csv_line(["1", "a,\"b\""]), "1,\"a,\"\"b\"\"\"\n");
/// ```
#[must_use]
pub fn csv_line(cells: impl IntoIterator<Item = impl AsRef<str>>) -> String {
    let cell = |cell: &str| match cell.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", cell.replace('"', "\"\"")),
        false => cell.to_owned(),
    };
    let cells: Vec<String> = (cells.into_iter())
        .map(|text| cell(text.as_ref()))
        .collect();
    cells.join(",") + "\n"
}
