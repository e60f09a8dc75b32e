//! The scenes that the project ships are right, and its index names each of them.

use std::path::{Path, PathBuf};

use mercury_common::scene::Files;
use mercury_solver::plan::{parse_scene, read_scene};

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
    files.extend(scenes(&folder().join("clumps")));
    files.extend(scenes(&folder().join("wear")));
    assert!(files.len() >= 19, "only {} scenes", files.len());
    for path in files {
        if let Err(errors) = read_scene(&path, &[]) {
            panic!("{}\n{errors}", path.display());
        }
    }
}

#[test]
fn the_index_names_every_scene() {
    let index = std::fs::read_to_string(folder().join("README.md")).expect("an index");
    let mut files = scenes(&folder());
    files.extend(scenes(&folder().join("clumps")));
    files.extend(scenes(&folder().join("wear")));
    for path in files {
        let name = path.file_name().expect("a name").to_string_lossy();
        assert!(
            index.contains(&format!("`{name}`")),
            "{name} is not in the index"
        );
    }
}

/// The blocks of a page that are fenced as TOML.
fn toml_blocks(page: &str) -> Vec<String> {
    let text = std::fs::read_to_string(folder().join("..").join(page)).expect("the page is there");
    text.split("```toml\n")
        .skip(1)
        .map(|rest| rest.split("```").next().unwrap_or_default().to_owned())
        .collect()
}

#[test]
fn the_scene_of_the_readme_parses() {
    let blocks = toml_blocks("README.md");
    assert_eq!(blocks.len(), 1);
    let read = parse_scene(Path::new("README.toml"), &blocks[0], &[], Files::MustExist);
    if let Err(errors) = read {
        panic!("{errors}");
    }
}

#[test]
fn the_steps_of_the_tutorial_lead_to_the_drum() {
    let lines = |text: &str| -> Vec<String> {
        text.lines()
            .map(|line| line.split('#').next().unwrap_or_default().trim().to_owned())
            .filter(|line| !line.is_empty())
            .collect()
    };
    let drum = std::fs::read_to_string(folder().join("drum.toml")).expect("the scene is there");
    let mut wanted = lines(&drum);
    let mut shown = lines(&toml_blocks("docs/how-to/write-a-scene.md").concat());
    wanted.sort();
    shown.sort();
    assert_eq!(shown, wanted);
}
