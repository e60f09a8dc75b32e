//! The page as Markdown.

use std::fmt::Write;

use super::Results;
use crate::cases::Outcome;
use crate::selftests::Comparison;

/// What the contact cases are about, in their order.
const TITLES: [(&str, &str); 20] = [
    ("T1", "Linear law: parameters and collisions of two spheres"),
    ("T2", "Linear law with tension cut off"),
    ("T3", "Elasto-plastic law"),
    ("T4", "Elastic Hertz contacts"),
    ("T5", "Damped Hertz contacts"),
    ("T6", "Damping for a given restitution with tension cut off"),
    ("T7", "The time step"),
    ("T8", "Two spheres with linear friction, point by point"),
    ("T9", "Hertz-Mindlin sphere on a wall, point by point"),
    (
        "T10",
        "Unequal spheres with rolling and torsion, point by point",
    ),
    ("T11", "Oblique impact, gross sliding"),
    ("T12", "Oblique impact, linear friction"),
    ("T13", "Oblique impact, Mindlin friction"),
    ("T14", "A sphere slides and rolls on a plane"),
    ("T15", "Rolling and torsion resistance"),
    ("T16", "Shear cycles at constant overlap"),
    ("T17", "Energy of a shear and release cycle"),
    ("T18", "Mixing of parameters"),
    ("T19", "Mesh walls beside the walls that they tessellate"),
    ("T20", "Oblique impacts of Chung & Ooi (2011), tests 4 to 8"),
];

/// Text of a table cell.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

fn mark(holds: bool) -> &'static str {
    if holds { "pass" } else { "**FAIL**" }
}

/// A number as a reader wants it: ten digits, plain where that is short.
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

/// A table of checks, each with the name that it has here.
pub(crate) fn outcomes<'a>(page: &mut String, rows: impl Iterator<Item = (&'a str, &'a Outcome)>) {
    page.push_str("\n| check | expected | measured | allowed | status | source |\n|---|---|---|---|---|---|\n");
    for (name, row) in rows {
        let _ = writeln!(
            page,
            "| {} | {} | {} | ±{:.1e} | {} | {} |",
            cell(name),
            number(row.expected),
            number(row.measured),
            row.allowed,
            mark(row.holds()),
            cell(row.source)
        );
    }
}

fn comparisons(page: &mut String, rows: &[Comparison]) {
    page.push_str(
        "\n| set-up | numbers | allowed: of a number + of its column | worst deviation, of the column | worst, of what is allowed | status | source |\n|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let _ = writeln!(
            page,
            "| {} | {} | {:.0e} + {:.0e} | {:.1e} | {:.2} | {} | {} |",
            cell(row.name),
            row.numbers,
            row.tolerance.relative,
            row.tolerance.floor,
            row.worst_deviation,
            row.worst_share,
            mark(row.holds()),
            cell(row.source)
        );
    }
}

/// The whole page.
#[must_use]
pub fn page(results: &Results) -> String {
    let (count, failed) = results.count();
    let numbers: usize = results.comparisons.iter().map(|c| c.numbers).sum();
    let mut page = String::from("# Validation\n\n");
    page.push_str("This page is written by `cargo run --release -p mercury-tests --bin validation` from real runs of the solver; do not edit it. ");
    page.push_str("Each expected value comes from theory or from another program, as the last column says; failures are shown. ");
    page.push_str(
        "A check that is on the frozen list and no longer runs makes the command fail.\n\n",
    );
    let _ = writeln!(
        page,
        "**{} of {count} checks pass.** The comparisons with other programs cover {numbers} numbers.",
        count - failed
    );
    if failed > 0 {
        page.push_str("\nFailed:\n\n");
        let rows = results.cases.iter();
        let rows = rows.chain(&results.scenes).chain(&results.shapes);
        let names = rows.filter(|row| !row.holds()).map(|row| row.name.as_str());
        let others = results.comparisons.iter().filter(|row| !row.holds());
        for name in names.chain(others.map(|row| row.name)) {
            let _ = writeln!(page, "- {name}");
        }
    }
    page.push_str(
        "\n## Scenes\n\nScene files of the project, read, planned and run through the library.\n",
    );
    outcomes(
        &mut page,
        results
            .scenes
            .iter()
            .map(|row| (row.name.strip_prefix("scene ").unwrap_or(&row.name), row)),
    );
    page.push_str("\n![Restitution of a Hertz impact over the phase of the first touch](pictures/hertz-phase.svg)\n");
    page.push_str("\nThe overlap at the first step in contact depends on where in a step the touch falls; the damping of the Hertz law grows with the fourth root of it. The jumps are where the contact ends a step earlier. The error falls with the step.\n");
    page.push_str("\n![Convergence of the time step](pictures/convergence.svg)\n");
    page.push_str("\nThe error of the free oscillation of a sphere on a spring is of second order in the step. A collision with damping begins and ends within a step, which leaves an error of first order at most.\n");
    page.push_str("\n## Reference shapes\n\nBodies that `mclump` makes of shapes shipped with MercuryDPM, on a table; lengths as in their files, density 1, gravity 10. [What they show](how-to/grains-of-real-shape.md#how-many-pebbles).\n");
    outcomes(
        &mut page,
        results.shapes.iter().map(|row| (row.name.as_str(), row)),
    );
    page.push_str("\n## Other programs\n\n");
    page.push_str("MercuryDPM ships files of its own self tests. Our engine runs the same set-ups, with the source's variant of a law where it differs from our default (springs turned incrementally, a spring increment in the first force evaluation, lever 2R\\* of rolling resistance, stiffness factor 2/3), ");
    page.push_str("and every number of a file is compared: |a − b| ≤ (first tolerance) · |b| + (second tolerance) · (largest magnitude in its column). Files hold 10 digits, so that up to half of 1e-9 is the file's own rounding. ");
    page.push_str("The source adds up its time and may make one step more than end/dt: we make the same steps.\n");
    comparisons(&mut page, &results.comparisons);
    page.push_str("\n## Contact cases\n\n*law* in a name: one law on its own; *engine*: the whole engine ran the scene.\n");
    for (key, title) in TITLES {
        let prefix = format!("{key} ");
        let rows: Vec<_> = results
            .cases
            .iter()
            .filter_map(|case| Some((case.name.strip_prefix(&prefix)?, case)))
            .collect();
        if rows.is_empty() {
            continue;
        }
        let _ = write!(page, "\n### {key}: {title}\n");
        outcomes(&mut page, rows.into_iter());
        if key == "T13" {
            page.push_str(
                "\n![Tangential rebound over impact angle](pictures/oblique-impact.svg)\n",
            );
        }
    }
    let known = |name: &str| {
        TITLES
            .iter()
            .any(|(key, _)| name.starts_with(&format!("{key} ")))
    };
    let others: Vec<_> = results
        .cases
        .iter()
        .filter(|case| !known(&case.name))
        .map(|case| (case.name.as_str(), case))
        .collect();
    if !others.is_empty() {
        page.push_str("\n### Others\n");
        outcomes(&mut page, others.into_iter());
    }
    page
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
            comparisons: Vec::new(),
        };
        let page = page(&results);
        assert!(page.contains("**1 of 3 checks pass.**"));
        assert!(page.contains("- X law: b\n- scene c\n"));
        assert!(page.contains("| X law: b | 1 | NaN | ±1.0e-1 | **FAIL** | theory |"));
        assert!(page.contains("| law: a | 1 | 1.05 | ±1.0e-1 | pass | theory |"));
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
