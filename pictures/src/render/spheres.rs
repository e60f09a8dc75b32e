//! Spheres as the camera sees them, and where its rays meet them.

use glam::DVec3;
use rayon::prelude::*;

use super::bins::Rect;
use crate::camera::Lens;
use crate::frame::Sphere;

/// Spheres are never drawn smaller than this (samples), so that dust among boulders stays visible.
const SMALLEST_RADIUS: f64 = 0.75;

/// A sphere in samples from the middle of the window.
#[derive(Debug, Clone, Copy)]
pub(super) struct SeenSphere {
    pub(super) centre: DVec3,
    pub(super) radius: f64,
    /// Place in the frame's list.
    pub(super) index: u32,
    pub(super) rect: Rect,
}

impl SeenSphere {
    /// Depth of its nearest point.
    pub(super) fn nearest(&self) -> f64 {
        self.centre.z - self.radius
    }
}

/// The spheres in the window, the nearest first.
pub(super) fn seen(
    spheres: &[Sphere],
    lens: &Lens,
    columns: usize,
    rows: usize,
) -> Vec<SeenSphere> {
    let mut seen: Vec<SeenSphere> = spheres
        .par_iter()
        .enumerate()
        .filter(|(_, sphere)| sphere.is_drawable())
        .filter_map(|(index, sphere)| {
            let centre = lens.place(sphere.centre);
            let mut radius = sphere.radius * lens.target_scale();
            let (mut low, mut high) = match lens.distance() {
                None => {
                    radius = radius.max(SMALLEST_RADIUS);
                    (
                        (centre.x - radius, centre.y - radius),
                        (centre.x + radius, centre.y + radius),
                    )
                }
                Some(distance) => {
                    let far = distance + centre.z;
                    radius = radius.max(SMALLEST_RADIUS * far / distance);
                    if far - radius <= lens.nearest() {
                        return None;
                    }
                    let (x, y) = (
                        tangents(centre.x, far, radius),
                        tangents(centre.y, far, radius),
                    );
                    (
                        (x.0 * distance, y.0 * distance),
                        (x.1 * distance, y.1 * distance),
                    )
                }
            };
            for corner in [&mut low, &mut high] {
                corner.0 += 0.5 * columns as f64;
                corner.1 += 0.5 * rows as f64;
            }
            Some(SeenSphere {
                centre,
                radius,
                index: index as u32,
                rect: Rect::around(low, high, columns, rows)?,
            })
        })
        .collect();
    seen.par_sort_unstable_by(|a, b| {
        f64::total_cmp(&a.nearest(), &b.nearest()).then(a.index.cmp(&b.index))
    });
    seen
}

/// Slopes of the two rays in a plane that touch a circle; it lies wholly before the eye.
fn tangents(sideways: f64, far: f64, radius: f64) -> (f64, f64) {
    let square = far * far - radius * radius;
    let root = radius * (sideways * sideways + square).max(0.0).sqrt();
    (
        (sideways * far - root) / square,
        (sideways * far + root) / square,
    )
}

/// Where the ray through the window's place (u, v) first meets a sphere: the outward normal there and the depth.
pub(super) fn hit(
    sphere: &SeenSphere,
    distance: Option<f64>,
    u: f64,
    v: f64,
) -> Option<(DVec3, f64)> {
    let Some(distance) = distance else {
        let (x, y) = (u - sphere.centre.x, v - sphere.centre.y);
        let square = sphere.radius * sphere.radius - x * x - y * y;
        let normal = DVec3::new(x, y, -square.max(0.0).sqrt());
        return (square >= 0.0).then(|| (normal / sphere.radius, sphere.centre.z + normal.z));
    };
    // The foot of the perpendicular from the centre, not the quadratic formula, which cancels far away.
    let ray = DVec3::new(u, v, distance).normalize();
    let centre = sphere.centre + DVec3::new(0.0, 0.0, distance);
    let along = ray.dot(centre);
    let across = centre - along * ray;
    let square = sphere.radius * sphere.radius - across.length_squared();
    (square >= 0.0).then(|| {
        let normal = -across - square.sqrt() * ray;
        (normal / sphere.radius, sphere.centre.z + normal.z)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn rays_meet_the_sphere_on_its_surface(
            x in -100.0..100.0f64, y in -100.0..100.0f64, z in -200.0..500.0f64, radius in 1.0..60.0f64,
            angle in 0.0..6.3f64, share in 0.0..0.99f64,
        ) {
            let centre = DVec3::new(x, y, z);
            let sphere = SeenSphere { centre, radius, index: 0, rect: Rect { x0: 0, y0: 0, x1: 1, y1: 1 } };
            for distance in [None, Some(1000.0)] {
                // Towards a point inside the sphere, so that the ray meets it.
                let inside = centre + share * radius * DVec3::new(angle.cos(), angle.sin(), 0.0);
                let shrink = distance.map_or(1.0, |d| d / (d + inside.z));
                let (u, v) = (inside.x * shrink, inside.y * shrink);
                let (normal, depth) = hit(&sphere, distance, u, v).unwrap();
                prop_assert!((normal.length() - 1.0).abs() < 1e-9);
                let point = centre + radius * normal;
                prop_assert!((point.z - depth).abs() < 1e-9);
                let stretch = distance.map_or(1.0, |d| (d + depth) / d);
                prop_assert!((point.x - u * stretch).abs() < 1e-7 && (point.y - v * stretch).abs() < 1e-7);
                prop_assert!(depth <= inside.z + 1e-9, "the near side");
            }
        }

        #[test]
        fn the_rectangle_is_that_of_the_outline(x in -300.0..300.0f64, z in -200.0..500.0f64, radius in 1.0..60.0f64) {
            let (far, distance) = (1000.0 + z, 1000.0);
            let (low, high) = tangents(x, far, radius);
            let sphere = SeenSphere {
                centre: DVec3::new(x, 0.0, z), radius, index: 0, rect: Rect { x0: 0, y0: 0, x1: 1, y1: 1 },
            };
            for (slope, inward) in [(low, 1e-6), (high, -1e-6)] {
                prop_assert!(hit(&sphere, Some(distance), (slope + inward) * distance, 0.0).is_some());
                prop_assert!(hit(&sphere, Some(distance), (slope - inward) * distance, 0.0).is_none());
            }
        }
    }
}
