//! Every file that is read for a scene: a service has to keep them with it, and a user has to pass them on.

use std::path::{Path, PathBuf};

use mercury_common::formats::clump::read_clump;
use mercury_common::scene::{NamedFile, Scene, SizeLaw, read_psd_with};

use super::Plan;

/// A file that is read for a scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SceneFile {
    /// The key of the scene that leads to it.
    pub key: String,
    /// Its name as typed; of a run that is started from the checkpoint that is used.
    pub name: String,
    /// The file that names it, as that was typed, unless the scene does so itself.
    pub from: Option<String>,
    /// Where it is.
    pub path: PathBuf,
}

/// All of them, in the order in which the scene names them, each behind the file that names it.
#[must_use]
pub fn files(scene: &Scene, plan: &Plan) -> Vec<SceneFile> {
    let mut all = Vec::new();
    for NamedFile { key, name, path } in scene.statement.files() {
        all.push(SceneFile {
            key: key.clone(),
            name: name.clone(),
            from: None,
            path: path.clone(),
        });
        for (inner, at) in named_by(scene, path) {
            all.push(SceneFile {
                key: key.clone(),
                name: inner,
                from: Some(name.clone()),
                path: at,
            });
        }
    }
    for from in plan.notes().started_from() {
        all.extend(from.files.iter().map(|path| SceneFile {
            key: from.key.clone(),
            name: seen_from(scene.directory(), path),
            from: None,
            path: path.clone(),
        }));
    }
    all
}

/// The name of a file as it is typed in a file of this folder.
fn seen_from(folder: &Path, path: &Path) -> String {
    let name = path.strip_prefix(folder).unwrap_or(path);
    name.display().to_string()
}

/// The files that a file names: the surface of a clump, the tables of a law of sizes. The plan has read them all but for surfaces, without
/// which a run goes on.
fn named_by(scene: &Scene, path: &Path) -> Vec<(String, PathBuf)> {
    if scene.clumps.iter().any(|clump| clump.file.value == path) {
        let file = read_clump(path).ok();
        let surface = file.and_then(|file| Some((file.surface.clone()?, file.surface_path(path)?)));
        return surface
            .filter(|(_, at)| scene.place.may_read(at).is_ok() && at.is_file())
            .into_iter()
            .collect();
    }
    let mut tables = Vec::new();
    if path.extension().is_some_and(|ending| ending == "toml") {
        tables_of(scene, path, &mut tables);
    }
    tables
}

/// The tables and laws that a law of sizes names.
fn tables_of(scene: &Scene, path: &Path, tables: &mut Vec<(String, PathBuf)>) {
    let Ok(law) = read_psd_with(path, scene.place.files().clone()) else {
        return;
    };
    let mut laws = vec![&law.law];
    while let Some(law) = laws.pop() {
        match law {
            SizeLaw::Mixture { of } => laws.extend(of.iter().map(|part| &part.psd.law)),
            SizeLaw::File { file } => {
                let name = seen_from(path.parent().unwrap_or(Path::new("")), file);
                if tables.iter().all(|(_, known)| *known != file.value) {
                    tables.push((name, file.value.clone()));
                    if file.extension().is_some_and(|ending| ending == "toml") {
                        tables_of(scene, &file.value, tables);
                    }
                }
            }
            _ => {}
        }
    }
}
