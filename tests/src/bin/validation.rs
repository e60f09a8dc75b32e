//! Writes `docs/validation.md`, the table of all its checks beside it, and its pictures from real runs. Ends with an error if a check fails or has vanished.

use std::path::Path;

use anyhow::{Result, ensure};
use mercury_tests::validation::{charts, page, run};

fn main() -> Result<()> {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
    let results = run()?;
    charts::draw(&results, &docs.join("pictures"))?;
    std::fs::write(docs.join("validation.md"), page::page(&results))?;
    std::fs::write(docs.join("validation.csv"), page::table(&results))?;
    let (count, failed) = results.count();
    ensure!(
        failed == 0,
        "{failed} of {count} checks fail: see docs/validation.md"
    );
    println!("{count} checks pass: docs/validation.md is written");
    Ok(())
}
