//! Writes `docs/validation-long.md` and its pictures from runs of minutes. Ends with an error if a check fails or has vanished.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use mercury_tests::long;

fn main() -> Result<()> {
    let runs = std::env::args_os().nth(1).map(PathBuf::from);
    let runs = runs.context(
        "usage: validation-long FOLDER\nFOLDER gets the runs; a finished run of the same plan that is there already is not made again",
    )?;
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
    let results = long::run(&runs)?;
    results.draw(&docs.join("pictures"))?;
    std::fs::write(docs.join("validation-long.md"), results.page())?;
    let failed = results.failed();
    ensure!(
        failed.is_empty(),
        "these checks fail, see docs/validation-long.md: {failed:#?}"
    );
    println!("all checks pass: docs/validation-long.md is written");
    Ok(())
}
