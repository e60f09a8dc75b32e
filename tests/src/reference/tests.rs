//! The reference path against printed numbers and closed forms. Case numbers T1 ... T17 are those
//! of the contact-model specification.

mod collisions;
mod conservation;
mod golden;
mod mindlin_paths;
mod sphere_on_plane;
mod time_step;
mod walls;

use glam::DVec3;

/// Fails unless each component agrees to `relative` of the vector's length.
#[track_caller]
fn close(value: DVec3, expected: DVec3, relative: f64) {
    let error = (value - expected).length() / expected.length();
    assert!(
        error <= relative,
        "{value} instead of {expected}: off by {error:e}"
    );
}

/// Fails unless the numbers agree to `relative`.
#[track_caller]
fn near(value: f64, expected: f64, relative: f64) {
    let error = (value / expected - 1.0).abs();
    assert!(
        error <= relative,
        "{value} instead of {expected}: off by {error:e}"
    );
}
