//! Liquid bridges against the grains that they join.

use std::f64::consts::PI;

use mercury_common::scene::{LawValues, Scene, SceneError};

use super::particles::StartingParticles;
use crate::bodies::Clump;
use crate::boundaries::InsertionPlan;
use crate::contact::parameter::short;

/// Finds every `max_bridge_volume` above the volume of the smallest grain of its material, in `[[contacts]]` of either material. Materials
/// of which there are no grains (those of walls) have no such bound.
pub(super) fn larger_than_grains(
    scene: &Scene,
    start: &StartingParticles,
    clumps: &[Clump],
    insertions: &[InsertionPlan],
    errors: &mut Vec<SceneError>,
) {
    let smallest = smallest_diameters(scene, start, clumps, insertions);
    for (material, &diameter) in scene.materials.iter().zip(&smallest) {
        if let Some(law) = &material.liquid {
            let name = &material.name.value;
            errors.extend(too_large(&law.values, name, diameter));
        }
    }
    for contact in &scene.contacts {
        let Some(law) = &contact.liquid else {
            continue;
        };
        let [a, b] = [0, 1].map(|side| contact.between[side].value.0);
        let smaller = if smallest[b] < smallest[a] { b } else { a };
        let name = &scene.materials[smaller].name.value;
        errors.extend(too_large(&law.values, name, smallest[smaller]));
    }
}

fn too_large(values: &LawValues, material: &str, diameter: f64) -> Option<SceneError> {
    let key = "max_bridge_volume";
    let (most, grain) = (
        values.number(key)?,
        PI / 6.0 * diameter * diameter * diameter,
    );
    // A diameter that was computed from a volume is not more exact than this.
    (most > grain * (1.0 + 1e-12)).then(|| {
        let message = format!(
            "is larger than the smallest grain of `{material}`, which has a diameter of {} m and {} m3, got {} m3",
            short(diameter),
            short(grain),
            short(most)
        );
        let help = format!(
            "a bridge holds a small part of a grain; give at most {} m3 (0.01 of it), or check the unit: 1 mm3 is 1e-9 m3",
            short(0.01 * grain)
        );
        values.get(key).map(|given| given.error(message).with_help(help))
    })?
}

/// Diameter of the smallest grain of each material, of a clump that of a sphere of its volume, m; infinite where there is none.
fn smallest_diameters(
    scene: &Scene,
    start: &StartingParticles,
    clumps: &[Clump],
    insertions: &[InsertionPlan],
) -> Vec<f64> {
    let mut smallest = vec![f64::INFINITY; scene.materials.len()];
    let mut note = |material: usize, diameter: f64| {
        smallest[material] = smallest[material].min(diameter);
    };
    for particle in &start.particles {
        note(particle.material.index(), 2.0 * particle.radius);
    }
    for body in &start.bodies {
        let clump = &clumps[body.clump as usize];
        let diameter = clump.equal_volume_diameter() * body.scale;
        note(clump.material.index(), diameter);
    }
    for part in insertions.iter().flat_map(|insertion| &insertion.mixture) {
        note(part.material.index(), part.sizes.smallest());
    }
    smallest
}
