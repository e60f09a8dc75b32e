//! Topology and built-in meshes.

use glam::DVec3;
use proptest::prelude::*;

use super::super::{Topology, TopologyError, cylinder, disc, rectangle, sphere};
use super::*;

fn build(mesh: &TriangleMesh) -> Topology {
    let corners: Vec<_> = (0..mesh.triangles.len()).map(|k| mesh.corners(k)).collect();
    Topology::check_areas(&corners).unwrap();
    Topology::new(mesh.vertices.len(), &mesh.triangles).unwrap()
}

/// Vertices - edges + triangles.
fn euler(topology: &Topology) -> i64 {
    topology.vertices() as i64 - topology.edges().len() as i64 + topology.triangles().len() as i64
}

#[test]
fn offences_are_named_by_their_triangle() {
    let of = |vertices, triangles: &[[u32; 3]]| Topology::new(vertices, triangles).unwrap_err();
    let third = of(5, &[[0, 1, 2], [1, 0, 3], [0, 1, 4]]);
    assert!(matches!(
        third,
        TopologyError::ThirdTriangle {
            triangle: 2,
            ends: [0, 1],
            ..
        }
    ));
    let turned = of(4, &[[0, 1, 2], [0, 1, 3]]);
    assert!(matches!(
        turned,
        TopologyError::Turned {
            triangle: 1,
            neighbour: 0,
            ..
        }
    ));
    assert!(matches!(
        of(3, &[[0, 1, 1]]),
        TopologyError::Corners { triangle: 0, .. }
    ));
    assert!(matches!(of(3, &[[0, 1, 3]]), TopologyError::Corners { .. }));
    assert!(matches!(
        of(4, &[[0, 1, 2]]),
        TopologyError::Lonely { vertex: 3 }
    ));
    assert!(matches!(of(0, &[]), TopologyError::Empty));
    let flat = [[DVec3::ZERO, DVec3::X, 2.0 * DVec3::X]];
    assert_eq!(
        Topology::check_areas(&flat),
        Err(TopologyError::NoArea { triangle: 0 })
    );
    let lost = [[DVec3::ZERO, DVec3::X, DVec3::NAN]];
    assert!(Topology::check_areas(&lost).is_err());
}

/// Two rims that meet at a vertex are walked apart, each along its own triangles.
#[test]
fn rims_at_a_common_vertex() {
    let topology = Topology::new(5, &[[0, 1, 2], [0, 3, 4]]).unwrap();
    assert_eq!(topology.rims(), [vec![0, 1, 2], vec![0, 3, 4]]);
    // A ring of triangles: one rim outside, one inside.
    let ring = Topology::new(
        6,
        &[
            [0, 3, 4],
            [0, 4, 1],
            [1, 4, 5],
            [1, 5, 2],
            [2, 5, 3],
            [2, 3, 0],
        ],
    )
    .unwrap();
    let mut lengths: Vec<usize> = ring.rims().iter().map(Vec::len).collect();
    lengths.sort_unstable();
    assert_eq!(lengths, [3, 3]);
}

proptest! {
    #[test]
    fn built_in_meshes_are_sheets(edge in 0.02..0.5_f64, a in 0.3..1.5_f64, b in 0.3..1.5_f64) {
        let axis = DVec3::new(1.0, 2.0, -0.5).normalize();
        let (one, other) = axis.any_orthonormal_pair();
        let corner = DVec3::new(0.1, 0.2, 0.3);
        let flat = rectangle(corner, one * a, other * b, edge);
        let topology = build(&flat);
        prop_assert_eq!(euler(&topology), 1);
        prop_assert_eq!(topology.rims().len(), 1);
        let whole = sheet(&flat, law(Elasticity::Springs));
        prop_assert!((whole.rest_area() - a * b).abs() < 1e-12);
        let round = disc(axis, corner, a, edge);
        let topology = build(&round);
        prop_assert_eq!(euler(&topology), 1);
        prop_assert_eq!(topology.rims().len(), 1);
        let tube = cylinder(axis, corner, a, [-b, b], edge);
        let topology = build(&tube);
        prop_assert_eq!(euler(&topology), 0);
        prop_assert_eq!(topology.rims().len(), 2);
        let ball = sphere(corner, a, edge);
        let topology = build(&ball);
        prop_assert_eq!(euler(&topology), 2);
        prop_assert_eq!(topology.rims().len(), 0);
        for (mesh, centre) in [(&ball, true), (&tube, false), (&flat, false), (&round, false)] {
            for k in 0..mesh.triangles.len() {
                let [x, y, z] = mesh.corners(k);
                let normal = (y - x).cross(z - x);
                let mean = (x + y + z) / 3.0 - corner;
                let outwards = if centre {
                    mean
                } else if std::ptr::eq(mesh, &raw const tube) {
                    mean - axis * mean.dot(axis)
                } else {
                    axis
                };
                prop_assert!(normal.dot(outwards) > 0.0);
            }
        }
    }

    /// Edges of large meshes are near the wanted length.
    #[test]
    fn edges_are_near_the_wanted_length(edge in 0.02..0.1_f64) {
        let meshes = [
            disc(DVec3::Z, DVec3::ZERO, 1.0, edge),
            cylinder(DVec3::Z, DVec3::ZERO, 1.0, [0.0, 1.0], edge),
            sphere(DVec3::ZERO, 1.0, edge),
        ];
        for mesh in meshes {
            let sheet = sheet(&mesh, law(Elasticity::Springs));
            let count = sheet.topology().edges().len() as f64;
            let mean = sheet.rest_lengths().sum::<f64>() / count;
            // A disc is farthest from equilateral: along a ring its edges have pi/3 of the distance of rings, between rings
            // sqrt(1 + (t pi/3)^2) of it with t evenly from 0 to 1, 1.12 in the mean. The number of rings, 10 or more, is rounded to
            // a whole one, which changes their distance by 5 % at most.
            prop_assert!((0.9..1.18).contains(&(mean / edge)), "{mean} {edge}");
            let within = sheet.rest_lengths().all(|length| length > 0.7 * edge && length < 1.53 * edge);
            prop_assert!(within);
        }
    }
}
