//! The volume of a body as a lattice of points, of which balls cover some.

use glam::DVec3;
use mercury_common::formats::clump::Pebble;
use rayon::prelude::*;

use super::body::Body;

/// A cubic lattice; a bit for each point that is inside the body and in no ball yet.
pub(super) struct Lattice {
    low: DVec3,
    spacing: f64,
    /// Points along x, y, z.
    count: [usize; 3],
    /// Words of 64 points along z, per row.
    words: usize,
    open: Vec<u64>,
}

impl Lattice {
    /// About `points` points inside the body.
    pub(super) fn new(body: &Body, points: usize) -> Self {
        let spacing = (body.volume / points as f64).cbrt();
        let (low, high) = body.bounds;
        let extent = high - low;
        let count = extent
            .to_array()
            .map(|length| (length / spacing).ceil().max(1.0) as usize);
        // Centred, so that symmetric bodies get symmetric lattices.
        let room = DVec3::from_array(count.map(|n| (n - 1) as f64 * spacing)) - extent;
        let low = low - 0.5 * room;
        let words = count[2].div_ceil(64);
        let rows: Vec<Vec<u64>> = (0..count[0] * count[1])
            .into_par_iter()
            .map(|row| {
                let (i, j) = (row / count[1], row % count[1]);
                let mut open = vec![0; words];
                // The depth changes by at most 1 per length: deep inside and far outside many points need no look.
                let mut known: Option<(usize, f64)> = None;
                for k in 0..count[2] {
                    let depth = match known {
                        Some((at, depth)) if depth.abs() > (k - at) as f64 * spacing => depth,
                        _ => {
                            let at = DVec3::new(i as f64, j as f64, k as f64);
                            let depth = body.nearest(low + spacing * at).depth;
                            known = Some((k, depth));
                            depth
                        }
                    };
                    open[k / 64] |= u64::from(depth > 0.0) << (k % 64);
                }
                open
            })
            .collect();
        Self {
            low,
            spacing,
            count,
            words,
            open: rows.concat(),
        }
    }

    /// Number of points that the ball would cover and no ball before it did.
    pub(super) fn gain(&self, ball: &Pebble) -> u32 {
        let mut gain = 0;
        self.visit(ball, &mut |word, mask| {
            gain += (self.open[word] & mask).count_ones()
        });
        gain
    }

    /// Marks the points of a ball as covered.
    pub(super) fn cover(&mut self, ball: &Pebble) {
        let mut covered = Vec::new();
        self.visit(ball, &mut |word, mask| covered.push((word, mask)));
        for (word, mask) in covered {
            self.open[word] &= !mask;
        }
    }

    /// Words that a ball reaches into, with the bits inside it.
    fn visit(&self, ball: &Pebble, visit: &mut impl FnMut(usize, u64)) {
        let range = |axis: usize, half: f64| {
            let at = (ball.position[axis] - self.low[axis]) / self.spacing;
            let half = half / self.spacing;
            let from = (at - half).ceil().max(0.0) as usize;
            let to = ((at + half).floor() + 1.0).max(0.0) as usize;
            (from, to.min(self.count[axis]))
        };
        let offset = |axis: usize, index: usize| {
            self.low[axis] + index as f64 * self.spacing - ball.position[axis]
        };
        let (from_x, to_x) = range(0, ball.radius);
        for i in from_x..to_x {
            let left = ball.radius * ball.radius - offset(0, i) * offset(0, i);
            let (from_y, to_y) = range(1, left.max(0.0).sqrt());
            for j in from_y..to_y {
                let left = left - offset(1, j) * offset(1, j);
                let (from, to) = range(2, left.max(0.0).sqrt());
                if from >= to {
                    continue;
                }
                let row = (i * self.count[1] + j) * self.words;
                let (first, last) = (from / 64, (to - 1) / 64);
                for word in first..=last {
                    let mut mask = u64::MAX;
                    if word == first {
                        mask &= u64::MAX << (from % 64);
                    }
                    if word == last {
                        mask &= u64::MAX >> (63 - (to - 1) % 64);
                    }
                    visit(row + word, mask);
                }
            }
        }
    }
}
