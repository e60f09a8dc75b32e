//! The scenes that the project ships are right, and its index names each of them.

use std::path::{Path, PathBuf};

use mercury_common::scene::Files;
use mercury_solver::plan::{parse_scene, plan, read_scene};

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

/// The scene of all keys has a plan, but for what excludes each other: sprays and membranes.
#[test]
fn the_scene_of_all_keys_has_a_plan() {
    let path = folder().join("keys.toml");
    for without in ["membranes=[]", "sprays=[]"] {
        let scene = read_scene(&path, &[without.to_owned()]);
        let planned = scene.and_then(|scene| plan(&scene));
        if let Err(errors) = planned {
            panic!("{without}\n{errors}");
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
fn the_scene_beside_a_script_of_another_code_is_a_whole_one() {
    let blocks = toml_blocks("docs/how-to/start-from-a-scene.md");
    assert_eq!(blocks.len(), 1);
    let path = Path::new("from-liggghts.toml");
    let read = parse_scene(path, &blocks[0], &[], Files::MustExist);
    let scene = read.unwrap_or_else(|errors| panic!("{errors}"));
    let plan = plan(&scene).unwrap_or_else(|errors| panic!("{errors}"));
    assert!(
        plan.notes().warnings().is_empty(),
        "{:?}",
        plan.notes().warnings()
    );
}

/// Nineteen pictures, all there and small, and each chapter with its commands and files that are there.
#[test]
fn the_gallery_is_whole() {
    let docs = folder().join("../docs");
    let text = std::fs::read_to_string(docs.join("gallery.md")).expect("the page is there");
    let chapters: Vec<&str> = text.split("\n## ").skip(1).collect();
    assert_eq!(chapters.len(), 19);
    for chapter in chapters {
        let title = chapter.lines().next().unwrap_or_default();
        assert!(chapter.contains("```sh\nmercury-"), "{title}: no command");
        let links = chapter.split("](").skip(1);
        let links: Vec<&str> = links.filter_map(|rest| rest.split(')').next()).collect();
        let pictures = links.iter().filter(|link| link.starts_with("pictures/"));
        assert_eq!(pictures.count(), 1, "{title}");
        for link in links {
            let path = docs.join(link.split('#').next().unwrap_or_default());
            let file = std::fs::metadata(&path);
            let file = file.unwrap_or_else(|error| panic!("{title}: {}: {error}", path.display()));
            assert!(
                !link.starts_with("pictures/") || file.len() < 250_000,
                "{title}: {} bytes",
                file.len()
            );
        }
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
