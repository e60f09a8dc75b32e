//! Rows that differ in a parameter alone become one row, which shows the worst of them.

use crate::cases::Outcome;

/// One row of a table on the page.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Folded<'a> {
    /// The name, with ranges in the place of what differs.
    pub(crate) name: String,
    /// How many checks the row stands for.
    pub(crate) count: usize,
    /// The worst of them.
    pub(crate) worst: &'a Outcome,
    /// What is particular to the worst: its parameters, in the order of the ranges.
    pub(crate) at: String,
}

/// A name taken apart: what is fixed, around the parameters.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Parts {
    fixed: Vec<String>,
    parameters: Vec<String>,
}

/// Folds rows, in the order of their first ones. A row that fails stays alone: so that it is found at once.
pub(crate) fn fold<'a>(rows: impl Iterator<Item = (&'a str, &'a Outcome)>) -> Vec<Folded<'a>> {
    let mut groups: Vec<(Parts, Vec<(Parts, &Outcome)>)> = Vec::new();
    for (name, row) in rows {
        let parts = take_apart(name);
        let group = groups.iter_mut().find(|(first, members)| {
            let other = members[0].1;
            row.holds() && other.holds() && first.fixed == parts.fixed && other.source == row.source
        });
        match group {
            Some((_, members)) => members.push((parts, row)),
            None => groups.push((parts.clone(), vec![(parts, row)])),
        }
    }
    groups.iter().map(|(_, members)| one_row(members)).collect()
}

fn one_row<'a>(members: &[(Parts, &'a Outcome)]) -> Folded<'a> {
    let mut worst = &members[0];
    for member in members {
        if member.1.share() > worst.1.share() {
            worst = member;
        }
    }
    let first = &members[0].0;
    let mut name = first.fixed[0].clone();
    let mut at = Vec::new();
    for slot in 0..first.parameters.len() {
        let mut values: Vec<&str> = Vec::new();
        for (parts, _) in members {
            let value = parts.parameters[slot].as_str();
            if !values.contains(&value) {
                values.push(value);
            }
        }
        if values.len() > 1 {
            at.push(worst.0.parameters[slot].as_str());
        }
        name.push_str(&range(&values));
        name.push_str(&first.fixed[slot + 1]);
    }
    Folded {
        name,
        count: members.len(),
        worst: worst.1,
        at: at.join(", "),
    }
}

/// Up to three values one by one, more of them from the least to the largest.
fn range(values: &[&str]) -> String {
    match values {
        [] => String::new(),
        [only] => (*only).to_owned(),
        [a, b] => format!("{a} or {b}"),
        [a, b, c] => format!("{a}, {b} or {c}"),
        many => {
            let mut sorted: Vec<(f64, &str)> = many.iter().map(|v| (value(v), *v)).collect();
            sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
            format!("{} to {}", sorted[0].1, sorted[sorted.len() - 1].1)
        }
    }
}

/// The number that a parameter stands for; a fraction is one.
fn value(parameter: &str) -> f64 {
    let number = |text: &str| text.parse().unwrap_or(f64::NAN);
    match parameter.split_once('/') {
        Some((over, under)) => number(over) / number(under),
        None => number(parameter),
    }
}

/// Parameters are numbers that stand alone, fractions among them, and the letters x, y and z.
fn take_apart(name: &str) -> Parts {
    let (mut fixed, mut parameters) = (vec![String::new()], Vec::new());
    let mut before = ' ';
    let mut rest = name;
    while let Some(next) = rest.chars().next() {
        let length = parameter_at(rest, before);
        let taken = if length > 0 {
            parameters.push(rest[..length].to_owned());
            fixed.push(String::new());
            length
        } else {
            if let Some(last) = fixed.last_mut() {
                last.push(next);
            }
            next.len_utf8()
        };
        before = rest[..taken].chars().next_back().unwrap_or(' ');
        rest = &rest[taken..];
    }
    Parts { fixed, parameters }
}

/// Length in bytes of the parameter at the start of a text that follows `before`; 0 if there is none.
fn parameter_at(text: &str, before: char) -> usize {
    if before.is_alphanumeric() {
        return 0;
    }
    let bytes = text.as_bytes();
    let digits = |from: usize| {
        let number = bytes[from..].iter().take_while(|b| b.is_ascii_digit());
        from + number.count()
    };
    let at = |k: usize| bytes.get(k).copied().unwrap_or(b' ');
    let mut end = if matches!(at(0), b'x' | b'y' | b'z') {
        1
    } else {
        let signed = matches!(at(0), b'+' | b'-') && matches!(before, ' ' | '(');
        let start = usize::from(signed);
        let mut end = digits(start);
        if end == start {
            return 0;
        }
        if at(end) == b'.' && digits(end + 1) > end + 1 {
            end = digits(end + 1);
        }
        if at(end) == b'e' {
            let exponent = end + 1 + usize::from(matches!(at(end + 1), b'+' | b'-'));
            if digits(exponent) > exponent {
                end = digits(exponent);
            }
        }
        end
    };
    if at(0) != b'x' && at(end) == b'/' && digits(end + 1) > end + 1 {
        end = digits(end + 1);
    }
    let after = text[end..].chars().next().unwrap_or(' ');
    if after.is_alphanumeric() || matches!(after, '_' | '*') {
        0
    } else {
        end
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome(name: &str, measured: f64) -> Outcome {
        Outcome {
            name: name.to_owned(),
            expected: 1.0,
            measured,
            allowed: 0.1,
            source: "theory",
        }
    }

    fn folded(rows: &[Outcome]) -> Vec<(String, usize, String)> {
        let rows = rows.iter().map(|row| (row.name.as_str(), row));
        let folded = fold(rows).into_iter();
        folded.map(|row| (row.name, row.count, row.at)).collect()
    }

    #[test]
    fn rows_that_differ_in_numbers_are_one() {
        let rows = [
            outcome("test 4, 40 degrees, factor 2/3: spin", 1.01),
            outcome("test 4, 5.5 degrees, factor 2/3: spin", 1.02),
            outcome("test 4, 60 degrees, factor 1: spin", 1.09),
            outcome("test 4, 1e-3 degrees, factor 1: spin", 1.0),
            outcome("test 5, 1e-3 degrees, factor 1: slip", 1.0),
        ];
        assert_eq!(
            folded(&rows),
            [
                (
                    "test 4, 1e-3 to 60 degrees, factor 2/3 or 1: spin".to_owned(),
                    4,
                    "60, 1".to_owned()
                ),
                (
                    "test 5, 1e-3 degrees, factor 1: slip".to_owned(),
                    1,
                    String::new()
                ),
            ]
        );
    }

    #[test]
    fn components_are_one_and_names_of_things_are_not() {
        let rows = [
            outcome("v of 1 (m/s), x", 1.0),
            outcome("v of 1 (m/s), y", 0.95),
            outcome("lever 2R* of DEM01 (m/s2)", 1.0),
            outcome("lever 3R* of DEM02 (m/s2)", 1.0),
        ];
        assert_eq!(
            folded(&rows)[0],
            ("v of 1 (m/s), x or y".to_owned(), 2, "y".to_owned())
        );
        assert_eq!(folded(&rows).len(), 3);
    }

    #[test]
    fn what_fails_and_what_has_another_source_stays_alone() {
        let other = Outcome {
            source: "another program",
            ..outcome("angle 4", 1.0)
        };
        let rows = [
            outcome("angle 1", 1.0),
            outcome("angle 2", 2.0),
            outcome("angle 3", f64::NAN),
            other,
            outcome("angle 5", 1.0),
        ];
        let names: Vec<_> = folded(&rows).into_iter().map(|row| row.0).collect();
        assert_eq!(names, ["angle 1 or 5", "angle 2", "angle 3", "angle 4"]);
    }
}
