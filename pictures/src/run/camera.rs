//! The orthographic camera: where it stands, what it frames, and where things fall on the page.

use super::framing::{self, drawable};
use super::{PictureScene, PictureSphere};
use crate::canvas::Spot;
use glam::DVec3;

/// Degrees by which the camera stands above the horizon.
const ELEVATION: f64 = 20.0;
/// Degrees by which the camera is turned to the side, so that a box shows two of its sides.
const AZIMUTH: f64 = 24.0;
/// A place in the camera's window: points on the page, and depth away from the camera in points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Seen {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) depth: f64,
}

/// A sphere in the camera's window.
#[derive(Debug, Clone, Copy)]
pub(super) struct SeenSphere {
    pub(super) at: Seen,
    /// Radius in points.
    pub(super) radius: f64,
    /// Place in the scene's list.
    pub(super) index: usize,
}

/// The rectangle of the page that shows the scene.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window {
    pub(super) upper_left: Spot,
    pub(super) lower_right: Spot,
}

impl Window {
    pub(super) fn width(&self) -> f64 {
        self.lower_right.0 - self.upper_left.0
    }

    pub(super) fn height(&self) -> f64 {
        self.lower_right.1 - self.upper_left.1
    }
}

/// An orthographic camera and its frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Camera {
    right: DVec3,
    up: DVec3,
    /// Away from the eye.
    ahead: DVec3,
    /// Middle of the frame (m, along right and up) and the depth that counts as zero.
    middle: (f64, f64, f64),
    /// Points per metre.
    scale: f64,
    window: Window,
}

/// The direction against gravity; z without gravity, y in two dimensions.
pub(super) fn upward(scene: &PictureScene) -> DVec3 {
    let against = -scene.gravity;
    match (against.is_finite(), against.try_normalize()) {
        (true, Some(up)) => up,
        _ if scene.dimensions == 2 => DVec3::Y,
        _ => DVec3::Z,
    }
}

/// The axes of the camera: right, up, ahead.
fn axes(scene: &PictureScene) -> (DVec3, DVec3, DVec3) {
    if scene.dimensions == 2 {
        return (DVec3::X, DVec3::Y, -DVec3::Z);
    }
    let zenith = upward(scene);
    // Level axes: x where it can be, so that the reader finds it pointing right.
    let level = |axis: DVec3| (axis - axis.dot(zenith) * zenith).try_normalize();
    let east = if zenith.x.abs() < 0.99 {
        level(DVec3::X)
    } else {
        level(DVec3::Y)
    }
    .unwrap_or(DVec3::X);
    let north = zenith.cross(east);
    let (turn, tilt) = (AZIMUTH.to_radians(), ELEVATION.to_radians());
    let level_ahead = turn.cos() * north - turn.sin() * east;
    let right = turn.cos() * east + turn.sin() * north;
    let ahead = tilt.cos() * level_ahead - tilt.sin() * zenith;
    (right, right.cross(ahead), ahead)
}

impl Camera {
    /// A camera that frames the bed and as much of walls and domain as leaves the bed well visible.
    pub(super) fn new(scene: &PictureScene, window: Window) -> Self {
        let (right, up, ahead) = axes(scene);
        let plane = |p: DVec3| (p.dot(right), p.dot(up));
        let (middle, scale) = framing::frame(scene, window, plane);
        // Depths count from the middle of the bed, so that their differences keep their digits.
        let (mut sum, mut number) = (0.0, 0.0);
        for sphere in scene.spheres.iter().filter(|sphere| drawable(sphere)) {
            sum += sphere.centre.dot(ahead);
            number += 1.0;
        }
        let depth = if number > 0.0 { sum / number } else { 0.0 };
        Self {
            right,
            up,
            ahead,
            middle: (middle.0, middle.1, depth),
            scale,
            window,
        }
    }

    /// Where a point is seen.
    pub(super) fn see(&self, point: DVec3) -> Seen {
        let centre_x = 0.5 * (self.window.upper_left.0 + self.window.lower_right.0);
        let centre_y = 0.5 * (self.window.upper_left.1 + self.window.lower_right.1);
        Seen {
            x: centre_x + self.scale * (point.dot(self.right) - self.middle.0),
            y: centre_y - self.scale * (point.dot(self.up) - self.middle.1),
            depth: self.scale * (point.dot(self.ahead) - self.middle.2),
        }
    }

    /// A direction on the page: x right, y down; its length is that of its projection.
    pub(super) fn direction(&self, direction: DVec3) -> Spot {
        (direction.dot(self.right), -direction.dot(self.up))
    }

    /// Points per metre.
    pub(super) fn scale(&self) -> f64 {
        self.scale
    }

    /// The rectangle of the page it fills.
    pub(super) fn window(&self) -> Window {
        self.window
    }

    /// The spheres in view, the nearest first.
    pub(super) fn spheres(&self, spheres: &[PictureSphere]) -> Vec<SeenSphere> {
        let mut seen: Vec<SeenSphere> = spheres
            .iter()
            .enumerate()
            .filter(|(_, sphere)| drawable(sphere))
            .map(|(index, sphere)| SeenSphere {
                at: self.see(sphere.centre),
                radius: sphere.radius * self.scale,
                index,
            })
            .filter(|s| {
                let ((x0, y0), (x1, y1)) = (self.window.upper_left, self.window.lower_right);
                s.at.x + s.radius > x0
                    && s.at.x - s.radius < x1
                    && s.at.y + s.radius > y0
                    && s.at.y - s.radius < y1
            })
            .collect();
        seen.sort_by(|a, b| f64::total_cmp(&(a.at.depth - a.radius), &(b.at.depth - b.radius)));
        seen
    }

    /// The part of the segment between two seen places that lies in the window (Liang and Barsky, 1984).
    pub(super) fn clip(&self, a: Seen, b: Seen) -> Option<(Seen, Seen)> {
        let ((x0, y0), (x1, y1)) = (self.window.upper_left, self.window.lower_right);
        let (dx, dy) = (b.x - a.x, b.y - a.y);
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for (step, room) in [
            (-dx, a.x - x0),
            (dx, x1 - a.x),
            (-dy, a.y - y0),
            (dy, y1 - a.y),
        ] {
            if step == 0.0 {
                if room < 0.0 {
                    return None;
                }
            } else if step < 0.0 {
                from = from.max(room / step);
            } else {
                to = to.min(room / step);
            }
        }
        let at = |t: f64| Seen {
            x: a.x + t * dx,
            y: a.y + t * dy,
            depth: a.depth + t * (b.depth - a.depth),
        };
        (from <= to).then(|| (at(from), at(to)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WINDOW: Window = Window {
        upper_left: (0.0, 0.0),
        lower_right: (1000.0, 700.0),
    };

    fn ball(x: f64, y: f64, z: f64, radius: f64) -> PictureSphere {
        PictureSphere {
            centre: DVec3::new(x, y, z),
            radius,
            speed: 0.0,
            fixed: false,
        }
    }

    fn scene<'a>(spheres: &'a [PictureSphere], gravity: DVec3, dimensions: u8) -> PictureScene<'a> {
        PictureScene {
            title: "",
            time: 0.0,
            spheres,
            domain_min: DVec3::ZERO,
            domain_max: DVec3::ONE,
            gravity,
            dimensions,
            walls: &[],
        }
    }

    #[test]
    fn axes_are_right_handed_and_up_is_against_gravity() {
        for gravity in [
            DVec3::ZERO,
            -DVec3::X,
            DVec3::X,
            DVec3::Y,
            DVec3::Z,
            DVec3::new(3.0, 0.1, -9.0),
        ] {
            for dimensions in [2, 3] {
                let scene = scene(&[], gravity, dimensions);
                let (right, up, ahead) = axes(&scene);
                // Right x up points at the viewer.
                assert!((right.cross(up) + ahead).length() < 1e-12);
                assert!((right.length() - 1.0).abs() < 1e-12 && (up.length() - 1.0).abs() < 1e-12);
                if dimensions == 3 {
                    // The zenith leans by the elevation out of the page and not to the side.
                    assert!((upward(&scene).dot(up) - ELEVATION.to_radians().cos()).abs() < 1e-12);
                    assert!(upward(&scene).dot(right).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn two_dimensions_are_seen_straight() {
        let camera = Camera::new(&scene(&[], DVec3::ZERO, 2), WINDOW);
        let (low, high) = (
            camera.see(DVec3::ZERO),
            camera.see(DVec3::new(1.0, 1.0, 0.0)),
        );
        assert!(high.x > low.x && high.y < low.y);
        assert!(
            ((high.x - low.x) - (low.y - high.y)).abs() < 1e-9,
            "equal scales"
        );
        assert!(
            (low.y - high.y - 0.94 * 700.0).abs() < 1e-9,
            "the domain fills the window up to its margins"
        );
    }

    #[test]
    fn a_small_bed_in_a_large_domain_is_framed_closely() {
        let spheres: Vec<_> = (0..100)
            .map(|i| ball(f64::from(i) * 1e-4, 0.0, 0.0, 1e-4))
            .collect();
        let camera = Camera::new(&scene(&spheres, -DVec3::Z, 3), WINDOW);
        let seen = camera.spheres(&spheres);
        assert_eq!(seen.len(), 100);
        let wide = seen.iter().map(|s| s.at.x).fold(f64::MIN, f64::max)
            - seen.iter().map(|s| s.at.x).fold(f64::MAX, f64::min);
        assert!(wide > 800.0, "{wide}");
    }

    #[test]
    fn one_straggler_does_not_shrink_the_bed() {
        let mut spheres: Vec<_> = (0..200)
            .map(|i| ball(f64::from(i % 20), 0.0, f64::from(i / 20), 0.5))
            .collect();
        spheres.push(ball(1e6, 0.0, 0.0, 0.5));
        let camera = Camera::new(&scene(&spheres, -DVec3::Z, 3), WINDOW);
        assert_eq!(camera.spheres(&spheres).len(), 200);
        assert!(camera.scale() > 10.0, "{}", camera.scale());
    }

    #[test]
    fn segments_are_clipped_to_the_window() {
        let camera = Camera::new(&scene(&[], DVec3::ZERO, 2), WINDOW);
        let at = |x: f64, y: f64, depth: f64| Seen { x, y, depth };
        let (a, b) = camera
            .clip(at(-1000.0, 350.0, 0.0), at(3000.0, 350.0, 4.0))
            .unwrap();
        assert_eq!((a, b), (at(0.0, 350.0, 1.0), at(1000.0, 350.0, 2.0)));
        assert!(
            camera
                .clip(at(-5.0, -5.0, 0.0), at(1005.0, -5.0, 0.0))
                .is_none()
        );
    }
}
