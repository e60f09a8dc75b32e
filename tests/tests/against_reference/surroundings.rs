//! Walls and periodic axes, for both paths.

use std::sync::Arc;

use glam::{DVec3, dvec3};
use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::random::Stream;
use mercury_engine::walls as fast;
use mercury_tests::reference::walls as plain;
use mercury_tests::scenes::wall;
use mercury_tests::twins::TwinWall;

use super::SIZE;

/// Walls, periodic axes and the like.
pub(crate) struct Surroundings {
    pub(crate) name: &'static str,
    pub(crate) walls: Vec<TwinWall>,
    pub(crate) periodic: [bool; 3],
    pub(crate) gravity: DVec3,
    pub(crate) dimensions: u8,
}

fn open(name: &'static str) -> Surroundings {
    Surroundings {
        name,
        walls: Vec::new(),
        periodic: [false; 3],
        gravity: DVec3::ZERO,
        dimensions: 3,
    }
}

fn twin(shape: Result<fast::Shape, fast::WallError>, plain: plain::Shape) -> TwinWall {
    TwinWall {
        fast: wall(shape.unwrap(), fast::Motion::default()),
        plain: plain::Wall::at_rest(plain),
    }
}

fn plane(point: DVec3, normal: DVec3) -> TwinWall {
    let normal = normal.normalize();
    twin(
        fast::Plane::new(point, normal).map(fast::Shape::Plane),
        plain::Shape::Plane { point, normal },
    )
}

fn side(inside: bool) -> (fast::Side, plain::Side) {
    if inside {
        (fast::Side::Inside, plain::Side::Inside)
    } else {
        (fast::Side::Outside, plain::Side::Outside)
    }
}

fn cylinder(origin: DVec3, axis: DVec3, radius: f64, inside: bool) -> TwinWall {
    let (fast_side, side) = side(inside);
    twin(
        fast::Cylinder::new(axis, origin, radius, None, fast_side).map(fast::Shape::Cylinder),
        plain::Shape::Cylinder {
            origin,
            axis,
            radius,
            side,
        },
    )
}

fn ball(origin: DVec3, radius: f64, inside: bool) -> TwinWall {
    let (fast_side, side) = side(inside);
    twin(
        fast::SphereShell::new(origin, radius, fast_side).map(fast::Shape::Sphere),
        plain::Shape::Sphere {
            origin,
            radius,
            side,
        },
    )
}

fn disc(origin: DVec3, axis: DVec3, radius: f64) -> TwinWall {
    let axis = axis.normalize();
    twin(
        fast::Disc::new(axis, origin, radius).map(fast::Shape::Disc),
        plain::Shape::disc(origin, axis, radius),
    )
}

fn cone(origin: DVec3, axis: DVec3, along: [f64; 2], radii: [f64; 2]) -> TwinWall {
    let axis = axis.normalize();
    twin(
        fast::Cone::new(axis, origin, along, radii, fast::Side::Both).map(fast::Shape::Cone),
        plain::Shape::cone(origin, axis, along, radii),
    )
}

fn pipe(origin: DVec3, axis: DVec3, radius: f64, along: [f64; 2]) -> TwinWall {
    let axis = axis.normalize();
    twin(
        fast::Cylinder::new(axis, origin, radius, Some(along), fast::Side::Both)
            .map(fast::Shape::Cylinder),
        plain::Shape::pipe(origin, axis, radius, along),
    )
}

fn revolution(origin: DVec3, axis: DVec3, profile: &[[f64; 2]]) -> TwinWall {
    let axis = axis.normalize();
    twin(
        fast::Revolution::new(axis, origin, profile, fast::Side::Both).map(fast::Shape::Revolution),
        plain::Shape::Revolution {
            origin,
            axis,
            profile: profile.iter().map(|&[r, z]| (r, z)).collect(),
        },
    )
}

fn triangles(corners: &[DVec3], indices: &[[u32; 3]]) -> TwinWall {
    let mesh = TriangleMesh {
        vertices: corners.to_vec(),
        triangles: indices.to_vec(),
        ..TriangleMesh::default()
    };
    let plain = (0..indices.len())
        .map(|index| mesh.corners(index))
        .collect();
    twin(
        fast::Mesh::new(&mesh, |x| x, false).map(|mesh| fast::Shape::Mesh(Arc::new(mesh))),
        plain::Shape::Triangles(plain),
    )
}

/// A bumpy floor of 2 x 8 x 8 triangles, as large as two domains.
fn bumpy_floor() -> TwinWall {
    let mut random = Stream::new(7, "bumpy floor", 0);
    let (mut corners, mut indices) = (Vec::new(), Vec::new());
    for j in 0..9u32 {
        for i in 0..9u32 {
            let place = dvec3(f64::from(i), f64::from(j), 0.0) / 4.0 - dvec3(0.5, 0.5, 0.0);
            corners.push(place * SIZE + DVec3::Z * 0.02 * random.uniform());
            if i < 8 && j < 8 {
                let first = 9 * j + i;
                indices.push([first, first + 1, first + 10]);
                indices.push([first, first + 10, first + 9]);
            }
        }
    }
    triangles(&corners, &indices)
}

/// Twelve triangles between nine random corners about the middle: they share corners and edges, and cross.
fn tangle() -> TwinWall {
    let mut random = Stream::new(5, "tangle", 0);
    let corners: Vec<DVec3> = (0..9)
        .map(|_| dvec3(random.uniform(), random.uniform(), random.uniform()) * 0.6 + 0.2)
        .map(|place| place * SIZE)
        .collect();
    let indices: Vec<[u32; 3]> = (0..12)
        .map(|k| [k % 9, (k + 1) % 9, (k * k + 4) % 9])
        .filter(|[a, b, c]| a != c && b != c)
        .collect();
    triangles(&corners, &indices)
}

fn moving(mut wall: TwinWall, velocity: DVec3) -> TwinWall {
    wall.fast.motion = fast::Motion::new(vec![fast::Component::Translation {
        velocity,
        from: 0.0,
        until: f64::INFINITY,
    }])
    .unwrap();
    wall.plain.motion = plain::Motion::Translation(velocity);
    wall
}

fn turning(mut wall: TwinWall, origin: DVec3, angular_velocity: DVec3) -> TwinWall {
    wall.fast.motion = fast::Motion::new(vec![fast::Component::Rotation {
        axis: angular_velocity,
        origin,
        angular_velocity: angular_velocity.length(),
        from: 0.0,
        until: f64::INFINITY,
    }])
    .unwrap();
    wall.plain.motion = plain::Motion::Rotation {
        origin,
        angular_velocity,
    };
    wall
}

/// All of them.
pub(crate) fn surroundings() -> Vec<Surroundings> {
    let middle = DVec3::splat(0.5 * SIZE);
    let weight = dvec3(1.0, 0.0, -9.81);
    let tilted = dvec3(0.3, 0.2, 1.0);
    vec![
        Surroundings {
            gravity: weight,
            ..open("open")
        },
        Surroundings {
            periodic: [true, false, false],
            ..open("periodic x")
        },
        Surroundings {
            periodic: [false, true, true],
            ..open("periodic yz")
        },
        Surroundings {
            periodic: [true; 3],
            ..open("periodic xyz")
        },
        Surroundings {
            walls: vec![
                plane(DVec3::ZERO, DVec3::Z),
                plane(dvec3(0.0, 0.0, SIZE), -DVec3::Z),
            ],
            periodic: [true, true, false],
            gravity: weight,
            ..open("periodic xy between plates")
        },
        Surroundings {
            walls: vec![
                plane(DVec3::ZERO, DVec3::X),
                plane(dvec3(SIZE, 0.0, 0.0), dvec3(-1.0, 0.0, 0.1)),
                moving(plane(DVec3::ZERO, DVec3::Y), dvec3(0.2, 0.3, 0.1)),
                plane(dvec3(0.0, SIZE, 0.0), -DVec3::Y),
                plane(DVec3::ZERO, dvec3(0.2, 0.1, 1.0)),
            ],
            gravity: weight,
            ..open("box with a moving side")
        },
        Surroundings {
            walls: vec![turning(
                cylinder(middle, DVec3::Y, 0.5 * SIZE, true),
                middle,
                6.0 * DVec3::Y,
            )],
            periodic: [false, true, false],
            gravity: weight,
            ..open("turning drum, periodic y")
        },
        Surroundings {
            walls: vec![ball(middle, 0.55 * SIZE, true)],
            ..open("in a sphere")
        },
        Surroundings {
            walls: vec![ball(middle, 0.2 * SIZE, false)],
            periodic: [true; 3],
            ..open("round a sphere, periodic xyz")
        },
        Surroundings {
            walls: vec![
                cylinder(middle, DVec3::Z, 0.2 * SIZE, false),
                plane(DVec3::ZERO, DVec3::Z),
            ],
            gravity: weight,
            ..open("round a column")
        },
        Surroundings {
            walls: vec![
                disc(middle, tilted, 0.3 * SIZE),
                plane(DVec3::ZERO, DVec3::Z),
            ],
            gravity: weight,
            ..open("on a plate")
        },
        Surroundings {
            walls: vec![turning(
                disc(middle, tilted, 0.35 * SIZE),
                middle,
                dvec3(2.0, -1.0, 4.0),
            )],
            ..open("round a tumbling plate")
        },
        Surroundings {
            walls: vec![
                cone(middle, tilted, [-0.1, 0.08], [0.03, 0.12]),
                pipe(middle, dvec3(0.0, 0.0, 1.0), 0.13, [-0.2, -0.11]),
            ],
            gravity: weight,
            ..open("funnel on a pipe")
        },
        Surroundings {
            walls: vec![moving(
                revolution(
                    middle,
                    DVec3::Y,
                    &[[0.0, -0.1], [0.1, -0.05], [0.12, 0.06], [0.09, 0.12]],
                ),
                dvec3(0.1, -0.4, 0.0),
            )],
            ..open("moving vase")
        },
        Surroundings {
            walls: vec![bumpy_floor()],
            gravity: weight,
            ..open("on a bumpy mesh")
        },
        Surroundings {
            walls: vec![turning(tangle(), middle, dvec3(2.0, -1.0, 4.0))],
            ..open("round a tumbling tangle of triangles")
        },
        Surroundings {
            walls: vec![plane(DVec3::ZERO, DVec3::Y)],
            periodic: [true, false, false],
            gravity: dvec3(0.0, -9.81, 0.0),
            dimensions: 2,
            ..open("discs, periodic x")
        },
    ]
}
