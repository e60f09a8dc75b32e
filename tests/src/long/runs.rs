//! The runs: made once, kept in folders.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, ensure};
use mercury_common::formats::table_head;
use mercury_solver::output::folder;
use mercury_solver::plan::read_scene;
use mercury_solver::plan::{document, plan};
use mercury_solver::run::{RunOptions, memory, run, useful_threads};

/// A finished run.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Run {
    folder: PathBuf,
    prefix: String,
    /// Particles.
    pub(super) particles: u64,
    /// Steps made.
    pub(super) steps: u64,
}

impl Run {
    /// Its folder.
    pub(super) fn folder(&self) -> &Path {
        &self.folder
    }

    /// The path of the file `<prefix>.<ending>`.
    pub(super) fn file(&self, ending: &str) -> PathBuf {
        self.folder.join(format!("{}.{ending}", self.prefix))
    }

    /// The columns with these names of a table with a header line, row by row.
    pub(super) fn table<const N: usize>(
        &self,
        ending: &str,
        names: [&str; N],
    ) -> Result<Vec<[f64; N]>> {
        let path = self.file(ending);
        let text = std::fs::read_to_string(&path)
            .with_context(|| format!("{}: cannot be read", path.display()))?;
        numbers(&text, names).with_context(|| path.display().to_string())
    }
}

/// The columns with these names of a comma-separated table; lines that begin with `#` are comments.
pub(super) fn numbers<const N: usize>(text: &str, names: [&str; N]) -> Result<Vec<[f64; N]>> {
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let mut places = [0; N];
    for (place, name) in places.iter_mut().zip(names) {
        *place = header
            .iter()
            .position(|column| table_head::name(column) == name)
            .with_context(|| format!("there is no column {name}"))?;
    }
    lines
        .map(|line| {
            let fields: Vec<&str> = line.split(',').collect();
            let mut row = [0.0; N];
            for (value, &place) in row.iter_mut().zip(&places) {
                let field = fields.get(place).copied().unwrap_or_default();
                *value = field
                    .parse()
                    .with_context(|| format!("`{line}`: `{field}` is no number"))?;
            }
            Ok(row)
        })
        .collect()
}

/// The run of `../shared/scenes/<scene>.toml`, with `KEY=VALUE` put on top, in `runs/<name>`: the one that is there if it is finished and of the same plan, else
/// a new one.
pub(super) fn finished(scene: &str, name: &str, overrides: &[String], runs: &Path) -> Result<Run> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../shared/scenes")
        .join(format!("{scene}.toml"));
    ensure!(
        path.exists(),
        "{}: the scene of the benchmark is not installed",
        path.display()
    );
    finished_at(&path, name, overrides, runs)
}

/// Finished run of the scene in a file.
pub(super) fn finished_at(
    path: &Path,
    name: &str,
    overrides: &[String],
    runs: &Path,
) -> Result<Run> {
    let plan = plan(&read_scene(path, overrides).map_err(|e| anyhow!("{e}"))?)
        .map_err(|e| anyhow!("{e}"))?;
    let (folder, prefix) = (runs.join(name), plan.outputs().prefix().to_owned());
    let document = document(&plan, &memory(&plan))?;
    let summary_path = folder.join("summary.json");
    let there = std::fs::read_to_string(folder.join("plan.toml")).is_ok_and(|old| old == document)
        && std::fs::read_to_string(&summary_path).is_ok_and(|text| is_finished(&text));
    if there {
        println!("{name}: the run in {} is taken", folder.display());
    } else {
        println!("{name}: runs into {}", folder.display());
        folder::prepare(&folder, &prefix, folder::Earlier::Replace)?;
        let options = RunOptions {
            folder: folder.clone(),
            threads: useful_threads(
                &plan,
                std::thread::available_parallelism().map_or(1, Into::into),
            ),
            command_line: format!("validation-long, scene {}", path.display()),
            plan_document: Some(document),
            ..RunOptions::default()
        };
        let report = run(plan, &options, &mut |_| ())?;
        println!("{report}");
    }
    let text = std::fs::read_to_string(&summary_path)?;
    ensure!(
        is_finished(&text),
        "{}: the run did not finish",
        summary_path.display()
    );
    let summary: serde_json::Value = serde_json::from_str(&text)?;
    let count = |name: &str| {
        summary[name]
            .as_u64()
            .with_context(|| format!("{}: no {name}", summary_path.display()))
    };
    Ok(Run {
        particles: count("particles")?,
        steps: count("steps")?,
        folder,
        prefix,
    })
}

fn is_finished(summary: &str) -> bool {
    serde_json::from_str::<serde_json::Value>(summary)
        .is_ok_and(|summary| summary["status"] == "finished")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_found_by_name() {
        let text = "# made by hand\ntime [s],name,z\n0,ball,1.5\n0.1,ball,-2e-3\n";
        assert_eq!(
            numbers(text, ["z", "time"]).unwrap(),
            [[1.5, 0.0], [-2e-3, 0.1]]
        );
        let message = |names| format!("{:#}", numbers(text, names).unwrap_err());
        assert_eq!(message(["vz"]), "there is no column vz");
        assert!(message(["name"]).contains("`ball` is no number"));
        assert!(numbers("time,z\n0\n", ["z"]).is_err());
    }

    #[test]
    fn a_stopped_or_torn_run_is_not_taken() {
        assert!(is_finished("{\"status\": \"finished\"}"));
        assert!(!is_finished("{\"status\": \"stopped\"}"));
        assert!(!is_finished("{\"status\": \"fin"));
    }
}
