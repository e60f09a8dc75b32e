//! Scenes and states that must be refused, or caught, with a message.

use anyhow::Result;
use mercury_engine::step::RunError;

use super::stage::{Stage, complaint};
use super::{Check, Found, Length};

pub(super) fn one_point(length: Length) -> Result<Found> {
    // So many at each side of the lattice.
    let sides = length.pick([9, 9, 6], [20, 20, 10u64]);
    // Sites lie at both ends.
    let ends = sides.map(|n| format!("{}e-20", n - 1)).join(",");
    let place = format!("particles.0.lattice.max=[{ends}]");
    let grains: u64 = sides.iter().product();
    let sets = |more: &[&str]| {
        let mut sets = vec![place.clone()];
        sets.extend(more.iter().map(|&set| set.to_owned()));
        sets
    };
    let mut checks = vec![Check::says(
        "refused, with two of the crowd named",
        &[
            "nothing was run",
            "particle 0",
            "so close to each other, and to others",
            "contact.overlap_error",
        ],
        &complaint("one-point", &sets(&[])),
        "all N (N - 1)/2 pairs overlap by more than contact.overlap_error: they are not counted one by one",
    )];
    let mut stage = Stage::open("one-point", &sets(&["contact.overlap_error=3.0"]))?;
    let outcome = stage.go(100);
    let message = outcome
        .as_ref()
        .err()
        .map_or("nothing".to_owned(), ToString::to_string);
    let mut check = Check::says(
        "let in, the guard stops the run and names the particle, place and time, and says what to do",
        &["step ", "particle ", " m/s", "guard.way = 0.5", "help: "],
        &message,
        "N springs at once push for N k 2R/m a second: more than half a radius in a step",
    );
    check.holds &= matches!(outcome, Err(RunError::Guarded { .. })) && stage.is_finite();
    checks.push(check);
    let steps = stage.engine.steps();
    let mut stage = Stage::open(
        "one-point",
        &sets(&["contact.overlap_error=3.0", "guard.policy=\"warn\""]),
    )?;
    stage.go(100)?;
    let there = stage.len() as u64 + stage.engine.boundaries().removed().number;
    checks.push(Check::exactly(
        "warned only: spheres that are there or counted as deleted",
        grains,
        there,
        "what leaves the domain is counted",
    ));
    checks.push(Check::exactly(
        "warned only: particles that are not a number",
        0,
        u64::from(!stage.is_finite()),
        "coincident centres are pushed apart along x, no 0/0",
    ));
    Ok(Found {
        checks,
        particles: grains as usize,
        steps: steps + 100,
        notes: Vec::new(),
    })
}

pub(super) fn denormals(_: Length) -> Result<Found> {
    let mut stage = Stage::open("denormals", &[])?;
    let steps = stage.engine.physics().steps;
    stage.go(steps)?;
    // v t, each step rounded to a multiple of 5e-324.
    let way = 1e-310 * 1e-3;
    let pair = stage.energies();
    let mut checks = vec![
        Check::within(
            "way of a sphere at 1e-310 m/s in 1 ms (m)",
            [way - 1000.0 * 2.5e-324, way + 1000.0 * 2.5e-324],
            stage.particle(2).position.y,
            "v t; rounded to denormal numbers, half of 4.9e-324 m in each step",
        ),
        Check::exactly(
            "particles that are not a number",
            0,
            u64::from(!(stage.is_finite() && pair.total().is_finite())),
            "no square of a small number divides anything",
        ),
    ];
    let source = "mass, moment of inertia and one over them must be normal numbers";
    let refused = ["nothing was run", "mass", "kg", "help: "];
    for (what, set) in [
        (
            "a sphere of 1e-110 m is refused",
            "particles.0.radius=1e-110",
        ),
        (
            "a density of 1e-320 kg/m³ is refused",
            "materials.grain.density=1e-320",
        ),
        (
            "a density of 1e308 kg/m³ in 1e3 m is refused",
            "materials.grain.density=1e300",
        ),
    ] {
        let mut sets = vec![set.to_owned()];
        if set.contains("1e300") {
            sets.push("particles.0.radius=1e4".to_owned());
        }
        checks.push(Check::says(
            what,
            &refused,
            &complaint("denormals", &sets),
            source,
        ));
    }
    let source = "its square, by which the fastest are found, must be a number";
    for (what, set, word) in [
        (
            "a velocity of 1e200 m/s is refused",
            "particles.0.velocity=[1e200,0.0,0.0]",
            "velocity",
        ),
        (
            "a spin of 1e200 rad/s is refused",
            "particles.0.angular_velocity=[1e200,0.0,0.0]",
            "angular velocity",
        ),
        (
            "a gravity of 1e300 m/s² is refused",
            "gravity=[0.0,0.0,-1e300]",
            "gravity",
        ),
    ] {
        let words = ["nothing was run", word, "help: "];
        checks.push(Check::says(
            what,
            &words,
            &complaint("denormals", &[set.to_owned()]),
            source,
        ));
    }
    Ok(Found {
        checks,
        particles: 3,
        steps,
        notes: Vec::new(),
    })
}
