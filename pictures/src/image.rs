//! A picture as pixels: what is drawn on, and what becomes a file.

use std::path::Path;

use ab_glyph_rasterizer::{Rasterizer, point};

use crate::PictureError;
use crate::canvas::{Anchor, Canvas, Lettering, Spot, Stroke};
use crate::colour::Colour;
use crate::font;
use mercury_common::whole_file::write_whole;

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
        Ok(write_whole(path, &self.png()?)?)
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

    /// A line with round ends through pieces; each pixel is covered by its distance from the nearest of them, so that where
    /// pieces meet nothing is painted twice.
    fn stroke(&mut self, pieces: &[(Spot, Spot)], half_width: f64, colour: Colour) {
        let reach = half_width + 1.0;
        let Some(region) = Region::around(pieces.iter().flat_map(|(a, b)| [*a, *b]), reach, self)
        else {
            return;
        };
        let mut covered = vec![0.0_f32; region.width * region.height];
        for (a, b) in pieces {
            region.cover(&mut covered, *a, *b, half_width);
        }
        for (row, line) in covered.chunks_exact(region.width).enumerate() {
            for (column, coverage) in line.iter().enumerate() {
                if *coverage > 0.0 {
                    let (x, y) = (region.left + column as i64, region.top + row as i64);
                    self.blend(x, y, colour, f64::from(*coverage));
                }
            }
        }
    }

    /// A canvas whose points are `factor` pixels of this picture.
    pub(crate) fn enlarged(&mut self, factor: f64) -> Enlarged<'_> {
        Enlarged {
            image: self,
            factor,
        }
    }
}

/// The pixels of a picture that something may touch.
struct Region {
    left: i64,
    top: i64,
    width: usize,
    height: usize,
}

impl Region {
    /// Pixels within `reach` of a box around `spots`; none: outside the picture.
    fn around(spots: impl Iterator<Item = Spot>, reach: f64, image: &Image) -> Option<Self> {
        let ends = spots.fold(None, |ends: Option<[f64; 4]>, (x, y)| {
            let [x0, y0, x1, y1] = ends.unwrap_or([x, y, x, y]);
            Some([x0.min(x), y0.min(y), x1.max(x), y1.max(y)])
        });
        let [x0, y0, x1, y1] = ends?;
        let from = |low: f64, end: u32| (low - reach).floor().clamp(0.0, f64::from(end));
        let to = |high: f64, end: u32| (high + reach).ceil().clamp(0.0, f64::from(end));
        let (left, top) = (from(x0, image.width), from(y0, image.height));
        let (right, bottom) = (to(x1, image.width), to(y1, image.height));
        (right > left && bottom > top).then_some(Self {
            left: left as i64,
            top: top as i64,
            width: (right - left) as usize,
            height: (bottom - top) as usize,
        })
    }

    /// Raises the coverage of each pixel to that by a straight line with round ends.
    fn cover(&self, covered: &mut [f32], a: Spot, b: Spot, half_width: f64) {
        let (ax, ay) = (a.0 - self.left as f64, a.1 - self.top as f64);
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let squared = dx * dx + dy * dy;
        let reach = half_width + 1.0;
        let range = |low: f64, high: f64, end: usize| {
            let low = (low - reach).floor().clamp(0.0, end as f64) as usize;
            let high = (high + reach).ceil().clamp(0.0, end as f64) as usize;
            low..high
        };
        for y in range(ay.min(ay + dy), ay.max(ay + dy), self.height) {
            let py = y as f64 + 0.5 - ay;
            // Only the part of the line near this row can touch it.
            let (first, last) = if dy == 0.0 {
                (0.0, 1.0)
            } else {
                let (s, t) = ((py - reach) / dy, (py + reach) / dy);
                (s.min(t).clamp(0.0, 1.0), s.max(t).clamp(0.0, 1.0))
            };
            let (x0, x1) = (ax + first * dx, ax + last * dx);
            for x in range(x0.min(x1), x0.max(x1), self.width) {
                let px = x as f64 + 0.5 - ax;
                let along = if squared > 0.0 {
                    ((px * dx + py * dy) / squared).clamp(0.0, 1.0)
                } else {
                    0.0
                };
                let distance = (px - along * dx).hypot(py - along * dy);
                // A line thinner than a pixel is as faint as it is thin.
                let coverage =
                    (half_width + 0.5 - distance).clamp(0.0, (2.0 * half_width).min(1.0)) as f32;
                let pixel = &mut covered[y * self.width + x];
                *pixel = pixel.max(coverage);
            }
        }
    }
}

impl Canvas for Image {
    fn polyline(&mut self, points: &[Spot], stroke: Stroke) {
        let pieces: Vec<(Spot, Spot)> = if stroke.dashes.is_empty() {
            points.windows(2).map(|pair| (pair[0], pair[1])).collect()
        } else {
            dashed(points, stroke.dashes)
        };
        self.stroke(&pieces, 0.5 * stroke.width, stroke.colour);
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
        self.stroke(&[(centre, centre)], radius, fill);
    }

    fn area(&mut self, corners: &[Spot], fill: Colour, opacity: f64) {
        let Some(region) = Region::around(corners.iter().copied(), 0.0, self) else {
            return;
        };
        // Beyond the picture a corner stands at its edge.
        let local = |(x, y): Spot| {
            point(
                (x - region.left as f64).clamp(0.0, region.width as f64) as f32,
                (y - region.top as f64).clamp(0.0, region.height as f64) as f32,
            )
        };
        let mut rasterizer = Rasterizer::new(region.width, region.height);
        for (place, corner) in corners.iter().enumerate() {
            let next = corners[(place + 1) % corners.len()];
            rasterizer.draw_line(local(*corner), local(next));
        }
        rasterizer.for_each_pixel_2d(|x, y, coverage| {
            // Sums in f32 leave dust where nothing is.
            if coverage > 1e-3 {
                let (x, y) = (region.left + i64::from(x), region.top + i64::from(y));
                self.blend(x, y, fill, f64::from(coverage) * opacity);
            }
        });
    }

    fn cells(&mut self, cells: &[(Spot, Spot, Colour)]) {
        let whole = |(x, y): Spot| (x.round(), y.round());
        for (upper_left, lower_right, fill) in cells {
            self.rectangle(whole(*upper_left), whole(*lower_right), *fill);
        }
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

/// A picture drawn on in points that are several pixels large.
pub(crate) struct Enlarged<'a> {
    image: &'a mut Image,
    factor: f64,
}

impl Enlarged<'_> {
    fn spot(&self, (x, y): Spot) -> Spot {
        (x * self.factor, y * self.factor)
    }
}

impl Canvas for Enlarged<'_> {
    fn polyline(&mut self, points: &[Spot], stroke: Stroke) {
        let points: Vec<Spot> = points.iter().map(|point| self.spot(*point)).collect();
        let pieces: Vec<(Spot, Spot)> = if stroke.dashes.is_empty() {
            points.windows(2).map(|pair| (pair[0], pair[1])).collect()
        } else {
            let dashes: Vec<f64> = stroke.dashes.iter().map(|d| d * self.factor).collect();
            dashed(&points, &dashes)
        };
        (self.image).stroke(&pieces, 0.5 * self.factor * stroke.width, stroke.colour);
    }

    fn rectangle(&mut self, upper_left: Spot, lower_right: Spot, fill: Colour) {
        let (a, b) = (self.spot(upper_left), self.spot(lower_right));
        self.image.rectangle(a, b, fill);
    }

    fn disc(&mut self, centre: Spot, radius: f64, fill: Colour) {
        let centre = self.spot(centre);
        self.image.disc(centre, radius * self.factor, fill);
    }

    fn area(&mut self, corners: &[Spot], fill: Colour, opacity: f64) {
        let corners: Vec<Spot> = corners.iter().map(|corner| self.spot(*corner)).collect();
        self.image.area(&corners, fill, opacity);
    }

    fn cells(&mut self, cells: &[(Spot, Spot, Colour)]) {
        let cells: Vec<_> = (cells.iter())
            .map(|(a, b, fill)| (self.spot(*a), self.spot(*b), *fill))
            .collect();
        self.image.cells(&cells);
    }

    fn text(&mut self, text: &str, at: Spot, lettering: Lettering) {
        let size = lettering.size * self.factor;
        (self.image).text(text, self.spot(at), Lettering { size, ..lettering });
    }
}

/// The pieces of a line that its dashes leave: `points` cut at the lengths of `dashes`, every second one kept.
fn dashed(points: &[Spot], dashes: &[f64]) -> Vec<(Spot, Spot)> {
    let mut pieces = Vec::new();
    let (mut which, mut left) = (0, dashes[0]);
    for pair in points.windows(2) {
        let (mut from, to) = (pair[0], pair[1]);
        loop {
            let length = (to.0 - from.0).hypot(to.1 - from.1);
            let ends_here = length <= left;
            let share = left / length;
            let end = if ends_here {
                to
            } else {
                (
                    from.0 + share * (to.0 - from.0),
                    from.1 + share * (to.1 - from.1),
                )
            };
            if which % 2 == 0 {
                pieces.push((from, end));
            }
            if ends_here {
                left -= length;
                break;
            }
            from = end;
            which = (which + 1) % dashes.len();
            left = dashes[which];
        }
    }
    pieces
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
    fn dashes_cover_their_share_of_a_bent_line() {
        let pieces = dashed(&[(0.0, 0.0), (30.0, 0.0), (30.0, 70.0)], &[6.0, 4.0]);
        let length: f64 = (pieces.iter())
            .map(|(a, b)| (b.0 - a.0).hypot(b.1 - a.1))
            .sum();
        // 100 points of line, 6 of every 10 drawn.
        assert!((length - 60.0).abs() < 1e-9, "{length}");
    }

    #[test]
    fn an_area_is_as_large_and_as_faint_as_requested() {
        let mut image = Image::new(40, 40, Some(Colour::WHITE));
        let corners = [(5.5, 5.5), (25.5, 5.5), (5.5, 30.5)];
        image.area(&corners, Colour(0, 0, 0), 0.5);
        let darkness: f64 = (0..1600)
            .map(|i| 1.0 - f64::from(image.pixel(i % 40, i / 40)[0]) / 255.0)
            .sum();
        // Half of 20 x 25 / 2, less what rounding to 8 bits takes.
        assert!((darkness - 125.0).abs() < 1.0, "{darkness}");
    }

    #[test]
    fn many_short_pieces_look_like_one_long_line() {
        let draw = |points: &[Spot]| {
            let mut image = Image::new(60, 40, Some(Colour::WHITE));
            image.polyline(points, Stroke::solid(Colour(0, 0, 0), 1.5));
            image
        };
        let many: Vec<Spot> = (0..=500)
            .map(|i| (5.0 + 0.1 * f64::from(i), 10.0 + 0.03 * f64::from(i)))
            .collect();
        let (one, many) = (draw(&[many[0], many[500]]), draw(&many));
        let apart = one
            .rgba
            .iter()
            .zip(&many.rgba)
            .map(|(a, b)| a.abs_diff(*b))
            .max();
        assert!(apart <= Some(1), "{apart:?}");
    }

    #[test]
    fn a_line_is_as_wide_as_requested() {
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
