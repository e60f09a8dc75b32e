//! Parameters that the data determine.
//!
//! Likelihood of a parameter that data determine falls to both sides: where ln L is z^2/2 below its maximum, all other parameters
//! being the best ones there, its interval ends (the profile likelihood; Wilks 1938, Ann. Math. Stat. 9, 60). If that is not
//! reached a hundred times away, the interval has no end, whatever the curvature at the maximum: a component that lies within one
//! class can be as narrow as one likes; where one component is nearly as likely as two, the parameters of the other can be
//! anything, and each of the two can be the other.

use super::data::Data;
use super::family::Family;
use super::minimise::{Minimum, minimise};

/// The searched parameters are followed so far, ln 100, in so many steps.
const REACH: f64 = 4.605_170;
const STEPS: u32 = 10;
/// Below this standard error of a searched parameter the curvature holds for the interval, which then spans less than a factor of four,
/// and nothing is followed.
const SMALL: f64 = 0.3;

/// Why a parameter has no standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Lack {
    /// The parameter lies at the end of the data.
    AtEnd,
    /// A hundred times away, upwards or downwards, ln L has fallen by this only.
    Flat { upwards: bool, fall: f64 },
    /// Decrease of ln L for one component alone, which is too small.
    Absent { fall: f64 },
    /// The curvature has no inverse, as others lack.
    Others,
}

/// Lack of information about each searched parameter; `errors` are those of the curvature.
pub(super) fn lacks(
    data: &Data,
    family: Family,
    minimum: &Minimum,
    errors: &[Option<f64>],
    z: f64,
) -> Vec<Option<Lack>> {
    if data.is_at_end(family) {
        let lack = |error: &Option<f64>| error.is_none().then_some(Lack::AtEnd);
        return errors.iter().map(lack).collect();
    }
    let is_small = |index: usize| errors[index].is_some_and(|error: f64| error < SMALL);
    let enough = 0.5 * z * z;
    if family.components == 2
        && let Some(fall) = fall_to_one(data, family, minimum).filter(|fall| *fall <= enough)
    {
        return vec![Some(Lack::Absent { fall }); minimum.at.len()];
    }
    (0..minimum.at.len())
        .map(|index| {
            // At the end of the range of a mixture's share only one law is left, and that law has been fitted already.
            let is_share = index == 0 && family.components == 2;
            if is_share || is_small(index) {
                return errors[index].is_none().then_some(Lack::Others);
            }
            let flat = [false, true].into_iter().find_map(|upwards| {
                let fall = fall(data, family, minimum, index, upwards, enough)?;
                Some(Lack::Flat { upwards, fall })
            });
            flat.or(errors[index].is_none().then_some(Lack::Others))
        })
        .collect()
}

/// Decrease of ln L from two components to the best single one.
fn fall_to_one(data: &Data, family: Family, minimum: &Minimum) -> Option<f64> {
    let single = Family {
        components: 1,
        ..family
    };
    let best = super::search(data, single).ok()?;
    Some(best.value - minimum.value)
}

/// Decrease of ln L on the way out with the others at their best; none if more than `enough`.
fn fall(
    data: &Data,
    family: Family,
    minimum: &Minimum,
    index: usize,
    upwards: bool,
    enough: f64,
) -> Option<f64> {
    let sign = if upwards { 1.0 } else { -1.0 };
    let mut others = minimum.at.clone();
    others.remove(index);
    let mut largest = 0.0_f64;
    for step in 1..=STEPS {
        let held = minimum.at[index] + sign * REACH * f64::from(step) / f64::from(STEPS);
        let whole = |others: &[f64]| {
            let mut theta = others.to_vec();
            theta.insert(index, held);
            theta
        };
        let best = minimise(
            |others| data.minus_log_likelihood(family, &whole(others)),
            &others,
        );
        // Another component may take its place, better than the first found.
        largest = largest.max(best.value - minimum.value);
        if largest.is_nan() || largest > enough {
            return None;
        }
        others = best.at;
    }
    Some(largest)
}
