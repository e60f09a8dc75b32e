//! Against a clump that MercuryDPM ships.

use glam::DVec3;
use mercury_common::formats::mesh::read_mesh;
use mercury_common::reference_data::shared;

use super::*;

#[test]
fn the_rattleback_is_closer_to_its_surface_than_the_shipped_clump() {
    let Some(folder) = shared("data/shapes") else {
        return;
    };
    let mesh = read_mesh(folder.join("mesh/Rattleback.stl")).unwrap();
    let text = std::fs::read_to_string(folder.join("pebbles/rattleback_500_input.csv")).unwrap();
    let shipped: Vec<Pebble> = text
        .lines()
        .filter_map(|line| {
            let numbers: Vec<f64> = line
                .split(',')
                .map_while(|cell| cell.trim().parse().ok())
                .collect();
            let &[x, y, z, radius] = numbers.as_slice() else {
                return None;
            };
            Some(Pebble {
                position: DVec3::new(x, y, z),
                radius,
            })
        })
        .collect();
    assert_eq!(shipped.len(), 500);
    let body = Body::new(&mesh).unwrap();
    let error = |pebbles: &[Pebble]| {
        let balls: Vec<Pebble> = pebbles.iter().map(|p| body.to_body(p)).collect();
        volume_error(&body, &balls)
    };
    let protrusion = shipped
        .iter()
        .map(|p| body.to_body(p))
        .map(|p| (p.radius - body.nearest(p.position).depth) * body.unit)
        .fold(0.0, f64::max);
    // Of the shipped clump single pebbles stand out by 0.44 mm and the union is 5.0 % lighter than the body.
    assert!((protrusion - 0.444).abs() < 1e-3 && (error(&shipped) + 0.0504).abs() < 2e-4);
    // A third of that is enough to be ten times closer.
    let third = Request {
        protrusion: 0.15,
        ..pebbles(
            Method::Tangent(Tangent {
                surface_points: 3_000,
                volume_points: 50_000,
            }),
            500,
        )
    };
    let found = run(&mesh, &third).unwrap();
    assert!(found.len() <= 500);
    assert!(error(&found).abs() < 0.1 * 0.0504, "{}", error(&found));
}
