//! The volume of a body as a lattice of points, of which balls cover some.

use glam::DVec3;
use mercury_common::formats::clump::Pebble;
use rayon::prelude::*;

use super::body::Body;

/// A cubic lattice; a mark for each point that is inside the body and in no ball yet.
pub(super) struct Lattice {
    low: DVec3,
    spacing: f64,
    /// Points along x, y, z; z runs fastest.
    count: [usize; 3],
    open: Vec<bool>,
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
        let rows: Vec<Vec<bool>> = (0..count[0] * count[1])
            .into_par_iter()
            .map(|row| {
                let (i, j) = (row / count[1], row % count[1]);
                let mut open = Vec::with_capacity(count[2]);
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
                    open.push(depth > 0.0);
                }
                open
            })
            .collect();
        Self {
            low,
            spacing,
            count,
            open: rows.concat(),
        }
    }

    /// How many points the ball would cover that no ball before it did.
    pub(super) fn gain(&self, ball: &Pebble) -> usize {
        let mut gain = 0;
        self.runs(ball, &mut |from, to| {
            gain += self.open[from..to].iter().filter(|open| **open).count();
        });
        gain
    }

    /// Marks the points of a ball as covered.
    pub(super) fn cover(&mut self, ball: &Pebble) {
        let mut runs = Vec::new();
        self.runs(ball, &mut |from, to| runs.push((from, to)));
        for (from, to) in runs {
            self.open[from..to].fill(false);
        }
    }

    /// Ranges of points inside a ball.
    fn runs(&self, ball: &Pebble, visit: &mut dyn FnMut(usize, usize)) {
        let range = |axis: usize, centre: f64, half: f64| {
            let at = (centre - self.low[axis]) / self.spacing;
            let half = half / self.spacing;
            let from = (at - half).ceil().max(0.0) as usize;
            let to = ((at + half).floor() + 1.0).max(0.0) as usize;
            (from, to.min(self.count[axis]))
        };
        let (centre, radius) = (ball.position, ball.radius);
        let (from_x, to_x) = range(0, centre.x, radius);
        for i in from_x..to_x {
            let dx = self.low.x + i as f64 * self.spacing - centre.x;
            let left = radius * radius - dx * dx;
            let (from_y, to_y) = range(1, centre.y, left.max(0.0).sqrt());
            for j in from_y..to_y {
                let dy = self.low.y + j as f64 * self.spacing - centre.y;
                let (from, to) = range(2, centre.z, (left - dy * dy).max(0.0).sqrt());
                if from < to {
                    let row = (i * self.count[1] + j) * self.count[2];
                    visit(row + from, row + to);
                }
            }
        }
    }
}
