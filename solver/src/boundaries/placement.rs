//! Where a new particle may stand.

use glam::DVec3;
use mercury_common::random::Stream;

use super::Region;
use crate::neighbours::Images;
use crate::plan::Plan;
use crate::walls::{Touches, Wall, WallState, image_between_faces, images_met};

/// Trials to hit the region from its bounding box before an attempt counts as failed: a region that fills a tenth of its box
/// is missed by all with a probability of 0.1 %.
const DRAWS: u32 = 64;

/// How far something reaches below and above its centre along x, y, z, m.
pub(super) type Extent = (DVec3, DVec3);

/// The extent of a sphere of this radius (m).
pub(super) fn of_sphere(radius: f64) -> Extent {
    (DVec3::splat(radius), DVec3::splat(radius))
}

/// The places that a region offers inside the domain.
#[derive(Debug, Clone)]
pub(super) struct Room {
    region: Region,
    /// Bounds of the region, m; infinite where it is unbounded.
    bounds: (DVec3, DVec3),
    domain: (DVec3, DVec3),
    periodic: [bool; 3],
    /// The plane of two-dimensional scenes, m.
    plane: Option<f64>,
}

impl Room {
    /// Of a region in the domain of a plan. Discs lie in the plane z = 0, or where the domain does not have it, in the nearest.
    pub(super) fn new(region: &Region, plan: &Plan) -> Self {
        let plane = (plan.dimensions == 2).then(|| {
            // Not `clamp`, which panics on a domain that is upside down.
            0.0f64.max(plan.domain_min.z).min(plan.domain_max.z)
        });
        let region = plane.map_or_else(|| region.clone(), |plane| region.in_plane(plane));
        Self {
            bounds: region.bounds(),
            region,
            domain: (plan.domain_min, plan.domain_max),
            periodic: plan.periodic,
            plane,
        }
    }

    /// Lowest and highest centre of something that reaches so far (m) below and above its centre, not yet wrapped into periodic
    /// domains.
    ///
    /// Where the region ends, it ends inside; where the domain ends first, only the centre must be inside.
    fn centres(&self, (below, above): Extent) -> (DVec3, DVec3) {
        let (mut low, mut high) = (self.bounds.0 + below, self.bounds.1 - above);
        for axis in 0..3 {
            if !self.periodic[axis] || low[axis] == f64::NEG_INFINITY {
                low[axis] = low[axis].max(self.domain.0[axis]);
            }
            if !self.periodic[axis] || high[axis] == f64::INFINITY {
                high[axis] = high[axis].min(self.domain.1[axis]);
            }
        }
        if let Some(plane) = self.plane {
            (low.z, high.z) = (plane, plane);
        }
        (low, high)
    }

    /// Lowest and highest wrapped centre of spheres of at least this radius, or of pebbles whose bodies' centres are not farther
    /// than `reach` from them, m.
    pub(super) fn extent(&self, smallest_radius: f64, reach: f64) -> (DVec3, DVec3) {
        let (low, high) = self.centres(of_sphere(smallest_radius));
        let (mut low, mut high) = (low - DVec3::splat(reach), high + DVec3::splat(reach));
        for axis in 0..3 {
            let sticks_out = low[axis] < self.domain.0[axis] || high[axis] > self.domain.1[axis];
            if self.periodic[axis] && sticks_out {
                (low[axis], high[axis]) = (self.domain.0[axis], self.domain.1[axis]);
            }
        }
        (low, high)
    }

    /// Whether something of this extent fits between the bounds at all, which must be finite.
    pub(super) fn has_space(&self, extent: Extent) -> bool {
        let (low, high) = self.centres(extent);
        low.is_finite() && high.is_finite() && low.cmple(high).all()
    }

    /// A centre uniform among those whose spheres, `offset` (m) from it, lie wholly inside the region, wrapped into the domain;
    /// `None` if the trials missed. Two words per trial in two dimensions, three in three.
    pub(super) fn draw(
        &self,
        spheres: &[(DVec3, f64)],
        extent: Extent,
        stream: &mut Stream,
        images: &Images,
    ) -> Option<DVec3> {
        let (low, high) = self.centres(extent);
        for _ in 0..DRAWS {
            let x = stream.uniform_in(low.x, high.x);
            let y = stream.uniform_in(low.y, high.y);
            let z = match self.plane {
                Some(plane) => plane,
                None => stream.uniform_in(low.z, high.z),
            };
            let centre = DVec3::new(x, y, z);
            let holds = |&(offset, radius): &(DVec3, f64)| {
                self.region.holds_sphere(centre + offset, radius)
            };
            if spheres.iter().all(holds) {
                return Some(images.wrap(centre));
            }
        }
        None
    }
}

/// The images by which each wall is met.
pub(super) fn wall_images(walls: &[Wall], images: &Images) -> Vec<Vec<u32>> {
    walls.iter().map(|wall| images_met(wall, images)).collect()
}

/// Whether a sphere would overlap a wall that is there; touching is not overlapping.
pub(super) fn overlaps_wall(
    walls: &[Wall],
    states: &[WallState],
    wall_images: &[Vec<u32>],
    images: &Images,
    centre: DVec3,
    radius: f64,
) -> bool {
    let mut touches = Touches::new();
    walls
        .iter()
        .zip(states)
        .zip(wall_images)
        .filter(|((_, state), _)| state.present)
        .any(|((wall, state), codes)| {
            codes.iter().any(|&code| {
                let code = image_between_faces(wall, state, images, centre, code);
                let centre = state.into_wall(centre + images.shift(code));
                wall.shape.touches(centre, radius, &mut touches);
                !touches.is_empty()
            })
        })
}
