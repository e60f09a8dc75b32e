//! The scenes of the contract: they have a plan, or a clear refusal.

use std::path::Path;

use mercury_common::reference_data::shared;

use crate::plan::read_scene;

use super::super::{Plan, plan};

fn plan_of(folder: &Path, name: &str) -> Result<Plan, String> {
    let scene = read_scene(&folder.join(name), &[]).unwrap_or_else(|e| panic!("{e}"));
    plan(&scene).map_err(|errors| errors.to_string())
}

#[test]
fn scenes_of_this_version_have_a_plan() {
    let Some(folder) = shared("") else { return };
    for name in [
        "scenes/settle.toml",
        "scenes/two-spheres.toml",
        "scenes/hertz-wall.toml",
        "scenes/chute.toml",
        "scenes/wet-pair.toml",
        "scenes/spray-drum.toml",
        "scenes/wear-plate.toml",
        "scenes/membrane.toml",
        "scenes/drum-soft.toml",
        "scenes/hopper-psd.toml",
        "scenes/penetration-25k.toml",
        "data/bench/dense-2k.toml",
        "data/bench/dense-20k.toml",
        "data/bench/poly-20k.toml",
        "data/bench/mesh-drum-6k.toml",
    ] {
        let plan = plan_of(&folder, name).unwrap_or_else(|e| panic!("{name}\n{e}"));
        assert!(plan.physics().steps > 0);
        assert!(plan.notes().step().critical.is_some(), "{name}");
        assert!(!super::super::report(&plan, &crate::run::memory(&plan), None).is_empty());
    }
}
