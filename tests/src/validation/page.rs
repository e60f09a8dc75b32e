//! The page as Markdown, and all rows as a table.

use std::fmt::Write;

use super::Results;
use super::subjects::{SUBJECTS, Section};
use crate::cases::Outcome;
use crate::selftests::Comparison;

/// Title of the comparisons with files of other programs.
const OTHER_PROGRAMS: &str = "Files of other programs";
/// Title for checks without a subject.
const OTHERS: &str = "Others";

const HEAD: &str = "# Validation

This page is written by `cargo run --release -p tests --bin validation` from real runs of the solver; do not edit it. Each expected value comes from theory, from measurements or from another program, as \
the last column says; failures are shown. A check that is on the frozen list and no longer runs makes the command fail.

A case has one row, with its worst check; [validation.csv](validation.csv) has every check in a row of its own. *Worst* is the difference between measured and expected value over the largest \
difference allowed, so that 1 would be the limit. What is allowed is derived from theory (the order of the time step, the overlap over the radius, the digits of a printed number), not from what came out: a worst case near 1 is no near miss where \
one unit of a last digit is allowed.

[Long scenes](#long-scenes), of minutes each, come last; [their own page](validation-long.md) has all of them.
";

/// Text of a table cell.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

fn mark(holds: bool) -> &'static str {
    if holds { "pass" } else { "**FAIL**" }
}

/// Difference over what is allowed, for a table.
pub(crate) fn share(value: f64) -> String {
    if value == 0.0 {
        "0".to_owned()
    } else if value >= 0.005 {
        format!("{value:.2}")
    } else {
        format!("{value:.0e}")
    }
}

/// Where a heading is found on the page.
pub(crate) fn anchor(heading: &str) -> String {
    let lower = heading.to_lowercase();
    let kept = lower.chars().filter_map(|c| match c {
        ' ' => Some('-'),
        '-' | '_' => Some(c),
        c => c.is_alphanumeric().then_some(c),
    });
    kept.collect()
}

/// A number for the reader: ten digits, plain where that is short.
fn number(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        "0".to_owned()
    } else if (1e-3..1e6).contains(&size) {
        let decimals = (9 - size.log10().floor() as i32).max(0) as usize;
        let text = format!("{value:.decimals$}");
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        }
    } else {
        let text = format!("{value:.9e}");
        match text.split_once('e') {
            Some((digits, power)) => {
                let digits = digits.trim_end_matches('0').trim_end_matches('.');
                format!("{digits}e{power}")
            }
            None => text,
        }
    }
}

/// A table with a row for each case, which shows the worst of its checks.
fn cases(page: &mut String, parts: &[Part<'_>]) {
    page.push_str("\n| case | checks | passed | its worst check | expected | measured | allowed | worst | source |\n|---|---|---|---|---|---|---|---|---|\n");
    for part in parts {
        let Some((name, worst)) = part.worst() else {
            continue;
        };
        let passed = part.rows.iter().filter(|(_, row)| row.holds()).count();
        let bold = if passed < part.rows.len() { "**" } else { "" };
        let _ = writeln!(
            page,
            "| {} | {} | {bold}{passed}{bold} | {} | {} | {} | ±{:.1e} | {} | {} |",
            cell(part.title),
            part.rows.len(),
            cell(name),
            number(worst.expected),
            number(worst.measured),
            worst.allowed,
            share(worst.share()),
            cell(worst.source)
        );
    }
}

fn comparisons(page: &mut String, rows: &[Comparison]) {
    page.push_str(
        "\n| set-up | numbers | allowed: of a number + of its column | worst deviation, of the column | worst | status | source |\n|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let _ = writeln!(
            page,
            "| {} | {} | {:.0e} + {:.0e} | {:.1e} | {} | {} | {} |",
            cell(row.name),
            row.numbers,
            row.tolerance.relative,
            row.tolerance.floor,
            row.worst_deviation,
            share(row.worst_share),
            mark(row.holds()),
            cell(row.source)
        );
    }
}

/// The checks of one case.
struct Part<'a> {
    title: &'static str,
    section: Option<&'static Section>,
    rows: Vec<(&'a str, &'a Outcome)>,
}

impl<'a> Part<'a> {
    /// Name and numbers of the check that is nearest to its limit, or farthest beyond it; the first of equals.
    fn worst(&self) -> Option<(&'a str, &'a Outcome)> {
        let rows = self.rows.iter().copied();
        rows.reduce(|worst, row| match row.1.share() > worst.1.share() {
            true => row,
            false => worst,
        })
    }
}

/// The subjects with their checks; those without a section come last.
fn parts(results: &Results) -> Vec<(&'static str, &'static str, Vec<Part<'_>>)> {
    let mut left: Vec<&Outcome> = results.outcomes().collect();
    let mut found = Vec::new();
    for subject in SUBJECTS {
        let mut parts = Vec::new();
        for section in subject.sections {
            let (mine, others) = left
                .iter()
                .partition(|row| row.name.starts_with(section.prefix));
            left = others;
            let mine: Vec<&Outcome> = mine;
            let short = |row: &Outcome| match row.name.strip_prefix(section.prefix) {
                Some(_) if section.prefix.ends_with(' ') => section.prefix.len(),
                _ => 0,
            };
            let rows: Vec<_> = mine
                .iter()
                .map(|row| (row.name.as_str().split_at(short(row)).1, *row))
                .collect();
            if !rows.is_empty() {
                parts.push(Part {
                    title: section.title,
                    section: Some(section),
                    rows,
                });
            }
        }
        if !parts.is_empty() {
            found.push((subject.title, subject.about, parts));
        }
    }
    if !left.is_empty() {
        let part = Part {
            title: "Not sorted yet",
            section: None,
            rows: left.iter().map(|row| (row.name.as_str(), *row)).collect(),
        };
        found.push((OTHERS, "", vec![part]));
    }
    found
}

/// One row of the overview.
fn overview_row(page: &mut String, title: &str, counts: [usize; 2], worst: (&str, f64)) {
    let [count, passed] = counts;
    let (name, value) = worst;
    let bold = if passed < count { "**" } else { "" };
    let _ = writeln!(
        page,
        "| [{title}](#{}) | {count} | {bold}{passed}{bold} | {} | {} |",
        anchor(title),
        cell(name),
        share(value)
    );
}

fn overview(page: &mut String, results: &Results) {
    page.push_str("\n## Overview\n\n| subject | checks | passed | its worst case | worst |\n|---|---|---|---|---|\n");
    for (title, _, parts) in parts(results) {
        let rows = || parts.iter().flat_map(|part| &part.rows);
        let passed = rows().filter(|(_, row)| row.holds()).count();
        let worst = parts.iter().filter_map(Part::worst);
        let worst = worst.map(|(name, row)| (name, row.share()));
        let Some(worst) = worst.reduce(|worst, row| if row.1 > worst.1 { row } else { worst })
        else {
            continue;
        };
        overview_row(page, title, [rows().count(), passed], worst);
    }
    let rows = &results.comparisons;
    if let Some(first) = rows.first() {
        let passed = rows.iter().filter(|row| row.holds()).count();
        let worst = rows.iter().fold(first, |worst, row| {
            if row.worst_share > worst.worst_share {
                row
            } else {
                worst
            }
        });
        overview_row(
            page,
            OTHER_PROGRAMS,
            [rows.len(), passed],
            (worst.name, worst.worst_share),
        );
    }
}

/// A paragraph with an empty line before it; nothing for an empty one.
fn paragraph(page: &mut String, text: &str) {
    if !text.is_empty() {
        let _ = write!(page, "\n{text}\n");
    }
}

/// The whole page.
#[must_use]
pub fn page(results: &Results) -> String {
    let (count, failed) = results.count();
    let numbers: usize = results.comparisons.iter().map(|c| c.numbers).sum();
    let mut page = String::from(HEAD);
    let _ = writeln!(
        page,
        "\n**{} of {count} checks pass.** The comparisons with files of other programs cover {numbers} numbers.",
        count - failed
    );
    if failed > 0 {
        page.push_str("\nFailed:\n\n");
        let names = (results.outcomes())
            .filter(|row| !row.holds())
            .map(|row| row.name.as_str());
        let others = results.comparisons.iter().filter(|row| !row.holds());
        for name in names.chain(others.map(|row| row.name)) {
            let _ = writeln!(page, "- {name}");
        }
    }
    overview(&mut page, results);
    page.push_str("\n*law* in a name: one law on its own; *engine*: the whole engine ran the scene. *Scenes* are files of the project, read, planned and run through the library.\n");
    for (title, about, parts) in parts(results) {
        let _ = write!(page, "\n## {title}\n");
        paragraph(&mut page, about);
        cases(&mut page, &parts);
        let sections = parts.iter().filter_map(|part| part.section);
        for section in sections.filter(|s| !s.about.is_empty() || !s.pictures.is_empty()) {
            let _ = write!(page, "\n### {}\n", section.title);
            paragraph(&mut page, section.about);
            paragraph(&mut page, section.pictures);
        }
    }
    let _ = write!(page, "\n## {OTHER_PROGRAMS}\n\n");
    page.push_str("MercuryDPM ships files of its own self tests. Our engine runs the same set-ups, with the source's variant of a law where it differs from our default (springs turned incrementally, a spring increment in the first force evaluation, lever 2R\\* of rolling resistance, stiffness factor 2/3), ");
    page.push_str("and every number of a file is compared: |a − b| ≤ (first tolerance) · |b| + (second tolerance) · (largest magnitude in its column). Files hold 10 digits, so that up to half of 1e-9 is the file's own rounding. ");
    page.push_str("The source adds up its time and may make one step more than end/dt: we make the same steps.\n");
    comparisons(&mut page, &results.comparisons);
    page
}

/// A field of comma-separated values.
pub(crate) fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}

/// Every check in a row of its own, as comma-separated values.
#[must_use]
pub fn table(results: &Results) -> String {
    let mut text =
        String::from("subject,section,check,expected,measured,allowed,worst,status,source\n");
    let status = |holds| if holds { "pass" } else { "FAIL" };
    for (subject, _, parts) in parts(results) {
        for part in parts {
            for (_, row) in part.rows {
                let _ = writeln!(
                    text,
                    "{},{},{},{},{},{:e},{},{},{}",
                    quoted(subject),
                    quoted(part.title),
                    quoted(&row.name),
                    number(row.expected),
                    number(row.measured),
                    row.allowed,
                    share(row.share()),
                    status(row.holds()),
                    quoted(row.source)
                );
            }
        }
    }
    for row in &results.comparisons {
        let _ = writeln!(
            text,
            "{},{},{},,,,{},{},{}",
            quoted(OTHER_PROGRAMS),
            quoted(OTHER_PROGRAMS),
            quoted(row.name),
            share(row.worst_share),
            status(row.holds()),
            quoted(row.source)
        );
    }
    text
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

    #[test]
    fn failures_and_unknown_cases_are_shown() {
        let results = Results {
            cases: vec![outcome("T1 law: a", 1.05), outcome("X law: b", f64::NAN)],
            scenes: vec![outcome("scene c", 2.0)],
            shapes: Vec::new(),
            published: Vec::new(),
            comparisons: Vec::new(),
        };
        let page = page(&results);
        for line in [
            "**1 of 3 checks pass.**",
            "- X law: b\n- scene c\n",
            "| Not sorted yet | 2 | **0** | X law: b | 1 | NaN | ±1.0e-1 | inf | theory |",
            "| Linear law: parameters and collisions of two spheres | 1 | 1 | law: a | 1 | 1.05 | ±1.0e-1 | 0.50 | theory |",
            "| [Head-on collisions](#head-on-collisions) | 1 | 1 | law: a | 0.50 |",
            "| [Others](#others) | 2 | **0** | X law: b | inf |",
        ] {
            assert!(page.contains(line), "{line} is not in\n{page}");
        }
    }

    /// Every check is in the table; the page has a row for their case.
    #[test]
    fn no_row_is_lost() {
        let results = Results {
            cases: vec![
                outcome("T1 law: with 1 kg", 1.05),
                outcome("T1 law: with 2 kg, say", 1.05),
                outcome("T1 law: with 3 kg", 1.01),
            ],
            scenes: vec![outcome("of no subject", 1.0)],
            shapes: Vec::new(),
            published: Vec::new(),
            comparisons: Vec::new(),
        };
        let table = table(&results);
        assert_eq!(table.lines().count(), 5);
        for row in results.outcomes() {
            assert!(table.contains(&row.name), "{table}");
        }
        assert!(page(&results).contains(" | 3 | 3 | law: with 1 kg | 1 | 1.05 |"));
    }

    /// Sections take what their names begin with, in order: none may hide behind an earlier one.
    #[test]
    fn every_section_can_be_reached() {
        let sections: Vec<&Section> = SUBJECTS.iter().flat_map(|s| s.sections).collect();
        for (k, section) in sections.iter().enumerate() {
            for earlier in &sections[..k] {
                assert!(
                    !section.prefix.starts_with(earlier.prefix),
                    "{} comes after {}",
                    section.prefix,
                    earlier.prefix
                );
                assert_ne!(anchor(section.title), anchor(earlier.title));
            }
            for subject in SUBJECTS {
                assert_ne!(anchor(section.title), anchor(subject.title));
            }
        }
    }

    #[test]
    fn numbers_keep_ten_digits() {
        for (value, text) in [
            (0.0, "0"),
            (0.4, "0.4"),
            (-12.5, "-12.5"),
            (0.700_735_123_456_78, "0.7007351235"),
            (123_456.789_012_34, "123456.789"),
            (2.5e-9, "2.5e-9"),
            (-1e20, "-1e20"),
        ] {
            assert_eq!(number(value), text);
        }
    }
}
