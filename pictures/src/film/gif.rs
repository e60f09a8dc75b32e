//! Animated GIF.

use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::Path;

use ::gif::{DisposalMethod, Encoder, EncodingError, Frame, Repeat};

use super::Sizes;
use super::changes::Part;
use super::palette::Palette;
use crate::PictureError;
use crate::image::Image;
use mercury_common::whole_file::WholeFile;

/// The number of the colour that lets the picture before through; the others come before it.
const THROUGH: u8 = 255;
/// Viewers show shorter delays (hundredths of a second) as a tenth of a second.
const SHORTEST: u64 = 2;

/// An animated GIF that grows picture by picture. Each has its own 255 colours and holds only what has changed.
pub struct Gif {
    file: WholeFile,
    encoder: Option<Encoder<BufWriter<File>>>,
    sizes: Sizes,
    before: Option<Image>,
    /// Time (s) up to the end of the last picture, and what of it is written (hundredths).
    clock: (f64, u64),
}

impl Gif {
    /// Starts a film that runs for ever. The file appears under its name when it is finished.
    ///
    /// # Errors
    /// If the system refuses.
    pub fn create(path: &Path) -> Result<Self, PictureError> {
        Ok(Self {
            file: WholeFile::create(path)?,
            encoder: None,
            sizes: Sizes::default(),
            before: None,
            clock: (0.0, 0),
        })
    }

    /// Adds a picture that stands for `seconds`. Delays are kept in hundredths of a second; their sum stays right.
    ///
    /// # Errors
    /// If it has another size than the first, is too large for the format, or the system refuses.
    pub fn add(&mut self, image: &Image, seconds: f64) -> Result<(), PictureError> {
        self.sizes.take(image)?;
        let (Ok(width), Ok(height)) = (u16::try_from(image.width), u16::try_from(image.height))
        else {
            return Err(PictureError::option(
                "size",
                format!(
                    "is limited to 65535 pixels a side in a GIF, got {} x {}",
                    image.width, image.height
                ),
            ));
        };
        if self.encoder.is_none() {
            let mut encoder = Encoder::new(self.file.writer()?, width, height, &[])?;
            encoder.set_repeat(Repeat::Infinite)?;
            self.encoder = Some(encoder);
        }
        let delay = self.delay(seconds);
        let frame = self.frame(image, delay);
        if let Some(encoder) = &mut self.encoder {
            encoder.write_frame(&frame)?;
        }
        self.before = Some(image.clone());
        Ok(())
    }

    fn delay(&mut self, seconds: f64) -> u16 {
        let (time, written) = &mut self.clock;
        *time += seconds.clamp(0.0, 600.0);
        let delay = ((*time * 100.0).round() as u64)
            .saturating_sub(*written)
            .clamp(SHORTEST, u64::from(u16::MAX));
        *written += delay;
        delay as u16
    }

    /// The part of `image` that differs from the picture before.
    fn frame(&self, image: &Image, delay: u16) -> Frame<'static> {
        let opaque = image.is_opaque();
        let before = self.before.as_ref().filter(|_| opaque);
        let part = before.map_or_else(|| Part::whole(image), |before| Part::changed(before, image));
        let old = before.map(|before| part.pixels(before));
        let mut shown: Vec<Option<&[u8]>> = (part.pixels(image))
            .map(|pixel| (pixel[3] >= 128).then_some(pixel))
            .collect();
        if let Some(old) = old {
            for (pixel, old) in shown.iter_mut().zip(old) {
                if *pixel == Some(old) {
                    *pixel = None;
                }
            }
        }
        let palette = Palette::new(shown.iter().copied().flatten(), usize::from(THROUGH));
        let mut colours = palette.colours.concat();
        colours.resize(3 * 256, 0);
        Frame {
            delay,
            // A transparent picture must be taken away before the next one.
            dispose: if opaque {
                DisposalMethod::Keep
            } else {
                DisposalMethod::Background
            },
            transparent: Some(THROUGH),
            // Parts of a GIF's picture: add() has seen that they fit.
            top: part.y as u16,
            left: part.x as u16,
            width: part.width as u16,
            height: part.height as u16,
            palette: Some(colours),
            buffer: shown
                .iter()
                .map(|pixel| pixel.map_or(THROUGH, |pixel| palette.index(pixel)))
                .collect::<Vec<u8>>()
                .into(),
            ..Frame::default()
        }
    }

    /// Ends the film and gives the file its name.
    ///
    /// # Errors
    /// If there is no picture or the system refuses.
    pub fn finish(self) -> Result<(), PictureError> {
        let Some(encoder) = self.encoder else {
            return Err(PictureError::Number {
                got: 0,
                expected: "at least 1".into(),
            });
        };
        encoder.into_inner()?.flush().map_err(EncodingError::from)?;
        self.file.finish()?;
        Ok(())
    }
}
