//! Numbers that look as if a unit was forgotten: grains of 4 m, a density of 2.5 kg/m3.

use crate::readable::rounded;

/// Grains of this diameter and more are probably given in mm, m. Boulders are not; therefore it is a note.
pub const LARGE: f64 = 1.0;
/// Up to this density, in kg/m3, it is probably given in g/cm3: lead has 11.3 there. The lightest foams in use have 15 kg/m3.
pub const LIGHT: f64 = 12.0;
/// Nothing is denser, kg/m3: osmium has 22,590.
pub const DENSE: f64 = 23_000.0;
/// Domains from this length on are compared with the grains, m.
const LONG: f64 = 10.0;
/// More grains than these along a domain are more than any run has: it is probably given in mm.
const ROW: f64 = 5000.0;

/// A note on numbers that look as if a unit was forgotten, all in SI: the largest diameter (m), densities (kg/m3), the longest edge of the domain (m).
#[must_use]
pub fn forgotten_units(
    diameter: Option<f64>,
    densities: impl IntoIterator<Item = f64>,
    edge: Option<f64>,
) -> Option<String> {
    let large = diameter.filter(|diameter| *diameter >= LARGE);
    let density = (densities.into_iter())
        .find(|&density| density > 0.0 && !(LIGHT..=DENSE).contains(&density));
    let long = edge.filter(|edge| {
        let is_wide = diameter.is_some_and(|diameter| diameter > 0.0 && *edge > ROW * diameter);
        *edge >= LONG && (is_wide || large.is_some() || density.is_some())
    });
    let found: Vec<String> = [
        large.map(|diameter| format!("grains of {} m in diameter", rounded(diameter, 4))),
        density.map(|density| format!("a density of {} kg/m3", rounded(density, 4))),
        long.map(|edge| format!("a domain of {} m", rounded(edge, 4))),
    ]
    .into_iter()
    .flatten()
    .collect();
    (!found.is_empty()).then(|| {
        format!(
            "{}: is a unit missing? Numbers are in m and kg/m3",
            found.join(", ")
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_looks_like_mm_and_g_per_cm3_is_noted_once() {
        let note = |diameter, density, edge| forgotten_units(Some(diameter), [density], Some(edge));
        assert_eq!(
            note(4.0, 2.5, 60.0).unwrap(),
            "grains of 4 m in diameter, a density of 2.5 kg/m3, a domain of 60 m: is a unit missing? Numbers are in m and kg/m3"
        );
        // A number alone.
        assert!(
            note(4e-3, 2.5, 0.06)
                .unwrap()
                .starts_with("a density of 2.5 kg/m3:")
        );
        assert!(
            note(4e-3, 2.5e6, 0.06)
                .unwrap()
                .starts_with("a density of 2500000 kg/m3:")
        );
        assert!(
            note(4.0, 2500.0, 6.0)
                .unwrap()
                .starts_with("grains of 4 m in diameter:")
        );
        // 15,000 grains in a row.
        assert!(
            note(4e-3, 2500.0, 60.0)
                .unwrap()
                .starts_with("a domain of 60 m:")
        );
        // Sand, foam, osmium, a silo of 20 m, dust in air.
        for (diameter, density, edge) in [
            (4e-3, 2500.0, 0.06),
            (4e-3, 15.0, 0.06),
            (4e-3, 22_590.0, 0.06),
            (0.05, 1400.0, 20.0),
            (1e-6, 2500.0, 5.0),
        ] {
            assert_eq!(note(diameter, density, edge), None);
        }
        assert_eq!(forgotten_units(None, [], Some(1e6)), None);
    }
}
