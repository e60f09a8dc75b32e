//! Pictures and films of a run that the test writes itself.

use std::path::{Path, PathBuf};

use glam::DVec3;
use mercury_common::frames::{
    ContactColumns, ContactFrame, ContactWriter, FramesHeader, ParticleColumns, ParticleFrame,
    ParticleWriter, WallFrame, WallWriter,
};
use mercury_common::surfaces::{Placement, Surface};
use mercury_export::output::Output;
use mercury_export::sinks::pictures::{PictureChoice, PictureKind, Pictures};
use mercury_export::{ExportError, Job, Selection, Source, export};
use mercury_pictures::{ColourMap, Options};

/// Two beads of two materials, one of them fixed, in a spherical shell; the free one moves with `speed` (m/s) in three frames.
fn run(folder: &Path, speed: f64) {
    let header = FramesHeader {
        title: "Two beads".into(),
        materials: vec!["glass".into(), "steel".into()],
        walls: vec!["shell".into()],
        domain: Some((DVec3::splat(-1.0), DVec3::splat(2.0))),
        dimensions: Some(3),
        gravity: Some(DVec3::new(0.0, 0.0, -9.81)),
        ..FramesHeader::default()
    };
    let path = |kind: &str| folder.join(format!("beads.{kind}.arrow"));
    let shell = Surface::Sphere {
        centre: DVec3::splat(0.5),
        radius: 1.4,
    };
    let columns = ParticleColumns::default();
    let mut particles = ParticleWriter::create(path("particles"), &header, &columns).unwrap();
    let columns = ContactColumns::default();
    let mut contacts = ContactWriter::create(path("contacts"), &header, &columns).unwrap();
    let mut walls = WallWriter::create(path("walls"), &header, &vec![shell]).unwrap();
    for k in 0..3_u32 {
        let (time, step) = (0.1 * f64::from(k), u64::from(k));
        let moved = DVec3::new(0.9 + speed * time, 0.0, 0.0);
        let frame = ParticleFrame {
            time,
            step,
            id: vec![0, 7],
            material: vec![0, 1],
            flags: vec![1, 0],
            mass: vec![1.0; 2],
            volume: vec![1.0; 2],
            radius: vec![0.5; 2],
            position: vec![DVec3::ZERO, moved],
            velocity: vec![DVec3::ZERO, DVec3::new(speed, 0.0, 0.0)],
            ..ParticleFrame::default()
        };
        particles.append(frame).unwrap();
        let contact = ContactFrame {
            time,
            step,
            i: vec![7],
            j: vec![Some(0)],
            wall: vec![None],
            point: vec![0.5 * moved],
            branch: vec![moved],
            normal: vec![DVec3::X],
            force: vec![DVec3::new(3.0, 0.0, 0.0)],
            overlap: vec![0.1],
            ..ContactFrame::default()
        };
        contacts.append(contact).unwrap();
        let present = vec![true];
        let placement = vec![Placement::default()];
        walls
            .append(WallFrame {
                time,
                step,
                present,
                placement,
            })
            .unwrap();
    }
}

fn choice(quantity: &str) -> PictureChoice {
    PictureChoice {
        options: Options {
            width: 480,
            height: 360,
            ..Options::default()
        },
        quantity: quantity.into(),
        range: None,
        map: ColourMap::Viridis,
        logarithmic: false,
        particles: true,
        contacts: true,
        bridges: false,
        bonds: None,
        droplets: false,
        walls: true,
        clumps: Default::default(),
        title: None,
    }
}

fn draw(
    folder: &Path,
    choice: &PictureChoice,
    kind: PictureKind,
) -> Result<Vec<PathBuf>, ExportError> {
    let source = Source::open(folder)?;
    let output = Output::new(&source, None, "out", true)?;
    let job = Job {
        source,
        selection: Selection::default(),
        output,
    };
    let mut heard = 0;
    let sink = Box::new(Pictures::new(&job, choice.clone(), kind)?);
    let (reported, files) = export(&job, sink, |_| heard += 1)?;
    assert_eq!((reported.frames, heard), (3, 3));
    Ok(files)
}

fn texts(svg: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(svg).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    let texts = document
        .descendants()
        .filter(|node| node.tag_name().name() == "text");
    texts
        .filter_map(|node| node.text().map(str::to_owned))
        .collect()
}

#[test]
fn every_kind_of_picture_comes_out_of_a_run() {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), 2.0);
    let names = |kind| -> Vec<String> {
        let files = draw(folder.path(), &choice("auto"), kind).unwrap();
        let name = |path: &PathBuf| path.file_name().unwrap().to_string_lossy().into_owned();
        assert!(
            files
                .iter()
                .all(|path| path.metadata().unwrap().len() > 100)
        );
        files.iter().map(name).collect()
    };
    let numbered = |ending: &str| {
        (0..3)
            .map(|k| format!("beads.{k:04}.{ending}"))
            .collect::<Vec<_>>()
    };
    assert_eq!(names(PictureKind::Png), numbered("png"));
    assert_eq!(names(PictureKind::Svg), numbered("svg"));
    assert_eq!(names(PictureKind::Strip(2)), ["beads.strip.png"]);
    assert_eq!(names(PictureKind::Gif(None)), ["beads.gif"]);
    assert_eq!(names(PictureKind::Apng(Some(1.0))), ["beads.apng"]);
}

#[test]
fn the_picture_says_what_it_shows() {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), 2.0);
    for (quantity, words) in [
        ("auto", "speed (m/s)"),
        ("material", "steel"),
        ("height", "height (m)"),
        ("mass", "mass (kg)"),
        ("vx", "vx (m/s)"),
        ("volume", "volume (m³)"),
        ("none", "force (N)"),
    ] {
        let files = draw(folder.path(), &choice(quantity), PictureKind::Svg).unwrap();
        let texts = texts(&files[1]);
        for words in [words, "Two beads", "t = 100 ms", "fixed", "1 contact"] {
            assert!(
                texts.iter().any(|text| text.contains(words)),
                "{quantity}: {words}: {texts:?}"
            );
        }
    }
}

#[test]
fn where_nothing_moves_colours_show_height() {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), 0.0);
    let files = draw(folder.path(), &choice("auto"), PictureKind::Svg).unwrap();
    assert!(
        texts(&files[0])
            .iter()
            .any(|text| text.contains("height (m)"))
    );
}

#[test]
fn walls_and_contacts_can_be_left_out() {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), 2.0);
    let scene = |walls: bool, contacts: bool| -> String {
        let choice = PictureChoice {
            walls,
            contacts,
            ..choice("auto")
        };
        let files = draw(folder.path(), &choice, PictureKind::Svg).unwrap();
        let texts = texts(&files[0]);
        assert_eq!(texts.iter().any(|text| text.contains("contact")), contacts);
        // The picture inside, on a line of its own.
        let text = std::fs::read_to_string(&files[0]).unwrap();
        text.lines().filter(|l| l.starts_with("<image")).collect()
    };
    let [neither, walls] = [false, true].map(|walls| scene(walls, false));
    assert!(!neither.is_empty() && neither != walls);
    scene(true, true);
}

#[test]
fn what_cannot_be_shown_is_named() {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), 2.0);
    let error = |choice: &PictureChoice, kind| {
        let error = draw(folder.path(), choice, kind).unwrap_err();
        assert!(error.is_input(), "exit code 2");
        error.to_string()
    };
    let file = folder.path().join("beads.particles.arrow");
    assert_eq!(
        error(&choice("colour"), PictureKind::Png),
        format!(
            "--colour colour: {} has nothing of that name\nhelp: it has auto, none, height, diameter, id, material, state, mass, \
             volume, radius, speed, and the components of vectors",
            file.display()
        )
    );
    assert_eq!(
        error(&choice("auto"), PictureKind::Strip(65)),
        "--strip 65: expected 1 to 64 frames"
    );
    assert_eq!(
        error(&choice("auto"), PictureKind::Gif(Some(f64::NAN))),
        "--duration NaN: expected seconds above 0"
    );
    let mut large = choice("auto");
    large.options.width = 20_000;
    assert_eq!(
        error(&large, PictureKind::Png),
        "the picture's width must be 16 to 16384 pixels, got 20000"
    );
}
