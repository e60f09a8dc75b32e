//! Heaps: the slope of what a column leaves when it is let go, by friction.

use std::fmt::Write as _;

use anyhow::{Context, Result};
use mercury_engine::step::Engine;
use mercury_pictures::charts::{Axis, Chart, ChartPage, Series};

use super::fits::Line;
use super::{Reported, outcome, small_scene};
use crate::scenes::start_planned;

const FRICTIONS: [f64; 4] = [0.0, 0.1, 0.25, 0.6];
/// Length of the box and mean diameter, m.
const LENGTH: f64 = 0.3;
const DIAMETER: f64 = 5e-3;
/// Bins of a diameter.
const BINS: usize = 60;
/// Looks over the last tenth of a second.
const LOOKS: u64 = 20;

/// The surface: x (m) and height of the highest grain (m), and the largest speed (m/s).
struct Heap {
    surface: Vec<(f64, f64)>,
    speed: f64,
}

fn look(engine: &Engine, top: &mut [f64]) {
    let mut highest = [0.0f64; BINS];
    for record in &engine.particles.records {
        let bin = ((record.position.x / LENGTH * BINS as f64).max(0.0) as usize).min(BINS - 1);
        highest[bin] = highest[bin].max(record.position.z + record.radius);
    }
    for (mean, height) in top.iter_mut().zip(highest) {
        *mean += height / LOOKS as f64;
    }
}

fn heap(friction: f64) -> Result<Heap> {
    println!("repose: friction {friction}");
    let plan = small_scene(
        "repose",
        &[format!("materials.grain.tangential.friction={friction:?}")],
    )?;
    let (step, steps) = (plan.physics().time_step, plan.physics().steps);
    let mut engine = start_planned(plan);
    let last = (0.1 / step) as u64 / LOOKS;
    let before = steps.checked_sub(last * LOOKS);
    engine.steps_at_once(before.context("the scene is too short")?, None)?;
    let mut top = vec![0.0; BINS];
    for _ in 0..LOOKS {
        engine.steps_at_once(last, None)?;
        engine.complete_step()?;
        look(&engine, &mut top);
    }
    let place = |k: usize| (k as f64 + 0.5) * LENGTH / BINS as f64;
    let speeds = engine.particles.records.iter().map(|r| r.velocity.length());
    Ok(Heap {
        surface: top
            .iter()
            .enumerate()
            .map(|(k, &z)| (place(k), z))
            .collect(),
        speed: speeds.fold(0.0, f64::max),
    })
}

/// The slope of a surface, degrees: the line through it from the wall to where it is two grains high.
fn angle(surface: &[(f64, f64)]) -> f64 {
    let foot = surface.iter().position(|point| point.1 < 2.0 * DIAMETER);
    let flank = &surface[..foot.unwrap_or(surface.len()).max(3)];
    (-Line::through(flank).slope).atan().to_degrees()
}

/// Runs the heaps.
pub(super) fn tell(_runs: &std::path::Path) -> Result<Reported> {
    let mut chart = Chart::new(
        "Surfaces of heaps",
        Axis::linear("distance from the wall", "m"),
        Axis::linear("height", "m"),
    );
    let mut text = String::from(
        "\n| friction | slope (degrees) | largest speed at the end (m/s) |\n|---|---|---|\n",
    );
    let mut angles = Vec::new();
    for friction in FRICTIONS {
        let heap = heap(friction)?;
        let slope = angle(&heap.surface);
        angles.push(slope);
        let _ = writeln!(text, "| {friction} | {slope:.2} | {:.1e} |", heap.speed);
        chart = chart.with(Series::line(&format!("friction {friction}"), heap.surface));
    }
    let falls = angles.windows(2).filter(|pair| pair[1] <= pair[0]).count();
    let checks = vec![
        outcome(
            "repose: slope without friction (degrees)",
            0.0,
            angles[0],
            5.76,
            "internal friction of frictionless spheres, 5.76 degrees (from memory): Peyneau & Roux 2008, Phys. Rev. E 78, 011307",
        ),
        outcome(
            "repose: steps of friction at which the slope does not grow",
            0.0,
            falls as f64,
            0.0,
            "the angle of repose grows with friction",
        ),
    ];
    let _ = writeln!(
        text,
        "\n`tests/scenes/long/repose.toml`: 1000 spheres of 4.5 to 5.5 mm fill a gap of 60 mm beside a wall, periodic in depth; at 0.4 s the gate goes, at 5 s the surface is taken: the highest grain in each of {BINS} bins, mean of {LOOKS} looks in the last 0.1 s. \
         The slope is that of the line through it from the wall to where it is two grains high. There is no exact value for spheres; without friction it cannot be steeper than 5.76 degrees, at which even smooth spheres hold each other, and it must grow with friction.\n\n\
         ![Surfaces of heaps for four coefficients of friction](pictures/repose.svg)"
    );
    Ok(Reported {
        checks,
        text,
        pictures: vec![("repose.svg", ChartPage::of(chart))],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_of_a_wedge_and_of_a_level() {
        let place = |k: u32| 0.005 * (f64::from(k) + 0.5);
        let wedge: Vec<_> = (0..60)
            .map(|k| (place(k), (0.1 - place(k)).max(0.0)))
            .collect();
        assert!((angle(&wedge) - 45.0).abs() < 1e-9);
        let level: Vec<_> = (0..60).map(|k| (place(k), 0.02)).collect();
        assert!(angle(&level).abs() < 1e-9);
    }
}
