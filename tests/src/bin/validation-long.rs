//! Writes `docs/validation-long.md`, the table of its checks and its pictures from runs of minutes, and what `docs/validation.md` shows of them. Ends with an error if a check fails or
//! has vanished.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use mercury_tests::long::{Page, chosen, run};

fn main() -> Result<()> {
    let mut arguments = std::env::args_os().skip(1);
    let runs = arguments.next().map(PathBuf::from);
    let runs = runs.context(
        "usage: validation-long FOLDER [SUBJECT...]\nFOLDER gets the runs; a finished run of the same plan that is there already is not made again\nSUBJECT: haff, janssen, repose, hopper-psd, chute, penetration-25k, drum-soft; all of them if none is named; none: the page is only written anew",
    )?;
    let keys: Vec<String> = arguments.map(|key| key.to_string_lossy().into()).collect();
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
    let (page_file, table_file) = (
        docs.join("validation-long.md"),
        docs.join("validation-long.csv"),
    );
    // As they are now: another subject may have been run by another command meanwhile.
    let old = || {
        let read = |path: &Path| std::fs::read_to_string(path).unwrap_or_default();
        Page::read(&read(&page_file), &read(&table_file))
    };
    let write = |page: &Page| {
        std::fs::write(&page_file, page.text())?;
        std::fs::write(&table_file, page.table())?;
        // The other page shows them too.
        let validation = docs.join("validation.md");
        let text = std::fs::read_to_string(&validation)?;
        std::fs::write(&validation, page.put_into(&text))
    };
    for subject in chosen(&keys)? {
        let reported = run(subject, &runs, &docs.join("pictures"))?;
        let mut page = old();
        page.put(subject, &reported);
        write(&page)?;
        println!("{}: docs/validation-long.md is written", subject.key);
    }
    let page = old();
    write(&page)?;
    page.complete()?;
    let failed = page.failed();
    ensure!(
        failed.is_empty(),
        "these checks fail, see docs/validation-long.md: {failed:#?}"
    );
    println!("all checks pass");
    Ok(())
}
