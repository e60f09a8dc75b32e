//! Writes `docs/wet-grains.md` and its pictures from real runs: the slope of a pile over the surface tension, and how evenly a spray wets the grains of a
//! drum. Takes some minutes.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Result, anyhow};
use mercury_engine::step::{Engine, StartOptions};
use mercury_pictures::charts::{Axis, Chart, ChartPage, Series};
use mercury_solver::plan::{plan, read_scene};

const TENSIONS: [f64; 4] = [0.0, 0.02, 0.04, 0.07];
const SEEDS: [u64; 2] = [11, 12];
/// m3/s
const FLOWS: [f64; 3] = [2.5e-7, 1e-6, 4e-6];

fn main() -> Result<()> {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
    let pictures = docs.join("pictures");
    let mut text = String::from(
        "# Wet grains: slopes and mixing\n\n\
         This page is written by `cargo run --release -p tests --bin wet-grains` from real runs; do not edit it.\n\n",
    );
    text += &piles(&pictures.join("wet-piles-slope.svg"))?;
    text += &drum(
        &pictures.join("wet-drum-evenness.svg"),
        &pictures.join("wet-drum-front.svg"),
    )?;
    std::fs::write(docs.join("wet-grains.md"), text)?;
    Ok(())
}

fn started(scene: &str, changes: &[String]) -> Result<Engine> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../scenes")
        .join(scene);
    let scene = read_scene(&path, changes).map_err(|errors| anyhow!("{errors}"))?;
    let plan = plan(&scene).map_err(|errors| anyhow!("{errors}"))?;
    Ok(Engine::start(Arc::new(plan), StartOptions::threads(2))?)
}

fn run_until(engine: &mut Engine, time: f64) -> Result<()> {
    let steps = (time / engine.physics().time_step).round() as u64;
    engine.steps_at_once(steps.saturating_sub(engine.steps()), None)?;
    Ok(())
}

/// Mean and standard deviation.
fn spread(numbers: &[f64]) -> (f64, f64) {
    let count = numbers.len() as f64;
    let mean = numbers.iter().sum::<f64>() / count;
    let squares = numbers.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>();
    (mean, (squares / (count - 1.0).max(1.0)).sqrt())
}

/// Slope of both piles of `wet-piles.toml`, both wet, over the surface tension.
fn piles(picture: &Path) -> Result<String> {
    let mut text = String::from(
        "## Slope of a pile\n\n\
         Both piles of [wet-piles](../scenes/wet-piles.toml) wet, four piles for each surface tension. The slope is that of a line through the highest grains of columns of\n\
         one diameter, from the middle of the pile to its foot.\n\n\
         | surface tension (N/m) | Bond number: bridge over weight | slope (degrees), mean and scatter of four piles |\n|---|---|---|\n",
    );
    let (mut points, mut bars) = (Vec::new(), Vec::new());
    for tension in TENSIONS {
        let mut slopes = Vec::new();
        for seed in SEEDS {
            let changes = [
                format!("seed={seed}"),
                format!("materials.wet.liquid.surface_tension={tension}"),
                "insertions.dry.material=wet".to_owned(),
                "insertions.dry.film_volume=1e-9".to_owned(),
            ];
            let mut engine = started("wet-piles.toml", &changes)?;
            run_until(&mut engine, 1.4)?;
            slopes.extend([-0.08, 0.08].map(|middle| slope(&engine, middle)));
        }
        let (mean, scatter) = spread(&slopes);
        // 2 pi R gamma between two of 2.5 mm over the weight of one.
        let radius: f64 = 2.5e-3;
        let weight = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * radius * radius * radius * 9.81;
        let bond = 2.0 * std::f64::consts::PI * radius * tension / weight;
        writeln!(text, "| {tension} | {bond:.2} | {mean:.1} ± {scatter:.1} |")?;
        points.push((tension, mean));
        bars.push((0.0, scatter));
    }
    let chart = Chart::new(
        "Slope of a pile of wet grains",
        Axis::linear("surface tension", "N/m"),
        Axis::linear("slope", "degrees"),
    )
    .with(Series::points_with_errors(
        "mean and scatter of four piles",
        points,
        bars,
    ));
    ChartPage::of(chart).write_svg(picture)?;
    text += "\n![Slope of a pile over the surface tension](pictures/wet-piles-slope.svg)\n\n";
    Ok(text)
}

/// Slope of a pile about x = `middle` (m), degrees.
fn slope(engine: &Engine, middle: f64) -> f64 {
    let width = 5e-3;
    let mut tops = [0.0f64; 14];
    for record in &engine.particles.records {
        let column = ((record.position.x - middle).abs() / width) as usize;
        if let Some(top) = tops.get_mut(column)
            && (record.position.x * middle) > 0.0
        {
            *top = top.max(record.position.z + record.radius);
        }
    }
    // From the second column to the last that is more than two grains high.
    let last = tops
        .iter()
        .position(|top| *top < 2.0 * width)
        .unwrap_or(tops.len());
    let used: Vec<(f64, f64)> = (tops.iter().enumerate().take(last).skip(1))
        .map(|(k, top)| ((k as f64 + 0.5) * width, *top))
        .collect();
    let count = used.len() as f64;
    let (x, z) = (
        used.iter().map(|p| p.0).sum::<f64>() / count,
        used.iter().map(|p| p.1).sum::<f64>() / count,
    );
    let (mut xx, mut xz) = (0.0, 0.0);
    for (px, pz) in used {
        xx += (px - x) * (px - x);
        xz += (px - x) * (pz - z);
    }
    (-xz / xx).atan().to_degrees()
}

/// How evenly `spray-drum.toml` wets its grains, and how fast, for some flow rates.
fn drum(evenness: &Path, front: &Path) -> Result<String> {
    let mut text = String::from(
        "## Mixing in a drum\n\n\
         The scene [spray-drum](../scenes/spray-drum.toml) with three flow rates. Wetness of a grain: its film, half of its bridges with grains and its bridges at walls.\n\n\
         | flow rate (m3/s) | grains that hold liquid at t = 1.3 s | at 2.8 s | coefficient of variation of wetness at 1.3 s | at 2.8 s |\n|---|---|---|---|---|\n",
    );
    let mut of_evenness = Chart::new(
        "Wetness of the grains of a sprayed drum: coefficient of variation",
        Axis::linear("time", "s"),
        Axis::log("standard deviation over mean", ""),
    );
    let mut of_front = Chart::new(
        "Grains of a sprayed drum that hold liquid",
        Axis::linear("time", "s"),
        Axis::linear("share", ""),
    );
    for flow in FLOWS {
        let mut engine = started(
            "spray-drum.toml",
            &[format!("sprays.nozzle.flow_rate={flow}")],
        )?;
        let (mut variation, mut share) = (Vec::new(), Vec::new());
        let mut row = Vec::new();
        for k in 0..=20 {
            let time = 0.8 + 0.1 * f64::from(k);
            run_until(&mut engine, time)?;
            let held = engine.liquid_volumes().unwrap_or_default();
            let wet = held.iter().filter(|volume| **volume > 0.0).count() as f64;
            share.push((time, wet / held.len() as f64));
            let (mean, scatter) = spread(&held);
            if mean > 0.0 {
                variation.push((time, scatter / mean));
            }
            if k == 5 || k == 20 {
                row.push((wet / held.len() as f64, scatter / mean));
            }
        }
        writeln!(
            text,
            "| {flow:e} | {:.2} | {:.2} | {:.2} | {:.2} |",
            row[0].0, row[1].0, row[0].1, row[1].1
        )?;
        let name = format!("{flow:e} m3/s");
        of_evenness = of_evenness.with(Series::marked_line(&name, variation));
        of_front = of_front.with(Series::marked_line(&name, share));
    }
    ChartPage::of(of_evenness).write_svg(evenness)?;
    ChartPage::of(of_front).write_svg(front)?;
    text += "\n![Coefficient of variation of wetness over time](pictures/wet-drum-evenness.svg)\n\n![Share of grains that hold liquid over time](pictures/wet-drum-front.svg)\n";
    Ok(text)
}
