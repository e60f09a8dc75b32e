//! Spreading on a grid: every place adds to the points that its kernel reaches.
//!
//! Places are put into groups along the grid, each of which is summed apart, in the order of its places; then the groups are added up in their
//! order. On grids too large for that there is one group: the grid is cut into slabs between its rows, one for each thread, which goes through all
//! places that reach its slab, in their order. Either way a point's sum has the same order of terms, and the same bytes, however many threads
//! there are.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::instructions::{Instructions, Task};
use super::lattice::Lattice;
use super::scratch::SumScratch;
use super::spread::{Layer, Placed};
use super::weights::{GaussianRows, PolynomialRows, RowWeights, Seen};
use super::window::Window;
use crate::kernel::Kernel;

/// Sums of this many bytes and fewer stay in a processor's cache; above, places are sorted in space first.
const CACHE: usize = 1 << 20;
/// Points that a thread puts in order, or adds up, in one go.
const ORDERED: usize = 4096;
/// Most numbers spread in one go: they stay in the processor's registers.
const MOST: usize = 24;

/// The sums at all points, `layer.channels()` numbers each.
///
/// Sums lie in memory from before, as far as there is any.
pub(crate) fn spread(
    lattice: &Lattice,
    kernel: &Kernel,
    layer: &mut Layer,
    scratch: &mut SumScratch,
) -> Vec<f64> {
    let channels = layer.channels();
    if channels == 0 || layer.placed.is_empty() {
        return scratch.buffers.zeros(lattice.len() * channels);
    }
    if lattice.len() * channels * 8 > CACHE {
        sort(lattice, layer);
    }
    let layer = &*layer;
    if channels <= MOST {
        return some(lattice, kernel, layer, 0..channels, scratch);
    }
    let mut all = scratch.buffers.any(lattice.len() * channels);
    for first in (0..channels).step_by(MOST) {
        let count = MOST.min(channels - first);
        let part = some(lattice, kernel, layer, first..first + count, scratch);
        for (to, from) in all.chunks_exact_mut(channels).zip(part.chunks_exact(count)) {
            to[first..first + count].copy_from_slice(from);
        }
        scratch.buffers.keep(part);
    }
    all
}

/// Places that are near each other become near in memory too: row by row of the grid, in each in the order that they have.
fn sort(lattice: &Lattice, layer: &mut Layer) {
    let placed = &layer.placed;
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
    order
        .par_iter()
        .with_min_len(4096)
        .map(|&k| placed[k as usize])
        .collect_into_vec(&mut layer.spare);
    std::mem::swap(&mut layer.placed, &mut layer.spare);
}

/// The sums of some channels.
fn some(
    lattice: &Lattice,
    kernel: &Kernel,
    layer: &Layer,
    channels: Range<usize>,
    scratch: &mut SumScratch,
) -> Vec<f64> {
    macro_rules! widths {
        ($($width:literal)*) => {
            $(if channels.len() <= $width {
                return widened::<$width>(lattice, kernel, layer, channels, scratch);
            })*
        };
    }
    widths!(4 10 18);
    widened::<MOST>(lattice, kernel, layer, channels, scratch)
}

fn widened<const F: usize>(
    lattice: &Lattice,
    kernel: &Kernel,
    layer: &Layer,
    channels: Range<usize>,
    scratch: &mut SumScratch,
) -> Vec<f64> {
    let (first, count) = (channels.start, channels.len());
    let mut all = scratch.buffers.zeros(lattice.len() * F);
    let (sums, parts) = (all.as_chunks_mut::<F>().0, &mut scratch.parts);
    if kernel.polynomial().is_some() {
        let rows = || PolynomialRows::new(kernel, lattice, layer.spread);
        slabs(lattice, kernel, layer, first, (sums, parts), rows);
    } else {
        let rows = || GaussianRows::new(kernel, lattice, layer.spread);
        slabs(lattice, kernel, layer, first, (sums, parts), rows);
    }
    if F == count && lattice.is_ordered() {
        return all;
    }
    let mut ordered = scratch.buffers.any(lattice.len() * count);
    let sums = all.as_chunks::<F>().0;
    let some = |(part, ordered): (usize, &mut [f64])| {
        for (place, to) in (part * ORDERED..).zip(ordered.chunks_exact_mut(count)) {
            to.copy_from_slice(&sums[lattice.place(place)][..count]);
        }
    };
    let parts = ordered.par_chunks_mut(ORDERED * count);
    parts.enumerate().for_each(some);
    scratch.buffers.keep(all);
    ordered
}

fn slabs<W: RowWeights, const F: usize>(
    lattice: &Lattice,
    kernel: &Kernel,
    layer: &Layer,
    first: usize,
    (sums, parts): (&mut [[f64; F]], &mut Vec<Vec<f64>>),
    rows: impl Fn() -> W + Sync,
) {
    let units = Units::of(lattice);
    let spans: Vec<Range<u32>> = (layer.placed.par_iter().with_min_len(1024))
        .map(|place| units.span(lattice, kernel, place))
        .collect();
    let instructions = Instructions::widest();
    let add_all = |range: Range<usize>, sums: &mut [[f64; F]], members: &[u32]| {
        let slab = Slab {
            lattice,
            kernel,
            layer,
            first,
            ball: Window::ball(kernel),
            units: Units {
                range,
                ..units.clone()
            },
            sums,
        };
        instructions.run(AddAll {
            slab,
            rows: rows(),
            spans: &spans,
            members,
        });
    };
    let groups = groups(
        &spans,
        units.range.len(),
        units.points * size_of::<[f64; F]>(),
    );
    if let [group] = &groups[..] {
        let mut rest = sums;
        let mut done = 0;
        let mut slabs = Vec::new();
        for range in equal_shares(&spans, group, rayon::current_num_threads()) {
            let (_, here) = rest.split_at_mut((range.start - done) * units.points);
            let (own, others) = here.split_at_mut(range.len() * units.points);
            (rest, done) = (others, range.end);
            slabs.push((range, own));
        }
        let slabs = slabs.into_par_iter().with_max_len(1);
        slabs.for_each(|(range, own)| add_all(range, own, &group.members));
        return;
    }
    parts.resize_with(groups.len().max(parts.len()), Vec::new);
    let of_groups = groups.par_iter().zip(&mut parts[..groups.len()]);
    of_groups.with_max_len(1).for_each(|(group, own)| {
        own.clear();
        own.resize(group.range.len() * units.points * F, 0.0);
        add_all(group.range.clone(), own.as_chunks_mut().0, &group.members);
    });
    // At each point group by group.
    let chunks = sums.par_chunks_mut(ORDERED).enumerate();
    chunks.for_each(|(chunk, sums)| {
        let begin = chunk * ORDERED;
        for (group, own) in groups.iter().zip(&*parts) {
            let own = own.as_chunks::<F>().0;
            let from = group.range.start * units.points;
            let (low, high) = (from.max(begin), (from + own.len()).min(begin + sums.len()));
            if low < high {
                let pairs = sums[low - begin..high - begin]
                    .iter_mut()
                    .zip(&own[low - from..]);
                for (sum, own) in pairs {
                    for (sum, own) in sum.iter_mut().zip(own) {
                        *sum += own;
                    }
                }
            }
        }
    });
}

/// Places that are spread together, and all units that they reach.
#[derive(Debug, Clone, PartialEq, Default)]
struct Group {
    range: Range<usize>,
    /// The places, in their order.
    members: Vec<u32>,
}

/// Most groups of places.
const MOST_GROUPS: usize = 16;
/// Fewer places than these are one group.
const FEWEST: usize = 1024;
/// Most bytes of the sums of all groups; where they would take more, there is one group.
pub(super) const MOST_BYTES: usize = 1 << 26;

/// The points of the grid in groups of about equal size; each group is summed by one thread. Every point is therefore processed
/// once, whatever the number of threads. The groups follow from the points alone, as they decide the order of sums. Their number
/// is limited so that their parts of the grid together are at most three times the grid, because these parts have to be added up.
fn groups(spans: &[Range<u32>], units: usize, bytes: usize) -> Vec<Group> {
    let middle = |span: &Range<u32>| ((span.start + span.end) / 2) as usize;
    let seen = || (0u32..).zip(spans).filter(|(_, span)| !span.is_empty());
    let mut upto = vec![0usize; units + 1];
    let mut longest = 1;
    for (_, span) in seen() {
        upto[middle(span) + 1] += 1;
        longest = longest.max(span.len());
    }
    for unit in 0..units {
        upto[unit + 1] += upto[unit];
    }
    let total = upto[units];
    // A power of two, which most numbers of threads share evenly.
    let count = 1 << (2 * units / longest).clamp(1, MOST_GROUPS).ilog2();
    let is_one = total < FEWEST || (units + count * longest) * bytes > MOST_BYTES;
    let count = if is_one { 1 } else { count };
    // Equal shares of the places, by where their middles are.
    let group_of: Vec<u8> = (upto[..units].iter())
        .map(|before| (before * count / total.max(1)).min(count - 1) as u8)
        .collect();
    let nothing = |_| Group {
        range: units..0,
        members: Vec::with_capacity(total / count + 1),
    };
    let mut groups: Vec<Group> = (0..count).map(nothing).collect();
    for (k, span) in seen() {
        let group = &mut groups[usize::from(group_of[middle(span)])];
        group.range.start = group.range.start.min(span.start as usize);
        group.range.end = group.range.end.max(span.end as usize);
        group.members.push(k);
    }
    groups.retain(|group| !group.members.is_empty());
    groups
}

/// Some of the units between which a grid may be cut: rows of points, or single points where there is only one row.
#[derive(Debug, Clone)]
struct Units {
    /// Range of the units.
    range: Range<usize>,
    /// The axis whose planes hold them.
    axis: usize,
    /// Units in a plane.
    per_plane: usize,
    /// Points in a unit.
    points: usize,
}

impl Units {
    /// All of a grid.
    fn of(lattice: &Lattice) -> Self {
        let [x, y, z] = lattice.axes.map(|axis| axis.count);
        let (axis, per_plane, points) = if x > 1 {
            (0, y, z)
        } else if y > 1 {
            (1, 1, z)
        } else {
            (2, 1, 1)
        };
        Self {
            range: 0..x * y * z / points,
            axis,
            per_plane,
            points,
        }
    }

    /// The planes that they touch.
    fn planes(&self) -> Range<usize> {
        self.range.start / self.per_plane..self.range.end.div_ceil(self.per_plane)
    }

    /// From the first unit that a place may reach to behind the last; 0 to 0 if it reaches none.
    fn span(&self, lattice: &Lattice, kernel: &Kernel, place: &Placed) -> Range<u32> {
        let between = |axis: usize| {
            let half = kernel.reach() + 0.5 * place.segment[axis].abs();
            // Not less than the window, which is found by other roundings.
            let half = half * (1.0 + 1e-9);
            let at = place.centre[axis];
            lattice.axes[axis].between(at - half, at + half)
        };
        let planes = between(self.axis);
        let (low, high) = if self.axis == 0 {
            let rows = between(1);
            if rows.is_empty() || planes.is_empty() {
                return 0..0;
            }
            let line = |plane: usize, row: usize| plane * self.per_plane + row;
            (
                line(planes.start, rows.start),
                line(planes.end - 1, rows.end),
            )
        } else {
            (planes.start, planes.end)
        };
        low as u32..high.max(low) as u32
    }
}

/// Cuts the units of a group so that every part has about as much to do. Where the cuts are changes no result.
fn equal_shares(spans: &[Range<u32>], group: &Group, count: usize) -> Vec<Range<usize>> {
    let range = group.range.clone();
    if count == 1 {
        return vec![range];
    }
    let mut change = vec![0i64; range.len() + 1];
    for &k in &group.members {
        let span = &spans[k as usize];
        change[span.start as usize - range.start] += 1;
        change[span.end as usize - range.start] -= 1;
    }
    let mut height = 0;
    let mut sum = 0;
    let upto: Vec<i64> = change[..range.len()]
        .iter()
        .map(|change| {
            height += change;
            sum += height + 1;
            sum
        })
        .collect();
    let cut = |k: usize| {
        upto.partition_point(|&sum| {
            sum as f64 <= upto[upto.len() - 1] as f64 * k as f64 / count as f64
        })
    };
    let cuts = (0..=count).map(|k| match k {
        0 => range.start,
        k if k == count => range.end,
        k => range.start + cut(k),
    });
    let cuts: Vec<usize> = cuts.collect();
    cuts.windows(2).map(|ends| ends[0]..ends[1]).collect()
}

/// A part of the grid and what is spread on it.
struct Slab<'a, const F: usize> {
    lattice: &'a Lattice,
    kernel: &'a Kernel,
    layer: &'a Layer,
    first: usize,
    ball: Window,
    units: Units,
    sums: &'a mut [[f64; F]],
}

/// All of some places that reach a part of the grid are added to it.
struct AddAll<'a, W, const F: usize> {
    slab: Slab<'a, F>,
    rows: W,
    spans: &'a [Range<u32>],
    members: &'a [u32],
}

impl<W: RowWeights, const F: usize> Task for AddAll<'_, W, F> {
    #[inline(always)]
    fn run(mut self) {
        let (begin, end) = (
            self.slab.units.range.start as u32,
            self.slab.units.range.end as u32,
        );
        let placed = &self.slab.layer.placed;
        for &k in self.members {
            let span = &self.spans[k as usize];
            if span.start < end && span.end > begin {
                self.slab.add(&placed[k as usize], &mut self.rows);
            }
        }
    }
}

impl<const F: usize> Slab<'_, F> {
    #[inline(always)]
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
        let (planes, split) = (self.units.planes(), self.units.axis);
        own[split].start = own[split].start.max(planes.start);
        own[split].end = own[split].end.min(planes.end);
        if own[split].is_empty() {
            return;
        }
        // Of a single row a part; else whole rows.
        let lines = if split == 2 {
            0..1
        } else {
            self.units.range.clone()
        };
        // Tables hold the whole range, so that they are the same in every slab.
        rows.begin(place, &ranges);
        let mut values = [0.0; F];
        self.layer.load(place, self.first, &mut values);
        let mut seen = Seen {
            lattice: self.lattice,
            window: &window,
            centre: place.centre,
            own,
            lines,
            begin: self.units.range.start * self.units.points,
            sums: self.sums,
        };
        rows.add(&mut seen, &values);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sums::Spread;

    #[test]
    fn shares_cover_the_units_of_a_group_and_are_even() {
        let group = |range: Range<usize>, members: usize| Group {
            range,
            members: (0..members as u32).collect(),
        };
        let even: Vec<Range<u32>> = (10..110).map(|k| k..k + 5).collect();
        let one = equal_shares(&even, &group(10..114, 100), 1);
        assert_eq!((one.len(), one[0].clone()), (1, 10..114));
        let halves = equal_shares(&even, &group(10..114, 100), 2);
        assert!(
            halves[0].start == 10
                && halves[0].end.abs_diff(62) <= 1
                && halves[1] == (halves[0].end..114),
            "{halves:?}"
        );
        // All at one end, and more shares than units with something to do.
        for spans in [vec![0..1; 50], vec![7..8; 3], Vec::new()] {
            let shares = equal_shares(&spans, &group(0..8, spans.len()), 5);
            assert_eq!((shares[0].start, shares[4].end, shares.len()), (0, 8, 5));
            assert!(
                shares.windows(2).all(|pair| pair[0].end == pair[1].start),
                "{shares:?}"
            );
        }
    }

    /// Spread sums are the same to the bit whatever instructions the processor has.
    #[test]
    fn the_bytes_do_not_depend_on_instructions() {
        use crate::coordinates::GridAxis;
        use crate::kernel::{KernelChoice, KernelShape};
        let axis = |count: usize| GridAxis {
            min: 0.0,
            max: 1.0,
            count,
        };
        let lattice = Lattice::new([true; 3], &[axis(7), axis(9), axis(11)]);
        let mut stream = mercury_common::random::Stream::new(7, "instructions", 0);
        let mut vector = |low: f64, high: f64| {
            let mut number = || stream.uniform_in(low, high);
            DVec3::new(number(), number(), number())
        };
        let placed: Vec<Placed> = (0..40)
            .map(|row| Placed {
                centre: vector(-0.1, 1.1),
                // From none to many widths long.
                segment: vector(-1.0, 1.0) * f64::from(row % 8) * 0.1,
                row,
                mirrored: (row % 3) as u8,
            })
            .collect();
        let layer = |spread: Spread| Layer {
            spread,
            width: 9,
            parity: (0..9).map(|k| k as u8).collect(),
            values: (0..9 * 40).map(|k| libm::sin(f64::from(k))).collect(),
            placed: placed.clone(),
            spare: Vec::new(),
            origin: DVec3::ZERO,
        };
        let spread_by = |instructions: Instructions, kernel: &Kernel, layer: &Layer| {
            let mut sums = vec![[0.0; 10]; lattice.len()];
            let units = Units::of(&lattice);
            let spans: Vec<Range<u32>> = (layer.placed.iter())
                .map(|place| units.span(&lattice, kernel, place))
                .collect();
            let members: Vec<u32> = (0..40).collect();
            let slab = Slab {
                lattice: &lattice,
                kernel,
                layer,
                first: 0,
                ball: Window::ball(kernel),
                units,
                sums: &mut sums,
            };
            let (spans, members) = (&spans[..], &members[..]);
            if kernel.polynomial().is_some() {
                let rows = PolynomialRows::new(kernel, &lattice, layer.spread);
                instructions.run(AddAll {
                    slab,
                    rows,
                    spans,
                    members,
                });
            } else {
                let rows = GaussianRows::new(kernel, &lattice, layer.spread);
                instructions.run(AddAll {
                    slab,
                    rows,
                    spans,
                    members,
                });
            }
            sums.into_flattened()
                .into_iter()
                .map(f64::to_bits)
                .collect::<Vec<u64>>()
        };
        for (shape, tolerance) in [
            (KernelShape::Gaussian, 1e-3),
            (KernelShape::Gaussian, 1e-9),
            (KernelShape::Lucy, 1e-3),
        ] {
            let choice = KernelChoice {
                tolerance,
                ..KernelChoice::new(shape, 0.1)
            };
            let kernel = Kernel::new(choice, 3);
            for spread in [
                Spread::Particles,
                Spread::Gradients,
                Spread::Lines,
                Spread::Moments,
            ] {
                let layer = layer(spread);
                let [common, widest] = [Instructions::COMMON, Instructions::widest()]
                    .map(|instructions| spread_by(instructions, &kernel, &layer));
                assert!(common.iter().any(|&bits| bits != 0) && common == widest);
            }
        }
    }

    #[test]
    fn groups_hold_all_places_and_what_they_reach() {
        let each = |k: u32| {
            let at = k * 7919 % 1000;
            at.saturating_sub(40)..(at + 40).min(1000)
        };
        let spans: Vec<Range<u32>> = (0..10_000).map(each).collect();
        for (bytes, count) in [(80, 16), (1 << 20, 1)] {
            let groups = groups(&spans, 1000, bytes);
            assert_eq!(groups.len(), count);
            let mut all: Vec<u32> = Vec::new();
            for group in &groups {
                let most = 10_000 / count;
                assert!(group.members.len().abs_diff(most) <= 20 && group.members.is_sorted());
                for &k in &group.members {
                    let span = &spans[k as usize];
                    assert!(group.range.start <= span.start as usize);
                    assert!(group.range.end >= span.end as usize);
                }
                all.extend(&group.members);
            }
            all.sort_unstable();
            assert!(all.into_iter().eq(0..10_000));
        }
        assert_eq!(groups(&[0..0, 0..0], 5, 8), []);
        let few = groups(&[1..3, 0..0, 2..5], 5, 8);
        assert_eq!((few.len(), &few[0].members[..]), (1, &[0, 2][..]));
        assert_eq!(few[0].range, 1..5);
    }
}
