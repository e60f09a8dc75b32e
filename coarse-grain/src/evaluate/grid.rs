//! Spreading on a grid: every place adds to the points that its kernel reaches.
//!
//! The grid is cut into slabs along its first axis, one for each thread: it goes through all places that reach its slab, in
//! their order. A point's sum therefore has the same order of terms, and the same bytes, however many slabs there are.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::lattice::Lattice;
use super::spread::{Layer, Placed};
use super::weights::{GaussianRows, PolynomialRows, RowWeights, Seen};
use super::window::Window;
use crate::kernel::Kernel;

/// Sums of this many bytes and fewer stay in a processor's cache; above, places are sorted in space first.
const CACHE: usize = 1 << 20;
/// Most numbers spread in one go: they stay in the processor's registers.
const MOST: usize = 24;

/// The sums at all points, `layer.channels()` numbers each.
pub(crate) fn spread(lattice: &Lattice, kernel: &Kernel, layer: &mut Layer) -> Vec<f64> {
    let channels = layer.channels();
    if channels == 0 || layer.placed.is_empty() {
        return vec![0.0; lattice.len() * channels];
    }
    if lattice.len() * channels * 8 > CACHE {
        sort(lattice, &mut layer.placed);
    }
    let layer = &*layer;
    if channels <= MOST {
        return some(lattice, kernel, layer, 0, channels);
    }
    let mut all = vec![0.0; lattice.len() * channels];
    for first in (0..channels).step_by(MOST) {
        let count = MOST.min(channels - first);
        let part = some(lattice, kernel, layer, first, count);
        for (to, from) in all.chunks_exact_mut(channels).zip(part.chunks_exact(count)) {
            to[first..first + count].copy_from_slice(from);
        }
    }
    all
}

/// Places that are near each other become near in memory too: row by row of the grid, in each in the order that they have.
fn sort(lattice: &Lattice, placed: &mut Vec<Placed>) {
    let [x, y, _] = &lattice.axes;
    let rows = (x.count + 1) * (y.count + 1);
    if rows > placed.len().saturating_mul(4) {
        return;
    }
    let row = |place: &Placed| {
        let cell = |axis: usize| {
            lattice.axes[axis]
                .between(place.centre[axis], f64::INFINITY)
                .start
        };
        (cell(0) * (y.count + 1) + cell(1)) as u32
    };
    let all: Vec<u32> = placed.par_iter().with_min_len(4096).map(row).collect();
    // Where the places of each row begin.
    let mut next = vec![0u32; rows + 1];
    for &row in &all {
        next[row as usize + 1] += 1;
    }
    for row in 1..next.len() {
        next[row] += next[row - 1];
    }
    let mut order = vec![0u32; placed.len()];
    for (k, &row) in (0..).zip(&all) {
        let at = &mut next[row as usize];
        order[*at as usize] = k;
        *at += 1;
    }
    *placed = order
        .par_iter()
        .with_min_len(4096)
        .map(|&k| placed[k as usize])
        .collect();
}

fn some(lattice: &Lattice, kernel: &Kernel, layer: &Layer, first: usize, count: usize) -> Vec<f64> {
    macro_rules! widths {
        ($($width:literal)*) => {
            $(if count <= $width {
                return widened::<$width>(lattice, kernel, layer, first, count);
            })*
        };
    }
    widths!(4 10 18);
    widened::<MOST>(lattice, kernel, layer, first, count)
}

fn widened<const F: usize>(
    lattice: &Lattice,
    kernel: &Kernel,
    layer: &Layer,
    first: usize,
    count: usize,
) -> Vec<f64> {
    let mut sums = vec![[0.0; F]; lattice.len()];
    if kernel.polynomial().is_some() {
        let rows = || PolynomialRows::new(kernel, lattice, layer.spread);
        slabs(lattice, kernel, layer, first, &mut sums, rows);
    } else {
        let rows = || GaussianRows::new(kernel, lattice, layer.spread);
        slabs(lattice, kernel, layer, first, &mut sums, rows);
    }
    if F == count && lattice.is_ordered() {
        return sums.into_flattened();
    }
    let mut ordered = vec![0.0; lattice.len() * count];
    for (place, from) in lattice.places().zip(&sums) {
        ordered[place * count..][..count].copy_from_slice(&from[..count]);
    }
    ordered
}

fn slabs<W: RowWeights, const F: usize>(
    lattice: &Lattice,
    kernel: &Kernel,
    layer: &Layer,
    first: usize,
    sums: &mut [[f64; F]],
    rows: impl Fn() -> W + Sync,
) {
    let split = (0..3)
        .find(|&axis| lattice.axes[axis].count > 1)
        .unwrap_or(2);
    let along = lattice.axes[split].count;
    let inner: usize = lattice.axes[split + 1..]
        .iter()
        .map(|axis| axis.count)
        .product();
    let threads = rayon::current_num_threads().min(along);
    let add_all = |slab: Range<usize>, sums: &mut [[f64; F]], spans: &[Range<u32>]| {
        let (begin, end) = (slab.start as u32, slab.end as u32);
        let ball = Window::ball(kernel);
        let mut slab = Slab {
            lattice,
            kernel,
            layer,
            first,
            split,
            inner,
            ball,
            slab,
            sums,
        };
        let mut rows = rows();
        for (k, place) in layer.placed.iter().enumerate() {
            if spans
                .get(k)
                .is_none_or(|span| span.start < end && span.end > begin)
            {
                slab.add(place, &mut rows);
            }
        }
    };
    if threads == 1 {
        add_all(0..along, sums, &[]);
        return;
    }
    let axis = &lattice.axes[split];
    let span = |place: &Placed| {
        let at = place.centre[split];
        let half = kernel.reach() + 0.5 * place.segment[split].abs();
        let span = axis.between(at - half, at + half);
        span.start as u32..span.end as u32
    };
    let spans: Vec<Range<u32>> = layer
        .placed
        .par_iter()
        .with_min_len(1024)
        .map(span)
        .collect();
    let mut rest = sums;
    let mut shares = Vec::with_capacity(threads);
    for slab in equal_shares(&spans, along, threads) {
        let (own, others) = rest.split_at_mut(slab.len() * inner);
        rest = others;
        shares.push((slab, own));
    }
    shares
        .into_par_iter()
        .with_max_len(1)
        .for_each(|(slab, sums)| add_all(slab, sums, &spans));
}

/// Cuts the grid so that every slab has about as much to do. Where the cuts are changes no result.
fn equal_shares(spans: &[Range<u32>], along: usize, count: usize) -> Vec<Range<usize>> {
    let mut change = vec![0i64; along + 1];
    for span in spans {
        change[span.start as usize] += 1;
        change[span.end as usize] -= 1;
    }
    let mut height = 0;
    let work = change[..along].iter().map(|change| {
        height += change;
        height + 1
    });
    let sums: Vec<i64> = work
        .scan(0, |sum, work| {
            *sum += work;
            Some(*sum)
        })
        .collect();
    let total = sums.last().copied().unwrap_or(0);
    let cut = |k: usize| sums.partition_point(|&sum| sum * (count as i64) < total * k as i64);
    // A cut behind the plane with which the share is full.
    let mut cuts: Vec<usize> = (1..count).map(|k| (cut(k) + 1).min(along)).collect();
    cuts.insert(0, 0);
    cuts.push(along);
    cuts.windows(2)
        .map(|ends| ends[0]..ends[1].max(ends[0]))
        .collect()
}

/// A part of the grid and what is spread on it.
struct Slab<'a, const F: usize> {
    lattice: &'a Lattice,
    kernel: &'a Kernel,
    layer: &'a Layer,
    first: usize,
    split: usize,
    /// Points per layer of the slab.
    inner: usize,
    ball: Window,
    slab: Range<usize>,
    sums: &'a mut [[f64; F]],
}

impl<const F: usize> Slab<'_, F> {
    fn add<W: RowWeights>(&mut self, place: &Placed, rows: &mut W) {
        let axes = &self.lattice.axes;
        let window = if place.segment == DVec3::ZERO {
            self.ball
        } else {
            Window::around(self.kernel, place.segment)
        };
        let ranges = [0, 1, 2].map(|a| {
            axes[a].between(
                place.centre[a] - window.half[a],
                place.centre[a] + window.half[a],
            )
        });
        if ranges.iter().any(Range::is_empty) {
            return;
        }
        let mut own = ranges.clone();
        own[self.split].start = own[self.split].start.max(self.slab.start);
        own[self.split].end = own[self.split].end.min(self.slab.end);
        if own[self.split].is_empty() {
            return;
        }
        // Tables hold the whole range, so that they are the same in every slab.
        rows.begin(place, &ranges);
        let mut values = [0.0; F];
        self.layer.load(place, self.first, &mut values);
        let mut seen = Seen {
            lattice: self.lattice,
            window: &window,
            centre: place.centre,
            own,
            begin: self.slab.start * self.inner,
            sums: self.sums,
        };
        rows.add(&mut seen, &values);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_cover_the_grid_and_are_even() {
        let even: Vec<Range<u32>> = (0..100).map(|k| k..(k + 5).min(100)).collect();
        assert_eq!(
            equal_shares(&even, 100, 1),
            vec![Range { start: 0, end: 100 }]
        );
        let halves = equal_shares(&even, 100, 2);
        assert!(
            halves[0].end.abs_diff(51) <= 2 && halves[1] == (halves[0].end..100),
            "{halves:?}"
        );
        // All at one end, and more shares than planes with something to do.
        for spans in [vec![0..1; 50], vec![7..8; 3], Vec::new()] {
            let shares = equal_shares(&spans, 8, 5);
            assert_eq!((shares[0].start, shares[4].end, shares.len()), (0, 8, 5));
            assert!(
                shares.windows(2).all(|pair| pair[0].end == pair[1].start),
                "{shares:?}"
            );
        }
    }
}
