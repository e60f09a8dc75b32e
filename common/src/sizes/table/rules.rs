//! From rows to a distribution: refusals, with the line, and repairs, with a note.

use std::path::Path;

use super::SizeTable;
use super::header::{Columns, SizeKind, ValueKind, ValueUnit};
use super::lines::Row;
use crate::error::FormatError;
use crate::scene::Weighting;
use crate::sizes::{ClassProblem, Classes};

/// Shares may miss their sum by this much (losses of a sieving, rounding); they are then scaled, with a note.
const TOLERANCE: f64 = 0.01;
/// Smaller differences are round-off of the printed digits and not worth a word.
const ROUND_OFF: f64 = 1e-9;

fn wrong(path: &Path, row: &Row, found: impl Into<String>, expected: &str) -> FormatError {
    FormatError::at(path, row.line, None, found, expected)
}

/// A list of sizes as diameters.
pub(super) fn sizes(path: &Path, columns: &Columns, rows: &[Row]) -> Result<Vec<f64>, FormatError> {
    let factor = if columns.size == SizeKind::Radius {
        2.0
    } else {
        1.0
    };
    if rows.is_empty() {
        return Err(FormatError::of_file(path, "no sizes below the header"));
    }
    rows.iter()
        .map(|row| {
            if row.size > 0.0 && row.size.is_finite() {
                Ok(factor * row.size / columns.per_metre)
            } else {
                Err(wrong(
                    path,
                    row,
                    format!("the size {}", row.size),
                    "a size above 0",
                ))
            }
        })
        .collect()
}

/// Shares of classes.
pub(super) fn table(
    path: &Path,
    columns: &Columns,
    kind: ValueKind,
    weighting: Weighting,
    rows: &[Row],
) -> Result<SizeTable, FormatError> {
    let mut notes = Vec::new();
    let mut rows = rows.to_vec();
    if rows.len() < 2 {
        let found = match rows.len() {
            0 => "no rows below the header".to_owned(),
            _ => "one row".to_owned(),
        };
        return Err(FormatError {
            expected: "at least two: a distribution has a smallest and a largest size".to_owned(),
            line: rows.first().map(|row| row.line),
            ..FormatError::of_file(path, found)
        }
        .with_help("one size alone: psd = { kind = \"monodisperse\", diameter = ... }"));
    }
    let is_sieve = columns.size == SizeKind::Sieve || kind.is_of_sieves();
    if is_sieve && rows[0].size > rows[1].size {
        rows.reverse();
    }
    check_sizes(path, &rows, is_sieve)?;
    check_values(path, columns, kind, &mut rows, &mut notes)?;
    let (edges, mut shares) = match kind {
        ValueKind::Cumulative => cumulative(path, columns, &mut rows, is_sieve, &mut notes)?,
        ValueKind::Fraction => fractions(path, columns, &mut rows, &mut notes)?,
        ValueKind::Retained => retained(path, &rows)?,
        ValueKind::CumulativeRetained => cumulative_retained(path, columns, &rows)?,
    };
    let sum: f64 = shares.iter().sum();
    if sum <= 0.0 {
        return Err(FormatError::of_file(path, "all shares are 0"));
    }
    check_sum(path, columns, kind, sum, &mut notes)?;
    let counted = (columns.unit == Some(ValueUnit::Count)).then_some(sum);
    for share in &mut shares {
        *share /= sum;
    }
    let factor = if columns.size == SizeKind::Radius {
        2.0
    } else {
        1.0
    };
    let edges: Vec<f64> = edges
        .iter()
        .map(|size| factor * size / columns.per_metre)
        .collect();
    let classes = Classes::new(&edges, &shares, weighting, columns.model)
        .map_err(|problem| of_classes(path, &rows, problem))?;
    Ok(SizeTable {
        classes,
        weighting,
        edges,
        shares,
        counted,
        notes,
    })
}

fn of_classes(path: &Path, rows: &[Row], problem: ClassProblem) -> FormatError {
    let line = rows.first().map(|row| row.line);
    let error = FormatError {
        line,
        ..FormatError::of_file(path, problem.to_string())
    };
    match problem {
        ClassProblem::Zero(_) => {
            error.with_help("begin with the smallest size there is, or use number-uniform classes")
        }
        // Sizes that differ in the file and not as f64 in m.
        _ => error,
    }
}

fn check_sizes(path: &Path, rows: &[Row], is_sieve: bool) -> Result<(), FormatError> {
    for (index, row) in rows.iter().enumerate() {
        if !row.size.is_finite() {
            return Err(wrong(
                path,
                row,
                format!("the size {}", row.size),
                "a finite number",
            ));
        }
        if row.size < 0.0 {
            return Err(wrong(
                path,
                row,
                format!("the size {}", row.size),
                "a size above 0",
            ));
        }
        let Some(before) = index.checked_sub(1).map(|before| &rows[before]) else {
            continue;
        };
        if row.size == before.size {
            let found = format!("the size {} for the second time", row.size);
            return Err(wrong(path, row, found, "each size once"));
        }
        if row.size < before.size {
            let (found, expected) = if is_sieve {
                (
                    format!("the size {} out of order", row.size),
                    "sieves in ascending or descending order",
                )
            } else {
                (
                    format!(
                        "the size {} below {}, the row before",
                        row.size, before.size
                    ),
                    "ascending sizes",
                )
            };
            return Err(wrong(path, row, found, expected));
        }
    }
    Ok(())
}

fn check_values(
    path: &Path,
    columns: &Columns,
    kind: ValueKind,
    rows: &mut [Row],
    notes: &mut Vec<String>,
) -> Result<(), FormatError> {
    let mut negative = 0;
    let mut before = 0.0;
    for (index, row) in rows.iter_mut().enumerate() {
        if !row.value.is_finite() {
            return Err(wrong(
                path,
                row,
                format!("the share {}", row.value),
                "a finite number",
            ));
        }
        if row.value < 0.0 {
            if !columns.mercury {
                return Err(wrong(
                    path,
                    row,
                    format!("the share {}", row.value),
                    "a share >= 0",
                ));
            }
            row.value = 0.0;
            negative += 1;
        }
        if kind == ValueKind::Cumulative {
            if row.value < before {
                let found = format!("the share {} below {before}, of a finer size", row.value);
                let expected = "cumulative shares that do not decrease";
                let error = wrong(path, row, found, expected);
                return Err(error.with_help("shares of single classes are of type fraction; what stays on sieves is retained"));
            }
            before = row.value;
        }
        if kind == ValueKind::CumulativeRetained {
            if index > 0 && row.value > before {
                let found = format!("the share {} above {before}, of a finer size", row.value);
                let expected = "cumulative retained shares that do not grow with the size";
                let error = wrong(path, row, found, expected);
                return Err(error.with_help(
                    "what passes is of type cumulative; what stays on one sieve is retained",
                ));
            }
            before = row.value;
        }
    }
    if negative > 0 {
        notes.push(format!("{negative} negative shares count as 0"));
    }
    Ok(())
}

type EdgesAndShares = (Vec<f64>, Vec<f64>);

/// The first row of cumulative shares and of fractions has the share 0: otherwise the message gives `found` and advice;
/// MercuryDPM puts a class in front.
fn begin_with_nothing(
    path: &Path,
    columns: &Columns,
    rows: &mut Vec<Row>,
    notes: &mut Vec<String>,
    found: &str,
    help: &str,
) -> Result<(), FormatError> {
    let Row { line, size, value } = rows[0];
    if value == 0.0 {
        return Ok(());
    }
    if !columns.mercury {
        let found = format!("the share {value} {found} {size}, the smallest size");
        let error = wrong(path, &rows[0], found, "a first row with the share 0");
        return Err(error.with_help(help));
    }
    let start = (0.001 * size).max(2.0 * size - rows[1].size);
    notes.push(format!("a class from {start} to {size} is put in front"));
    let row = Row {
        line,
        size: start,
        value: 0.0,
    };
    rows.insert(0, row);
    Ok(())
}

fn cumulative(
    path: &Path,
    columns: &Columns,
    rows: &mut Vec<Row>,
    is_sieve: bool,
    notes: &mut Vec<String>,
) -> Result<EdgesAndShares, FormatError> {
    let help = if is_sieve {
        "add the size at which the fines begin, with the share 0 (the row pan,0: they reach down to 0)"
    } else {
        "add the size at which they begin, with the share 0"
    };
    begin_with_nothing(path, columns, rows, notes, "below", help)?;
    let shares = rows.windows(2).map(|pair| pair[1].value - pair[0].value);
    let shares = shares.collect();
    Ok((rows.iter().map(|row| row.size).collect(), shares))
}

fn fractions(
    path: &Path,
    columns: &Columns,
    rows: &mut Vec<Row>,
    notes: &mut Vec<String>,
) -> Result<EdgesAndShares, FormatError> {
    let help = "a share belongs to the class that ends at its size: add the size at which the first class begins; \
                what stays on sieves is of type retained";
    begin_with_nothing(
        path,
        columns,
        rows,
        notes,
        "in the class that ends at",
        help,
    )?;
    let shares = rows.iter().skip(1).map(|row| row.value).collect();
    Ok((rows.iter().map(|row| row.size).collect(), shares))
}

fn retained(path: &Path, rows: &[Row]) -> Result<EdgesAndShares, FormatError> {
    all_pass_the_largest(path, rows)?;
    let shares = rows[..rows.len() - 1].iter().map(|row| row.value);
    Ok((rows.iter().map(|row| row.size).collect(), shares.collect()))
}

/// One minus what passes. Of amounts all is what the finest row has, which is the pan where there is one.
fn cumulative_retained(
    path: &Path,
    columns: &Columns,
    rows: &[Row],
) -> Result<EdgesAndShares, FormatError> {
    all_pass_the_largest(path, rows)?;
    let finest = &rows[0];
    if let Some(all) = whole(columns, finest.value)
        && finest.size > 0.0
        && (finest.value / all - 1.0).abs() > ROUND_OFF
        && !columns.mercury
    {
        let found = format!(
            "the cumulative retained share {} at {}, the finest sieve",
            finest.value, finest.size
        );
        let error = wrong(
            path,
            finest,
            found,
            &format!("{all} there: all that is coarser"),
        );
        return Err(error.with_help(format!(
            "add the size at which the fines begin, with the share {all} (the row pan,{all}: they reach down to 0)"
        )));
    }
    let shares = rows.windows(2).map(|pair| pair[0].value - pair[1].value);
    Ok((rows.iter().map(|row| row.size).collect(), shares.collect()))
}

/// Nothing stays on the largest sieve: the upper end of what does would not be known.
fn all_pass_the_largest(path: &Path, rows: &[Row]) -> Result<(), FormatError> {
    let last = &rows[rows.len() - 1];
    if last.value != 0.0 {
        let found = format!("{} on the largest sieve, {}", last.value, last.size);
        let error = wrong(path, last, found, "0 there");
        return Err(
            error.with_help("add a larger sieve through which everything passes, with 0 on it")
        );
    }
    Ok(())
}

/// The sum of all shares as the unit of their column has it; nothing for amounts, whose sum may be any.
fn whole(columns: &Columns, sum: f64) -> Option<f64> {
    match columns.unit {
        Some(ValueUnit::Amount | ValueUnit::Count) => None,
        Some(ValueUnit::Fraction) => Some(1.0),
        Some(ValueUnit::Percent) => Some(100.0),
        None if sum > 10.0 => Some(100.0),
        None => Some(1.0),
    }
}

fn check_sum(
    path: &Path,
    columns: &Columns,
    kind: ValueKind,
    sum: f64,
    notes: &mut Vec<String>,
) -> Result<(), FormatError> {
    let Some(all) = whole(columns, sum) else {
        return Ok(());
    };
    let miss = (sum / all - 1.0).abs();
    if miss > TOLERANCE && !columns.mercury {
        let what = match kind {
            ValueKind::Cumulative | ValueKind::CumulativeRetained => "the cumulative shares end at",
            _ => "the shares sum to",
        };
        let unit = if all == 1.0 { "1" } else { "100 %" };
        let error = FormatError {
            expected: unit.to_owned(),
            ..FormatError::of_file(path, format!("{what} {sum}"))
        };
        return Err(error.with_help(if all == 1.0 && (sum / 100.0 - 1.0).abs() < TOLERANCE {
            "these are percent: write [%] behind the name of the column"
        } else {
            "is a row missing? Amounts of any sum have their unit in brackets: retained [g], fraction number [count]"
        }));
    }
    if miss > ROUND_OFF {
        notes.push(format!(
            "shares are divided by {sum}, so that they sum to 1"
        ));
    }
    Ok(())
}
