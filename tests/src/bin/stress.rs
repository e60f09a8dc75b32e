//! Writes `docs/stability.md`, and the table of all its checks beside it, from long runs of the scenes in `scenes/stress/`. Ends with an error if a check fails or has vanished.

use std::path::Path;

use anyhow::{Result, ensure};
use mercury_tests::stress::page::{page, soak_section, table};
use mercury_tests::stress::{CASES, Length, Outcome, compare_with_list};

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let is_asked =
        |scene: &str| words.is_empty() || words.iter().any(|word| scene.contains(word.as_str()));
    let mut outcomes: Vec<Outcome> = Vec::new();
    for case in CASES.iter().filter(|case| is_asked(case.scene)) {
        println!("{}: {}", case.scene, case.what);
        let outcome = case.run(Length::Long)?;
        for check in &outcome.found.checks {
            let mark = if check.holds { "pass" } else { "FAIL" };
            println!(
                "  {mark}  {}: {} (expected: {})",
                check.name, check.measured, check.expected
            );
        }
        for note in &outcome.found.notes {
            println!("  {note}");
        }
        println!("  {:.1} s", outcome.seconds);
        outcomes.push(outcome);
    }
    ensure!(!outcomes.is_empty(), "no case has such a name: {words:?}");
    if words.is_empty() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/stability.md");
        let before = std::fs::read_to_string(&path).unwrap_or_default();
        std::fs::write(&path, page(&outcomes, soak_section(&before)))?;
        std::fs::write(path.with_extension("csv"), table(&outcomes))?;
        println!("docs/stability.md is written");
        compare_with_list(&outcomes)?;
    }
    let failed: Vec<String> = outcomes
        .iter()
        .flat_map(|case| case.failed().map(|(name, _)| name))
        .collect();
    ensure!(failed.is_empty(), "these checks fail: {failed:#?}");
    Ok(())
}
