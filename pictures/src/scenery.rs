//! Walls and bodies of a run as parts of a [`crate::Frame`], for every program that draws runs: the solver's own picture and
//! `mercury-export`.

use glam::{DQuat, DVec3};
use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::frames::WearFrame;
use mercury_common::surfaces::{self, Placement, faces_of_one_box};

use crate::frame::{Grain, Surface};

/// Particles are at rest while their kinetic energy is less than this share of the energy that they would gain by falling by their diameter: the limit
/// of `until_at_rest`.
const REST_ENERGY: f64 = 1e-6;
/// Without gravity they are at rest while they are so slow that they would have come by this share of their diameter since the start.
const REST_WAY: f64 = 1e-6;

/// Whether particles move at a time (s) under this gravity (m/s²), or what they do is no more than what is left of their way to rest, or round-off.
/// `grains`: radius (m) and velocity (m/s) of each. All are taken to be as dense.
pub fn moves(gravity: DVec3, time: f64, grains: impl Iterator<Item = (f64, DVec3)>) -> bool {
    let (mut energy, mut fall, mut way) = (0.0, 0.0, 0.0);
    for (radius, velocity) in grains {
        let (mass, diameter) = (radius * radius * radius, 2.0 * radius);
        energy += 0.5 * mass * velocity.length_squared();
        fall += mass * gravity.length() * diameter;
        let slow = REST_WAY * diameter / time;
        way += 0.5 * mass * slow * slow;
    }
    let rests = energy <= REST_ENERGY * fall || (time > 0.0 && energy <= way);
    // A grain whose energy is not a number counts as moving.
    !rests && energy != 0.0
}

/// The walls that are there, where they stand. `standing` is the placement of each of `shapes`; `names` show which planes are
/// faces of one box and end each other. Planes are cut at the domain.
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

/// The triangles of these mesh walls, as far as they are there, as they are worn: each is coloured by its mean depth (m).
#[must_use]
pub fn worn_triangles(
    wear: &WearFrame,
    walls: &[u32],
    shapes: &[surfaces::Surface],
    standing: &[Option<Placement>],
) -> Vec<Grain> {
    let mut triangles = Vec::new();
    for (wall, (shape, place)) in (0u32..).zip(shapes.iter().zip(standing)) {
        let (surfaces::Surface::Mesh(mesh), Some(place)) = (shape, place) else {
            continue;
        };
        if !walls.contains(&wall) {
            continue;
        }
        let (worn, depths) = wear.worn(wall, mesh);
        for corners in &worn.triangles {
            let depth: f64 = corners.iter().map(|&k| depths[k as usize]).sum();
            triangles.push(Grain {
                triangles: vec![corners.map(|k| place.to_global(worn.vertices[k as usize]))],
                value: depth / 3.0,
                fixed: false,
                of_wall: true,
            });
        }
    }
    triangles
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
            ..TriangleMesh::default()
        };
        let turn = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2);
        let grain = Grain::of_body(&surface, DVec3::Z, turn, 2.0);
        let [a, b, c] = grain.triangles[0];
        assert!(a.distance(DVec3::Z) < 1e-12);
        assert!(b.distance(DVec3::new(0.0, 2.0, 1.0)) < 1e-12);
        assert!(c.distance(DVec3::new(-2.0, 0.0, 1.0)) < 1e-12);
    }

    #[test]
    fn what_is_left_of_a_fall_is_rest() {
        let down = DVec3::NEG_Z * 10.0;
        // A bed of 1,000 beads of 1 mm. All at v: m v^2 / 2 = 1e-6 m g d at v = sqrt(2e-6 * 0.01 m^2/s^2) = 0.141 mm/s.
        let bed = |speed: f64| (0..1000).map(move |_| (0.5e-3, DVec3::X * speed));
        assert!(moves(down, 1.0, bed(1.5e-4)) && !moves(down, 1.0, bed(1.3e-4)));
        // One bead that rolls at 4 mm/s is no reason to show the round-off of the others, one that falls at 0.2 m/s is.
        let one = |speed: f64| bed(1e-9).chain([(0.5e-3, DVec3::X * speed)]);
        assert!(!moves(down, 1.0, one(4e-3)) && moves(down, 1.0, one(0.2)));
        // Without gravity round-off alone is rest: by 1 mm * 1e-6 in a second.
        assert!(!moves(DVec3::ZERO, 1.0, bed(0.9e-9)) && moves(DVec3::ZERO, 1.0, bed(1.1e-9)));
        assert!(moves(DVec3::ZERO, 0.0, bed(1e-12)));
        for gravity in [down, DVec3::ZERO] {
            assert!(!moves(gravity, 0.0, bed(0.0)) && !moves(gravity, 1.0, bed(0.0)));
            assert!(!moves(gravity, 1.0, std::iter::empty()));
            assert!(moves(gravity, 1.0, bed(f64::NAN)));
        }
    }
}
