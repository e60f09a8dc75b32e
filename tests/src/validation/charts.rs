//! Pictures of results that a table does not show well.

use std::path::Path;

use anyhow::Result;
use glam::DVec3;
use mercury_engine::contact::normal::{effective_modulus, effective_shear_modulus};
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, Hertz, Linear, Mindlin, PairLaw,
};
use mercury_engine::state::volume;
use mercury_pictures::charts::{Axis, Chart, ChartPage, Dash, Hue, Marker, Series};

use super::Results;
use crate::published::Published;
use crate::scene_checks::{hertz_wall_rebound, two_spheres_collide};
use crate::scenes::{advance, frictionless, particle, plan, plane, sphere, start};
use crate::wet::WetCollision;

/// Draws all charts into a folder.
///
/// # Errors
/// If a file cannot be written.
pub fn draw(results: &Results, folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder)?;
    hertz_phase(&folder.join("hertz-phase.svg"))?;
    convergence(&folder.join("convergence.svg"))?;
    wet_restitution(&folder.join("wet-restitution.svg"))?;
    if let Some(published) = Published::find() {
        published.draw(folder)?;
    }
    oblique_impact(results, &folder.join("oblique-impact.svg"))
}

/// Restitution of hertz-wall.toml over the phase of the first touch for three time steps.
fn hertz_phase(path: &Path) -> Result<()> {
    let line = |name, step: f64| {
        let phases = (0..=64).map(|k| f64::from(k) / 64.0);
        let points = phases.map(|phase| (phase, hertz_wall_rebound(step, phase)));
        Series::line(name, points.collect())
    };
    let chart = Chart::new(
        "Hertz impact: restitution over the phase of the first touch (0.4 requested)",
        Axis::linear("first touch within the step", ""),
        Axis::linear("restitution", ""),
    )
    .with(line("dt = 0.5 µs", 5e-7))
    .with(line("dt = 0.25 µs", 2.5e-7))
    .with(line("dt = 0.125 µs", 1.25e-7));
    Ok(ChartPage::of(chart).write_svg(path)?)
}

/// Restitution of two wet grains over the Stokes number, with and without tension, for bridges that form at the touch and where films meet.
fn wet_restitution(path: &Path) -> Result<()> {
    let mut chart = Chart::new(
        "Two wet grains, e = 0.8 when dry: restitution over the Stokes number",
        Axis::log("Stokes number, v m*/(6π η R*²)", ""),
        Axis::linear("restitution", ""),
    );
    let collision = |films, tension, speed| WetCollision {
        at_wall: false,
        films,
        tension,
        speed,
    };
    let unit = collision(false, 0.0, 1.0).speed_of_film();
    for (films, form, hue) in [
        (false, "at the touch", Hue::Blue),
        (true, "as films meet", Hue::Vermillion),
    ] {
        let theory = (0..=80).map(|k| {
            let stokes = 4.0 * f64::powf(100.0, f64::from(k) / 80.0);
            (stokes, collision(films, 0.0, stokes * unit).theory())
        });
        chart = chart.with(
            Series::line(&format!("theory without tension, {form}"), theory.collect()).hue(hue),
        );
        for (tension, what) in [(0.0, "no tension"), (0.07, "0.07 N/m")] {
            let points = (0..=10).map(|k| {
                let stokes = 5.0 * f64::powf(60.0, f64::from(k) / 10.0);
                let found = collision(films, tension, stokes * unit).restitution();
                (stokes, found)
            });
            let name = format!("Mercury, {what}, {form}");
            let marker = if tension == 0.0 {
                Marker::Ring
            } else {
                Marker::Cross
            };
            chart = chart.with(
                Series::points(&name, points.collect())
                    .hue(hue)
                    .marker(marker),
            );
        }
    }
    Ok(ChartPage::of(chart).write_svg(path)?)
}

/// Errors over the time step.
fn convergence(path: &Path) -> Result<()> {
    let steps: Vec<f64> = (0..8).map(|k| 1.6e-4 / f64::from(1 << k)).collect();
    let of = |error: fn(f64) -> f64| steps.iter().map(|&step| (step, error(step))).collect();
    let collision = |step| (two_spheres_collide(step).0 - 0.7).abs();
    let chart = Chart::new(
        "Errors over the time step",
        Axis::log("time step", "s"),
        Axis::log("error", ""),
    )
    .with(Series::marked_line(
        "collision: restitution of two-spheres.toml",
        of(collision),
    ))
    .with(Series::marked_line(
        "oscillation: place after 0.02 s, over the amplitude",
        of(oscillation_error),
    ))
    .with(
        Series::line("slope 2", of(|step| 3e4 * step * step))
            .hue(Hue::Grey)
            .dash(Dash::Dashed),
    );
    Ok(ChartPage::of(chart).write_svg(path)?)
}

/// Error of the place of an undamped sphere on a spring after 0.02 s, over the amplitude: x = A cos(w t).
fn oscillation_error(step: f64) -> f64 {
    let (stiffness, gravity, amplitude) = (1e4, 100.0, 4e-3);
    let mut plan = plan(
        step,
        6.0 / std::f64::consts::PI,
        frictionless(AnyNormal::Linear(Linear::new(stiffness, 0.0))),
    );
    plan.gravity = DVec3::NEG_Z * gravity;
    plan.walls.push(plane(DVec3::ZERO, DVec3::Z));
    // mass 1 kg
    let rest = 0.5 - gravity / stiffness;
    let place = DVec3::new(0.0, 0.0, rest + amplitude);
    let ball = sphere(place, 0.5, DVec3::ZERO, DVec3::ZERO);
    let mut engine = start(plan.with_particles(vec![ball]));
    advance(&mut engine, (0.02 / step).round() as u64);
    let exact = amplitude * (stiffness.sqrt() * engine.time()).cos();
    ((particle(&engine, 0).position.z - rest - exact) / amplitude).abs()
}

/// Tangential rebound over impact angle, solver and table.
fn oblique_impact(results: &Results, path: &Path) -> Result<()> {
    // "T13 engine: Mindlin rebound from psi = 0.5000, factor 2/3"
    let rows = |variant: &str| -> Vec<(f64, f64)> {
        let rows = results.cases.iter().filter_map(|case| {
            let rest = case
                .name
                .strip_prefix("T13 engine: Mindlin rebound from psi = ")?;
            let (psi, name) = rest.split_once(", ")?;
            (name == variant).then_some(())?;
            Some((psi.parse().ok()?, case.expected))
        });
        rows.collect()
    };
    let mut chart = Chart::new(
        "Oblique elastic impact on a wall, Hertz-Mindlin, ν = 0.3",
        Axis::linear("tangential over normal velocity before, κ u / (μ v)", ""),
        Axis::linear("tangential velocity after, κ u / (μ v)", ""),
    );
    for (variant, factor, hue) in [
        ("factor 2/3", 2.0 / 3.0, Hue::Vermillion),
        ("factor 1", 1.0, Hue::Blue),
    ] {
        let rows = rows(variant);
        anyhow::ensure!(!rows.is_empty(), "no rows of the oblique impact, {variant}");
        let before = (0..=110).map(|k| 0.5 + 0.05 * f64::from(k));
        let after = before.map(|psi| (psi, rebound(psi, factor))).collect();
        let ours = Series::line(&format!("stiffness {variant}: solver"), after);
        chart = chart
            .with(ours.hue(hue))
            .with(Series::points("expected", rows).hue(hue));
    }
    Ok(ChartPage::of(chart).write_svg(path)?)
}

/// Tangential velocity of the contact point after an elastic impact on a wall, kappa u/(mu v), for the one before: the set-up of
/// the table's rows with a coarser step.
fn rebound(psi: f64, factor: f64) -> f64 {
    let (poisson, friction, radius, density, speed) = (0.3, 0.3, 0.005, 2500.0, 7.5e-7);
    let material = (1e7, poisson);
    let kappa = 2.0 * (1.0 - poisson) / (2.0 - poisson);
    let normal = Hertz::new(effective_modulus(material, material), 0.0);
    let shear = effective_shear_modulus(material, material);
    let law = PairLaw {
        normal: AnyNormal::Hertz(normal),
        tangential: AnyTangential::Mindlin(Mindlin::new(shear, factor, 0.0, friction, friction)),
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    };
    let steps = 2000;
    let mass = density * volume(radius, 3);
    let step = normal.collision_time(mass, radius, speed) / steps as f64;
    let mut plan = plan(step, density, law);
    plan.walls.push(plane(DVec3::ZERO, DVec3::Y));
    let velocity = DVec3::new(psi * friction * speed / kappa, -speed, 0.0);
    let ball = sphere(DVec3::Y * radius, radius, velocity, DVec3::ZERO);
    let mut engine = start(plan.with_particles(vec![ball]));
    advance(&mut engine, steps + 2);
    let after = particle(&engine, 0);
    kappa * (after.velocity.x + after.angular_velocity.z * radius) / (friction * speed)
}
