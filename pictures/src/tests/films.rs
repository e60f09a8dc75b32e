//! Films, read back.

use super::*;
use crate::{Apng, Background, Gif, PictureError};

fn moving(number: u32, options: &Options) -> Vec<Image> {
    let frames: Vec<Frame> = (0..number)
        .map(|k| {
            frame(vec![
                sphere(0.1 * f64::from(k), 0.0, 0.0, 0.3),
                sphere(1.0, 0.0, 0.6, 0.2),
            ])
        })
        .collect();
    let mut overview = Overview::default();
    frames.iter().for_each(|frame| overview.add(frame, options));
    let painter = Painter::new(options, overview).unwrap();
    frames.iter().map(|frame| painter.image(frame)).collect()
}

/// Delays (hundredths) and the pictures a viewer composes.
fn read_gif(path: &std::path::Path) -> (Vec<u16>, Vec<Image>) {
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options
        .read_info(std::fs::File::open(path).unwrap())
        .unwrap();
    let mut screen = Image::new(
        u32::from(decoder.width()),
        u32::from(decoder.height()),
        None,
    );
    let (mut delays, mut pictures) = (Vec::new(), Vec::new());
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        for (k, pixel) in frame.buffer.chunks_exact(4).enumerate() {
            let (x, y) = (k % usize::from(frame.width), k / usize::from(frame.width));
            let at =
                (usize::from(frame.top) + y) * screen.width as usize + usize::from(frame.left) + x;
            if pixel[3] > 0 {
                screen.rgba[4 * at..4 * at + 4].copy_from_slice(pixel);
            }
        }
        delays.push(frame.delay);
        pictures.push(screen.clone());
        if frame.dispose == gif::DisposalMethod::Background {
            screen = Image::new(screen.width, screen.height, None);
        }
    }
    (delays, pictures)
}

#[test]
fn a_gif_reads_back_with_its_delays_and_colours() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.gif");
    let images = moving(4, &bare(120, 90));
    let mut film = Gif::create(&path).unwrap();
    for image in &images {
        // 1/30 s: 3.33 hundredths each, 13.3 in all.
        film.add(image, 1.0 / 30.0).unwrap();
    }
    assert!(!path.exists(), "the film has no name before it is whole");
    film.finish().unwrap();
    let (delays, seen) = read_gif(&path);
    assert_eq!(delays, [3, 4, 3, 3]);
    for (seen, drawn) in seen.iter().zip(&images) {
        let differences = seen
            .rgba
            .iter()
            .zip(&drawn.rgba)
            .map(|(a, b)| a.abs_diff(*b));
        // Cells of 4 levels, 255 colours for shades of one hue.
        assert!(differences.max().unwrap() <= 24);
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn transparent_films_clear_the_picture_before() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.gif");
    let options = Options {
        background: Background::Transparent,
        ..bare(100, 60)
    };
    let images = moving(3, &options);
    let mut film = Gif::create(&path).unwrap();
    images
        .iter()
        .for_each(|image| film.add(image, 0.1).unwrap());
    film.finish().unwrap();
    for (seen, drawn) in read_gif(&path).1.iter().zip(&images) {
        for (a, b) in seen.rgba.chunks_exact(4).zip(drawn.rgba.chunks_exact(4)) {
            assert_eq!(a[3] > 0, b[3] >= 128);
        }
    }
}

#[test]
fn an_apng_reads_back_exactly() {
    let folder = tempfile::tempdir().unwrap();
    for background in [Background::Light, Background::Transparent] {
        let path = folder.path().join("film.png");
        let options = Options {
            background,
            ..bare(100, 60)
        };
        let images = moving(4, &options);
        let mut film = Apng::create(&path, images.len()).unwrap();
        images
            .iter()
            .for_each(|image| film.add(image, 0.025).unwrap());
        film.finish().unwrap();
        let mut reader = png::Decoder::new(std::fs::File::open(&path).unwrap())
            .read_info()
            .unwrap();
        assert_eq!(
            reader
                .info()
                .animation_control
                .map(|a| (a.num_frames, a.num_plays)),
            Some((4, 0))
        );
        let channels = reader.info().color_type.samples();
        let mut screen = Image::new(100, 60, None);
        for drawn in &images {
            let mut buffer = vec![0; reader.output_buffer_size()];
            reader.next_frame(&mut buffer).unwrap();
            let control = *reader.info().frame_control().unwrap();
            assert_eq!((control.delay_num, control.delay_den), (25, 1000));
            for y in 0..control.height {
                for x in 0..control.width {
                    let from = channels * (y * control.width + x) as usize;
                    let mut pixel = [0, 0, 0, 255];
                    pixel[..channels].copy_from_slice(&buffer[from..from + channels]);
                    let at = 4 * ((control.y_offset + y) * 100 + control.x_offset + x) as usize;
                    screen.rgba[at..at + 4].copy_from_slice(&pixel);
                }
            }
            assert!(screen == *drawn);
        }
    }
}

#[test]
fn films_refuse_what_makes_no_film_and_leave_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film");
    let (small, large) = (Image::new(4, 4, None), Image::new(5, 4, None));
    let mut film = Gif::create(&path).unwrap();
    film.add(&small, 0.1).unwrap();
    assert_eq!(
        film.add(&large, 0.1).unwrap_err().to_string(),
        "picture 2 of the film has 5 x 4 pixels, the first 4 x 4"
    );
    drop(film);
    assert_eq!(
        Gif::create(&path)
            .unwrap()
            .finish()
            .unwrap_err()
            .to_string(),
        "the film has 0 pictures, expected at least 1"
    );
    assert!(matches!(
        Apng::create(&path, 0),
        Err(PictureError::Number { got: 0, .. })
    ));
    let mut film = Apng::create(&path, 2).unwrap();
    film.add(&small, 0.1).unwrap();
    assert_eq!(
        film.finish().unwrap_err().to_string(),
        "the film has 1 pictures, expected 2"
    );
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    let missing = folder.path().join("missing").join("film.gif");
    assert!(
        Gif::create(&missing)
            .err()
            .unwrap()
            .to_string()
            .contains("missing")
    );
}
