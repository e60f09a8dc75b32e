//! The space that pebbles cover, counted in voxels. It is the route of MercuryDPM's MClump, kept to compare with it; the
//! [union](super::union) is faster and far more accurate.

use glam::{DMat3, DVec3};
use mercury_common::formats::clump::Pebble;
use rayon::prelude::*;

use super::pebbles::bounds;
use super::{Estimate, MassProperties};

/// Default number of voxels along the longest edge, as in MClump.
pub const DEFAULT_VOXELS: u32 = 100;
/// Refinement ends here: 8e9 voxels.
pub const MOST_VOXELS: u32 = 2000;

/// Grids shifted by these fractions of a voxel: their differences estimate the error of each.
const SHIFTS: [[f64; 3]; 3] = [[0.5, 0.5, 0.5], [0.25, 0.5, 0.75], [0.75, 0.25, 0.5]];

/// Volume, centre and second moments of the voxels whose centre lies strictly inside a pebble, with an error estimate.
/// `voxels` (at least 1) is their number along the longest edge of the box around the pebbles. `None` without
/// pebbles, or if no voxel's centre lies in a pebble.
///
/// Each voxel of edge h counts with its own second moment `h^5/12 E`. Sums are whole numbers, so the result does not depend on the
/// number of threads. The error is the largest difference to three shifted grids.
#[must_use]
pub fn integrate(pebbles: &[Pebble], voxels: u32) -> Option<Estimate> {
    let properties = on_grid(pebbles, voxels, DVec3::ZERO)?;
    let relative_error = SHIFTS
        .iter()
        .map(|shift| {
            on_grid(pebbles, voxels, DVec3::from_array(*shift))
                .map_or(1.0, |other| difference(&properties, &other))
        })
        .fold(0.0, f64::max);
    Some(Estimate {
        properties,
        relative_error,
    })
}

/// Doubles the number of voxels from `voxels` until the estimated relative error is at most `tolerance`, or the
/// number would exceed [`MOST_VOXELS`]; returns the last number too. `None` as for [`integrate`].
#[must_use]
pub fn integrate_to(pebbles: &[Pebble], voxels: u32, tolerance: f64) -> Option<(Estimate, u32)> {
    let mut number = voxels.max(1);
    loop {
        let estimate = integrate(pebbles, number);
        let good = estimate.is_some_and(|estimate| estimate.relative_error <= tolerance);
        let next = number.saturating_mul(2);
        if good || next > MOST_VOXELS {
            return Some((estimate?, number));
        }
        number = next;
    }
}

/// The larger of the relative differences of volume and inertia, the latter relative to the trace.
pub(crate) fn difference(a: &MassProperties, b: &MassProperties) -> f64 {
    let trace = |m: DMat3| m.x_axis.x + m.y_axis.y + m.z_axis.z;
    let matrix = (a.second_moment - b.second_moment).to_cols_array();
    let largest = matrix
        .into_iter()
        .fold(0.0, |most: f64, x| most.max(x.abs()));
    let volume = (a.volume - b.volume).abs() / a.volume.abs();
    // The inertia's trace is twice the second moment's.
    volume.max(largest / (2.0 * trace(a.second_moment)).abs())
}

fn on_grid(pebbles: &[Pebble], voxels: u32, shift: DVec3) -> Option<MassProperties> {
    let (low, high) = bounds(pebbles)?;
    let number = i64::from(voxels.max(1));
    let edge = (high - low).max_element() / number as f64;
    // A shifted grid needs one more voxel to cover the box.
    let corner = low + 0.5 * (high - low) - DVec3::splat(0.5 * edge * number as f64) - shift * edge;
    let layers = if shift == DVec3::ZERO {
        number
    } else {
        number + 1
    };
    let grid = Grid {
        corner,
        edge,
        layers,
    };
    let counts: Vec<Counts> = (0..layers)
        .into_par_iter()
        .map(|i| grid.layer(pebbles, i))
        .collect();
    let mut sum = Counts::default();
    for layer in &counts {
        sum.add(layer);
    }
    if sum.number == 0 {
        return None;
    }
    // Indices to lengths; sums of whole numbers are exact until here.
    let n = sum.number as f64;
    let first = DVec3::from_array(sum.first.map(|x| x as f64)) / n;
    let central = |a: usize, b: usize, second: i128| {
        let exact = second * sum.number - sum.first[a] * sum.first[b];
        exact as f64 / n
    };
    let [xx, yy, zz, xy, xz, yz] = [
        central(0, 0, sum.second[0]),
        central(1, 1, sum.second[1]),
        central(2, 2, sum.second[2]),
        central(0, 1, sum.second[3]),
        central(0, 2, sum.second[4]),
        central(1, 2, sum.second[5]),
    ];
    let indices = DMat3::from_cols(
        DVec3::new(xx, xy, xz),
        DVec3::new(xy, yy, yz),
        DVec3::new(xz, yz, zz),
    );
    let own = DMat3::from_diagonal(DVec3::splat(n / 12.0));
    Some(MassProperties {
        volume: n * edge.powi(3),
        centre: corner + (first + DVec3::splat(0.5)) * edge,
        second_moment: (indices + own) * edge.powi(5),
    })
}

struct Grid {
    corner: DVec3,
    edge: f64,
    layers: i64,
}

/// Number of full voxels, sums of their indices and of products of indices (xx, yy, zz, xy, xz, yz).
#[derive(Default, Clone, Copy)]
struct Counts {
    number: i128,
    first: [i128; 3],
    second: [i128; 6],
}

impl Counts {
    fn add(&mut self, other: &Self) {
        self.number += other.number;
        for (sum, part) in self.first.iter_mut().zip(other.first) {
            *sum += part;
        }
        for (sum, part) in self.second.iter_mut().zip(other.second) {
            *sum += part;
        }
    }

    /// Voxels (i, j, from..to).
    fn add_run(&mut self, i: i64, j: i64, from: i64, to: i64) {
        let [i, j, from, to] = [i, j, from, to].map(i128::from);
        let n = to - from;
        // Sums of k and k² for k below m: m (m - 1)/2 and m (m - 1) (2m - 1)/6.
        let below = |m: i128| (m * (m - 1) / 2, m * (m - 1) * (2 * m - 1) / 6);
        let ((k_to, kk_to), (k_from, kk_from)) = (below(to), below(from));
        let (k, kk) = (k_to - k_from, kk_to - kk_from);
        self.number += n;
        self.first[0] += n * i;
        self.first[1] += n * j;
        self.first[2] += k;
        self.second[0] += n * i * i;
        self.second[1] += n * j * j;
        self.second[2] += kk;
        self.second[3] += n * i * j;
        self.second[4] += i * k;
        self.second[5] += j * k;
    }
}

impl Grid {
    fn centre(&self, index: i64, axis: usize) -> f64 {
        self.corner[axis] + (index as f64 + 0.5) * self.edge
    }

    /// The indices along an axis whose centres are strictly nearer than `reach` to `at`.
    fn inside(&self, at: f64, reach: f64, axis: usize) -> std::ops::Range<i64> {
        let is_inside = |index: i64| (self.centre(index, axis) - at).abs() < reach;
        let estimate = |x: f64| (x - self.corner[axis]) / self.edge - 0.5;
        // A range and its ends tested one by one: the estimates may be off by round-off.
        let mut from = (estimate(at - reach).floor() as i64).clamp(0, self.layers);
        let mut to = (estimate(at + reach).ceil() as i64 + 1).clamp(0, self.layers);
        while from < to && !is_inside(from) {
            from += 1;
        }
        while to > from && !is_inside(to - 1) {
            to -= 1;
        }
        from..to
    }

    /// All full voxels with first index `i`.
    fn layer(&self, pebbles: &[Pebble], i: i64) -> Counts {
        let x = self.centre(i, 0);
        // Runs along z of each column of the layer.
        let mut columns: Vec<Vec<(i64, i64)>> = vec![Vec::new(); self.layers as usize];
        for pebble in pebbles {
            let disc = pebble.radius.powi(2) - (x - pebble.position.x).powi(2);
            if disc <= 0.0 {
                continue;
            }
            for j in self.inside(pebble.position.y, disc.sqrt(), 1) {
                let y = self.centre(j, 1);
                let half = disc - (y - pebble.position.y).powi(2);
                if half > 0.0 {
                    let run = self.inside(pebble.position.z, half.sqrt(), 2);
                    if !run.is_empty() {
                        columns[j as usize].push((run.start, run.end));
                    }
                }
            }
        }
        let mut counts = Counts::default();
        for (j, runs) in columns.iter_mut().enumerate() {
            runs.sort_unstable();
            let mut reached = 0;
            for &(from, to) in runs.iter() {
                let from = from.max(reached);
                if to > from {
                    counts.add_run(i, j as i64, from, to);
                    reached = to;
                }
            }
        }
        counts
    }
}
