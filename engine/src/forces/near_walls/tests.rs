//! The search through the cells finds the same as a test of every particle against every wall, in the same order.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::DVec3;
use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::random::Stream;
use proptest::prelude::*;

use super::*;
use crate::neighbours::{Built, Levels, Margin, build};
use crate::state::{MaterialIndex, Particle, WallIndex};
use crate::walls::{
    Component, Cone, Cylinder, Disc, Mesh, Motion, Plane, Revolution, Side, SphereShell, Wall,
};

/// Queries every particle and every wall, with all its images.
fn by_testing_all(
    particles: &Particles,
    extra_skin: &[f64],
    walls: &[WallNow],
    cell: &Cell,
    margin: f64,
) -> Vec<NearWall> {
    let margin = &Margin::of_skin(margin);
    let mut tests = Tests {
        records: &particles.records,
        extra_skin,
        cell,
        margin,
        touches: Touches::default(),
        scratch: Scratch::default(),
    };
    let mut found = Vec::new();
    for row in 0..particles.len() {
        for (index, wall) in walls.iter().enumerate() {
            for &code in wall.met_by() {
                found.extend(tests.test(wall, (row, 0.0), code).map(|(image, features)| {
                    NearWall {
                        row: row as u32,
                        wall: WallIndex::new(index as u16),
                        image,
                        features,
                    }
                }));
            }
        }
    }
    found
}

/// Draws walls and particles.
struct Draw(Stream);

impl Draw {
    fn in_range(&mut self, low: f64, high: f64) -> f64 {
        self.0.uniform_in(low, high)
    }

    fn vector(&mut self, low: f64, high: f64) -> DVec3 {
        DVec3::from([0; 3].map(|_| self.in_range(low, high)))
    }

    fn one_of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[(self.in_range(0.0, choices.len() as f64)) as usize]
    }

    /// Triangles with common corners: some large, some in a fine sheet.
    fn mesh(&mut self, corner: DVec3) -> Mesh {
        let cells = self.one_of(&[1u32, 3, 20]);
        let (place, size) = (self.vector(-0.5, 1.0) + corner, self.in_range(0.05, 1.0));
        let (u, v) = (self.vector(-1.0, 1.0), self.vector(-1.0, 1.0));
        let mut sheet = TriangleMesh::default();
        for j in 0..=cells {
            for i in 0..=cells {
                let [s, t] = [i, j].map(|k| f64::from(k) / f64::from(cells));
                let wave = 0.1 * (TAU * s).sin() * DVec3::Z;
                sheet.vertices.push(place + size * (s * u + t * v + wave));
                if i < cells && j < cells {
                    let a = j * (cells + 1) + i;
                    let (b, c, d) = (a + 1, a + cells + 2, a + cells + 1);
                    sheet.triangles.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
        let front = self.one_of(&[false, true]);
        Mesh::new(&sheet, |x| x, front).unwrap()
    }

    /// A flat floor of one period along x, which continues periodically.
    fn endless_floor(&mut self, cell: &Cell) -> Option<Mesh> {
        let (length, z) = (cell.size().x, self.in_range(0.0, cell.size().z));
        let corner = cell.low();
        let cells = self.one_of(&[1u32, 9]);
        let mut floor = TriangleMesh::default();
        for i in 0..=cells {
            let x = cell.low().x + length * f64::from(i) / f64::from(cells);
            floor.vertices.extend([
                DVec3::new(x, 0.1 + corner.y, z + corner.z),
                DVec3::new(x, 0.3 + corner.y, z + corner.z),
            ]);
            if i < cells {
                let a = 2 * i;
                floor
                    .triangles
                    .extend([[a, a + 2, a + 3], [a, a + 3, a + 1]]);
            }
        }
        let mesh = Mesh::new(&floor, |x| x, false).unwrap();
        mesh.continued(&[(0, cell.low().x, length)], 0.25)
    }

    fn shape(&mut self, cell: &Cell) -> Shape {
        let side = self.one_of(&[Side::Inside, Side::Outside, Side::Both]);
        let (axis, origin) = (self.vector(-1.0, 1.0), self.vector(-0.5, 1.5) + cell.low());
        let axis = self.one_of(&[axis, DVec3::X, DVec3::Z, -DVec3::Y]);
        let size = self.one_of(&[0.02, 0.3, 2.0]) * self.in_range(0.5, 1.0);
        let other = self.in_range(0.0, 1.0) * size;
        match self.one_of(&[0, 1, 2, 3, 4, 5, 6, 7, 8]) {
            0 => Shape::Plane(Plane::new(origin, axis).unwrap()),
            1 => Shape::Disc(Disc::new(axis, origin, size).unwrap()),
            2 => Shape::Cylinder(Cylinder::new(axis, origin, size, None, side).unwrap()),
            3 => {
                let along = Some([-0.4 * size, other]);
                Shape::Cylinder(Cylinder::new(axis, origin, size, along, side).unwrap())
            }
            4 => {
                let radii = [size, self.one_of(&[0.0, other])];
                Shape::Cone(Cone::new(axis, origin, [-other, size], radii, side).unwrap())
            }
            5 => Shape::Sphere(SphereShell::new(origin, size, side).unwrap()),
            6 => {
                let profile = [
                    [0.0, 0.0],
                    [size, 0.1 * size],
                    [other, size],
                    [size, 2.0 * size],
                ];
                Shape::Revolution(Revolution::new(axis, origin, &profile, side).unwrap())
            }
            7 if cell.is_periodic(0) => match self.endless_floor(cell) {
                Some(mesh) => Shape::Mesh(Arc::new(mesh)),
                None => Shape::Mesh(Arc::new(self.mesh(cell.low()))),
            },
            _ => Shape::Mesh(Arc::new(self.mesh(cell.low()))),
        }
    }

    /// A wall that has moved, in some cases.
    fn wall(&mut self, cell: &Cell) -> WallNow {
        let shape = self.shape(cell);
        let endless = matches!(&shape, Shape::Mesh(mesh) if !mesh.periods().is_empty());
        let mut components = Vec::new();
        if self.one_of(&[false, true]) {
            let turn = self.vector(-1.0, 1.0);
            components.push(Component::Rotation {
                axis: if endless { DVec3::X } else { turn },
                origin: self.vector(0.0, 1.0) + cell.low(),
                angular_velocity: 3.0,
                from: 0.0,
                until: f64::INFINITY,
            });
        }
        if self.one_of(&[false, true]) {
            components.push(Component::Translation {
                velocity: self.vector(-1.0, 1.0),
                from: 0.0,
                until: f64::INFINITY,
            });
        }
        let wall = Wall {
            name: "wall".to_owned(),
            material: MaterialIndex::new(0),
            shape,
            motion: Motion::new(components).unwrap(),
            from: 0.0,
            until: f64::INFINITY,
            reference: DVec3::ZERO,
        };
        let mut now = WallNow::new(&wall, 0.1, cell);
        now.advance(&wall, self.in_range(0.0, 2.0), 0.1, cell);
        now.note_images(cell);
        now
    }

    fn particles(&mut self, count: usize, size: DVec3, ratio: f64) -> Particles {
        let mut particles = Particles::new(false);
        for k in 0..count {
            let record = Particle {
                position: self.vector(0.0, 1.0) * size,
                radius: 0.1 * ratio.powf(-self.in_range(0.0, 1.0)) * ratio.min(1.5) / 1.5,
                velocity: DVec3::ZERO,
                inverse_mass: f64::from(k % 6 != 5),
                angular_velocity: DVec3::ZERO,
                material: MaterialIndex::new(0),
                flags: 0,
            };
            particles.push(record, 1.0, None);
        }
        particles
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn the_cells_find_what_every_particle_finds(
        seed in any::<u64>(),
        count in 0usize..500,
        walls in 0usize..12,
        ratio in prop_oneof![Just(1.0), 1.0..10.0f64, 10.0..300.0f64],
        periodic in any::<[bool; 3]>(),
        margin in 0.0..0.03f64,
        farther in 0.0..0.1f64,
        extra_skin_every in 0usize..30,
        outside in any::<bool>(),
        far in prop_oneof![Just(0.0), Just(1e3)],
    ) {
        let mut draw = Draw(Stream::new(seed, "near walls", 0));
        let size = DVec3::new(0.7, 0.9, 1.2);
        // A box far from the origin has its round-off.
        let corner = DVec3::splat(far);
        let cell = Cell::new(corner, corner + size, periodic);
        let mut particles = draw.particles(count, size, ratio);
        for (k, record) in particles.records.iter_mut().enumerate() {
            record.position += corner;
            if outside {
                record.position += DVec3::new(0.1, -0.3, 0.2) * (k % 4) as f64;
            }
        }
        let ahead = |k: usize| if k.is_multiple_of(extra_skin_every) { farther } else { 0.0 };
        let extra_skin: Vec<f64> =
            (0..if extra_skin_every > 0 { count } else { 0 }).map(ahead).collect();
        let levels = Levels::choose(&particles.records, margin);
        let mut extra_skin = extra_skin;
        let listed = Margin::of_skin(margin);
        let Built { grid, .. } =
            build(&mut particles, &mut extra_skin, &levels, &listed, &cell, false);
        let walls: Vec<WallNow> = (0..walls).map(|_| draw.wall(&cell)).collect();
        let expected = by_testing_all(&particles, &extra_skin, &walls, &cell, margin);
        for parallel in [false, true] {
            let found =
                find_near_walls(&particles, &extra_skin, &grid, &walls, &cell, &listed, &(0..count), parallel);
            prop_assert_eq!(&found, &expected);
        }
    }
}
