//! Which sphere each pixel shows, how deep it lies there, and how bright it is.

use super::camera::{Camera, Seen, SeenSphere};
use super::raster::{Raster, SAMPLES};
use crate::colour::Colour;
use rayon::prelude::*;

/// Owner of a pixel that shows no sphere.
const NOBODY: u32 = u32::MAX;
/// Rows that one task fills.
const BAND: usize = 64;
/// Spheres are never drawn smaller than this (fine pixels), so that dust among boulders stays visible.
const SMALLEST_RADIUS: f64 = 0.75;
/// Light without direction, and light of the lamp.
const AMBIENT: f64 = 0.44;
const LAMP: f64 = 0.56;
/// How far the lamp reaches round the terminator, as a cosine: a soft lamp leaves no hard edge of shadow.
const WRAP: f64 = 0.35;
/// Direction to the lamp: right, up, towards the eye; of unit length.
const TO_LAMP: [f64; 3] = [-0.424, 0.566, 0.707];
/// Share of the background mixed into the farthest sphere.
const HAZE: f64 = 0.22;
/// Strength of the shade that nearer things cast on what lies close behind them in the picture.
const CREVICE: f64 = 0.5;

/// The nearest sphere of every fine pixel of the camera's window.
pub(super) struct DepthBuffer {
    columns: usize,
    rows: usize,
    /// First fine column and row of the window on the page.
    origin: (usize, usize),
    /// Place in the list of seen spheres.
    owner: Vec<u32>,
    /// Depth in fine pixels, infinite where there is nobody.
    depth: Vec<f32>,
}

impl DepthBuffer {
    /// Draws `spheres`, the nearest first, as seen by `camera`.
    pub(super) fn new(camera: &Camera, spheres: &[SeenSphere]) -> Self {
        let fine = SAMPLES as f64;
        let window = camera.window();
        let origin = (
            (window.upper_left.0 * fine).round() as usize,
            (window.upper_left.1 * fine).round() as usize,
        );
        let columns = (window.width() * fine).round().max(1.0) as usize;
        let rows = (window.height() * fine).round().max(1.0) as usize;
        let mut owner = vec![NOBODY; columns * rows];
        let mut depth = vec![f32::INFINITY; columns * rows];
        owner
            .par_chunks_mut(columns * BAND)
            .zip(depth.par_chunks_mut(columns * BAND))
            .enumerate()
            .for_each(|(band, (owner, depth))| {
                let first = band * BAND;
                let last = first + owner.len() / columns;
                for (place, sphere) in spheres.iter().enumerate() {
                    let radius = (sphere.radius * fine).max(SMALLEST_RADIUS);
                    // Pixel centres lie at halves.
                    let x = sphere.at.x * fine - origin.0 as f64 - 0.5;
                    let y = sphere.at.y * fine - origin.1 as f64 - 0.5;
                    let centre = sphere.at.depth * fine;
                    let top = (y - radius).ceil().max(first as f64) as usize;
                    let bottom = ((y + radius).floor() + 1.0).clamp(0.0, last as f64) as usize;
                    for row in top..bottom {
                        let dy = row as f64 - y;
                        let half = (radius * radius - dy * dy).max(0.0).sqrt();
                        let left = (x - half).ceil().max(0.0) as usize;
                        let right = ((x + half).floor() + 1.0).clamp(0.0, columns as f64) as usize;
                        let line = (row - first) * columns;
                        for column in left..right {
                            let pixel = line + column;
                            if f64::from(depth[pixel]) <= centre - radius {
                                continue;
                            }
                            let dx = column as f64 - x;
                            let here =
                                centre - (radius * radius - dx * dx - dy * dy).max(0.0).sqrt();
                            if (here as f32) < depth[pixel] {
                                depth[pixel] = here as f32;
                                owner[pixel] = place as u32;
                            }
                        }
                    }
                }
            });
        Self {
            columns,
            rows,
            origin,
            owner,
            depth,
        }
    }

    /// How many fine pixels each of `number` spheres owns.
    pub(super) fn owned(&self, number: usize) -> Vec<u32> {
        let mut owned = vec![0; number];
        for owner in &self.owner {
            if let Some(count) = owned.get_mut(*owner as usize) {
                *count += 1;
            }
        }
        owned
    }

    /// Whether nothing stands before a place.
    pub(super) fn is_visible(&self, place: Seen) -> bool {
        let fine = SAMPLES as f64;
        let column = (place.x * fine).floor() - self.origin.0 as f64;
        let row = (place.y * fine).floor() - self.origin.1 as f64;
        if !(0.0..self.columns as f64).contains(&column) || !(0.0..self.rows as f64).contains(&row)
        {
            return true;
        }
        let depth = self.depth[row as usize * self.columns + column as usize];
        f64::from(depth) >= place.depth * fine - 1.0
    }

    /// The mean depth around each pixel, over the pixels that show a sphere, in a square of `2 reach + 1`.
    fn mean_depth(&self, reach: usize) -> Vec<f32> {
        // Separable running sums of depth and of number: the cost does not depend on the reach.
        let mut sums: Vec<(f64, f64)> = vec![(0.0, 0.0); self.depth.len()];
        let entry = |d: f32| {
            if d.is_finite() {
                (f64::from(d), 1.0)
            } else {
                (0.0, 0.0)
            }
        };
        sums.par_chunks_mut(self.columns)
            .zip(self.depth.par_chunks(self.columns))
            .for_each(|(out, line)| {
                let (mut sum, mut number) = (0.0, 0.0);
                for column in 0..self.columns + reach {
                    if column < self.columns {
                        let (d, n) = entry(line[column]);
                        sum += d;
                        number += n;
                    }
                    if column > 2 * reach {
                        let (d, n) = entry(line[column - 2 * reach - 1]);
                        sum -= d;
                        number -= n;
                    }
                    if column >= reach {
                        out[column - reach] = (sum, number);
                    }
                }
            });
        let mut mean = vec![0.0; self.depth.len()];
        let mut running = vec![(0.0, 0.0); self.columns];
        for row in 0..self.rows + reach {
            let add = (row < self.rows).then_some(row);
            let drop = row.checked_sub(2 * reach + 1);
            for (column, (sum, number)) in running.iter_mut().enumerate() {
                if let Some(add) = add {
                    *sum += sums[add * self.columns + column].0;
                    *number += sums[add * self.columns + column].1;
                }
                if let Some(drop) = drop {
                    *sum -= sums[drop * self.columns + column].0;
                    *number -= sums[drop * self.columns + column].1;
                }
            }
            if let Some(out) = row.checked_sub(reach) {
                for (column, (sum, number)) in running.iter().enumerate() {
                    mean[out * self.columns + column] = (sum / number.max(1.0)) as f32;
                }
            }
        }
        mean
    }

    /// Paints the spheres onto the page. `colours` belong to `spheres`, one each.
    ///
    /// Lambert's cosine law with ambient light; crevices between spheres are darkened by the difference of
    /// depth to the neighbourhood's mean (T. Luft, C. Colditz and O. Deussen, 2006).
    pub(super) fn paint(&self, page: &mut Raster, spheres: &[SeenSphere], colours: &[Colour]) {
        let fine = SAMPLES as f64;
        let mut sizes: Vec<f64> = spheres.iter().map(|s| s.radius * fine).collect();
        if sizes.is_empty() {
            return;
        }
        let half = sizes.len() / 2;
        let typical = *sizes.select_nth_unstable_by(half, f64::total_cmp).1;
        let reach = typical.clamp(3.0, 40.0);
        let mean = self.mean_depth(reach as usize);
        let (near, far) = self
            .depth
            .iter()
            .filter(|d| d.is_finite())
            .fold((f32::INFINITY, f32::NEG_INFINITY), |(near, far), d| {
                (near.min(*d), far.max(*d))
            });
        let span = f64::from(far - near);
        page.rows_from(self.origin.1)
            .take(self.rows)
            .enumerate()
            .for_each(|(row, line)| {
                let line = &mut line[self.origin.0..];
                for (column, pixel) in line.iter_mut().take(self.columns).enumerate() {
                    let here = row * self.columns + column;
                    let owner = self.owner[here] as usize;
                    let (Some(sphere), Some(colour)) = (spheres.get(owner), colours.get(owner))
                    else {
                        continue;
                    };
                    let radius = (sphere.radius * fine).max(SMALLEST_RADIUS);
                    let nx =
                        (column as f64 + 0.5 + self.origin.0 as f64 - sphere.at.x * fine) / radius;
                    let ny =
                        -(row as f64 + 0.5 + self.origin.1 as f64 - sphere.at.y * fine) / radius;
                    let nz = (1.0 - nx * nx - ny * ny).max(0.0).sqrt();
                    let cosine = nx * TO_LAMP[0] + ny * TO_LAMP[1] + nz * TO_LAMP[2];
                    let light = ((cosine + WRAP) / (1.0 + WRAP)).max(0.0);
                    let depth = f64::from(self.depth[here]);
                    // The sphere's own rim is no crevice: count from its shoulder.
                    let shoulder = depth.min((sphere.at.depth - 0.5 * sphere.radius) * fine);
                    let behind =
                        ((shoulder - f64::from(mean[here])) / (1.5 * reach)).clamp(0.0, 1.0);
                    // The outline: the last pixels before the rim, gone on spheres too small to bear it.
                    let rim = (nz * radius.sqrt() * 0.45).min(1.0);
                    let outline = if radius > 3.0 { 0.6 + 0.4 * rim } else { 1.0 };
                    let strength = (AMBIENT + LAMP * light) * (1.0 - CREVICE * behind) * outline;
                    let gloss = 0.22 * light.powi(24);
                    let haze = if span > 4.0 * radius {
                        HAZE * (depth - f64::from(near)) / span
                    } else {
                        0.0
                    };
                    *pixel = colour
                        .lit(strength)
                        .mix(Colour::WHITE, gloss)
                        .mix(Colour(236, 239, 243), haze);
                }
            });
    }
}
