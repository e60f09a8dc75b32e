//! From space to the picture.

use glam::{DVec2, DVec3};

use super::extent::Extent;
use super::{Axes, Window};
use crate::canvas::Spot;
use crate::options::{Options, Projection};

/// Free space around what is framed, as a share of the window.
const MARGIN: f64 = 0.03;

/// A camera with its window. Places are in pixels from the middle of the window: x right, y down, z away from the eye,
/// at the scale of the target's plane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lens {
    axes: Axes,
    /// Point in the middle of the window (m along the axes).
    target: DVec3,
    /// Pixels per metre in the plane of the target.
    scale: f64,
    /// Pixels from the eye to the target; none: orthographic.
    distance: Option<f64>,
    window: Window,
}

impl Lens {
    /// A lens that shows `extent` in `window`.
    pub(crate) fn new(axes: Axes, extent: &Extent, options: &Options, window: Window) -> Self {
        let (width, height) = (window.width as f64, window.height as f64);
        let (room_x, room_y) = (width * (1.0 - 2.0 * MARGIN), height * (1.0 - 2.0 * MARGIN));
        let size = extent.size();
        let middle = if extent.is_empty() {
            DVec3::ZERO
        } else {
            extent.middle()
        };
        let target = options.target.map_or(middle, |at| axes.coordinates(at));
        let sane = |scale: f64| scale.is_finite() && scale > 0.0;
        let (scale, distance) = match options.projection {
            Projection::Orthographic => ((room_x / size.x).min(room_y / size.y), None),
            Projection::Perspective { field_of_view } => {
                let focal = 0.5 * width.max(height) / (0.5 * field_of_view).to_radians().tan();
                // Every corner inside the window, and none behind the eye.
                let reach = |corner: DVec3| {
                    let sideways = (corner.x.abs() / room_x).max(corner.y.abs() / room_y);
                    2.0 * focal * sideways - corner.z
                };
                let eye = extent.corners().into_iter().map(reach).fold(0.0, f64::max);
                (focal / eye, Some(focal * options.zoom))
            }
        };
        // A frame without any size: a metre across.
        let scale = if sane(scale) {
            scale
        } else {
            room_x.min(room_y)
        };
        Self {
            axes,
            target,
            scale: scale * options.zoom,
            distance,
            window,
        }
    }

    pub(crate) fn window(&self) -> Window {
        self.window
    }

    /// Pixels per metre, the same everywhere; none in perspective.
    pub(crate) fn scale(&self) -> Option<f64> {
        self.distance.is_none().then_some(self.scale)
    }

    /// Pixels per metre in the plane of the target.
    pub(crate) fn target_scale(&self) -> f64 {
        self.scale
    }

    /// Pixels from the eye to the target's plane; none: orthographic.
    pub(crate) fn distance(&self) -> Option<f64> {
        self.distance
    }

    /// A point in pixels from the middle of the window, not yet projected.
    pub(crate) fn place(&self, point: DVec3) -> DVec3 {
        let at = (self.axes.coordinates(point) - self.target) * self.scale;
        DVec3::new(at.x, -at.y, at.z)
    }

    /// A direction in the picture: x right, y down; its length is that of its projection.
    pub(crate) fn direction(&self, direction: DVec3) -> Spot {
        let at = self.axes.coordinates(direction);
        (at.x, -at.y)
    }

    /// Where a place falls, from the middle of the window; none behind the eye.
    pub(crate) fn project(&self, place: DVec3) -> Option<Spot> {
        match self.distance {
            None => Some((place.x, place.y)),
            Some(distance) => {
                let far = distance + place.z;
                (far > self.nearest()).then(|| {
                    let shrink = distance / far;
                    (place.x * shrink, place.y * shrink)
                })
            }
        }
    }

    /// Whether all of these points (m) fall into a window of this width and height, in pixels of this lens.
    pub(crate) fn holds(&self, points: &[DVec3], (width, height): (usize, usize)) -> bool {
        let half = 0.5 * DVec2::new(width as f64, height as f64);
        points.iter().all(|point| {
            let at = self.project(self.place(*point));
            at.is_some_and(|(x, y)| x.abs() <= half.x && y.abs() <= half.y)
        })
    }

    /// Pixels from the eye within which nothing is drawn.
    pub(crate) fn nearest(&self) -> f64 {
        self.distance.map_or(f64::NEG_INFINITY, |d| 1e-3 * d)
    }

    /// This lens at another scale in the plane of the target; in perspective the eye stays where it is.
    pub(crate) fn with_scale(mut self, scale: f64) -> Self {
        self.distance = self.distance.map(|d| d * (scale / self.scale));
        self.scale = scale;
        self
    }

    /// This lens for pixels of `1 / factor` the size.
    pub(crate) fn finer(mut self, factor: f64) -> Self {
        self.scale *= factor;
        self.distance = self.distance.map(|d| d * factor);
        self
    }
}
