//! A sphere that falls on a linear spring with a dashpot, gravity acting during the contact too.

/// A sphere on a plane: the motion of the lowest point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bouncing {
    /// √(k/m) \[rad/s\].
    pub frequency: f64,
    /// ζ, 0 <= ζ < 1.
    pub damping_ratio: f64,
    /// m/s².
    pub gravity: f64,
}

impl Bouncing {
    fn damped(&self) -> f64 {
        self.frequency * (1.0 - self.damping_ratio * self.damping_ratio).sqrt()
    }

    /// Overlap \[m\] and its rate \[m/s\] a time after a touch at `speed`:
    /// δ'' + 2 ζ ω δ' + ω² δ = g, δ(0) = 0, δ'(0) = v.
    pub fn overlap(&self, speed: f64, time: f64) -> (f64, f64) {
        let (w, wd) = (self.frequency, self.damped());
        let rate = self.damping_ratio * w;
        let rest = self.gravity / (w * w);
        let (a, b) = (-rest, (speed - rate * rest) / wd);
        let decay = (-rate * time).exp();
        let (sin, cos) = (wd * time).sin_cos();
        let wave = decay * (a * cos + b * sin);
        let slope = decay * (wd * (b * cos - a * sin)) - rate * wave;
        (rest + wave, slope)
    }

    /// When \[s\] the contact that began at `speed` ends, and the speed \[m/s\] then; `None` if it never does.
    pub fn leaves(&self, speed: f64) -> Option<(f64, f64)> {
        // The overlap is positive from the touch until after half a period, and at its least three quarters of one later.
        let half = std::f64::consts::PI / self.damped();
        let parts = 1000;
        let end = (1..=parts)
            .map(|k| half * (0.9 + 0.85 * f64::from(k) / f64::from(parts)))
            .find(|&time| self.overlap(speed, time).0 <= 0.0)?;
        let (mut low, mut high) = (0.5 * half, end);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if self.overlap(speed, middle).0 > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        Some((high, -self.overlap(speed, high).1))
    }

    /// Height of the lowest point \[m\] and its velocity \[m/s\] a time after a start at rest at `height`, until the second touch.
    pub fn height(&self, height: f64, time: f64) -> (f64, f64) {
        let g = self.gravity;
        let touch = (2.0 * height / g).sqrt();
        if time <= touch {
            return (height - 0.5 * g * time * time, -g * time);
        }
        let speed = g * touch;
        match self.leaves(speed) {
            Some((lasts, leaves)) if time > touch + lasts => {
                let since = time - touch - lasts;
                (leaves * since - 0.5 * g * since * since, leaves - g * since)
            }
            _ => {
                let (overlap, rate) = self.overlap(speed, time - touch);
                (-overlap, -rate)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_forms::{damping_ratio, linear_contact_time};

    #[test]
    fn without_damping_the_speed_comes_back() {
        let ball = Bouncing {
            frequency: 30.0,
            damping_ratio: 0.0,
            gravity: 9.81,
        };
        let (lasts, speed) = ball.leaves(2.8).unwrap();
        assert!((speed / 2.8 - 1.0).abs() < 1e-12);
        // phi = pi + 2 atan(g/(w v))
        let expected = (std::f64::consts::PI + 2.0 * (9.81f64 / (30.0 * 2.8)).atan()) / 30.0;
        assert!((lasts / expected - 1.0).abs() < 1e-12);
    }

    #[test]
    fn without_gravity_it_is_the_linear_law() {
        let ball = Bouncing {
            frequency: 30.0,
            damping_ratio: damping_ratio(0.6),
            gravity: 1e-12,
        };
        let (lasts, speed) = ball.leaves(2.8).unwrap();
        assert!((speed / (0.6 * 2.8) - 1.0).abs() < 1e-9);
        let time = linear_contact_time(900.0, 2.0 * ball.damping_ratio * 30.0, 1.0);
        assert!((lasts / time - 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_slow_sphere_on_a_damped_spring_stays() {
        let ball = Bouncing {
            frequency: 30.0,
            damping_ratio: 0.2,
            gravity: 9.81,
        };
        assert!(ball.leaves(1e-3).is_none());
    }
}
