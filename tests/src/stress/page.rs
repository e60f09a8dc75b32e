//! The page as Markdown, and all checks as a table.

use std::fmt::Write;

use super::Outcome;
use crate::validation::page::quoted;

const HEAD: &str = "# Numerical stability

This page is written from runs of the scenes in [`scenes/stress/`](../scenes/stress/README.md) but for its last section; do not edit it:

```sh
cargo run --release -p tests --bin stress              # all of it
cargo run --release -p tests --bin stress -- spin      # the cases whose names hold a word; nothing is written
```

A case has one row; [stability.csv](stability.csv) has every check in a row of its own. Each expectation follows from theory, as the table's last column says, none from what came out; failures are shown. A check that is on the frozen list and no longer runs makes the command fail. Shorter runs of the same cases are
among the tests (`cargo test -p tests --test scenes stress`). ε is 2.2e-16, ulp(x) the distance to the next number.
";

/// Text of a cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

/// The whole page; `soak`: its last section, by another program.
#[must_use]
pub fn page(outcomes: &[Outcome], soak: &str) -> String {
    let mut page = String::from(HEAD);
    let count: usize = outcomes.iter().map(|case| case.found.checks.len()).sum();
    let failed: Vec<_> = outcomes.iter().flat_map(Outcome::failed).collect();
    let _ = writeln!(
        page,
        "\n**{} of {count} checks pass.**",
        count - failed.len()
    );
    for (name, check) in &failed {
        let _ = writeln!(
            page,
            "\nFailed: {name}: {} instead of {}",
            cell(&check.measured),
            cell(&check.expected)
        );
    }
    page.push_str("\n| case | stressed | checks | particles | steps | time (s) |\n|---|---|---|---|---|---|\n");
    for case in outcomes {
        let bad = case.failed().count();
        let all = case.found.checks.len();
        let _ = writeln!(
            page,
            "| [{0}](../scenes/stress/{0}.toml) | {1} | {2} | {3} | {4:.0e} | {5:.1} |",
            case.scene,
            case.what,
            if bad == 0 {
                format!("{all} pass")
            } else {
                format!("**{bad} of {all} fail**")
            },
            case.found.particles,
            case.found.steps as f64,
            case.seconds
        );
    }
    page.push('\n');
    page.push_str(soak);
    page
}

/// Every check in a row of its own, and every note of a case, as comma-separated values.
#[must_use]
pub fn table(outcomes: &[Outcome]) -> String {
    let mut text = String::from("case,check,expected,measured,status,source\n");
    for case in outcomes {
        let checks = case.found.checks.iter().map(|check| {
            let status = if check.holds { "pass" } else { "FAIL" };
            let [name, expected, measured, source] = [
                check.name.as_str(),
                &check.expected,
                &check.measured,
                check.source,
            ]
            .map(quoted);
            format!("{name},{expected},{measured},{status},{source}")
        });
        let notes = (case.found.notes.iter()).map(|note| format!("note,,{},,", quoted(note)));
        for row in checks.chain(notes) {
            let _ = writeln!(text, "{},{row}", case.scene);
        }
    }
    text
}

/// The part of the page that `benches/soak.py` writes, from the present page.
#[must_use]
pub fn soak_section(page: &str) -> &str {
    page.find(SOAK).map_or("", |at| &page[at..])
}

const SOAK: &str = "## Soak\n";

#[cfg(test)]
mod tests {
    use super::{page, soak_section, table};
    use crate::stress::{Check, Found, Outcome};

    #[test]
    fn what_the_soak_wrote_is_kept() {
        let written = page(&[], "## Soak\n\nflat\n");
        assert_eq!(soak_section(&written), "## Soak\n\nflat\n");
        assert_eq!(soak_section("# Other"), "");
    }

    /// Checks and notes are in the table, whatever stands in them.
    #[test]
    fn no_check_is_lost() {
        let check = |name: &str, holds| Check {
            name: name.to_owned(),
            expected: "at most 1, \"or so\"".to_owned(),
            measured: "2".to_owned(),
            source: "theory",
            holds,
        };
        let found = Found {
            checks: vec![check("a", true), check("b, then c", false)],
            particles: 3,
            steps: 10,
            notes: vec!["one, two".to_owned()],
        };
        let outcome = Outcome {
            scene: "spin",
            what: "a spin",
            found,
            seconds: 0.1,
        };
        let quoted = "\"at most 1, \"\"or so\"\"\"";
        assert_eq!(
            table(std::slice::from_ref(&outcome)),
            format!(
                "case,check,expected,measured,status,source\nspin,a,{quoted},2,pass,theory\n\
                 spin,\"b, then c\",{quoted},2,FAIL,theory\nspin,note,,\"one, two\",,\n"
            )
        );
        assert!(page(&[outcome], "").contains("| a spin | **1 of 2 fail** | 3 | 1e1 | 0.1 |"));
    }
}
