//! Averages over frames and how sure they are.

use crate::analysis::words::{Reader, Words};

/// Standard errors of the mean of correlated samples by blocking (Flyvbjerg & Petersen, *J. Chem. Phys.* 91, 461, 1989).
///
/// Pairs of samples are merged to blocks, pairs of blocks to larger ones, and so on. Neighbouring frames resemble each other, so the error
/// estimated from single frames is too small; it grows with the size of the blocks until these are independent. The largest error
/// over all sizes of which there are at least eight blocks is taken.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Blocking {
    levels: Vec<Level>,
}

#[derive(Debug, Clone, Default, PartialEq)]
struct Level {
    waiting: Option<Vec<f64>>,
    count: usize,
    mean: Vec<f64>,
    /// Sum of squared distances from the mean.
    spread: Vec<f64>,
}

/// Fewest blocks from which an error is estimated, unless there are no smaller blocks.
const FEWEST: usize = 8;

impl Level {
    fn add(&mut self, sample: &[f64]) {
        if self.count == 0 {
            self.mean = vec![0.0; sample.len()];
            self.spread = vec![0.0; sample.len()];
        }
        self.count += 1;
        let count = self.count as f64;
        for ((mean, spread), value) in self.mean.iter_mut().zip(&mut self.spread).zip(sample) {
            let before = value - *mean;
            *mean += before / count;
            *spread += before * (value - *mean);
        }
    }
}

impl Blocking {
    /// Adds the values of a frame.
    pub fn add(&mut self, sample: Vec<f64>) {
        let mut sample = sample;
        for level in 0.. {
            if level == self.levels.len() {
                self.levels.push(Level::default());
            }
            let level = &mut self.levels[level];
            level.add(&sample);
            match level.waiting.take() {
                None => {
                    level.waiting = Some(sample);
                    return;
                }
                Some(first) => {
                    for (value, first) in sample.iter_mut().zip(first) {
                        *value = 0.5 * (*value + first);
                    }
                }
            }
        }
    }

    pub(crate) fn put(&self, words: &mut Words) {
        words.count(self.levels.len());
        for level in &self.levels {
            words.count(level.count);
            words.flag(level.waiting.is_some());
            let waiting = level.waiting.iter();
            for values in waiting.chain([&level.mean, &level.spread]) {
                words.numbers(values);
            }
        }
    }

    /// Reads the blocks of samples of so many numbers.
    pub(crate) fn take(words: &mut Reader<'_>, numbers: usize) -> Option<Self> {
        let levels = words.count()?;
        let level = |words: &mut Reader<'_>| {
            let count = words.count()?;
            let waiting = match words.flag()? {
                true => Some(words.numbers(numbers)?),
                false => None,
            };
            Some(Level {
                waiting,
                count,
                mean: words.numbers(numbers)?,
                spread: words.numbers(numbers)?,
            })
        };
        // One word at least of each: a wrong number ends with the words.
        let levels: Option<Vec<Level>> = (0..levels).map(|_| level(words)).collect();
        levels.map(|levels| Self { levels })
    }

    /// The number of frames.
    #[must_use]
    pub fn count(&self) -> usize {
        self.levels.first().map_or(0, |level| level.count)
    }

    /// The standard error of the mean of each value; nothing from fewer than two frames.
    #[must_use]
    pub fn errors(&self) -> Option<Vec<f64>> {
        let first = self.levels.first().filter(|level| level.count > 1)?;
        let mut errors = vec![0.0f64; first.mean.len()];
        for (k, level) in self.levels.iter().enumerate() {
            if level.count < 2 || (k > 0 && level.count < FEWEST) {
                break;
            }
            let degrees = (level.count - 1) as f64 * level.count as f64;
            for (error, spread) in errors.iter_mut().zip(&level.spread) {
                *error = error.max((spread / degrees).sqrt());
            }
        }
        Some(errors)
    }
}

#[cfg(test)]
mod tests {
    use mercury_common::random::Stream;

    use super::*;

    #[test]
    fn two_frames_have_half_their_distance_as_error() {
        let mut blocking = Blocking::default();
        assert_eq!(blocking.errors(), None);
        blocking.add(vec![1.0, 4.0]);
        assert_eq!(blocking.errors(), None);
        blocking.add(vec![3.0, 4.0]);
        // s = sqrt(2), error = s / sqrt(2).
        assert_eq!(blocking.errors(), Some(vec![1.0, 0.0]));
    }

    /// An autoregressive series x_k = a x_(k-1) + noise: the error of its mean is known.
    #[test]
    fn correlated_samples_have_larger_errors() {
        let (a, count) = (0.9, 4096);
        let mut stream = Stream::new(1, "blocking", 0);
        let mut blocking = Blocking::default();
        let mut x = 0.0;
        for _ in 0..count {
            x = a * x + stream.uniform_in(-0.5, 0.5);
            blocking.add(vec![x]);
        }
        // Variance of the noise 1/12; of the mean of n: 1/12 / (n (1 - a)^2).
        let expected = (1.0f64 / 12.0 / count as f64).sqrt() / (1.0 - a);
        let found = blocking.errors().unwrap()[0];
        // Eight blocks at the top level: their error is known to within about a quarter, and the largest level is taken.
        assert!(
            found / expected > 0.7 && found / expected < 1.8,
            "{found} {expected}"
        );
        let naive = (1.0f64 / 12.0 / (1.0 - a * a) / count as f64).sqrt();
        assert!(found > 2.0 * naive, "{found} {naive}");
    }
}
