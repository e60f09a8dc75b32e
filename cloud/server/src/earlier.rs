//! Scenes that start from the last state of another run: `[[particles]] run = "ID"`, with the id of a run on this server.
//!
//! The newest checkpoint of that run becomes an input like any other, kept by its content, so that the new run does not change with the
//! old one. For the solver it lies in a folder that has the id as its name.

use std::collections::BTreeSet;
use std::fs;

use cloud_api::requests::Scene;
use cloud_api::{Head, RunId};
use serde_json::Value;

use crate::access::ApiError;
use crate::inputs;
use crate::projects;
use crate::secrets;
use crate::state::App;

/// The runs that a scene starts from. A scene that cannot be read has none: what is wrong with it is said by the solver.
fn named(scene: &Scene) -> BTreeSet<RunId> {
    let json = scene.name.ends_with(".json");
    let document: Option<Value> = if json {
        serde_json::from_str(&scene.text).ok()
    } else {
        (scene.text.parse::<toml::Table>().ok()).and_then(|table| serde_json::to_value(table).ok())
    };
    let entries = document
        .as_ref()
        .and_then(|scene| scene["particles"].as_array());
    let in_text = (entries.into_iter().flatten()).filter_map(|entry| entry["run"].as_str());
    let in_sets = scene.set.iter().filter_map(|set| {
        let (key, value) = set.split_once('=')?;
        let key = key.trim();
        let is_run = key.starts_with("particles.") && key.ends_with(".run");
        is_run.then(|| value.trim().trim_matches(['"', '\'']))
    });
    in_text
        .chain(in_sets)
        .filter_map(|id| id.parse().ok())
        .collect()
}

/// Adds the checkpoints that a scene starts from to its files: once for all that is made of it, as the runs may go on meanwhile. A run
/// that the user may not see has none.
pub(crate) fn pin(app: &App, user: i64, scene: &mut Scene) -> Result<(), ApiError> {
    for run in named(scene) {
        let folder = format!("{run}/");
        // A clone has the state that its original had.
        if scene.files.keys().any(|name| name.starts_with(&folder)) {
            continue;
        }
        let Some((owner, _, row, _)) = app.db.run(run.as_str())? else {
            continue;
        };
        if owner != user && !projects::is_member(app, user, row.project.as_deref())? {
            continue;
        }
        let head = app.head(&run)?.unwrap_or_default();
        let Some(checkpoint) = head.checkpoint.as_ref() else {
            let detail = format!(
                "The run {run} has no checkpoint yet: it writes one when it is stopped, and at its end."
            );
            return Err(ApiError::bad_request("the run has no state", detail));
        };
        let name = format!("{folder}{}", checkpoint.name);
        let (sha256, bytes) = (&checkpoint.sha256, checkpoint.bytes);
        inputs::add(app, user, sha256, bytes, || keep(app, &run, &head))?;
        scene.files.insert(name, checkpoint.sha256.clone());
    }
    Ok(())
}

/// Copies the newest checkpoint of a run to the inputs.
fn keep(app: &App, run: &RunId, head: &Head) -> Result<(), ApiError> {
    let Some(checkpoint) = &head.checkpoint else {
        return Ok(());
    };
    let path = app.options.data.join("checks").join(secrets::random()?);
    let mut file = fs::OpenOptions::new()
        .read(true)
        .write(true)
        .create_new(true)
        .open(&path)?;
    // Its name is not needed any more; it goes when it is closed.
    fs::remove_file(&path)?;
    let sha256 = app
        .store
        .get_into(&format!("runs/{run}/{}", checkpoint.key), &mut file)?;
    if sha256 != checkpoint.sha256 {
        return Err(ApiError::internal(format!(
            "the checkpoint {} of run {run} is damaged",
            checkpoint.name
        )));
    }
    app.store
        .put_file(&inputs::key(&sha256), &mut file, 0..checkpoint.bytes)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: &str = "0123456789abcdef0123456789abcdef";
    const B: &str = "fedcba9876543210fedcba9876543210";

    fn runs(name: &str, text: &str, set: &[&str]) -> Vec<String> {
        let scene = Scene {
            name: name.to_owned(),
            text: text.to_owned(),
            set: set.iter().map(|set| (*set).to_owned()).collect(),
            ..Scene::default()
        };
        named(&scene).iter().map(ToString::to_string).collect()
    }

    #[test]
    fn runs_are_found_in_toml_json_and_sets() {
        let toml = format!("[[particles]]\nrun = \"{A}\"\n[[particles]]\nrun = \"../x\"\n");
        assert_eq!(runs("s.toml", &toml, &[]), [A]);
        let json = format!("{{\"particles\": [{{\"run\": \"{B}\"}}, {{\"file\": \"{A}\"}}, 3]}}");
        assert_eq!(runs("s.json", &json, &[]), [B]);
        let set = format!("particles.0.run = \"{B}\"");
        assert_eq!(runs("s.toml", &toml, &[&set, "particles.1.run=x"]), [A, B]);
        assert!(runs("s.toml", "particles = 3\n[", &[]).is_empty());
        assert!(runs("s.json", "[1, 2]", &["particles.0.run"]).is_empty());
    }
}
