//! Rows that are spread in one way: their places, and their numbers.

use glam::DVec3;

use crate::sums::Spread;

/// One particle, contact or contact point where it is seen from the grid: itself, a periodic image, or a mirror image.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Placed {
    /// Middle of the segment; the point itself without one. Zero in directions that are not resolved.
    pub centre: DVec3,
    /// The segment.
    pub segment: DVec3,
    /// Row of its numbers.
    pub row: u32,
    /// Axes (as bits) along which it is mirrored.
    pub mirrored: u8,
}

impl Placed {
    /// Until something is placed.
    pub(crate) const NOWHERE: Self = Self {
        centre: DVec3::ZERO,
        segment: DVec3::ZERO,
        row: 0,
        mirrored: 0,
    };
}

/// All that is spread in one way.
#[derive(Debug, Clone)]
pub(crate) struct Layer {
    pub spread: Spread,
    /// Numbers per row.
    pub width: usize,
    /// Axes whose mirroring turns the sign, of each number.
    pub parity: Vec<u8>,
    /// Rows of numbers.
    pub values: Vec<f64>,
    pub placed: Vec<Placed>,
    /// Memory for as many again.
    pub spare: Vec<Placed>,
    /// Where products with positions are counted from.
    pub origin: DVec3,
}

impl Layer {
    /// Numbers per point of what comes out: gradients have the numbers and their products with x, y, z.
    pub(crate) fn channels(&self) -> usize {
        if self.spread == Spread::Gradients {
            4 * self.width
        } else {
            self.width
        }
    }

    /// The numbers to be spread of one place, from channel `first` on.
    ///
    /// For gradients, `grad phi(r - x) = slope(|r - x|) (r - x)`: what is spread by the slope is q and q x, so that the gradient of sum q phi
    /// is r sum(q slope) - sum(q x slope); both are counted from `origin`, which keeps the difference sharp.
    #[inline(always)]
    pub(crate) fn load(&self, placed: &Placed, first: usize, out: &mut [f64]) {
        let row = &self.values[placed.row as usize * self.width..][..self.width];
        let signed = |k: usize| {
            let odd = (self.parity[k] & placed.mirrored).count_ones() & 1 == 1;
            if odd { -row[k] } else { row[k] }
        };
        if self.spread != Spread::Gradients && placed.mirrored == 0 {
            let count = out.len().min(row.len() - first);
            out[..count].copy_from_slice(&row[first..first + count]);
            out[count..].fill(0.0);
            return;
        }
        let from = placed.centre - self.origin;
        for (k, out) in out.iter_mut().enumerate() {
            let channel = first + k;
            *out = if channel < self.width {
                signed(channel)
            } else if channel < self.channels() {
                let (direction, k) = (
                    (channel - self.width) / self.width,
                    (channel - self.width) % self.width,
                );
                signed(k) * from[direction]
            } else {
                0.0
            };
        }
    }
}
