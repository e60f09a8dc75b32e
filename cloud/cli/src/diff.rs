//! Whether two runs have left the same bytes.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::Args;
use cloud_api::names::{Growth, growth, may_differ};

use crate::commands::say;

/// Times and counts of interruptions differ (`run.log`, `summary.json`, `plan.toml`, checkpoints); all else must not.
#[derive(Debug, Args)]
pub(crate) struct Diff {
    /// Folder of a run
    one: PathBuf,
    /// Folder of another
    other: PathBuf,
}

impl Diff {
    pub(crate) fn run(self) -> Result<ExitCode> {
        let mut names = BTreeSet::new();
        for folder in [&self.one, &self.other] {
            list(folder, "", &mut names).with_context(|| format!("{}", folder.display()))?;
        }
        let mut different = 0;
        let mut same = 0;
        for name in &names {
            if growth(name) == Growth::Never || may_differ(name) {
                continue;
            }
            match compare(&self.one.join(name), &self.other.join(name))? {
                None => same += 1,
                Some(how) => {
                    different += 1;
                    say(&format!("{name}: {how}"))?;
                }
            }
        }
        say(&format!("{same} files are the same, {different} differ"))?;
        Ok(if different == 0 && same > 0 {
            ExitCode::SUCCESS
        } else {
            ExitCode::FAILURE
        })
    }
}

fn list(folder: &Path, prefix: &str, names: &mut BTreeSet<String>) -> Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
        if entry.file_type()?.is_dir() {
            list(&entry.path(), &format!("{name}/"), names)?;
        } else {
            names.insert(name);
        }
    }
    Ok(())
}

/// `None`: the same bytes.
fn compare(one: &Path, other: &Path) -> Result<Option<String>> {
    let open = |path: &Path| File::open(path).map(BufReader::new);
    let (mut one, mut other) = match (open(one), open(other)) {
        (Ok(one), Ok(other)) => (one, other),
        (Err(_), _) => return Ok(Some("is in the second only".into())),
        (_, Err(_)) => return Ok(Some("is in the first only".into())),
    };
    let (mut a, mut b) = (vec![0; 1 << 16], vec![0; 1 << 16]);
    let mut at = 0;
    loop {
        let (n, m) = (fill(&mut one, &mut a)?, fill(&mut other, &mut b)?);
        if let Some(k) = (0..n.min(m)).find(|&k| a[k] != b[k]) {
            return Ok(Some(format!("differs from byte {} on", at + k)));
        }
        if n != m {
            return Ok(Some(format!("one ends at byte {}", at + n.min(m))));
        }
        if n == 0 {
            return Ok(None);
        }
        at += n;
    }
}

fn fill(reader: &mut impl Read, to: &mut [u8]) -> Result<usize> {
    let mut got = 0;
    while got < to.len() {
        match reader.read(&mut to[got..])? {
            0 => break,
            n => got += n,
        }
    }
    Ok(got)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_byte_is_a_difference() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, bytes: &[u8]| {
            let path = folder.path().join(name);
            fs::write(&path, bytes).unwrap();
            path
        };
        let a = write("a", &[7; 100_000]);
        assert_eq!(compare(&a, &write("b", &[7; 100_000])).unwrap(), None);
        assert!(compare(&a, &write("c", &[7; 99_999])).unwrap().is_some());
        let mut changed = [7; 100_000];
        changed[70_000] = 8;
        assert_eq!(
            compare(&a, &write("d", &changed)).unwrap().unwrap(),
            "differs from byte 70000 on"
        );
        assert!(compare(&a, &folder.path().join("e")).unwrap().is_some());
    }
}
