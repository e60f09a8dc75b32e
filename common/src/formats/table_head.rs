//! Heads of text tables: of each column its name, and its unit in brackets: `time [s],name,fz [N]`.

use super::delimited::push_line;

/// The cell of a head for a column of this name and SI unit; the unit is empty, or `1`, where it has none.
///
/// ```
/// use mercury_common::formats::table_head::{cell, name};
///
/// assert_eq!(cell("fz", "N"), "fz [N]");
/// assert_eq!(cell("qw", "1"), "qw");
/// // The name comes back from heads with units and from those without.
/// assert_eq!((name("fz [N]"), name("fz")), ("fz", "fz"));
/// ```
#[must_use]
pub fn cell(name: &str, unit: &str) -> String {
    match unit {
        "" | "1" => name.to_owned(),
        _ => format!("{name} [{unit}]"),
    }
}

/// The name in a cell of a head, with or without a unit.
#[must_use]
pub fn name(cell: &str) -> &str {
    let cell = cell.trim();
    match cell
        .strip_suffix(']')
        .and_then(|cell| cell.rsplit_once(" ["))
    {
        Some((name, _)) => name,
        None => cell,
    }
}

/// The first line of a table with columns of these names and units, with its end.
#[must_use]
pub fn line(columns: impl IntoIterator<Item = (impl AsRef<str>, impl AsRef<str>)>) -> String {
    let mut out = Vec::new();
    let cells = columns.into_iter();
    push_line(
        &mut out,
        cells.map(|(name, unit)| cell(name.as_ref(), unit.as_ref())),
    );
    String::from_utf8_lossy(&out).into_owned()
}
