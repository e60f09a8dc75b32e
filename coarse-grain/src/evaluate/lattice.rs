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
    #[inline(always)]
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

    #[inline(always)]
    pub(crate) fn at(&self, k: usize) -> f64 {
        self.first + k as f64 * self.step
    }
}

/// The next whole number at or above, within 0 and `most`.
#[inline(always)]
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

/// The grid, with its axes in the order of loops: resolved ones last, the longest of them first and that of the smallest steps at the end, so
/// that the rows of the innermost loop are long.
#[derive(Debug, Clone)]
pub(crate) struct Lattice {
    pub axes: [LatticeAxis; 3],
    /// Cartesian axis of each axis of the loops.
    pub cartesian: [usize; 3],
    /// From one point to the next along each axis of the loops, in the order of results (x before y before z).
    strides: [usize; 3],
}

impl Lattice {
    /// A grid over the resolved axes.
    pub(crate) fn new(resolved: [bool; 3], grid: &[GridAxis]) -> Self {
        let mut rest = grid.iter();
        let mut next = |cartesian: usize| {
            if resolved[cartesian] {
                rest.next()
            } else {
                None
            }
        };
        let mut stride: usize = grid.iter().map(|axis| axis.count).product();
        let mut all: Vec<(usize, LatticeAxis, usize)> = (0..3)
            .map(|cartesian| match next(cartesian) {
                Some(grid) => {
                    let (first, step) = (grid.at(0), grid.step());
                    stride /= grid.count;
                    let axis = LatticeAxis {
                        first,
                        step,
                        inverse_step: 1.0 / step,
                        count: grid.count,
                        resolved: true,
                    };
                    (cartesian, axis, stride)
                }
                None => (cartesian, LatticeAxis::UNRESOLVED, 0),
            })
            .collect();
        // Sorting keeps the order of equals, so that it is that of the results where nothing speaks against it.
        all.sort_by_key(|(_, axis, _)| axis.resolved);
        let free = all.iter().filter(|(_, axis, _)| !axis.resolved).count();
        let mut inner = 2;
        for k in (free..2).rev() {
            if all[k].1.step < 0.999 * all[inner].1.step {
                inner = k;
            }
        }
        let last = all.remove(inner);
        all.push(last);
        let length = |k: usize| all[k].1.step * all[k].1.count as f64;
        if free == 0 && length(1) > 1.001 * length(0) {
            all.swap(0, 1);
        }
        Self {
            axes: [0, 1, 2].map(|k| all[k].1),
            cartesian: [0, 1, 2].map(|k| all[k].0),
            strides: [0, 1, 2].map(|k| all[k].2),
        }
    }

    /// Whether points follow each other in the order of results.
    pub(crate) fn is_ordered(&self) -> bool {
        let [_, y, z] = &self.axes;
        let own = [y.count * z.count, z.count, 1];
        (0..3).all(|k| self.axes[k].count == 1 || self.strides[k] == own[k])
    }

    /// Where the point that stands at a place of the results comes in the loops.
    pub(crate) fn place(&self, of_results: usize) -> usize {
        (0..3).fold(0, |place, k| {
            let count = self.axes[k].count;
            // Axes that are not resolved have no stride.
            let at = of_results.checked_div(self.strides[k]).unwrap_or(0) % count;
            place * count + at
        })
    }

    /// The point that stands at a place of the results, in the order of loops.
    pub(crate) fn point(&self, place: usize) -> DVec3 {
        let at = |k: usize| {
            let axis = &self.axes[k];
            if axis.resolved {
                axis.at(place / self.strides[k] % axis.count)
            } else {
                0.0
            }
        };
        DVec3::new(at(0), at(1), at(2))
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
    fn rows_are_fine_and_the_longest_axis_is_first() {
        let axis = |max: f64, count: usize| GridAxis {
            min: 0.0,
            max,
            count,
        };
        // Steps 0.5, 0.25, 1 and lengths 1, 1, 3.
        let lattice = Lattice::new([true; 3], &[axis(1.0, 2), axis(1.0, 4), axis(3.0, 3)]);
        assert_eq!(
            (lattice.cartesian, lattice.strides),
            ([2, 0, 1], [1, 12, 3])
        );
        assert!(!lattice.is_ordered());
        let mut places: Vec<usize> = (0..24).map(|place| lattice.place(place)).collect();
        // Loops go over z, x, y; results over x, y, z.
        assert_eq!(places[..5], [0, 8, 16, 1, 9]);
        // Place 4: x = 0, y = 1, z = 1.
        assert_eq!(lattice.point(4), DVec3::new(1.5, 0.25, 0.375));
        places.sort_unstable();
        assert!(places.into_iter().eq(0..24));
        let even = Lattice::new([true; 3], &[axis(1.0, 2), axis(1.0, 2), axis(1.0, 2)]);
        assert_eq!(even.cartesian, [0, 1, 2]);
        assert!(even.is_ordered());
        let plane = Lattice::new([true, false, true], &[axis(1.0, 9), axis(1.0, 3)]);
        assert_eq!((plane.cartesian, plane.is_ordered()), ([1, 2, 0], false));
    }

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
