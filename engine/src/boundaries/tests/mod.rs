//! The contract of the boundaries: totals, places, sizes, exits, histories.

mod behind;
mod clumps;
mod exits;
mod fluxes;
mod inserting;
mod regions;
mod speed;

use crate::state::MaterialIndex;
use glam::DVec3;
use mercury_common::scene::parse_psd;
use mercury_common::sizes::SizeDistribution;

use super::{Ingredient, InsertionPlan, Region, Total};
use crate::contact::registry::AnyPairLaw;
use crate::contact::{AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, Linear, PairLaw};
use crate::physics::Inputs;

/// A size law as its file would state it.
fn sizes(psd: &str) -> SizeDistribution {
    SizeDistribution::from_scene(&parse_psd("sizes.toml", psd, None).unwrap()).unwrap()
}

/// Spheres of one diameter, m.
fn monodisperse(diameter: f64) -> SizeDistribution {
    sizes(&format!("kind = \"monodisperse\"\ndiameter = {diameter}"))
}

/// Diameters uniform by number between two, m.
pub(super) fn uniform(min: f64, max: f64) -> SizeDistribution {
    sizes(&format!(
        "kind = \"uniform\"\nmin_diameter = {min}\nmax_diameter = {max}\nweighting = \"number\""
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
fn plan() -> Inputs {
    let mut plan = Inputs::new(1e-3, (DVec3::ZERO, DVec3::ONE), 1000.0, frictionless());
    plan.seed = 7;
    plan
}

fn unit_box() -> Region {
    Region::Box {
        min: DVec3::ZERO,
        max: DVec3::ONE,
    }
}

/// Insertion of grains at rest, as fast as they fit.
fn insertion(region: Region, sizes: SizeDistribution, total: Total) -> InsertionPlan {
    InsertionPlan {
        name: "feed".to_owned(),
        region,
        mixture: vec![Ingredient {
            material: MaterialIndex::new(0),
            clump: None,
            sizes,
            share: 1.0,
            properties: Vec::new(),
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
