//! Rigid bodies: their free rotation, and their motion in the engine.

mod crossing;
mod prescribed;
mod restitution;
mod rotor;
mod templates;

use std::f64::consts::PI;

use glam::{DVec3, dvec3};
use mercury_common::formats::clump::Pebble;

use super::Clump;
use crate::state::MaterialIndex;

/// Touching spheres of diameter 1 m and density 1 kg/m^3 at `centres` (m), principal moments given in units of pi/6 kg m^2.
fn touching(name: &str, centres: &[DVec3], moments: DVec3) -> Clump {
    let pebbles = centres.iter().map(|&position| Pebble {
        position,
        radius: 0.5,
    });
    let volume = PI / 6.0 * centres.len() as f64;
    let moments = moments * (PI / 6.0);
    Clump::new(
        name,
        MaterialIndex::new(0),
        pebbles.collect(),
        volume,
        volume,
        moments,
    )
    .unwrap()
}

/// Three spheres in a row: I = (pi/6) diag(0.3, 2.3, 2.3).
fn rod() -> Clump {
    let centres = [-1.0, 0.0, 1.0].map(|x| dvec3(x, 0.0, 0.0));
    touching("rod", &centres, dvec3(0.3, 2.3, 2.3))
}

/// Seven spheres along x, three more along y above the middle: I = (pi/6) diag(11.4, 29, 39.4).
fn t_bar() -> Clump {
    let bar = (-3..=3).map(|x| dvec3(f64::from(x), 0.0, 0.0));
    let stem = (1..=3).map(|y| dvec3(0.0, f64::from(y), 0.0));
    let centres: Vec<DVec3> = bar.chain(stem).map(|c| c - dvec3(0.0, 0.6, 0.0)).collect();
    touching("t-bar", &centres, dvec3(11.4, 29.0, 39.4))
}
