//! A quick volume of a union of balls, to decide when to stop.

use mercury_common::formats::clump::Pebble;
use rayon::prelude::*;

/// Columns along the longer side of the cross section.
const COLUMNS: usize = 200;

/// Volume of the space that balls cover, to about 1e-4: midpoint rule over columns along z, exact in each.
///
/// Reports give the integral of [`crate::inertia::union`]; this one costs milliseconds.
pub(super) fn union_volume(balls: &[Pebble], (low, high): (glam::DVec3, glam::DVec3)) -> f64 {
    let extent = high - low;
    let edge = extent.x.max(extent.y) / COLUMNS as f64;
    let count = [extent.x, extent.y].map(|length| (length / edge).ceil() as usize);
    let rows: Vec<f64> = (0..count[0])
        .into_par_iter()
        .map(|i| {
            let x = low.x + edge * (i as f64 + 0.5);
            let near: Vec<(f64, f64, f64)> = balls
                .iter()
                .map(|ball| {
                    let dx = x - ball.position.x;
                    let square = (ball.radius - dx) * (ball.radius + dx);
                    (square, ball.position.y, ball.position.z)
                })
                .filter(|disc| disc.0 > 0.0)
                .collect();
            let mut spans: Vec<(f64, f64)> = Vec::new();
            let mut area = 0.0;
            for j in 0..count[1] {
                let y = low.y + edge * (j as f64 + 0.5);
                spans.clear();
                for &(disc, y_centre, z) in &near {
                    let square = disc - (y - y_centre) * (y - y_centre);
                    if square > 0.0 {
                        let half = square.sqrt();
                        spans.push((z - half, z + half));
                    }
                }
                spans.sort_by(|a, b| a.0.total_cmp(&b.0));
                let mut top = f64::NEG_INFINITY;
                for &(from, to) in &spans {
                    area += (to - from.max(top)).max(0.0) * edge;
                    top = top.max(to);
                }
            }
            area * edge
        })
        .collect();
    rows.iter().sum()
}
