//! Translucent surfaces in front of spheres and behind them.

use super::*;
use crate::{Colour, Contact, Line, Surface};

/// A square in the plane of this y, from -`half` to `half` in x and z.
fn square(y: f64, half: f64) -> Vec<[DVec3; 3]> {
    let p = |x: f64, z: f64| DVec3::new(x * half, y, z * half);
    vec![
        [p(-1.0, -1.0), p(1.0, -1.0), p(1.0, 1.0)],
        [p(-1.0, -1.0), p(1.0, 1.0), p(-1.0, 1.0)],
    ]
}

fn sheet(y: f64, opacity: f64, colour: Colour) -> Surface {
    Surface {
        triangles: square(y, 2.0),
        colour: Some(colour),
        opacity,
        edges: false,
    }
}

fn middle(surfaces: Vec<Surface>) -> [i32; 3] {
    let frame = Frame {
        surfaces,
        ..frame(Vec::new())
    };
    let [r, g, b, a] = draw(&frame, &bare(80, 80)).pixel(30, 50);
    assert_eq!(a, 255);
    [r, g, b].map(i32::from)
}

/// How bright a sheet is that faces the eye: 0.6 + 0.4 (0.707 + 0.35) / 1.35.
const LIT: f64 = 0.6 + 0.4 * (0.707 + 0.35) / 1.35;

#[test]
fn a_sheet_mixes_its_colour_with_what_lies_behind() {
    let red = Colour(200, 0, 0);
    for opacity in [0.25, 0.5, 1.0] {
        let [r, g, b] = middle(vec![sheet(0.0, opacity, red)]);
        let expected = (1.0 - opacity) * 255.0 + opacity * 200.0 * LIT;
        assert!(
            (f64::from(r) - expected).abs() <= 1.0,
            "{opacity}: {r} {expected}"
        );
        assert!((f64::from(g) - (1.0 - opacity) * 255.0).abs() <= 1.0 && g == b);
    }
}

#[test]
fn the_order_is_that_of_space_not_of_the_list() {
    let (red, blue) = (Colour(255, 0, 0), Colour(0, 0, 255));
    // Seen along +y the sheet at y = -1 is in front.
    let one = middle(vec![sheet(-1.0, 0.5, red), sheet(1.0, 0.5, blue)]);
    let other = middle(vec![sheet(1.0, 0.5, blue), sheet(-1.0, 0.5, red)]);
    assert_eq!(one, other);
    let expected = [
        0.25 * 255.0 + 0.5 * 255.0 * LIT,
        0.25 * 255.0,
        0.25 * 255.0 + 0.25 * 255.0 * LIT,
    ];
    for (seen, expected) in one.into_iter().zip(expected) {
        assert!((f64::from(seen) - expected).abs() <= 1.0, "{one:?}");
    }
}

#[test]
fn triangles_that_share_an_edge_leave_no_seam() {
    let frame = Frame {
        surfaces: vec![sheet(0.0, 0.4, Colour(0, 120, 0))],
        ..frame(Vec::new())
    };
    let image = draw(&frame, &bare(90, 90));
    let expected = image.pixel(45, 30);
    // The diagonal runs through the middle; the sheet fills 94 % of the window.
    for k in 12..78 {
        assert_eq!(image.pixel(k, 90 - 1 - k), expected);
        assert_eq!(image.pixel(k, k), expected);
    }
}

#[test]
fn a_sheet_before_a_sphere_tints_it_and_one_behind_does_not() {
    let look_at = |y: f64| {
        let mut scene = frame(vec![sphere(0.0, 0.0, 0.0, 1.0)]);
        scene.surfaces.push(sheet(y, 0.5, Colour(0, 0, 0)));
        draw(&scene, &bare(100, 100)).pixel(50, 50)
    };
    let (behind, before) = (look_at(2.0), look_at(-2.0));
    for k in 0..3 {
        assert!((i32::from(behind[k]) / 2 - i32::from(before[k])).abs() <= 1);
    }
}

#[test]
fn an_opaque_sheet_hides_and_is_hidden() {
    let mut scene = frame(vec![sphere(0.0, 0.0, 0.0, 1.0)]);
    scene.surfaces.push(sheet(0.0, 1.0, Colour(0, 0, 200)));
    let image = draw(&scene, &bare(100, 100));
    let [r, _, b, _] = image.pixel(50, 50);
    assert!(
        r > b,
        "the front half of the sphere stands before the sheet"
    );
    let [r, _, b, _] = image.pixel(20, 20);
    assert!(b > r + 100, "the sheet is seen beside it");
}

#[test]
fn lines_hide_behind_spheres_and_show_through_ghosts() {
    let mut scene = frame(vec![sphere(0.0, 0.0, 0.0, 1.0)]);
    let ends = vec![DVec3::new(-2.0, 0.5, 0.0), DVec3::new(2.0, 0.5, 0.0)];
    scene.lines.push(Line {
        points: ends,
        colour: Some(Colour(255, 0, 0)),
        width: 40.0,
    });
    let solid = draw(&scene, &bare(100, 100));
    let is_red = |p: [u8; 4]| p[0] > p[1].saturating_add(60);
    assert!(!is_red(solid.pixel(50, 50)) && is_red(solid.pixel(15, 50)));
    let ghost = draw(
        &scene,
        &Options {
            sphere_opacity: 0.3,
            ..bare(100, 100)
        },
    );
    assert!(is_red(ghost.pixel(50, 50)));
}

#[test]
fn stronger_contacts_are_wider() {
    let options = bare(400, 400);
    let dark = |strength: f64| {
        let mut scene = frame(Vec::new());
        scene.contacts = vec![
            Contact {
                from: DVec3::new(-1.0, 0.0, 0.5),
                to: DVec3::new(1.0, 0.0, 0.5),
                strength: 4.0,
            },
            Contact {
                from: DVec3::new(-1.0, 0.0, -0.5),
                to: DVec3::new(1.0, 0.0, -0.5),
                strength,
            },
        ];
        scene.lines.push(Line {
            points: vec![DVec3::splat(-1.0), DVec3::ONE],
            colour: None,
            width: 0.0,
        });
        let image = draw(&scene, &options);
        let seen = |rows: std::ops::Range<u32>| {
            rows.map(|y| 255.0 - f64::from(image.pixel(200, y)[2]))
                .sum::<f64>()
        };
        seen(200..400)
    };
    let (none, half, full) = (dark(0.0), dark(2.0), dark(4.0));
    assert!(
        none < 0.5 * half && half < 0.8 * full,
        "{none} {half} {full}"
    );
}
