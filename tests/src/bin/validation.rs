//! Writes `docs/validation.md`, the table of all its checks beside it, and its pictures from real runs. Ends with an error if a check fails or has vanished.

use std::path::Path;

use anyhow::{Result, ensure};
use mercury_tests::long::Page;
use mercury_tests::validation::{charts, page, run};

fn main() -> Result<()> {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
    let results = run()?;
    charts::draw(&results, &docs.join("pictures"))?;
    // The long scenes as they were run last.
    let read = |name: &str| std::fs::read_to_string(docs.join(name)).unwrap_or_default();
    let long = Page::read(&read("validation-long.md"), &read("validation-long.csv"));
    std::fs::write(
        docs.join("validation.md"),
        long.put_into(&page::page(&results)),
    )?;
    std::fs::write(docs.join("validation.csv"), page::table(&results))?;
    let (count, failed) = results.count();
    ensure!(
        failed == 0,
        "{failed} of {count} checks fail: see docs/validation.md"
    );
    println!("{count} checks pass: docs/validation.md is written");
    Ok(())
}
