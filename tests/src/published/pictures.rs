//! The published curves, and ours.

use std::path::Path;

use anyhow::Result;
use mercury_pictures::charts::{Axis, Chart, ChartPage, Dash, Hue, Legend, Marker, Series};

use super::Published;
use super::chung_ooi::{FACTORS, FILES_4, FILES_5, points_6, seen_4, seen_5, seen_6};
use super::mfix::{Fall, NAMES, SWEEP, fall_tables, seen_in_impact};

const HUES: [Hue; 2] = [Hue::Blue, Hue::Vermillion];

fn theirs(name: &str, points: Vec<(f64, f64)>, marker: Marker) -> Series {
    Series::points(name, points).hue(Hue::Ink).marker(marker)
}

/// Our lines for the two factors on Mindlin's stiffness.
fn ours(chart: Chart, at: &[f64], see: impl Fn(f64, f64) -> f64) -> Chart {
    let mut chart = chart;
    for ((name, factor), hue) in FACTORS.into_iter().zip(HUES) {
        let points = at.iter().map(|&x| (x, see(x, factor))).collect();
        chart = chart.with(Series::line(&format!("Mercury, {name}"), points).hue(hue));
    }
    chart
}

/// Tests 4 to 6 and 8 of Chung & Ooi.
pub(super) fn chung_ooi(published: &Published, folder: &Path) -> Result<()> {
    let angles: Vec<f64> = (1..=60).map(|k| 1.42 * f64::from(k)).collect();
    let mut charts = Vec::new();
    for (k, (title, name, unit)) in [
        (
            "Test 4: tangential restitution",
            "v_t after over before",
            "",
        ),
        ("Test 4: spin", "spin after", "rad/s"),
        (
            "Test 4: rebound of the contact point",
            "angle after (°)",
            "",
        ),
    ]
    .into_iter()
    .enumerate()
    {
        let axis = Axis::linear("angle from the normal (°)", "");
        let chart = Chart::new(title, axis, Axis::linear(name, unit));
        // The first chart has the legend for the three of them.
        let legend = if k == 0 { Legend::Auto } else { Legend::None };
        let chart = chart.legend(legend);
        let chart = ours(chart, &angles, |angle, factor| seen_4(angle, factor)[k]);
        charts.push(
            chart
                .with(theirs(
                    "Chung & Ooi",
                    published.curve(FILES_4[k], "al_oxide")?,
                    Marker::Ring,
                ))
                .with(theirs(
                    "measured",
                    published.curve(FILES_4[k], "experiment")?,
                    Marker::Cross,
                )),
        );
    }
    let psi: Vec<f64> = (1..=70).map(|k| 0.2 * f64::from(k)).collect();
    for (k, (title, name)) in [
        ("Test 5: slip", "slip after over μ v_n"),
        ("Test 5: spin", "R spin after over μ v_n"),
    ]
    .into_iter()
    .enumerate()
    {
        let axis = Axis::linear("v_t over μ v_n", "");
        let chart = Chart::new(title, axis, Axis::linear(name, ""));
        let chart = ours(chart, &psi, |psi, factor| seen_5(psi, factor)[k]);
        let mut curve = published.curve(FILES_5[k], "steel")?;
        curve.retain(|&(psi, _)| psi < 14.1);
        charts.push(chart.with(theirs("Chung & Ooi", curve, Marker::Ring)));
    }
    let tangents: Vec<f64> = (1..=60).map(|k| 0.1 * f64::from(k)).collect();
    let [_, wall] = points_6(published, false)?;
    let [_, heavy] = points_6(published, true)?;
    let axis = Axis::linear("R spin over v_n", "");
    let chart = Chart::new(
        "Tests 6 and 8: slip over normal velocity after",
        axis,
        Axis::linear("slip over v_n after", ""),
    );
    let chart = ours(chart, &tangents, |tangent, factor| {
        seen_6(tangent, factor, false)[1]
    });
    let below = |mut points: Vec<(f64, f64)>| {
        points.retain(|&(x, _)| x < 6.05);
        points
    };
    charts.push(
        chart
            .with(theirs("Chung & Ooi, 6", below(wall), Marker::Ring))
            .with(theirs("Chung & Ooi, 8", below(heavy), Marker::Cross)),
    );
    let page = ChartPage::new("", 2, charts).size(900.0, 1050.0);
    Ok(page.write_svg(&folder.join("chung-ooi.svg"))?)
}

/// DEM01, DEM02 and DEM05.
pub(super) fn mfix(published: &Published, folder: &Path) -> Result<()> {
    let mut charts = Vec::new();
    let mut fall = Chart::new(
        "DEM01: fall and rebound, k = 10 kN/m",
        Axis::linear("time", "s"),
        Axis::linear("height of the centre", "m"),
    );
    for (table, hue) in fall_tables(published, 0)?
        .into_iter()
        .filter(|table| table.stiffness == 1e4)
        .filter(|table| [0.9, 0.6].contains(&table.restitution))
        .zip(HUES)
    {
        let times: Vec<f64> = (0..=200).map(|k| 0.0025 * f64::from(k)).collect();
        let run = Fall {
            stiffness: table.stiffness,
            restitution: table.restitution,
        };
        let line = times
            .iter()
            .zip(run.heights(&times))
            .map(|(&t, seen)| (t, seen[0]))
            .collect();
        let points = table.rows.iter().step_by(4).map(|row| (row[0], row[2]));
        fall = fall
            .with(Series::line(&format!("Mercury, e = {}", table.restitution), line).hue(hue))
            .with(theirs("closed form", points.collect(), Marker::Ring));
    }
    charts.push(fall);
    let mut bounces = Chart::new(
        "DEM02: heights of the bounces, e = 0.9",
        Axis::linear("bounce", ""),
        Axis::linear("height of the centre", "m"),
    );
    let numbered =
        |heights: Vec<f64>| -> Vec<(f64, f64)> { (1..).map(f64::from).zip(heights).collect() };
    for (stiffness, hue) in SWEEP
        .into_iter()
        .zip([Hue::Blue, Hue::Vermillion, Hue::Green])
    {
        let fall = Fall {
            stiffness,
            restitution: 0.9,
        };
        let name = format!("Mercury, k = {stiffness:e} N/m");
        bounces = bounces.with(Series::marked_line(&name, numbered(fall.bounces(15))).hue(hue));
    }
    let stiff = (1..=15).map(|k| 0.1 + 0.4 * 0.81f64.powi(k)).collect();
    charts.push(
        bounces.with(
            Series::line("r + (h - r) e^(2k)", numbered(stiff))
                .hue(Hue::Ink)
                .dash(Dash::Dashed),
        ),
    );
    let angles: Vec<f64> = (1..=65).map(f64::from).collect();
    for (k, (title, unit)) in [
        ("DEM05: v_t after over before, on a wall", ""),
        ("DEM05: spin after, on a wall", "rad/s"),
    ]
    .into_iter()
    .enumerate()
    {
        let axis = Axis::linear("angle from the normal (°)", "");
        let chart = Chart::new(title, axis, Axis::linear("", unit));
        let chart = ours(chart, &angles, |angle, factor| {
            seen_in_impact(angle, factor, false)[k]
        });
        let rows = published.points("mfix/DEM05.json", &["hertz", NAMES[k]])?;
        let points = rows.iter().map(|row| (row[0], row[2])).collect();
        charts.push(chart.with(theirs("MFiX, Hertz", points, Marker::Ring)));
    }
    let page = ChartPage::new("", 2, charts).size(900.0, 720.0);
    Ok(page.write_svg(&folder.join("mfix.svg"))?)
}
