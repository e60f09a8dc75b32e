//! The contract of the pictures: files that decode, spheres where they belong, and no input that breaks them.

use super::*;
use glam::DVec3;
use proptest::prelude::*;
use std::path::{Path, PathBuf};

/// Set to a folder, the tests leave their pictures there to be looked at.
const KEEP: &str = "MERCURY_KEEP_PICTURES";

struct Drawn {
    /// Width, height, RGB bytes.
    pixels: (u32, u32, Vec<u8>),
    svg: String,
}

impl Drawn {
    fn read(png: &Path, svg: &Path) -> Self {
        let mut reader = png::Decoder::new(std::fs::File::open(png).unwrap())
            .read_info()
            .unwrap();
        let mut bytes = vec![0; reader.output_buffer_size()];
        let info = reader.next_frame(&mut bytes).unwrap();
        assert_eq!(
            (info.width, info.height, info.color_type),
            (1200, 900, png::ColorType::Rgb)
        );
        Self {
            pixels: (info.width, info.height, bytes),
            svg: std::fs::read_to_string(svg).unwrap(),
        }
    }

    fn pixel(&self, x: f64, y: f64) -> [u8; 3] {
        let at = 3 * (y as usize * self.pixels.0 as usize + x as usize);
        self.pixels.2[at..at + 3].try_into().unwrap()
    }

    /// The SVG parsed: fails the test if it is not well formed.
    fn xml(&self) -> roxmltree::Document<'_> {
        roxmltree::Document::parse(&self.svg).unwrap()
    }

    fn texts(&self) -> Vec<String> {
        self.xml()
            .descendants()
            .filter_map(|n| n.text().map(str::to_owned))
            .collect()
    }

    fn says(&self, words: &str) -> bool {
        self.texts().iter().any(|text| text.contains(words))
    }

    fn circles(&self) -> usize {
        self.xml()
            .descendants()
            .filter(|n| n.has_tag_name(("http://www.w3.org/2000/svg", "circle")))
            .count()
    }
}

fn folder(name: &str) -> (Option<tempfile::TempDir>, PathBuf, PathBuf) {
    let (guard, folder) = match std::env::var_os(KEEP) {
        Some(folder) => (None, PathBuf::from(folder)),
        None => {
            let guard = tempfile::tempdir().unwrap();
            let path = guard.path().to_path_buf();
            (Some(guard), path)
        }
    };
    (
        guard,
        folder.join(format!("{name}.png")),
        folder.join(format!("{name}.svg")),
    )
}

fn final_of(name: &str, scene: &PictureScene) -> Drawn {
    let (_guard, png, svg) = folder(name);
    draw_final(&png, &svg, scene).unwrap();
    let drawn = Drawn::read(&png, &svg);
    drawn.xml();
    drawn
}

fn scene<'a>(title: &'a str, spheres: &'a [PictureSphere], size: DVec3) -> PictureScene<'a> {
    PictureScene {
        title,
        time: 1.25,
        spheres,
        domain_min: DVec3::ZERO,
        domain_max: size,
        gravity: DVec3::new(0.0, 0.0, -9.81),
        dimensions: 3,
        walls: &[],
    }
}

fn sphere(x: f64, y: f64, z: f64, radius: f64, speed: f64) -> PictureSphere {
    PictureSphere {
        centre: DVec3::new(x, y, z),
        radius,
        speed,
        fixed: false,
    }
}

/// Numbers in 0..1 that look random and are the same everywhere (Weyl's sequence for the golden ratio).
fn weyl(n: usize, which: usize) -> f64 {
    let irrational = [
        0.618_033_988_749_894_9,
        0.754_877_666_246_692_8,
        0.569_840_290_998_053_2,
    ];
    (0.5 + n as f64 * irrational[which % 3] * (1.0 + which as f64).sqrt()).fract()
}

/// A loose cubic packing with some disorder, filled layer by layer.
fn bed(number: usize, across: usize, deep: usize, radius: f64) -> Vec<PictureSphere> {
    (0..number)
        .map(|n| {
            let (i, j, k) = (n % across, n / across % deep, n / (across * deep));
            let size = radius * (0.8 + 0.2 * weyl(n, 0));
            let shift = |which| 0.35 * radius * (weyl(n, which) - 0.5);
            let place = |index: usize, which| radius * (2.0 * index as f64 + 1.0) + shift(which);
            let speed = 0.4
                * (k as f64 / (number as f64 / (across * deep) as f64))
                * (0.6 + 0.4 * weyl(n, 1));
            sphere(
                place(i, 1),
                place(j, 2),
                radius * (1.9 * k as f64 + 1.0) + shift(0),
                size,
                speed,
            )
        })
        .collect()
}

#[test]
fn beads_in_a_box() {
    let spheres = bed(2_000, 16, 12, 0.0025);
    let scene = scene(
        "Beads <in> a box & more",
        &spheres,
        DVec3::new(0.08, 0.06, 0.075),
    );
    let drawn = final_of("box", &scene);
    assert_eq!(drawn.circles(), 2_000);
    assert!(
        drawn.says("Beads <in> a box & more")
            && drawn.says("speed (mm/s)")
            && drawn.says("t = 1.25 s")
    );
    // The middle of the window lies inside the bed, its corner outside.
    assert_ne!(drawn.pixel(548.0, 500.0), [255, 255, 255]);
    assert_eq!(drawn.pixel(44.0, 100.0), [255, 255, 255]);
}

#[test]
fn a_chute_with_a_fixed_bottom() {
    let mut spheres = bed(3_000, 20, 10, 0.0005);
    for fixed in spheres.iter_mut().take(200) {
        fixed.fixed = true;
        fixed.speed = 0.0;
    }
    let mut scene = scene("Chute flow, 24°", &spheres, DVec3::new(0.02, 0.01, 0.03));
    let angle = 24_f64.to_radians();
    scene.gravity = 9.81 * DVec3::new(angle.sin(), 0.0, -angle.cos());
    let drawn = final_of("chute", &scene);
    assert!(drawn.says("200 fixed") && drawn.says("fixed"));
}

#[test]
fn one_sphere_bounces_in_its_box() {
    let spheres = [sphere(0.05, 0.05, 0.03, 0.005, 0.7)];
    let drawn = final_of("one", &scene("One sphere", &spheres, DVec3::splat(0.1)));
    assert!(drawn.says("1 sphere") && drawn.circles() == 1);
    let circle = drawn
        .xml()
        .descendants()
        .find(|n| n.has_tag_name(("http://www.w3.org/2000/svg", "circle")))
        .map(|n| ["cx", "cy"].map(|key| n.attribute(key).unwrap().parse::<f64>().unwrap()))
        .unwrap();
    assert_ne!(
        drawn.pixel(circle[0], circle[1]),
        [255, 255, 255],
        "the PNG shows it where the SVG does"
    );
}

#[test]
fn no_sphere_still_shows_the_domain() {
    let drawn = final_of(
        "none",
        &scene("Nothing left", &[], DVec3::new(0.3, 0.1, 0.1)),
    );
    assert!(drawn.says("0 spheres") && drawn.circles() == 0);
    assert!(
        drawn
            .xml()
            .descendants()
            .filter(|n| n.has_tag_name(("http://www.w3.org/2000/svg", "polyline")))
            .count()
            >= 12
    );
}

#[test]
fn sizes_twenty_to_one() {
    let spheres = [
        sphere(0.0, 0.0, 0.02, 0.02, 0.01),
        sphere(0.0175, -0.012, 0.005, 0.001, 0.05),
    ];
    let mut scene = scene("Ratio of sizes 20", &spheres, DVec3::new(0.04, 0.04, 0.06));
    scene.domain_min = DVec3::new(-0.04, -0.04, 0.0);
    assert_eq!(final_of("ratio", &scene).circles(), 2);
}

#[test]
fn discs_in_two_dimensions() {
    let spheres: Vec<_> = (0..400)
        .map(|n| {
            let (i, k) = ((n % 25) as f64, (n / 25) as f64);
            let speed = 0.02 * weyl(n, 1) * k;
            sphere(
                0.01 * (i + 0.5) + 0.002 * (weyl(n, 0) - 0.5),
                0.009 * (k + 0.6),
                0.0,
                0.0048,
                speed,
            )
        })
        .collect();
    let mut scene = scene("Discs", &spheres, DVec3::new(0.25, 0.2, 0.0));
    scene.dimensions = 2;
    scene.gravity = DVec3::new(0.0, -9.81, 0.0);
    let drawn = final_of("discs", &scene);
    assert!(drawn.says("400 discs"));
}

#[test]
fn a_bed_at_rest_is_coloured_by_height() {
    let mut spheres = bed(1_500, 12, 12, 0.004);
    spheres.iter_mut().for_each(|s| s.speed = 0.0);
    let circle = |z: f64| -> Vec<DVec3> {
        (0..=48)
            .map(|i| {
                let angle = std::f64::consts::TAU * f64::from(i) / 48.0;
                DVec3::new(0.048 + 0.07 * angle.cos(), 0.048 + 0.07 * angle.sin(), z)
            })
            .collect()
    };
    let walls = [
        PictureWall::Polyline(circle(0.0)),
        PictureWall::Polyline(circle(0.12)),
    ];
    let mut scene = scene("Silo at rest", &spheres, DVec3::new(5.0, 5.0, 5.0));
    scene.walls = &walls;
    let drawn = final_of("rest", &scene);
    assert!(drawn.says("height (mm)") && drawn.says("at rest"));
}

#[test]
fn a_hundred_thousand_spheres_keep_the_svg_small() {
    let spheres = bed(100_000, 50, 40, 0.001);
    let start = std::time::Instant::now();
    let drawn = final_of(
        "many",
        &scene("A hundred thousand", &spheres, DVec3::new(0.1, 0.08, 0.1)),
    );
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "100 000 spheres: {seconds:.2} s, SVG {} kB",
        drawn.svg.len() / 1000
    );
    assert!(drawn.circles() <= 20_000 && drawn.svg.len() < 2_000_000);
}

#[test]
fn strange_scenes_draw_something() {
    let nan = f64::NAN;
    let strange = [
        sphere(nan, 0.0, 0.0, 1.0, 1.0),
        sphere(0.0, f64::INFINITY, 0.0, 1.0, nan),
        sphere(0.0, 0.0, 0.0, 0.0, 0.0),
        sphere(0.0, 0.0, 0.0, -1.0, 0.0),
        sphere(1e300, 0.0, 0.0, 1.0, 1e300),
        sphere(0.0, 0.0, 0.0, 1e-9, 1.0),
        sphere(0.0, 1.0, 0.0, 1e9, f64::INFINITY),
    ];
    for (which, size) in [
        DVec3::ZERO,
        DVec3::splat(nan),
        DVec3::INFINITY,
        DVec3::splat(-1.0),
    ]
    .into_iter()
    .enumerate()
    {
        for (dimensions, spheres) in [
            (2, &strange[..]),
            (3, &strange[..]),
            (3, &strange[..5]),
            (2, &[]),
        ] {
            let mut scene = scene("\u{0}\u{7}]]> strange\u{fffe}", spheres, size);
            scene.dimensions = dimensions;
            scene.gravity = [
                DVec3::ZERO,
                DVec3::splat(nan),
                DVec3::X,
                DVec3::splat(1e300),
            ][which];
            scene.time = [0.0, nan, -1e-300, 1e300][which];
            let walls = [PictureWall::Polyline(vec![
                DVec3::splat(nan),
                DVec3::ONE,
                DVec3::splat(1e200),
            ])];
            scene.walls = &walls;
            assert!(final_of("strange", &scene).says("strange"));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn no_scene_breaks_the_picture(bits in prop::collection::vec(any::<[u64; 5]>(), 0..5), gravity in any::<[f64; 3]>()) {
        let spheres: Vec<_> = bits
            .iter()
            .map(|b| {
                let [x, y, z, radius, speed] = b.map(f64::from_bits);
                sphere(x, y, z, radius.abs(), speed)
            })
            .collect();
        let mut scene = scene("any", &spheres, DVec3::ONE);
        scene.gravity = DVec3::from_array(gravity);
        let drawn = final_of("any", &scene);
        prop_assert!(!drawn.svg.contains("NaN") && !drawn.svg.contains("inf"));
    }
}
