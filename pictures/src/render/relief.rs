//! The mean depth around each pixel: what lies deeper than its surroundings is a crevice, and darker.

use rayon::prelude::*;

use super::SAMPLES;
use super::opaque::Opaque;

/// Mean depths, one for each pixel of the window.
pub(super) struct Relief {
    columns: usize,
    mean: Vec<f32>,
    /// Half the side (samples) of the square that the mean is taken over.
    pub(super) reach: f64,
}

/// Sum of depths and number of samples.
type Sum = (f64, f64);

impl Relief {
    /// Means over squares of about `2 reach` samples.
    pub(super) fn new(opaque: &Opaque, reach: f64) -> Self {
        let (columns, rows) = (opaque.columns / SAMPLES, opaque.rows / SAMPLES);
        let wide = ((reach / SAMPLES as f64).round() as usize).max(1);
        // Separable running sums: the cost does not depend on the reach. Along rows first, written transposed, so that the
        // second pass is the same again.
        let across: Vec<Vec<Sum>> = (0..rows)
            .into_par_iter()
            .map(|row| running(columns, wide, |column| pixel(opaque, column, row)))
            .collect();
        let down: Vec<Vec<Sum>> = (0..columns)
            .into_par_iter()
            .map(|column| running(rows, wide, |row| across[row][column]))
            .collect();
        let mean = (0..rows)
            .into_par_iter()
            .flat_map_iter(|row| {
                down.iter()
                    .map(move |line| (line[row].0 / line[row].1.max(1.0)) as f32)
            })
            .collect();
        Self {
            columns,
            mean,
            reach,
        }
    }

    /// The mean depth around a sample.
    pub(super) fn mean(&self, column: usize, row: usize) -> f64 {
        f64::from(self.mean[row / SAMPLES * self.columns + column / SAMPLES])
    }
}

/// Sum of the depths of a pixel's samples that show something, and their number.
fn pixel(opaque: &Opaque, column: usize, row: usize) -> Sum {
    let mut sum = (0.0, 0.0);
    for line in 0..SAMPLES {
        let start = (row * SAMPLES + line) * opaque.columns + column * SAMPLES;
        for depth in &opaque.depth[start..start + SAMPLES] {
            if depth.is_finite() {
                sum.0 += f64::from(*depth);
                sum.1 += 1.0;
            }
        }
    }
    sum
}

/// For each of `number` places the sum over those at most `wide` away.
fn running(number: usize, wide: usize, value: impl Fn(usize) -> Sum) -> Vec<Sum> {
    let mut sums = Vec::with_capacity(number);
    let values: Vec<Sum> = (0..number).map(value).collect();
    let mut sum = (0.0, 0.0);
    for place in 0..number + wide {
        if let Some(new) = values.get(place) {
            sum = (sum.0 + new.0, sum.1 + new.1);
        }
        if let Some(old) = place.checked_sub(2 * wide + 1).map(|old| values[old]) {
            sum = (sum.0 - old.0, sum.1 - old.1);
        }
        if place >= wide {
            sums.push(sum);
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn running_sums_are_sums() {
        let sums = running(6, 2, |place| (place as f64, 1.0));
        // 0+1+2, 0+1+2+3, 0+..+4, 1+..+5, 2+..+5, 3+4+5.
        let expected = [
            (3.0, 3.0),
            (6.0, 4.0),
            (10.0, 5.0),
            (15.0, 5.0),
            (14.0, 4.0),
            (12.0, 3.0),
        ];
        assert_eq!(sums, expected);
        assert_eq!(running(2, 9, |_| (1.0, 1.0)), [(2.0, 2.0); 2]);
    }
}
