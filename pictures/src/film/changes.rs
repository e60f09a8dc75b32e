//! Differences between two pictures of a film.

use crate::image::Image;

/// A rectangle of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Part {
    pub(super) x: u32,
    pub(super) y: u32,
    pub(super) width: u32,
    pub(super) height: u32,
}

impl Part {
    pub(super) fn whole(image: &Image) -> Self {
        Self {
            x: 0,
            y: 0,
            width: image.width,
            height: image.height,
        }
    }

    /// The smallest rectangle that holds every pixel that differs; one pixel where none does.
    pub(super) fn changed(before: &Image, now: &Image) -> Self {
        let row_bytes = 4 * now.width as usize;
        let (mut x0, mut x1, mut y0, mut y1) = (u32::MAX, 0, u32::MAX, 0);
        let rows = before
            .rgba
            .chunks_exact(row_bytes)
            .zip(now.rgba.chunks_exact(row_bytes));
        for (y, (a, b)) in (0..).zip(rows) {
            if a == b {
                continue;
            }
            let differs = |(a, b): (&[u8], &[u8])| a != b;
            let mut pixels = a.chunks_exact(4).zip(b.chunks_exact(4));
            let first = pixels.clone().position(differs).unwrap_or(0) as u32;
            let last = pixels.rposition(differs).unwrap_or(0) as u32;
            (x0, x1) = (x0.min(first), x1.max(last + 1));
            (y0, y1) = (y0.min(y), y + 1);
        }
        if x0 >= x1 {
            (x0, x1, y0, y1) = (0, 1, 0, 1);
        }
        Self {
            x: x0,
            y: y0,
            width: x1 - x0,
            height: y1 - y0,
        }
    }

    /// The bytes of the pixels, four each, row by row.
    pub(super) fn pixels<'a>(&self, image: &'a Image) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        let row_bytes = 4 * image.width as usize;
        let (from, number) = (4 * self.x as usize, 4 * self.width as usize);
        image
            .rgba
            .chunks_exact(row_bytes)
            .skip(self.y as usize)
            .take(self.height as usize)
            .flat_map(move |row| row[from..from + number].chunks_exact(4))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rectangle_of_two_changed_pixels() {
        let before = Image::new(9, 7, None);
        let mut now = before.clone();
        assert_eq!(
            Part::changed(&before, &now),
            Part {
                x: 0,
                y: 0,
                width: 1,
                height: 1
            }
        );
        now.rgba[4 * (2 * 9 + 5)] = 1;
        now.rgba[4 * (4 * 9 + 3) + 3] = 1;
        let part = Part::changed(&before, &now);
        assert_eq!(
            part,
            Part {
                x: 3,
                y: 2,
                width: 3,
                height: 3
            }
        );
        let changed: Vec<usize> = (part.pixels(&now).enumerate())
            .filter(|(_, pixel)| *pixel != [0; 4])
            .map(|(place, _)| place)
            .collect();
        assert_eq!(changed, [2, 6]);
    }
}
