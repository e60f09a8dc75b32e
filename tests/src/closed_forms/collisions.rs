//! Head-on collisions of two bodies under the linear, Hertz and plastic normal laws.
//!
//! `mass` is the effective mass m* = 1/(1/m₁ + 1/m₂) and `radius` the effective radius
//! R* = 1/(1/R₁ + 1/R₂) throughout; a wall has neither 1/m nor 1/R.

use std::f64::consts::{FRAC_PI_2, PI};

/// Damping ratio ζ = |ln e|/√(π² + ln² e) of restitution 0 < e <= 1; ζ(0) = 1. It belongs to the
/// linear law, and through β = √5 ζ to the Hertz law. Tensile forces are not clamped.
pub fn damping_ratio(restitution: f64) -> f64 {
    if restitution == 0.0 {
        return 1.0;
    }
    let log = restitution.ln().abs();
    log / (PI * PI + log * log).sqrt()
}

/// Restitution e = exp(−π ζ/√(1 − ζ²)) of the damping ratio 0 <= ζ < 1: inverse of
/// [`damping_ratio`].
pub fn restitution_of(damping_ratio: f64) -> f64 {
    (-PI * slope(damping_ratio)).exp()
}

/// ζ/√(1 − ζ²).
fn slope(damping_ratio: f64) -> f64 {
    damping_ratio / (1.0 - damping_ratio * damping_ratio).sqrt()
}

/// Restitution when the force is not allowed to pull, 0 <= ζ < 1 (linear and Hertz law alike).
///
/// The contact then ends where k δ = γ |δ'|, at the phase ω t = π − atan2(2ζ√(1−ζ²), 1−2ζ²)
/// (Schwager & Pöschel 2007).
pub fn clamped_restitution(damping_ratio: f64) -> f64 {
    let root = (1.0 - damping_ratio * damping_ratio).sqrt();
    let early = (2.0 * damping_ratio * root).atan2(1.0 - 2.0 * damping_ratio * damping_ratio);
    (-slope(damping_ratio) * (PI - early)).exp()
}

/// The damping ratio at which the clamped restitution is `restitution`, e⁻² < e <= 1: inverse of
/// [`clamped_restitution`], by bisection. NaN outside: an overdamped contact would be needed.
pub fn clamped_damping_ratio(restitution: f64) -> f64 {
    if !(restitution > (-2.0f64).exp() && restitution <= 1.0) {
        return f64::NAN;
    }
    let (mut low, mut high) = (0.0, 1.0);
    while high - low > f64::EPSILON * high {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if clamped_restitution(middle) > restitution {
            low = middle
        } else {
            high = middle
        }
    }
    0.5 * (low + high)
}

/// Largest overlap, relative to that without damping, of the linear law:
/// exp(−ζ/√(1−ζ²) arccos ζ), reached at ω t = arccos ζ.
pub fn linear_overlap_ratio(damping_ratio: f64) -> f64 {
    (-slope(damping_ratio) * damping_ratio.acos()).exp()
}

/// Duration of a linear contact, π/√(k/m* − (γ/2m*)²) \[s\]; NaN when overdamped.
pub fn linear_contact_time(stiffness: f64, dissipation: f64, mass: f64) -> f64 {
    PI / linear_frequency(stiffness, dissipation, mass)
}

/// Damped frequency √(k/m* − (γ/2m*)²) \[rad/s\].
fn linear_frequency(stiffness: f64, dissipation: f64, mass: f64) -> f64 {
    (stiffness / mass - (0.5 * dissipation / mass).powi(2)).sqrt()
}

/// Restitution of a linear contact, exp(−γ t_c/2m*); NaN when overdamped.
pub fn linear_restitution(stiffness: f64, dissipation: f64, mass: f64) -> f64 {
    (-0.5 * dissipation / mass * linear_contact_time(stiffness, dissipation, mass)).exp()
}

/// Largest overlap of a linear contact at approach speed `speed` \[m\].
pub fn linear_largest_overlap(stiffness: f64, dissipation: f64, mass: f64, speed: f64) -> f64 {
    let zeta = 0.5 * dissipation / (mass * stiffness).sqrt();
    speed / (stiffness / mass).sqrt() * linear_overlap_ratio(zeta)
}

/// When the largest overlap of a linear contact is reached, arccos ζ/ω \[s\].
pub fn linear_time_of_largest_overlap(stiffness: f64, dissipation: f64, mass: f64) -> f64 {
    let zeta = 0.5 * dissipation / (mass * stiffness).sqrt();
    zeta.acos() / linear_frequency(stiffness, dissipation, mass)
}

/// Largest overlap δ = \[(15/16) m* v²/(E* √R*)\]^(2/5) of an elastic Hertz contact \[m\].
pub fn hertz_largest_overlap(effective_modulus: f64, mass: f64, radius: f64, speed: f64) -> f64 {
    (15.0 / 16.0 * mass * speed * speed / (effective_modulus * radius.sqrt())).powf(0.4)
}

/// ∫₀¹ 2 dx/√(1 − x^(5/2)) = (4/5) √π Γ(2/5)/Γ(9/10): duration of an elastic Hertz contact in
/// units of δ/v.
pub const HERTZ_DURATION: f64 = 2.943_275_184_324_704_7;

/// Duration of an elastic Hertz contact \[s\].
pub fn hertz_contact_time(effective_modulus: f64, mass: f64, radius: f64, speed: f64) -> f64 {
    HERTZ_DURATION * hertz_largest_overlap(effective_modulus, mass, radius, speed) / speed
}

/// Elastic Hertz force (4/3) E* √R* δ^(3/2) \[N\].
pub fn hertz_force(effective_modulus: f64, radius: f64, overlap: f64) -> f64 {
    4.0 / 3.0 * effective_modulus * radius.sqrt() * overlap.powf(1.5)
}

/// Largest force of an elastic Hertz contact \[N\].
pub fn hertz_largest_force(effective_modulus: f64, mass: f64, radius: f64, speed: f64) -> f64 {
    let overlap = hertz_largest_overlap(effective_modulus, mass, radius, speed);
    hertz_force(effective_modulus, radius, overlap)
}

/// β(e) = √5 ζ(e), the damping of the Hertz law with the secant stiffness (Antypov & Elliott 2011).
pub fn hertz_damping(restitution: f64) -> f64 {
    5.0f64.sqrt() * damping_ratio(restitution)
}

/// Largest overlap of a damped Hertz contact relative to the elastic one.
///
/// In y = δ^(5/4) and a time that runs with (5/4) δ^(1/4) the damped Hertz law is the linear law
/// (Antypov & Elliott 2011), so this is the linear ratio to the power 4/5.
pub fn hertz_overlap_ratio(restitution: f64) -> f64 {
    linear_overlap_ratio(damping_ratio(restitution)).powf(0.8)
}

/// Duration of a damped Hertz contact relative to the elastic one, 0 < e <= 1.
///
/// From the same substitution t_c = (4/5) ∫ y^(−1/5) ds over half a period of
/// y = (v/ω) e^(−ζ ω₀ s) sin ω s. The integral ∫₀^π e^(aφ) sin^(−1/5) φ dφ with a = ζ/(5 √(1−ζ²)) is a
/// Beta function of complex arguments (Gradshteyn & Ryzhik 3.892.1), whose ratio to the elastic one is
/// e^(aπ/2) Γ(p)²/|Γ(p + iq)|², p = 9/10, q = a/2, that is, e^(aπ/2) ∏ₙ (1 + q²/(p+n)²).
pub fn hertz_duration_ratio(restitution: f64) -> f64 {
    let zeta = damping_ratio(restitution);
    let a = slope(zeta) / 5.0;
    let (p, q) = (0.9, 0.5 * a);
    let terms = 1000;
    let product: f64 = (0..terms)
        .map(|n| 1.0 + (q / (p + f64::from(n))).powi(2))
        .product();
    // The terms left out: their logarithms sum to q²/(p + terms − 1/2), to order terms⁻³.
    let rest = (q * q / (p + f64::from(terms) - 0.5)).exp();
    (1.0 - zeta * zeta).powf(-0.4) * (a * FRAC_PI_2).exp() * product * rest
}

/// Restitution of the plastic law without dashpot, for an approach at `speed` from a fresh contact.
/// `depth` is φ 2R* \[m\]. Valid while the largest overlap stays below δ*, else NaN.
///
/// Energy balance: k₁ δ_m² comes in; k₁ δ_m (δ_m − δ₀) is given back by unloading to δ₀, and
/// cohesion takes back k_c δ_min δ₀, with δ_min = (k₂−k₁)/(k₂+k_c) δ_m (Luding 2008).
pub fn plastic_restitution(
    loading_stiffness: f64,
    unloading_stiffness: f64,
    cohesion_stiffness: f64,
    depth: f64,
    mass: f64,
    speed: f64,
) -> f64 {
    let (k1, k2_max, kc) = (loading_stiffness, unloading_stiffness, cohesion_stiffness);
    let largest = speed * (mass / k1).sqrt();
    let star = k2_max / (k2_max - k1) * depth;
    if largest > star {
        return f64::NAN;
    }
    let k2 = k1 + (k2_max - k1) * largest / star;
    let zero = (1.0 - k1 / k2) * largest;
    let least = (k2 - k1) / (k2 + kc) * largest;
    let given_back = k1 * largest * (largest - zero) - kc * least * zero;
    (given_back.max(0.0) / (k1 * largest * largest)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(value: f64, expected: f64, tolerance: f64) {
        let error = (value - expected).abs();
        assert!(
            error <= tolerance,
            "{value} instead of {expected}: off by {error:e}"
        );
    }

    #[test]
    fn linear_collision_of_unequal_masses() {
        let (stiffness, dissipation) = (12496.02677090382, 17.83374719693662);
        near(
            linear_contact_time(stiffness, dissipation, 0.5),
            0.02,
            1e-15,
        );
        near(linear_restitution(stiffness, dissipation, 0.5), 0.7, 1e-13);
        near(
            linear_contact_time(stiffness, dissipation, 0.75),
            0.0244424440946,
            1e-13,
        );
        near(
            linear_restitution(stiffness, dissipation, 0.75),
            0.7478145602066,
            1e-13,
        );
        near(
            linear_largest_overlap(stiffness, dissipation, 0.5, 1.0),
            0.005360707863247,
            1e-15,
        );
        let time = linear_time_of_largest_overlap(stiffness, dissipation, 0.5);
        near(time, 0.00928030711972, 1e-14);
        near(damping_ratio(0.7), 0.1128084506936, 1e-13);
    }

    #[test]
    fn clamping_raises_the_restitution() {
        let table = [
            (0.9, 0.9020260687),
            (0.8, 0.8080993353),
            (0.7, 0.7182013610075),
            (0.6, 0.6322905164),
            (0.5, 0.5502831696),
            (0.3, 0.3971404999),
            (0.1, 0.2527293796),
        ];
        for (nominal, clamped) in table {
            near(clamped_restitution(damping_ratio(nominal)), clamped, 1e-10);
            near(clamped_damping_ratio(clamped), damping_ratio(nominal), 1e-9);
        }
    }

    #[test]
    fn the_clamped_restitution_can_be_inverted() {
        let table = [
            (0.9, 0.8978874399, 0.0766193257),
            (0.7, 0.6791937155, 0.2732804839),
            (0.5, 0.4362877627, 0.5708136788),
            (0.3, 0.1652189766, 1.1118610876),
        ];
        for (wanted, nominal, beta) in table {
            let zeta = clamped_damping_ratio(wanted);
            near(restitution_of(zeta), nominal, 1e-10);
            near(5.0f64.sqrt() * zeta, beta, 1e-10);
        }
        assert!(clamped_damping_ratio(0.1).is_nan());
    }

    #[test]
    fn damped_hertz_collisions() {
        let table = [
            (0.95, 0.03650378, 1.005255, 0.9799007),
            (0.9, 0.07494953, 1.011068, 0.9595942),
            (0.8, 0.15842609, 1.024725, 0.9183028),
            (0.7, 0.25224736, 1.041892, 0.8759887),
            (0.5, 0.48176926, 1.093369, 0.7874709),
            (0.3, 0.80019287, 1.194866, 0.6911585),
            (0.1, 1.32186284, 1.510660, 0.5768492),
        ];
        for (restitution, beta, duration, overlap) in table {
            near(hertz_damping(restitution), beta, 0.6e-8);
            near(hertz_duration_ratio(restitution), duration, 0.6e-6);
            near(hertz_overlap_ratio(restitution), overlap, 0.6e-7);
        }
    }

    #[test]
    fn elastic_hertz_collisions() {
        let (modulus, mass) = (5494505.494505494, 0.001308996938995747);
        near(hertz_force(modulus, 0.0025, 1e-5), 0.01158343465263, 1e-14);
        near(hertz_force(modulus, 0.005, 1e-5), 0.01638145038461, 1e-14);
        near(
            hertz_largest_overlap(modulus, 0.5 * mass, 0.0025, 0.2),
            9.559089210180e-5,
            1e-16,
        );
        near(
            hertz_contact_time(modulus, 0.5 * mass, 0.0025, 0.2),
            1.406751502853e-3,
            1e-14,
        );
        near(
            hertz_largest_force(modulus, 0.5 * mass, 0.0025, 0.2),
            0.3423435303862,
            1e-12,
        );
        near(
            hertz_contact_time(modulus, mass, 0.005, 0.2),
            1.615933137217e-3,
            1e-14,
        );
        near(
            hertz_largest_force(modulus, mass, 0.005, 0.2),
            0.5960547064370,
            1e-12,
        );
    }

    #[test]
    fn plastic_collisions() {
        near(
            plastic_restitution(1e4, 2e4, 0.0, 0.025, 0.5, 2.0),
            0.8829036135323,
            1e-13,
        );
        near(
            plastic_restitution(1e4, 2e4, 5e3, 0.025, 0.5, 2.0),
            0.8729429795759,
            1e-13,
        );
        assert!(plastic_restitution(1e4, 2e4, 5e3, 0.025, 0.5, 20.0).is_nan());
    }
}
