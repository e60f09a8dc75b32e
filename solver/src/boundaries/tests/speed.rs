//! Cost, by counts and generous clocks.

use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;

use super::super::{Region, Total};
use super::{insertion, monodisperse, plan, uniform, unit_box};
use crate::step::Engine;

#[test]
fn a_hundred_thousand_particles_come_within_seconds() {
    let mut scene = plan();
    scene.insertions = vec![insertion(
        unit_box(),
        uniform(0.008, 0.012),
        Total::Number(100_000),
    )];
    let start = Instant::now();
    let engine = Engine::new(Arc::new(scene.plan().unwrap()), 1).unwrap();
    let seconds = start.elapsed().as_secs_f64();
    assert_eq!(engine.particles.len(), 100_000);
    // 0.4 s on a busy machine; testing all pairs would take minutes.
    assert!(seconds < 10.0, "{seconds} s");
    println!("100 000 particles: {seconds:.3} s with the first list and forces");
}

#[test]
fn a_saturated_insertion_does_not_stop_the_run() {
    let mut scene = plan();
    scene.insertions = vec![insertion(
        Region::Box {
            min: DVec3::ZERO,
            max: DVec3::new(0.5, 0.5, 0.25),
        },
        monodisperse(0.02),
        Total::Number(1_000_000),
    )];
    let mut engine = Engine::new(Arc::new(scene.plan().unwrap()), 1).unwrap();
    let failed = |engine: &Engine| engine.boundaries().state().insertions[0].failed_attempts;
    let before = (failed(&engine), engine.particles.len());
    let start = Instant::now();
    for _ in 0..300 {
        engine.step(None).unwrap();
    }
    let seconds = start.elapsed().as_secs_f64() / 300.0;
    let (attempts, came) = (
        failed(&engine) - before.0,
        engine.particles.len() - before.1,
    );
    println!(
        "{} particles, {came} more in 300 steps, {attempts} failed attempts, {seconds:.5} s per step",
        before.1
    );
    // A hundredth of each step's cost, 15 looks a particle, and in advance what it costs to find out who stands about: to look at
    // each, to find its cells, to list it in 8 at most, to go over the cells, fewer than spheres. An attempt costs a draw, a cell and a sphere at least. What came cost nothing.
    let particles = engine.particles.len() as f64;
    let paid =
        300.0 * 0.01 * 15.0 * (particles + 1000.0) + (1.0 + 10.0 + 2.0 * 8.0 + 0.5) * particles;
    let paid = paid / (12.0 + 8.0 + 2.0);
    assert!(attempts > 0 && (attempts as f64) < paid, "{attempts}");
    assert!(seconds < 1.0, "{seconds} s per step");
}
