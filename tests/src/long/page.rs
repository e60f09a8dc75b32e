//! The page of the long scenes: an overview of all subjects, and their sections, of which those that are not run stay as they are.

use std::fmt::Write;

use super::{FROZEN, Reported, SUBJECTS, Subject};
use crate::validation::compare_names;
use crate::validation::page::{anchor, quoted, share};

const HEAD: &str = "# Validation: long scenes

Scenes of minutes, written by a program from real runs; do not edit this page. The other checks: [validation](validation.md).

```sh
cargo run --release -p tests --bin validation-long -- /tmp/long                # all of them
cargo run --release -p tests --bin validation-long -- /tmp/long haff janssen   # some: the sections of the others stay as they are
```

The folder gets the runs of the larger scenes; a finished run of the same plan that is there already is taken as it is. `penetration-25k` and `drum-soft` are scenes of the open-source DEM benchmark (Dosta et al. 2024, *Comput. Phys. Commun.* 296, 109066), which are not part of the
project: they need the reference data beside it. A check that is on the frozen list and no longer runs makes the command fail. Run times of the two: [performance](lab/performance.md#long-scenes).

[validation-long.csv](validation-long.csv) has every check in a row of its own. *Worst* is the difference between measured and expected value over the largest difference allowed.
";

/// Heading of the long scenes on the validation page.
const HEADING: &str = "## Long scenes";

/// Keys of the subjects whose sections the validation page shows whole.
const SHOWN: [&str; 1] = ["hopper-psd"];

/// First line of the table of all checks.
const COLUMNS: &str = "check,expected,measured,allowed,worst,status,source";

/// Content of the page, subject by subject.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Page {
    /// Key, rows of the table, section below the heading.
    parts: Vec<(&'static str, Vec<String>, String)>,
}

impl Page {
    /// Content of the page and of the table beside it as they are; a subject that is missing in either is not on it.
    #[must_use]
    pub fn read(page: &str, table: &str) -> Self {
        let mut parts = Vec::new();
        for subject in &SUBJECTS {
            let heading = format!("\n## {}\n", subject.title);
            let Some((_, rest)) = page.split_once(&heading) else {
                continue;
            };
            let section = rest.split("\n## ").next().unwrap_or_default();
            let rows: Vec<String> = table
                .lines()
                .filter(|line| key_of(line) == Some(subject.key))
                .map(str::to_owned)
                .collect();
            if !rows.is_empty() {
                parts.push((subject.key, rows, format!("{}\n", section.trim_end())));
            }
        }
        Self { parts }
    }

    /// Replaces a subject.
    pub fn put(&mut self, subject: &Subject, reported: &Reported) {
        let rows = reported.checks.iter().map(|row| {
            format!(
                "{},{},{},{:e},{},{},{}",
                quoted(&row.name),
                row.expected,
                row.measured,
                row.allowed,
                share(row.share()),
                if row.holds() { "pass" } else { "FAIL" },
                quoted(row.source)
            )
        });
        let part = (subject.key, rows.collect(), reported.text.clone());
        match self.parts.iter_mut().find(|part| part.0 == subject.key) {
            Some(old) => *old = part,
            None => self.parts.push(part),
        }
    }

    fn rows(&self) -> impl Iterator<Item = Vec<String>> {
        self.parts
            .iter()
            .flat_map(|part| &part.1)
            .map(|row| fields(row))
    }

    /// Names of the checks that fail.
    #[must_use]
    pub fn failed(&self) -> Vec<String> {
        let failed = self.rows().filter(|row| field(row, 5) != "pass");
        failed.map(|row| field(&row, 0).to_owned()).collect()
    }

    /// Whether every check of the frozen list is on the page.
    ///
    /// # Errors
    /// If one has vanished.
    pub fn complete(&self) -> anyhow::Result<()> {
        let rows: Vec<Vec<String>> = self.rows().collect();
        let names: Vec<&str> = rows.iter().map(|row| field(row, 0)).collect();
        compare_names(&names, FROZEN)
    }

    /// The whole page.
    #[must_use]
    pub fn text(&self) -> String {
        let mut page = String::from(HEAD);
        let failed = self.failed();
        let count = self.rows().count();
        let _ = writeln!(
            page,
            "\n**{} of {count} checks pass.**",
            count - failed.len()
        );
        for name in failed {
            let _ = writeln!(page, "\nFailed: {name}");
        }
        self.overview(&mut page, "");
        let missing = SUBJECTS
            .iter()
            .filter(|s| self.parts.iter().all(|part| part.0 != s.key));
        let missing: Vec<String> = missing
            .map(|s| format!("`{}` ({})", s.key, s.title))
            .collect();
        if !missing.is_empty() {
            let _ = writeln!(
                page,
                "\n**Not run yet**: {}. The command for all of them fails until they are.",
                missing.join(", ")
            );
        }
        for subject in &SUBJECTS {
            if let Some((_, _, section)) = self.parts.iter().find(|part| part.0 == subject.key) {
                let _ = write!(page, "\n## {}\n{section}", subject.title);
            }
        }
        page
    }

    /// Summary of the long scenes on the validation page, below `HEADING`: an overview, and the sections of `SHOWN`.
    #[must_use]
    pub fn summary(&self) -> String {
        let mut text = String::from(
            "\nRuns of minutes each, made by a [program of their own](validation-long.md), whose results stand here too.\n",
        );
        self.overview(&mut text, "validation-long.md");
        for key in SHOWN {
            let part = self.parts.iter().find(|part| part.0 == key);
            let subject = SUBJECTS.iter().find(|subject| subject.key == key);
            if let (Some((_, _, section)), Some(subject)) = (part, subject) {
                let _ = write!(text, "\n### {}\n{section}", subject.title);
            }
        }
        text
    }

    /// The validation page with the long scenes as they are here, in place of its section about them.
    #[must_use]
    pub fn put_into(&self, validation: &str) -> String {
        let heading = format!("\n{HEADING}\n");
        let (before, after) = match validation.split_once(&heading) {
            None => (validation, ""),
            Some((before, rest)) => (before, rest.find("\n## ").map_or("", |end| &rest[end..])),
        };
        format!(
            "{}\n{heading}{}{after}",
            before.trim_end_matches('\n'),
            self.summary()
        )
    }

    /// A row for each subject; headings are on the page `file`.
    fn overview(&self, page: &mut String, file: &str) {
        page.push_str(
            "\n| subject | checks | passed | its worst case | worst |\n|---|---|---|---|---|\n",
        );
        for subject in &SUBJECTS {
            let Some((key, rows, _)) = self.parts.iter().find(|part| part.0 == subject.key) else {
                continue;
            };
            let rows: Vec<Vec<String>> = rows.iter().map(|row| fields(row)).collect();
            let passed = rows.iter().filter(|row| field(row, 5) == "pass").count();
            let worst = |row: &&Vec<String>| field(row, 4).parse().unwrap_or(f64::INFINITY);
            let Some(worst) = rows.iter().max_by(|a, b| worst(a).total_cmp(&worst(b))) else {
                continue;
            };
            let bold = if passed < rows.len() { "**" } else { "" };
            let name = field(worst, 0);
            let _ = writeln!(
                page,
                "| [{}]({file}#{}) | {} | {bold}{passed}{bold} | {} | {} |",
                subject.title,
                anchor(subject.title),
                rows.len(),
                name.strip_prefix(&format!("{key}: ")).unwrap_or(name),
                field(worst, 4)
            );
        }
    }

    /// Every check in a row of its own, as comma-separated values.
    #[must_use]
    pub fn table(&self) -> String {
        let mut text = format!("{COLUMNS}\n");
        for subject in &SUBJECTS {
            let part = self.parts.iter().find(|part| part.0 == subject.key);
            for row in part.into_iter().flat_map(|part| &part.1) {
                text.push_str(row);
                text.push('\n');
            }
        }
        text
    }
}

fn field(row: &[String], k: usize) -> &str {
    row.get(k).map_or("", String::as_str)
}

/// The key of the subject that a row of the table belongs to.
fn key_of(row: &str) -> Option<&'static str> {
    let fields = fields(row);
    let name = fields.first()?;
    let subject = SUBJECTS
        .iter()
        .find(|subject| name.starts_with(&format!("{}: ", subject.key)));
    Some(subject?.key)
}

/// The fields of a row of comma-separated values, of which some are quoted.
fn fields(row: &str) -> Vec<String> {
    let (mut fields, mut inside) = (vec![String::new()], false);
    let mut rest = row.chars().peekable();
    while let Some(c) = rest.next() {
        match c {
            '"' if inside && rest.peek() == Some(&'"') => {
                rest.next();
                fields.last_mut().into_iter().for_each(|f| f.push('"'));
            }
            '"' => inside = !inside,
            ',' if !inside => fields.push(String::new()),
            c => fields.last_mut().into_iter().for_each(|f| f.push(c)),
        }
    }
    fields
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::long::outcome;

    fn reported(measured: f64, text: &str) -> Reported {
        Reported {
            checks: vec![
                outcome(
                    "haff: a line, \"straight\"",
                    1.0,
                    measured,
                    0.1,
                    "theory, 1983",
                ),
                outcome("haff: b", 0.0, 0.0, 0.0, "theory"),
            ],
            text: text.to_owned(),
            pictures: Vec::new(),
        }
    }

    /// The validation page shows the content of the page of the long scenes, as both are committed: the plot of the hopper's
    /// discharge and its rate beside Beverloo's law among them.
    #[test]
    fn the_validation_page_shows_the_long_scenes_as_they_are() {
        let docs = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
        let read = |name: &str| std::fs::read_to_string(docs.join(name)).unwrap();
        let page = Page::read(&read("validation-long.md"), &read("validation-long.csv"));
        let validation = read("validation.md");
        assert_eq!(
            page.put_into(&validation),
            validation,
            "run `validation-long FOLDER none`"
        );
        for part in [
            "pictures/hopper-discharge.svg",
            "the rate is **",
            "Beverloo",
        ] {
            assert!(validation.contains(part), "{part}");
        }
    }

    #[test]
    fn what_stands_around_the_long_scenes_stays() {
        let mut page = Page::default();
        page.put(
            &SUBJECTS[3],
            &Reported {
                checks: vec![outcome("hopper-psd: a", 1.0, 1.0, 0.1, "theory")],
                ..reported(0.0, "\nplot\n")
            },
        );
        let first = page.put_into("# Validation\n\ntext\n");
        assert!(
            first.starts_with("# Validation\n\ntext\n\n## Long scenes\n\nRuns"),
            "{first}"
        );
        assert!(
            first.ends_with("\n### A hopper discharges\n\nplot\n"),
            "{first}"
        );
        assert_eq!(page.put_into(&first), first);
        let with_more = format!("{first}\n## More\n\nmore\n");
        assert_eq!(page.put_into(&with_more), with_more);
    }

    /// Sections are written and read back, and a subject that is run again takes the place of the old one.
    #[test]
    fn sections_stay_until_they_are_run_again() {
        let haff = &SUBJECTS[0];
        let mut page = Page::default();
        page.put(haff, &reported(1.2, "\nold\n"));
        let drum = &SUBJECTS[6];
        let mut other = reported(0.0, "\nof the drum\n\n### More\n\nmore\n");
        other.checks = vec![outcome("drum-soft: c", 0.0, 0.5, 1.0, "theory")];
        page.put(drum, &other);
        let again = Page::read(&page.text(), &page.table());
        assert_eq!(again, page);
        assert_eq!(again.failed(), ["haff: a line, \"straight\""]);
        let mut again = again;
        again.put(haff, &reported(1.05, "\nnew\n"));
        assert!(again.failed().is_empty());
        let text = again.text();
        assert!(
            text.contains("new") && !text.contains("old\n") && text.contains("### More\n\nmore")
        );
        assert!(
            text.contains(
                "| [Gases that cool](#gases-that-cool) | 2 | 2 | a line, \"straight\" | 0.50 |"
            ),
            "{text}"
        );
        assert!(text.contains("**3 of 3 checks pass.**"));
        assert!(again.complete().is_err());
        assert!(text.contains("**Not run yet**: `janssen` (A silo"));
    }
}
