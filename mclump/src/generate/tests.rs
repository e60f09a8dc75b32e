use super::shapes::*;
use super::*;
use glam::DVec3;

fn run(mesh: &TriangleMesh, method: Method, n: usize) -> Vec<Pebble> {
    let request = Request {
        method,
        stop: Stop {
            pebbles: Some(n),
            volume_error: None,
        },
        ..Request::default()
    };
    generate(mesh, &request, &mut |_, _| {}).unwrap()
}

#[test]
fn try_out() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../shared/data/shapes/mesh/Rattleback.stl"
    );
    let shared = mercury_common::formats::mesh::read_mesh(path).unwrap();
    for (name, mesh) in [
        ("cube", cuboid(DVec3::splat(2.0), DVec3::splat(3.0))),
        (
            "plate",
            cuboid(DVec3::splat(2.0), DVec3::new(3.0, 3.0, 2.05)),
        ),
        ("octahedron", octahedron()),
        ("ellipsoid", spheroid(2.0, 1.0, 60, 60)),
        ("torus", torus(2.0, 0.5, 80, 40)),
        ("rattleback", shared),
    ] {
        let body = Body::new(&mesh).unwrap();
        for (what, method) in [
            ("euclid", Method::Euclidean(Euclidean::default())),
            ("tangent", Method::Tangent(Tangent::default())),
            ("favier", Method::Favier(Favier::default())),
        ] {
            for n in [1, 10, 100, 500] {
                let t = std::time::Instant::now();
                let request = Request {
                    method: method.clone(),
                    stop: Stop {
                        pebbles: Some(n),
                        volume_error: None,
                    },
                    ..Request::default()
                };
                match generate(&mesh, &request, &mut |_, _| {}) {
                    Ok(p) => {
                        let e = union_volume(&p) / (body.volume * body.unit.powi(3)) - 1.0;
                        println!(
                            "{name} {what} {n}: {} r {} .. {} volume {e:.5} {:.2} s",
                            p.len(),
                            p[0].radius,
                            p[p.len() - 1].radius,
                            t.elapsed().as_secs_f64()
                        );
                    }
                    Err(e) => println!("{name} {what} {n}: {e}"),
                }
            }
        }
    }
}
