//! T18: effective moduli of unlike materials.

use mercury_engine::contact::normal::{effective_modulus, effective_shear_modulus};

use super::Case;
use super::Tolerance::Relative;

/// Rows of T18.
pub(super) fn cases() -> Vec<Case> {
    const SOFT: (f64, f64) = (1e7, 0.3);
    const STEEL: (f64, f64) = (210e9, 0.25);
    const MEAN: &str = "harmonic mean of the moduli of like pairs";
    let harmonic = |a: f64, b: f64| 2.0 / (1.0 / a + 1.0 / b);
    let (modulus, shear) = (10988471.91562423, 2262336.80539190);
    let near = Relative(1e-12);
    vec![
        Case::new(
            "T18 law: E* of a soft and a steel sphere (Pa)",
            modulus,
            near,
            "Hertz 1882",
            || effective_modulus(SOFT, STEEL),
        ),
        Case::new(
            "T18 law: G* of a soft and a steel sphere (Pa)",
            shear,
            near,
            "Mindlin 1949",
            || effective_shear_modulus(SOFT, STEEL),
        ),
        Case::new(
            "T18 law: E* by mixing (Pa)",
            modulus,
            near,
            MEAN,
            move || {
                harmonic(
                    effective_modulus(SOFT, SOFT),
                    effective_modulus(STEEL, STEEL),
                )
            },
        ),
        Case::new("T18 law: G* by mixing (Pa)", shear, near, MEAN, move || {
            harmonic(
                effective_shear_modulus(SOFT, SOFT),
                effective_shear_modulus(STEEL, STEEL),
            )
        }),
    ]
}
