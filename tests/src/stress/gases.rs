//! Elastic gases: nothing may be lost or gained but what the integrator's corners explain.

use anyhow::{Result, ensure};

use super::energy_walk::EnergyWalk;
use super::stage::{Stage, ulp};
use super::{Check, Found, Length};

const WALK: &str = "jumps of leapfrog where a contact begins and ends (`tests/src/stress/energy_walk.rs`), with the drift that follows: four standard deviations";
const RATE: &str = "the same; four standard deviations of a variance, and 15 % for the rate of collisions by kinetic theory";
const MOMENTUM: &str = "forces of a pair are opposite to the bit; velocities are rounded by ε/2 in each kick: four standard deviations of the walk";

pub(super) fn linear(length: Length) -> Result<Found> {
    gas(
        "elastic-gas",
        &[],
        length.pick(20_000, 10_000_000),
        "",
        true,
    )
}

pub(super) fn hertz(length: Length) -> Result<Found> {
    gas(
        "elastic-gas-hertz",
        &[],
        length.pick(20_000, 10_000_000),
        "",
        true,
    )
}

pub(super) fn stiffness_ratio(length: Length) -> Result<Found> {
    // So few collisions between two looks are no sum of many.
    gas(
        "stiffness-ratio",
        &[],
        length.pick(100_000, 4_000_000),
        "",
        false,
    )
}

/// A million diameters from the origin.
pub(super) fn far_away(length: Length) -> Result<Found> {
    let sets = [
        "domain.min=[2000.0,2000.0,2000.0]",
        "domain.max=[2000.0105,2000.0105,2000.0105]",
        "insertions.gas.region.min=[2000.0,2000.0,2000.0]",
        "insertions.gas.region.max=[2000.0105,2000.0105,2000.0105]",
    ];
    let sets = sets.map(str::to_owned);
    gas(
        "elastic-gas",
        &sets,
        length.pick(20_000, 1_000_000),
        "gas: ",
        true,
    )
}

/// Looks at the energy every twentieth or hundredth of so many steps; `many`: with many collisions between two looks.
fn gas(scene: &str, sets: &[String], steps: u64, of: &str, many: bool) -> Result<Found> {
    let mut stage = Stage::open(scene, sets)?;
    ensure!(stage.len() == 64, "{} spheres came", stage.len());
    let walk = EnergyWalk::of(&stage);
    let (before, momentum) = (stage.energies().total(), stage.momentum().0);
    let looks = if steps > 500_000 { 100 } else { 20 };
    let (mut last, mut squares, mut farthest) = (before, 0.0, 0.0f64);
    for _ in 0..looks {
        stage.go(steps / looks)?;
        let now = stage.energies().total();
        squares += (now - last) * (now - last);
        farthest = farthest.max((now / before - 1.0).abs());
        last = now;
    }
    let time = steps as f64 * stage.time_step();
    let deviation = (walk.variance * time + walk.noise).sqrt() / before;
    let drift = walk.drift * time / before;
    // Each difference has the noise of two looks.
    let spread = squares / (walk.variance * time + 2.0 * looks as f64 * walk.noise);
    let slack = 4.0 * (2.0 / looks as f64).sqrt() + 0.15;
    let mut checks = vec![Check::within(
        format!("{of}relative change of the energy at the end"),
        [drift - 4.0 * deviation, drift + 4.0 * deviation],
        last / before - 1.0,
        WALK,
    )];
    if many {
        checks.push(Check::within(
            format!("{of}variance of the energy from look to look over that of walk and noise"),
            [1.0 - slack, 1.0 + slack],
            spread,
            RATE,
        ));
    }
    let (after, sum) = stage.momentum();
    let grains = stage.len() as f64;
    let rounding = ulp(1.0) * sum / grains * (grains * steps as f64).sqrt();
    checks.push(Check::at_most(
        format!("{of}change of the momentum (kg m/s)"),
        4.0 * rounding,
        (after - momentum).length(),
        MOMENTUM,
    ));
    Ok(Found {
        checks,
        particles: stage.len(),
        steps,
        notes: vec![format!(
            "{of}{:.0} collisions of each sphere; largest relative deviation of the energy at {looks} looks {farthest:.1e}; expected drift {drift:.1e} ± {deviation:.1e}.",
            2.0 * walk.collisions * time / grains
        )],
    })
}
