//! Liquid bridges between equal spheres by integration along the meridian: independent of the engine's solutions, which follow from
//! elliptic integrals of the profile.
//!
//! Lengths are in R_D, which is the radius of each sphere. From the contact line at the half-filling angle b the profile r(l), z(l) goes
//! down with the direction (cos a, sin a), a = pi + b + theta at first: the wetted surface of the sphere points to pi + b. The
//! Young-Laplace equation is da/dl = -k - sin a/r, with the pressure inside minus outside k gamma. At the neck, or the widest place, z = 0 and
//! a = 3 pi/2. The three unknowns b, k and the length of the half profile follow from these two conditions and the volume.

use std::f64::consts::PI;

/// Steps of the rule of Runge and Kutta along half a profile: its error, of fourth order, is then below 1e-9.
const STEPS: usize = 600;

/// Half-filling angle (rad), pressure (gamma/R_D) and length of half a profile (R_D).
type Unknowns = [f64; 3];

/// Direction, height and volume at the end of half a profile, less what they should be, and the radius there.
fn ends(
    [filling, pressure, length]: Unknowns,
    theta: f64,
    volume: f64,
    gap: f64,
) -> ([f64; 3], f64) {
    let slope = |[r, _, a, _]: [f64; 4]| {
        let (sine, cosine) = a.sin_cos();
        [cosine, sine, -pressure - sine / r, -PI * r * r * sine]
    };
    let step = length / STEPS as f64;
    let height = 1.0 - filling.cos();
    let mut at = [filling.sin(), 0.5 * gap + height, PI + filling + theta, 0.0];
    for _ in 0..STEPS {
        let ahead =
            |by: [f64; 4], share: f64| std::array::from_fn(|k| at[k] + share * step * by[k]);
        let first = slope(at);
        let second = slope(ahead(first, 0.5));
        let third = slope(ahead(second, 0.5));
        let fourth = slope(ahead(third, 1.0));
        at = std::array::from_fn(|k| {
            at[k] + step / 6.0 * (first[k] + 2.0 * (second[k] + third[k]) + fourth[k])
        });
    }
    // The cap of the sphere within.
    let cap = PI * height * height * (1.0 - height / 3.0);
    (
        [at[2] - 1.5 * PI, at[1], 2.0 * (at[3] - cap) - volume],
        at[0],
    )
}

/// The pull over gamma R_D of the bridge of a volume (R_D^3) at a gap (R_D) and a contact angle (rad), near a half-filling angle (rad) and a
/// pressure (gamma/R_D); `None` if there is none nearby.
#[must_use]
pub fn pull(theta: f64, volume: f64, gap: f64, [filling, pressure]: [f64; 2]) -> Option<f64> {
    let mut at = [filling, pressure, arc(theta, gap, filling).0];
    for _ in 0..50 {
        let (off, radius) = ends(at, theta, volume, gap);
        if off.iter().all(|off| off.abs() < 1e-11) {
            return Some(PI * radius * (2.0 - radius * at[1]));
        }
        // Newton's step, with derivatives by central differences.
        let mut system = [[0.0; 4]; 3];
        for k in 0..3 {
            let moved = |by: f64| {
                let mut moved = at;
                moved[k] += by;
                ends(moved, theta, volume, gap).0
            };
            let (more, less) = (moved(1e-6), moved(-1e-6));
            for row in 0..3 {
                system[row][k] = (more[row] - less[row]) / 2e-6;
                system[row][3] = -off[row];
            }
        }
        let step = solved(system)?;
        let largest = step.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let share = (0.1 / largest).min(1.0);
        for k in 0..3 {
            at[k] += share * step[k];
        }
    }
    None
}

/// Length of half a profile that is an arc of a circle, and the pressure at its middle: where the iteration starts.
fn arc(theta: f64, gap: f64, filling: f64) -> (f64, f64) {
    let height = 0.5 * gap + 1.0 - filling.cos();
    let turn = 0.5 * PI - filling - theta;
    let length = if turn == 0.0 {
        height
    } else {
        height * turn / turn.sin()
    };
    let radius = height / turn.sin();
    let neck = filling.sin() - radius * (1.0 - turn.cos());
    (length, 1.0 / neck - 1.0 / radius)
}

/// Cramer's rule.
fn solved(m: [[f64; 4]; 3]) -> Option<[f64; 3]> {
    let determinant = |columns: [usize; 3]| {
        let at = |row: usize, column: usize| m[row][columns[column]];
        at(0, 0) * (at(1, 1) * at(2, 2) - at(1, 2) * at(2, 1))
            - at(0, 1) * (at(1, 0) * at(2, 2) - at(1, 2) * at(2, 0))
            + at(0, 2) * (at(1, 0) * at(2, 1) - at(1, 1) * at(2, 0))
    };
    let all = determinant([0, 1, 2]);
    let step = [[3, 1, 2], [0, 3, 2], [0, 1, 3]].map(|columns| determinant(columns) / all);
    step.iter().all(|x| x.is_finite()).then_some(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Forces that another program found (T21): contact angle, volume, half-filling angle at the touch and force there.
    #[test]
    fn known_forces_are_found() {
        for (degrees, volume, filling, force) in [
            (0.0, 0.01, 0.3168103, 5.5568523),
            (30.0, 0.01, 0.2985045, 4.6531753),
            (30.0, 0.05, 0.4575960, 4.2411531),
        ] {
            let theta = f64::to_radians(degrees);
            let found = pull(theta, volume, 0.0, [filling, arc(theta, 0.0, filling).1]);
            // Printed with eight digits.
            assert!(
                (found.unwrap() - force).abs() < 1e-7,
                "{found:?}, not {force}"
            );
        }
    }
}
