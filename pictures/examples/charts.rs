//! Charts of every kind, to look at: `cargo run -p pictures --example charts -- FOLDER`.

use std::path::PathBuf;

use mercury_common::normal::{normal_cdf, normal_quantile};
use mercury_pictures::ColourMap;
use mercury_pictures::charts::{
    Axis, Chart, ChartPage, Dash, HeatMap, Hue, Legend, Marker, Place, Series, Shape,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = PathBuf::from(
        std::env::args()
            .nth(1)
            .unwrap_or_else(|| "out/charts".into()),
    );
    std::fs::create_dir_all(&folder)?;
    for (name, page) in [
        ("log-normal", log_normal()),
        ("rosin-rammler", rosin_rammler()),
        ("histogram", histogram()),
        ("profiles", profiles()),
        ("field", field()),
        ("convergence", convergence()),
        ("gaps", gaps()),
        ("many", many()),
    ] {
        let start = std::time::Instant::now();
        page.write(&folder.join(name))?;
        println!("{name}: {:.1} ms", 1e3 * start.elapsed().as_secs_f64());
    }
    Ok(())
}

/// Numbers between 0 and 1 that look random.
fn noise(number: usize) -> impl Fn(usize) -> f64 {
    move |i| (0.5 + 0.618_033_988_749_895 * (i % number) as f64).fract()
}

fn diameters() -> Vec<f64> {
    (0..=200)
        .map(|k| 2e-4 * 10f64.powf(f64::from(k) / 200.0 * 1.2 - 0.5))
        .collect()
}

fn sample(median: f64, spread: f64, number: usize) -> Vec<(f64, f64)> {
    let random = noise(number * 3 + 1);
    let mut sizes: Vec<f64> = (0..number)
        .map(|i| median * (spread * normal_quantile(random(i).clamp(1e-4, 1.0 - 1e-4))).exp())
        .collect();
    sizes.sort_by(f64::total_cmp);
    let share = |i: usize| (i as f64 + 0.5) / number as f64;
    sizes
        .into_iter()
        .enumerate()
        .map(|(i, size)| (size, share(i)))
        .collect()
}

fn log_normal() -> ChartPage {
    let (median, spread) = (2e-4_f64, 0.35);
    let share = |d: f64| normal_cdf((d / median).ln() / spread);
    let line = |shift: f64| -> Vec<(f64, f64)> {
        diameters()
            .into_iter()
            .map(|d| (d, (share(d) + shift).clamp(0.0, 1.0)))
            .collect()
    };
    let chart = |title: &str, y: Axis| {
        Chart::new(title, Axis::log("diameter", "m"), y)
            .with(Series::line("target", line(0.0)))
            .with(Series::band("95 % of samples", line(-0.04), line(0.04)))
            .with(Series::steps("sample of 200", sample(median, spread, 200)).dash(Dash::Solid))
            .with(Series::upright("", median))
    };
    let below = "share below, by number";
    let linear = chart("Linear", Axis::linear(below, "").within(0.0, 1.0));
    let straight = chart(
        "Normal quantiles",
        Axis::probability(below).within(0.001, 0.999),
    );
    ChartPage::new("Log-normal diameters", 2, vec![linear, straight])
}

fn rosin_rammler() -> ChartPage {
    let share = |d: f64| 1.0 - (-(d / 3e-4).powf(2.1)).exp();
    let target = diameters().into_iter().map(|d| (d, share(d))).collect();
    let sieves = [1.25e-4, 1.8e-4, 2.5e-4, 3.55e-4, 5e-4];
    let measured: Vec<(f64, f64)> = sieves.iter().map(|d| (*d, share(*d * 1.02))).collect();
    let errors = measured
        .iter()
        .map(|(_, p)| (0.0, 0.15 * p * (1.0 - p)))
        .collect();
    let chart = Chart::new(
        "Rosin-Rammler, d₆₃ = 300 µm, n = 2.1",
        Axis::log("diameter", "m"),
        Axis::rosin_rammler("share below, by volume"),
    )
    .with(Series::line("fit", target))
    .with(Series::points_with_errors("sieves", measured, errors).hue(Hue::Ink))
    .note("63.2 %", Place::At(1.2e-4, 0.632))
    .with(Series::level("", 0.632));
    ChartPage::of(chart)
}

fn histogram() -> ChartPage {
    let edges: Vec<f64> = (0..=20).map(|k| 1e-4 + 1.5e-5 * f64::from(k)).collect();
    let middle = |w: &[f64]| 0.5 * (w[0] + w[1]);
    let density = |d: f64| (-0.5 * ((d - 2.4e-4) / 5e-5).powi(2)).exp() / 5e-5 / 2.5066;
    let random = noise(97);
    let heights: Vec<f64> = (edges.windows(2).enumerate())
        .map(|(i, w)| density(middle(w)) * (0.85 + 0.3 * random(i)))
        .collect();
    let residuals: Vec<(f64, f64)> = (edges.windows(2).zip(&heights))
        .map(|(w, h)| (middle(w), (h - density(middle(w))) / density(2.4e-4)))
        .collect();
    let errors = residuals.iter().map(|_| (0.0, 0.05)).collect();
    let smooth: Vec<(f64, f64)> = (0..=200)
        .map(|k| 1e-4 + 1.5e-6 * f64::from(k))
        .map(|d| (d, density(d)))
        .collect();
    let ends = |axis: Axis| axis.within(9e-5, 4.1e-4);
    let upper = Chart::new(
        "",
        ends(Axis::linear("diameter", "m")),
        Axis::linear("density", "1/m"),
    )
    .with(Series::bars("sample", edges, heights))
    .with(Series::line("target", smooth));
    let lower = Chart::new(
        "",
        ends(Axis::linear("diameter", "m")),
        Axis::linear("residual", ""),
    )
    .with(Series::level("", 0.0))
    .with(Series::points_with_errors("", residuals, errors));
    let page = ChartPage::new("Diameters and what is left of them", 1, vec![upper, lower]);
    ChartPage {
        row_shares: vec![2.0, 1.0],
        subtitle: "250 particles, classes of 15 µm".into(),
        ..page
    }
    .size(620.0, 520.0)
}

fn profiles() -> ChartPage {
    let heights: Vec<f64> = (0..=40).map(|k| 2.5e-4 * f64::from(k)).collect();
    let speed = |z: f64| 0.3 * (1.0 - (1.0 - z / 1.05e-2).powf(1.5));
    let pick = |f: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> {
        heights.iter().map(|z| (f(*z), *z)).collect()
    };
    let fraction = |z: f64| 0.58 - 0.3 * (z / 1e-2).powi(12);
    let left = Chart::new(
        "Velocity",
        Axis::linear("velocity", "m/s"),
        Axis::linear("height", "m"),
    )
    .with(Series::line("mean", pick(&speed)))
    .with(Series::band(
        "two standard errors",
        pick(&|z| speed(z) - 0.012),
        pick(&|z| speed(z) + 0.012),
    ))
    .with(
        Series::line("Bagnold", pick(&|z| 1.02 * speed(z)))
            .hue(Hue::Grey)
            .dash(Dash::Dashed),
    );
    let points = pick(&fraction);
    let errors = points.iter().map(|_| (0.015, 0.0)).collect();
    let right = Chart::new(
        "Volume fraction",
        Axis::linear("volume fraction", ""),
        Axis::linear("height", "m"),
    )
    .with(Series::points_with_errors("fields", points, errors));
    ChartPage::new("Chute at 24°", 2, vec![left, right])
}

fn field() -> ChartPage {
    let edges = |number: u32| -> Vec<f64> { (0..=number).map(|k| f64::from(k) * 1e-3).collect() };
    let (columns, rows) = (60, 40);
    let value = |c: u32, r: u32| {
        let (x, y) = (f64::from(c) / 60.0 - 0.5, f64::from(r) / 40.0);
        if x * x + (y - 0.4).powi(2) < 0.01 {
            f64::NAN
        } else {
            2.3e3 * (1.0 - y) * (-4.0 * x * x).exp()
        }
    };
    let values = (0..rows)
        .flat_map(|r| (0..columns).map(move |c| value(c, r)))
        .collect();
    let heat = HeatMap {
        x_edges: edges(columns),
        y_edges: edges(rows),
        values,
        name: "pressure".into(),
        unit: "Pa".into(),
        map: ColourMap::Viridis,
        range: None,
        centred: false,
    };
    let chart = Chart::new(
        "Pressure around an intruder",
        Axis::linear("x", "m"),
        Axis::linear("z", "m"),
    );
    ChartPage::of(chart.with(Series::heat(heat)))
}

fn convergence() -> ChartPage {
    let steps: Vec<f64> = (0..8).map(|k| 1.6e-4 / f64::from(1 << k)).collect();
    let of = |factor: f64, power: i32| -> Vec<(f64, f64)> {
        steps.iter().map(|s| (*s, factor * s.powi(power))).collect()
    };
    let chart = Chart::new(
        "Errors over the time step",
        Axis::log("time step", "s"),
        Axis::log("error", ""),
    )
    .with(Series::marked_line("collision", of(2e5, 2)))
    .with(Series::marked_line("oscillation", of(3e4, 2)))
    .with(
        Series::line("slope 2", of(6e4, 2))
            .hue(Hue::Grey)
            .dash(Dash::Dashed),
    );
    ChartPage::of(chart)
}

fn gaps() -> ChartPage {
    let wave = (0..100).map(|k| {
        let t = f64::from(k) * 2e-3;
        (
            t,
            if (40..45).contains(&k) {
                f64::NAN
            } else {
                (60.0 * t).sin() * 4e7
            },
        )
    });
    let broken = Chart::new(
        "A line with a gap",
        Axis::linear("time", "s"),
        Axis::linear("number density", "1/m³"),
    )
    .with(Series::line("wave", wave.collect()));
    let empty = Chart::new(
        "Nothing",
        Axis::linear("time", "s"),
        Axis::log("energy", "J"),
    )
    .with(Series::line("never", vec![(0.0, 0.0), (1.0, f64::NAN)]));
    ChartPage::new("Values that are missing", 2, vec![broken, empty])
}

fn many() -> ChartPage {
    let wave = |k: u32| -> Vec<(f64, f64)> {
        (0..=100)
            .map(|i| f64::from(i) * 0.01)
            .map(|x| (x, (6.0 * x + 0.5 * f64::from(k)).sin() + 0.2 * f64::from(k)))
            .collect()
    };
    let lines = (0..7).fold(
        Chart::new(
            "The cycle of lines",
            Axis::linear("x", ""),
            Axis::linear("y", ""),
        ),
        |chart, k| {
            chart.with(Series::line(&format!("line {}", k + 1), wave(k)).about("as it comes"))
        },
    );
    let marks = (0..7).fold(
        Chart::new(
            "The cycle of markers",
            Axis::linear("x", ""),
            Axis::linear("y", ""),
        )
        .legend(Legend::Right),
        |chart, k| {
            let few = wave(k).into_iter().step_by(10).collect();
            chart.with(Series::new(
                &format!("points {}", k + 1),
                Shape::MarkedLine(few),
            ))
        },
    );
    let odd = Series::points("chosen", vec![(0.5, -0.7)])
        .hue(Hue::Ink)
        .marker(Marker::Cross);
    ChartPage::new("", 1, vec![lines, marks.with(odd)])
}
