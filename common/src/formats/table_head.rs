//! Heads of text tables: of each column its name, and its unit in brackets: `time [s],name,fz [N]`.

/// Name and SI unit of a column; the unit is empty, or `1`, where it has none.
pub type TableColumn = (&'static str, &'static str);

/// The cell of a head for a column of this name and unit.
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
        .and_then(|cell| cell.split_once(" ["))
    {
        Some((name, _)) => name,
        None => cell,
    }
}

/// The first line of a table, with its end.
#[must_use]
pub fn line<'a>(columns: impl IntoIterator<Item = &'a TableColumn>) -> String {
    let cells = columns.into_iter().map(|(name, unit)| cell(name, unit));
    cells.collect::<Vec<_>>().join(",") + "\n"
}
