//! To the top of a distance field.

use glam::DVec3;

/// The number of slopes that the model keeps, beside those of the given constraints.
const MOST_CUTS: usize = 14;
/// Evaluations of the field per ascent.
const MOST_STEPS: usize = 300;

/// A linear upper model of the field: `excess` above the value at the centre, and the slope there.
#[derive(Clone, Copy)]
pub(crate) struct Cut {
    pub(crate) excess: f64,
    pub(crate) slope: DVec3,
}

/// A function of places with slopes of length 1, the least of many distances.
pub(crate) trait DistanceField {
    /// Value and slope.
    fn at(&self, x: DVec3) -> (f64, DVec3);

    /// The distances that are known beforehand and at most `limit` at x: their values above `value`, and slopes. They are added to what the
    /// ascent learns; none are needed.
    fn known(&self, _x: DVec3, _value: f64, _limit: f64) -> Vec<Cut> {
        Vec::new()
    }
}

impl<F: Fn(DVec3) -> (f64, DVec3)> DistanceField for F {
    fn at(&self, x: DVec3) -> (f64, DVec3) {
        self(x)
    }
}

/// A local maximum of a field with slopes of length 1, near `start`: its place and value.
///
/// A distance field is the least of many distances, so it has ridges where gradients jump. A proximal bundle method climbs them: the
/// field is modelled by the least of the linear functions seen so far, and each step goes to where the model less
/// `|step|²/(2 reach)` is largest (Kiwiel 1990, doi:10.1007/BF01585731). For a polyhedron the functions are exact near a
/// maximum and the method ends after few steps.
///
/// The result is never lower than the start.
pub(crate) fn ascend(field: &impl DistanceField, start: DVec3, reach: f64) -> (DVec3, f64) {
    let farthest = reach;
    let mut reach = reach;
    let mut centre = start;
    let (mut value, slope) = field.at(centre);
    let mut cuts = vec![Cut { excess: 0.0, slope }];
    let mut idle = 0;
    for _ in 0..MOST_STEPS {
        let mut model = field.known(centre, value, value + 2.0 * reach);
        model.extend(&cuts);
        let (step, rise) = model_step(&model, reach);
        if rise <= 1e-13 {
            break;
        }
        let (there, slope) = field.at(centre + step);
        if there - value >= 0.2 * rise {
            for cut in &mut cuts {
                // The field is not concave: a slope from elsewhere may lie below the field here, and is of no use then.
                cut.excess = (cut.excess + cut.slope.dot(step) - (there - value)).max(0.0);
            }
            centre += step;
            value = there;
            reach = (2.0 * reach).min(farthest);
            cuts.push(Cut { excess: 0.0, slope });
            idle = 0;
        } else {
            let excess = (there - slope.dot(step) - value).max(0.0);
            cuts.push(Cut { excess, slope });
            idle += 1;
            if idle % 10 == 0 {
                // Slopes from too far away mislead: start anew, nearer.
                reach *= 0.1;
                let (_, slope) = field.at(centre);
                cuts = vec![Cut { excess: 0.0, slope }];
            }
        }
        if cuts.len() > MOST_CUTS {
            // The one highest above the field binds least.
            let mut worst = 0;
            for (k, cut) in cuts.iter().enumerate() {
                if cut.excess > cuts[worst].excess {
                    worst = k;
                }
            }
            cuts.remove(worst);
        }
    }
    (centre, value)
}

/// The step s that maximises `min_i(excess_i + slope_i·s) - s²/(2 reach)`, and the rise of the model there.
///
/// The dual, over weights w on the simplex, is `min w·excess + reach |sum w slope|²/2`, with s = reach sum w slope;
/// weight is moved from the largest to the smallest derivative, as far as pays.
fn model_step(cuts: &[Cut], reach: f64) -> (DVec3, f64) {
    let mut weights = vec![0.0; cuts.len()];
    weights[cuts.len() - 1] = 1.0;
    let mut sum = cuts[cuts.len() - 1].slope;
    for _ in 0..200 {
        let (mut low, mut high) = ((f64::INFINITY, 0), (f64::NEG_INFINITY, 0));
        for (k, cut) in cuts.iter().enumerate() {
            let derivative = cut.excess + reach * cut.slope.dot(sum);
            if derivative < low.0 {
                low = (derivative, k);
            }
            if weights[k] > 0.0 && derivative > high.0 {
                high = (derivative, k);
            }
        }
        let gap = high.0 - low.0;
        if gap <= 1e-15 {
            break;
        }
        let turn = cuts[low.1].slope - cuts[high.1].slope;
        let curvature = reach * turn.length_squared();
        let moved = if curvature > 0.0 {
            (gap / curvature).min(weights[high.1])
        } else {
            weights[high.1]
        };
        weights[low.1] += moved;
        weights[high.1] = if moved == weights[high.1] {
            0.0
        } else {
            weights[high.1] - moved
        };
        sum += turn * moved;
    }
    let step = reach * sum;
    let rise = cuts
        .iter()
        .map(|cut| cut.excess + cut.slope.dot(step))
        .fold(f64::INFINITY, f64::min);
    (step, rise)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The distance inside a cube of edge 2, from its nearest face.
    fn cube(p: DVec3) -> (f64, DVec3) {
        let a = p.abs();
        let axis = [DVec3::X, DVec3::Y, DVec3::Z][a.max_position()];
        (1.0 - a.max_element(), -axis * p.dot(axis).signum())
    }

    #[test]
    fn the_centre_of_a_cube_is_found_to_round_off() {
        for start in [
            DVec3::new(0.3, -0.2, 0.4),
            DVec3::new(0.9, 0.9, -0.9),
            DVec3::ZERO,
        ] {
            let (top, value) = ascend(&cube, start, 0.5);
            assert!(top.length() < 1e-11, "from {start}: {top}");
            assert!((value - 1.0).abs() < 1e-12, "{value}");
        }
    }

    #[test]
    fn a_smooth_top_is_found_to_half_the_digits() {
        // -|p|²/2 near the origin, slope 1 farther out (as a distance has everywhere): value 0 at the top.
        let field = |p: DVec3| {
            let r = p.length();
            if r < 1.0 {
                (-0.5 * r * r, -p)
            } else {
                (0.5 - r, -p / r)
            }
        };
        let (top, value) = ascend(&field, DVec3::new(1.5, 0.7, -0.3), 0.5);
        assert!(top.length() < 1e-6 && value > -1e-12, "{top} {value}");
    }
}
