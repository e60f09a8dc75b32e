//! A picture as pixels: what is drawn on, and what becomes a file.

use std::path::Path;

use crate::PictureError;
use crate::canvas::{Anchor, Canvas, Lettering, Spot, Stroke};
use crate::colour::Colour;
use crate::{file, font};

/// A picture of `width` x `height` pixels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green, blue and alpha (sRGB, not premultiplied), row by row from the upper left.
    pub rgba: Vec<u8>,
}

impl Image {
    /// A picture of one colour; `None`: transparent.
    pub(crate) fn new(width: u32, height: u32, paper: Option<Colour>) -> Self {
        let pixel = paper.map_or([0; 4], |Colour(r, g, b)| [r, g, b, 255]);
        Self {
            width,
            height,
            rgba: pixel.repeat(width as usize * height as usize),
        }
    }

    /// Red, green, blue and alpha of a pixel; x to the right, y down. Outside the picture: transparent.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 4] {
        if x >= self.width || y >= self.height {
            return [0; 4];
        }
        let at = 4 * (y as usize * self.width as usize + x as usize);
        [
            self.rgba[at],
            self.rgba[at + 1],
            self.rgba[at + 2],
            self.rgba[at + 3],
        ]
    }

    /// Whether no pixel lets anything through.
    #[must_use]
    pub fn is_opaque(&self) -> bool {
        self.rgba.chunks_exact(4).all(|pixel| pixel[3] == 255)
    }

    /// Red, green and blue alone, over white where the picture is transparent.
    #[must_use]
    pub fn rgb(&self) -> Vec<u8> {
        self.rgba
            .chunks_exact(4)
            .flat_map(|p| {
                let Colour(r, g, b) =
                    Colour::WHITE.mix(Colour(p[0], p[1], p[2]), f64::from(p[3]) / 255.0);
                [r, g, b]
            })
            .collect()
    }

    /// The picture as the bytes of a PNG file, with an alpha channel only if it needs one.
    ///
    /// # Errors
    /// If the encoder refuses, which it has no reason to.
    pub fn png(&self) -> Result<Vec<u8>, PictureError> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width, self.height);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_filter(png::FilterType::Paeth);
        let opaque = self.is_opaque();
        encoder.set_color(if opaque {
            png::ColorType::Rgb
        } else {
            png::ColorType::Rgba
        });
        let mut writer = encoder.write_header()?;
        if opaque {
            writer.write_image_data(&self.rgb())?;
        } else {
            writer.write_image_data(&self.rgba)?;
        }
        writer.finish()?;
        Ok(bytes)
    }

    /// Writes the picture as a PNG file, as a whole or not at all.
    ///
    /// # Errors
    /// If the system refuses.
    pub fn write_png(&self, path: &Path) -> Result<(), PictureError> {
        file::write_whole(path, &self.png()?)
    }

    /// Lays `colour` over a pixel; places outside the picture are passed over.
    fn blend(&mut self, x: i64, y: i64, colour: Colour, coverage: f64) {
        if let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y))
            && x < self.width
            && y < self.height
        {
            let at = 4 * (y as usize * self.width as usize + x as usize);
            let pixel: &mut [u8] = &mut self.rgba[at..at + 4];
            let below = f64::from(pixel[3]) / 255.0;
            let share = coverage.clamp(0.0, 1.0);
            // T. Porter and T. Duff, 1984: "over", not premultiplied.
            let alpha = share + below * (1.0 - share);
            if alpha > 0.0 {
                let Colour(r, g, b) =
                    Colour(pixel[0], pixel[1], pixel[2]).mix(colour, share / alpha);
                pixel.copy_from_slice(&[r, g, b, (alpha * 255.0 + 0.5) as u8]);
            }
        }
    }

    /// A straight line with round ends; each pixel is covered by its distance from the line.
    fn segment(&mut self, a: Spot, b: Spot, half_width: f64, colour: Colour) {
        let inside = |low: f64, high: f64, end: u32| {
            let low = (low - half_width - 1.0).floor().clamp(0.0, f64::from(end)) as i64;
            let high = (high + half_width + 1.0).ceil().clamp(0.0, f64::from(end)) as i64;
            low..high
        };
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let squared = dx * dx + dy * dy;
        for y in inside(a.1.min(b.1), a.1.max(b.1), self.height) {
            for x in inside(a.0.min(b.0), a.0.max(b.0), self.width) {
                let (px, py) = (x as f64 + 0.5 - a.0, y as f64 + 0.5 - a.1);
                let along = if squared > 0.0 {
                    ((px * dx + py * dy) / squared).clamp(0.0, 1.0)
                } else {
                    0.0
                };
                let distance = (px - along * dx).hypot(py - along * dy);
                // A line thinner than a pixel is as faint as it is thin.
                let coverage =
                    (half_width + 0.5 - distance).clamp(0.0, (2.0 * half_width).min(1.0));
                if coverage > 0.0 {
                    self.blend(x, y, colour, coverage);
                }
            }
        }
    }
}

impl Canvas for Image {
    fn polyline(&mut self, points: &[Spot], stroke: Stroke) {
        for pair in points.windows(2) {
            self.segment(pair[0], pair[1], 0.5 * stroke.width, stroke.colour);
        }
    }

    fn rectangle(&mut self, (x0, y0): Spot, (x1, y1): Spot, fill: Colour) {
        // Edges between pixels cover their share.
        let share = |low: f64, high: f64, at: i64| {
            (high.min(at as f64 + 1.0) - low.max(at as f64)).clamp(0.0, 1.0)
        };
        let range = |low: f64, high: f64, end: u32| {
            let end = f64::from(end);
            low.floor().clamp(0.0, end) as i64..high.ceil().clamp(0.0, end) as i64
        };
        for y in range(y0, y1, self.height) {
            for x in range(x0, x1, self.width) {
                self.blend(x, y, fill, share(x0, x1, x) * share(y0, y1, y));
            }
        }
    }

    fn disc(&mut self, centre: Spot, radius: f64, fill: Colour) {
        self.segment(centre, centre, radius, fill);
    }

    fn text(&mut self, text: &str, (x, y): Spot, lettering: Lettering) {
        let text = font::printable(text);
        let back = lettering.anchor.share() * font::width(&text, lettering.size);
        let (left, line) = if lettering.upright {
            (x.round() as i64, (y + back).round() as i64)
        } else {
            ((x - back).round() as i64, y.round() as i64)
        };
        font::rasterise(&text, lettering.size, |dx, dy, coverage| {
            let (dx, dy) = (i64::from(dx), i64::from(dy));
            let (x, y) = if lettering.upright {
                (left + dy, line - 1 - dx)
            } else {
                (left + dx, line + dy)
            };
            self.blend(x, y, lettering.colour, coverage);
        });
    }
}

impl Anchor {
    /// The share of a text that lies before its spot.
    pub(crate) fn share(self) -> f64 {
        match self {
            Self::Start => 0.0,
            Self::Middle => 0.5,
            Self::End => 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn over_on_paper_and_on_nothing() {
        let mut paper = Image::new(1, 1, Some(Colour(100, 100, 100)));
        paper.blend(0, 0, Colour(200, 0, 100), 0.25);
        // 100 + (200 - 100) / 4, 100 - 100 / 4.
        assert_eq!(paper.pixel(0, 0), [125, 75, 100, 255]);
        let mut nothing = Image::new(1, 1, None);
        nothing.blend(0, 0, Colour(200, 0, 100), 0.25);
        assert_eq!(nothing.pixel(0, 0), [200, 0, 100, 64]);
        nothing.blend(5, -1, Colour(1, 1, 1), 1.0);
        assert_eq!(nothing.pixel(9, 9), [0; 4]);
    }

    #[test]
    fn png_holds_alpha_only_where_there_is_some() {
        for (paper, colour, bytes) in [
            (Some(Colour(1, 2, 3)), png::ColorType::Rgb, vec![1, 2, 3]),
            (None, png::ColorType::Rgba, vec![0; 4]),
        ] {
            let image = Image::new(1, 1, paper);
            let png = image.png().unwrap();
            let mut reader = png::Decoder::new(png.as_slice()).read_info().unwrap();
            let mut buffer = vec![0; reader.output_buffer_size()];
            let info = reader.next_frame(&mut buffer).unwrap();
            assert_eq!((info.color_type, buffer), (colour, bytes));
        }
    }

    #[test]
    fn a_line_is_as_wide_as_asked() {
        for width in [0.4, 1.0, 3.0] {
            let mut image = Image::new(60, 40, Some(Colour::WHITE));
            let stroke = Stroke::solid(Colour(0, 0, 0), width);
            image.polyline(&[(5.0, 20.3), (55.0, 20.3)], stroke);
            let darkness: f64 = (0..40)
                .map(|y| 1.0 - f64::from(image.pixel(30, y)[0]) / 255.0)
                .sum();
            // Thin lines: each of two rows may lose to the cap on faintness.
            assert!((darkness - width).abs() < 0.25, "{width}: {darkness}");
        }
    }
}
