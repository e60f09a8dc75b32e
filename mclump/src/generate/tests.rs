mod closed_forms;
mod difficult;
mod promises;
mod shipped;

use super::*;

/// A request for n pebbles.
fn pebbles(method: Method, n: usize) -> Request {
    Request {
        method,
        stop: Stop {
            pebbles: Some(n),
            volume_error: None,
        },
        ..Request::default()
    }
}

fn run(mesh: &TriangleMesh, request: &Request) -> Result<Vec<Pebble>, GenerateError> {
    generate(mesh, request, &mut |_, _| {})
}

fn euclidean() -> Method {
    Method::Euclidean(Euclidean::default())
}

/// Few points: tests run without optimisation.
fn tangent() -> Method {
    Method::Tangent(Tangent {
        surface_points: 1_000,
        volume_points: 20_000,
    })
}

/// Radius less the distance to the surface by brute force over all triangles and the winding number; positive for balls that
/// stand out. In m.
fn protrusion(mesh: &TriangleMesh, pebble: &Pebble) -> f64 {
    let body = Body::new(mesh).unwrap();
    let ball = body.to_body(pebble);
    let inside = body.winding_number(ball.position) > 0.5;
    let distance = body
        .faces
        .iter()
        .map(|face| distance_to_triangle(ball.position, face.corners))
        .fold(f64::INFINITY, f64::min);
    (ball.radius - if inside { distance } else { -distance }) * body.unit
}

/// Distance of a point to a triangle: its plane if the foot is inside, else the nearest edge.
fn distance_to_triangle(p: glam::DVec3, [a, b, c]: [glam::DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let inside = [(a, b), (b, c), (c, a)]
        .iter()
        .all(|(from, to)| (*to - *from).cross(p - *from).dot(normal) >= 0.0);
    if inside {
        return ((p - a).dot(normal) / normal.length()).abs();
    }
    [(a, b), (b, c), (c, a)]
        .iter()
        .map(|&(from, to)| {
            let edge = to - from;
            let along = ((p - from).dot(edge) / edge.length_squared()).clamp(0.0, 1.0);
            p.distance(from + along * edge)
        })
        .fold(f64::INFINITY, f64::min)
}
