//! Sums at points anywhere: every point looks for the places whose kernels reach it.

use glam::DVec3;
use rayon::prelude::*;

use super::spread::{Layer, Placed};
use crate::kernel::Kernel;
use crate::sums::Spread;

/// Most cells of the search grid.
const MOST_CELLS: usize = 1 << 21;

/// Cells of equal size, each with the places whose middle it holds.
struct Cells {
    first: DVec3,
    inverse: DVec3,
    counts: [usize; 3],
    starts: Vec<u32>,
    members: Vec<u32>,
}

impl Cells {
    /// Cells not smaller than `size`, so that nothing reaches farther than the next cell.
    fn new(placed: &[Placed], size: f64) -> Self {
        let low = placed
            .iter()
            .fold(DVec3::INFINITY, |low, p| low.min(p.centre));
        let high = placed
            .iter()
            .fold(DVec3::NEG_INFINITY, |high, p| high.max(p.centre));
        let mut size = size;
        let count = |size: f64| [0, 1, 2].map(|a| ((high[a] - low[a]) / size) as usize + 1);
        while count(size).iter().map(|&n| n as f64).product::<f64>() > MOST_CELLS as f64 {
            size *= 1.3;
        }
        let counts = count(size);
        let mut cells = Self {
            first: low,
            inverse: DVec3::splat(1.0 / size),
            counts,
            starts: vec![0; counts.iter().product::<usize>() + 1],
            members: vec![0; placed.len()],
        };
        let at: Vec<usize> = placed
            .iter()
            .map(|p| cells.index(cells.cell(p.centre)))
            .collect();
        for &cell in &at {
            cells.starts[cell + 1] += 1;
        }
        for k in 1..cells.starts.len() {
            cells.starts[k] += cells.starts[k - 1];
        }
        let mut next = cells.starts.clone();
        for (k, &cell) in at.iter().enumerate() {
            cells.members[next[cell] as usize] = k as u32;
            next[cell] += 1;
        }
        cells
    }

    /// The cell of a point; beside the grid, the nearest layer outside.
    fn cell(&self, point: DVec3) -> [i64; 3] {
        let scaled = (point - self.first) * self.inverse;
        [0, 1, 2].map(|a| (scaled[a].floor().clamp(-2.0, self.counts[a] as f64 + 1.0)) as i64)
    }

    fn index(&self, cell: [i64; 3]) -> usize {
        let inside = |a: usize| cell[a].clamp(0, self.counts[a] as i64 - 1) as usize;
        (inside(0) * self.counts[1] + inside(1)) * self.counts[2] + inside(2)
    }

    /// The places in and around the cell of a point, in a fixed order.
    fn near(&self, point: DVec3) -> impl Iterator<Item = u32> + '_ {
        let middle = self.cell(point);
        let around = move |a: usize| {
            let most = self.counts[a] as i64;
            (middle[a] - 1).max(0)..(middle[a] + 2).min(most)
        };
        around(0)
            .flat_map(move |i| around(1).map(move |j| (i, j)))
            .flat_map(move |(i, j)| {
                let row = around(2);
                let (begin, end) = if row.is_empty() {
                    (0, 0)
                } else {
                    let first = self.index([i, j, row.start]);
                    (
                        self.starts[first],
                        self.starts[first + (row.end - row.start) as usize],
                    )
                };
                self.members[begin as usize..end as usize].iter().copied()
            })
    }
}

/// The sums at points, `layer.channels()` numbers each.
pub(crate) fn gather(points: &[DVec3], kernel: &Kernel, layer: &Layer) -> Vec<f64> {
    let channels = layer.channels();
    let mut sums = vec![0.0; points.len() * channels];
    if channels == 0 || layer.placed.is_empty() {
        return sums;
    }
    let longest = layer
        .placed
        .iter()
        .fold(0.0, |longest: f64, p| longest.max(p.segment.length()));
    let cells = Cells::new(&layer.placed, kernel.reach() + 0.5 * longest);
    sums.par_chunks_mut(channels).zip(points).for_each_init(
        || vec![0.0; channels],
        |values, (sums, &point)| {
            for k in cells.near(point) {
                let place = &layer.placed[k as usize];
                let weight = weight(kernel, layer.spread, place, point);
                if weight == 0.0 {
                    continue;
                }
                layer.load(place, 0, values);
                for (sum, value) in sums.iter_mut().zip(&*values) {
                    *sum += weight * value;
                }
            }
        },
    );
    sums
}

fn weight(kernel: &Kernel, spread: Spread, place: &Placed, point: DVec3) -> f64 {
    match spread {
        Spread::Particles | Spread::Boundary => kernel.phi((point - place.centre).length_squared()),
        Spread::Gradients => kernel.slope((point - place.centre).length_squared()),
        Spread::Lines | Spread::Moments => {
            let start = place.centre - 0.5 * place.segment;
            let [psi, moment] = kernel.line(start, place.segment, point);
            if spread == Spread::Lines { psi } else { moment }
        }
    }
}

/// Rows added one after the other before a new sum begins.
const BLOCK: usize = 4096;

/// The sums without any coordinate: kernels are 1, gradients and moments 0.
pub(crate) fn total(layer: &Layer) -> Vec<f64> {
    if layer.spread == Spread::Gradients {
        return vec![0.0; 3 * layer.width];
    }
    let channels = layer.width;
    let mut sums = vec![0.0; channels];
    if layer.width == 0 || layer.spread == Spread::Moments {
        return sums;
    }
    let blocks: Vec<Vec<f64>> = layer
        .values
        .par_chunks(BLOCK * layer.width)
        .map(|rows| {
            let mut sums = vec![0.0; channels];
            for row in rows.chunks_exact(layer.width) {
                for (sum, value) in sums.iter_mut().zip(row) {
                    *sum += value;
                }
            }
            sums
        })
        .collect();
    for block in blocks {
        for (sum, value) in sums.iter_mut().zip(block) {
            *sum += value;
        }
    }
    sums
}
