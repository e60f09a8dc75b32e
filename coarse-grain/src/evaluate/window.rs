//! The region in which a kernel or a cut line integral is not zero, row by row of a grid.

use std::ops::Range;

use glam::DVec3;

use super::lattice::{Lattice, LatticeAxis};
use crate::kernel::{Kernel, LineCut};

/// The points of a row of the grid that a window holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Span {
    /// Where the row is along the first axis.
    pub i: u32,
    /// Where it is along the second.
    pub j: u32,
    /// The first of its points.
    pub first: u32,
    /// How many.
    pub count: u32,
}

/// The spans of a window; kept, so that their memory is.
#[derive(Debug, Default)]
pub(crate) struct Spans {
    pub all: Vec<Span>,
    firsts: Vec<f64>,
    ends: Vec<f64>,
}

/// Added to a number it rounds it to a whole one.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// A ball, or an ellipsoid or capped cylinder around a segment.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Window {
    direction: DVec3,
    /// 1 - (transverse half axis / half axis along)^2: 0 for a ball, 1 for a cylinder.
    flatness: f64,
    reach_squared: f64,
    /// 1 - flatness nz^2, and its inverse.
    steepness: f64,
    inverse: f64,
    /// A cylinder ends here, measured from the middle.
    cap: Option<f64>,
    /// Half sizes of the box around it.
    pub half: DVec3,
}

impl Window {
    /// The region of a particle.
    pub(crate) fn ball(kernel: &Kernel) -> Self {
        let reach = kernel.reach();
        Self {
            direction: DVec3::ZERO,
            flatness: 0.0,
            reach_squared: reach * reach,
            steepness: 1.0,
            inverse: 1.0,
            cap: None,
            half: DVec3::splat(reach),
        }
    }

    /// The region of a segment.
    pub(crate) fn around(kernel: &Kernel, segment: DVec3) -> Self {
        let length = segment.length();
        let ball = Self::ball(kernel);
        if length <= 1e-10 * kernel.choice().width {
            return ball;
        }
        let (reach, half) = (kernel.reach(), kernel.reach() + 0.5 * length);
        let direction = segment / length;
        // Polynomials end on their own; a cylinder holds all of them.
        let cylinder =
            kernel.polynomial().is_some() || kernel.choice().line_cut == LineCut::Cylinder;
        let flatness = if cylinder {
            1.0
        } else {
            1.0 - (reach / half) * (reach / half)
        };
        let steepness = 1.0 - flatness * direction.z * direction.z;
        let bounds = if cylinder {
            DVec3::splat(reach) + 0.5 * segment.abs()
        } else {
            let along = direction * direction * (half * half - reach * reach);
            (along + DVec3::splat(reach * reach)).map(f64::sqrt)
        };
        Self {
            direction,
            flatness,
            reach_squared: reach * reach,
            steepness,
            inverse: 1.0 / steepness,
            cap: cylinder.then_some(half),
            half: bounds,
        }
    }

    /// All rows of `own`, a part of the grid, that have points in the window around `centre`.
    pub(crate) fn spans(
        &self,
        lattice: &Lattice,
        centre: DVec3,
        own: &[Range<usize>; 3],
        spans: &mut Spans,
    ) {
        let [x, y, z] = &lattice.axes;
        spans.all.clear();
        for i in own[0].clone() {
            let dx = x.at(i) - centre.x;
            self.bounds(dx, [y, z], centre, own, spans);
            let bounds = spans.firsts.iter().zip(&spans.ends);
            for (j, (&first, &end)) in own[1].clone().zip(bounds) {
                if first < end {
                    spans.all.push(Span {
                        i: i as u32,
                        j: j as u32,
                        first: first as u32,
                        count: (end - first) as u32,
                    });
                }
            }
        }
    }

    /// First point and end of each row at `dx`, as whole numbers. Without branches, so that the processor works on several rows at once.
    #[inline]
    fn bounds(
        &self,
        dx: f64,
        [y, z]: [&LatticeAxis; 2],
        centre: DVec3,
        own: &[Range<usize>; 3],
        spans: &mut Spans,
    ) {
        let count = own[1].len();
        spans.firsts.resize(count, 0.0);
        spans.ends.resize(count, 0.0);
        let (begin, end) = (own[2].start as f64, own[2].end as f64);
        let above = (centre.z - z.first) * z.inverse_step;
        let rows = spans.firsts.iter_mut().zip(&mut spans.ends);
        let n = self.direction;
        let is_awkward = self.steepness <= 1e-12 || n.z.abs() <= 1e-12;
        if self.cap.is_some() && is_awkward {
            for (j, (first, last)) in own[1].clone().zip(rows) {
                (*first, *last) = match self.row(dx, y.at(j) - centre.y) {
                    Some((low, high)) => {
                        let range = z.between(centre.z + low, centre.z + high);
                        ((range.start as f64).max(begin), (range.end as f64).min(end))
                    }
                    None => (begin, begin),
                };
            }
            return;
        }
        // Along a row the caps are this far from where it passes the middle.
        let (slant, cap) = match self.cap {
            Some(cap) => (1.0 / n.z, cap / n.z.abs()),
            None => (0.0, f64::INFINITY),
        };
        // The formulas of `row`; for a ball they give the same with a flatness of 0.
        let row = own[1].start as u32;
        let (x_across, x_along) = (self.reach_squared - dx * dx, n.x * dx);
        for (k, (first, last)) in rows.enumerate() {
            let dy = y.first + f64::from(row + k as u32) * y.step - centre.y;
            let along = x_along + n.y * dy;
            let rest = x_across - dy * dy + self.flatness * along * along;
            let middle = self.flatness * along * n.z;
            let square = middle * middle + self.steepness * rest;
            let height = square.max(0.0).sqrt();
            let between = -along * slant;
            let low = ((middle - height) * self.inverse).max(between - cap);
            let high = ((middle + height) * self.inverse).min(between + cap);
            let low = (above + low * z.inverse_step).max(begin).min(end);
            let high = (above + high * z.inverse_step)
                .max(begin - 1.0)
                .min(end - 1.0);
            let (down, up) = ((low + ROUND) - ROUND, (high + ROUND) - ROUND);
            let ceil = down + if down < low { 1.0 } else { 0.0 };
            let floor = up - if up > high { 1.0 } else { 0.0 };
            *first = ceil;
            *last = if square >= 0.0 { floor + 1.0 } else { begin };
        }
    }

    /// Where the row at `dx`, `dy` from the middle lies inside, as heights above the middle.
    #[inline]
    pub(crate) fn row(&self, dx: f64, dy: f64) -> Option<(f64, f64)> {
        let across = dx * dx + dy * dy;
        if self.flatness == 0.0 {
            let rest = self.reach_squared - across;
            if rest < 0.0 {
                return None;
            }
            let height = rest.sqrt();
            return Some((-height, height));
        }
        let along = self.direction.x * dx + self.direction.y * dy;
        let rest = self.reach_squared - across + self.flatness * along * along;
        let (mut low, mut high) = if self.steepness > 1e-12 {
            let middle = self.flatness * along * self.direction.z;
            let square = middle * middle + self.steepness * rest;
            if square < 0.0 {
                return None;
            }
            let height = square.sqrt();
            (
                (middle - height) * self.inverse,
                (middle + height) * self.inverse,
            )
        } else if rest >= 0.0 {
            (f64::NEG_INFINITY, f64::INFINITY)
        } else {
            return None;
        };
        if let Some(cap) = self.cap {
            let z = self.direction.z;
            if z.abs() > 1e-12 {
                let (a, b) = ((-cap - along) / z, (cap - along) / z);
                low = low.max(a.min(b));
                high = high.min(a.max(b));
            } else if along.abs() > cap {
                return None;
            }
        }
        (low <= high).then_some((low, high))
    }
}
