//! Periodic images of a particle that meet a wall.
//!
//! A wall stands where its motion puts it, less whole periods, so that it stays within half a period of where it covers the domain best.
//! From there it is met by all images that may come near, however far it has gone.

use glam::DVec3;

use super::near_box::Corners;
use super::{Pose, Shape, WallState};
use crate::cell::{Cell, image};

/// Excess over half a period (in periods) at which places still count as within it: a place at the very face stays where it is.
const FACE: f64 = 1e-6;

/// Beyond its faces a particle of the domain feels less far than this, in periods: its radius, the skin and the range of forces
/// fit into half a period ([`crate::neighbours::Skin::first`]).
const REACH: f64 = 0.5;

/// Lack to a period (in periods) at which a surface still counts as spanning it.
const SPANS: f64 = 1e-9;

/// How a wall is met along one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Along {
    /// Where particles are: the axis is not periodic, or the surface has no end along it.
    Once,
    /// The image that is between the faces of a mesh that goes on for ever.
    BetweenFaces,
    /// Every image that may come near.
    All,
}

/// Images that meet a wall.
#[derive(Debug, Clone)]
pub(super) struct MetBy {
    along: [Along; 3],
    /// Middle of the surface in its own frame, m; along axes without an end that of the domain.
    middle: DVec3,
    /// Translation of the middle into the domain, m: whole periods.
    home: DVec3,
    codes: Vec<u32>,
    /// Whether the motion of the wall leaves the direction of each axis as it is.
    keeps_axis: [bool; 3],
    /// Whether places of the surface may lie on its own images: it is as long as a period or longer.
    may_join: bool,
}

impl MetBy {
    /// Before the position of the wall is known. `keeps_axis`: whether the motion leaves the direction of each axis as it is.
    pub(super) fn new(shape: &Shape, cell: &Cell, keeps_axis: [bool; 3]) -> Self {
        let (low, high) = shape.bounds();
        let domain = cell.middle();
        let along = [0, 1, 2].map(|axis| {
            let continued = match shape {
                Shape::Mesh(mesh) => mesh.periods().iter().any(|period| period.axis == axis),
                _ => false,
            };
            let extent = high[axis] - low[axis];
            if !cell.is_periodic(axis) || !extent.is_finite() {
                Along::Once
            } else if continued {
                Along::BetweenFaces
            } else {
                Along::All
            }
        });
        // Endless ones cross their images at most, as spheres do.
        let is_bounded = (high - low).is_finite() && !matches!(shape, Shape::Sphere(_));
        let may_join = is_bounded
            && (0..3).any(|axis| {
                let turned = if keeps_axis[axis] {
                    high[axis] - low[axis]
                } else {
                    low.distance(high)
                };
                along[axis] == Along::All && turned >= cell.size()[axis] * (1.0 - SPANS)
            });
        let (mut middle, mut home) = (domain, DVec3::ZERO);
        for axis in 0..3 {
            if (high[axis] - low[axis]).is_finite() {
                middle[axis] = 0.5 * (low[axis] + high[axis]);
            }
            let beside = (middle[axis] - domain[axis]) / cell.size()[axis];
            if beside.abs() > 0.5 + FACE {
                home[axis] = -beside.round() * cell.size()[axis];
            }
        }
        Self {
            along,
            middle,
            home,
            codes: Vec::new(),
            keeps_axis,
            may_join,
        }
    }

    /// Images for another shape of the wall.
    pub(super) fn of_shape(&self, shape: &Shape, cell: &Cell) -> Self {
        Self::new(shape, cell, self.keeps_axis)
    }

    /// Whether places of the surface may lie on its own images.
    pub(super) fn may_join(&self) -> bool {
        self.may_join
    }

    /// The code that goes with the same copy of the wall as `code` once the particle is `way` farther and the wall `back`, whole periods, m.
    pub(super) fn renamed(&self, code: u32, way: DVec3, back: DVec3, cell: &Cell) -> u32 {
        (0..3).fold(code, |code, axis| {
            let periods = cell.whole_periods(axis, (back - way)[axis]);
            if self.along[axis].is_set_back() && periods != 0.0 {
                image::moved(code, axis, periods)
            } else {
                code
            }
        })
    }

    /// Codes of the images by which particles meet the wall, of those axes along which none is chosen for each particle.
    pub(super) fn codes(&self) -> &[u32] {
        &self.codes
    }

    /// Translation that takes whole periods off a pose, m: zero while the wall is within half a period of where it covers the
    /// domain best.
    pub(super) fn whole_periods(&self, pose: &Pose, cell: &Cell) -> DVec3 {
        let mut back = DVec3::ZERO;
        if !self.along.iter().any(|along| along.is_set_back()) {
            return back;
        }
        let way = pose.to_global(self.middle) - self.middle - self.home;
        for axis in 0..3 {
            if self.along[axis].is_set_back() {
                let periods = cell.whole_periods(axis, way[axis]);
                if periods != 0.0 {
                    back[axis] = -periods * cell.size()[axis];
                }
            }
        }
        back
    }

    /// The wall stands in the box `outer` (m) now.
    pub(super) fn stand(&mut self, (low, high): Corners, cell: &Cell) {
        let range = |axis: usize| {
            if self.along[axis] != Along::All || !(high - low)[axis].is_finite() {
                return 0..=0;
            }
            let first = (cell.fractional(low)[axis] - 1.0 - REACH).ceil();
            let last = (cell.fractional(high)[axis] + REACH).floor();
            // Farther images than have codes are refused when the plan is made.
            let most = image::MOST_PERIODS;
            first.max(-f64::from(most)) as i32..=last.min(f64::from(most)) as i32
        };
        let [x, y, z] = [range(0), range(1), range(2)];
        self.codes.clear();
        let here = [&x, &y, &z].iter().all(|range| range.contains(&0));
        self.codes.extend(here.then_some(image::code([0, 0, 0])));
        for c in z {
            for b in y.clone() {
                for a in x.clone() {
                    if [a, b, c] != [0, 0, 0] {
                        self.codes.push(image::code([a, b, c]));
                    }
                }
            }
        }
    }

    /// The image of a particle at `position` (m) that meets the wall, of those that go with `code`.
    #[inline]
    pub(super) fn image_of(
        &self,
        shape: &Shape,
        state: &WallState,
        position: DVec3,
        code: u32,
    ) -> u32 {
        if !self.along.iter().any(|along| along.is_chosen()) {
            return code;
        }
        let mut code = code;
        for axis in 0..3 {
            let periods = self.periods(axis, shape, state, position);
            code = image::moved(code, axis, periods);
        }
        code
    }

    /// The codes between which [`MetBy::image_of`] chooses for particles in a box, m.
    pub(super) fn images_of_box(
        &self,
        shape: &Shape,
        state: &WallState,
        cell: &Cell,
        (low, high): Corners,
        code: u32,
    ) -> impl Iterator<Item = u32> + use<> {
        let range = |axis: usize| {
            // Round-off must not hide the one at the end.
            let slack = FACE * cell.size();
            let most = self.periods(axis, shape, state, low - slack);
            let least = self.periods(axis, shape, state, high + slack);
            (least as i32, most as i32)
        };
        let [x, y, z] = if self.along.iter().any(|along| along.is_chosen()) {
            [range(0), range(1), range(2)]
        } else {
            [(0, 0); 3]
        };
        (z.0..=z.1).flat_map(move |c| {
            (y.0..=y.1).flat_map(move |b| {
                (x.0..=x.1).map(move |a| {
                    let moved = image::moved(code, 0, f64::from(a));
                    let moved = image::moved(moved, 1, f64::from(b));
                    image::moved(moved, 2, f64::from(c))
                })
            })
        })
    }

    /// Whole periods by which a particle is shifted along an axis to meet the wall; 0 along axes of which no image is chosen.
    #[inline]
    fn periods(&self, axis: usize, shape: &Shape, state: &WallState, position: DVec3) -> f64 {
        match self.along[axis] {
            Along::Once | Along::All => 0.0,
            Along::BetweenFaces => {
                let Shape::Mesh(mesh) = shape else {
                    return 0.0;
                };
                // Motion leaves these axes where they are.
                let place = state.into_wall(position);
                let mut periods = mesh.periods().iter();
                let period = periods.find(|period| period.axis == axis);
                period.map_or(0.0, |period| period.into_base(place[axis]))
            }
        }
    }
}

impl Along {
    /// Whether whole periods are taken off the wall's way; meshes that go on do that themselves.
    fn is_set_back(self) -> bool {
        matches!(self, Self::All)
    }

    /// Whether one image is chosen for each particle.
    fn is_chosen(self) -> bool {
        matches!(self, Self::BetweenFaces)
    }
}
