//! The page as pixels: drawn at twice the size, averaged down, written as PNG.

use crate::PictureError;
use crate::canvas::{Anchor, Canvas, HEIGHT, Lettering, Spot, Stroke, WIDTH};
use crate::colour::Colour;
use crate::font;
use rayon::prelude::*;

/// Drawn pixels per point along each axis; their average smooths every edge.
pub(super) const SAMPLES: usize = 2;

const COLUMNS: usize = WIDTH as usize * SAMPLES;
const ROWS: usize = HEIGHT as usize * SAMPLES;

/// A page of pixels.
pub(super) struct Raster {
    pixels: Vec<Colour>,
}

impl Raster {
    /// A white page.
    pub(super) fn new() -> Self {
        Self {
            pixels: vec![Colour::WHITE; COLUMNS * ROWS],
        }
    }

    /// The rows of fine pixels from `first` on, for painting them side by side.
    pub(super) fn rows_from(
        &mut self,
        first: usize,
    ) -> impl IndexedParallelIterator<Item = &mut [Colour]> {
        self.pixels[first * COLUMNS..].par_chunks_mut(COLUMNS)
    }

    fn row(&mut self, row: usize) -> &mut [Colour] {
        &mut self.pixels[row * COLUMNS..(row + 1) * COLUMNS]
    }

    fn blend(&mut self, x: i64, y: i64, colour: Colour, coverage: f64) {
        if let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y))
            && x < COLUMNS
            && y < ROWS
        {
            let pixel = &mut self.pixels[y * COLUMNS + x];
            *pixel = pixel.mix(colour, coverage);
        }
    }

    /// Fills every fine pixel by `coverage(distance)`, the distance of its centre from the segment a-b.
    fn segment(&mut self, a: Spot, b: Spot, half_width: f64, colour: Colour) {
        let scale = SAMPLES as f64;
        let (ax, ay, bx, by) = (a.0 * scale, a.1 * scale, b.0 * scale, b.1 * scale);
        let reach = half_width * scale;
        let inside = |low: f64, high: f64, end: usize| {
            let low = (low - reach - 1.0).floor().clamp(0.0, end as f64) as i64;
            let high = (high + reach + 1.0).ceil().clamp(0.0, end as f64) as i64;
            low..high
        };
        let (dx, dy) = (bx - ax, by - ay);
        let squared = dx * dx + dy * dy;
        for y in inside(ay.min(by), ay.max(by), ROWS) {
            for x in inside(ax.min(bx), ax.max(bx), COLUMNS) {
                let (px, py) = (x as f64 + 0.5 - ax, y as f64 + 0.5 - ay);
                let along = if squared > 0.0 {
                    ((px * dx + py * dy) / squared).clamp(0.0, 1.0)
                } else {
                    0.0
                };
                let distance = (px - along * dx).hypot(py - along * dy);
                let coverage = (reach + 0.5 - distance).clamp(0.0, 1.0);
                if coverage > 0.0 {
                    self.blend(x, y, colour, coverage);
                }
            }
        }
    }

    /// The page at one pixel per point, three bytes each, row by row.
    fn averaged(&self) -> Vec<u8> {
        let (width, height) = (COLUMNS / SAMPLES, ROWS / SAMPLES);
        let mut bytes = Vec::with_capacity(3 * width * height);
        for y in 0..height {
            for x in 0..width {
                let mut sum = [0u32; 3];
                for line in 0..SAMPLES {
                    let start = (y * SAMPLES + line) * COLUMNS + x * SAMPLES;
                    for Colour(red, green, blue) in &self.pixels[start..start + SAMPLES] {
                        sum[0] += u32::from(*red);
                        sum[1] += u32::from(*green);
                        sum[2] += u32::from(*blue);
                    }
                }
                let number = (SAMPLES * SAMPLES) as u32;
                bytes.extend(sum.map(|s| ((s + number / 2) / number) as u8));
            }
        }
        bytes
    }

    /// The page as the bytes of a PNG file.
    pub(super) fn png(&self) -> Result<Vec<u8>, PictureError> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, WIDTH as u32, HEIGHT as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_filter(png::FilterType::Paeth);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.averaged())?;
        writer.finish()?;
        Ok(bytes)
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

impl Canvas for Raster {
    fn polyline(&mut self, points: &[Spot], stroke: Stroke) {
        let half = 0.5 * stroke.width;
        if stroke.dashes.is_empty() {
            for pair in points.windows(2) {
                self.segment(pair[0], pair[1], half, stroke.colour);
            }
        } else {
            for (from, to) in dashed(points, stroke.dashes) {
                self.segment(from, to, half, stroke.colour);
            }
        }
    }

    fn rectangle(&mut self, (x0, y0): Spot, (x1, y1): Spot, fill: Colour) {
        let fine = |value: f64, end: usize| {
            (value * SAMPLES as f64).round().clamp(0.0, end as f64) as usize
        };
        for y in fine(y0, ROWS)..fine(y1, ROWS) {
            let (from, to) = (fine(x0, COLUMNS), fine(x1, COLUMNS));
            self.row(y)[from..to.max(from)].fill(fill);
        }
    }

    fn disc(&mut self, centre: Spot, radius: f64, fill: Colour) {
        self.segment(centre, centre, radius, fill);
    }

    fn area(&mut self, _: &[Spot], _: Colour, _: f64) {}

    fn cells(&mut self, _: &[(Spot, Spot, Colour)]) {}

    fn text(&mut self, text: &str, (x, y): Spot, lettering: Lettering) {
        let scale = SAMPLES as f64;
        let size = lettering.size * scale;
        let text = font::printable(text);
        let back = match lettering.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => 0.5,
            Anchor::End => 1.0,
        } * font::width(&text, size);
        let (x, y) = (x * scale, y * scale);
        if lettering.upright {
            let (x, y) = (x.round() as i64, (y + back).round() as i64);
            font::rasterise(&text, size, |dx, dy, coverage| {
                self.blend(
                    x + i64::from(dy),
                    y - 1 - i64::from(dx),
                    lettering.colour,
                    coverage,
                );
            });
        } else {
            let (x, y) = ((x - back).round() as i64, y.round() as i64);
            font::rasterise(&text, size, |dx, dy, coverage| {
                self.blend(
                    x + i64::from(dx),
                    y + i64::from(dy),
                    lettering.colour,
                    coverage,
                );
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dashes_cover_their_share_of_a_bent_line() {
        let pieces = dashed(&[(0.0, 0.0), (30.0, 0.0), (30.0, 70.0)], &[6.0, 4.0]);
        let length: f64 = pieces
            .iter()
            .map(|(a, b)| (b.0 - a.0).hypot(b.1 - a.1))
            .sum();
        // 100 points of line, 6 of every 10 drawn.
        assert!((length - 60.0).abs() < 1e-9, "{length}");
    }

    #[test]
    fn a_line_is_as_wide_as_asked() {
        let mut page = Raster::new();
        page.polyline(
            &[(100.0, 50.0), (200.0, 50.0)],
            Stroke::solid(Colour(0, 0, 0), 3.0),
        );
        let bytes = page.averaged();
        let darkness: f64 = (40..60)
            .map(|y| 1.0 - f64::from(bytes[3 * (y * WIDTH as usize + 150)]) / 255.0)
            .sum();
        assert!((darkness - 3.0).abs() < 0.1, "{darkness}");
    }
}
