//! Walls and bodies of a run as parts of a [`crate::Frame`], for everybody who draws runs: the solver's own picture and
//! `mercury-export`.

use glam::{DQuat, DVec3};
use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::surfaces::{self, Placement, faces_of_one_box};

use crate::frame::{Grain, Surface};

/// Spheres slower than this share of sqrt(g d) are at rest: they rose by less than 1e-12 diameters with it.
const REST: f64 = 1e-6;

/// The speed (m/s) up to which particles of this mean diameter (m) are at rest under this gravity (m/s²).
#[must_use]
pub fn rest_speed(gravity: DVec3, diameter: f64) -> f64 {
    REST * (gravity.length() * diameter).max(0.0).sqrt()
}

/// The walls that are there, where they stand. `standing` says it for each of `shapes`; `names` tell which planes are faces of one
/// box and end each other. Planes are cut at the domain.
#[must_use]
pub fn wall_surfaces(
    names: &[String],
    shapes: &[surfaces::Surface],
    standing: &[Option<Placement>],
    domain: (DVec3, DVec3),
) -> Vec<Surface> {
    let ends = faces_of_one_box(names);
    let there = |k: usize| standing.get(k).copied().flatten();
    let mut walls = Vec::new();
    for (k, shape) in shapes.iter().enumerate() {
        let Some(placement) = there(k) else {
            continue;
        };
        let others = ends.get(k).map_or(&[][..], Vec::as_slice);
        let cuts: Vec<_> = (others.iter())
            .filter_map(|&other| shapes[other].half_space(&there(other)?))
            .collect();
        let mut wall = Surface::wall(corners(&shape.triangles(&placement, domain, &cuts), |x| x));
        if matches!(shape, surfaces::Surface::Plane { .. }) {
            // Planes are the box around the scene: six sheets would be a fog. Their outlines are enough.
            wall.opacity = 0.0;
        }
        walls.push(wall);
    }
    walls
}

impl Grain {
    /// A body by the surface of its clump: turned, enlarged and set down at `position` (m).
    #[must_use]
    pub fn of_body(surface: &TriangleMesh, position: DVec3, turn: DQuat, scale: f64) -> Self {
        Self {
            triangles: corners(surface, |x| position + turn * (x * scale)),
            value: f64::NAN,
            fixed: false,
            of_wall: false,
        }
    }
}

fn corners(mesh: &TriangleMesh, place: impl Fn(DVec3) -> DVec3) -> Vec<[DVec3; 3]> {
    let corner = |k: u32| place(mesh.vertices[k as usize]);
    mesh.triangles.iter().map(|t| t.map(corner)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(point: DVec3, normal: DVec3) -> surfaces::Surface {
        surfaces::Surface::Plane { point, normal }
    }

    #[test]
    fn planes_are_outlines_cut_at_the_domain_and_at_each_other() {
        let names = ["box.-z".to_owned(), "box.-x".to_owned(), "lid".to_owned()];
        let shapes = [
            plane(DVec3::ZERO, DVec3::Z),
            plane(DVec3::X, DVec3::X),
            plane(DVec3::Z, DVec3::NEG_Z),
        ];
        let there = Some(Placement::default());
        let domain = (DVec3::ZERO, DVec3::new(4.0, 1.0, 3.0));
        let walls = wall_surfaces(&names, &shapes, &[there, there, None], domain);
        assert_eq!(walls.len(), 2, "the lid is not there");
        assert!(walls.iter().all(|wall| wall.opacity == 0.0 && wall.edges));
        let lowest = walls[0].triangles.iter().flatten().map(|x| x.x);
        // The floor ends where the other face of the box stands.
        assert!((lowest.fold(f64::MAX, f64::min) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_body_is_turned_enlarged_and_moved() {
        let surface = TriangleMesh {
            vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
            triangles: vec![[0, 1, 2]],
            welded: 0,
        };
        let turn = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2);
        let grain = Grain::of_body(&surface, DVec3::Z, turn, 2.0);
        let [a, b, c] = grain.triangles[0];
        assert!(a.distance(DVec3::Z) < 1e-12);
        assert!(b.distance(DVec3::new(0.0, 2.0, 1.0)) < 1e-12);
        assert!(c.distance(DVec3::new(-2.0, 0.0, 1.0)) < 1e-12);
    }

    #[test]
    fn rest_is_slower_than_any_fall() {
        // sqrt(10 m/s² * 1 mm) = 0.1 m/s, of which a millionth.
        let rest = rest_speed(DVec3::NEG_Z * 10.0, 1e-3);
        assert!((rest - 1e-7).abs() < 1e-12, "{rest}");
        assert_eq!(rest_speed(DVec3::ZERO, 1e-3), 0.0);
    }
}
