//! How fast frames of a million particles are written and read.
//!
//! `cargo run --release -p common --example frames_speed -- [FILE] [PARTICLES] [FRAMES]`; a file that is named
//! stays.

use std::path::PathBuf;
use std::time::Instant;

use glam::{DQuat, DVec3};
use mercury_common::frames::{
    FrameReader, FramesHeader, ParticleColumns, ParticleFrame, ParticleReader, ParticleWriter,
    Table,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let named = arguments.next().map(PathBuf::from);
    let default = std::env::temp_dir().join("frames_speed.particles.arrow");
    let path = named.clone().unwrap_or(default);
    let particles: usize = arguments
        .next()
        .map_or(Ok(1_000_000), |text| text.parse())?;
    let frames: u64 = arguments.next().map_or(Ok(5), |text| text.parse())?;

    let columns = ParticleColumns {
        orientation: true,
        angular_velocity: true,
        force: true,
        torque: true,
        ..ParticleColumns::default()
    };
    let vectors: Vec<DVec3> = (0..particles)
        .map(|k| DVec3::new(k as f64, 0.5 * k as f64, -1.0))
        .collect();
    let frame = |step| ParticleFrame {
        time: 1e-3 * step as f64,
        step,
        id: (0..particles as u32).collect(),
        material: vec![0; particles],
        flags: vec![0; particles],
        mass: vec![1e-3; particles],
        volume: vec![1e-9; particles],
        radius: vec![1e-3; particles],
        position: vectors.clone(),
        velocity: vectors.clone(),
        body: None,
        orientation: Some(vec![DQuat::IDENTITY; particles]),
        angular_velocity: Some(vectors.clone()),
        force: Some(vectors.clone()),
        torque: Some(vectors.clone()),
        more: Vec::new(),
    };

    let (mut split, mut appended) = (0.0, 0.0);
    for step in 0..frames {
        let frame = frame(step);
        let start = Instant::now();
        let flat = frame.into_frame();
        split += start.elapsed().as_secs_f64();
        drop(flat);
    }
    let mut writer = ParticleWriter::create(&path, &FramesHeader::default(), &columns)?;
    for step in 0..frames {
        let frame = frame(step);
        let start = Instant::now();
        writer.append(frame)?;
        appended += start.elapsed().as_secs_f64();
    }
    let start = Instant::now();
    writer.frames().sync()?;
    let synced = start.elapsed().as_secs_f64();
    let megabytes = std::fs::metadata(&path)?.len() as f64 / 1e6;
    let rate = |seconds: f64| format!("{seconds:.3} s, {:.0} MB/s", megabytes / seconds);
    println!("{frames} frames of {particles} particles, {megabytes:.0} MB");
    println!("append           {}", rate(appended));
    println!("  of which split {split:.3} s");
    println!("append and sync  {}", rate(appended + synced));

    let start = Instant::now();
    let reader = FrameReader::open(&path)?;
    println!(
        "open, {} heads  {:.6} s",
        reader.len(),
        start.elapsed().as_secs_f64()
    );
    let start = Instant::now();
    for frame in reader.frames() {
        frame?;
    }
    println!("read as columns  {}", rate(start.elapsed().as_secs_f64()));
    let reader = ParticleReader::open(&path)?;
    let start = Instant::now();
    for frame in reader.iter() {
        frame?;
    }
    println!("read as vectors  {}", rate(start.elapsed().as_secs_f64()));
    if named.is_none() {
        std::fs::remove_file(&path)?;
    }
    Ok(())
}
