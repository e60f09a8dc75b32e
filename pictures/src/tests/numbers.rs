//! Colours that mean the same in every frame of a film.

use super::*;
use crate::{ColourBy, PictureError};

#[test]
fn a_film_has_one_camera_and_one_range() {
    let options = Options {
        colour: ColourBy::scalar("speed", "m/s"),
        ..bare(100, 100)
    };
    let still = Sphere {
        value: 0.0,
        ..sphere(0.0, 0.0, 0.0, 0.5)
    };
    let frames = [
        frame(vec![still]),
        frame(vec![Sphere {
            value: 8.0,
            ..sphere(4.0, 0.0, 4.0, 0.5)
        }]),
    ];
    let mut overview = Overview::default();
    frames
        .iter()
        .for_each(|frame| overview.add(frame, &options));
    let painter = Painter::new(&options, overview).unwrap();
    let images = frames.each_ref().map(|frame| painter.image(frame));
    // The first sphere stands lower left, the second upper right, of 5 units in 94 % of the width.
    let white = [255; 4];
    let at = |share: f64| (3.0 + 94.0 * share) as u32;
    assert_ne!(images[0].pixel(at(0.1), at(0.9)), white);
    assert_eq!(images[0].pixel(at(0.9), at(0.1)), white);
    assert_ne!(images[1].pixel(at(0.9), at(0.1)), white);
    // Viridis: bluish at the low end, yellow at the high end.
    let [r, _, b, _] = images[0].pixel(at(0.1), at(0.9));
    assert!(b > r);
    let [r, _, b, _] = images[1].pixel(at(0.9), at(0.1));
    assert!(r > b);
}

#[test]
fn a_strip_needs_a_frame() {
    let options = bare(100, 100);
    let painter = Painter::new(&options, Overview::default()).unwrap();
    assert!(matches!(
        painter.strip(&[]),
        Err(PictureError::Number { got: 0, .. })
    ));
    let image = painter
        .strip(&[frame(vec![sphere(0.0, 0.0, 0.0, 1.0)]), frame(Vec::new())])
        .unwrap();
    assert_eq!((image.width, image.height), (100, 100));
}
