//! Writes a frame of particles as VTU with every compression and prints the time of each, beside that of the bytes alone.
//!
//! `cargo run --release -p common --example vtu_speed -- FOLDER [PARTICLES]`

use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

use glam::DVec3;
use mercury_common::formats::vtu::{
    VtuArray, VtuCompression, VtuGrid, VtuOptions, VtuPrecision, write_vtu,
};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = PathBuf::from(
        arguments
            .next()
            .ok_or("usage: vtu_speed FOLDER [PARTICLES]")?,
    );
    let count: u64 = arguments.next().map_or(Ok(1_000_000), |n| n.parse())?;
    let noise = |k: u64| {
        let mut z = k.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        (z >> 11) as f64 / (1u64 << 53) as f64
    };
    let vector = |k: u64| DVec3::new(noise(3 * k), noise(3 * k + 1), noise(3 * k + 2));
    let points: Vec<DVec3> = (0..count).map(vector).collect();
    let velocity: Vec<DVec3> = (count..2 * count).map(vector).collect();
    let force: Vec<DVec3> = (2 * count..3 * count).map(vector).collect();
    let speed: Vec<f64> = velocity.iter().map(|v| v.length()).collect();
    let diameter: Vec<f64> = (0..count).map(|k| 1e-3 * (1 + k % 7) as f64).collect();
    let id: Vec<u32> = (0..count as u32).collect();
    let material: Vec<u32> = (0..count as u32).map(|k| k % 2).collect();
    let grid = VtuGrid {
        time: Some(0.25),
        points: points.as_slice().into(),
        point_data: vec![
            VtuArray::new("diameter", &diameter),
            VtuArray::new("speed", &speed),
            VtuArray::new("velocity", &velocity),
            VtuArray::new("force", &force),
            VtuArray::new("torque", vec![DVec3::ZERO; count as usize]),
            VtuArray::new("id", &id),
            VtuArray::new("material", &material),
        ],
        ..VtuGrid::default()
    };
    println!("precision compression  threads  seconds        MB      MB/s");
    for precision in [VtuPrecision::Double, VtuPrecision::Single] {
        for (name, compression) in [
            ("none", VtuCompression::None),
            ("adaptive", VtuCompression::Adaptive),
            ("level 1", VtuCompression::Level(1)),
        ] {
            for parallel in [false, true] {
                let options = VtuOptions {
                    precision,
                    compression,
                    parallel,
                };
                let path = folder.join(format!("{precision:?}.{name}.vtu"));
                let start = Instant::now();
                write_vtu(&path, &grid, options)?;
                let seconds = start.elapsed().as_secs_f64();
                let bytes = std::fs::metadata(&path)?.len() as f64 / 1e6;
                let threads = if parallel { "all" } else { "one" };
                println!(
                    "{precision:<9?} {name:<12} {threads:>7} {seconds:8.3} {bytes:9.1} {:9.0}",
                    bytes / seconds
                );
            }
        }
    }
    let bytes = vec![1; 100_000_000];
    let start = Instant::now();
    std::fs::write(folder.join("bytes"), &bytes)?;
    println!("100 MB alone: {:.3} s", start.elapsed().as_secs_f64());
    Ok(())
}
