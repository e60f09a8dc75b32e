//! SVG: well formed, small, and with the content of the pixels.

use super::*;
use crate::{ClumpScene, ColourBy, Surface, draw_clump, draw_clump_svg};

fn texts(svg: &str) -> Vec<String> {
    let document = roxmltree::Document::parse(svg).unwrap();
    document
        .descendants()
        .filter(|n| n.has_tag_name(("http://www.w3.org/2000/svg", "text")))
        .filter_map(|n| n.text().map(str::to_owned))
        .collect()
}

/// Left, right, top and bottom of each text.
fn boxes(svg: &str) -> Vec<(String, [f64; 4])> {
    let document = roxmltree::Document::parse(svg).unwrap();
    let texts = document
        .descendants()
        .filter(|n| n.has_tag_name(("http://www.w3.org/2000/svg", "text")));
    texts
        .map(|n| {
            let number = |key: &str| n.attribute(key).unwrap().parse::<f64>().unwrap();
            let (x, y, size) = (number("x"), number("y"), number("font-size"));
            let text = n.text().unwrap_or_default();
            let width = crate::font::width(text, size);
            let left = match n.attribute("text-anchor") {
                Some("middle") => x - 0.5 * width,
                Some("end") => x - width,
                _ => x,
            };
            // Capitals and descenders, not the whole em.
            (
                text.to_owned(),
                [left, left + width, y - 0.73 * size, y + 0.2 * size],
            )
        })
        .collect()
}

fn labelled() -> (Frame, Options) {
    let mut scene = frame(
        (0..200)
            .map(|n| Sphere {
                value: f64::from(n),
                fixed: n < 20,
                ..sphere(
                    f64::from(n % 8),
                    f64::from(n / 8 % 5),
                    f64::from(n / 40),
                    0.5,
                )
            })
            .collect(),
    );
    scene.time = Some(0.0125);
    scene.title = "Beads <in> a box & more".into();
    scene.gravity = DVec3::new(0.0, 0.0, -9.81);
    scene.domain = Some((DVec3::splat(-1.0), DVec3::splat(9.0)));
    scene
        .surfaces
        .push(Surface::wall(vec![[DVec3::ZERO, DVec3::X, DVec3::Z]]));
    scene.spheres[30].value = f64::NAN;
    let options = Options {
        colour: ColourBy::scalar("temperature", "K"),
        ..Options::default()
    };
    (scene, options)
}

#[test]
fn the_document_says_what_is_shown() {
    let (scene, options) = labelled();
    let svg = svg(&scene, &options);
    let texts = texts(&svg);
    for words in [
        "Beads <in> a box & more",
        "t = 12.5 ms",
        "200 spheres (20 fixed)",
        "temperature (K)",
        "fixed",
        "no value",
        "2 m",
    ] {
        assert!(
            texts.iter().any(|text| text.contains(words)),
            "{words}: {texts:?}"
        );
    }
    let document = roxmltree::Document::parse(&svg).unwrap();
    let shape = |name: &str| {
        document
            .descendants()
            .filter(|n| n.has_tag_name(("http://www.w3.org/2000/svg", name)))
            .count()
    };
    // One picture of the scene, and two discs each for "fixed" and "no value".
    assert_eq!((shape("image"), shape("circle")), (1, 4));
}

#[test]
fn no_text_leaves_the_picture_or_covers_another() {
    let (mut scene, options) = labelled();
    for title in ["Short", &"A very long title ".repeat(20), ""] {
        scene.title = title.into();
        for (width, height) in [(1200, 900), (640, 480), (1600, 500), (500, 900), (320, 240)] {
            let options = Options {
                width,
                height,
                ..options.clone()
            };
            let boxes = boxes(&svg(&scene, &options));
            assert!(!boxes.is_empty());
            for (k, (text, [left, right, top, bottom])) in boxes.iter().enumerate() {
                assert!(
                    *left >= 0.0
                        && *right <= f64::from(width)
                        && *top >= 0.0
                        && *bottom <= f64::from(height),
                    "{text:?} leaves {width} x {height}: {left} {right} {top} {bottom}"
                );
                for (other, [l, r, t, b]) in &boxes[..k] {
                    let apart = right <= l || r <= left || bottom <= t || b <= top;
                    assert!(apart, "{text:?} and {other:?} at {width} x {height}");
                }
            }
        }
    }
}

/// The pixels inside are those of the picture without headings, legend and axes.
#[test]
fn the_scene_is_a_png_inside() {
    use base64::Engine as _;
    let (scene, options) = labelled();
    let text = svg(&scene, &options);
    let start = text.find("base64,").expect("a picture") + 7;
    let end = start + text[start..].find('"').expect("an end");
    let bytes = base64::prelude::BASE64_STANDARD.decode(&text[start..end]);
    let decoder = png::Decoder::new(std::io::Cursor::new(bytes.unwrap()));
    let mut reader = decoder.read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!((info.width, info.height), (options.width, options.height));
    let whole = draw(&scene, &options).rgb();
    let (mut same, mut paper) = (0, 0);
    for (inside, outside) in pixels.chunks_exact(3).zip(whole.chunks_exact(3)) {
        same += usize::from(inside == outside);
        paper += usize::from(inside == &whole[..3] && inside != outside);
    }
    // A pixel is the scene's, or paper on which something is written.
    assert_eq!(same + paper, whole.len() / 3);
    assert!(paper > 0);
}

#[test]
fn a_clump_has_three_views_of_one_scale() {
    let pebbles = [(DVec3::ZERO, 1.0), (DVec3::new(3.0, 0.0, 0.0), 0.5)];
    let surface = [[
        DVec3::new(-1.0, 0.0, -1.0),
        DVec3::new(4.0, 0.0, -1.0),
        DVec3::new(0.0, 0.0, 1.0),
    ]];
    let clump = ClumpScene {
        title: "A clump",
        pebbles: &pebbles,
        surface: &surface,
    };
    let options = Options {
        height: 500,
        ..Options::default()
    };
    let svg = draw_clump_svg(&clump, &options).unwrap();
    let texts = texts(&svg);
    for words in [
        "A clump",
        "front",
        "side",
        "top",
        "2 pebbles",
        "largest radius 1 m",
        "1 triangle",
    ] {
        assert!(
            texts.iter().any(|text| text.contains(words)),
            "{words}: {texts:?}"
        );
    }
    let image = draw_clump(&clump, &options).unwrap();
    assert_eq!((image.width, image.height), (1200, 500));
    let nothing = ClumpScene {
        title: "",
        pebbles: &[],
        surface: &[],
    };
    draw_clump(&nothing, &options).unwrap();
}

/// A legend names what fits and counts all others, also beyond the number of names that it keeps.
#[test]
fn a_legend_counts_all_categories() {
    for number in [70, 200_u32] {
        let valued = |k: u32| Sphere {
            value: f64::from(k),
            ..sphere(f64::from(k), 0.0, 0.0, 0.5)
        };
        let options = Options {
            colour: ColourBy::Category {
                label: "kind".into(),
                names: (0..number).map(|k| format!("kind {k}")).collect(),
            },
            ..Options::default()
        };
        let texts = texts(&svg(&frame((0..number).map(valued).collect()), &options));
        let is_named = |k: &u32| texts.contains(&format!("kind {k}"));
        let named = (0..number).filter(is_named).count() as u32;
        assert!((10..64).contains(&named), "{named}");
        let rest = format!("and {} more", number - named);
        assert!(texts.contains(&rest), "{rest}: {texts:?}");
    }
}

/// Categories that are only numbers have a legend only where they are few: a reader cannot find one number among many.
#[test]
fn many_numbers_have_no_legend() {
    for (number, has_legend) in [(3, true), (40, false)] {
        let valued = |k: u32| Sphere {
            value: f64::from(k),
            ..sphere(f64::from(k), 0.0, 0.0, 0.5)
        };
        let options = Options {
            colour: ColourBy::Category {
                label: "body".into(),
                names: Vec::new(),
            },
            ..Options::default()
        };
        let texts = texts(&svg(&frame((0..number).map(valued).collect()), &options));
        assert_eq!(texts.contains(&"body".to_owned()), has_legend, "{texts:?}");
    }
}
