//! Scenes to start from, as `mercury-solve new` writes them, and the schema of scenes.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, bail};
use cloud_api::answers::Template;
use cloud_store::{Store, sha256};

use crate::db::{ALL, Db};

const NAMES: [&str; 6] = ["drum", "hopper", "chute", "repose", "press", "clumps"];

/// Has the solver write its scenes, and keeps the files that they need as inputs of all users.
pub(crate) fn all(
    solver: &Path,
    scratch: &Path,
    store: &dyn Store,
    db: &Db,
) -> Result<Vec<Template>> {
    let mut templates = Vec::new();
    for name in NAMES {
        let folder = scratch.join(format!("new-{name}"));
        let output = Command::new(solver)
            .arg("new")
            .arg(name)
            .arg(&folder)
            .output()?;
        if !output.status.success() {
            bail!(
                "mercury-solve new {name}: {}",
                String::from_utf8_lossy(&output.stderr)
            );
        }
        let scene = format!("{name}.toml");
        let text = fs::read_to_string(folder.join(&scene)).with_context(|| scene.clone())?;
        let mut files = BTreeMap::new();
        for entry in fs::read_dir(&folder)? {
            let entry = entry?;
            let Ok(file) = entry.file_name().into_string() else {
                continue;
            };
            if file == scene {
                continue;
            }
            let content = fs::read(entry.path())?;
            let digits = sha256(&content);
            let key = format!("inputs/{digits}");
            if store.bytes(&key)?.is_none() {
                store.put(&key, &content)?;
            }
            db.add_input(&digits, ALL, content.len() as u64)?;
            files.insert(file, digits);
        }
        fs::remove_dir_all(&folder)?;
        // "drum.toml, drum-lifters.obj: Beads in a turning drum ..."
        let said = String::from_utf8_lossy(&output.stdout);
        let title = said
            .lines()
            .next()
            .and_then(|line| line.split_once(": "))
            .map_or(name, |(_, title)| title);
        templates.push(Template {
            name: name.to_owned(),
            title: title.to_owned(),
            scene,
            text,
            files,
        });
    }
    Ok(templates)
}

/// The JSON schema of scenes, as the solver prints it.
pub(crate) fn schema(solver: &Path) -> Result<String> {
    let output = Command::new(solver).arg("--schema").output()?;
    if !output.status.success() {
        let why = String::from_utf8_lossy(&output.stderr);
        bail!("mercury-solve --schema: {why}");
    }
    String::from_utf8(output.stdout).context("mercury-solve --schema")
}
