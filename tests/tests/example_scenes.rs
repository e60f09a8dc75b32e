//! The scenes that the project ships are right, and its index names each of them.

use std::path::{Path, PathBuf};

use mercury_common::scene::read_scene;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes")
}

/// Scenes of a folder, by name.
fn scenes(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .expect("the folder can be listed")
        .map(|entry| entry.expect("the folder can be listed").path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "toml"))
        .filter(|path| !path.to_string_lossy().ends_with(".clump.toml"))
        .collect();
    files.sort();
    files
}

#[test]
fn every_scene_parses() {
    let mut files = scenes(&folder());
    files.extend(scenes(&folder().join("bench")));
    assert!(files.len() >= 11, "only {} scenes", files.len());
    for path in files {
        if let Err(errors) = read_scene(&path, &[]) {
            panic!("{}\n{errors}", path.display());
        }
    }
}

#[test]
fn the_index_names_every_scene() {
    let index = std::fs::read_to_string(folder().join("README.md")).expect("an index");
    for path in scenes(&folder()) {
        let name = path.file_name().expect("a name").to_string_lossy();
        assert!(
            index.contains(&format!("`{name}`")),
            "{name} is not in the index"
        );
    }
}
