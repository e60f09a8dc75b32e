//! Timoshenko's beam of round section by its stiffness matrix (Przemieniecki 1968, eq. 5.116), and cantilevers of beams between spheres.
//!
//! Written from the matrix alone, without the turning frame of the engine: right for small displacements.

use std::f64::consts::PI;

/// Displacements of both ends: x, y, z and rotations about x, y, z of the one, then of the other.
pub type Displacements = [f64; 12];

/// A straight beam along x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    /// Radius of the section \[m\].
    pub radius: f64,
    /// Length \[m\].
    pub length: f64,
    /// Young's modulus \[Pa\].
    pub youngs_modulus: f64,
    /// Poisson's ratio.
    pub poisson_ratio: f64,
}

impl Beam {
    /// Shear coefficient of a round section, 6(1+ν)/(7+6ν) (Cowper 1966).
    pub fn shear_coefficient(&self) -> f64 {
        6.0 * (1.0 + self.poisson_ratio) / (7.0 + 6.0 * self.poisson_ratio)
    }

    /// EA \[N\].
    pub fn axial(&self) -> f64 {
        self.youngs_modulus * PI * self.radius * self.radius
    }

    /// EI \[N m²\].
    pub fn bending(&self) -> f64 {
        self.axial() * self.radius * self.radius / 4.0
    }

    /// κGA \[N\].
    pub fn shear(&self) -> f64 {
        self.shear_coefficient() * self.axial() / (2.0 * (1.0 + self.poisson_ratio))
    }

    /// GJ \[N m²\], J = 2I.
    pub fn twist(&self) -> f64 {
        self.bending() / (1.0 + self.poisson_ratio)
    }

    /// Φ = 12EI/(κGAL²).
    pub fn shear_parameter(&self) -> f64 {
        12.0 * self.bending() / (self.shear() * self.length * self.length)
    }

    /// Stiffness of one end against one kind of displacement: E A/L, 12k/L², 6k/L, (4+Φ)k, (2-Φ)k and GJ/L, with k = EI/(L(1+Φ)).
    pub fn stiffnesses(&self) -> [f64; 6] {
        let (length, phi) = (self.length, self.shear_parameter());
        let k = self.bending() / (length * (1.0 + phi));
        [
            self.axial() / length,
            12.0 * k / (length * length),
            6.0 * k / length,
            (4.0 + phi) * k,
            (2.0 - phi) * k,
            self.twist() / length,
        ]
    }

    /// Stiffness matrix: forces \[N\] and couples \[N m\] that hold both ends in place are this times the displacements.
    pub fn matrix(&self) -> [[f64; 12]; 12] {
        let [along, across, couple, near, far, twist] = self.stiffnesses();
        let mut matrix = [[0.0; 12]; 12];
        let mut set = |row: usize, column: usize, value: f64| {
            matrix[row][column] = value;
            matrix[column][row] = value;
        };
        for (place, stiffness) in [(0, along), (3, twist)] {
            set(place, place, stiffness);
            set(place + 6, place + 6, stiffness);
            set(place, place + 6, -stiffness);
        }
        // Deflection along y turns about z; along z, against y.
        for (shift, turn, sign) in [(1, 5, 1.0), (2, 4, -1.0)] {
            set(shift, shift, across);
            set(shift + 6, shift + 6, across);
            set(shift, shift + 6, -across);
            for end in [turn, turn + 6] {
                set(shift, end, sign * couple);
                set(shift + 6, end, -sign * couple);
                set(end, end, near);
            }
            set(turn, turn + 6, far);
        }
        matrix
    }

    /// Forces and couples of the beam on what holds its ends.
    pub fn loads(&self, displacements: &Displacements) -> Displacements {
        let row = |row: &[f64; 12]| -> f64 {
            let products = row.iter().zip(displacements);
            -products
                .map(|(stiffness, shift)| stiffness * shift)
                .sum::<f64>()
        };
        self.matrix().each_ref().map(row)
    }

    /// Deflections \[m\] of the nodes of a cantilever of equal beams, the first node held, under forces \[N\] across it on the others.
    pub fn cantilever(&self, forces: &[f64]) -> Vec<f64> {
        let mut right = vec![0.0; 2 * forces.len()];
        for (k, force) in forces.iter().enumerate() {
            right[2 * k] = *force;
        }
        let solved = solved(self.assembled(forces.len()), right);
        solved.into_iter().step_by(2).collect()
    }

    /// First frequency \[rad/s\] of a cantilever of `count` beams, whose nodes have a mass \[kg\] and a moment of inertia \[kg m²\].
    pub fn first_frequency(&self, count: usize, mass: f64, inertia: f64) -> f64 {
        let inert = |k: usize| if k.is_multiple_of(2) { mass } else { inertia };
        let mut shape: Vec<f64> = (0..2 * count)
            .map(|k| f64::from(k.is_multiple_of(2)))
            .collect();
        let mut square = 0.0;
        // Inverse iteration; the second frequency is six times the first, so that each round wins a factor of 40.
        for _ in 0..30 {
            let right = shape.iter().enumerate().map(|(k, x)| inert(k) * x);
            let next = solved(self.assembled(count), right.collect());
            let product = |a: &[f64], b: &[f64]| -> f64 {
                let both = a.iter().zip(b).enumerate();
                both.map(|(k, (a, b))| inert(k) * a * b).sum()
            };
            // Rayleigh's quotient.
            square = product(&next, &shape) / product(&next, &next);
            let size = product(&next, &next).sqrt();
            shape = next.into_iter().map(|x| x / size).collect();
        }
        square.sqrt()
    }

    /// Stiffness of a cantilever of `count` beams in the plane: deflections and rotations of the nodes behind the held one.
    fn assembled(&self, count: usize) -> Vec<Vec<f64>> {
        let matrix = self.matrix();
        let mut whole = vec![vec![0.0; 2 * count]; 2 * count];
        // Of node k: its deflection and rotation in the element, and in the whole.
        let places = [1, 5, 7, 11];
        for element in 0..count {
            let unknown = |place: usize| (2 * element + place).checked_sub(2);
            for (a, row) in places.into_iter().enumerate() {
                for (b, column) in places.into_iter().enumerate() {
                    if let (Some(i), Some(j)) = (unknown(a), unknown(b)) {
                        whole[i][j] += matrix[row][column];
                    }
                }
            }
        }
        whole
    }
}

/// Solution of a symmetric, positive definite system by elimination.
fn solved(mut matrix: Vec<Vec<f64>>, mut right: Vec<f64>) -> Vec<f64> {
    let count = right.len();
    for k in 0..count {
        let (above, below) = matrix.split_at_mut(k + 1);
        let pivot = &above[k];
        for (row, line) in below.iter_mut().enumerate() {
            let factor = line[k] / pivot[k];
            if factor != 0.0 {
                for (value, known) in line[k..].iter_mut().zip(&pivot[k..]) {
                    *value -= factor * known;
                }
                right[k + 1 + row] -= factor * right[k];
            }
        }
    }
    for k in (0..count).rev() {
        let known: f64 = (k + 1..count).map(|j| matrix[k][j] * right[j]).sum();
        right[k] = (right[k] - known) / matrix[k][k];
    }
    right
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Case T31: R = r = 1 mm, E = 1e8 Pa, ν = 0.25.
    const T31: Beam = Beam {
        radius: 1e-3,
        length: 2e-3,
        youngs_modulus: 1e8,
        poisson_ratio: 0.25,
    };

    fn is_near(found: f64, expected: f64) {
        // Ten digits are given.
        assert!(
            (found / expected - 1.0).abs() < 1e-9,
            "{found:e} {expected:e}"
        );
    }

    #[test]
    fn stiffnesses_have_the_numbers_of_case_t31() {
        is_near(T31.shear_coefficient(), 0.882_352_941_2);
        is_near(T31.shear_parameter(), 2.125);
        let [along, across, couple, near, far, twist] = T31.stiffnesses();
        is_near(along, 157_079.632_7);
        is_near(across, 37_699.111_84);
        is_near(couple, 37.699_111_84);
        is_near(twist, 0.031_415_926_54);
        // Both ends turned alike are a shear, turned against each other a pure bending by EI/L.
        is_near((near + far) * 2.0, couple * T31.length * 2.0);
        is_near(near - far, 2.0 * T31.bending() / T31.length);
    }

    /// P L³/3EI + P L/κGA, to the round-off of elimination.
    fn deflection(beams: usize, force: f64) -> f64 {
        let length = T31.length * beams as f64;
        force * (length * length * length / (3.0 * T31.bending()) + length / T31.shear())
    }

    #[test]
    fn cantilevers_of_any_number_of_beams_bend_as_one() {
        let tip = |beams: usize| {
            let mut forces = vec![0.0; beams];
            forces[beams - 1] = 1e-6;
            *T31.cantilever(&forces).last().unwrap()
        };
        is_near(tip(5), 4.334_319_62e-9);
        for beams in [1, 2, 5, 49] {
            let (found, expected) = (tip(beams), deflection(beams, 1e-6));
            assert!(
                (found / expected - 1.0).abs() < 1e-8,
                "{beams}: {found:e} {expected:e}"
            );
        }
        // Forces on all nodes add up.
        let all = T31.cantilever(&[1e-6; 5]);
        let sum: f64 = (1..=5)
            .map(|k| {
                let mut one = [0.0; 5];
                one[k - 1] = 1e-6;
                T31.cantilever(&one)[4]
            })
            .sum();
        is_near(all[4], sum);
    }

    #[test]
    fn the_first_frequency_is_that_of_a_slender_beam() {
        // 1.875104² √(EI/μL⁴) of Euler and Bernoulli; shear and rotation of a section lower it by some (r/L)² = 1e-4, lumped masses by some 1/count.
        let slender = Beam {
            radius: 1e-4,
            ..T31
        };
        let (count, mass) = (60, 1e-5);
        let length = slender.length * count as f64;
        let line = mass / slender.length;
        let square = length * length;
        let exact = 1.875_104 * 1.875_104 * (slender.bending() / (line * square * square)).sqrt();
        let found = slender.first_frequency(count, mass, 0.0);
        assert!((found / exact - 1.0).abs() < 0.03, "{found} {exact}");
        // The tip of a lumped beam has twice the mass that it should have.
        assert!(found < exact);
        // One massless beam with a mass at its tip is a spring.
        let spring = 1.0 / deflection(1, 1.0);
        is_near(T31.first_frequency(1, mass, 0.0), (spring / mass).sqrt());
        // Moments of inertia make it slower.
        assert!(T31.first_frequency(5, mass, 1e-11) < T31.first_frequency(5, mass, 0.0));
    }

    #[test]
    fn rigid_motions_load_nothing_and_loads_balance() {
        let length = T31.length;
        let small = 1e-6;
        for k in 0..6 {
            let mut motion = [0.0; 12];
            motion[k] = small;
            motion[k + 6] = small;
            match k {
                4 => motion[8] = -small * length,
                5 => motion[7] = small * length,
                _ => {}
            }
            let scale = small * T31.stiffnesses()[0];
            for load in T31.loads(&motion) {
                assert!(load.abs() < 1e-12 * scale, "{k}: {load:e}");
            }
        }
        let matrix = T31.matrix();
        for (row, line) in matrix.iter().enumerate() {
            for (column, value) in line.iter().enumerate() {
                assert_eq!(*value, matrix[column][row]);
            }
        }
        let uneven: [f64; 12] = std::array::from_fn(|k| small * (1.0 + (k * k) as f64));
        let loads = T31.loads(&uneven);
        for axis in 0..3 {
            assert!((loads[axis] + loads[axis + 6]).abs() < 1e-12 * loads[axis].abs().max(1e-3));
        }
        // Couples about the first end.
        let about_y = loads[4] + loads[10] - length * loads[8];
        let about_z = loads[5] + loads[11] + length * loads[7];
        assert!(
            about_y.abs() < 1e-12 && about_z.abs() < 1e-12,
            "{about_y:e} {about_z:e}"
        );
    }
}
