//! Pictures of many kinds, to be looked at: `cargo run --release -p pictures --example gallery -- FOLDER`.

use std::path::Path;
use std::time::Instant;

use glam::DVec3;
use mercury_pictures::{
    Apng, Background, ClumpScene, Colour, ColourBy, ColourMap, Contact, Frame, Framing, Gif, Image,
    Line, Options, Overview, Painter, PictureError, Projection, Sphere, Surface, View, delays,
    draw_clump,
};

/// Numbers in 0..1 that look random and are the same everywhere (Weyl's sequence).
fn weyl(n: usize, which: usize) -> f64 {
    let irrational = [
        0.618_033_988_749_894_9,
        0.754_877_666_246_692_8,
        0.569_840_290_998_053_2,
    ];
    (0.5 + n as f64 * irrational[which % 3] * (1.0 + which as f64).sqrt()).fract()
}

/// A loose packing with some disorder, filled layer by layer; the value grows with height.
fn bed(number: usize, across: usize, deep: usize, radius: f64) -> Vec<Sphere> {
    (0..number)
        .map(|n| {
            let (i, j, k) = (n % across, n / across % deep, n / (across * deep));
            let shift = |which| 0.35 * radius * (weyl(n, which) - 0.5);
            let place = |index: usize, which| radius * (2.0 * index as f64 + 1.0) + shift(which);
            Sphere {
                centre: DVec3::new(
                    place(i, 1),
                    place(j, 2),
                    radius * (1.9 * k as f64 + 1.0) + shift(0),
                ),
                radius: radius * (0.8 + 0.2 * weyl(n, 0)),
                value: 0.4 * k as f64 / (number as f64 / (across * deep) as f64)
                    * (0.6 + 0.4 * weyl(n, 1)),
                fixed: false,
            }
        })
        .collect()
}

/// A drum of this radius and length along y.
fn drum(radius: f64, length: f64, sides: usize) -> Vec<[DVec3; 3]> {
    let at = |k: usize, y: f64| {
        let (sin, cos) = (std::f64::consts::TAU * (k % sides) as f64 / sides as f64).sin_cos();
        DVec3::new(radius * cos, y, radius * sin)
    };
    (0..sides)
        .flat_map(|k| {
            let (a, b, c, d) = (at(k, 0.0), at(k + 1, 0.0), at(k + 1, length), at(k, length));
            [[a, b, c], [a, c, d]]
        })
        .collect()
}

fn frame(title: &str, spheres: Vec<Sphere>, size: DVec3) -> Frame {
    Frame {
        title: title.into(),
        time: Some(1.25),
        gravity: DVec3::new(0.0, 0.0, -9.81),
        domain: Some((DVec3::ZERO, size)),
        spheres,
        ..Frame::default()
    }
}

struct Gallery<'a>(&'a Path);

impl Gallery<'_> {
    fn draw(&self, name: &str, frame: &Frame, options: &Options) -> Result<Image, PictureError> {
        let begin = Instant::now();
        let painter = Painter::new(options, Overview::of(frame, options))?;
        let image = painter.image(frame);
        let drawn = begin.elapsed().as_secs_f64();
        image.write_png(&self.0.join(format!("{name}.png")))?;
        let written = begin.elapsed().as_secs_f64();
        let svg = painter.svg(frame)?;
        mercury_common::whole_file::write_whole(
            &self.0.join(format!("{name}.svg")),
            svg.as_bytes(),
        )?;
        println!(
            "{name}: {} spheres, {drawn:.3} s drawn, {written:.3} s as PNG, SVG {} kB",
            frame.spheres.len(),
            svg.len() / 1000
        );
        Ok(image)
    }
}

fn main() -> Result<(), PictureError> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "gallery".into());
    let gallery = Gallery(Path::new(&folder));
    let _ = std::fs::create_dir_all(gallery.0);
    let speed = Options {
        colour: ColourBy::scalar("speed", "m/s"),
        ..Options::default()
    };

    let mut boxed = frame(
        "Beads in a box",
        bed(2_000, 16, 12, 0.0025),
        DVec3::new(0.08, 0.06, 0.075),
    );
    gallery.draw("box", &boxed, &speed)?;
    let perspective = Options {
        projection: Projection::Perspective {
            field_of_view: 45.0,
        },
        ..speed.clone()
    };
    gallery.draw("box-perspective", &boxed, &perspective)?;
    gallery.draw(
        "box-dark",
        &boxed,
        &Options {
            background: Background::Dark,
            view: View::ISO,
            ..speed.clone()
        },
    )?;
    gallery.draw(
        "box-transparent",
        &boxed,
        &Options {
            background: Background::Transparent,
            ..speed.clone()
        },
    )?;
    for (name, map) in ColourMap::NAMES {
        let colour = ColourBy::Scalar {
            label: "kinetic energy".into(),
            unit: "J".into(),
            range: Some((-0.1, 0.4)),
            map,
            logarithmic: false,
        };
        gallery.draw(
            &format!("map-{name}"),
            &boxed,
            &Options {
                width: 400,
                height: 300,
                colour,
                ..speed.clone()
            },
        )?;
    }
    for (k, sphere) in boxed.spheres.iter_mut().enumerate() {
        sphere.value = (k % 3) as f64;
        sphere.fixed = k < 192;
    }
    let names = vec!["glass".into(), "steel with a rather long name".into()];
    let materials = Options {
        colour: ColourBy::Category {
            label: "material".into(),
            names,
        },
        ..Options::default()
    };
    gallery.draw("materials", &boxed, &materials)?;
    for (k, sphere) in boxed.spheres.iter_mut().enumerate() {
        sphere.value = (k / 40) as f64;
    }
    gallery.draw(
        "bodies",
        &boxed,
        &Options {
            colour: ColourBy::Category {
                label: "body".into(),
                names: vec![],
            },
            ..Options::default()
        },
    )?;

    let mut drummed = frame("Half-filled drum", Vec::new(), DVec3::ZERO);
    drummed.domain = None;
    drummed.spheres = bed(4_000, 26, 12, 0.002);
    for sphere in &mut drummed.spheres {
        sphere.centre += DVec3::new(-0.052, 0.001, -0.055);
    }
    drummed
        .spheres
        .retain(|s| s.centre.x.hypot(s.centre.z) < 0.058);
    drummed.surfaces.push(Surface::wall(drum(0.06, 0.05, 72)));
    gallery.draw("drum", &drummed, &speed)?;
    gallery.draw(
        "drum-perspective-dark",
        &drummed,
        &Options {
            background: Background::Dark,
            ..perspective.clone()
        },
    )?;

    let mut discs = frame("Discs", Vec::new(), DVec3::new(0.25, 0.2, 0.0));
    discs.flat = true;
    discs.gravity = DVec3::new(0.0, -9.81, 0.0);
    discs.spheres = (0..400)
        .map(|n| {
            let (i, k) = ((n % 25) as f64, (n / 25) as f64);
            let x = 0.01 * (i + 0.5 + 0.25 * (k % 2.0)) + 0.001 * (weyl(n, 0) - 0.5);
            Sphere {
                centre: DVec3::new(x, 0.009 * (k + 0.6), 0.0),
                radius: 0.0046,
                value: 0.02 * weyl(n, 1) * k,
                fixed: k == 0.0,
            }
        })
        .collect();
    gallery.draw("discs", &discs, &speed)?;
    let places: Vec<DVec3> = discs.spheres.iter().map(|s| s.centre).collect();
    for (i, a) in places.iter().enumerate() {
        for b in &places[..i] {
            if a.distance(*b) < 0.0112 {
                let strength = 3.0 * (weyl(i, 0) * weyl(i, 1)).powi(2) * (0.2 - a.y);
                discs.contacts.push(Contact {
                    from: *a,
                    to: *b,
                    strength,
                });
            }
        }
    }
    gallery.draw(
        "discs-forces",
        &discs,
        &Options {
            sphere_opacity: 0.25,
            colour: ColourBy::Plain,
            ..speed.clone()
        },
    )?;

    let one = vec![Sphere {
        centre: DVec3::new(0.05, 0.05, 0.03),
        radius: 0.005,
        value: 0.7,
        fixed: false,
    }];
    gallery.draw(
        "one",
        &frame("One sphere", one.clone(), DVec3::splat(0.1)),
        &speed,
    )?;
    let mut alone = frame("", one, DVec3::ZERO);
    alone.domain = None;
    gallery.draw("alone", &alone, &speed)?;
    gallery.draw(
        "empty",
        &frame("Nothing left", Vec::new(), DVec3::new(0.3, 0.1, 0.1)),
        &speed,
    )?;
    let long = "A title that is much longer than the picture is wide, so that it has to be shortened or set in a smaller font, \
    ".repeat(3);
    gallery.draw(
        "long-title",
        &frame(&long, bed(300, 10, 6, 1e-7), DVec3::splat(2e-6)),
        &speed,
    )?;
    let mut huge = frame("Huge", bed(300, 10, 6, 2e5), DVec3::splat(4e6));
    huge.spheres.iter_mut().for_each(|s| s.value *= 1e9);
    gallery.draw("huge", &huge, &speed)?;
    huge.spheres
        .iter_mut()
        .enumerate()
        .for_each(|(k, s)| s.value = if k % 7 == 0 { f64::NAN } else { -2500.0 });
    gallery.draw(
        "one-value",
        &huge,
        &Options {
            colour: ColourBy::scalar("charge density", "C/m³"),
            ..speed.clone()
        },
    )?;
    for (width, height) in [
        (160, 120),
        (320, 240),
        (1600, 400),
        (400, 1200),
        (2400, 1800),
    ] {
        gallery.draw(
            &format!("size-{width}x{height}"),
            &drummed,
            &Options {
                width,
                height,
                ..speed.clone()
            },
        )?;
    }
    for (name, view) in View::NAMES {
        gallery.draw(
            &format!("view-{name}"),
            &drummed,
            &Options {
                width: 480,
                height: 360,
                view,
                ..speed.clone()
            },
        )?;
    }
    gallery.draw(
        "zoom",
        &drummed,
        &Options {
            zoom: 4.0,
            framing: Framing::Particles,
            ..speed.clone()
        },
    )?;
    let mut blocks = frame(
        "Opaque and translucent",
        bed(200, 8, 5, 0.005),
        DVec3::splat(0.08),
    );
    let square = |x: f64| {
        let p = |y: f64, z: f64| DVec3::new(x, y, z);
        vec![
            [p(0.0, 0.0), p(0.06, 0.0), p(0.06, 0.07)],
            [p(0.0, 0.0), p(0.06, 0.07), p(0.0, 0.07)],
        ]
    };
    blocks.surfaces = vec![
        Surface {
            colour: Some(Colour(200, 60, 60)),
            opacity: 0.4,
            ..Surface::wall(square(0.03))
        },
        Surface {
            opacity: 1.0,
            ..Surface::wall(square(0.055))
        },
    ];
    blocks.lines.push(Line {
        points: vec![DVec3::ZERO, DVec3::splat(0.08)],
        colour: Some(Colour(230, 120, 0)),
        width: 4.0,
    });
    gallery.draw("blocks", &blocks, &speed)?;
    gallery.draw(
        "blocks-ghost",
        &blocks,
        &Options {
            sphere_opacity: 0.3,
            ..perspective
        },
    )?;
    let hundred = frame(
        "A hundred thousand",
        bed(100_000, 50, 40, 0.001),
        DVec3::new(0.1, 0.08, 0.1),
    );
    gallery.draw("100k", &hundred, &speed)?;
    gallery.draw(
        "100k-perspective",
        &hundred,
        &Options {
            projection: Projection::Perspective {
                field_of_view: 40.0,
            },
            ..speed.clone()
        },
    )?;
    gallery.draw(
        "100k-ghost",
        &hundred,
        &Options {
            sphere_opacity: 0.3,
            ..speed.clone()
        },
    )?;
    gallery.draw(
        "1M",
        &frame(
            "A million",
            bed(1_000_000, 100, 100, 0.001),
            DVec3::new(0.2, 0.2, 0.2),
        ),
        &speed,
    )?;

    let pebbles = [
        (DVec3::ZERO, 0.005),
        (DVec3::new(0.006, 0.0, 0.001), 0.004),
        (DVec3::new(0.011, 0.001, 0.003), 0.003),
    ];
    let rod: Vec<[DVec3; 3]> = drum(0.0055, 0.02, 40)
        .into_iter()
        .map(|triangle| triangle.map(|p| DVec3::new(p.y - 0.006, p.x, p.z + 0.2 * p.y)))
        .collect();
    for (name, background) in [
        ("clump", Background::Light),
        ("clump-dark", Background::Dark),
    ] {
        let options = Options {
            width: 1200,
            height: 520,
            background,
            ..Options::default()
        };
        let scene = ClumpScene {
            title: "Three pebbles in a pipe",
            pebbles: &pebbles,
            surface: &rod,
        };
        draw_clump(&scene, &options)?.write_png(&gallery.0.join(format!("{name}.png")))?;
    }

    let film: Vec<Frame> = (0..12)
        .map(|k| {
            let mut frame = frame(
                "Falling beads",
                bed(600, 10, 6, 0.004),
                DVec3::new(0.08, 0.05, 0.12),
            );
            frame.time = Some(0.02 * f64::from(k));
            for (n, sphere) in frame.spheres.iter_mut().enumerate() {
                let fall = 0.5 * 9.81 * (0.02 * f64::from(k) * weyl(n, 2)).powi(2);
                sphere.centre.z = (sphere.centre.z + 0.03 - fall).max(sphere.radius);
                sphere.value = 9.81 * 0.02 * f64::from(k) * weyl(n, 2);
            }
            frame
        })
        .collect();
    let mut overview = Overview::default();
    film.iter().for_each(|frame| overview.add(frame, &speed));
    let small = Options {
        width: 480,
        height: 400,
        ..speed.clone()
    };
    let painter = Painter::new(&small, overview.clone())?;
    let mut gif = Gif::create(&gallery.0.join("film.gif"))?;
    let mut apng = Apng::create(&gallery.0.join("film.apng"), film.len())?;
    let times: Vec<f64> = film.iter().filter_map(|frame| frame.time).collect();
    let begin = Instant::now();
    for (frame, delay) in film.iter().zip(delays(&times, 2.0)) {
        let image = painter.image(frame);
        gif.add(&image, delay)?;
        apng.add(&image, delay)?;
    }
    gif.finish()?;
    apng.finish()?;
    println!("film: {:.2} s", begin.elapsed().as_secs_f64());
    Painter::new(&speed, overview.clone())?
        .strip(&film[..6])?
        .write_png(&gallery.0.join("strip.png"))?;
    Painter::new(
        &Options {
            width: 1600,
            height: 420,
            ..speed
        },
        overview,
    )?
    .strip(&film[..5])?
    .write_png(&gallery.0.join("strip-wide.png"))
}
