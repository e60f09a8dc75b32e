//! Spheres where they belong, as large as they are.

use std::f64::consts::PI;

use super::*;
use crate::{Background, Projection};

/// Sum of alpha, in pixels.
fn covered(image: &Image) -> f64 {
    let alpha: u64 = image.rgba.chunks_exact(4).map(|p| u64::from(p[3])).sum();
    alpha as f64 / 255.0
}

/// Mean place of what is covered (pixels).
fn centroid(image: &Image) -> (f64, f64) {
    let (mut x, mut y, mut sum) = (0.0, 0.0, 0.0);
    for row in 0..image.height {
        for column in 0..image.width {
            let alpha = f64::from(image.pixel(column, row)[3]);
            x += alpha * (f64::from(column) + 0.5);
            y += alpha * (f64::from(row) + 0.5);
            sum += alpha;
        }
    }
    (x / sum, y / sum)
}

fn transparent(options: Options) -> Options {
    Options {
        background: Background::Transparent,
        ..options
    }
}

#[test]
fn the_outline_has_the_area_of_a_circle() {
    let options = transparent(bare(200, 200));
    let frame = frame(vec![sphere(3.0, -2.0, 1.0, 0.7)]);
    let lens = Overview::of(&frame, &options);
    let image = draw(&frame, &options);
    // The frame leaves margins of 10 and of 0.03 · 180 pixels: the sphere fills the rest, 169.2 wide.
    let window = crate::camera::Window {
        x: 10,
        y: 7,
        width: 180,
        height: 186,
    };
    let radius = 0.7 * lens.lens(&options, window).target_scale();
    assert!((radius - 0.5 * 0.94 * 180.0).abs() < 1e-9, "{radius}");
    let area = covered(&image);
    assert!((area / (PI * radius * radius) - 1.0).abs() < 0.01, "{area}");
    let (x, y) = centroid(&image);
    assert!(
        (x - 100.0).abs() < 0.3 && (y - 100.0).abs() < 1.0,
        "{x} {y}"
    );
}

#[test]
fn in_perspective_the_outline_is_the_tangent_cone() {
    let mut options = transparent(bare(300, 300));
    options.projection = Projection::Perspective {
        field_of_view: 60.0,
    };
    let frame = frame(vec![sphere(0.0, 0.0, 0.0, 1.0)]);
    let window = crate::camera::Window {
        x: 0,
        y: 0,
        width: 300,
        height: 300,
    };
    let lens = Overview::of(&frame, &options).lens(&options, window);
    // A sphere of radius R at distance D is seen as a disc of radius D tan(asin(R / D)) in the plane of its centre.
    let distance = lens.distance().unwrap();
    let radius = lens.target_scale();
    let seen = distance * (radius / distance).asin().tan();
    let mut image = Image::new(300, 300, None);
    let look = crate::render::Look {
        theme: crate::theme::Theme::new(Background::Transparent),
        spheres: (&frame.spheres[..]).into(),
        sphere_colours: vec![crate::Colour::WHITE],
        grain_colours: Vec::new(),
        sphere_opacity: 1.0,
        contacts: Vec::new(),
        domain: false,
        unit: 1.0,
        frame: &frame,
    };
    crate::render::paint(&mut image, &lens, &look);
    let area = covered(&image);
    assert!(
        seen > 1.05 * radius,
        "else the test sees nothing of perspective"
    );
    assert!(
        (area / (PI * seen * seen) - 1.0).abs() < 0.01,
        "{area} {seen}"
    );
}

#[test]
fn equal_spheres_side_by_side_have_equal_areas() {
    let options = transparent(bare(400, 200));
    let spheres: Vec<Sphere> = (0..4)
        .map(|k| sphere(3.0 * f64::from(k), 0.5 * f64::from(k), 0.0, 1.0))
        .collect();
    let all = covered(&draw(&frame(spheres), &options));
    // 11 radii wide in 94 % of 400 - 2 · 11.3 pixels... four discs of 2 of 11 parts of that width.
    let width = 0.94 * (400.0 - 2.0 * 40.0 * (400.0 * 200.0 / 1_080_000.0_f64).sqrt()).floor();
    let radius = width / 11.0;
    assert!(
        (all / (4.0 * PI * radius * radius) - 1.0).abs() < 0.01,
        "{all}"
    );
}

#[test]
fn the_nearer_sphere_hides_the_farther_one() {
    // Seen along +y the one at lesser y is nearer, whatever the order of the list.
    let (near, far) = (sphere(0.0, -3.0, 0.0, 1.0), sphere(0.0, 3.0, 0.0, 1.0));
    let options = Options {
        colour: crate::ColourBy::Category {
            label: String::new(),
            names: Vec::new(),
        },
        ..bare(100, 100)
    };
    for swap in [false, true] {
        let mut spheres = vec![Sphere { value: 0.0, ..near }, Sphere { value: 1.0, ..far }];
        if swap {
            spheres.reverse();
        }
        let [r, _, b, _] = draw(&frame(spheres), &options).pixel(50, 50);
        // The first category is blue, the second orange.
        assert!(b > r, "{r} {b}");
    }
}

#[test]
fn the_middle_has_the_colour_of_its_value_in_the_light_of_the_lamp() {
    let options = Options {
        colour: crate::ColourBy::Scalar {
            label: "x".into(),
            unit: String::new(),
            range: Some((0.0, 1.0)),
            map: crate::ColourMap::Viridis,
            logarithmic: false,
        },
        ..bare(101, 101)
    };
    for value in [0.0, 0.3, 1.0] {
        let frame = frame(vec![Sphere {
            value,
            ..sphere(0.0, 0.0, 0.0, 1.0)
        }]);
        let image = draw(&frame, &options);
        let crate::Colour(r, g, b) = crate::ColourMap::Viridis.colour(value);
        // Facing the eye: 0.44 + 0.56 (0.707 + 0.35) / 1.35 of the colour.
        let lit = |c: u8| (f64::from(c) * (0.44 + 0.56 * (0.707 + 0.35) / 1.35)) as i32;
        let pixel = image.pixel(50, 50);
        for (seen, expected) in pixel[..3].iter().zip([r, g, b].map(lit)) {
            assert!(
                (i32::from(*seen) - expected).abs() <= 2,
                "{value}: {pixel:?}"
            );
        }
    }
}

#[test]
fn the_same_bytes_with_any_number_of_threads() {
    let mut scene = frame(
        (0..300)
            .map(|n| sphere(f64::from(n % 17), f64::from(n % 13), f64::from(n % 7), 0.9))
            .collect(),
    );
    scene.surfaces.push(crate::Surface::wall(vec![[
        DVec3::ZERO,
        DVec3::new(17.0, 5.0, 0.0),
        DVec3::new(0.0, 9.0, 7.0),
    ]]));
    let options = Options {
        sphere_opacity: 0.7,
        ..bare(300, 200)
    };
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| draw(&scene, &options))
    };
    assert!(with(1) == with(3));
}
