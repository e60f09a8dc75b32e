//! No scene breaks the picture.

use proptest::prelude::*;

use super::*;
use crate::{Background, ColourBy, Contact, Line, Projection, Surface};

fn strange(k: usize) -> f64 {
    [
        f64::NAN,
        f64::INFINITY,
        -f64::INFINITY,
        0.0,
        -0.0,
        1e300,
        -1e300,
        1e-300,
        f64::MIN_POSITIVE,
        1.0,
        -1.0,
        f64::MAX,
    ][k % 12]
}

#[test]
fn strange_numbers_everywhere() {
    for k in 0..24 {
        let at = |n: usize| DVec3::new(strange(n), strange(n / 3 + k), strange(n / 5));
        let mut scene = frame(
            (0..60)
                .map(|n| Sphere {
                    centre: at(n),
                    radius: strange(n / 2 + k),
                    value: strange(n),
                    fixed: n % 7 == 0,
                })
                .collect(),
        );
        scene.title = "\u{0}\u{7}]]> strange\u{fffe}".into();
        scene.time = Some(strange(k));
        scene.gravity = at(k);
        scene.flat = k % 3 == 0;
        scene.domain = Some((at(k), at(k + 1)));
        scene.surfaces.push(Surface {
            opacity: strange(k),
            ..Surface::wall((0..30).map(|n| [at(n), at(n + 1), at(n + 2)]).collect())
        });
        scene.lines.push(Line {
            width: strange(k),
            ..Line::wall((0..30).map(at).collect())
        });
        scene.contacts = (0..30)
            .map(|n| Contact {
                from: at(n),
                to: at(n + 5),
                strength: strange(n),
            })
            .collect();
        let options = Options {
            width: 120,
            height: 90,
            background: [Background::Light, Background::Dark, Background::Transparent][k % 3],
            projection: if k % 2 == 0 {
                Projection::Orthographic
            } else {
                Projection::Perspective {
                    field_of_view: 50.0,
                }
            },
            colour: ColourBy::scalar("strange", "N"),
            target: (k % 5 == 0).then(|| at(k)),
            sphere_opacity: if k % 4 == 0 { 0.5 } else { 1.0 },
            ..Options::default()
        };
        draw(&scene, &options);
        let svg = svg(&scene, &options);
        assert!(roxmltree::Document::parse(&svg).is_ok());
        assert!(!svg.contains("NaN") && !svg.contains("\"inf"), "{svg}");
    }
}

#[test]
fn nothing_to_see() {
    for (width, height) in [(16, 16), (16, 900), (900, 16), (333, 77)] {
        let options = Options {
            width,
            height,
            ..Options::default()
        };
        draw(&Frame::default(), &options);
        let point = frame(vec![sphere(0.0, 0.0, 0.0, f64::MIN_POSITIVE)]);
        draw(&point, &options);
        svg(&point, &options);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn any_bits(
        bits in prop::collection::vec(any::<[u64; 5]>(), 0..8), width in 16u32..200, height in 16u32..200,
        view in (-1e3..1e3f64, -1e3..1e3f64), perspective in any::<bool>(), zoom in 1e-6..1e6f64,
    ) {
        let spheres = bits.iter().map(|b| {
            let [x, y, z, radius, value] = b.map(f64::from_bits);
            Sphere { centre: DVec3::new(x, y, z), radius: radius.abs(), value, fixed: false }
        }).collect();
        let mut scene = frame(spheres);
        let corners: Vec<DVec3> = scene.spheres.iter().map(|s| s.centre).collect();
        scene.surfaces.push(Surface::wall(corners.windows(3).map(|c| [c[0], c[1], c[2]]).collect()));
        let options = Options {
            width, height, zoom,
            view: View::new(view.0, view.1),
            projection: if perspective { Projection::Perspective { field_of_view: 70.0 } } else { Projection::Orthographic },
            colour: ColourBy::scalar("value", "m/s"),
            ..Options::default()
        };
        draw(&scene, &options);
        let svg = svg(&scene, &options);
        prop_assert!(roxmltree::Document::parse(&svg).is_ok());
        prop_assert!(!svg.contains("NaN") && !svg.contains("\"inf"));
    }

    #[test]
    fn the_renderer_survives_the_eye_among_the_things(
        places in prop::collection::vec((-2.0..2.0f64, -2.0..2.0f64, -2.0..2.0f64, 0.01..1.0f64), 3..12), zoom in 0.5..50.0f64,
    ) {
        let spheres: Vec<Sphere> = places.iter().map(|(x, y, z, r)| sphere(*x, *y, *z, *r)).collect();
        let mut scene = frame(spheres);
        let corners: Vec<DVec3> = scene.spheres.iter().map(|s| s.centre * 3.0).collect();
        scene.surfaces.push(Surface::wall(corners.windows(3).map(|c| [c[0], c[1], c[2]]).collect()));
        let options = Options {
            framing: crate::Framing::Particles,
            projection: Projection::Perspective { field_of_view: 110.0 },
            zoom,
            ..bare(90, 70)
        };
        draw(&scene, &options);
    }
}
