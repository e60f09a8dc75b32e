//! Time of the search for particles near walls when a candidate list is built: through the cells, and by a test of every particle
//! with every wall; in one run, alternating.
//!
//!     cargo run --release -p solver --example many_walls

use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;
use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::random::Stream;
use mercury_engine::cell::Cell;
use mercury_engine::forces::find_near_walls;
use mercury_engine::neighbours::{Built, Levels, Margin, build};
use mercury_engine::state::{MaterialIndex, Particle, Particles};
use mercury_engine::walls::{
    Cylinder, Disc, Mesh, Motion, Plane, Scratch, Shape, Side, Touches, Wall, WallError, WallNow,
};

const RADIUS: f64 = 1.0;
/// Spheres along each edge of the packing.
const EDGE: usize = 27;
const MARGIN: f64 = 0.1 * RADIUS;
const ROUNDS: usize = 7;

/// Nearly touching spheres with the density of a random packing, in a cube.
fn packing(random: &mut Stream) -> (Particles, f64) {
    let spacing = 1.92 * RADIUS;
    let mut particles = Particles::new(false);
    for k in 0..EDGE * EDGE * EDGE {
        let place = [k % EDGE, k / EDGE % EDGE, k / EDGE / EDGE];
        let at = place.map(|k| (k as f64 + 0.5 + 0.1 * (random.uniform() - 0.5)) * spacing);
        let record = Particle {
            position: at.into(),
            radius: RADIUS,
            velocity: DVec3::ZERO,
            inverse_mass: 1.0,
            angular_velocity: DVec3::ZERO,
            material: MaterialIndex::new(0),
            flags: 0,
        };
        particles.push(record, 1.0, None);
    }
    (particles, EDGE as f64 * spacing)
}

/// The cube of 12 triangles about a place.
fn block(place: DVec3, half: f64) -> Result<Mesh, WallError> {
    let corner = |k: u32| DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2));
    let faces = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let halves = faces.map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let cube = TriangleMesh {
        vertices: (0..8).map(|k| (corner(k) * 2.0 - 1.0) * half).collect(),
        triangles: halves.concat(),
        ..TriangleMesh::default()
    };
    Mesh::new(&cube, |x| x + place, false)
}

/// The surface number `k` of a kind, in a cube of this size.
fn shape(kind: &str, k: usize, size: f64, random: &mut Stream) -> Result<Shape, WallError> {
    let mut vector = || DVec3::from([0; 3].map(|_| random.uniform()));
    let (axis, place) = (vector() - 0.5, vector() * size);
    Ok(match kind {
        // The faces of the cube, again and again.
        "planes" => {
            let is_low = k.is_multiple_of(2);
            let normal = DVec3::AXES[k % 3] * if is_low { 1.0 } else { -1.0 };
            let point = if is_low { 0.0 } else { size };
            Shape::Plane(Plane::new(DVec3::splat(point), normal)?)
        }
        "discs" => Shape::Disc(Disc::new(axis, place, 3.0 * RADIUS)?),
        "rods" => {
            let (radius, along) = (1.5 * RADIUS, Some([0.0, 10.0 * RADIUS]));
            Shape::Cylinder(Cylinder::new(axis, place, radius, along, Side::Outside)?)
        }
        "tubes" => {
            let radius = 0.2 * size;
            Shape::Cylinder(Cylinder::new(axis, place, radius, None, Side::Both)?)
        }
        _ => Shape::Mesh(Arc::new(block(place, 2.0 * RADIUS)?)),
    })
}

/// As before there were blocks: every wall tests every particle.
fn by_testing_all(particles: &Particles, walls: &[WallNow], cell: &Cell) -> usize {
    let (mut touches, mut scratch) = (Touches::default(), Scratch::default());
    let mut found = 0;
    for wall in walls {
        for &code in wall.met_by() {
            for record in &particles.records {
                let image = wall.image_of(record.position, code);
                let centre = (wall.state).into_wall(record.position + cell.shift(image));
                let reach = record.radius + MARGIN;
                found += usize::from(match wall.shape() {
                    Shape::Plane(plane) => plane.touch(centre, reach).is_some(),
                    Shape::Mesh(mesh) => mesh.may_be_near(centre, reach, &mut scratch),
                    shape => {
                        shape.touches(centre, reach, &mut touches);
                        !touches.is_empty()
                    }
                });
            }
        }
    }
    found
}

/// The least of some times: what else the machine does makes them longer only.
fn least(times: &[f64]) -> f64 {
    times.iter().copied().fold(f64::INFINITY, f64::min)
}

/// Milliseconds that something takes.
fn time<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let start = Instant::now();
    let result = black_box(work());
    (1e3 * start.elapsed().as_secs_f64(), result)
}

fn main() -> Result<(), WallError> {
    let mut random = Stream::new(1, "many walls", 0);
    let (mut particles, size) = packing(&mut random);
    println!(
        "{} spheres; ms for a list, the least of {ROUNDS}",
        particles.len()
    );
    println!(
        "{:8} {:>6} {:>8} {:>10} {:>12} {:>10}",
        "walls", "count", "near", "the pairs", "asking all", "cells"
    );
    for periodic in [false, true] {
        let cell = Cell::new(DVec3::ZERO, DVec3::splat(size), [periodic; 3]);
        for kind in ["planes", "discs", "rods", "tubes", "blocks"] {
            for count in [1, 6, 10, 100, 1000] {
                if (kind == "planes" && count > 10)
                    || (periodic && (kind == "planes" || count > 100))
                {
                    continue;
                }
                let mut walls = Vec::with_capacity(count);
                for k in 0..count {
                    let wall = Wall {
                        name: String::new(),
                        material: MaterialIndex::new(0),
                        shape: shape(kind, k, size, &mut random)?,
                        motion: Motion::new(Vec::new())?,
                        from: 0.0,
                        until: f64::INFINITY,
                        reference: DVec3::ZERO,
                    };
                    walls.push(WallNow::new(&wall, 1.0, &cell));
                }
                let (mut pairs, mut plain, mut cells) = (Vec::new(), Vec::new(), Vec::new());
                let mut near = 0;
                for _ in 0..ROUNDS {
                    let (of_pairs, Built { grid, .. }) = time(|| {
                        let levels = Levels::choose(&particles.records, MARGIN);
                        let mut extra = Vec::new();
                        build(
                            &mut particles,
                            &mut extra,
                            &levels,
                            &Margin::of_skin(MARGIN),
                            &cell,
                            false,
                        )
                    });
                    let (of_plain, found) = time(|| by_testing_all(&particles, &walls, &cell));
                    let (of_cells, listed) = time(|| {
                        find_near_walls(
                            &particles,
                            &[],
                            &grid,
                            &walls,
                            &cell,
                            &Margin::of_skin(MARGIN),
                            &(0..particles.len()),
                            false,
                        )
                    });
                    assert_eq!(listed.len(), found);
                    near = found;
                    pairs.push(of_pairs);
                    plain.push(of_plain);
                    cells.push(of_cells);
                }
                let name = if periodic {
                    format!("{kind}, p")
                } else {
                    kind.to_owned()
                };
                println!(
                    "{name:10} {count:>5} {near:>8} {:>10.2} {:>12.3} {:>10.3}",
                    least(&pairs),
                    least(&plain),
                    least(&cells)
                );
            }
        }
    }
    Ok(())
}
