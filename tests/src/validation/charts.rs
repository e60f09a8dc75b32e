//! Pictures of results that a table does not show well.

use std::path::Path;

use anyhow::{Result, anyhow};
use glam::DVec3;
use mercury_solver::contact::normal::{effective_modulus, effective_shear_modulus};
use mercury_solver::contact::{
    AnyNormal, AnyRolling, AnyTangential, Hertz, Linear, Mindlin, PairLaw,
};
use mercury_solver::state::volume;
use plotters::prelude::*;
use plotters::style::register_font;

use super::Results;
use crate::scene_checks::{hertz_wall_rebound, two_spheres_collide};
use crate::scenes::{advance, frictionless, particle, plan, plane, sphere, start};

const FONT: &[u8] = include_bytes!("../../../pictures/assets/DejaVuSans-subset.ttf");
/// Colours that colour-blind readers tell apart (Okabe & Ito 2008).
pub(crate) const BLUE: RGBColor = RGBColor(0, 114, 178);
pub(crate) const ORANGE: RGBColor = RGBColor(213, 94, 0);
pub(crate) const GREEN: RGBColor = RGBColor(0, 158, 115);
pub(crate) const PINK: RGBColor = RGBColor(204, 121, 167);

/// One curve of a chart: its legend, colour and points; with or without a line through the points.
pub(crate) struct Curve {
    pub(crate) name: &'static str,
    pub(crate) colour: RGBColor,
    pub(crate) points: Vec<(f64, f64)>,
    pub(crate) line: bool,
    pub(crate) dots: bool,
}

/// Lets charts use the embedded font.
pub(crate) fn load_font() -> Result<()> {
    register_font("sans-serif", FontStyle::Normal, FONT)
        .map_err(|_| anyhow!("the embedded font cannot be read"))
}

/// Draws all charts into a folder.
///
/// # Errors
/// If a file cannot be written.
pub fn draw(results: &Results, folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder)?;
    load_font()?;
    hertz_phase(&folder.join("hertz-phase.svg"))?;
    convergence(&folder.join("convergence.svg"))?;
    oblique_impact(results, &folder.join("oblique-impact.svg"))
}

/// Restitution of hertz-wall.toml over the phase of the first touch for three time steps.
fn hertz_phase(path: &Path) -> Result<()> {
    let curve = |name, colour, step: f64| Curve {
        name,
        colour,
        points: (0..=64)
            .map(|k| f64::from(k) / 64.0)
            .map(|phase| (phase, hertz_wall_rebound(step, phase)))
            .collect(),
        line: true,
        dots: false,
    };
    let curves = [
        curve("dt = 0.5 µs", ORANGE, 5e-7),
        curve("dt = 0.25 µs", GREEN, 2.5e-7),
        curve("dt = 0.125 µs", BLUE, 1.25e-7),
    ];
    chart(
        path,
        "Hertz impact: restitution over the phase of the first touch (0.4 asked for)",
        ("first touch within the step", "restitution"),
        &curves,
        false,
        SeriesLabelPosition::UpperMiddle,
    )
}

/// Errors over the time step, both axes logarithmic (base 10).
fn convergence(path: &Path) -> Result<()> {
    let steps: Vec<f64> = (0..8).map(|k| 1.6e-4 / f64::from(1 << k)).collect();
    let curve = |name, colour, error: fn(f64) -> f64| Curve {
        name,
        colour,
        points: steps.iter().map(|&step| (step, error(step))).collect(),
        line: true,
        dots: true,
    };
    let curves = [
        curve(
            "collision: restitution of two-spheres.toml",
            ORANGE,
            |step| (two_spheres_collide(step).0 - 0.7).abs(),
        ),
        curve(
            "oscillation: place after 0.02 s, over the amplitude",
            BLUE,
            oscillation_error,
        ),
        Curve {
            name: "slope 2",
            colour: RGBColor(120, 120, 120),
            points: steps.iter().map(|&s| (s, 3e4 * s * s)).collect(),
            line: true,
            dots: false,
        },
    ];
    chart(
        path,
        "Errors over the time step",
        ("time step (s)", "error"),
        &curves,
        true,
        SeriesLabelPosition::LowerRight,
    )
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
    let mut curves = Vec::new();
    for (variant, factor, ours, colour) in [
        (
            "factor 2/3",
            2.0 / 3.0,
            "stiffness factor 2/3: solver",
            ORANGE,
        ),
        ("factor 1", 1.0, "stiffness factor 1: solver", BLUE),
    ] {
        let rows = rows(variant);
        anyhow::ensure!(!rows.is_empty(), "no rows of the oblique impact, {variant}");
        curves.push(Curve {
            name: ours,
            colour,
            points: (0..=110)
                .map(|k| 0.5 + 0.05 * f64::from(k))
                .map(|psi| (psi, rebound(psi, factor)))
                .collect(),
            line: true,
            dots: false,
        });
        curves.push(Curve {
            name: "expected",
            colour,
            points: rows,
            line: false,
            dots: true,
        });
    }
    chart(
        path,
        "Oblique elastic impact on a wall, Hertz-Mindlin, ν = 0.3",
        (
            "tangential over normal velocity before, κ u / (μ v)",
            "tangential velocity after, κ u / (μ v)",
        ),
        &curves,
        false,
        SeriesLabelPosition::UpperMiddle,
    )
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

/// One chart; `logarithmic` takes decimal logarithms along both axes.
pub(crate) fn chart(
    path: &Path,
    title: &str,
    (x_label, y_label): (&str, &str),
    curves: &[Curve],
    logarithmic: bool,
    legend: SeriesLabelPosition,
) -> Result<()> {
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let range = |pick: fn(&(f64, f64)) -> f64| {
        let values = points().map(pick).filter(|v| !logarithmic || *v > 0.0);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        if logarithmic {
            (low / 1.3, high * 1.3)
        } else {
            let room = 0.04 * (high - low);
            (low - room, high + room)
        }
    };
    let ((x0, x1), (y0, y1)) = (range(|point| point.0), range(|point| point.1));
    let failed = |error: DrawingAreaErrorKind<std::io::Error>| anyhow!("{error}");
    let area = SVGBackend::new(path, (760, 460)).into_drawing_area();
    area.fill(&WHITE).map_err(failed)?;
    let mut builder = ChartBuilder::on(&area);
    builder
        .caption(title, ("sans-serif", 17))
        .margin(12)
        .x_label_area_size(48)
        .y_label_area_size(78);
    /// Fills a chart of either kind of axis.
    macro_rules! fill {
        ($chart:expr, $format:expr) => {{
            let mut chart = $chart.map_err(failed)?;
            chart
                .configure_mesh()
                .x_desc(x_label)
                .y_desc(y_label)
                .x_label_formatter(&$format)
                .y_label_formatter(&$format)
                .label_style(("sans-serif", 13))
                .axis_desc_style(("sans-serif", 14))
                .light_line_style(WHITE)
                .draw()
                .map_err(failed)?;
            for curve in curves {
                let style = curve.colour.stroke_width(2);
                let colour = curve.colour;
                if curve.line {
                    chart
                        .draw_series(LineSeries::new(curve.points.iter().copied(), style))
                        .map_err(failed)?
                        .label(curve.name)
                        .legend(move |(x, y)| PathElement::new([(x, y), (x + 22, y)], style));
                }
                if curve.dots {
                    let dots = curve
                        .points
                        .iter()
                        .map(|&p| Circle::new(p, 4, colour.filled()));
                    let drawn = chart.draw_series(dots).map_err(failed)?;
                    if !curve.line {
                        drawn
                            .label(curve.name)
                            .legend(move |(x, y)| Circle::new((x + 11, y), 4, colour.filled()));
                    }
                }
            }
            chart
                .configure_series_labels()
                .position(legend.clone())
                .background_style(WHITE.mix(0.85))
                .border_style(RGBColor(200, 200, 200))
                .label_font(("sans-serif", 13))
                .draw()
                .map_err(failed)?;
        }};
    }
    if logarithmic {
        let axes = builder.build_cartesian_2d((x0..x1).log_scale(), (y0..y1).log_scale());
        fill!(axes, |value: &f64| format!("{value:.0e}"));
    } else {
        fill!(builder.build_cartesian_2d(x0..x1, y0..y1), |value: &f64| {
            let text = format!("{value:.4}");
            let text = text.trim_end_matches('0').trim_end_matches('.');
            (if text == "-0" { "0" } else { text }).to_owned()
        });
    }
    area.present().map_err(failed)
}
