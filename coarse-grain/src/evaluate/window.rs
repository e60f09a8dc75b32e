//! The region in which a kernel or a cut line integral is not zero, row by row of a grid.

use std::ops::Range;

use glam::DVec3;

use super::lattice::LatticeAxis;
use crate::kernel::{Kernel, LineCut};

/// Points of a window in each row of a plane of the grid; kept, so that its memory is.
#[derive(Debug, Default)]
pub(crate) struct Bounds {
    firsts: Vec<[u32; LANES]>,
    ends: Vec<[u32; LANES]>,
}

impl Bounds {
    /// Memory for this many rows.
    #[inline(always)]
    fn hold(&mut self, rows: usize) -> (&mut [[u32; LANES]], &mut [[u32; LANES]]) {
        let groups = rows.div_ceil(LANES);
        if self.firsts.len() < groups {
            self.firsts.resize(groups, [0; LANES]);
            self.ends.resize(groups, [0; LANES]);
        }
        (&mut self.firsts[..groups], &mut self.ends[..groups])
    }

    /// First point and end of each row, in order; the end lies before or at the first point where there is none. Valid for the
    /// rows of the plane that was requested last; other rows follow behind them.
    #[inline(always)]
    pub(crate) fn iter(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        let (firsts, ends) = (self.firsts.as_flattened(), self.ends.as_flattened());
        firsts.iter().copied().zip(ends.iter().copied())
    }
}

/// Rows whose bounds are found at once.
const LANES: usize = 4;

/// Added to a number it rounds it to a whole one, which then stands in the last bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// Added before rounding it rounds up: points may lie outside by 1e-11 of their distance.
const NEARLY_HALF: f64 = 0.5 - 1e-11;

/// The larger of two numbers; unlike `f64::max` one instruction, since its result for NaN is not specified.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The smaller of two numbers.
#[inline(always)]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

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
    #[inline(always)]
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

    /// Points of `own`, a part of the grid, in the window around `centre` in its plane `i`.
    #[inline(always)]
    pub(crate) fn plane(
        &self,
        axes: &[LatticeAxis; 3],
        centre: DVec3,
        i: usize,
        own: &[Range<usize>; 3],
        bounds: &mut Bounds,
    ) {
        let dx = axes[0].at(i) - centre.x;
        match self.cap {
            None => self.rows::<false>(axes, centre, dx, own, bounds),
            // A cylinder along the rows or across them: divisions by zero.
            Some(_) if self.steepness <= 1e-12 || self.direction.z.abs() <= 1e-12 => {
                self.single_rows(axes, centre, dx, own, bounds);
            }
            Some(_) => self.rows::<true>(axes, centre, dx, own, bounds),
        }
    }

    fn single_rows(
        &self,
        [_, y, z]: &[LatticeAxis; 3],
        centre: DVec3,
        dx: f64,
        own: &[Range<usize>; 3],
        bounds: &mut Bounds,
    ) {
        let (firsts, ends) = bounds.hold(own[1].len());
        let found = firsts
            .as_flattened_mut()
            .iter_mut()
            .zip(ends.as_flattened_mut());
        for (j, (first, end)) in own[1].clone().zip(found) {
            (*first, *end) = (0, 0);
            if let Some((low, high)) = self.row(dx, y.at(j) - centre.y) {
                let range = z.between(centre.z + low, centre.z + high);
                *first = range.start.max(own[2].start) as u32;
                *end = range.end.min(own[2].end) as u32;
            }
        }
    }

    /// The formulas of [`Self::row`], for several rows at once and without branches; for a ball they hold with a flatness of 0.
    ///
    /// With a = n . d for what is known of the distance d from the middle, row by row: the middle of what lies inside is flatness nz a / steepness, its half
    /// length the root of reach^2 - dx^2 - dy^2 + flatness a^2 / steepness, over the root of the steepness. The one is linear in dy, the other a root of
    /// a polynomial of degree two. Heights are counted in points from the first of the row.
    #[inline(always)]
    fn rows<const CAPPED: bool>(
        &self,
        [_, y, z]: &[LatticeAxis; 3],
        centre: DVec3,
        dx: f64,
        own: &[Range<usize>; 3],
        bounds: &mut Bounds,
    ) {
        let n = self.direction;
        let (begin, end) = (own[2].start as f64, own[2].end as f64);
        let most = end - 1.0;
        let above = (centre.z - z.first) * z.inverse_step;
        let scale = self.inverse * z.inverse_step;
        let along = n.x * dx;
        let steep = self.flatness * n.z * scale;
        let middle = [above + steep * along, steep * n.y];
        let scale = scale * scale;
        let square = [
            scale
                * (self.steepness * (self.reach_squared - dx * dx) + self.flatness * along * along),
            scale * 2.0 * self.flatness * along * n.y,
            scale * (self.flatness * n.y * n.y - self.steepness),
        ];
        // Along a row the caps are this far from where it passes the middle plane.
        let (between, cap) = match self.cap {
            Some(cap) if CAPPED => {
                let slant = z.inverse_step / n.z;
                ([above - along * slant, -n.y * slant], cap * slant.abs())
            }
            _ => ([0.0; 2], 0.0),
        };
        let (firsts, ends) = bounds.hold(own[1].len());
        let mut row = own[1].start as f64;
        let from = y.first - centre.y;
        for (firsts, ends) in firsts.iter_mut().zip(ends) {
            for k in 0..LANES {
                let dy = from + (row + k as f64) * y.step;
                let square = square[0] + (square[1] + square[2] * dy) * dy;
                let height = larger(square, 0.0).sqrt();
                let middle = middle[0] + middle[1] * dy;
                let (mut low, mut high) = (middle - height, middle + height);
                if CAPPED {
                    let between = between[0] + between[1] * dy;
                    low = larger(low, between - cap);
                    high = smaller(high, between + cap);
                }
                let low = smaller(larger(low, begin), end) + NEARLY_HALF;
                let high = larger(smaller(high, most), -1.0) - NEARLY_HALF;
                firsts[k] = (low + ROUND).to_bits() as u32;
                let last = (high + (ROUND + 1.0)).to_bits() as u32;
                ends[k] = if square >= 0.0 { last } else { 0 };
            }
            row += LANES as f64;
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
