//! Piles at rest: they must stay so.

use anyhow::Result;
use glam::DVec3;

use super::stage::{Stage, complaint, ulp};
use super::{Check, Found, Length, gases};

const FLOOR: &str = "a velocity below half the spacing of places over Δt moves nothing, and one above meets the damping: v ≤ 2 ulp(x)/Δt in each direction";
const CREEP: &str = "a step moves a place by half the spacing of numbers too much or too little at worst: Σ ulp(x)/2";
const BALANCE: &str = "balance of the forces on a pile at rest: its floor carries its weight, within k ulp(x) of each contact with the floor";

pub(super) fn at_the_origin(length: Length) -> Result<Found> {
    pile("resting-pile", length)
}

pub(super) fn far_away(length: Length) -> Result<Found> {
    let mut found = pile("far-box", length)?;
    let gas = gases::far_away(length)?;
    found.checks.extend(gas.checks);
    found.steps += gas.steps;
    found.notes.extend(gas.notes);
    // 1e9 and 1e11 diameters away, where numbers lie 2.4e-7 m and 3e-5 m apart.
    let place = |x: &str| {
        let [min, max] = ["", ".012"].map(|part| format!("{x}{part}"));
        complaint(
            "far-box",
            &[
                format!("domain.min=[{min},0.0,0.0]"),
                format!("domain.max=[{max},0.012,0.03]"),
                "insertions=[]".to_owned(),
                format!(
                    "particles=[{{material=\"grain\",radius=1e-3,position=[{x}.006,0.006,0.006]}}]"
                ),
            ],
        )
    };
    found.checks.push(Check::says(
        "a sphere 1e9 diameters away is warned about",
        &[
            "taken; warnings",
            "particle 0",
            "overlaps would be lost in round-off",
            "move the scene to the origin",
        ],
        &place("2000000"),
        "ε |x| is above 1e-8 of the radius",
    ));
    found.checks.push(Check::says(
        "a sphere 1e11 diameters away is refused",
        &[
            "nothing was run",
            "particle 0",
            "overlaps would be lost in round-off",
            "move the scene to the origin",
        ],
        &place("200000000"),
        "ε |x| is above 1e-5 of the radius",
    ));
    Ok(found)
}

fn pile(scene: &str, length: Length) -> Result<Found> {
    // A layer comes to rest sooner than a pile.
    let (grains, settling, resting) = length.pick((20, 200_000, 20_000), (150, 300_000, 1_000_000));
    let mut stage = Stage::open(scene, &[format!("insertions.rain.total.number={grains}")])?;
    stage.go(settling)?;
    let mut ids: Vec<u32> = (stage.engine.particles.ids.iter())
        .map(|id| id.number())
        .collect();
    ids.sort_unstable();
    let places: Vec<DVec3> = ids.iter().map(|&id| stage.particle(id).position).collect();
    let reach = places
        .iter()
        .map(|x| x.abs().max_element())
        .fold(0.0, f64::max);
    let (spacing, dt) = (ulp(reach), stage.time_step());
    let mass: f64 = stage.free().map(|(_, mass)| mass).sum();
    // Until here it may still come to rest, from here on it must not move.
    let mut hottest = 0.0f64;
    const LOOKS: u64 = 20;
    for _ in 0..LOOKS {
        stage.go(resting / LOOKS)?;
        let energies = stage.energies();
        hottest = hottest.max(energies.kinetic + energies.rotational);
    }
    let creep = ids
        .iter()
        .zip(&places)
        .map(|(&id, &before)| (stage.particle(id).position - before).abs().max_element());
    let creep = creep.fold(0.0, f64::max);
    let observation = stage.engine.observation();
    let down: f64 = -observation
        .walls
        .iter()
        .map(|(load, _)| load.force.z)
        .sum::<f64>();
    let weight = mass * 9.81;
    // Hertz' tangent stiffness 2 E* √(R* overlap) of a wall contact, at an overlap of 1 % of the radius.
    let stiffness = 2.0 * (1e7 / (2.0 * 0.91)) * (1e-3f64 * 1e-5).sqrt();
    let speed = 2.0 * spacing / dt;
    let floor = 0.5 * mass * 3.0 * speed * speed;
    Ok(Found {
        checks: vec![
            Check::at_most("largest kinetic energy at rest (J)", floor, hottest, FLOOR),
            Check::at_most(
                "farthest that anyone creeps along an axis (m)",
                0.5 * spacing * resting as f64,
                creep,
                CREEP,
            ),
            Check::within(
                "load of the walls over the weight, less 1",
                [-1.0, 1.0].map(|side| {
                    side * 2.0 * stiffness * spacing * observation.wall_contacts as f64 / weight
                }),
                down / weight - 1.0,
                BALANCE,
            ),
            Check::exactly(
                "spheres that are still there",
                grains,
                stage.len() as u64,
                "nothing leaves a closed box",
            ),
        ],
        particles: stage.len(),
        steps: settling + resting,
        notes: vec![format!(
            "The kinetic energy of the fall of one diameter is {:.0e} J.",
            mass * 9.81 * 2e-3
        )],
    })
}

/// The column of two.
pub(super) fn mass_ratio(length: Length) -> Result<Found> {
    let steps = length.pick(20_000, 1_000_000);
    let mut stage = Stage::open("mass-ratio", &[])?;
    let before = [0, 1].map(|id| stage.particle(id).position);
    let weight: f64 = stage.free().map(|(_, mass)| mass * 9.81).sum();
    let (mut load, mut moved) = (0.0f64, 0.0f64);
    const LOOKS: u64 = 20;
    for _ in 0..LOOKS {
        stage.go(steps / LOOKS)?;
        let down = -stage.engine.observation().walls[0].0.force.z;
        load = load.max((down / weight - 1.0).abs());
        for (id, before) in before.iter().enumerate() {
            moved = moved.max((stage.particle(id as u32).position.z - before.z).abs());
        }
    }
    let aside = [0, 1].map(|id| stage.particle(id).position.truncate().abs().max_element());
    // Each step rounds the places by up to half their spacing; undamped, that is a walk.
    let walk = 4.0 * ulp(3e-3) * (steps as f64).sqrt();
    Ok(Found {
        checks: vec![
            Check::at_most(
                "farthest from the balance (m)",
                walk,
                moved,
                "round-off of places, undamped: a walk, four standard deviations",
            ),
            Check::at_most(
                "load of the floor over the weight, less 1",
                walk * 5e3 / weight,
                load,
                "stiffness times that",
            ),
            Check::at_most(
                "way to the side (m)",
                0.0,
                aside[0].max(aside[1]),
                "symmetry: forces to the side are zero to the bit",
            ),
        ],
        particles: 2,
        steps,
        notes: Vec::new(),
    })
}
