//! A one-sided wall holds particles that come from its front, and does not accelerate those that come from behind.

use std::sync::Arc;

use glam::{DVec3, dvec3};
use mercury_common::formats::mesh::TriangleMesh;

use super::trampoline;
use mercury_engine::step::{Engine, Snapshot};
use mercury_engine::walls::{Cylinder, Mesh, Motion, Revolution, Shape, Side, SphereShell};

const RADIUS: f64 = 0.01;

/// One ball at `place` (m) with `velocity` (m/s) and one wall; it bounces without loss.
fn ball_and_wall(shape: Shape, place: DVec3, velocity: DVec3) -> Engine {
    let mut draft = trampoline(Motion::new(Vec::new()).unwrap());
    draft.walls[0].shape = shape;
    draft.gravity = DVec3::ZERO;
    draft.particles.truncate(1);
    draft.particles[0].position = place;
    draft.particles[0].velocity = velocity;
    Engine::new(Arc::new(draft.plan().unwrap()), 1).unwrap()
}

/// The velocity (m/s) after 0.1 s; in the middle of it the run is saved and gone on with.
fn after(mut engine: Engine) -> DVec3 {
    for _ in 0..50 {
        engine.steps_at_once(100, None).unwrap();
        let saved = Snapshot::decode(&engine.snapshot().encode()).unwrap();
        engine = Engine::restore(engine.setup(), saved, 1).unwrap();
    }
    engine.complete_step().unwrap();
    engine.particles.records[0].velocity
}

/// A square of triangles in the plane x = 0.05 whose front is towards -x.
fn sheet() -> Mesh {
    let at = |y: f64, z: f64| dvec3(0.05, y, z);
    let mesh = TriangleMesh {
        vertices: vec![at(-0.1, -0.1), at(-0.1, 0.1), at(0.1, 0.1), at(0.1, -0.1)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..TriangleMesh::default()
    };
    Mesh::new(&mesh, |x| x, true).unwrap()
}

/// Surfaces through (0.05, 0, 0) that hold what is at smaller x.
fn shapes() -> Vec<Shape> {
    let (origin, inside) = (DVec3::ZERO, Side::Inside);
    let along = Some([-0.1, 0.1]);
    let profile = [[0.05, -0.1], [0.05, 0.1]];
    vec![
        Shape::Cylinder(Cylinder::new(DVec3::Z, origin, 0.05, None, inside).unwrap()),
        Shape::Cylinder(Cylinder::new(DVec3::Z, origin, 0.05, along, inside).unwrap()),
        Shape::Sphere(SphereShell::new(origin, 0.05, inside).unwrap()),
        Shape::Revolution(Revolution::new(DVec3::Z, origin, &profile, inside).unwrap()),
        Shape::Mesh(Arc::new(sheet())),
    ]
}

/// Before, it left at many times its speed: with the energy of an overlap of almost a diameter.
#[test]
fn from_behind_a_ball_bounces_off_the_back() {
    for shape in shapes() {
        let engine = ball_and_wall(shape.clone(), 0.08 * DVec3::X, -DVec3::X);
        let velocity = after(engine);
        // A collision in steps of (omega dt)^2/8 = 1e-5 of it, and the ends of it within a step: 1e-3.
        let off = velocity.distance(DVec3::X);
        assert!(off < 2e-3, "{shape:?}: {velocity}");
    }
}

/// The stiffness of 1000 N/m stops 4.2 g at 6 m/s within v/omega = 12 mm: the centre goes through, and comes back.
#[test]
fn from_the_front_a_ball_that_goes_through_is_pushed_back() {
    for shape in shapes() {
        let mut engine = ball_and_wall(shape.clone(), 0.035 * DVec3::X, 6.0 * DVec3::X);
        let mut farthest = 0.0f64;
        for _ in 0..500 {
            engine.step(None).unwrap();
            farthest = farthest.max(engine.particles.records[0].position.x);
        }
        assert!(farthest > 0.051 && farthest < 0.05 + RADIUS, "{farthest}");
        engine.complete_step().unwrap();
        let velocity = engine.particles.records[0].velocity;
        assert!(
            velocity.distance(-6.0 * DVec3::X) < 0.02,
            "{shape:?}: {velocity}"
        );
    }
}
