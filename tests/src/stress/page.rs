//! The page as Markdown.

use std::fmt::Write;

use super::Outcome;

const HEAD: &str = "# Numerical stability

This page is written from runs of the scenes in [`scenes/stress/`](../scenes/stress/README.md) but for its last section; do not edit it:

```sh
cargo run --release -p tests --bin stress              # all of it
cargo run --release -p tests --bin stress -- spin      # the cases whose names hold a word; nothing is written
```

Each expectation follows from theory, as the last column says, none from what came out; failures are shown. A check that is on the frozen list and no longer runs makes the command fail. Shorter runs of the same cases are
among the tests (`cargo test -p tests --test scenes stress`). ε is 2.2e-16, ulp(x) the distance to the next number.
";

/// What stands in a cell of a table.
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
            "| [{0}](#{0}) | {1} | {2} | {3} | {4:.0e} | {5:.1} |",
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
    for case in outcomes {
        let _ = write!(
            page,
            "\n## {}\n\n{}. Scene: [`{0}.toml`](../scenes/stress/{0}.toml).\n\n\
             | check | expected | measured | status | source |\n|---|---|---|---|---|\n",
            case.scene,
            capital(case.what)
        );
        for check in &case.found.checks {
            let _ = writeln!(
                page,
                "| {} | {} | {} | {} | {} |",
                cell(&check.name),
                cell(&check.expected),
                cell(&check.measured),
                if check.holds { "pass" } else { "**FAIL**" },
                cell(check.source)
            );
        }
        for note in &case.found.notes {
            let _ = writeln!(page, "\n{note}");
        }
    }
    page.push('\n');
    page.push_str(soak);
    page
}

/// With its first letter large.
fn capital(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters
        .next()
        .map(|letter| letter.to_uppercase().to_string());
    first.unwrap_or_default() + letters.as_str().trim_end_matches('?')
}

/// The part of the page that `benches/soak.py` writes, from the present page.
#[must_use]
pub fn soak_section(page: &str) -> &str {
    page.find(SOAK).map_or("", |at| &page[at..])
}

const SOAK: &str = "## Soak\n";

#[cfg(test)]
mod tests {
    use super::{page, soak_section};

    #[test]
    fn what_the_soak_wrote_is_kept() {
        let written = page(&[], "## Soak\n\nflat\n");
        assert_eq!(soak_section(&written), "## Soak\n\nflat\n");
        assert_eq!(soak_section("# Other"), "");
    }
}
