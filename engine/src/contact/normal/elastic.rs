//! Elasticity of two bodies: E* and G*, and the keys by which scenes give E*.

use std::f64::consts::PI;

use mercury_common::scene::{Key, Mixing, Range};

use crate::contact::mixing::Pair;
use crate::contact::parameter::Origin;

/// E* of two materials given as (E, nu): 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2, Pa.
#[must_use]
pub fn effective_modulus(one: (f64, f64), other: (f64, f64)) -> f64 {
    1.0 / ((1.0 - one.1 * one.1) / one.0 + (1.0 - other.1 * other.1) / other.0)
}

/// G* of two materials given as (E, nu): 1/G* = (2 - nu1)/G1 + (2 - nu2)/G2, G = E/(2 (1 + nu)), Pa.
#[must_use]
pub fn effective_shear_modulus(one: (f64, f64), other: (f64, f64)) -> f64 {
    let compliance = |(e, nu): (f64, f64)| (2.0 - nu) * 2.0 * (1.0 + nu) / e;
    1.0 / (compliance(one) + compliance(other))
}

/// Rayleigh time of a sphere (s), pi R sqrt(rho/G) / (0.1631 nu + 0.8766) (Thornton 2015): how long a
/// surface wave needs round half of it.
#[must_use]
pub fn rayleigh_time(radius: f64, density: f64, youngs_modulus: f64, poisson_ratio: f64) -> f64 {
    let shear_modulus = youngs_modulus / (2.0 * (1.0 + poisson_ratio));
    PI * radius * (density / shear_modulus).sqrt() / (0.1631 * poisson_ratio + 0.8766)
}

const MIXING: Mixing = Mixing::Derived("by the elasticity of the two bodies");

/// The keys of [`modulus_of`], for the table of a law.
pub(super) const ELASTIC_KEYS: [Key; 3] = [
    Key::new("youngs_modulus", "Pa", Range::Positive, "E").mixes(MIXING),
    Key::new("poisson_ratio", "", Range::PoissonRatio, "nu").mixes(MIXING),
    Key::new(
        "effective_modulus",
        "Pa",
        Range::Positive,
        "E* of the material with itself",
    )
    .mixes(MIXING),
];

/// Which of them exclude each other.
pub(super) const ELASTIC_CHOICE: &[&[&str]] =
    &[&["youngs_modulus", "poisson_ratio"], &["effective_modulus"]];

/// E* (Pa) of two materials by [`ELASTIC_KEYS`], and where it comes from; errors are recorded in the pair.
pub(super) fn modulus_of(pair: &mut Pair<'_>) -> Option<(f64, Origin)> {
    let (over_e, over_nu) = (pair.over("youngs_modulus"), pair.over("poisson_ratio"));
    let constants = pair.elastic_constants();
    let typed = pair.sides("effective_modulus");
    let like_like =
        [0, 1].map(|i| typed[i].or_else(|| constants[i].map(|one| effective_modulus(one, one))));
    let exact = match elastic_pair(constants, over_e, over_nu) {
        Some([a, b]) => Some(effective_modulus(a, b)),
        None if over_e.is_some() || over_nu.is_some() => {
            let message = format!(
                "E* of the contacts of {} is incomplete: youngs_modulus and poisson_ratio go together",
                pair.name()
            );
            pair.error(message, "give both, or effective_modulus".to_owned());
            return None;
        }
        None => None,
    };
    match (pair.over("effective_modulus"), exact) {
        (None, Some(exact)) if over_e.is_some() || over_nu.is_some() => {
            Some((exact, pair.contact_origin()))
        }
        (None, Some(exact)) => Some((exact, pair.mixed_origin(constants.map(|c| c.is_some())))),
        (modulus, _) => pair.need("effective_modulus", modulus, like_like),
    }
}

/// (E, nu) of both bodies: what is replaced counts for both; a body without constants is like the other one.
pub(crate) fn elastic_pair(
    sides: [Option<(f64, f64)>; 2],
    over_e: Option<f64>,
    over_nu: Option<f64>,
) -> Option<[(f64, f64); 2]> {
    let side = |own: Option<(f64, f64)>| {
        let e = over_e.or(own.map(|c| c.0))?;
        Some((e, over_nu.or(own.map(|c| c.1))?))
    };
    match sides.map(side) {
        [Some(a), Some(b)] => Some([a, b]),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moduli_mix_as_the_theory_says() {
        // contact-model case T18
        let (soft, steel) = ((1e7, 0.3), (210e9, 0.25));
        assert!((effective_modulus(soft, steel) / 10988471.91562423 - 1.0).abs() < 1e-14);
        assert!((effective_shear_modulus(soft, steel) / 2262336.80539190 - 1.0).abs() < 1e-14);
        assert!((effective_shear_modulus(soft, soft) / 1131221.719457014 - 1.0).abs() < 1e-14);
        // the harmonic mean of the like-like moduli is the same thing
        let mean = |a: f64, b: f64| 2.0 / (1.0 / a + 1.0 / b);
        let like = mean(
            effective_modulus(soft, soft),
            effective_modulus(steel, steel),
        );
        assert!((like / effective_modulus(soft, steel) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn the_rayleigh_time_has_its_tabulated_value() {
        let time = rayleigh_time(5e-3, 2500.0, 1e7, 0.3);
        assert!((time / 4.326991627612e-4 - 1.0).abs() < 1e-12);
    }
}
