//! The stable branch of one bridge: followed from the touch to its end, and solved at any gap between.
//!
//! For given contact angle, volume and radii, the equations of [`meridian`](super::meridian) leave a curve in the space of the four
//! unknowns. It is followed by steps along its tangent, each corrected by Newton's iteration across it (Keller 1977). The stable
//! branch ends
//!
//! - at a fold, where the gap is largest: beyond it no bridge of this volume exists, and the branch that comes back from it is
//!   unstable (Erle, Dyson & Morrow 1971; Lian, Thornton & Adams 1993); or
//! - where a branch of asymmetric bridges crosses: between equal spheres at contact angles above some 25 to 30 degrees the symmetric
//!   bridge loses its stability there, before its fold (between planes: Vogel 2005).

use std::f64::consts::PI;

use super::meridian::{Bridge, Given, Unknowns};

/// Newton's iteration has converged when the last step, in the scales of the unknowns, is below this: as it doubles the digits, what
/// is left then is round-off.
const CONVERGED: f64 = 1e-9;
/// How long a step along the branch is at most, in the scales of the unknowns.
const LONGEST_STEP: f64 = 0.2;
/// Two branches cross where a shorter step than this, in the same scales, would lead over to the other side.
const CROSSING: f64 = 1e-5;
/// More points than any branch has.
const MOST_POINTS: usize = 500;
/// The condition that keeps the gap as it is.
const AT_GAP: [f64; 4] = [0.0, 0.0, 0.0, 1.0];
/// Points closer to the end than this way (see [`Branch`]) only disturb the interpolation to it.
const CLOSE: f64 = 2e-3;

/// Why there is no branch of solutions.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Failure {
    /// An input is no number, or outside of what makes sense.
    #[error(
        "a liquid bridge needs a contact angle from 0 to pi/2, a volume above 0 and a ratio of radii from 0 to 1, but got {theta}, {volume} and {ratio}"
    )]
    Input {
        /// Contact angle, rad.
        theta: f64,
        /// Volume, R_D^3.
        volume: f64,
        /// Smaller over larger radius.
        ratio: f64,
    },
    /// The iteration found no bridge of this volume between touching spheres.
    #[error(
        "found no liquid bridge of volume {volume} R_D^3 at a contact angle of {theta} rad between touching spheres with a ratio of radii of {ratio}"
    )]
    NotFound {
        /// Contact angle, rad.
        theta: f64,
        /// Volume, R_D^3.
        volume: f64,
        /// Smaller over larger radius.
        ratio: f64,
    },
}

/// The stable branch of one bridge, from the touch to its end. Units as the [module](super) has them.
///
/// ```
/// use mercury_engine::contact::adhesion::young_laplace::Branch;
/// // two equal spheres, a contact angle of 0, a hundredth of R_D^3
/// let branch = Branch::new(0.0, 0.01, 1.0)?;
/// let touch = branch.at(0.0).unwrap();
/// assert!((touch.force - 5.5568523).abs() < 1e-7);
/// assert!((branch.end() - 0.2190).abs() < 1e-4);
/// # Ok::<(), mercury_engine::contact::adhesion::young_laplace::Failure>(())
/// ```
#[derive(Debug, Clone)]
pub struct Branch {
    given: Given,
    /// Points along it from the touch on, each with its way to the end, sqrt(1 - gap/end): a measure in which the branch is smooth,
    /// over a fold too, behind which it is negative.
    points: Vec<(f64, Unknowns)>,
    end: Unknowns,
}

impl Branch {
    /// The branch for a contact angle (rad), a volume in R_D^3 and the ratio of the smaller to the larger radius, 0 for a plane.
    ///
    /// # Errors
    /// If an input makes no sense, or no such bridge between touching spheres is found.
    pub fn new(theta: f64, volume: f64, ratio: f64) -> Result<Self, Failure> {
        let sensible = (0.0..=PI / 2.0).contains(&theta)
            && volume > 0.0
            && volume.is_finite()
            && (0.0..=1.0).contains(&ratio);
        if !sensible {
            return Err(Failure::Input {
                theta,
                volume,
                ratio,
            });
        }
        let d = (1.0 - ratio) / (1.0 + ratio);
        Self::between(theta, volume, [1.0 + d, 1.0 - d]).ok_or(Failure::NotFound {
            theta,
            volume,
            ratio,
        })
    }

    /// For the curvatures of the two spheres in 1/R_D, of which the first is not 0.
    fn between(theta: f64, volume: f64, curvatures: [f64; 2]) -> Option<Self> {
        let given = Given::new(theta, volume, curvatures);
        let touch = given.corrected(given.guess(), AT_GAP, 60)?;
        let (points, end) = given.followed(touch)?;
        let last = points[end];
        let way = |k: usize| {
            let way = f64::max(1.0 - points[k][3] / last[3], 0.0).sqrt();
            if k > end { -way } else { way }
        };
        Some(Self {
            given,
            points: (0..points.len())
                .map(|k| (way(k), points[k]))
                .filter(|&(way, w)| way.abs() > CLOSE || w == last)
                .collect(),
            end: last,
        })
    }

    /// Gap at the end of the stable branch, R_D.
    #[must_use]
    pub fn end(&self) -> f64 {
        self.end[3]
    }

    /// The bridge at its end.
    #[must_use]
    pub fn last(&self) -> Bridge {
        self.given.bridge(self.end)
    }

    /// The stable bridge at a gap (R_D); none where the gap is negative or beyond the end.
    #[must_use]
    pub fn at(&self, gap: f64) -> Option<Bridge> {
        let end = self.end();
        if !(0.0..=end).contains(&gap) {
            return None;
        }
        let way = (1.0 - gap / end).sqrt();
        let mut w = self.interpolated(way)?;
        w[3] = gap;
        // so close to the end, the interpolation is better than an iteration at a given gap
        if way > 0.1 * CLOSE {
            w = self.given.corrected(w, AT_GAP, 12)?;
        }
        Some(self.given.bridge(w))
    }

    /// Lagrange's interpolation between the four nearest points.
    fn interpolated(&self, way: f64) -> Option<Unknowns> {
        let behind = self.points.partition_point(|point| point.0 > way);
        let first = behind
            .saturating_sub(2)
            .min(self.points.len().checked_sub(4)?);
        let near = &self.points[first..first + 4];
        let mut sum = [0.0; 4];
        for (i, (own, point)) in near.iter().enumerate() {
            let mut weight = 1.0;
            for (j, (other, _)) in near.iter().enumerate() {
                if j != i {
                    weight *= (way - other) / (own - other);
                }
            }
            for k in 0..4 {
                sum[k] += weight * point[k];
            }
        }
        Some(sum)
    }
}

/// Newton's iteration and tangents, in the scales of the unknowns.
impl Given {
    /// Newton's iteration from `guess` in the plane through it across `along`.
    fn corrected(&self, guess: Unknowns, along: [f64; 4], iterations: usize) -> Option<Unknowns> {
        let units = self.units();
        let mut w = guess;
        for _ in 0..iterations {
            let mut system = self.system(w, along);
            system[3][4] = (0..4)
                .map(|k| along[k] * (guess[k] - w[k]) / units[k])
                .sum();
            let (step, _) = solved(system)?;
            // a step that would leave the neighbourhood in which the iteration converges is shortened
            let size = step.iter().fold(0.0, |most, x| f64::max(most, x.abs()));
            let most = 0.3 * f64::min(1.0, 2.0 * w[2] / units[2]);
            let share = f64::min(1.0, most / size);
            for k in 0..4 {
                w[k] += share * step[k] * units[k];
            }
            if !(w[0] > 0.0 && w[0] < PI && w[2] > 0.0 && w[1].abs() < 2.0 * PI) {
                return None;
            }
            if size < CONVERGED {
                return Some(w);
            }
        }
        None
    }

    /// The unit vector along the branch, on the side of `before`; and the sign of the determinant of the equations and this vector.
    /// It is the same all along a branch, through its folds too, but differs behind a crossing of two branches.
    fn tangent(&self, w: Unknowns, before: [f64; 4]) -> Option<([f64; 4], bool)> {
        let mut system = self.system(w, before);
        for (row, right) in system.iter_mut().zip([0.0, 0.0, 0.0, 1.0]) {
            row[4] = right;
        }
        let (t, side) = solved(system)?;
        let norm = (t[0] * t[0] + t[1] * t[1] + t[2] * t[2] + t[3] * t[3]).sqrt();
        Some((t.map(|x| x / norm), side))
    }

    /// The linearised equations, in the last column what is missing, and a row of one condition more.
    fn system(&self, w: Unknowns, last: [f64; 4]) -> [[f64; 5]; 4] {
        let units = self.units();
        let (residuals, by) = self.residuals(w);
        let mut system = [[0.0; 5]; 4];
        for i in 0..3 {
            for k in 0..4 {
                system[i][k] = by[i][k] * units[k];
            }
            system[i][4] = -residuals[i];
        }
        system[3][..4].copy_from_slice(&last);
        system
    }

    /// Points of the branch from the touch on, some of them behind its end, and the index of the end.
    fn followed(&self, touch: Unknowns) -> Option<(Vec<Unknowns>, usize)> {
        let mut points = vec![touch];
        let mut w = touch;
        let (mut t, side) = self.tangent(w, AT_GAP)?;
        let mut step = 0.25 * LONGEST_STEP;
        let mut end = None;
        while points.len() < MOST_POINTS {
            let next = self
                .corrected(self.ahead(w, t, step), t, 6)
                .and_then(|next| Some((next, self.tangent(next, t)?)));
            let (next, after, turn) = match next {
                Some((next, (after, on))) if on == side => {
                    let turn: f64 = (0..4).map(|k| t[k] * after[k]).sum();
                    (next, after, turn)
                }
                Some(_) if step < CROSSING && points.len() > 3 => {
                    let last = points.len() - 1;
                    return Some((points, last));
                }
                _ => (w, t, 0.0),
            };
            if turn < 0.9 {
                step *= 0.5;
                if step < 0.01 * CROSSING {
                    return None;
                }
                continue;
            }
            if end.is_none() && after[3] <= 0.0 {
                end = Some(points.len());
                points.push(self.fold(w, t, (step, after[3]))?);
            }
            points.push(next);
            if let Some(end) = end
                && points.len() > end + 2
            {
                return Some((points, end));
            }
            if turn > 0.98 {
                step = f64::min(1.5 * step, LONGEST_STEP);
            }
            (w, t) = (next, after);
        }
        None
    }

    /// A step along a tangent.
    fn ahead(&self, w: Unknowns, t: [f64; 4], step: f64) -> Unknowns {
        let units = self.units();
        [0, 1, 2, 3].map(|k| w[k] + step * t[k] * units[k])
    }

    /// Where the gap is largest, between the point `w` and that of a step further, where the gap's share in the direction is `last`
    /// <= 0: by false position, of which the end that stays counts half (Illinois).
    fn fold(&self, w: Unknowns, t: [f64; 4], (step, last): (f64, f64)) -> Option<Unknowns> {
        let (mut low, mut high) = ((0.0, t[3]), (step, last));
        let mut found = w;
        for _ in 0..60 {
            let ahead = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
            found = self.corrected(self.ahead(w, t, ahead), t, 12)?;
            let share = self.tangent(found, t)?.0[3];
            // the gap is flat here: its error is of the order of the square of this
            if share.abs() < 1e-8 || high.0 - low.0 < 1e-8 {
                break;
            }
            if share > 0.0 {
                low = (ahead, share);
                high.1 *= 0.5;
            } else {
                high = (ahead, share);
                low.1 *= 0.5;
            }
        }
        Some(found)
    }
}

/// The solution of four linear equations, and whether their determinant is positive: Gauss' elimination with the largest pivot of
/// each column.
fn solved(mut m: [[f64; 5]; 4]) -> Option<([f64; 4], bool)> {
    let mut positive = true;
    for column in 0..4 {
        let mut pivot = column;
        for row in column + 1..4 {
            if m[row][column].abs() > m[pivot][column].abs() {
                pivot = row;
            }
        }
        m.swap(column, pivot);
        positive ^= pivot != column;
        let top = m[column];
        if !(top[column].abs() > 0.0 && top[column].is_finite()) {
            return None;
        }
        positive ^= top[column] < 0.0;
        for row in &mut m[column + 1..] {
            let factor = row[column] / top[column];
            for k in column..5 {
                row[k] -= factor * top[k];
            }
        }
    }
    let mut x = [0.0; 4];
    for row in (0..4).rev() {
        let mut sum = m[row][4];
        for k in row + 1..4 {
            sum -= m[row][k] * x[k];
        }
        x[row] = sum / m[row][row];
    }
    x.iter().all(|x| x.is_finite()).then_some((x, positive))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const DEGREE: f64 = PI / 180.0;

    /// (1 + theta/2)(V*^(1/3) + 0.1 V*^(2/3)), Willett et al. (2000).
    fn willett(theta: f64, volume: f64) -> f64 {
        let root = libm::cbrt(volume);
        (1.0 + theta / 2.0) * (root + 0.1 * root * root)
    }

    /// Shares of that distance at which the forces of T21 and T21b stand.
    const SHARES: [f64; 5] = [0.0, 0.1, 0.25, 0.5, 0.75];

    #[test]
    fn equal_spheres_as_in_case_t21() {
        // degrees, V*, half-filling angle at the touch, forces, last stable gap
        #[rustfmt::skip]
        let rows = [
            (0.0, 0.001, 0.1693036, [5.8820021, 3.8634989, 1.9379071, 0.7948671, 0.4248681], 0.1007),
            (0.0, 0.01, 0.3168103, [5.5568523, 4.3189436, 2.7780303, 1.4125256, 0.8215396], 0.2190),
            (0.0, 0.05, 0.5019142, [5.1746235, 4.3965049, 3.2650436, 1.9606015, 1.2428148], 0.3810),
            (0.0, 0.1, 0.6164987, [4.9490799, 4.3525773, 3.4180598, 2.2086268, 1.4641865], 0.4857),
            (10.0, 0.01, 0.3088274, [5.4514747, 4.1433109, 2.5695320, 1.2681384, 0.7288167], 0.230),
            (30.0, 0.01, 0.2985045, [4.6531753, 3.4286910, 2.0281658, 0.9940369, 0.5955822], 0.272),
            (30.0, 0.05, 0.4575960, [4.2411531, 3.5281835, 2.4961029, 1.4484995, 0.9373207], 0.477),
        ];
        for (degrees, volume, filling, forces, end) in rows {
            let theta = degrees * DEGREE;
            let branch = Branch::new(theta, volume, 1.0).unwrap();
            let touch = branch.at(0.0).unwrap();
            // converged to 1e-7
            assert!((touch.filling[0] - filling).abs() < 1e-7);
            for (share, force) in SHARES.into_iter().zip(forces) {
                let found = branch.at(share * willett(theta, volume)).unwrap().force;
                assert!(
                    (found - force).abs() < 1e-7,
                    "{degrees} {volume} {share}: {found}"
                );
            }
            // the last gap is rough in the table
            assert!((branch.end() / end - 1.0).abs() < 0.01, "{}", branch.end());
        }
    }

    #[test]
    fn unequal_spheres_and_planes_as_in_case_t21b() {
        // degrees, V*, ratio, forces, end over Willett's distance (to 0.01), work from the touch to the end (to 1 %)
        #[rustfmt::skip]
        let rows = [
            (0.0, 0.01, 1.0, [5.55685, 4.31894, 2.77803, 1.41253, 0.82154], 0.99, 0.42706),
            (0.0, 0.01, 0.5, [5.54382, 4.31560, 2.77888, 1.41245, 0.81853], 0.96, 0.42333),
            (0.0, 0.01, 0.2, [5.50476, 4.30550, 2.78146, 1.41227, 0.80953], 0.92, 0.41735),
            (0.0, 0.01, 0.0, [5.43973, 4.28849, 2.78585, 1.41218, 0.79464], 0.88, 0.41064),
            (0.0, 0.05, 0.0, [4.92864, 4.29778, 3.25866, 1.94187, 1.10165], 0.80, 0.79888),
            (20.0, 0.001, 0.0, [5.44892, 3.34219, 1.53641, 0.61166, 0.32660], 0.89, 0.13923),
            (20.0, 0.01, 0.5, [5.13278, 3.83749, 2.31544, 1.12821, 0.65259], 0.91, 0.41578),
            (20.0, 0.01, 0.0, [5.03551, 3.81932, 2.32324, 1.12478, 0.61688], 0.82, 0.40116),
            (20.0, 0.05, 0.2, [4.64335, 3.91564, 2.81288, 1.61014, 0.93980], 0.81, 0.82208),
            (40.0, 0.01, 0.2, [3.95634, 2.92656, 1.72750, 0.86298, 0.52146], 0.83, 0.35508),
        ];
        for (degrees, volume, ratio, forces, end, work) in rows {
            let theta = degrees * DEGREE;
            let branch = Branch::new(theta, volume, ratio).unwrap();
            let distance = willett(theta, volume);
            for (share, force) in SHARES.into_iter().zip(forces) {
                let found = branch.at(share * distance).unwrap().force;
                // half of the last digit
                assert!(
                    (found - force).abs() < 5.1e-6,
                    "{degrees} {volume} {ratio} {share}: {found}"
                );
            }
            assert!((branch.end() / distance - end).abs() < 0.01);
            let touch = branch.at(0.0).unwrap();
            let found = branch.last().surface_energy - touch.surface_energy;
            assert!((found / work - 1.0).abs() < 0.01, "{found}");
        }
    }

    #[test]
    fn the_end_of_equal_spheres_is_where_asymmetric_shapes_set_in() {
        // Up to some 25 degrees it is the fold: nearly equal spheres end as equal ones do, but for a term of d^2.
        let end =
            |degrees: f64, ratio: f64| Branch::new(degrees * DEGREE, 0.01, ratio).unwrap().end();
        let lost = |degrees: f64, ratio: f64| 1.0 - end(degrees, ratio) / end(degrees, 1.0);
        let d = |ratio: f64| (1.0 - ratio) / (1.0 + ratio);
        let (near, far): (f64, f64) = (0.96, 0.9);
        let power = libm::log(lost(10.0, far) / lost(10.0, near)) / libm::log(d(far) / d(near));
        assert!((power - 2.0).abs() < 0.1, "{power}");
        // Beyond, two branches cross before the fold (at a gap of 0.2981 for 40 degrees). Spheres that differ a little end sooner by a
        // term of |d|^(2/3), as with any imperfect pitchfork.
        let (near, far): (f64, f64) = (0.9999, 0.999);
        let power = libm::log(lost(40.0, far) / lost(40.0, near)) / libm::log(d(far) / d(near));
        assert!((power - 2.0 / 3.0).abs() < 0.03, "{power}");
        assert!((end(40.0, 1.0) / 0.29225 - 1.0).abs() < 1e-4);
        assert!((end(40.0, 1.0 - 1e-9) / end(40.0, 1.0) - 1.0).abs() < 1e-4);
    }

    #[test]
    fn either_sphere_may_come_first() {
        for (theta, volume, [a, b]) in [(0.0, 0.01, [1.4, 0.6]), (0.9, 0.1, [1.2, 0.8])] {
            let one = Branch::between(theta, volume, [a, b]).unwrap();
            let other = Branch::between(theta, volume, [b, a]).unwrap();
            // quadrature near the end, 4e-7
            assert!((one.end() / other.end() - 1.0).abs() < 1e-6);
            for share in [0.0, 0.3, 0.7] {
                let gap = share * one.end();
                let (one, other) = (one.at(gap).unwrap(), other.at(gap).unwrap());
                assert!((one.force / other.force - 1.0).abs() < 1e-8);
                assert!((one.filling[0] / other.filling[1] - 1.0).abs() < 1e-8);
                assert!((one.wetted[1] / other.wetted[0] - 1.0).abs() < 1e-8);
                assert!((one.surface_energy / other.surface_energy - 1.0).abs() < 1e-8);
            }
        }
    }

    #[test]
    fn input_that_makes_no_sense_is_refused() {
        for (theta, volume, ratio) in [
            (-0.1, 0.01, 1.0),
            (1.6, 0.01, 1.0),
            (f64::NAN, 0.01, 1.0),
            (0.1, 0.0, 1.0),
            (0.1, f64::INFINITY, 1.0),
            (0.1, f64::NAN, 1.0),
            (0.1, 0.01, -0.1),
            (0.1, 0.01, 1.1),
            (0.1, 0.01, f64::NAN),
        ] {
            let failure = Branch::new(theta, volume, ratio).unwrap_err();
            assert!(matches!(failure, Failure::Input { .. }), "{failure}");
        }
        // more liquid than anything holds: found or not, but no panic
        let _ = Branch::new(0.5, 1e6, 0.3);
        let branch = Branch::new(0.5, 0.01, 0.3).unwrap();
        for gap in [-1e-9, 1.01 * branch.end(), f64::NAN] {
            assert!(branch.at(gap).is_none());
        }
        assert!(branch.at(branch.end()).is_some());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        /// An independent check of all of it: surface and force come from different formulas.
        #[test]
        fn the_pull_is_the_derivative_of_the_surface_energy(
            theta in 0.0..90.0 * DEGREE,
            log_volume in -9.2..-1.6,
            ratio in 0.0..=1.0,
            share in 0.01..0.94,
        ) {
            let branch = Branch::new(theta, libm::exp(log_volume), ratio).unwrap();
            let end = branch.end();
            let at = |share: f64| branch.at(share * end).unwrap();
            let step = 1e-4;
            let energy = |k: f64| at(share + k * step).surface_energy;
            // of fourth order
            let slope = (8.0 * (energy(1.0) - energy(-1.0)) - (energy(2.0) - energy(-2.0)))
                / (12.0 * step * end);
            let exact = at(share);
            // Beyond some 75 degrees the force near the touch changes its sign.
            let forces = [0.0, 0.1, 0.3, 0.6, 0.9].map(|share| at(share).force.abs());
            let largest = forces.into_iter().fold(exact.force.abs(), f64::max);
            prop_assert!((slope - exact.force).abs() < 1e-6 * largest, "{} {}", slope, exact.force);
            // round the contact lines: R sin(beta) = y
            let d = (1.0 - ratio) / (1.0 + ratio);
            for (i, curvature) in [1.0 + d, 1.0 - d].into_iter().enumerate() {
                let sine = libm::sin(exact.filling[i]);
                prop_assert!((sine - curvature * exact.wetted[i]).abs() < 1e-9);
                // y sin(beta + theta) = a + h y^2
                let y = exact.wetted[i];
                let pull = y * libm::sin(exact.filling[i] + theta) - exact.curvature * y * y;
                prop_assert!((2.0 * PI * pull - exact.force).abs() < 1e-7 * largest);
            }
        }
    }
}
