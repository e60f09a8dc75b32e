//! Contact parameters that give a collision, and effective moduli of a pair.
//!
//! `mass` is the effective mass m* of the pair.

use std::f64::consts::PI;

use super::linear_contact_time;

/// Stiffness k \[N/m\] and dissipation γ \[kg/s\] of the linear law from contact time and restitution
/// 0 < e <= 1: γ = −(2m*/t_c) ln e, k = m* \[(π/t_c)² + (γ/2m*)²\]. For e = 0 critical damping,
/// with k = m* (π/t_c)².
pub fn linear_from_contact_time(contact_time: f64, restitution: f64, mass: f64) -> (f64, f64) {
    let frequency = PI / contact_time;
    if restitution == 0.0 {
        let stiffness = mass * frequency * frequency;
        return (stiffness, 2.0 * (mass * stiffness).sqrt());
    }
    let dissipation = -2.0 * mass / contact_time * restitution.ln();
    let rate = 0.5 * dissipation / mass;
    (mass * (frequency * frequency + rate * rate), dissipation)
}

/// Dissipation γ \[kg/s\] of the linear law from stiffness and restitution 0 <= e <= 1:
/// γ = −2 ln e √(m* k/(π² + ln² e)); e = 0: 2 √(m* k).
pub fn linear_dissipation(stiffness: f64, restitution: f64, mass: f64) -> f64 {
    2.0 * super::damping_ratio(restitution) * (mass * stiffness).sqrt()
}

/// Tangential stiffness k_t \[N/m\] and dissipation γ_t \[kg/s\] of solid spheres with damping, from
/// the tangential restitution 0 <= β_T <= 1 and the normal one 0 < e <= 1; the tangential half
/// period is then that of the normal direction. The tangential effective mass is (2/7) m*.
pub fn tangential_with_damping(
    stiffness: f64,
    restitution: f64,
    tangential_restitution: f64,
    mass: f64,
) -> (f64, f64) {
    if tangential_restitution == 0.0 {
        // The tangential contact time of the normal one, critically damped.
        let dissipation = linear_dissipation(stiffness, restitution, mass);
        let frequency = PI / linear_contact_time(stiffness, dissipation, mass);
        let tangential_mass = 2.0 / 7.0 * mass;
        let tangential = tangential_mass * frequency * frequency;
        return (tangential, 2.0 * (tangential_mass * tangential).sqrt());
    }
    let (log, log_tangential) = (restitution.ln(), tangential_restitution.ln());
    let square = PI * PI + log_tangential * log_tangential;
    let tangential = 2.0 / 7.0 * stiffness * square / (PI * PI + log * log);
    (
        tangential,
        -2.0 * log_tangential * (2.0 / 7.0 * mass * tangential / square).sqrt(),
    )
}

/// Tangential stiffness \[N/m\] of solid spheres without damping that gives the tangential
/// restitution −1 <= β_T <= 1: k_t = (2/7) k (arccos(−β_T)/π)².
pub fn tangential_without_damping(stiffness: f64, tangential_restitution: f64) -> f64 {
    2.0 / 7.0 * stiffness * ((-tangential_restitution).acos() / PI).powi(2)
}

/// 1/E* = (1−ν₁²)/E₁ + (1−ν₂²)/E₂ \[Pa\] (Hertz 1882); each material is (E, ν).
pub fn effective_modulus((e1, nu1): (f64, f64), (e2, nu2): (f64, f64)) -> f64 {
    1.0 / ((1.0 - nu1 * nu1) / e1 + (1.0 - nu2 * nu2) / e2)
}

/// 1/G* = (2−ν₁)/G₁ + (2−ν₂)/G₂ with G = E/(2(1+ν)) \[Pa\] (Mindlin 1949); each material is (E, ν).
pub fn effective_shear_modulus((e1, nu1): (f64, f64), (e2, nu2): (f64, f64)) -> f64 {
    let compliance = |e: f64, nu: f64| (2.0 - nu) * 2.0 * (1.0 + nu) / e;
    1.0 / (compliance(e1, nu1) + compliance(e2, nu2))
}

#[cfg(test)]
mod tests {
    use super::super::{linear_contact_time, linear_restitution};
    use super::*;

    fn near(value: f64, expected: f64, relative: f64) {
        let error = (value / expected - 1.0).abs();
        assert!(
            error <= relative,
            "{value} instead of {expected}: off by {error:e}"
        );
    }

    #[test]
    fn the_setters_give_what_they_promise() {
        let (stiffness, dissipation) = linear_from_contact_time(0.02, 0.7, 0.5);
        near(stiffness, 12496.02677090382, 1e-14);
        near(dissipation, 17.83374719693662, 1e-14);
        near(linear_dissipation(stiffness, 0.7, 0.5), dissipation, 1e-14);
        for restitution in [0.05, 0.5, 0.99] {
            let (k, gamma) = linear_from_contact_time(3e-4, restitution, 0.2);
            near(linear_contact_time(k, gamma, 0.2), 3e-4, 1e-13);
            near(linear_restitution(k, gamma, 0.2), restitution, 1e-13);
            // In tangential direction the same oscillator with 2/7 of the mass.
            let (kt, gamma_t) = tangential_with_damping(k, restitution, 0.3, 0.2);
            near(linear_contact_time(kt, gamma_t, 0.4 / 7.0), 3e-4, 1e-13);
            near(linear_restitution(kt, gamma_t, 0.4 / 7.0), 0.3, 1e-13);
        }
    }

    #[test]
    fn vanishing_restitution_is_critical_damping() {
        let (k, gamma) = linear_from_contact_time(0.02, 0.0, 0.5);
        near(gamma * gamma, 4.0 * 0.5 * k, 1e-14);
        let (kt, gamma_t) = tangential_with_damping(1e4, 0.7, 0.0, 0.5);
        near(gamma_t * gamma_t, 4.0 * kt * 0.5 * 2.0 / 7.0, 1e-14);
    }

    #[test]
    fn undamped_tangential_rebound() {
        near(tangential_without_damping(1e4, 1.0), 2e4 / 7.0, 1e-15);
        near(tangential_without_damping(1e4, 0.5), 8e4 / 63.0, 1e-14);
    }

    #[test]
    fn effective_moduli_of_equal_and_unequal_materials() {
        let (soft, steel) = ((1e7, 0.3), (210e9, 0.25));
        near(effective_modulus(soft, soft), 5494505.494505494, 1e-15);
        near(
            effective_shear_modulus(soft, soft),
            1131221.719457014,
            1e-15,
        );
        near(effective_modulus(soft, steel), 10988471.91562423, 1e-15);
        near(
            effective_shear_modulus(soft, steel),
            2262336.80539190,
            1e-14,
        );
    }
}
