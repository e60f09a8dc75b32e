//! What part of the scene a picture frames.

use super::camera::Window;
use super::{PictureScene, PictureSphere, PictureWall};
use glam::DVec3;

/// The bed fills at least this share of the frame in one direction ...
const SMALLEST_BED: f64 = 0.3;
/// ... or its median sphere is at least this many points wide; else the frame closes in on the bed.
const SMALLEST_SPHERE: f64 = 12.0;
/// Free space around what is framed, as a share of the window.
const MARGIN: f64 = 0.03;
/// Coordinates beyond this (m) are taken for errors: their squares would overflow.
const FARTHEST: f64 = 1e100;

/// Whether a sphere can be drawn at all.
pub(super) fn drawable(sphere: &PictureSphere) -> bool {
    sphere.centre.is_finite()
        && sphere.centre.abs().max_element() < FARTHEST
        && sphere.radius > 0.0
        && sphere.radius < FARTHEST
}

/// The corners of the domain: eight, or four in two dimensions; none if it has no finite extent.
pub(super) fn domain_corners(scene: &PictureScene) -> Vec<DVec3> {
    let (low, mut high) = (scene.domain_min, scene.domain_max);
    if scene.dimensions == 2 {
        high.z = low.z;
    }
    let sane = |v: DVec3| v.is_finite() && v.abs().max_element() < FARTHEST;
    if !sane(low) || !sane(high) || low == high {
        return Vec::new();
    }
    let number = if scene.dimensions == 2 { 4 } else { 8 };
    (0..number)
        .map(|corner| {
            let pick =
                |bit: u32, low: f64, high: f64| if corner & (1 << bit) == 0 { low } else { high };
            DVec3::new(
                pick(0, low.x, high.x),
                pick(1, low.y, high.y),
                pick(2, low.z, high.z),
            )
        })
        .collect()
}

/// An axis-parallel rectangle in the camera's plane (m).
#[derive(Debug, Clone, Copy)]
struct Extent {
    low: (f64, f64),
    high: (f64, f64),
}

impl Extent {
    const EMPTY: Self = Self {
        low: (f64::MAX, f64::MAX),
        high: (f64::MIN, f64::MIN),
    };

    fn add(&mut self, (x, y): (f64, f64), radius: f64) {
        self.low = (self.low.0.min(x - radius), self.low.1.min(y - radius));
        self.high = (self.high.0.max(x + radius), self.high.1.max(y + radius));
    }

    fn union(mut self, other: Self) -> Self {
        if !other.is_empty() {
            self.add(other.low, 0.0);
            self.add(other.high, 0.0);
        }
        self
    }

    fn is_empty(&self) -> bool {
        self.low.0 > self.high.0
    }

    fn size(&self) -> (f64, f64) {
        (self.high.0 - self.low.0, self.high.1 - self.low.1)
    }
}

/// The extent of the spheres. A few that have left the bed by several times its size do not count, or they
/// would shrink it to a dot.
fn bed_extent(flat: &[(f64, f64, f64)]) -> Extent {
    let mut full = Extent::EMPTY;
    for (x, y, radius) in flat {
        full.add((*x, *y), *radius);
    }
    if flat.len() < 50 {
        return full;
    }
    // The middle 98 % along each axis, widened by its own size, holds any bed without stragglers.
    let largest = flat.iter().map(|s| s.2).fold(0.0, f64::max);
    let middle = |pick: fn(&(f64, f64, f64)) -> f64| {
        let mut values: Vec<f64> = flat.iter().map(pick).collect();
        let last = values.len() - 1;
        let low = *values.select_nth_unstable_by(last / 100, f64::total_cmp).1;
        let high = *values
            .select_nth_unstable_by(last - last / 100, f64::total_cmp)
            .1;
        let reach = (high - low) + 2.0 * largest;
        (low - reach, high + reach)
    };
    let (x, y) = (middle(|s| s.0), middle(|s| s.1));
    Extent {
        low: (full.low.0.max(x.0), full.low.1.max(y.0)),
        high: (full.high.0.min(x.1), full.high.1.min(y.1)),
    }
}

/// The middle of the frame (m) and its scale (points per metre): the bed, and as much of walls and domain as leaves
/// the bed well visible. `plane` gives the coordinates of a point to the right and up.
pub(super) fn frame(
    scene: &PictureScene,
    window: Window,
    plane: impl Fn(DVec3) -> (f64, f64),
) -> ((f64, f64), f64) {
    let flat: Vec<(f64, f64, f64)> = scene
        .spheres
        .iter()
        .filter(|sphere| drawable(sphere))
        .map(|sphere| {
            let (x, y) = plane(sphere.centre);
            (x, y, sphere.radius)
        })
        .collect();
    let bed = bed_extent(&flat);
    let mut walls = Extent::EMPTY;
    for PictureWall::Polyline(points) in scene.walls {
        for point in points
            .iter()
            .filter(|p| p.is_finite() && p.abs().max_element() < FARTHEST)
        {
            walls.add(plane(*point), 0.0);
        }
    }
    let mut domain = Extent::EMPTY;
    for corner in domain_corners(scene) {
        domain.add(plane(corner), 0.0);
    }

    let mut radii: Vec<f64> = flat.iter().map(|s| s.2).collect();
    let median = if radii.is_empty() {
        0.0
    } else {
        let half = radii.len() / 2;
        *radii.select_nth_unstable_by(half, f64::total_cmp).1
    };
    let (room_x, room_y) = (
        window.width() * (1.0 - 2.0 * MARGIN),
        window.height() * (1.0 - 2.0 * MARGIN),
    );
    let scale_of = |extent: &Extent| {
        let (width, height) = extent.size();
        (room_x / width).min(room_y / height)
    };
    let shows_bed = |extent: &Extent| {
        let ((width, height), (bed_width, bed_height)) = (extent.size(), bed.size());
        bed_width >= SMALLEST_BED * width
            || bed_height >= SMALLEST_BED * height
            || 2.0 * median * scale_of(extent) >= SMALLEST_SPHERE
    };
    let everything = bed.union(walls).union(domain);
    let frame = if bed.is_empty() {
        everything
    } else {
        let candidates = [everything, bed.union(walls)];
        candidates.into_iter().find(shows_bed).unwrap_or(bed)
    };
    if frame.is_empty() {
        return ((0.0, 0.0), room_x.min(room_y));
    }
    let middle = (
        0.5 * (frame.low.0 + frame.high.0),
        0.5 * (frame.low.1 + frame.high.1),
    );
    let scale = scale_of(&frame);
    // A frame without any size: a metre across.
    let sane = scale.is_finite() && scale > 0.0;
    (middle, if sane { scale } else { room_x.min(room_y) })
}
