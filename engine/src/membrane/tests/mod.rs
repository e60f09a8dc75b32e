//! Comparison with the theory of sheets at rest: `docs/theory/membranes.md`.

mod balloon;
mod bending;
mod borders;
mod mesh;
mod step;
mod strain;

use glam::DVec3;
use mercury_common::formats::mesh::TriangleMesh;

use super::{Bending, Elasticity, Evaluation, Law, Powers, Sheet, Topology, Workspace};
use crate::lanes::Width;

/// E t = 1 N/m with a thickness of 1 mm; limp, without losses.
pub(super) fn law(elasticity: Elasticity) -> Law {
    Law {
        thickness: 1e-3,
        youngs_modulus: 1e3,
        density: 1000.0,
        elasticity,
        damping_ratio: 0.0,
        drag: 0.0,
        bending: None,
    }
}

pub(super) fn plate(law: Law) -> Law {
    Law {
        bending: Some(Bending {
            stiffness: law.plate_stiffness(),
            damping: 0.0,
            rests_flat: true,
        }),
        ..law
    }
}

pub(super) fn sheet(mesh: &TriangleMesh, law: Law) -> Sheet {
    let topology = Topology::new(mesh.vertices.len(), &mesh.triangles).unwrap();
    let rest: Vec<[DVec3; 3]> = (0..mesh.triangles.len()).map(|k| mesh.corners(k)).collect();
    Sheet::new(topology, &rest, 0.0, law).unwrap()
}

/// Forces on the vertices, and what dashpots lose.
pub(super) fn forces_of(
    sheet: &Sheet,
    positions: &[DVec3],
    velocities: &[DVec3],
    pressure: f64,
) -> (Vec<DVec3>, Powers) {
    let inverse_masses: Vec<f64> = sheet.masses().iter().map(|mass| 1.0 / mass).collect();
    let dashpots = sheet.dashpots(&inverse_masses);
    let mut forces = vec![DVec3::ZERO; positions.len()];
    let at = Evaluation {
        positions,
        velocities,
        dashpots: &dashpots,
        pressure,
        is_parallel: false,
        width: Width::fastest(),
    };
    let powers = sheet.forces(&at, &mut Workspace::default(), &[], &mut forces);
    (forces, powers)
}

/// Equilateral triangles with edges of 1 m throughout: a parallelogram of `columns` x `rows` cells.
pub(super) fn lattice(columns: u32, rows: u32) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for row in 0..=rows {
        for column in 0..=columns {
            let x = f64::from(column) + 0.5 * f64::from(row);
            let y = f64::from(row) * 0.75_f64.sqrt();
            mesh.vertices.push(DVec3::new(x, y, 0.0));
        }
    }
    let at = |column: u32, row: u32| row * (columns + 1) + column;
    for row in 0..rows {
        for column in 0..columns {
            let (a, b) = (at(column, row), at(column + 1, row));
            let (c, d) = (at(column, row + 1), at(column + 1, row + 1));
            mesh.triangles.push([a, b, c]);
            mesh.triangles.push([b, d, c]);
        }
    }
    mesh
}

/// A number in [-1, 1) that looks random.
pub(super) fn noise(seed: &mut u64) -> f64 {
    *seed = seed
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

pub(super) fn noisy(positions: &[DVec3], size: f64, seed: &mut u64) -> Vec<DVec3> {
    let moved = |&x: &DVec3| x + size * DVec3::new(noise(seed), noise(seed), noise(seed));
    positions.iter().map(moved).collect()
}
