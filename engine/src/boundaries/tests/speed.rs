//! Cost, by counts: clocks are for benches (`benches/insertion.py`).

use glam::DVec3;

use super::super::{InsertionPlan, Limit, Region, Total};
use super::{insertion, monodisperse, plan, uniform, unit_box};
use crate::step::Engine;

/// Where all find a place at once, few places are tried in vain.
#[test]
fn a_hundred_thousand_particles_come_in_one_step() {
    let mut scene = plan();
    scene.insertions = vec![insertion(
        unit_box(),
        uniform(0.008, 0.012),
        Total::Number(100_000),
    )];
    let engine = Engine::new(scene.setup().unwrap(), 1).unwrap();
    assert_eq!(engine.particles.len(), 100_000);
    // Each keeps the centres of the others out of a ball of twice its diameter, so that for the last one a share p of all places
    // is taken at most, in a volume whose sides are shorter than the box by a diameter, and p / (1 - p) attempts fail for each
    // that succeeds. The mean of d^3 is 1.04 of the cube of the mean, and that of (d + d')^3 less than 8 times as large.
    let volume = 1.04 * std::f64::consts::PI / 6.0 * 0.01_f64.powi(3);
    let taken: f64 = 8.0 * 1e5 * volume / 0.988_f64.powi(3);
    // The mean of t / (1 - t) for t up to what is taken.
    let in_vain = 1e5 * (-(1.0 - taken).ln() - taken) / taken;
    let failed = engine.boundaries().state().insertions[0].failed_attempts as f64;
    assert!(failed < in_vain, "{failed} {in_vain}");
}

/// Grains that find no place between the spheres of another insertion, which fill the region, are tried in one step of 64.
#[test]
fn a_full_region_is_tried_seldom() {
    let region = || Region::Box {
        min: DVec3::ZERO,
        max: DVec3::new(0.5, 0.5, 0.25),
    };
    let mut scene = plan();
    scene.insertions = vec![
        insertion(region(), monodisperse(0.02), Total::Full),
        InsertionPlan {
            name: "large".to_owned(),
            ..insertion(region(), monodisperse(0.06), Total::Number(1))
        },
    ];
    let mut engine = Engine::new(scene.setup().unwrap(), 1).unwrap();
    for _ in 0..300 {
        engine.step(None).unwrap();
    }
    let large = &engine.boundaries().state().insertions[1];
    assert_eq!((large.inserted.number, large.limit), (0, Limit::Space));
    // Rounds at the start and in steps 1, 3, 7, 15, 31, 63, 127, 191, 255.
    assert_eq!(large.failed_attempts, 1000 * 10);
    assert_eq!(engine.have_places(), [true, false]);
}
