//! Time of the union of a pebble list: `cargo run --release -p mclump --example union_speed -- LIST.csv`.

use std::time::Instant;

use mclump::inertia::{union, voxels};
use mercury_common::formats::pebble_list::read_pebble_list;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("give a pebble list")?;
    let pebbles = read_pebble_list(&path)?;
    for tolerance in [1e-3, 1e-4, 1e-5, 1e-6, 1e-7] {
        let begin = Instant::now();
        let Some(union) = union::integrate(&pebbles, tolerance) else {
            continue;
        };
        println!(
            "tolerance {tolerance:e}: volume {:.10}, error {:.1e}, {:.3} s",
            union.properties.volume,
            union.relative_error,
            begin.elapsed().as_secs_f64()
        );
    }
    for number in [50, 100, 200, 400] {
        let begin = Instant::now();
        let Some(estimate) = voxels::integrate(&pebbles, number) else {
            continue;
        };
        println!(
            "{number} voxels: volume {:.10}, error {:.1e}, {:.3} s",
            estimate.properties.volume,
            estimate.relative_error,
            begin.elapsed().as_secs_f64()
        );
    }
    Ok(())
}
