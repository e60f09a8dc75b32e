//! A silo whose floor sinks: what the walls carry (Janssen 1895).

use std::f64::consts::PI;
use std::fmt::Write as _;

use anyhow::{Context, Result};
use glam::DVec3;
use mercury_engine::forces::Partner;
use mercury_engine::step::Engine;
use mercury_pictures::charts::{Axis, Chart, ChartPage, Dash, Hue, Series};

use super::fits::least;
use super::{Reported, outcome, small_scene};
use crate::scenes::{RECORDS, start_planned};

/// m, m/s².
const RADIUS: f64 = 0.025;
const GRAVITY: f64 = 9.81;
/// Between grains and wall.
const FRICTION: f64 = 0.3;
/// Tangent of the angle of internal friction of spheres with a friction of 0.5 between them: 0.33 to 0.38 in slow shear, by codes of
/// several groups (GDR MiDi 2004, Eur. Phys. J. E 14, 341; from memory).
const BULK_FRICTION: f64 = 0.36;
/// Slices of 5 mm.
const SLICE: f64 = 0.005;
const SLICES: usize = 80;
/// When looking begins, s: the floor has sunk by seven grains. After one, friction at the wall had come to 65 % of its limit only.
const FROM: f64 = 4.3;
const LOOKS: u32 = 50;

/// Means over time, of slices over the floor.
#[derive(Debug, Clone, Default)]
struct Profile {
    /// Weight of the grains whose centres are in a slice, N.
    weight: Vec<f64>,
    /// Force of the wall on the grains along its axis, upwards, N.
    friction: Vec<f64>,
    /// Normal force of the grains on the wall, N.
    pressure: Vec<f64>,
    floor: f64,
}

impl Profile {
    fn add(&mut self, engine: &Engine, walls: [usize; 2]) {
        let floor = -0.01 * (engine.time() - 0.8).max(0.0);
        let slice = |z: f64| (((z - floor) / SLICE).max(0.0) as usize).min(SLICES - 1);
        let share = 1.0 / f64::from(LOOKS);
        for (record, mass) in engine
            .particles
            .records
            .iter()
            .zip(&engine.particles.masses)
        {
            self.weight[slice(record.position.z)] += share * mass * GRAVITY;
        }
        for record in engine.observation().records {
            let Partner::Wall { wall, .. } = record.partner else {
                continue;
            };
            if wall.index() == walls[0] {
                let outwards = DVec3::new(record.point.x, record.point.y, 0.0).normalize();
                self.friction[slice(record.point.z)] += share * record.force.z;
                self.pressure[slice(record.point.z)] -= share * record.force.dot(outwards);
            } else if wall.index() == walls[1] {
                self.floor += share * record.force.z;
            }
        }
    }

    /// Vertical stress at the lower end of each slice, Pa: what is above less what the wall carries of it.
    fn stress(&self) -> Vec<f64> {
        let area = PI * RADIUS * RADIUS;
        let mut above = 0.0;
        let mut stress: Vec<f64> = (0..SLICES)
            .rev()
            .map(|k| {
                above += self.weight[k] - self.friction[k];
                above / area
            })
            .collect();
        stress.reverse();
        stress
    }
}

/// Janssen's stress at a depth (m) for the stress ratio K, Pa.
fn janssen(density: f64, ratio: f64, depth: f64) -> f64 {
    let length = 2.0 * RADIUS / (4.0 * FRICTION * ratio);
    density * GRAVITY * length * (1.0 - (-depth / length).exp())
}

/// Runs the silo.
pub(super) fn tell(_runs: &std::path::Path) -> Result<Reported> {
    println!("janssen");
    let plan = small_scene("janssen", &[])?;
    let place = |name: &str| {
        let walls = &plan.physics().walls;
        let place = walls.iter().position(|wall| wall.name == name);
        place.with_context(|| format!("no wall {name}"))
    };
    let walls = [place("tube")?, place("floor")?];
    let (step, steps) = (plan.physics().time_step, plan.physics().steps);
    let mut engine = start_planned(plan);
    let begin = (FROM / step).round() as u64;
    let rest = (steps.checked_sub(begin)).context("the scene ends before the silo is looked at")?;
    engine.steps_at_once(begin, None)?;
    let mut seen = Profile {
        weight: vec![0.0; SLICES],
        friction: vec![0.0; SLICES],
        pressure: vec![0.0; SLICES],
        floor: 0.0,
    };
    for _ in 0..LOOKS {
        engine.steps_at_once(rest / u64::from(LOOKS), RECORDS)?;
        engine.complete_step()?;
        seen.add(&engine, walls);
    }
    let total: f64 = seen.weight.iter().sum();
    let carried: f64 = seen.friction.iter().sum();
    let stress = seen.stress();
    let area = PI * RADIUS * RADIUS;
    // The bulk is what fills the tube as the lower half of the content does; the top is where that would end.
    let middle = (0..SLICES)
        .find(|&k| seen.weight[..k].iter().sum::<f64>() > 0.5 * total)
        .context("an empty silo")?;
    // Two grains over the floor, where they lie in layers.
    let lower: f64 = seen.weight[2..middle].iter().sum();
    let density = lower / (GRAVITY * area * SLICE * (middle - 2) as f64);
    let height = total / (GRAVITY * area * density);
    let depth = |k: usize| height - k as f64 * SLICE;
    let inside: Vec<usize> = (2..SLICES).filter(|&k| depth(k) > 2.0 * SLICE).collect();
    let off = |ratio: f64| {
        let squares = inside
            .iter()
            .map(|&k| (stress[k] - janssen(density, ratio, depth(k))).powi(2));
        squares.sum::<f64>()
    };
    let ratio = least(0.1, 2.0, off);
    // Over the lower two thirds, by what the wall feels.
    let deep: Vec<usize> = (inside.iter().copied())
        .filter(|&k| depth(k) > height / 3.0)
        .collect();
    let sum = |values: &[f64]| deep.iter().map(|&k| values[k]).sum::<f64>();
    let direct = sum(&seen.pressure) / (2.0 * PI * RADIUS * SLICE) / sum(&stress);
    let mobilised = sum(&seen.friction) / (FRICTION * sum(&seen.pressure));
    // Growth of the stress over the lowest diameter.
    let ten = (2.0 * RADIUS / SLICE) as usize;
    let growth = (stress[2] - stress[2 + ten]) / (density * GRAVITY * 2.0 * RADIUS);
    // Of the wall's shear over the vertical stress: what Janssen's balance of a slice takes to be the same at every depth, as a
    // stress ratio for the full friction.
    let felt = direct * mobilised;
    let sine = BULK_FRICTION.atan().sin();
    let [active, passive] = [(1.0 - sine) / (1.0 + sine), (1.0 + sine) / (1.0 - sine)];
    let checks = vec![
        outcome(
            "janssen: floor and walls over the weight",
            1.0,
            (seen.floor + carried) / total,
            // Slow: the floor moves by 2e-4 of its own free fall.
            0.01,
            "balance of forces while the floor sinks slowly",
        ),
        outcome(
            "janssen: stress ratio K of the fitted curve over that of the forces on the wall",
            1.0,
            ratio / felt,
            // The wall is met by some 40 grains in each of the slices, and by each with a force of its own: 1/sqrt(40), and K may
            // change with the depth by as much.
            0.15,
            "Janssen 1895: the curve's K is the wall's shear over the vertical stress, over mu",
        ),
        outcome(
            "janssen: stress ratio at the wall, middle of Rankine's states",
            0.5 * (active + passive),
            direct,
            0.5 * (passive - active),
            "Rankine 1857: from (1 - sin phi)/(1 + sin phi) to its inverse; tan phi = 0.36 of spheres of friction 0.5 (GDR MiDi 2004, from memory)",
        ),
        outcome(
            "janssen: growth of the stress over the lowest diameter, over that of a liquid",
            0.0,
            growth,
            // exp(-4 mu K z/D) at the depth of its middle, at K = 0.4.
            (-4.0 * FRICTION * 0.4 * (height - 2.0 * RADIUS) / (2.0 * RADIUS)).exp(),
            "saturation: exp(-4 mu K z/D), K >= 0.4",
        ),
        outcome(
            "janssen: friction at the wall over mu times the force on it",
            0.5,
            mobilised,
            0.5,
            "Coulomb: at most 1; spheres roll down a wall too, so that it need not be 1",
        ),
    ];
    let mut text = String::new();
    let _ = writeln!(
        text,
        "\n`tests/scenes/long/janssen.toml`: {} spheres of 4.5 to 5.5 mm in a tube of 50 mm, friction 0.5 between them and {FRICTION} at the wall. The floor sinks at 10 mm/s from 0.8 s on; means over {LOOKS} looks from {FROM} s to {:.1} s. \
         The content is {:.0} mm high ({:.1} diameters) with a bulk density of {density:.0} kg/m³. The walls carry {:.0} % of its weight.\n\n\
         K by the fitted curve is {ratio:.3}. In the lower two thirds the force on the wall over the vertical stress is {direct:.3}, and friction is at {mobilised:.3} of its limit: {felt:.3} together. \
         The 0.4 to 0.6 of handbooks are for a silo while it is filled and its content is pressed together; here it is stretched as the floor sinks, which takes the ratio towards Rankine's passive state, above 1.\n\n\
         ![Vertical stress over depth with Janssen's curve, and that of a liquid](pictures/janssen.svg)",
        engine.particles.records.len(),
        engine.time(),
        1e3 * height,
        height / (2.0 * RADIUS),
        100.0 * carried / total,
    );
    let curve = |ratio: f64| -> Vec<(f64, f64)> {
        (0..=60)
            .map(|k| height * f64::from(k) / 60.0)
            .map(|z| (z, janssen(density, ratio, z)))
            .collect()
    };
    let liquid = vec![(0.0, 0.0), (0.4 * height, 0.4 * height * density * GRAVITY)];
    let points = (0..SLICES)
        .filter(|&k| depth(k) > -SLICE)
        .map(|k| (depth(k), stress[k]));
    let chart = Chart::new(
        "Vertical stress in a silo",
        Axis::linear("depth", "m"),
        Axis::linear("stress", "Pa"),
    )
    .with(
        Series::points("weight above less what the wall carries", points.collect()).hue(Hue::Blue),
    )
    .with(Series::line(&format!("Janssen, K = {ratio:.2}"), curve(ratio)).hue(Hue::Vermillion))
    .with(
        Series::line("liquid", liquid)
            .hue(Hue::Grey)
            .dash(Dash::Dashed),
    );
    Ok(Reported {
        checks,
        text,
        pictures: vec![("janssen.svg", ChartPage::of(chart))],
    })
}
