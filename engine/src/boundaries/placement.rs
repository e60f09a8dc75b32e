//! Positions for new particles.

use glam::DVec3;
use mercury_common::random::Stream;

use super::Region;
use crate::cell::Cell;
use crate::walls::{Touches, WallNow};

/// Trials to hit the region from its bounding box before an attempt counts as failed: a region that fills a tenth of its box
/// is missed by all with a probability of 0.1 %.
const DRAWS: u32 = 64;

/// The number of boxes that are tested before a region counts as possibly large enough for a sphere: some hundredths of a second.
const MOST_LOOKS: u32 = 1_000_000;

/// The space in which regions lie.
#[derive(Debug, Clone, Copy)]
pub struct Space<'a> {
    /// The cell.
    pub cell: &'a Cell,
    /// 3, or 2 for discs.
    pub dimensions: u8,
}

/// Whether a sphere of this radius (m) may have a place in the region and the domain: `false` only where it certainly has none.
pub fn may_hold(region: &Region, radius: f64, space: Space<'_>) -> bool {
    PlacementRegion::new(region, space).may_hold(radius, space.cell)
}

/// The extent below and above a centre along x, y, z, m.
pub(super) type Extent = (DVec3, DVec3);

/// The extent of a sphere of this radius (m).
pub(super) fn of_sphere(radius: f64) -> Extent {
    (DVec3::splat(radius), DVec3::splat(radius))
}

/// The possible positions of a region inside the domain.
#[derive(Debug, Clone)]
pub(super) struct PlacementRegion {
    region: Region,
    /// Bounds of the region, m; infinite where it is unbounded.
    bounds: (DVec3, DVec3),
    /// The plane of two-dimensional scenes, m.
    plane: Option<f64>,
}

impl PlacementRegion {
    /// For a region in the domain of a plan. Discs lie in the plane z = 0, or where the domain does not have it, in the nearest.
    pub(super) fn new(region: &Region, space: Space<'_>) -> Self {
        let (low, high) = space.cell.corners();
        let plane = (space.dimensions == 2).then(|| {
            // Not `clamp`, which panics if the domain's corners are swapped.
            0.0f64.max(low.z).min(high.z)
        });
        let region = plane.map_or_else(|| region.clone(), |plane| region.in_plane(plane));
        Self {
            bounds: region.bounds(),
            region,
            plane,
        }
    }

    /// Lowest and highest centre of an object with this extent (m) below and above its centre, not yet wrapped into periodic
    /// domains.
    ///
    /// At the bounds of the region the whole object must be inside; where the domain ends first, only the centre must be.
    fn centres(&self, (below, above): Extent, cell: &Cell) -> (DVec3, DVec3) {
        let (mut low, mut high) = (self.bounds.0 + below, self.bounds.1 - above);
        for axis in 0..3 {
            if !cell.is_periodic(axis) || low[axis] == f64::NEG_INFINITY {
                low[axis] = low[axis].max(cell.low()[axis]);
            }
            if !cell.is_periodic(axis) || high[axis] == f64::INFINITY {
                high[axis] = high[axis].min(cell.high()[axis]);
            }
        }
        if let Some(plane) = self.plane {
            (low.z, high.z) = (plane, plane);
        }
        (low, high)
    }

    /// Lowest and highest centre as above, if something of this extent fits between the bounds at all, which must be finite.
    fn space(&self, extent: Extent, cell: &Cell) -> Option<(DVec3, DVec3)> {
        let (low, high) = self.centres(extent, cell);
        (low.is_finite() && high.is_finite() && low.cmple(high).all()).then_some((low, high))
    }

    /// Whether something of this extent fits between the bounds at all.
    pub(super) fn has_space(&self, extent: Extent, cell: &Cell) -> bool {
        self.space(extent, cell).is_some()
    }

    /// Whether there may be a place for a sphere of this radius (m): `false` only where it is certain that there is none.
    ///
    /// Boxes of centres are halved until one has its middle where the sphere fits. As the signed distance changes at most as
    /// fast as the place, a box whose middle misses by more than its half diagonal holds no place and is dropped.
    pub(super) fn may_hold(&self, radius: f64, cell: &Cell) -> bool {
        let extent = of_sphere(radius);
        let Some((low, high)) = self.space(extent, cell) else {
            return false;
        };
        let mut boxes = vec![(0.5 * (low + high), 0.5 * (high - low))];
        let mut looks = 0;
        while let Some((centre, half)) = boxes.pop() {
            looks += 1;
            // The margin for the centre, as a share of the radius; `NaN` counts as a fit.
            let missing = self.region.signed_distance(centre) + radius;
            if missing.is_nan() || missing <= 0.0 || looks > MOST_LOOKS {
                return true;
            }
            if missing > half.length() {
                continue;
            }
            let axis = if half.x >= half.y && half.x >= half.z {
                DVec3::X
            } else if half.y >= half.z {
                DVec3::Y
            } else {
                DVec3::Z
            };
            let (step, half) = (0.5 * half * axis, half * (1.0 - 0.5 * axis));
            boxes.extend([(centre - step, half), (centre + step, half)]);
        }
        // Across the joints of a union there may be more space than its distance shows.
        radius > 0.0 && self.region.has_union() && self.may_hold(0.0, cell)
    }

    /// A centre uniform among those whose spheres, `offset` (m) from it, lie wholly inside the region, wrapped into the domain;
    /// `None` if there is no space for the extent, or if the trials missed. Two words per trial in two dimensions, three in three.
    pub(super) fn draw(
        &self,
        spheres: &[(DVec3, f64)],
        extent: Extent,
        stream: &mut Stream,
        cell: &Cell,
    ) -> Option<DVec3> {
        let (low, high) = self.space(extent, cell)?;
        for _ in 0..DRAWS {
            let x = stream.uniform_in(low.x, high.x);
            let y = stream.uniform_in(low.y, high.y);
            let z = match self.plane {
                Some(plane) => plane,
                None => stream.uniform_in(low.z, high.z),
            };
            let centre = DVec3::new(x, y, z);
            let holds = |&(offset, radius)| self.region.holds_sphere(centre + offset, radius);
            if spheres.iter().all(holds) {
                return Some(cell.wrap(centre));
            }
        }
        None
    }
}

/// Whether a sphere would overlap a wall or sheet that is there; touching is not overlapping.
pub fn overlaps_wall(walls: &[WallNow], cell: &Cell, centre: DVec3, radius: f64) -> bool {
    let mut touches = Touches::new();
    walls.iter().filter(|wall| wall.state.present).any(|wall| {
        wall.met_by().iter().any(|&code| {
            let code = wall.image_of(centre, code);
            let centre = wall.state.into_wall(centre + cell.any_shift(code));
            let reach = radius + wall.half_thickness();
            wall.shape().touches(centre, reach, &mut touches);
            !touches.is_empty()
        })
    })
}
