//! Granular gases that cool: 1/sqrt(T) grows in proportion to the time where the restitution is constant (Haff 1983).

use std::f64::consts::PI;
use std::fmt::Write as _;

use anyhow::Result;
use glam::DVec3;
use mercury_engine::step::Engine;
use mercury_pictures::charts::{Axis, Chart, ChartPage, Dash, Hue, Series};
use mercury_solver::plan::Plan;

use super::fits::Line;
use super::{Reported, outcome, small_scene};
use crate::cases::Outcome;
use crate::scene_checks::planned;
use crate::scenes::start_planned;

const RESTITUTION: f64 = 0.9;
/// Number of times at which the temperature is taken.
const LOOKS: u64 = 120;

/// The course of a gas: time (s) and temperature, (2/3) of the kinetic energy per mass beyond that of the whole, m²/s².
fn cool(plan: Plan) -> Result<Vec<[f64; 2]>> {
    let steps = plan.physics().steps;
    let mut engine = start_planned(plan);
    let mut course = Vec::new();
    for _ in 0..LOOKS {
        engine.steps_at_once(steps / LOOKS, None)?;
        engine.complete_step()?;
        course.push([engine.time(), temperature(&engine)]);
    }
    Ok(course)
}

fn temperature(engine: &Engine) -> f64 {
    let (mut mass, mut momentum, mut energy) = (0.0, DVec3::ZERO, 0.0);
    let mut add = |m: f64, velocity: DVec3, rotation: f64| {
        mass += m;
        momentum += m * velocity;
        energy += 0.5 * m * velocity.length_squared() + rotation;
    };
    let bodies = engine.particles.bodies();
    for body in bodies {
        add(body.mass, body.velocity, body.rotational_energy());
    }
    if bodies.is_empty() {
        for (record, &m) in engine
            .particles
            .records
            .iter()
            .zip(&engine.particles.masses)
        {
            add(m, record.velocity, 0.0);
        }
    }
    (energy - 0.5 * momentum.length_squared() / mass) * 2.0 / (3.0 * mass)
}

/// Growth of 1/sqrt(T/m) (s/m per s) of hard spheres: (1 - e^2)/6 of 4 sqrt(pi) n d^2 chi, with chi of Carnahan & Starling (1969) and the
/// Sonine correction of van Noije & Ernst (1998).
fn hard_spheres(number: f64, diameter: f64, volume: f64) -> f64 {
    let e = RESTITUTION;
    let fraction = number * PI / 6.0 * diameter.powi(3) / volume;
    let chi = (1.0 - 0.5 * fraction) / (1.0 - fraction).powi(3);
    let a2 = 16.0 * (1.0 - e) * (1.0 - 2.0 * e * e) / (81.0 - 17.0 * e + 30.0 * e * e * (1.0 - e));
    let collisions = 4.0 * PI.sqrt() * number / volume * diameter * diameter * chi;
    (1.0 - e * e) / 6.0 * collisions * (1.0 + 3.0 / 16.0 * a2)
}

/// The scene of a gas of clumps in a larger box, inelastic.
fn clumps(name: &str, side: f64, number: u32, end: f64) -> Result<Plan> {
    planned(
        &format!("clumps/{name}-gas.toml"),
        &[
            format!("time.end={end}"),
            format!("domain.max=[{side:.1},{side:.1},{side:.1}]"),
            format!("insertions.gas.region.max=[{side:.1},{side:.1},{side:.1}]"),
            format!("insertions.gas.total.number={number}"),
            format!(
                "materials.smooth.normal={{law=\"linear\",stiffness=3e5,restitution={RESTITUTION}}}"
            ),
        ],
    )
}

/// Runs the gases.
pub(super) fn tell(_runs: &std::path::Path) -> Result<Reported> {
    let mut checks: Vec<Outcome> = Vec::new();
    let mut chart = Chart::new(
        "Granular gases that cool, e = 0.9",
        Axis::linear("time over that of the run", ""),
        Axis::linear("√(T of the first look / T)", ""),
    );
    let mut text = String::from(
        "\n| gas | bodies | T at the start (m²/s²) | T at the end over that | R² of the line |\n|---|---|---|---|---|\n",
    );
    for (name, plan, number, hue) in [
        ("spheres", small_scene("haff", &[])?, 1600, Hue::Blue),
        (
            "rods",
            clumps("rod", 24.0, 480, 40.0)?,
            480,
            Hue::Vermillion,
        ),
        ("T-bars", clumps("t-bar", 36.0, 233, 40.0)?, 233, Hue::Green),
    ] {
        println!("haff: {name}");
        let course = cool(plan)?;
        // The start is not that of a cooling gas: spheres begin with uniform velocities, clumps without turning.
        let from = course[course.len() - 1][0] * if name == "spheres" { 0.1 } else { 0.2 };
        let points: Vec<(f64, f64)> = course
            .iter()
            .filter(|row| row[0] > from)
            .map(|row| (row[0], row[1].sqrt().recip()))
            .collect();
        let line = Line::through(&points);
        checks.push(outcome(
            &format!("haff: {name}: R squared of the line 1/sqrt(T) over t"),
            1.0,
            line.r_squared,
            1e-3,
            "Haff 1983: dT/dt is proportional to T^(3/2) where e is constant; R squared >= 0.999",
        ));
        if name == "spheres" {
            let expected = hard_spheres(1600.0, 1e-3, 0.0256f64.powi(3));
            checks.push(outcome(
                "haff: spheres: growth of 1/sqrt(T) (1/m)",
                expected,
                line.slope,
                // Three standard deviations of sqrt(T) of 1600 spheres at the end, sqrt(1/(6 N)).
                3.0 * (1.0f64 / (6.0 * 1600.0)).sqrt() * expected,
                "hard spheres: (1 - e^2)/6 of the collision rate (Carnahan & Starling 1969; van Noije & Ernst 1998)",
            ));
        }
        let (first, last) = (course[0][1], course[course.len() - 1]);
        let _ = writeln!(
            text,
            "| {name} | {number} | {first:.3e} | {:.4} | {:.5} |",
            last[1] / first,
            line.r_squared
        );
        let scaled = |t: f64, y: f64| (t / last[0], y * first.sqrt());
        let seen = course
            .iter()
            .map(|row| scaled(row[0], row[1].sqrt().recip()));
        let fit = [from, last[0]].map(|t| scaled(t, line.at(t)));
        chart = chart
            .with(Series::line(name, seen.collect()).hue(hue))
            .with(
                Series::line("", fit.into())
                    .hue(Hue::Ink)
                    .dash(Dash::Dashed),
            );
    }
    text.push_str("\nSpheres: `tests/scenes/long/haff.toml`; rods and T-bars: `scenes/clumps/rod-gas.toml` and `t-bar-gas.toml` with more bodies in a larger box and e = 0.9. Smooth, without gravity, periodic. The line is fitted from a tenth (clumps: a fifth) of the time on.\n\n![1/√T over time for spheres, rods and T-bars with fitted lines](pictures/haff.svg)\n");
    Ok(Reported {
        checks,
        text,
        pictures: vec![("haff.svg", ChartPage::of(chart))],
    })
}
