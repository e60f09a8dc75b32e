//! Pebbles and run time against error, for the generators and several bodies.
//!
//! ```text
//! cargo run --release -p mclump --example work_precision -- docs/pictures docs/theory
//! ```
//!
//! writes `work-precision.svg` into the first folder and `pebble-generators.csv` into the second. A third argument names a folder
//! with MercuryDPM's rattleback (`mesh/Rattleback.stl`, `pebbles/rattleback_500_input.csv`), which is then added with its
//! shipped clump.

use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

use glam::DVec3;
use mclump::fidelity::{Fidelity, compare};
use mclump::generate::{Euclidean, Favier, Method, Request, Stop, Tangent, generate};
use mercury_common::formats::clump::Pebble;
use mercury_common::formats::mesh::{TriangleMesh, read_mesh};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::register_font;

const FONT: &[u8] = include_bytes!("../../pictures/assets/DejaVuSans-subset.ttf");
const NUMBERS: [usize; 9] = [1, 2, 5, 10, 20, 50, 100, 200, 500];

type Failure = Box<dyn Error>;

/// A clump of a body by a method.
struct Row {
    body: &'static str,
    method: &'static str,
    seconds: Option<f64>,
    fidelity: Fidelity,
}

impl Row {
    /// Largest relative error of a principal moment.
    fn moment_error(&self) -> f64 {
        let errors = self.fidelity.moment_errors;
        errors
            .iter()
            .fold(0.0, |worst, error| error.abs().max(worst))
    }

    fn relative(&self, length: f64) -> f64 {
        length / self.fidelity.equal_volume_diameter
    }
}

/// What is drawn of a row: name, colour and value.
type Quantity = (&'static str, fn(&Row) -> Option<f64>);

const QUANTITIES: [Quantity; 4] = [
    ("volume error", |row| Some(row.fidelity.volume_error.abs())),
    ("mean surface distance / d", |row| {
        Some(row.relative(row.fidelity.mean_distance))
    }),
    ("largest moment error", |row| Some(row.moment_error())),
    ("run time (s)", |row| row.seconds),
];

/// Colours that colour-blind readers tell apart (Okabe and Ito 2008).
const METHODS: [(&str, RGBColor); 5] = [
    ("Euclidean", RGBColor(213, 94, 0)),
    ("tangent", RGBColor(0, 114, 178)),
    ("Favier", RGBColor(0, 158, 115)),
    ("tangent, 0.15 mm out", RGBColor(204, 121, 167)),
    ("shipped, 0.44 mm out", RGBColor(0, 0, 0)),
];

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [pictures, tables, rest @ ..] = arguments.as_slice() else {
        return Err("give the folders of picture and table".into());
    };
    let mut rows = Vec::new();
    for (body, mesh) in [
        ("cube", cube()),
        ("ellipsoid 2:1:1", ellipsoid()),
        ("torus 4:1", torus(2.0, 0.5, 80, 40)),
    ] {
        methods(body, &mesh, &mut rows)?;
    }
    if let [folder, ..] = rest {
        rattleback(Path::new(folder), &mut rows)?;
    }
    let mut table = String::from(
        "body,method,pebbles,run_time_s,volume_error,mean_distance_over_d,largest_distance_over_d,largest_moment_error,protrusion_over_d\n",
    );
    for row in &rows {
        let f = &row.fidelity;
        writeln!(
            table,
            "{},{},{},{},{:.6},{:.6},{:.6},{:.6},{:.3e}",
            row.body,
            row.method.replace(',', ""),
            f.pebbles,
            row.seconds.map_or(String::new(), |s| format!("{s:.4}")),
            f.volume_error,
            row.relative(f.mean_distance),
            row.relative(f.largest_distance),
            row.moment_error(),
            row.relative(f.protrusion),
        )?;
    }
    std::fs::write(Path::new(tables).join("pebble-generators.csv"), table)?;
    draw(&rows, &Path::new(pictures).join("work-precision.svg"))?;
    speed()
}

/// The promise about large meshes: 200 balls in a mesh of 1e5 triangles.
fn speed() -> Result<(), Failure> {
    let mesh = torus(2.0, 0.7, 320, 160);
    for (name, method) in [
        ("Euclidean", Method::Euclidean(Euclidean::default())),
        ("tangent", Method::Tangent(Tangent::default())),
    ] {
        let start = Instant::now();
        let found = made(&mesh, &request(method, 200))?;
        println!(
            "{name}: {} balls in {} triangles in {:.2} s",
            found.len(),
            mesh.triangles.len(),
            start.elapsed().as_secs_f64()
        );
    }
    Ok(())
}

fn request(method: Method, n: usize) -> Request {
    Request {
        method,
        stop: Stop {
            pebbles: Some(n),
            volume_error: None,
        },
        ..Request::default()
    }
}

fn made(mesh: &TriangleMesh, request: &Request) -> Result<Vec<Pebble>, Failure> {
    Ok(generate(mesh, request, &mut |_, _| {})?)
}

/// All methods for a body; Favier's where the axis stays inside.
fn methods(body: &'static str, mesh: &TriangleMesh, rows: &mut Vec<Row>) -> Result<(), Failure> {
    for (name, method) in [
        ("Euclidean", Method::Euclidean(Euclidean::default())),
        ("tangent", Method::Tangent(Tangent::default())),
        ("Favier", Method::Favier(Favier::default())),
    ] {
        for n in NUMBERS {
            let start = Instant::now();
            let Ok(found) = made(mesh, &request(method.clone(), n)) else {
                break;
            };
            let seconds = start.elapsed().as_secs_f64();
            push(rows, body, name, Some(seconds), mesh, &found)?;
        }
    }
    Ok(())
}

fn push(
    rows: &mut Vec<Row>,
    body: &'static str,
    method: &'static str,
    seconds: Option<f64>,
    mesh: &TriangleMesh,
    pebbles: &[Pebble],
) -> Result<(), Failure> {
    let fidelity = compare(mesh, pebbles)?;
    println!(
        "{body}, {method}, {}: volume {:+.4}, {:.3} s",
        fidelity.pebbles,
        fidelity.volume_error,
        seconds.unwrap_or(0.0)
    );
    rows.push(Row {
        body,
        method,
        seconds,
        fidelity,
    });
    Ok(())
}

/// MercuryDPM's celt, also with pebbles that stand out, and the clump that it ships. Lengths in mm.
fn rattleback(folder: &Path, rows: &mut Vec<Row>) -> Result<(), Failure> {
    let body = "rattleback";
    let mesh = read_mesh(folder.join("mesh/Rattleback.stl"))?;
    methods(body, &mesh, rows)?;
    for n in NUMBERS {
        let start = Instant::now();
        let out = Request {
            protrusion: 0.15,
            ..request(Method::default(), n)
        };
        let found = made(&mesh, &out)?;
        let seconds = start.elapsed().as_secs_f64();
        push(rows, body, METHODS[3].0, Some(seconds), &mesh, &found)?;
    }
    let text = std::fs::read_to_string(folder.join("pebbles/rattleback_500_input.csv"))?;
    let mut shipped = Vec::new();
    for line in text.lines() {
        let numbers: Vec<f64> = line
            .split(',')
            .map_while(|cell| cell.trim().parse().ok())
            .collect();
        if let &[x, y, z, radius] = numbers.as_slice() {
            let position = DVec3::new(x, y, z);
            shipped.push(Pebble { position, radius });
        }
    }
    push(rows, body, METHODS[4].0, None, &mesh, &shipped)
}

/// A row of charts per body, a column per quantity, both axes logarithmic.
fn draw(rows: &[Row], path: &Path) -> Result<(), Failure> {
    register_font("sans-serif", FontStyle::Normal, FONT).map_err(|_| "the font cannot be read")?;
    let mut bodies: Vec<&str> = rows.iter().map(|row| row.body).collect();
    bodies.dedup();
    let height = 40 + 230 * bodies.len() as u32;
    let area = SVGBackend::new(path, (1160, height)).into_drawing_area();
    area.fill(&WHITE)?;
    let (legend, charts) = area.split_vertically(40);
    for (k, (name, colour)) in METHODS.iter().enumerate() {
        let x = 70 + 215 * k as i32;
        legend.draw(&Circle::new((x, 22), 4, colour.filled()))?;
        legend.draw(&Text::new(*name, (x + 10, 15), ("sans-serif", 14)))?;
    }
    for (k, panel) in charts
        .split_evenly((bodies.len(), QUANTITIES.len()))
        .iter()
        .enumerate()
    {
        let body = bodies[k / QUANTITIES.len()];
        let (name, quantity) = QUANTITIES[k % QUANTITIES.len()];
        let of_body: Vec<&Row> = rows.iter().filter(|row| row.body == body).collect();
        chart(panel, &format!("{body}: {name}"), &of_body, quantity)?;
    }
    area.present()?;
    Ok(())
}

fn chart(
    panel: &DrawingArea<SVGBackend<'_>, Shift>,
    title: &str,
    rows: &[&Row],
    quantity: fn(&Row) -> Option<f64>,
) -> Result<(), Failure> {
    let values = || {
        rows.iter()
            .filter_map(|row| quantity(row))
            .filter(|v| *v > 0.0)
    };
    let low = values().fold(f64::INFINITY, f64::min);
    let high = values().fold(0.0, f64::max);
    let mut chart = ChartBuilder::on(panel)
        .caption(title, ("sans-serif", 13))
        .margin(6)
        .x_label_area_size(26)
        .y_label_area_size(46)
        .build_cartesian_2d(
            (0.8..700f64).log_scale(),
            (low / 1.4..high * 1.4).log_scale(),
        )?;
    chart
        .configure_mesh()
        .x_labels(4)
        .y_labels(5)
        .x_desc("pebbles")
        .x_label_formatter(&|v| format!("{v:.0}"))
        .y_label_formatter(&|v| format!("{v:.0e}"))
        .label_style(("sans-serif", 11))
        .axis_desc_style(("sans-serif", 11))
        .light_line_style(WHITE)
        .draw()?;
    for (method, colour) in METHODS {
        let points: Vec<(f64, f64)> = rows
            .iter()
            .filter(|row| row.method == method)
            .filter_map(|row| Some((row.fidelity.pebbles as f64, quantity(row)?)))
            .filter(|point| point.1 > 0.0)
            .collect();
        chart.draw_series(LineSeries::new(points.clone(), colour.stroke_width(2)))?;
        chart.draw_series(points.iter().map(|&p| Circle::new(p, 3, colour.filled())))?;
    }
    Ok(())
}

fn cube() -> TriangleMesh {
    let vertices = (0..8)
        .map(|k| DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2)))
        .collect();
    let quads = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let triangles = quads
        .into_iter()
        .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect();
    TriangleMesh {
        vertices,
        triangles,
        welded: 0,
    }
}

/// Rings of corners on the exact surface with half axes 2, 1, 1.
fn ellipsoid() -> TriangleMesh {
    let (rings, around) = (80u32, 80u32);
    let mut vertices = vec![DVec3::X * 2.0];
    for i in 1..rings {
        let (sin, cos) = (std::f64::consts::PI * f64::from(i) / f64::from(rings)).sin_cos();
        for j in 0..around {
            let (s, c) = (std::f64::consts::TAU * f64::from(j) / f64::from(around)).sin_cos();
            vertices.push(DVec3::new(2.0 * cos, sin * c, sin * s));
        }
    }
    let last = vertices.len() as u32;
    vertices.push(-DVec3::X * 2.0);
    let at = |i: u32, j: u32| 1 + (i - 1) * around + j % around;
    let mut triangles = Vec::new();
    for j in 0..around {
        triangles.push([0, at(1, j), at(1, j + 1)]);
        triangles.push([last, at(rings - 1, j + 1), at(rings - 1, j)]);
        for i in 1..rings - 1 {
            triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    TriangleMesh {
        vertices,
        triangles,
        welded: 0,
    }
}

fn torus(major: f64, minor: f64, along: u32, around: u32) -> TriangleMesh {
    let mut vertices = Vec::new();
    for i in 0..along {
        let (s, c) = (std::f64::consts::TAU * f64::from(i) / f64::from(along)).sin_cos();
        for j in 0..around {
            let (t, d) = (std::f64::consts::TAU * f64::from(j) / f64::from(around)).sin_cos();
            let r = major + minor * d;
            vertices.push(DVec3::new(r * c, r * s, minor * t));
        }
    }
    let at = |i: u32, j: u32| (i % along) * around + j % around;
    let mut triangles = Vec::new();
    for i in 0..along {
        for j in 0..around {
            triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    TriangleMesh {
        vertices,
        triangles,
        welded: 0,
    }
}
