//! The contract of the boundaries: totals, places, sizes, exits, histories.

mod behind;
mod clumps;
mod exits;
mod fluxes;
mod inserting;
mod regions;
mod speed;

use std::path::Path;

use crate::plan::parse_scene;
use crate::state::MaterialIndex;
use glam::DVec3;
use mercury_common::scene::Files;
use mercury_common::sizes::SizeDistribution;

use super::{Ingredient, InsertionPlan, Region, Total};
use crate::contact::registry::AnyPairLaw;
use crate::contact::{AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, Linear, PairLaw};
use crate::plan::Draft;

/// A size law as a scene would write it.
fn sizes(psd: &str) -> SizeDistribution {
    let text = format!(
        r#"
        time = {{ end = 1.0, step = 0.1 }}
        domain = {{ min = [0, 0, 0], max = [1, 1, 1] }}
        output = {{ interval = 0.1 }}
        materials.m = {{ density = 1.0, normal = {{ law = "linear", stiffness = 1.0, dissipation = 0.0 }} }}
        [[insertions]]
        name = "feed"
        region = {{ shape = "sphere", origin = [0, 0, 0], radius = 1 }}
        material = "m"
        total = {{ full = true }}
        psd = {psd}
        "#
    );
    let scene = parse_scene(Path::new("test.toml"), &text, &[], Files::Unchecked).unwrap();
    SizeDistribution::from_scene(scene.insertions[0].mixture[0].psd.as_ref().unwrap()).unwrap()
}

/// Spheres of one diameter, m.
fn monodisperse(diameter: f64) -> SizeDistribution {
    sizes(&format!(
        r#"{{ kind = "monodisperse", diameter = {diameter} }}"#
    ))
}

/// Diameters uniform by number between two, m.
pub(super) fn uniform(min: f64, max: f64) -> SizeDistribution {
    sizes(&format!(
        r#"{{ kind = "uniform", min_diameter = {min}, max_diameter = {max}, weighting = "number" }}"#
    ))
}

fn frictionless() -> AnyPairLaw {
    PairLaw {
        normal: AnyNormal::Linear(Linear::new(1000.0, 0.0)),
        tangential: AnyTangential::None,
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    }
}

/// A plan in the unit cube with steps of 1 ms and a density of 1000 kg/m^3.
fn plan() -> Draft {
    let mut plan = Draft::new(1e-3, (DVec3::ZERO, DVec3::ONE), 1000.0, frictionless());
    plan.seed = 7;
    plan
}

fn unit_box() -> Region {
    Region::Box {
        min: DVec3::ZERO,
        max: DVec3::ONE,
    }
}

/// As fast as they fit, at rest.
fn insertion(region: Region, sizes: SizeDistribution, total: Total) -> InsertionPlan {
    InsertionPlan {
        name: "feed".to_owned(),
        region,
        mixture: vec![Ingredient {
            material: MaterialIndex::new(0),
            clump: None,
            sizes,
            share: 1.0,
            film_volume: 0.0,
        }],
        by_quota: false,
        total: Some(total),
        rate: None,
        velocity_mean: DVec3::ZERO,
        velocity_spread: DVec3::ZERO,
        from: 0.0,
        until: f64::INFINITY,
        attempts: 1000,
        closing: Vec::new(),
    }
}
