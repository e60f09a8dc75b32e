//! The motion of a droplet within a step.

use glam::DVec3;
use libm::{exp, expm1, pow};

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

/// What moves the droplets of one nozzle.
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
        let k = self.rate(drag, droplet.radius, droplet.velocity);
        let middle = self.after(drag, droplet.velocity, k, 0.5 * dt).1;
        let k = self.rate(drag, droplet.radius, middle);
        let (way, velocity) = self.after(drag, droplet.velocity, k, dt);
        droplet.position += way;
        droplet.velocity = velocity;
    }

    /// Way (m) and velocity (m/s) after `dt` (s) with this rate of drag (1/s).
    fn after(&self, drag: &Drag, velocity: DVec3, k: f64, dt: f64) -> (DVec3, DVec3) {
        let exponent = -k * dt;
        // (1 - exp(-k dt))/k and what follows from it for the constant force; series where the difference would be lost.
        let (of_velocity, of_force) = if exponent > -1e-4 {
            let of_velocity = dt * (1.0 + 0.5 * exponent * (1.0 + exponent / 3.0));
            (of_velocity, 0.5 * dt * dt * (1.0 + exponent / 3.0))
        } else {
            let of_velocity = -expm1(exponent) / k;
            (of_velocity, (dt - of_velocity) / k)
        };
        let against = velocity - drag.velocity;
        let way = dt * drag.velocity + of_velocity * against + of_force * self.gravity;
        let velocity = drag.velocity + exp(exponent) * against + of_velocity * self.gravity;
        (way, velocity)
    }

    /// 3/4 (rho_g/rho_l) C_d |v - u|/d with C_d = 24/Re (1 + 0.15 Re^0.687) below Re = 1000 and 0.44 from there on, 1/s.
    fn rate(&self, drag: &Drag, radius: f64, velocity: DVec3) -> f64 {
        let diameter = 2.0 * radius;
        let stokes = 18.0 * drag.viscosity / (self.liquid_density * diameter * diameter);
        let speed = (velocity - drag.velocity).length();
        let reynolds = drag.density * speed * diameter / drag.viscosity;
        let factor = if reynolds < 1000.0 {
            1.0 + 0.15 * pow(reynolds, 0.687)
        } else {
            0.44 / 24.0 * reynolds
        };
        stokes * factor
    }

    /// A bound of the speed of a droplet within the next `time` (s), m/s.
    pub(super) fn fastest(&self, velocity: DVec3, time: f64) -> f64 {
        let gas = self.drag.map_or(DVec3::ZERO, |drag| drag.velocity);
        // Drag slows the motion against the gas only.
        (velocity - gas).length() + gas.length() + time * self.gravity.length()
    }
}
