//! Cutting, squeezing and scaling a distribution, with what that changed.

use super::classes::Classes;
use super::distribution::{Form, SizeDistribution};
use super::laws::{CutLaw, Law};
use crate::scene::Weighting;

/// The classes that a law is divided into where its formula does not survive a change.
pub const CLASSES_OF_A_LAW: usize = 1000;

/// Effect of a change on a distribution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effect {
    /// Share of the particles, by number, that is no longer there.
    pub removed_number: f64,
    /// Share of the volume that is no longer there.
    pub removed_volume: f64,
    /// d10, d50 and d90 before, m, in the weighting of the change.
    pub before: [f64; 3],
    /// These three diameters after the change.
    pub after: [f64; 3],
    /// Number of classes into which a law was divided, where it had to be.
    pub classes: Option<usize>,
}

/// A change that leaves nothing.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ChangeError {
    /// The quantiles bound nothing.
    #[error("nothing lies between the quantiles {low} and {high}: give 0 <= low < high <= 1")]
    Empty {
        /// Lower quantile.
        low: f64,
        /// Upper quantile.
        high: f64,
    },
    /// The factor is no factor.
    #[error("the factor {0} must be above 0 and finite")]
    Factor(f64),
    /// The squeeze would make diameters that are not above 0.
    #[error(
        "a squeeze by {factor} makes the smallest diameter {smallest} m: choose a factor below {limit}"
    )]
    Squeeze {
        /// The factor.
        factor: f64,
        /// Smallest diameter after the change, m.
        smallest: f64,
        /// The factor that makes it 0.
        limit: f64,
    },
}

fn deciles(sizes: &SizeDistribution, weighting: Weighting) -> [f64; 3] {
    let view = sizes.by(weighting);
    [0.1, 0.5, 0.9].map(|u| view.quantile(u))
}

fn effect(
    before: &SizeDistribution,
    after: &SizeDistribution,
    removed: [f64; 2],
    weighting: Weighting,
) -> Effect {
    Effect {
        removed_number: removed[0],
        removed_volume: removed[1],
        before: deciles(before, weighting),
        after: deciles(after, weighting),
        classes: None,
    }
}

/// Leaves what lies between two quantiles of a weighting; exact for every distribution.
///
/// # Errors
/// [`ChangeError::Empty`].
pub fn cut(
    sizes: &SizeDistribution,
    weighting: Weighting,
    low: f64,
    high: f64,
) -> Result<(SizeDistribution, Effect), ChangeError> {
    let empty = ChangeError::Empty { low, high };
    if !(0.0 <= low && low < high && high <= 1.0) {
        return Err(empty);
    }
    let view = sizes.by(weighting);
    let (a, b) = (view.quantile(low), view.quantile(high));
    let after = between(sizes, a, b).ok_or(empty)?;
    let removed = [Weighting::Number, Weighting::Volume].map(|w| {
        let view = sizes.by(w);
        let above = if b >= sizes.largest() {
            0.0
        } else {
            1.0 - view.cdf(b)
        };
        let below = if a <= sizes.smallest() {
            0.0
        } else {
            view.cdf(a)
        };
        below + above
    });
    let effect = effect(sizes, &after, removed, weighting);
    Ok((after, effect))
}

/// Part of the distribution in [a, b]; `None` if there is none.
fn between(sizes: &SizeDistribution, a: f64, b: f64) -> Option<SizeDistribution> {
    match sizes.form() {
        Form::Classes(classes) => {
            let classes = classes.between(a, b).ok()?;
            Some(SizeDistribution::from_classes(classes, sizes.weighting()))
        }
        Form::Law(law) => {
            let stated = sizes.by(sizes.weighting());
            let (below, up_to) = (stated.cdf(a), stated.cdf(b));
            let [low, high] = law.bounds;
            let at_atom = matches!(law.law, Law::Monodisperse(d) if a <= d && d <= b);
            if at_atom {
                return Some(sizes.clone());
            }
            (up_to > below).then(|| {
                SizeDistribution::of_law(
                    CutLaw {
                        bounds: [low + below * (high - low), low + up_to * (high - low)],
                        smallest: law.smallest.max(a),
                        largest: law.largest.min(b),
                        ..*law
                    },
                    sizes.weighting(),
                )
            })
        }
        Form::Mixture(parts) => {
            let parts = parts.iter().filter_map(|(share, part)| {
                let view = part.by(Weighting::Number);
                let left = if a <= part.smallest() {
                    0.0
                } else {
                    view.cdf(a)
                };
                Some((share * (view.cdf(b) - left), between(part, a, b)?))
            });
            let mixture = SizeDistribution::mixture(parts.collect(), Weighting::Number)?;
            Some(mixture.stated_by(sizes.weighting()))
        }
    }
}

/// Multiplies all diameters; exact for every distribution.
///
/// # Errors
/// [`ChangeError::Factor`].
pub fn scale(
    sizes: &SizeDistribution,
    factor: f64,
) -> Result<(SizeDistribution, Effect), ChangeError> {
    if !(factor > 0.0 && factor.is_finite()) {
        return Err(ChangeError::Factor(factor));
    }
    let after = scaled(sizes, factor).ok_or(ChangeError::Factor(factor))?;
    let effect = effect(sizes, &after, [0.0; 2], sizes.weighting());
    Ok((after, effect))
}

fn scaled(sizes: &SizeDistribution, factor: f64) -> Option<SizeDistribution> {
    match sizes.form() {
        Form::Classes(classes) => {
            let classes = classes.moved(|d| factor * d).ok()?;
            Some(SizeDistribution::from_classes(classes, sizes.weighting()))
        }
        Form::Law(law) => Some(SizeDistribution::of_law(
            CutLaw {
                law: law.law.scaled(factor),
                smallest: factor * law.smallest,
                largest: factor * law.largest,
                ..*law
            },
            sizes.weighting(),
        )),
        Form::Mixture(parts) => {
            let parts: Option<Vec<_>> = parts
                .iter()
                .map(|(share, part)| Some((*share, scaled(part, factor)?)))
                .collect();
            let mixture = SizeDistribution::mixture(parts?, Weighting::Number)?;
            Some(mixture.stated_by(sizes.weighting()))
        }
    }
}

/// Brings all diameters nearer to the median of a weighting (or farther, for a factor above 1): d becomes
/// d50 + factor (d - d50), every particle keeps its place in the order. A law is divided into classes first.
///
/// # Errors
/// [`ChangeError::Factor`], [`ChangeError::Squeeze`].
pub fn squeeze(
    sizes: &SizeDistribution,
    weighting: Weighting,
    factor: f64,
) -> Result<(SizeDistribution, Effect), ChangeError> {
    if !(factor > 0.0 && factor.is_finite()) {
        return Err(ChangeError::Factor(factor));
    }
    let median = sizes.by(weighting).quantile(0.5);
    let smallest = median + factor * (sizes.smallest() - median);
    if smallest <= 0.0 {
        return Err(ChangeError::Squeeze {
            factor,
            smallest,
            limit: median / (median - sizes.smallest()),
        });
    }
    let (classes, divided) = match sizes.classes() {
        Some(classes) => (classes.clone(), None),
        None => match divided(sizes, weighting, CLASSES_OF_A_LAW) {
            Some(classes) => (classes, Some(CLASSES_OF_A_LAW)),
            // One size is its own median.
            None => {
                let effect = effect(sizes, sizes, [0.0; 2], weighting);
                return Ok((sizes.clone(), effect));
            }
        },
    };
    let squeezed = classes.moved(|d| median + factor * (d - median));
    let squeezed = squeezed.map_err(|_| ChangeError::Factor(factor))?;
    let after = SizeDistribution::from_classes(squeezed, sizes.weighting());
    let effect = effect(sizes, &after, [0.0; 2], weighting);
    let effect = Effect {
        classes: divided,
        ..effect
    };
    Ok((after, effect))
}

/// A distribution as `count` classes of equal share of a quantity, divided further where parts of a mixture begin and end;
/// `None` where it is one size. The number of particles
/// in each class is exact, so the shares by number are; sizes are spread evenly inside each.
#[must_use]
pub fn divided(sizes: &SizeDistribution, weighting: Weighting, count: usize) -> Option<Classes> {
    let view = sizes.by(weighting);
    let mut edges: Vec<f64> = (0..=count)
        .map(|i| view.quantile(i as f64 / count as f64))
        .collect();
    edges.extend(ends_of_parts(sizes));
    edges.sort_by(f64::total_cmp);
    edges.dedup();
    let number = sizes.by(Weighting::Number);
    let shares: Vec<f64> = edges
        .windows(2)
        .map(|class| (number.cdf(class[1]) - number.cdf(class[0])).max(0.0))
        .collect();
    Classes::new(
        &edges,
        &shares,
        Weighting::Number,
        super::ClassModel::default(),
    )
    .ok()
}

/// Where the density of a mixture jumps: gaps are not spread over.
fn ends_of_parts(sizes: &SizeDistribution) -> Vec<f64> {
    match sizes.form() {
        Form::Law(law) => vec![law.smallest, law.largest],
        Form::Classes(classes) => classes.edges().to_vec(),
        Form::Mixture(parts) => parts
            .iter()
            .flat_map(|(_, part)| ends_of_parts(part))
            .collect(),
    }
}
