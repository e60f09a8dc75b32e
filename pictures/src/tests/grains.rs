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
    // 12 triangles each, without the broken one.
    assert_eq!(text.matches("<polygon").count(), 23);
    draw(&scene, &options);
}
