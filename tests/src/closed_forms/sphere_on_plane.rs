//! A rigid solid sphere (I = (2/5) m R²) on a plane, with Coulomb's friction and rolling resistance.
//!
//! A simulated sphere has the lever R − δ/2, so it agrees up to δ/R.

/// When a sphere that slides at `speed` without spin begins to roll, 2 v/(7 μ g) \[s\].
pub fn rolling_begins_after(speed: f64, friction: f64, gravity: f64) -> f64 {
    2.0 * speed / (7.0 * friction * gravity)
}

/// How far it has gone by then, (12/49) v²/(μ g) \[m\].
pub fn sliding_distance(speed: f64, friction: f64, gravity: f64) -> f64 {
    12.0 / 49.0 * speed * speed / (friction * gravity)
}

/// The speed at which it rolls from then on, (5/7) v \[m/s\].
pub fn rolling_speed(speed: f64) -> f64 {
    5.0 / 7.0 * speed
}

/// The slope above which a sphere slips, tan θ = (7/2) μ \[rad\].
pub fn slipping_angle(friction: f64) -> f64 {
    (3.5 * friction).atan()
}

/// Acceleration down a slope of a sphere without rolling resistance: (5/7) g sin θ while it rolls,
/// g (sin θ − μ cos θ) above the slipping angle \[m/s²\].
pub fn acceleration_on_slope(angle: f64, friction: f64, gravity: f64) -> f64 {
    if angle <= slipping_angle(friction) {
        5.0 / 7.0 * gravity * angle.sin()
    } else {
        gravity * (angle.sin() - friction * angle.cos())
    }
}

/// Angular acceleration of a slipping sphere, (5/2) μ g cos θ/R \[rad/s²\].
pub fn slipping_angular_acceleration(angle: f64, friction: f64, gravity: f64, radius: f64) -> f64 {
    2.5 * friction * gravity * angle.cos() / radius
}

/// The slope above which rolling resistance no longer holds a sphere, tan θ = μ_r a/R \[rad\].
/// `lever_ratio` = a/R: 1 for the lever R*, 2 for 2R*.
pub fn rolling_angle(rolling_friction: f64, lever_ratio: f64) -> f64 {
    (rolling_friction * lever_ratio).atan()
}

/// Acceleration of a sphere that rolls down a slope against rolling resistance,
/// (5/7) g (sin θ − μ_r (a/R) cos θ) above the rolling angle, else 0 \[m/s²\].
pub fn acceleration_with_rolling_resistance(
    angle: f64,
    rolling_friction: f64,
    lever_ratio: f64,
    gravity: f64,
) -> f64 {
    let drive = angle.sin() - rolling_friction * lever_ratio * angle.cos();
    5.0 / 7.0 * gravity * drive.max(0.0)
}

/// Spin decay about the normal on a level plane, (5/2) μ_o (a/R) g/R \[rad/s²\].
pub fn spin_decay(torsion_friction: f64, lever_ratio: f64, gravity: f64, radius: f64) -> f64 {
    2.5 * torsion_friction * lever_ratio * gravity / radius
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(value: f64, expected: f64, relative: f64) {
        let error = (value / expected - 1.0).abs();
        assert!(
            error <= relative,
            "{value} instead of {expected}: off by {error:e}"
        );
    }

    #[test]
    fn printed_values() {
        let g = 9.81;
        let degrees = f64::to_radians;
        near(rolling_begins_after(1.0, 0.3, g), 0.0970826659, 1e-9);
        near(sliding_distance(1.0, 0.3, g), 0.0832137136, 1e-9);
        near(slipping_angle(0.3), degrees(46.39718103), 1e-9);
        near(
            acceleration_on_slope(degrees(20.0), 0.3, g),
            2.396584004,
            1e-9,
        );
        near(
            acceleration_on_slope(degrees(50.0), 0.3, g),
            5.623172052,
            1e-9,
        );
        near(
            slipping_angular_acceleration(degrees(50.0), 0.3, g, 0.005),
            945.8619677,
            1e-9,
        );
        near(rolling_angle(0.1, 2.0), degrees(11.30993), 1e-6);
        near(rolling_angle(0.1, 1.0), degrees(5.710593), 1e-6);
        near(
            acceleration_with_rolling_resistance(degrees(20.0), 0.1, 2.0, g),
            1.079671917,
            1e-9,
        );
        near(
            acceleration_with_rolling_resistance(degrees(20.0), 0.1, 1.0, g),
            1.738127961,
            1e-9,
        );
        assert_eq!(
            acceleration_with_rolling_resistance(degrees(5.0), 0.1, 1.0, g),
            0.0
        );
        near(100.0 / spin_decay(0.05, 2.0, g, 0.005), 0.203873598, 1e-8);
        assert_eq!(rolling_speed(7.0), 5.0);
    }
}
