//! Space behind a one-sided wall is solid to an insertion.

use std::sync::Arc;

use glam::{DVec2, DVec3, dvec3};
use mercury_common::formats::mesh::TriangleMesh;

use super::super::{InsertionPlan, Quantity, Rate, Total};
use super::inserting::{Still, wall};
use super::{insertion, monodisperse, plan, unit_box};
use crate::step::Engine;
use crate::walls::{Component, Cone, Cylinder, Disc, Mesh, Motion, Shape, Side, SphereShell, Wall};

const RADIUS: f64 = 0.02;
const MIDDLE: DVec3 = DVec3::splat(0.5);

/// A closed box of triangles about the middle, seen from outside.
fn block() -> Mesh {
    let mut mesh = TriangleMesh::default();
    for k in 0..8 {
        let sign = |bit: u32| if k & bit == 0 { -0.25 } else { 0.25 };
        mesh.vertices
            .push(MIDDLE + dvec3(sign(1), sign(2), sign(4)));
    }
    for [a, b, c, d] in [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ] {
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
    Mesh::new(&mesh, |x| x, true).unwrap()
}

/// How far a centre is in front of a wall, m, by its geometry; negative behind.
type InFront = fn(DVec3) -> f64;

fn across(x: DVec3) -> f64 {
    (x - MIDDLE).truncate().length()
}

/// In front of a cylinder that ends at z = 0.2 and 0.8: beyond these its rims block no particle.
fn in_front_of_shell(x: DVec3) -> f64 {
    let beyond = (0.2 - x.z).max(x.z - 0.8);
    if beyond > 0.0 {
        DVec2::new(across(x) - 0.3, beyond).length()
    } else {
        0.3 - across(x)
    }
}

/// In front of a cone from a tip at z = 0.1 to a rim of radius 0.4 at z = 0.9.
fn in_front_of_cone(x: DVec3) -> f64 {
    let place = DVec2::new(across(x), x.z - 0.1);
    let (slope, rim) = (DVec2::new(0.4, 0.8).normalize(), DVec2::new(0.4, 0.8));
    if place.dot(slope) > rim.length() {
        place.distance(rim)
    } else {
        slope.perp_dot(place)
    }
}

#[test]
fn nothing_is_inserted_behind_a_wall() {
    let cylinder = |along, side| {
        let shape = Cylinder::new(DVec3::Z, MIDDLE, 0.3, along, side).unwrap();
        Shape::Cylinder(shape)
    };
    let sphere = |side| Shape::Sphere(SphereShell::new(MIDDLE, 0.4, side).unwrap());
    let tip = dvec3(0.5, 0.5, 0.1);
    let cone = Cone::new(DVec3::Z, tip, [0.0, 0.8], [0.0, 0.4], Side::Inside).unwrap();
    let walls: [(&str, Shape, InFront); 7] = [
        ("cylinder", cylinder(None, Side::Inside), |x| {
            0.3 - across(x)
        }),
        ("post", cylinder(None, Side::Outside), |x| across(x) - 0.3),
        (
            "shell",
            cylinder(Some([-0.3, 0.3]), Side::Inside),
            in_front_of_shell,
        ),
        ("sphere", sphere(Side::Inside), |x| 0.4 - x.distance(MIDDLE)),
        ("ball", sphere(Side::Outside), |x| x.distance(MIDDLE) - 0.4),
        ("cone", Shape::Cone(cone), in_front_of_cone),
        ("mesh", Shape::Mesh(Arc::new(block())), |x| {
            let outside = (x - MIDDLE).abs() - 0.25;
            if outside.max_element() > 0.0 {
                outside.max(DVec3::ZERO).length()
            } else {
                outside.max_element()
            }
        }),
    ];
    for (name, shape, in_front) in walls {
        // The rim of a cone's image is nearer than the cone in places that are behind it.
        let periodic_too = name != "cone";
        for periodic in [false, true]
            .into_iter()
            .take(1 + usize::from(periodic_too))
        {
            let mut draft = plan();
            draft.cell = draft.cell.with_periodic([periodic; 3]);
            draft.walls.push(wall(shape.clone()));
            let sizes = monodisperse(2.0 * RADIUS);
            draft
                .insertions
                .push(insertion(unit_box(), sizes, Total::Number(300)));
            let mut still = Still::new(draft);
            for step in 0..20 {
                still.exchange(1e-3 * f64::from(step));
            }
            assert_eq!(still.particles.len(), 300, "{name}");
            for record in &still.particles.records {
                let free = in_front(record.position);
                assert!(
                    free >= RADIUS * (1.0 - 1e-9),
                    "{name}: {}: {free}",
                    record.position
                );
            }
        }
    }
}

/// A disc that comes down through a region acts on both sides: what is placed above it is counted, however far it has come.
#[test]
fn what_is_placed_behind_a_closing_wall_is_counted() {
    let mut draft = plan();
    let disc = Disc::new(DVec3::Z, dvec3(0.5, 0.5, 1.2), 0.8).unwrap();
    let down = Component::Translation {
        velocity: dvec3(0.0, 0.0, -1.0),
        from: 0.0,
        until: 0.7,
    };
    draft.walls.push(Wall {
        motion: Motion::new(vec![down]).unwrap(),
        ..wall(Shape::Disc(disc))
    });
    // All come slowly enough that each is placed at its time.
    draft.insertions.push(InsertionPlan {
        rate: Some(Rate::Steady {
            quantity: Quantity::Number,
            per_second: 400.0,
        }),
        closing: vec![0],
        ..insertion(unit_box(), monodisperse(2.0 * RADIUS), Total::Number(400))
    });
    let mut engine = Engine::new(draft.setup().unwrap(), 1).unwrap();
    let mut behind = 0;
    for _ in 0..1000 {
        let known = engine.particles.grains_created();
        engine.step(None).unwrap();
        let height = 1.2 - engine.time().min(0.7);
        let new = (engine.particles.ids.iter()).zip(&engine.particles.records);
        let new = new.filter(|(id, _)| u64::from(id.number()) >= known);
        behind += new.filter(|(_, record)| record.position.z > height).count();
    }
    let state = &engine.boundaries().state().insertions[0];
    assert_eq!(state.inserted.number, 400);
    assert!(behind > 100, "{behind}");
    assert_eq!(state.behind, [behind as u64]);
}
