//! Cost, by counts: clocks are for benches (`benches/insertion.py`).

use std::sync::Arc;

use glam::DVec3;

use super::super::{Region, Total};
use super::{insertion, monodisperse, plan, uniform, unit_box};
use crate::step::Engine;

/// Where all find a place at once, few places are tried in vain. What a place costs is counted beside the crowd.
#[test]
fn a_hundred_thousand_particles_come_in_one_step() {
    let mut scene = plan();
    scene.insertions = vec![insertion(
        unit_box(),
        uniform(0.008, 0.012),
        Total::Number(100_000),
    )];
    let engine = Engine::new(Arc::new(scene.plan().unwrap()), 1).unwrap();
    assert_eq!(engine.particles.len(), 100_000);
    // Each keeps the centres of its like out of a ball of twice its diameter, so that of all places for the last one a share p is taken at
    // most, in a room that is smaller than the box by a diameter, and p / (1 - p) fail for each that does not. The mean of d^3 is 1.04 of
    // the cube of the mean, and that of (d + d')^3 less than 8 times as large.
    let volume = 1.04 * std::f64::consts::PI / 6.0 * 0.01_f64.powi(3);
    let taken: f64 = 8.0 * 1e5 * volume / 0.988_f64.powi(3);
    // The mean of t / (1 - t) for t up to what is taken.
    let in_vain = 1e5 * (-(1.0 - taken).ln() - taken) / taken;
    let failed = engine.boundaries().state().insertions[0].failed_attempts as f64;
    assert!(failed < in_vain, "{failed} {in_vain}");
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
    for _ in 0..300 {
        engine.step(None).unwrap();
    }
    let (attempts, came) = (
        failed(&engine) - before.0,
        engine.particles.len() - before.1,
    );
    println!(
        "{} particles, {came} more in 300 steps, {attempts} failed attempts",
        before.1
    );
    // A hundredth of each step's cost, 15 looks a particle, and in advance what it costs to find out who stands about: to look at
    // each, to find its cells, to list it in 8 at most, to go over the cells, fewer than spheres. An attempt costs a draw, a cell and a sphere at least. What came cost nothing.
    let particles = engine.particles.len() as f64;
    let paid =
        300.0 * 0.01 * 15.0 * (particles + 1000.0) + (1.0 + 10.0 + 2.0 * 8.0 + 0.5) * particles;
    let paid = paid / (12.0 + 8.0 + 2.0);
    assert!(attempts > 0 && (attempts as f64) < paid, "{attempts}");
}
