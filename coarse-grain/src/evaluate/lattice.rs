//! A grid of points along up to three axes, the resolved ones last.

use std::ops::Range;

use glam::DVec3;

use crate::coordinates::GridAxis;

/// One axis of the grid; one that is not resolved has a single point at 0, where everything is projected.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LatticeAxis {
    pub first: f64,
    pub step: f64,
    pub inverse_step: f64,
    pub count: usize,
    pub resolved: bool,
}

impl LatticeAxis {
    const UNRESOLVED: Self = Self {
        first: 0.0,
        step: 1.0,
        inverse_step: 1.0,
        count: 1,
        resolved: false,
    };

    /// The points between two coordinates.
    #[inline]
    pub(crate) fn between(&self, low: f64, high: f64) -> Range<usize> {
        let begin = whole((low - self.first) * self.inverse_step, self.count);
        let scaled = (high - self.first) * self.inverse_step;
        let mut end = whole(scaled, self.count);
        // One more where the upper end is a point itself.
        if end < self.count && end as f64 <= scaled {
            end += 1;
        }
        begin..end.max(begin)
    }

    #[inline]
    pub(crate) fn at(&self, k: usize) -> f64 {
        self.first + k as f64 * self.step
    }
}

/// The next whole number at or above, within 0 and `most`.
#[inline]
fn whole(x: f64, most: usize) -> usize {
    if x <= 0.0 {
        return 0;
    }
    if x >= most as f64 {
        return most;
    }
    // A cast is faster than `ceil` on processors without that instruction.
    let down = x as usize;
    down + usize::from((down as f64) < x)
}

/// The grid, with its axes in the order of loops: resolved ones last, so that the innermost loop is long.
#[derive(Debug, Clone)]
pub(crate) struct Lattice {
    pub axes: [LatticeAxis; 3],
    /// Of each axis of the loops the Cartesian axis.
    pub cartesian: [usize; 3],
}

impl Lattice {
    /// A grid over the resolved axes.
    pub(crate) fn new(resolved: [bool; 3], grid: &[GridAxis]) -> Self {
        let mut cartesian: Vec<usize> = (0..3).filter(|&axis| !resolved[axis]).collect();
        let mut axes = vec![LatticeAxis::UNRESOLVED; cartesian.len()];
        let resolved = (0..3).filter(|&axis| resolved[axis]);
        for (axis, grid) in resolved.zip(grid) {
            cartesian.push(axis);
            let (first, step) = (grid.at(0), grid.step());
            axes.push(LatticeAxis {
                first,
                step,
                inverse_step: 1.0 / step,
                count: grid.count,
                resolved: true,
            });
        }
        Self {
            axes: [axes[0], axes[1], axes[2]],
            cartesian: [cartesian[0], cartesian[1], cartesian[2]],
        }
    }

    /// The number of points.
    pub(crate) fn len(&self) -> usize {
        self.axes.iter().map(|axis| axis.count).product()
    }

    /// A vector in the order of the loops, without its parts along axes that are not resolved.
    pub(crate) fn project(&self, v: DVec3) -> DVec3 {
        let part = |k: usize| {
            if self.axes[k].resolved {
                v[self.cartesian[k]]
            } else {
                0.0
            }
        };
        DVec3::new(part(0), part(1), part(2))
    }

    /// The box of the points, in the order of the loops.
    pub(crate) fn bounds(&self) -> (DVec3, DVec3) {
        let ends = |last: bool| {
            let end = |axis: &LatticeAxis| {
                if last {
                    axis.at(axis.count - 1)
                } else {
                    axis.first
                }
            };
            DVec3::new(end(&self.axes[0]), end(&self.axes[1]), end(&self.axes[2]))
        };
        (ends(false), ends(true))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_between_are_those_between() {
        let axis = LatticeAxis {
            first: 0.5,
            step: 1.0,
            inverse_step: 1.0,
            count: 4,
            resolved: true,
        };
        for (low, high, expected) in [
            (0.4, 0.6, 0..1),
            (0.5, 0.5, 0..1),
            (0.6, 1.4, 1..1),
            (-9.0, 9.0, 0..4),
            (3.5, 9.0, 3..4),
            (3.6, 9.0, 4..4),
            (-9.0, 0.4, 0..0),
            (1.5, 2.5, 1..3),
        ] {
            assert_eq!(axis.between(low, high), expected, "{low} {high}");
        }
    }
}
