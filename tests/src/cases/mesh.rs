//! T19: what a tessellated wall feels like, beside the wall that it tessellates.

use std::f64::consts::{FRAC_PI_4, TAU};
use std::sync::Arc;

use glam::{DQuat, DVec3, dvec3};
use mercury_common::formats::mesh::{TriangleMesh, push_binary_stl, read_mesh};
use mercury_common::random::Stream;
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, Hertz, Linear, Mindlin, PairLaw,
};
use mercury_engine::state::volume;
use mercury_engine::step::Engine;
use mercury_engine::walls::{Cylinder, Mesh, Motion, Plane, Shape, Side};

use super::Case;
use super::Tolerance::Absolute;
use crate::scenes::{advance, frictionless, particle, plan, row, sphere, start, wall};

const RADIUS: f64 = 0.005;

/// Rows of T19.
pub(super) fn cases() -> Vec<Case> {
    const ANALYTIC: &str = "the analytic wall in the same scene";
    let mut cases = vec![
        Case::new(
            "T19 engine: sliding and rolling over a tessellated plane, largest difference of the force over the force",
            0.0,
            // Round-off of 1e-17 m beside an overlap of 1e-4 m, grown over 2,000 steps.
            Absolute(1e-9),
            ANALYTIC,
            || over_a_plane(|mesh| mesh),
        ),
        Case::new(
            "T19 engine: the same from a binary STL file",
            0.0,
            // Coordinates of 0.02 m in single precision are off by up to 1e-9 m.
            Absolute(1e-4),
            ANALYTIC,
            || over_a_plane(through_stl),
        ),
        Case::new(
            "T19 engine: kinetic energy of an elastic ball in a closed box with a cube in it, after 40 impacts, over that before",
            1.0,
            // A contact begins and ends within a step: up to (omega dt)^2/4 each time.
            Absolute(40.0 * 0.25 * (1e-3 * std::f64::consts::PI).powi(2)),
            "conservation of energy",
            energy_in_a_box,
        ),
    ];
    for facets in [64, 128, 256] {
        cases.push(Case::new(
            format!("T19 engine: swinging in a drum of {facets} facets, largest distance from the swing in a cylinder, in radii"),
            0.0,
            // The ball's centre runs along a polygon that is inside its circle by up to the sagitta of the facets, and turns
            // by 2 pi/n where they meet.
            Absolute(SWING / f64::from(facets)),
            ANALYTIC,
            move || swing(facets),
        ));
    }
    cases
}

fn mesh_wall(triangles: &TriangleMesh) -> mercury_engine::walls::Wall {
    let mesh = Mesh::new(triangles, |x| x, false).expect("triangles with areas");
    wall(Shape::Mesh(Arc::new(mesh)), Motion::default())
}

/// A square of 40 mm normal to z, cut up irregularly, some triangles as thin as a hundredth.
fn irregular_square() -> TriangleMesh {
    const CELLS: u32 = 30;
    let mut random = Stream::new(3, "irregular square", 0);
    let mut mesh = TriangleMesh::default();
    for j in 0..=CELLS {
        for i in 0..=CELLS {
            let mut jitter = || 0.49 * (2.0 * random.uniform() - 1.0);
            let place = dvec3(f64::from(i) + jitter(), f64::from(j) + jitter(), 0.0);
            mesh.vertices
                .push((place / f64::from(CELLS) - 0.5) * 0.04 * dvec3(1.0, 1.0, 0.0));
        }
    }
    for j in 0..CELLS {
        for i in 0..CELLS {
            let a = j * (CELLS + 1) + i;
            let [b, c, d] = [a + 1, a + CELLS + 2, a + CELLS + 1];
            let at = |k: u32| mesh.vertices[k as usize];
            let area = |p, q, r| (at(q) - at(p)).cross(at(r) - at(p)).z;
            // The diagonal that leaves no triangle turned over.
            if area(a, b, c) > 0.0 && area(a, c, d) > 0.0 {
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            } else {
                mesh.triangles.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    mesh
}

/// Written as binary STL, where coordinates have single precision, and read back.
fn through_stl(mesh: TriangleMesh) -> TriangleMesh {
    let mut bytes = Vec::new();
    push_binary_stl(&mesh, &mut bytes).expect("coordinates within single precision");
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    let path = folder.path().join("square.stl");
    std::fs::write(&path, bytes).expect("a writable folder for temporary files");
    read_mesh(&path).expect("what was just written")
}

/// A ball pressed into a plane of any direction by gravity, sliding, rolling and spinning; the largest difference between the
/// forces from the mesh and from the plane, over the force.
fn over_a_plane(prepare: impl Fn(TriangleMesh) -> TriangleMesh) -> f64 {
    let turn = DQuat::from_scaled_axis(dvec3(0.7, -0.4, 1.1));
    let mut mesh = irregular_square();
    for vertex in &mut mesh.vertices {
        *vertex = turn * *vertex;
    }
    let mesh = prepare(mesh);
    let (modulus, step) = (1e5, 1e-5);
    let begin = |wall| {
        let law = PairLaw {
            normal: AnyNormal::Hertz(Hertz::new(modulus, 0.1)),
            tangential: AnyTangential::Mindlin(Mindlin::new(0.3 * modulus, 1.0, 0.1, 0.3, 0.35)),
            rolling: AnyRolling::None,
            adhesion: AnyAdhesion::None,
        };
        let mut plan = plan(step, 2500.0, law);
        plan.gravity = turn * dvec3(0.0, 0.0, -9.81);
        let weight = 2500.0 * volume(RADIUS, 3) * 9.81;
        let overlap = (0.75 * weight / (modulus * RADIUS.sqrt())).powf(2.0 / 3.0);
        plan.walls.push(wall);
        start(plan.with_particles(vec![sphere(
            turn * dvec3(-0.007, -0.004, RADIUS - overlap),
            RADIUS,
            turn * dvec3(0.6, 0.25, 0.0),
            turn * dvec3(0.0, 30.0, 50.0),
        )]))
    };
    let plane = Plane::new(DVec3::ZERO, turn * DVec3::Z).expect("a direction");
    let mut flat = begin(wall(Shape::Plane(plane), Motion::default()));
    let mut tessellated = begin(mesh_wall(&mesh));
    let force = |engine: &Engine| engine.particles.loads[row(engine, 0)].force;
    let mut largest = 0.0f64;
    for _ in 0..2000 {
        advance(&mut flat, 1);
        advance(&mut tessellated, 1);
        let expected = force(&flat);
        largest = largest.max((force(&tessellated) - expected).length() / expected.length());
    }
    // It has rolled on over dozens of triangles, if this is to mean anything.
    let travelled = (particle(&flat, 0).position - turn * dvec3(-0.007, -0.004, RADIUS)).length();
    if travelled > 2.0 * RADIUS {
        largest
    } else {
        f64::NAN
    }
}

/// The eight corners and twelve triangles of a box with half edges `half` (m), turned about its middle.
fn add_box(mesh: &mut TriangleMesh, half: f64, turn: DQuat) {
    let first = mesh.vertices.len() as u32;
    for k in 0..8 {
        let corner = dvec3(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2));
        mesh.vertices.push(turn * ((2.0 * corner - 1.0) * half));
    }
    for [a, b, c, d] in [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ] {
        let triangles = [[a, b, c], [a, c, d]];
        mesh.triangles
            .extend(triangles.map(|t: [u32; 3]| t.map(|k| first + k)));
    }
}

/// Kinetic energy of a ball that bounces about, at the end, in flight, over that at the start.
fn energy_in_a_box() -> f64 {
    let mut mesh = TriangleMesh::default();
    add_box(
        &mut mesh,
        0.06,
        DQuat::from_scaled_axis(dvec3(0.2, 0.5, -0.3)),
    );
    add_box(&mut mesh, 0.02, DQuat::from_rotation_z(FRAC_PI_4));
    let (radius, contact_time) = (0.01, 5e-3);
    let mass = 2500.0 * volume(radius, 3);
    let stiffness = mass * (std::f64::consts::PI / contact_time).powi(2);
    let law = frictionless(AnyNormal::Linear(Linear::new(stiffness, 0.0)));
    let mut plan = plan(1e-3 * contact_time, 2500.0, law);
    plan.walls.push(mesh_wall(&mesh));
    let velocity = dvec3(0.9, 0.53, 0.35);
    let place = dvec3(-0.04, 0.01, 0.005);
    let mut engine = start(plan.with_particles(vec![sphere(place, radius, velocity, DVec3::ZERO)]));
    let in_contact = |engine: &Engine| engine.particles.loads[0].force != DVec3::ZERO;
    let (mut impacts, mut touching) = (0, false);
    while impacts < 40 || touching {
        advance(&mut engine, 1);
        let now = in_contact(&engine);
        impacts += u32::from(touching && !now);
        touching = now;
        if engine.time() > 20.0 {
            return f64::NAN;
        }
    }
    particle(&engine, 0).velocity.length_squared() / velocity.length_squared()
}

/// Times the number of facets, the distance that is allowed.
const SWING: f64 = 12.0;

/// Largest distance (in radii) between a ball that swings in a drum of flat facets and one in a cylinder, over one swing.
fn swing(facets: u32) -> f64 {
    let drum = 0.05;
    let mut mesh = TriangleMesh::default();
    for k in 0..facets {
        let angle = TAU * f64::from(k) / f64::from(facets);
        for y in [-0.02, 0.02] {
            mesh.vertices
                .push(dvec3(angle.cos() * drum, y, angle.sin() * drum));
        }
        let [a, b, c, d] = [2 * k, 2 * k + 1, 2 * k + 2, 2 * k + 3].map(|i| i % (2 * facets));
        mesh.triangles.extend([[a, b, c], [b, d, c]]);
    }
    let cylinder = Cylinder::new(DVec3::Y, DVec3::ZERO, drum, None, Side::Inside)
        .expect("a cylinder with an axis and a radius");
    let begin = |wall| {
        let law = PairLaw {
            normal: AnyNormal::Hertz(Hertz::new(1e6, 0.2)),
            tangential: AnyTangential::Mindlin(Mindlin::new(3e5, 1.0, 0.2, 0.5, 0.5)),
            rolling: AnyRolling::None,
            adhesion: AnyAdhesion::None,
        };
        let mut plan = plan(1e-5, 2500.0, law);
        plan.gravity = -9.81 * DVec3::Z;
        plan.walls.push(wall);
        let angle = 40f64.to_radians();
        let place = (drum - RADIUS) * dvec3(angle.sin(), 0.0, -angle.cos());
        start(plan.with_particles(vec![sphere(place, RADIUS, DVec3::ZERO, DVec3::ZERO)]))
    };
    let mut round = begin(wall(Shape::Cylinder(cylinder), Motion::default()));
    let mut faceted = begin(mesh_wall(&mesh));
    let mut largest = 0.0f64;
    for _ in 0..250 {
        advance(&mut round, 100);
        advance(&mut faceted, 100);
        let [a, b] = [&round, &faceted].map(|engine| particle(engine, 0).position);
        largest = largest.max(a.distance(b));
    }
    largest / RADIUS
}
