//! An order that nothing disturbs.

use std::collections::BTreeMap;

use anyhow::Result;

use super::stage::Stage;
use super::{Check, Found, Length};

const SIDE: u64 = 5;

pub(super) fn lattice(length: Length) -> Result<Found> {
    let steps = length.pick(10_000, 1_000_000);
    let mut stage = Stage::open("lattice", &[])?;
    let grains = SIDE.pow(3) as u32;
    let before: Vec<_> = (0..grains).map(|id| stage.particle(id).position).collect();
    let (mut aside, mut unequal, mut turned) = (0u64, 0u64, 0u64);
    const LOOKS: u64 = 20;
    for _ in 0..LOOKS {
        stage.go(steps / LOOKS)?;
        let mut heights: BTreeMap<u64, [u64; 2]> = BTreeMap::new();
        for (id, before) in (0..grains).zip(&before) {
            let now = stage.particle(id);
            aside += u64::from(now.position.truncate() != before.truncate());
            turned += u64::from(now.angular_velocity.length_squared() != 0.0);
            // Bits of height and speed, which are the same in a layer.
            let bits = [now.position.z, now.velocity.z].map(f64::to_bits);
            let layer = u64::from(id) / (SIDE * SIDE);
            unequal += u64::from(*heights.entry(layer).or_insert(bits) != bits);
        }
    }
    let energy = stage.energies();
    Ok(Found {
        checks: vec![
            Check::exactly(
                "spheres that have moved aside, over 20 looks",
                0,
                aside,
                "symmetry: overlaps of both sides are equal to the bit, and so are their forces",
            ),
            Check::exactly(
                "spheres whose height or speed is not that of their layer to the bit, over 20 looks",
                0,
                unequal,
                "symmetry: all columns do the same arithmetic",
            ),
            Check::exactly(
                "spheres that turn, over 20 looks",
                0,
                turned,
                "symmetry: neighbours of a layer move alike, and nothing rubs",
            ),
        ],
        particles: stage.len(),
        steps,
        notes: vec![format!(
            "Kinetic energy at the end {:.1e} J.",
            energy.kinetic
        )],
    })
}
