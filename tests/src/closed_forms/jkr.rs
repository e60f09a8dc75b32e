//! Dry cohesion of two spheres: the curve of Johnson, Kendall & Roberts (1971) by bisection, its energies by quadrature; DMT and van der Waals.

use std::f64::consts::PI;

/// Simpson's rule over this many intervals.
const INTERVALS: u32 = 2000;

/// ∫ f from `low` to `high`.
fn integral(low: f64, high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let step = (high - low) / f64::from(INTERVALS);
    let weighted = |k: u32| {
        let weight = match k {
            0 | INTERVALS => 1.0,
            k if k % 2 == 1 => 4.0,
            _ => 2.0,
        };
        weight * f(low + step * f64::from(k))
    };
    (0..=INTERVALS).map(weighted).sum::<f64>() * step / 3.0
}

/// A contact of two elastic spheres that adhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jkr {
    /// Work of adhesion W \[J/m²\], twice the surface energy of like surfaces.
    pub work: f64,
    /// R*, 1/R* = 1/R_A + 1/R_B \[m\].
    pub radius: f64,
    /// E* \[Pa\].
    pub modulus: f64,
}

impl Jkr {
    /// δ = a²/R* - √(2πWa/E*) \[m\] of a radius of contact `a` \[m\].
    pub fn overlap(&self, a: f64) -> f64 {
        a * a / self.radius - (2.0 * PI * self.work * a / self.modulus).sqrt()
    }

    /// F = 4E*a³/(3R*) - √(8πWE*a³) \[N\] of a radius of contact `a` \[m\]; positive where the spheres repel each other.
    pub fn force(&self, a: f64) -> f64 {
        let cube = a * a * a;
        4.0 * self.modulus * cube / (3.0 * self.radius)
            - (8.0 * PI * self.work * self.modulus * cube).sqrt()
    }

    /// Radius of contact at the touch, δ = 0: a³ = 2πWR*²/E* \[m\].
    pub fn radius_at_touch(&self) -> f64 {
        (2.0 * PI * self.work * self.radius * self.radius / self.modulus).cbrt()
    }

    /// Radius of contact at which the spheres part, where dδ/da = 0: a³ = πWR*²/(8E*) \[m\].
    pub fn radius_at_end(&self) -> f64 {
        (PI * self.work * self.radius * self.radius / (8.0 * self.modulus)).cbrt()
    }

    /// Gap at which the spheres part, 3a²/R* with a of [`radius_at_end`](Self::radius_at_end) \[m\].
    pub fn longest_gap(&self) -> f64 {
        let a = self.radius_at_end();
        3.0 * a * a / self.radius
    }

    /// Largest pull, 3πWR*/2 \[N\].
    pub fn pull_off(&self) -> f64 {
        1.5 * PI * self.work * self.radius
    }

    /// Energy \[J\] that a contact of radius `a` \[m\] can give back: ∫F (dδ/da) da from a = 0, term by term.
    pub fn energy(&self, a: f64) -> f64 {
        let (work, modulus, radius) = (self.work, self.modulus, self.radius);
        let square = a * a;
        8.0 / 15.0 * modulus * square * square * a / (radius * radius)
            - 4.0 / 3.0 * (2.0 * PI * work * modulus * a).sqrt() * square * a / radius
            + PI * work * square
    }

    /// Radius \[m\] of the contact of spheres that have touched, at an overlap `delta` \[m\]; none beyond the longest gap.
    pub fn radius_at(&self, delta: f64) -> Option<f64> {
        let mut low = self.radius_at_end();
        if delta < self.overlap(low) {
            return None;
        }
        // On the larger root δ grows with a.
        let mut high = 2.0 * self.radius_at_touch() + 2.0 * (self.radius * delta.abs()).sqrt();
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if self.overlap(middle) < delta {
                low = middle;
            } else {
                high = middle;
            }
        }
        Some(0.5 * (low + high))
    }

    /// Force \[N\] of spheres that have touched, at an overlap `delta` \[m\]; none beyond the longest gap.
    pub fn force_at(&self, delta: f64) -> Option<f64> {
        self.radius_at(delta).map(|a| self.force(a))
    }

    /// Energy \[J\] that a touch and a parting lose: -∫F dδ from the longest gap to the touch.
    pub fn lost(&self) -> f64 {
        let slope =
            |a: f64| 2.0 * a / self.radius - (0.5 * PI * self.work / (self.modulus * a)).sqrt();
        let power = |a: f64| -self.force(a) * slope(a);
        integral(self.radius_at_end(), self.radius_at_touch(), power)
    }

    /// Speed \[m/s\] below which a collision of effective mass `mass` \[kg\] ends bonded, without other losses: √(2W_s/m*).
    pub fn sticking_speed(&self, mass: f64) -> f64 {
        (2.0 * self.lost() / mass).sqrt()
    }

    /// Restitution of a collision at `speed` \[m/s\], 0 where the spheres stick.
    pub fn restitution(&self, mass: f64, speed: f64) -> f64 {
        let share = self.sticking_speed(mass) / speed;
        (1.0 - share * share).max(0.0).sqrt()
    }
}

/// Pull \[N\] of Derjaguin, Muller & Toporov (1975) while spheres touch: 2πWR*.
pub fn dmt_pull(work: f64, radius: f64) -> f64 {
    2.0 * PI * work * radius
}

/// Attraction of van der Waals, moved so that it ends at zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VanDerWaals {
    /// Hamaker's constant A \[J\].
    pub hamaker: f64,
    /// Least separation z₀ \[m\].
    pub separation: f64,
    /// Gap beyond which nothing acts \[m\].
    pub range: f64,
    /// R* \[m\].
    pub radius: f64,
}

impl VanDerWaals {
    /// Pull \[N\] at a gap \[m\], that of the touch where spheres overlap: A R*/6 (1/(z₀ + s)² - 1/(z₀ + range)²).
    pub fn pull(&self, gap: f64) -> f64 {
        let gap = gap.max(0.0);
        if gap >= self.range {
            return 0.0;
        }
        let square = |x: f64| x * x;
        let (near, far) = (self.separation + gap, self.separation + self.range);
        self.hamaker * self.radius / 6.0 * (1.0 / square(near) - 1.0 / square(far))
    }

    /// Work \[J\] of the pull from a gap \[m\] to the range, by quadrature over ln(z₀ + s).
    pub fn work_from(&self, gap: f64) -> f64 {
        let ends = [gap, self.range].map(|s| (self.separation + s).ln());
        let distance = |x: f64| x.exp();
        integral(ends[0], ends[1], |x| {
            // Round-off of the logarithm must not carry the end past the range.
            self.pull((distance(x) - self.separation).min(self.range)) * distance(x)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Case T28: E = 1e8 Pa and ν = 0.3 of both spheres, W = 0.05 J/m².
    fn t28(radius: f64) -> Jkr {
        Jkr {
            work: 0.05,
            radius,
            modulus: 1e8 / (2.0 * (1.0 - 0.09)),
        }
    }

    fn is_near(found: f64, expected: f64) {
        // Ten digits are given.
        assert!(
            (found / expected - 1.0).abs() < 1e-9,
            "{found:e} {expected:e}"
        );
    }

    #[test]
    fn the_curve_has_the_numbers_of_case_t28() {
        let pair = t28(5e-5);
        is_near(pair.modulus, 54_945_054.945);
        is_near(pair.pull_off(), 1.178_097_245e-5);
        is_near(pair.longest_gap(), 5.565_601_510e-8);
        is_near(pair.force(pair.radius_at_end()), -6.544_984_695e-6);
        is_near(pair.radius_at_touch(), 2.426_910_477e-6);
        is_near(pair.force_at(0.0).unwrap(), -1.047_197_551e-5);
        is_near(pair.force_at(1e-7).unwrap(), 7.517_437_405e-6);
        is_near(pair.force_at(-2.782_800_755e-8).unwrap(), -1.177_828_222e-5);
        assert_eq!(pair.force_at(-5.565_602e-8), None);
        let wall = t28(1e-4);
        is_near(wall.pull_off(), 2.356_194_49e-5);
        is_near(wall.longest_gap(), 7.012_218_498e-8);
        is_near(wall.force_at(1e-7).unwrap(), 5.201_488_973e-6);
    }

    #[test]
    fn the_curve_has_its_largest_pull_and_its_end_where_theory_has_them() {
        let pair = t28(5e-5);
        let end = pair.radius_at_end();
        // F(δ_f) = -5/9 F_c, F(0) = -8/9 F_c.
        is_near(pair.force(end), -5.0 / 9.0 * pair.pull_off());
        is_near(
            pair.force(pair.radius_at_touch()),
            -8.0 / 9.0 * pair.pull_off(),
        );
        is_near(pair.overlap(end), -pair.longest_gap());
        let radii = (0..=100_000).map(|k| end * (1.0 + f64::from(k) * 2e-5));
        let least = radii.map(|a| pair.force(a)).fold(f64::MAX, f64::min);
        is_near(least, -pair.pull_off());
    }

    #[test]
    fn energies_have_the_numbers_of_case_t28() {
        is_near(t28(5e-5).lost(), 6.133_923_178e-13);
        let pair = t28(5e-5);
        let [end, touch] = [pair.radius_at_end(), pair.radius_at_touch()].map(|a| pair.energy(a));
        is_near(end - touch, pair.lost());
        let wall = t28(1e-4);
        is_near(wall.lost(), 1.545_651_786e-12);
        // W_s = 7.0922 (W⁵ R*⁴/E*²)^(1/3), to the five digits that are given.
        let fifth = wall.work * wall.work * wall.work * wall.work * wall.work;
        let fourth = wall.radius * wall.radius * wall.radius * wall.radius;
        let scale = (fifth * fourth / (wall.modulus * wall.modulus)).cbrt();
        assert!((wall.lost() / scale - 7.0922).abs() < 5e-5);
        // A sphere of R = 0.1 mm and 1500 kg/m³ on a wall.
        let mass = 1500.0 * 4.0 / 3.0 * PI * 1e-12;
        // Eight digits are given.
        assert!((wall.sticking_speed(mass) - 0.022_180_988).abs() < 5e-10);
        assert_eq!(wall.restitution(mass, 0.022), 0.0);
        // e(√2 v_s) = √(1/2).
        let speed = std::f64::consts::SQRT_2 * wall.sticking_speed(mass);
        is_near(wall.restitution(mass, speed), 0.5f64.sqrt());
    }

    #[test]
    fn dmt_and_van_der_waals_have_the_numbers_of_case_t29() {
        is_near(dmt_pull(0.05, 7.5e-5), 2.356_194_490e-5);
        let law = VanDerWaals {
            hamaker: 6.5e-20,
            separation: 4e-10,
            range: 1e-8,
            radius: 7.5e-5,
        };
        is_near(law.pull(0.0), 5.070_612_981e-6);
        is_near(law.pull(-1e-9), law.pull(0.0));
        is_near(law.pull(2e-9), 1.335_470_086e-7);
        assert_eq!(law.pull(1e-8), 0.0);
        // A R*/6 (1/z₀ - 1/z₁ - range/z₁²), z₁ = z₀ + range.
        let (near, far) = (law.separation, law.separation + law.range);
        let exact =
            law.hamaker * law.radius / 6.0 * (1.0 / near - 1.0 / far - law.range / (far * far));
        is_near(law.work_from(0.0), exact);
    }
}
