//! T22: sliding that turns into rolling, and rolling that friction of its own slows down, over a sweep of parameters.

use super::Case;
use super::Tolerance::Relative;
use super::slope::{GRAVITY, LEVEL, NEAR, OnPlane};
use crate::closed_forms::{rolling_begins_after, rolling_speed, sliding_distance};
use crate::scenes::{advance, particle};

/// Rows of T22.
pub(super) fn cases() -> Vec<Case> {
    const SLIDING: &str = "rigid sphere with Coulomb friction (Coriolis 1835)";
    const ROLLING: &str = "rigid sphere with a limited rolling couple: (5/7) mu_r g a/R";
    let mut cases = Vec::new();
    for friction in [0.2, 0.7] {
        for speed in [0.5, 1.5] {
            let sphere = OnPlane {
                friction,
                speed,
                damping: 0.002,
                ..LEVEL
            };
            for (k, (what, expected)) in [
                ("time (s)", rolling_begins_after(speed, friction, GRAVITY)),
                ("distance (m)", sliding_distance(speed, friction, GRAVITY)),
                ("speed (m/s)", rolling_speed(speed)),
            ]
            .into_iter()
            .enumerate()
            {
                cases.push(Case::new(
                    format!("T22 engine: sliding turns into rolling, mu = {friction}, v0 = {speed} m/s: {what}"),
                    expected,
                    // The spring holds when k u < gamma |du/dt|: up to 7e-6 of the slip early where mu is largest and v0 least.
                    Relative(2.0 * NEAR),
                    SLIDING,
                    move || sphere.rolling_begins()[k],
                ));
            }
        }
    }
    for rolling in [0.02, 0.1] {
        for (name, lever) in [("lever R*", 1.0), ("lever 2R*", 2.0)] {
            let sphere = OnPlane {
                rolling,
                lever,
                damping: 1.0,
                speed: 1.0,
                ..LEVEL
            };
            let expected = -5.0 / 7.0 * rolling * lever * GRAVITY;
            cases.push(Case::new(
                format!("T22 engine: rolling on a level plane, mu_r = {rolling}, {name}: acceleration (m/s2)"),
                expected,
                Relative(NEAR),
                ROLLING,
                move || {
                    let mut engine = sphere.start_rolling();
                    advance(&mut engine, 30_000);
                    let early = particle(&engine, 0).velocity.x;
                    let since = engine.time();
                    advance(&mut engine, 20_000);
                    (particle(&engine, 0).velocity.x - early) / (engine.time() - since)
                },
            ));
        }
    }
    cases
}
