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
use mclump::generate::{Euclidean, Method, Request, Stop, Tangent, generate};
use mercury_common::formats::clump::Pebble;
use mercury_common::formats::mesh::{TriangleMesh, read_mesh};
use mercury_pictures::charts::{Axis, Chart, ChartPage, Hue, Series};

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

/// Value that is drawn of a row: name, colour and value.
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
const METHODS: [(&str, Hue); 5] = [
    ("Euclidean", Hue::Vermillion),
    ("tangent", Hue::Blue),
    ("Favier", Hue::Green),
    ("tangent, 0.15 mm out", Hue::Purple),
    ("shipped, 0.44 mm out", Hue::Ink),
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
        ("Favier", Method::Favier),
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
    let mut bodies: Vec<&str> = rows.iter().map(|row| row.body).collect();
    bodies.dedup();
    let of_body = |body: &str| {
        let rows: Vec<&Row> = rows.iter().filter(|row| row.body == body).collect();
        QUANTITIES.map(|(name, quantity)| chart(&format!("{body}: {name}"), &rows, quantity))
    };
    let charts: Vec<Chart> = bodies.iter().flat_map(|body| of_body(body)).collect();
    let page = ChartPage {
        shared_legend: true,
        ..ChartPage::new("", QUANTITIES.len(), charts)
    };
    let height = 40.0 + 230.0 * bodies.len() as f64;
    Ok(page.size(1160.0, height).write_svg(path)?)
}

fn chart(title: &str, rows: &[&Row], quantity: fn(&Row) -> Option<f64>) -> Chart {
    let pebbles = Axis::log("pebbles", "").within(0.8, 700.0);
    let mut chart = Chart::new(title, pebbles, Axis::log("", ""));
    for (method, hue) in METHODS {
        let points = (rows.iter())
            .filter(|row| row.method == method)
            .filter_map(|row| Some((row.fidelity.pebbles as f64, quantity(row)?)))
            .filter(|point| point.1 > 0.0);
        chart = chart.with(Series::marked_line(method, points.collect()).hue(hue));
    }
    chart
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
        ..TriangleMesh::default()
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
        ..TriangleMesh::default()
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
        ..TriangleMesh::default()
    }
}
