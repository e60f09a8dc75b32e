//! Films: pictures that follow each other in one file.
//!
//! `palette` finds the 255 colours that a GIF may have at a time, `changes` what differs from the picture before.

mod apng;
mod changes;
mod gif;
mod palette;

pub use apng::Apng;
pub use gif::Gif;

use crate::PictureError;
use crate::image::Image;

/// Delay (s) of each picture of a film, so that pictures follow each other as the times (s) of the frames do and the film takes
/// `duration` (s) in all. The last one stands as long as those before on average.
#[must_use]
pub fn delays(times: &[f64], duration: f64) -> Vec<f64> {
    let number = times.len();
    let even = vec![duration / number.max(1) as f64; number];
    let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let span: f64 = steps.iter().sum();
    if !(span.is_finite() && span > 0.0) || steps.iter().any(|step| *step < 0.0) {
        return even;
    }
    steps.push(span / steps.len() as f64);
    let all: f64 = steps.iter().sum();
    steps.iter().map(|step| step / all * duration).collect()
}

/// The size of a film's pictures, and how many there were.
#[derive(Debug, Clone, Copy, Default)]
struct Sizes {
    first: Option<(u32, u32)>,
    number: usize,
}

impl Sizes {
    fn take(&mut self, image: &Image) -> Result<(), PictureError> {
        self.number += 1;
        let (first_width, first_height) = *self.first.get_or_insert((image.width, image.height));
        if (image.width, image.height) == (first_width, first_height) {
            return Ok(());
        }
        Err(PictureError::Sizes {
            number: self.number,
            width: image.width,
            height: image.height,
            first_width,
            first_height,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delays_follow_the_times() {
        // Steps of 1, 3 and, on average, 2 s: 6 s of run in 12 s of film.
        assert_eq!(delays(&[0.0, 1.0, 4.0], 12.0), [2.0, 6.0, 4.0]);
        assert_eq!(delays(&[0.0, 0.0], 1.0), [0.5, 0.5]);
        assert_eq!(delays(&[3.0, f64::NAN, 1.0], 3.0), [1.0, 1.0, 1.0]);
        assert_eq!(delays(&[7.0], 2.0), [2.0]);
        assert!(delays(&[], 2.0).is_empty());
    }
}
