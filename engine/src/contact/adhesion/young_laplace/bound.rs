//! One bridge as a few numbers: force, energy and end, cheap over the gap.

use crate::lanes::Real;

/// Coefficients of the polynomial.
pub(super) const COEFFICIENTS: usize = 12;

/// How many numbers a [`Bound`] holds.
pub const NUMBERS: usize = COEFFICIENTS + 3;

/// The force of one bridge of a known volume over the gap, or of several in lanes.
///
/// The way to the end, t = sqrt(1 - s/s_end), is 1 at the touch and 0 at the end; the force is a smooth function of it. With
///
/// ```text
/// D = 1/(1 + m (1 - t)),   x = t D,   F = D^3 (f_0 + f_1 x + ... + f_11 x^11)
/// ```
///
/// the integral of F from a gap to the end has a closed form, as ds = -2 s_end t dt and dx = (1 + m) D^2 dt:
///
/// ```text
/// U = -2 s_end/(1 + m) x^2 (f_0/2 + f_1 x/3 + ... + f_11 x^11/13),   dU/ds = F.
/// ```
///
/// In contact (a gap below 0) the force is that of the touch, and beyond the end there is none. Made by [`Table::bind`](super::Table::bind) in the units
/// of the [module](super); [`Bound::scaled`] gives it other ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound<L: Real = f64> {
    /// Gap at the end of the stable branch.
    pub end: L,
    per_end: L,
    stretch: L,
    coefficients: [L; COEFFICIENTS],
}

impl Bound {
    /// No bridge: it ends at the touch and pulls nowhere.
    pub const NONE: Self = Self {
        end: 0.0,
        per_end: 0.0,
        stretch: 0.0,
        coefficients: [0.0; COEFFICIENTS],
    };

    pub(super) fn new(end: f64, stretch: f64, coefficients: [f64; COEFFICIENTS]) -> Self {
        Self {
            end,
            per_end: 1.0 / end,
            stretch,
            coefficients,
        }
    }

    /// This bridge in other units: gaps times `length`, forces times `force`, energies times both. With R_D and gamma R_D, gaps
    /// are in m, forces in N and energies in J.
    #[must_use]
    pub fn scaled(self, length: f64, force: f64) -> Self {
        Self {
            end: self.end * length,
            per_end: self.per_end / length,
            stretch: self.stretch,
            coefficients: self.coefficients.map(|f| f * force),
        }
    }
}

impl Default for Bound {
    fn default() -> Self {
        Self::NONE
    }
}

impl<L: Real> Bound<L> {
    /// The bridge `one(k)` in lane `k`.
    #[inline(always)]
    #[must_use]
    pub fn gather<'a>(one: impl Fn(usize) -> &'a Bound) -> Self {
        let mut coefficients = [L::ZERO; COEFFICIENTS];
        for (n, coefficient) in coefficients.iter_mut().enumerate() {
            *coefficient = L::from_lanes(|k| one(k).coefficients[n]);
        }
        Self {
            end: L::from_lanes(|k| one(k).end),
            per_end: L::from_lanes(|k| one(k).per_end),
            stretch: L::from_lanes(|k| one(k).stretch),
            coefficients,
        }
    }

    /// The bridge in lane `k`.
    #[inline(always)]
    #[must_use]
    pub fn lane(&self, k: usize) -> Bound {
        let mut coefficients = [0.0; COEFFICIENTS];
        for (n, coefficient) in coefficients.iter_mut().enumerate() {
            *coefficient = self.coefficients[n].lane(k);
        }
        Bound {
            end: self.end.lane(k),
            per_end: self.per_end.lane(k),
            stretch: self.stretch.lane(k),
            coefficients,
        }
    }

    /// All of its numbers.
    #[inline(always)]
    #[must_use]
    pub fn to_array(&self) -> [L; NUMBERS] {
        let mut numbers = [self.end; NUMBERS];
        numbers[1] = self.per_end;
        numbers[2] = self.stretch;
        numbers[3..].copy_from_slice(&self.coefficients);
        numbers
    }

    /// From the numbers of [`Bound::to_array`].
    #[inline(always)]
    #[must_use]
    pub fn from_array(numbers: [L; NUMBERS]) -> Self {
        let mut coefficients = [L::ZERO; COEFFICIENTS];
        coefficients.copy_from_slice(&numbers[3..]);
        Self {
            end: numbers[0],
            per_end: numbers[1],
            stretch: numbers[2],
            coefficients,
        }
    }

    /// D and x.
    #[inline(always)]
    fn place(&self, gap: L) -> (L, L) {
        let left = L::ONE - gap.max(L::ZERO) * self.per_end;
        let t = left.max(L::ZERO).sqrt();
        let d = L::ONE / (self.stretch * (L::ONE - t) + 1.0);
        (d, t * d)
    }

    /// Pull at a gap; negative where the bridge pushes.
    #[inline(always)]
    #[must_use]
    pub fn force(&self, gap: L) -> L {
        let (d, x) = self.place(gap);
        // even and odd powers apart: two chains of half the length
        let square = x * x;
        let (mut even, mut odd) = (L::ZERO, L::ZERO);
        let mut k = COEFFICIENTS;
        while k > 0 {
            k -= 2;
            even = even * square + self.coefficients[k];
            odd = odd * square + self.coefficients[k + 1];
        }
        let force = d * d * d * (even + odd * x);
        L::select(self.end.at_most(gap), L::ZERO, force)
    }

    /// Energy at a gap: minus the work that it takes to pull the bridge from there to its end, where it is 0. Its derivative by the
    /// gap is the pull, in contact too.
    #[inline(always)]
    #[must_use]
    pub fn energy(&self, gap: L) -> L {
        let (_, x) = self.place(gap);
        let mut sum = L::ZERO;
        for (k, &coefficient) in self.coefficients.iter().enumerate().rev() {
            sum = sum * x + coefficient / (k as f64 + 2.0);
        }
        let over_gap = self.end * -2.0 / (self.stretch + 1.0) * (x * x) * sum;
        let energy = over_gap + self.force(gap) * gap.min(L::ZERO);
        L::select(self.end.at_most(gap), L::ZERO, energy)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Table;
    use super::super::meridian::GAUSS;
    use super::*;
    use crate::lanes::Lanes;

    fn bridges() -> Vec<Bound> {
        let table = Table::new(0.3, (1e-4, 1e-3), (0.2, 0.2), 1e-3).unwrap();
        [1e-4, 2.3e-4, 1e-3]
            .map(|volume| table.bind(volume, 0.2).bound)
            .to_vec()
    }

    #[test]
    fn the_force_is_the_derivative_of_the_energy() {
        for bound in bridges() {
            // the integral of the force over t, s = end (1 - t^2), by Gauss in panels: exact to round-off
            let panels = 16;
            let mut sum = 0.0;
            for panel in 0..panels {
                for (point, weight) in GAUSS.iter() {
                    let t = (f64::from(panel) + point) / f64::from(panels);
                    let force = bound.force(bound.end * (1.0 - t * t));
                    sum += weight / f64::from(panels) * 2.0 * bound.end * t * force;
                }
                let t = f64::from(panel + 1) / f64::from(panels);
                let energy = bound.energy(bound.end * (1.0 - t * t));
                // gaps are rounded to 1e-16 of the end, which moves t by 1e-16/t; the coefficients, of both signs, add up to some
                // thousand times the force
                let tolerance = 1e-11 * sum;
                assert!((energy + sum).abs() < tolerance, "{t}: {energy} {sum}");
            }
            assert_eq!(bound.energy(bound.end), 0.0);
            assert_eq!(bound.energy(2.0 * bound.end), 0.0);
        }
    }

    #[test]
    fn in_contact_the_force_is_that_of_the_touch_and_beyond_the_end_there_is_none() {
        for bound in bridges() {
            let touch = bound.force(0.0);
            assert_eq!(bound.force(-0.1), touch);
            let energy = bound.energy(0.0) - 0.1 * touch;
            assert!((bound.energy(-0.1) / energy - 1.0).abs() < 1e-15);
            assert_eq!(bound.force(bound.end), 0.0);
            assert_eq!(bound.force(1.0), 0.0);
            assert!(bound.force(0.999 * bound.end) > 0.0);
        }
        for gap in [-1.0, 0.0, 1.0] {
            assert_eq!(
                (Bound::NONE.force(gap), Bound::NONE.energy(gap)),
                (0.0, 0.0)
            );
        }
    }

    #[test]
    fn lanes_get_the_bits_of_single_bridges() {
        let bridges = bridges();
        let lanes = Bound::<Lanes<4>>::gather(|k| &bridges[k % 3]);
        let gaps = Lanes::from_lanes(|k| [0.01, 0.03, -1e-3, 0.9][k]);
        let (force, energy) = (lanes.force(gaps), lanes.energy(gaps));
        for k in 0..4 {
            let (bound, gap) = (bridges[k % 3], gaps.lane(k));
            assert_eq!(lanes.lane(k), bound);
            assert_eq!(force.lane(k).to_bits(), bound.force(gap).to_bits());
            assert_eq!(energy.lane(k).to_bits(), bound.energy(gap).to_bits());
        }
    }

    #[test]
    fn other_units_scale_gaps_forces_and_energies() {
        // powers of two: exact
        let (length, force) = (0.25, 8.0);
        for bound in bridges() {
            let scaled = bound.scaled(length, force);
            assert_eq!(scaled.end, length * bound.end);
            for gap in [-0.01, 0.0, 0.3 * bound.end] {
                let (own, other) = (bound.force(gap), bound.energy(gap));
                assert_eq!(scaled.force(length * gap), force * own);
                assert_eq!(scaled.energy(length * gap), length * force * other);
            }
        }
    }
}
