//! Particles of other shapes: as large as they are, coloured like spheres.

use std::f64::consts::PI;

use super::*;
use crate::render::shaded;
use crate::{Background, ColourBy, Grain, category_colour};

/// A box between two corners.
fn cuboid(low: DVec3, high: DVec3, value: f64) -> Grain {
    let corner = |k: usize| {
        let pick = |axis: usize| {
            if k >> axis & 1 == 0 {
                low[axis]
            } else {
                high[axis]
            }
        };
        DVec3::new(pick(0), pick(1), pick(2))
    };
    let faces = [
        [0, 1, 3, 2],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 3, 7, 6],
        [0, 2, 6, 4],
        [1, 3, 7, 5],
    ];
    let triangles = faces
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
        .map(|face| face.map(corner));
    Grain {
        triangles: triangles.collect(),
        value,
        fixed: false,
        of_wall: false,
    }
}

fn covered(image: &Image) -> f64 {
    let alpha: u64 = image.rgba.chunks_exact(4).map(|p| u64::from(p[3])).sum();
    alpha as f64 / 255.0
}

#[test]
fn a_box_covers_the_area_of_its_face() {
    let options = Options {
        background: Background::Transparent,
        ..bare(400, 300)
    };
    let grain = cuboid(DVec3::ZERO, DVec3::new(2.0, 5.0, 1.0), 0.0);
    let both = Frame {
        grains: vec![grain],
        ..frame(vec![sphere(4.0, 0.0, 0.0, 0.5)])
    };
    let alone = frame(both.spheres.clone());
    let painter = Painter::new(&options, Overview::of(&both, &options)).unwrap();
    let [both, alone] = [both, alone].map(|frame| covered(&painter.image(&frame)));
    // Seen along y: 2 x 1 against a circle of radius 1/2; edges are good to a sample of half a pixel.
    let ratio = (both - alone) / alone;
    assert!((ratio / (2.0 / (0.25 * PI)) - 1.0).abs() < 0.01, "{ratio}");
}

#[test]
fn colours_and_opacity_are_those_of_spheres() {
    let mut options = bare(200, 200);
    options.colour = ColourBy::Category {
        label: "body".into(),
        names: Vec::new(),
    };
    let scene = Frame {
        grains: vec![cuboid(-DVec3::ONE, DVec3::ONE, 3.0)],
        ..frame(Vec::new())
    };
    let middle = draw(&scene, &options).pixel(100, 100);
    let crate::Colour(r, g, b) = shaded(category_colour(3), DVec3::Z);
    assert_eq!(middle, [r, g, b, 255]);

    options.background = Background::Transparent;
    options.sphere_opacity = 0.5;
    let middle = draw(&scene, &options).pixel(100, 100);
    // Front and back, each hiding one half: 3/4 of 255.
    assert!((f64::from(middle[3]) - 191.25).abs() <= 1.0, "{middle:?}");
}

#[test]
fn walls_that_show_a_value_stay_as_they_are_where_particles_let_light_through() {
    let mut options = bare(200, 200);
    options.colour = ColourBy::Category {
        label: "body".into(),
        names: Vec::new(),
    };
    options.sphere_opacity = 0.0;
    let scene = Frame {
        grains: vec![Grain {
            of_wall: true,
            ..cuboid(-DVec3::ONE, DVec3::ONE, 3.0)
        }],
        ..frame(vec![sphere(0.0, -5.0, 0.0, 0.9)])
    };
    let crate::Colour(r, g, b) = shaded(category_colour(3), DVec3::Z);
    assert_eq!(draw(&scene, &options).pixel(100, 100), [r, g, b, 255]);
}

#[test]
fn droplets_are_no_spheres_and_decide_no_colours() {
    let droplet = crate::Sphere {
        value: 1e6,
        ..sphere(0.5, -2.0, 0.5, 0.2)
    };
    let mut scene = frame(vec![crate::Sphere {
        value: 1.0,
        ..sphere(0.0, 0.0, 0.0, 1.0)
    }]);
    let options = Options {
        colour: ColourBy::scalar("film volume", "m³"),
        ..Options::default()
    };
    let alone = Overview::of(&scene, &options);
    scene.droplets = vec![droplet, droplet];
    let with = Overview::of(&scene, &options);
    assert_eq!(with.values, alone.values);
    assert!(!with.has_droplets);
    let text = svg(&scene, &options);
    assert!(
        text.contains("1 sphere") && text.contains("2 droplets"),
        "{text}"
    );
    // Those without a value have a colour of their own, and a line in the legend, and are not "no value".
    scene.droplets[0].value = f64::NAN;
    let text = svg(&scene, &options);
    assert!(text.contains(">droplet<") && !text.contains(">no value<"));
}

#[test]
fn the_box_of_the_domain_is_drawn_as_a_whole_or_not_at_all() {
    let mut scene = frame(vec![sphere(0.0, 0.0, 0.0, 1.0)]);
    scene.domain = Some((DVec3::splat(-1.5), DVec3::splat(1.5)));
    let mut options = Options {
        domain: true,
        ..bare(300, 300)
    };
    // Whether the edges of the box are seen. From the front it is a square whose edges stand at 3 % of the window.
    let shows = |options: &Options| {
        let without = Options {
            domain: false,
            ..options.clone()
        };
        // From the same place.
        let drawn = |with: &Options| {
            let painter = Painter::new(with, Overview::of(&scene, options));
            painter.unwrap().image(&scene).rgba
        };
        drawn(options) != drawn(&without)
    };
    assert!(shows(&options));
    options.zoom = 2.0;
    assert!(!shows(&options));
    options.zoom = 1.0;
    options.framing = crate::Framing::Particles;
    assert!(!shows(&options));
}

#[test]
fn a_logarithmic_scale_needs_values_above_zero() {
    let options = Options {
        colour: ColourBy::Scalar {
            label: "film".into(),
            unit: String::new(),
            range: None,
            map: crate::ColourMap::Grey,
            logarithmic: true,
        },
        ..bare(100, 100)
    };
    let with = |values: [f64; 3]| {
        let spheres = (0u8..).zip(values).map(|(k, value)| crate::Sphere {
            value,
            ..sphere(3.0 * f64::from(k), 0.0, 0.0, 1.0)
        });
        frame(spheres.collect())
    };
    let painter = |scene: &Frame| Painter::new(&options, Overview::of(scene, &options));
    let error = painter(&with([0.0, -1.0, 0.0])).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the picture's colour scale cannot be logarithmic: no value is above 0"
    );
    // The middle of the ratios has the middle of the colours.
    let scene = with([1e-4, 1e-2, 1.0]);
    let look = painter(&scene).unwrap();
    let image = look.image(&scene);
    let grey = |x: u32| i32::from(image.pixel(x, 50)[0]);
    // Seen from the front the spheres stand at 1/8, 4/8, 7/8 of 94 % of the width.
    let [low, middle, high] = [18, 50, 82].map(grey);
    assert!(
        (2 * middle - low - high).abs() <= 4,
        "{low} {middle} {high}"
    );
    let mut refused = options.clone();
    if let ColourBy::Scalar { range, .. } = &mut refused.colour {
        *range = Some((0.0, 1.0));
    }
    assert!(Painter::new(&refused, Overview::of(&scene, &refused)).is_err());
}

#[test]
fn headings_and_legend_know_grains() {
    let mut fixed = cuboid(DVec3::ZERO, DVec3::ONE, 0.0);
    fixed.fixed = true;
    let mut broken = cuboid(DVec3::splat(2.0), DVec3::splat(3.0), f64::NAN);
    broken.triangles[0][0].x = f64::NAN;
    let scene = Frame {
        grains: vec![fixed, broken],
        ..frame(Vec::new())
    };
    let options = Options {
        colour: ColourBy::scalar("speed", "m/s"),
        ..Options::default()
    };
    let text = svg(&scene, &options);
    assert!(text.contains("2 grains (1 fixed)"), "heading");
    assert!(text.contains(">fixed<") && text.contains(">no value<"));
    draw(&scene, &options);
}
