//! A sphere in a funnel of many flat sides touches them all.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DVec3, dvec3};
use mercury_common::formats::mesh::TriangleMesh;

use super::{frictionless, trampoline};
use mercury_engine::forces::Watch;
use mercury_engine::state::{MaterialIndex, volume};
use mercury_engine::step::Engine;
use mercury_engine::walls::{Mesh, Motion, Shape};

/// It hangs in equilibrium by the theory: of n forces k d along normals that rise with the sine of the half angle b, the sum is n k d sin b = m g.
#[test]
fn a_sphere_hangs_on_all_sides_of_a_funnel() {
    let (radius, half_angle, g) = (0.01, PI / 6.0, 9.81);
    let stiffness = match frictionless().normal {
        mercury_engine::contact::AnyNormal::Linear(law) => law.stiffness,
        _ => panic!("it is linear"),
    };
    // 24 sides: their normals differ by 13 degrees, more than what is smooth.
    for sides in [3u32, 8, 9, 10, 12, 24] {
        let mut funnel = TriangleMesh {
            vertices: vec![DVec3::ZERO],
            ..TriangleMesh::default()
        };
        // The middles of the sides are at the half angle.
        let ring = 0.1 * half_angle.tan() / (PI / f64::from(sides)).cos();
        for k in 0..sides {
            let (sin, cos) = (2.0 * PI * f64::from(k) / f64::from(sides)).sin_cos();
            funnel.vertices.push(dvec3(ring * cos, ring * sin, 0.1));
            funnel.triangles.push([0, 1 + k, 1 + (k + 1) % sides]);
        }
        let mass = 1000.0 * volume(radius, 3);
        let overlap = mass * g / (f64::from(sides) * stiffness * half_angle.sin());
        let mut draft = trampoline(Motion::new(Vec::new()).unwrap());
        draft.walls[0].shape = Shape::Mesh(Arc::new(Mesh::new(&funnel, |x| x, false).unwrap()));
        draft.gravity = -g * DVec3::Z;
        draft.particles.truncate(1);
        draft.particles[0].position = (radius - overlap) / half_angle.sin() * DVec3::Z;
        assert_eq!(draft.particles[0].material, MaterialIndex::new(0));
        let mut engine = Engine::new(Arc::new(draft.plan().unwrap()), 1).unwrap();
        engine.step(Some(Watch::default())).unwrap();
        assert_eq!(engine.observation().wall_contacts, u64::from(sides));
        engine.steps_at_once(1000, None).unwrap();
        engine.complete_step().unwrap();
        let (load, record) = (engine.particles.loads[0], engine.particles.records[0]);
        // Round-off of 1e-18 m beside the overlap.
        let expected = mass * g * DVec3::Z;
        let off = load.force.distance(expected) / (mass * g);
        assert!(
            off < 1e-9,
            "{sides} sides: {} N, not {expected}",
            load.force
        );
        assert!(record.velocity.length() < 1e-9, "{}", record.velocity);
    }
}
