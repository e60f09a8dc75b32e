//! How the energy of an elastic gas wanders.
//!
//! Leapfrog keeps a neighbouring energy as long as the force is smooth. Where a contact begins or ends it is not: the force overlap^s has a corner. There the scheme
//! is the trapezoidal sum of a function that begins between two points, and by Euler and Maclaurin the energy jumps by
//!
//! ΔE = -κ h^(s+1) ζ(-s, θ),  h = v Δt,
//!
//! with F = κ overlap^s, v the normal velocity, θ in (0, 1) the place of the beginning between two points, ζ Hurwitz' function. θ is random, the mean of ζ(-s, θ) is
//! zero and its variance ½ (2 Γ(s+1)/(2π)^(s+1))² ζ(2s+2) (its Fourier series, Apostol 1976, *Introduction to Analytic Number Theory*, theorem 12.6). So the energy makes a random walk: two independent jumps a collision. As the
//! map preserves volume in phase space, the walk has a drift towards more states: d⟨E⟩/dt = D d ln(Ω D)/dE with Ω ~ E^(f/2 - 1) and D half the variance per time.
//! For s = 1 a jump is half the well known m* (ω Δt)² v² θ(1 - θ), less its mean.
//!
//! Within a contact the energy differs from the neighbouring one by -Δt² (v² U''/12 - U'²/24) for a unit mass (Hairer, Lubich & Wanner 2006, section IX.3): pairs that are
//! in contact when someone looks add a noise, which does not grow.

use std::f64::consts::PI;

use glam::DVec3;
use mercury_engine::contact::normal::AnyNormalHistory;
use mercury_engine::contact::{AnyNormal, NormalLaw as _};

use super::stage::Stage;
use crate::scenes::contact_at_rest;

/// Expected statistics of the energy of a gas.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EnergyWalk {
    /// Variance of the energy, J² per second.
    pub(super) variance: f64,
    /// Mean growth of the energy, J per second.
    pub(super) drift: f64,
    /// Mean square of what pairs in contact add to the energy at a look, J².
    pub(super) noise: f64,
    /// Collisions per second.
    pub(super) collisions: f64,
}

impl EnergyWalk {
    /// Walk of the gas in a periodic box as it is now.
    ///
    /// Collisions by kinetic theory: π σ² χ √(8 kT/π m*)/V for each pair (Chapman & Cowling 1970), with the contact value χ of Carnahan and Starling (1969). At a
    /// collision the energy m* v²/2 of the normal motion is distributed exponentially with mean kT.
    pub(super) fn of(stage: &Stage) -> Self {
        let physics = stage.engine.physics();
        let size = physics.cell.size();
        let volume = size.x * size.y * size.z;
        let grains: Vec<_> = stage.free().collect();
        let (mut solid, mut momentum, mut mass) = (0.0, DVec3::ZERO, 0.0);
        for (record, m) in &grains {
            solid += 4.0 / 3.0 * PI * record.radius.powi(3);
            momentum += *m * record.velocity;
            mass += m;
        }
        let fraction = solid / volume;
        let chi = (1.0 - 0.5 * fraction) / (1.0 - fraction).powi(3);
        let freedoms = 3.0 * grains.len() as f64 - 3.0;
        let kinetic = stage.energies().kinetic - 0.5 * momentum.length_squared() / mass;
        let temperature = 2.0 * kinetic / freedoms;
        let mut walk = Self {
            variance: 0.0,
            drift: 0.0,
            noise: 0.0,
            collisions: 0.0,
        };
        for (k, (a, mass_a)) in grains.iter().enumerate() {
            for (b, mass_b) in &grains[..k] {
                let effective = 1.0 / (1.0 / mass_a + 1.0 / mass_b);
                let law = physics.laws.get(a.material.number(), b.material.number());
                let radius = 1.0 / (1.0 / a.radius + 1.0 / b.radius);
                let Some(corner) = law.and_then(|law| Corner::of(&law.normal, radius)) else {
                    continue;
                };
                let (s, dt) = (corner.exponent, physics.time_step);
                let reach = a.radius + b.radius;
                let speed = (8.0 * temperature / (PI * effective)).sqrt();
                let rate = PI * reach * reach * chi * speed / volume;
                // <v^p> of an exponentially distributed m* v^2/2.
                let thermal = (2.0 * temperature / effective).sqrt();
                let moment = |p: f64| thermal.powf(p) * gamma(0.5 * p + 1.0);
                let jump = corner.zeta_variance()
                    * (corner.factor * dt.powf(s + 1.0)).powi(2)
                    * moment(2.0 * s + 2.0);
                let variance = rate * 2.0 * jump;
                walk.collisions += rate;
                walk.variance += variance;
                // D ~ E^(s + 3/2).
                walk.drift += 0.5 * variance * (0.5 * freedoms - 1.0 + s + 1.5) / kinetic;
                // Largest overlap over v^(2/(s + 1)); a contact lasts for 2 I overlaps over v.
                let deepest = ((s + 1.0) * effective / (2.0 * corner.factor)).powf(1.0 / (s + 1.0));
                let [lasts, square] = corner.within();
                walk.noise += rate
                    * 2.0
                    * lasts
                    * square
                    * (0.5 * effective).powi(2)
                    * dt.powi(4)
                    * moment(7.0 - 6.0 / (s + 1.0))
                    / deepest.powi(3);
            }
        }
        walk
    }
}

/// How a contact begins: F = κ overlap^s.
#[derive(Debug, Clone, Copy)]
struct Corner {
    /// s.
    exponent: f64,
    /// κ, N/m^s.
    factor: f64,
}

impl Corner {
    /// Corner of a law without memory for R* (m): by its elastic force at two small overlaps.
    fn of(law: &AnyNormal, effective_radius: f64) -> Option<Self> {
        let force = |overlap: f64| {
            let contact = contact_at_rest(overlap, effective_radius, 1.0);
            law.force(&contact, &mut AnyNormalHistory::default())
                .elastic
        };
        let small = 1e-9 * effective_radius;
        let exponent = (force(2.0 * small) / force(small)).log2();
        law.is_elastic().then(|| Self {
            exponent,
            factor: force(small) / small.powf(exponent),
        })
    }

    /// Variance of ζ(-s, θ) over θ in (0, 1).
    fn zeta_variance(&self) -> f64 {
        let s = self.exponent;
        let size = 2.0 * gamma(s + 1.0) / (2.0 * PI).powf(s + 1.0);
        let zeta: f64 = (1..100).map(|n| f64::from(n).powf(-2.0 * s - 2.0)).sum();
        0.5 * size * size * zeta
    }

    /// With y the overlap over the largest one: the integral I of dy/√(1 - y^(s+1)), half the duration of a contact; and the mean square over this time of what the
    /// energy within a contact has more, over (v Δt/largest overlap)² m* v²/2.
    fn within(&self) -> [f64; 2] {
        let s = self.exponent;
        let mut sums = [0.0; 2];
        const POINTS: u32 = 200;
        for k in 0..POINTS {
            // y = 1 - u², which takes the root away.
            let u = (f64::from(k) + 0.5) / f64::from(POINTS);
            let y = 1.0 - u * u;
            let weight = 2.0 * u / (1.0 - y.powf(s + 1.0)).sqrt() / f64::from(POINTS);
            let more = s * (s + 1.0) / 12.0 * (1.0 - y.powf(s + 1.0)) * y.powf(s - 1.0)
                - (s + 1.0) * (s + 1.0) / 48.0 * y.powf(2.0 * s);
            sums[0] += weight;
            sums[1] += weight * more * more;
        }
        [sums[0], sums[1] / sums[0]]
    }
}

/// Γ(x) for x between 2 and 6: its integral.
fn gamma(x: f64) -> f64 {
    const POINTS: u32 = 400;
    let step = 40.0 / f64::from(POINTS);
    let at = |k: u32| {
        let z = (f64::from(k) + 0.5) * step;
        z.powf(x - 1.0) * (-z).exp()
    };
    (0..POINTS).map(at).sum::<f64>() * step
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use mercury_engine::contact::{AnyNormal, Hertz, Linear};

    use super::{Corner, gamma};

    const LINEAR: Corner = Corner {
        exponent: 1.0,
        factor: 1.0,
    };

    /// F = k overlap, and F = 4/3 E* sqrt(R*) overlap^1.5 (Hertz 1882).
    #[test]
    fn corners_are_those_of_the_laws() {
        let hertz = 4.0 / 3.0 * 1e7 * 0.01f64.sqrt();
        for (law, exponent, factor) in [
            (AnyNormal::Linear(Linear::new(3e4, 2.0)), 1.0, 3e4),
            (AnyNormal::Hertz(Hertz::new(1e7, 0.3)), 1.5, hertz),
        ] {
            let corner = Corner::of(&law, 0.01).unwrap();
            assert!((corner.exponent - exponent).abs() < 1e-14);
            // Round-off of the exponent, times the logarithm of the overlap.
            assert!((corner.factor / factor - 1.0).abs() < 1e-12);
        }
    }

    /// ζ(-1, θ) = -(θ² - θ + 1/6)/2, whose variance is 1/720.
    #[test]
    fn the_variance_of_a_straight_corner_is_known() {
        assert!((LINEAR.zeta_variance() * 720.0 - 1.0).abs() < 1e-2);
    }

    /// Half a period of the linear spring is π/ω = 2 I/ω; within it, (1/6 - sin²/4)² has the mean 1/36 - 1/24 + 3/128. A Hertz contact lasts for 2.943 overlaps over the
    /// speed (Johnson 1985, section 11.4).
    #[test]
    fn what_is_within_a_contact_is_known() {
        let [half, square] = LINEAR.within();
        assert!((half - PI / 2.0).abs() < 1e-4, "{half}");
        let known = 1.0 / 36.0 - 1.0 / 24.0 + 3.0 / 128.0;
        assert!((square / known - 1.0).abs() < 1e-2, "{square} {known}");
        let hertz = Corner {
            exponent: 1.5,
            ..LINEAR
        };
        assert!((hertz.within()[0] - 0.5 * 2.943).abs() < 1e-3);
    }

    #[test]
    fn the_gamma_function_is_known() {
        for (x, known) in [(2.0, 1.0), (5.0, 24.0), (3.5, 15.0 / 8.0 * PI.sqrt())] {
            assert!((gamma(x) / known - 1.0).abs() < 1e-2, "{x}");
        }
    }
}
