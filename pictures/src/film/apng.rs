//! Animated PNG: every colour, every browser.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use png::{BitDepth, BlendOp, ColorType, DisposeOp, Encoder, FilterType, Writer};

use super::Sizes;
use super::changes::Part;
use crate::PictureError;
use crate::image::Image;
use mercury_common::whole_file::WholeFile;

/// An animated PNG that grows picture by picture. Each holds only the rectangle that has changed.
pub struct Apng {
    file: WholeFile,
    writer: Option<Writer<BufWriter<File>>>,
    sizes: Sizes,
    /// Number of pictures that the head announces.
    number: u32,
    before: Option<Image>,
    alpha: bool,
    /// Time (s) up to the end of the last picture, and what of it is written (ms).
    clock: (f64, u64),
}

impl Apng {
    /// Starts a film of `number` pictures that runs for ever. The file appears under its name when it is finished.
    ///
    /// # Errors
    /// If `number` is 0 or the system refuses.
    pub fn create(path: &Path, number: usize) -> Result<Self, PictureError> {
        let pictures = u32::try_from(number).ok().filter(|number| *number > 0);
        Ok(Self {
            number: pictures.ok_or(PictureError::Number {
                got: number,
                expected: "at least 1".into(),
            })?,
            file: WholeFile::create(path)?,
            writer: None,
            sizes: Sizes::default(),
            before: None,
            alpha: false,
            clock: (0.0, 0),
        })
    }

    /// Adds a picture that stands for `seconds`. Delays are kept in milliseconds; their sum stays right. The first picture
    /// decides whether the film has an alpha channel.
    ///
    /// # Errors
    /// If it has another size than the first, comes after the last, or the system refuses.
    pub fn add(&mut self, image: &Image, seconds: f64) -> Result<(), PictureError> {
        self.sizes.take(image)?;
        if self.sizes.number > self.number as usize {
            return Err(self.wrong_number());
        }
        if self.writer.is_none() {
            self.alpha = !image.is_opaque();
            self.writer = Some(self.head(image)?);
        }
        let delay = self.delay(seconds);
        let part = match &self.before {
            Some(before) => Part::changed(before, image),
            None => Part::whole(image),
        };
        let bytes: Vec<u8> = if self.alpha {
            part.pixels(image).flatten().copied().collect()
        } else {
            part.pixels(image)
                .flat_map(|pixel| &pixel[..3])
                .copied()
                .collect()
        };
        if let Some(writer) = &mut self.writer {
            // The place before the size and the other way round: at no time may the part reach beyond the picture.
            writer.reset_frame_position()?;
            writer.set_frame_dimension(part.width, part.height)?;
            writer.set_frame_position(part.x, part.y)?;
            writer.set_frame_delay(delay, 1000)?;
            writer.write_image_data(&bytes)?;
        }
        self.before = Some(image.clone());
        Ok(())
    }

    fn head(&mut self, image: &Image) -> Result<Writer<BufWriter<File>>, PictureError> {
        let mut encoder = Encoder::new(self.file.writer()?, image.width, image.height);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_filter(FilterType::Paeth);
        encoder.set_color(if self.alpha {
            ColorType::Rgba
        } else {
            ColorType::Rgb
        });
        encoder.set_animated(self.number, 0)?;
        encoder.set_blend_op(BlendOp::Source)?;
        encoder.set_dispose_op(DisposeOp::None)?;
        Ok(encoder.write_header()?)
    }

    fn delay(&mut self, seconds: f64) -> u16 {
        let (time, written) = &mut self.clock;
        *time += seconds.clamp(0.0, 65.0);
        let delay = ((*time * 1000.0).round() as u64)
            .saturating_sub(*written)
            .clamp(1, u64::from(u16::MAX));
        *written += delay;
        delay as u16
    }

    fn wrong_number(&self) -> PictureError {
        PictureError::Number {
            got: self.sizes.number,
            expected: self.number.to_string(),
        }
    }

    /// Ends the film and gives the file its name.
    ///
    /// # Errors
    /// If pictures are missing or the system refuses.
    pub fn finish(mut self) -> Result<(), PictureError> {
        match self.writer.take() {
            Some(writer) if self.sizes.number == self.number as usize => {
                writer.finish()?;
                self.file.finish()?;
                Ok(())
            }
            _ => Err(self.wrong_number()),
        }
    }
}
