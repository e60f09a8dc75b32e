//! Repulsion along the normal: linear, Hertz, and the hysteretic law of Luding.

use mercury_engine::contact::AnyNormal;

use super::Kinematics;

/// A normal force law, F_n = elastic force − damping · u_n.
#[derive(Debug, Clone, Copy)]
pub enum Normal {
    /// Spring and dashpot: F_n = k δ − γ u_n (Cundall & Strack 1979).
    Linear {
        /// k \[N/m\].
        stiffness: f64,
        /// The dashpot.
        damping: LinearDamping,
    },
    /// Elastic spheres: F_n = k_n δ − β √(m* k_n) u_n with the secant stiffness
    /// k_n = (4/3) E* √(R* δ) (Hertz 1882; Antypov & Elliott 2011: the restitution does not depend
    /// on the velocity).
    Hertz {
        /// E* \[Pa\].
        effective_modulus: f64,
        /// β ≥ 0.
        damping: f64,
    },
    /// Loads softly, unloads stiffly, may hold together (Luding 2008).
    Plastic {
        /// k₁ \[N/m\].
        loading_stiffness: f64,
        /// k₂max ≥ k₁, the largest unloading stiffness \[N/m\].
        unloading_stiffness: f64,
        /// k_c ≥ 0 \[N/m\].
        cohesion_stiffness: f64,
        /// φ, the depth at which k₂max is reached, in units of 2 R*.
        penetration_depth: f64,
        /// γ \[kg/s\].
        dissipation: f64,
    },
}

/// The dashpot of the linear law.
#[derive(Debug, Clone, Copy)]
pub enum LinearDamping {
    /// γ \[kg/s\], whatever the masses.
    Dissipation(f64),
    /// ζ: each contact takes γ = 2 ζ √(m* k), so that the restitution does not depend on the masses.
    Ratio(f64),
}

impl Normal {
    /// With the parameters of a law of the engine: all that the two have in common.
    pub fn of(law: &AnyNormal) -> Self {
        match *law {
            AnyNormal::Linear(law) => Self::Linear {
                stiffness: law.stiffness,
                damping: if law.damping_ratio > 0.0 {
                    LinearDamping::Ratio(law.damping_ratio)
                } else {
                    LinearDamping::Dissipation(law.dissipation)
                },
            },
            AnyNormal::Hertz(law) => Self::Hertz {
                effective_modulus: law.effective_modulus,
                damping: law.damping,
            },
            AnyNormal::Plastic(law) => Self::Plastic {
                loading_stiffness: law.loading_stiffness,
                unloading_stiffness: law.unloading_stiffness,
                cohesion_stiffness: law.cohesion_stiffness,
                penetration_depth: law.penetration_depth,
                dissipation: law.dissipation,
            },
        }
    }

    /// Normal force F_n \[N\] and stored energy \[J\].
    pub(super) fn evaluate(
        &self,
        kinematics: &Kinematics,
        clamp_tension: bool,
        largest_overlap: &mut f64,
    ) -> (f64, f64) {
        let overlap = kinematics.overlap;
        let mass = kinematics.effective_mass;
        let (elastic, damping, energy) = match *self {
            Normal::Linear { stiffness, damping } => {
                let gamma = match damping {
                    LinearDamping::Dissipation(gamma) => gamma,
                    LinearDamping::Ratio(zeta) => 2.0 * zeta * (mass * stiffness).sqrt(),
                };
                (
                    stiffness * overlap,
                    gamma,
                    0.5 * stiffness * overlap * overlap,
                )
            }
            Normal::Hertz {
                effective_modulus,
                damping,
            } => {
                let secant = 4.0 / 3.0 * effective_modulus * kinematics.contact_radius();
                let gamma = damping * (mass * secant).sqrt();
                // ∫ F dδ = (2/5) F δ, since F grows as δ^(3/2).
                (secant * overlap, gamma, 0.4 * secant * overlap * overlap)
            }
            Normal::Plastic {
                loading_stiffness,
                unloading_stiffness,
                cohesion_stiffness,
                penetration_depth,
                dissipation,
            } => {
                let (elastic, energy) = plastic(
                    loading_stiffness,
                    unloading_stiffness,
                    cohesion_stiffness,
                    penetration_depth * 2.0 * kinematics.effective_radius,
                    overlap,
                    largest_overlap,
                );
                (elastic, dissipation, energy)
            }
        };
        let force = elastic - damping * kinematics.normal_velocity();
        let floor = if clamp_tension {
            elastic.min(0.0)
        } else {
            f64::NEG_INFINITY
        };
        (force.max(floor), energy)
    }
}

/// Force and releasable energy of the hysteretic spring. `depth` = φ 2R*.
///
/// Three branches in the plane of overlap and force: loading along k₁ δ, un- and reloading along
/// k₂ (δ − δ₀), and cohesion along −k_c δ. k₂ grows with the largest overlap δ_m until it reaches
/// k₂max at δ*; from there on loading, too, follows k₂max.
fn plastic(
    k1: f64,
    k2_max: f64,
    kc: f64,
    depth: f64,
    overlap: f64,
    largest_overlap: &mut f64,
) -> (f64, f64) {
    if k2_max <= k1 {
        return (k1 * overlap, 0.5 * k1 * overlap * overlap); // δ* is infinite: never plastic
    }
    if depth <= 0.0 {
        return (k2_max * overlap, 0.5 * k2_max * overlap * overlap); // δ* is zero: stiff at once
    }
    let overlap_star = k2_max / (k2_max - k1) * depth;
    if overlap > *largest_overlap {
        *largest_overlap = overlap.min(overlap_star);
    }
    let k2 = k1 + (k2_max - k1) * *largest_overlap / overlap_star;
    let overlap_0 = (1.0 - k1 / k2) * *largest_overlap;
    let force = k2 * (overlap - overlap_0);
    let energy = 0.5 * k2 * (overlap - overlap_0).max(0.0).powi(2);
    if force < -kc * overlap {
        // On the cohesion branch the contact forgets: reloading starts from here.
        *largest_overlap = (k2 + kc) / (k2 - k1) * overlap;
        return (-kc * overlap, energy);
    }
    (force, energy)
}
