//! What the colours of the spheres mean: speed, or height where everything is at rest.

use super::camera;
use super::{PictureScene, PictureSphere};
use crate::colour::{Colour, value_colour};
use glam::DVec3;

/// Spheres slower than this share of sqrt(g d) are at rest: they rose by less than 1e-12 diameters with it.
const REST: f64 = 1e-6;

/// What the colours mean.
pub(super) enum Colouring {
    /// Nothing moves freely: no bar.
    None,
    /// 0 to `top` (m/s); faster ones are drawn as `top`.
    Speed { top: f64, exceeded: bool },
    /// Height against gravity (m).
    Height { up: DVec3, low: f64, high: f64 },
}

impl Colouring {
    pub(super) fn new(scene: &PictureScene) -> Self {
        let free = || {
            scene
                .spheres
                .iter()
                .filter(|s| !s.fixed && s.speed.is_finite() && s.centre.is_finite())
        };
        let mut speeds: Vec<f64> = free().map(|s| s.speed.abs()).collect();
        if speeds.is_empty() {
            return Self::None;
        }
        let fastest = speeds.iter().copied().fold(0.0, f64::max);
        let diameter = free().map(|s| 2.0 * s.radius).sum::<f64>() / speeds.len() as f64;
        let gravity = scene.gravity.length();
        if fastest <= REST * (gravity * diameter).max(0.0).sqrt() {
            let up = camera::upward(scene);
            let heights = || free().map(|s| s.centre.dot(up));
            let (low, high) = (
                heights().fold(f64::MAX, f64::min),
                heights().fold(f64::MIN, f64::max),
            );
            // One layer: give the bar the thickness of a grain.
            let room = if high - low > 1e-9 * diameter {
                0.0
            } else {
                0.5 * diameter
            };
            return Self::Height {
                up,
                low: low - room,
                high: high + room,
            };
        }
        // A few that fly must not leave all others in one colour; of fewer than a hundred none is "a few".
        let place = (speeds.len() - 1) * 99 / 100;
        let usual = *speeds.select_nth_unstable_by(place, f64::total_cmp).1;
        if speeds.len() >= 100 && usual > 0.0 && fastest > 3.0 * usual {
            Self::Speed {
                top: usual,
                exceeded: true,
            }
        } else {
            Self::Speed {
                top: fastest,
                exceeded: false,
            }
        }
    }

    /// Place of a sphere along the colour bar, 0 to 1; `None` for grey.
    pub(super) fn place(&self, sphere: &PictureSphere) -> Option<f64> {
        if sphere.fixed {
            return None;
        }
        match self {
            Self::None => None,
            Self::Speed { top, .. } => Some((sphere.speed.abs() / top).clamp(0.0, 1.0)),
            Self::Height { up, low, high } => {
                Some(((sphere.centre.dot(*up) - low) / (high - low)).clamp(0.0, 1.0))
            }
        }
    }

    pub(super) fn colour(&self, sphere: &PictureSphere) -> Colour {
        self.place(sphere).map_or(Colour::FIXED, value_colour)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(spheres: &[PictureSphere]) -> PictureScene<'_> {
        PictureScene {
            title: "",
            time: 0.0,
            spheres,
            domain_min: DVec3::ZERO,
            domain_max: DVec3::ONE,
            gravity: DVec3::new(0.0, 0.0, -9.81),
            dimensions: 3,
            walls: &[],
        }
    }

    fn moving(z: f64, speed: f64) -> PictureSphere {
        PictureSphere {
            centre: DVec3::new(0.5, 0.5, z),
            radius: 0.01,
            speed,
            fixed: false,
        }
    }

    #[test]
    fn speed_colours_the_moving_height_the_resting() {
        let spheres = [moving(0.1, 0.0), moving(0.3, 2.0)];
        let colouring = Colouring::new(&scene(&spheres));
        assert!(matches!(
            colouring,
            Colouring::Speed {
                top: 2.0,
                exceeded: false
            }
        ));
        // sqrt(9.81 * 0.02) = 0.44 m/s: a nanometre per second is rest.
        let spheres = [moving(0.1, 1e-9), moving(0.3, 0.0)];
        match Colouring::new(&scene(&spheres)) {
            Colouring::Height { low, high, .. } => assert_eq!((low, high), (0.1, 0.3)),
            _ => panic!("expected height"),
        }
    }

    #[test]
    fn one_flying_sphere_does_not_flatten_the_colours() {
        let mut spheres: Vec<_> = (0..200)
            .map(|i| moving(0.1, 0.001 * f64::from(i)))
            .collect();
        spheres.push(moving(0.9, 50.0));
        match Colouring::new(&scene(&spheres)) {
            Colouring::Speed { top, exceeded } => assert!(exceeded && top < 0.2, "{top}"),
            _ => panic!("expected speed"),
        }
    }
}
