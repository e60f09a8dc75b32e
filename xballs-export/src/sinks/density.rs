//! Densities from masses and volumes that were written with few digits.
//!
//! LAMMPS dumps write numbers with six significant digits (`%g`) by default, without zeros at the end. A density is their
//! quotient, so of its digits only the first ones mean something: it is the shortest number within what the digits of mass and
//! radius leave open.

use mercury_common::readable::rounded;

use crate::Snapshot;

/// Beyond these there is round-off of a quotient.
const MOST: i32 = 12;
/// Digits that programs write at least. Fewer are there where zeros at the end were left out.
const LEAST: i32 = 6;

/// Number of digits of the masses and radii of a frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Digits(i32);

impl Digits {
    /// Digits of a frame. Programs write all columns alike, so the most that any number has is what the others have, too.
    pub(super) fn of(snapshot: &Snapshot) -> Self {
        let of = |name: &str| snapshot.numbers(name).map_or(MOST, most);
        Self(of("mass").max(of("radius")))
    }

    /// The density of a grain of this mass (kg) and volume (m^3), kg/m^3.
    pub(super) fn density(self, mass: f64, volume: f64) -> f64 {
        let density = mass / volume;
        if self.0 >= MOST || !(density > 0.0 && density.is_finite()) {
            return rounded(density, MOST as usize);
        }
        // The volume goes with the third power of the radius (in two dimensions the second, which is within that).
        let radius = (0.75 / std::f64::consts::PI * volume).cbrt();
        let open = last_place(mass, self.0) + 3.0 * last_place(radius, self.0);
        let candidates = (1..MOST).map(|digits| rounded(density, digits as usize));
        let mut near = candidates.filter(|near| (near - density).abs() <= open * density);
        near.next()
            .unwrap_or_else(|| rounded(density, MOST as usize))
    }
}

/// Half a unit of the last of so many digits, over the number.
fn last_place(number: f64, digits: i32) -> f64 {
    let place = number.abs().log10().floor() as i32 - digits + 1;
    0.5 * 10.0_f64.powi(place) / number.abs()
}

/// The most significant digits of any of these, as they are written shortest.
fn most(numbers: &[f64]) -> i32 {
    let mut most = LEAST;
    for number in numbers {
        let text = format!("{number:e}");
        let mantissa = text.split('e').next().unwrap_or_default();
        let digits = mantissa.bytes().filter(u8::is_ascii_digit).count();
        most = most.max(digits as i32);
        if most >= MOST {
            return MOST;
        }
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;

    fn volume(radius: f64) -> f64 {
        4.0 / 3.0 * std::f64::consts::PI * radius * radius * radius
    }

    #[test]
    fn a_density_has_the_digits_that_its_mass_leaves() {
        // Spheres of 2500 kg/m^3 as %g writes them: six digits.
        let six = Digits(6);
        for radius in [1e-3, 1.23456e-3, 2.71828e-3, 0.05] {
            let exact = 2500.0 * volume(radius);
            let mass: f64 = format!("{exact:.5e}").parse().unwrap();
            assert_eq!(six.density(mass, volume(radius)), 2500.0, "{radius}");
        }
        // Digits that are there are kept: 1 kg at R = 0.5 m.
        let density = six.density(1.0, volume(0.5));
        assert_eq!(density, 1.909_86);
        // Of numbers with all digits nothing but round-off goes.
        let all = Digits(MOST);
        assert_eq!(
            all.density(2_499.999_877_78 * volume(1.1e-3), volume(1.1e-3)),
            2_499.999_877_78
        );
    }

    #[test]
    fn what_is_no_density_is_no_reason_to_panic() {
        for (mass, volume) in [
            (0.0, 1.0),
            (1.0, 0.0),
            (0.0, 0.0),
            (f64::NAN, 1.0),
            (1e-310, 1e-300),
        ] {
            let _ = Digits(6).density(mass, volume);
        }
    }

    #[test]
    fn zeros_that_were_left_out_count() {
        assert_eq!(most(&[1.0, 0.5]), LEAST);
        assert_eq!(most(&[1.0, 1.234_567_8e-7]), 8);
        assert_eq!(most(&[1.0 / 3.0]), MOST);
        assert_eq!(most(&[]), LEAST);
    }
}
