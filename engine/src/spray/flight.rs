//! The motion of a droplet within a step.

use std::sync::LazyLock;

use glam::DVec3;
use libm::{expm1, pow};

use super::{Droplet, NozzlePlan};

/// Drag of a gas on droplets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drag {
    /// kg/m^3
    pub density: f64,
    /// Pa s
    pub viscosity: f64,
    /// Velocity of the gas, m/s.
    pub velocity: DVec3,
}

/// Forces on the droplets of one nozzle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Flight {
    gravity: DVec3,
    drag: Option<Drag>,
    liquid_density: f64,
}

impl Flight {
    pub(super) fn new(nozzle: &NozzlePlan, gravity: DVec3) -> Self {
        Self {
            gravity: if nozzle.gravity { gravity } else { DVec3::ZERO },
            drag: nozzle.drag,
            liquid_density: nozzle.liquid_density,
        }
    }

    /// Moves a droplet on by `dt` (s): along the exact parabola without drag, of second order in the step with it.
    ///
    /// With drag, dv/dt = g - k (v - u) with the velocity u of the gas and the rate k of Schiller & Naumann (1933). k is taken at the
    /// middle of the step and held through it, where the equation has the solution v = w + (v0 - w) exp(-k t), w = u + g/k: no droplet
    /// is so small that a step would be unstable.
    #[inline]
    pub(super) fn advance(&self, droplet: &mut Droplet, dt: f64) {
        let Some(drag) = &self.drag else {
            let half = 0.5 * dt * self.gravity;
            droplet.position += dt * (droplet.velocity + half);
            droplet.velocity += dt * self.gravity;
            return;
        };
        let air = Air::around(drag, droplet.radius, self.liquid_density);
        let against = droplet.velocity - drag.velocity;
        let (left, of_velocity, _) = decays(0.5 * dt * air.rate(against.length()));
        let at_middle = left * against + 0.5 * dt * of_velocity * self.gravity;
        let (left, of_velocity, of_force) = decays(dt * air.rate(at_middle.length()));
        droplet.position +=
            dt * (drag.velocity + of_velocity * against + dt * of_force * self.gravity);
        droplet.velocity = drag.velocity + left * against + dt * of_velocity * self.gravity;
    }

    /// A bound of the speed of a droplet within the next `time` (s), m/s.
    pub(super) fn fastest(&self, velocity: DVec3, time: f64) -> f64 {
        let gas = self.drag.map_or(DVec3::ZERO, |drag| drag.velocity);
        // Drag slows the motion against the gas only.
        (velocity - gas).length() + gas.length() + time * self.gravity.length()
    }
}

/// Drag of the gas on a droplet of one size.
struct Air {
    /// Rate of Stokes' drag, 1/s.
    stokes: f64,
    /// Reynolds number per speed, s/m.
    reynolds: f64,
}

impl Air {
    fn around(drag: &Drag, radius: f64, liquid_density: f64) -> Self {
        let diameter = 2.0 * radius;
        Self {
            stokes: 18.0 * drag.viscosity / (liquid_density * diameter * diameter),
            reynolds: drag.density * diameter / drag.viscosity,
        }
    }

    /// 3/4 (rho_g/rho_l) C_d |v - u|/d with C_d = 24/Re (1 + 0.15 Re^0.687) below Re = 1000 and 0.44 from there on, 1/s.
    #[inline]
    fn rate(&self, speed: f64) -> f64 {
        let reynolds = self.reynolds * speed;
        let factor = if reynolds < 1000.0 {
            1.0 + 0.15 * POWER.of(reynolds)
        } else {
            0.44 / 24.0 * reynolds
        };
        self.stokes * factor
    }
}

/// exp(-x), (1 - exp(-x))/x and (x - 1 + exp(-x))/x^2 for x >= 0: for small x, as of most droplets, by series, which lose no digits.
#[inline]
fn decays(x: f64) -> (f64, f64, f64) {
    let (once, twice);
    if x < SMALL {
        // The sum of (-x)^n/(n + 2)!; the first term left out is 2e-17.
        twice = SERIES.into_iter().fold(0.0, |sum, next| next - x * sum);
        once = 1.0 - x * twice;
    } else {
        once = -expm1(-x) / x;
        twice = (1.0 - once) / x;
    }
    (1.0 - x * once, once, twice)
}

/// 1/7!, ..., 1/2!.
const SERIES: [f64; 6] = [
    1.0 / 5040.0,
    1.0 / 720.0,
    1.0 / 120.0,
    1.0 / 24.0,
    1.0 / 6.0,
    1.0 / 2.0,
];

/// Below this x [`decays`] has series.
const SMALL: f64 = 0.01;

/// The exponent in the drag of Schiller & Naumann.
const EXPONENT: f64 = 0.687;

/// Coefficients of u^5 to u in (1 + u)^0.687: binomial ones.
const BINOMIAL: [f64; 5] = {
    let (mut all, mut last, mut n) = ([0.0; 5], 1.0, 0);
    while n < 5 {
        last *= (EXPONENT - n as f64) / (n + 1) as f64;
        all[4 - n] = last;
        n += 1;
    }
    all
};

/// Powers of two between which [`POWER`] has tables: from where the drag is that of Stokes but for 1e-9 to Re = 1024.
const TWOS: (i64, i64) = (-40, 10);

/// Parts of (1, 2) in the tables of [`POWER`], and their binary digits.
const PARTS: usize = 1 << PART_DIGITS;
const PART_DIGITS: u32 = 7;

/// x^0.687 from tables, to round-off: `pow` would take half of a droplet's step.
struct Power {
    /// 2^(0.687 n).
    twos: Vec<f64>,
    /// Inverse and power of the middle of each part of (1, 2).
    middles: [[f64; 2]; PARTS],
}

static POWER: LazyLock<Power> = LazyLock::new(|| Power {
    twos: (TWOS.0..TWOS.1)
        .map(|n| pow(2.0, EXPONENT * n as f64))
        .collect(),
    middles: std::array::from_fn(|n| {
        let middle = 1.0 + (n as f64 + 0.5) / PARTS as f64;
        [1.0 / middle, pow(middle, EXPONENT)]
    }),
});

impl Power {
    #[inline]
    fn of(&self, x: f64) -> f64 {
        let bits = x.to_bits();
        let two = (bits >> 52) as i64 - 1023 - TWOS.0;
        let Some(of_two) = usize::try_from(two).ok().and_then(|two| self.twos.get(two)) else {
            return pow(x, EXPONENT);
        };
        let fraction = bits & ((1 << 52) - 1);
        let [inverse, of_middle] = self.middles[(fraction >> (52 - PART_DIGITS)) as usize];
        // |u| < 1/256: the first term left out of the series is below 1e-16.
        let u = f64::from_bits(fraction | 1f64.to_bits()) * inverse - 1.0;
        let sum = BINOMIAL.into_iter().fold(0.0, |sum, next| sum * u + next);
        of_two * (of_middle + of_middle * (u * sum))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Some roundings of products and sums near 1.
    const CLOSE: f64 = 8.0 * f64::EPSILON;

    #[test]
    fn powers_and_decays_are_those_of_the_library() {
        for k in 0..4000 {
            let x = libm::exp(-40.0 + 0.0117 * f64::from(k));
            let (found, exact) = (POWER.of(x), pow(x, EXPONENT));
            assert!(
                (found / exact - 1.0).abs() < CLOSE,
                "{x}: {found}, not {exact}"
            );
        }
        assert_eq!(POWER.of(0.0), 0.0);
        for k in 0..600 {
            let x = libm::exp(-25.0 + 0.05 * f64::from(k));
            let (left, once, twice) = decays(x);
            // The first by the library; the others by what follows from it, where the differences keep their digits.
            let exact = libm::exp(-x);
            assert!((left - exact).abs() < CLOSE, "{x}: {left}, not {exact}");
            assert!((once / (-expm1(-x) / x) - 1.0).abs() < CLOSE, "{x}: {once}");
            let series = 0.5 - x / 6.0 * (1.0 - 0.25 * x);
            let expected = if x < 1e-5 {
                series
            } else {
                (x + expm1(-x)) / (x * x)
            };
            let digits = if x < 1e-5 {
                CLOSE
            } else {
                4.0 * f64::EPSILON / x + CLOSE
            };
            assert!(
                (twice / expected - 1.0).abs() < digits,
                "{x}: {twice}, not {expected}"
            );
        }
        assert_eq!(decays(0.0), (1.0, 1.0, 0.5));
    }
}
