//! Time in which a mesh takes new places of its corners, and time in which it is made of the same triangles.
//!
//!     cargo run --release -p solver --example reshape_speed

use std::time::Instant;

use glam::DVec3;
use mercury_common::formats::mesh::TriangleMesh;
use mercury_engine::walls::{Mesh, WallError};

/// A square sheet of twice `cells` squared triangles with a wave.
fn sheet(cells: u32) -> TriangleMesh {
    let mut sheet = TriangleMesh::default();
    for j in 0..=cells {
        for i in 0..=cells {
            let [x, y] = [i, j].map(|k| f64::from(k) / f64::from(cells));
            sheet.vertices.push(DVec3::new(x, y, 0.1 * (9.0 * x).sin()));
            if i < cells && j < cells {
                let a = j * (cells + 1) + i;
                let (b, c, d) = (a + 1, a + cells + 2, a + cells + 1);
                sheet.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    sheet
}

fn main() -> Result<(), WallError> {
    println!(
        "{:>10} {:>12} {:>12} {:>8}",
        "triangles", "made, ms", "reshaped, ms", "ratio"
    );
    for cells in [8, 35, 110, 350, 700] {
        let triangles = sheet(cells);
        let (mut made, mut reshaped) = (Vec::new(), Vec::new());
        for round in 0..7 {
            let start = Instant::now();
            let mut mesh = Mesh::new(&triangles, |x| x, false)?;
            made.push(1e3 * start.elapsed().as_secs_f64());
            let lift = |x: &DVec3| *x + 1e-3 * f64::from(round) * (7.0 * x.y).cos() * DVec3::Z;
            let places: Vec<DVec3> = mesh.corners().iter().map(lift).collect();
            let start = Instant::now();
            mesh.reshape(&places)?;
            reshaped.push(1e3 * start.elapsed().as_secs_f64());
        }
        // Other work of the machine only makes times longer.
        let least = |times: &[f64]| times.iter().copied().fold(f64::INFINITY, f64::min);
        let (made, reshaped) = (least(&made), least(&reshaped));
        let count = triangles.triangles.len();
        println!(
            "{count:>10} {made:>12.3} {reshaped:>12.3} {:>8.3}",
            reshaped / made
        );
    }
    Ok(())
}
