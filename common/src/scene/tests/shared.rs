//! Every scene of the contract parses as it stands.

use std::path::{Path, PathBuf};

use crate::reference_data::shared;
use crate::scene::*;

fn scenes(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = ["scenes", "data/bench"]
        .iter()
        .flat_map(|part| std::fs::read_dir(folder.join(part)).expect("the folder can be listed"))
        .map(|entry| entry.expect("the folder can be listed").path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "toml"))
        .filter(|path| !path.to_string_lossy().ends_with(".clump.toml"))
        .collect();
    files.sort();
    files
}

#[test]
fn every_shared_scene_parses() {
    let Some(folder) = shared("") else { return };
    let files = scenes(&folder);
    assert!(files.len() >= 17, "only {} scenes", files.len());
    for path in files {
        // By the head of t-bar.toml its clump file is made first.
        let is_unmade = path.ends_with("t-bar.toml");
        let text = std::fs::read_to_string(&path).expect("the scene can be read");
        let files = if is_unmade {
            Files::Unchecked
        } else {
            Files::MustExist
        };
        if let Err(errors) = parse_scene(&path, &text, &[], files) {
            panic!("{}\n{errors}", path.display());
        }
    }
}

#[test]
fn the_clump_of_the_t_bar_is_requested() {
    let Some(folder) = shared("") else { return };
    let errors = read_scene(&folder.join("scenes/t-bar.toml"), &[]).expect_err("no clump file yet");
    assert_eq!(errors.0.len(), 1, "{errors}");
    assert_eq!(errors.0[0].path(), "clumps.t-bar.file");
}

#[test]
fn all_keys_arrive() {
    let Some(folder) = shared("") else { return };
    let scene = read_scene(&folder.join("scenes/keys.toml"), &[]).expect("keys.toml parses");
    assert_eq!(scene.title, "All keys");
    assert_eq!(scene.seed, 1);
    assert_eq!(scene.time.step.value, TimeStep::Auto);
    assert_eq!(scene.domain.periodic, [true, false, false]);
    let names: Vec<&str> = scene.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["a", "b", "c"]);
    assert_eq!(scene.contacts.len(), 3);
    assert_eq!(scene.contacts[2].between[1].value, MaterialIndex(2));
    let shapes: Vec<&str> = scene.walls.iter().map(|wall| wall.name.as_str()).collect();
    assert_eq!(
        shapes,
        [
            "box", "lid", "plate", "pipe", "funnel", "ball", "vessel", "mesh"
        ]
    );
    let Shape::Box { sides } = &scene.walls[0].shape else {
        panic!("box")
    };
    assert_eq!(
        sides.iter().map(|side| side.name()).collect::<Vec<_>>(),
        ["-y", "+y", "-z", "+z"]
    );
    assert_eq!(scene.walls[2].motion.len(), 2);
    assert_eq!(scene.particles.len(), 5);
    assert_eq!(scene.clumps[0].name.value, "rod");
    let feed = &scene.insertions[0];
    assert_eq!(feed.mixture.len(), 2);
    assert_eq!(
        feed.total.as_ref().map(|total| &total.value),
        Some(&Target::Of(Total::Mass(0.5)))
    );
    assert_eq!(*feed.attempts, 1000);
    assert_eq!(scene.output.track[0].value, "first");
    assert_eq!(scene.output.restart_interval.as_deref(), Some(&0.5));
    assert!(scene.output.digits.is_none());
}

#[test]
fn defaults_are_those_of_the_contract() {
    let Some(folder) = shared("") else { return };
    let scene = read_scene(&folder.join("scenes/drum-soft.toml"), &[]).expect("parses");
    assert_eq!(scene.seed, 0);
    assert_eq!(scene.contact.tangential_history, TangentialHistory::Project);
    assert_eq!(scene.contact.rolling_lever, RollingLever::ReducedRadius);
    assert_eq!(scene.contact.coulomb_limits, CoulombLimits::Bounded);
    assert_eq!(
        (*scene.contact.overlap_error, *scene.contact.overlap_warning),
        (0.5, 0.1)
    );
    let normal = scene.contacts[0].normal.as_ref().expect("an override");
    assert!(normal.name.is_none());
    assert_eq!(normal.values.number("restitution"), Some(0.45));
    let Shape::Mesh { side, mesh } = &scene.walls[0].shape else {
        panic!("mesh")
    };
    assert_eq!((*side, *mesh.scale), (MeshSide::Both, 1.0));
    let output = &scene.output;
    let files = output.switches;
    assert!(files.data && files.ene && files.frames && files.walls && files.pictures);
    assert!(!files.fstat && !files.vtk && !output.energy_budget);
    assert_eq!(*output.fstat_interval, 0.1);
    assert_eq!(output.clumps_as, ClumpsAs::Bodies);
}
