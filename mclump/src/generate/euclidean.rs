//! The largest ball that fits beside those placed, again and again.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::DVec3;
use mercury_common::formats::clump::Pebble;
use rayon::prelude::*;

use super::Euclidean;
use super::ascent::{Cut, DistanceField, ascend};
use super::body::Body;

/// Cells that are cut into eight at once; a constant, so that results do not depend on the number of threads.
const BATCH: usize = 64;
/// Cells in memory at most (about 150 MB). A body that needs more is so thin that the bound on the search is given up, not the
/// tangency.
const MOST_CELLS: usize = 2_000_000;

/// Inscribed balls in order of their making.
///
/// The field D grows by at most 1 per unit of length, so in a cell with centre x and half diagonal h it stays below D(x) + h. Cells that
/// could hold the maximum are cut into eight until the best ball known is within [`Euclidean::accuracy`] of every bound. Balls only
/// lower the field, so all bounds stay valid, and what was learnt of the distance to the surface is never computed twice.
pub(super) struct Balls<'a> {
    body: &'a Body,
    options: Euclidean,
    smallest: f64,
    largest: f64,
    cells: BinaryHeap<Cell>,
    made: u64,
    /// Space that is taken: balls shrunk by the overlap.
    taken: Vec<Pebble>,
    /// Tops of the field that were climbed and not used yet.
    tops: Vec<(DVec3, f64)>,
}

struct Cell {
    /// The field is at most this anywhere in the cell.
    bound: f64,
    centre: DVec3,
    half_edge: f64,
    /// The field at the centre as far as `seen` balls.
    value: f64,
    seen: usize,
    /// Cells of equal bound come in order of their making.
    number: u64,
}

impl Ord for Cell {
    fn cmp(&self, other: &Self) -> Ordering {
        self.bound
            .total_cmp(&other.bound)
            .then(other.number.cmp(&self.number))
    }
}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Cell {}

/// Half diagonal of a cube over its half edge.
const DIAGONAL: f64 = 1.732_050_807_568_877_2;

impl<'a> Balls<'a> {
    pub(super) fn new(body: &'a Body, options: &Euclidean, smallest: f64) -> Self {
        let (low, high) = body.bounds;
        let half_edge = low.abs().max(high.abs()).max_element();
        let value = body.nearest(DVec3::ZERO).depth;
        let root = Cell {
            bound: value + DIAGONAL * half_edge,
            centre: DVec3::ZERO,
            half_edge,
            value,
            seen: 0,
            number: 0,
        };
        let mut balls = Self {
            body,
            options: *options,
            smallest,
            largest: f64::INFINITY,
            cells: BinaryHeap::from([root]),
            made: 1,
            taken: Vec::new(),
            tops: Vec::new(),
        };
        if options.largest_radius_ratio < 1.0
            && let Some((_, radius)) = balls.top()
        {
            balls.largest = options.largest_radius_ratio * radius;
        }
        balls
    }

    /// The next ball, unless its radius would be below the smallest.
    pub(super) fn next(&mut self) -> Option<Pebble> {
        loop {
            let (position, value) = self.top()?;
            self.tops.retain(|top| top.0 != position);
            let radius = value.min(self.largest);
            // Where surfaces cut each other pseudo-normals can mislead; the winding number cannot.
            let inside = self.body.winding_number(position) > 0.5;
            self.take(Pebble {
                position,
                radius: if inside {
                    (1.0 - self.options.overlap) * radius
                } else {
                    value
                },
            });
            if inside {
                return Some(Pebble { position, radius });
            }
        }
    }

    /// Takes space away and brings the known tops up to date.
    fn take(&mut self, ball: Pebble) {
        self.taken.push(ball);
        for top in &mut self.tops {
            top.1 = top.1.min(distance(top.0, &ball));
        }
        let smallest = self.smallest;
        self.tops.retain(|top| top.1 >= smallest);
    }

    fn field(&self) -> Field<'_> {
        Field {
            body: self.body,
            taken: &self.taken,
        }
    }

    /// A place where the field is at least (1 - accuracy) of its maximum and at a local maximum, if it is `smallest` there.
    fn top(&mut self) -> Option<(DVec3, f64)> {
        let keep = 1.0 - self.options.accuracy;
        loop {
            let best = self.best().map_or(0.0, |top| top.1);
            let batch = self.batch(best / keep);
            if batch.is_empty() {
                let (start, value) = self.best()?;
                let field = self.field();
                let top = ascend(&field, start, 0.3 * value);
                self.tops.retain(|known| known.0 != start);
                if top.1 < self.smallest {
                    continue;
                }
                self.tops.push(top);
                return Some(top);
            }
            self.refine(&batch, best);
        }
    }

    /// The highest of the known tops.
    fn best(&self) -> Option<(DVec3, f64)> {
        let higher = |best: Option<(DVec3, f64)>, top: &(DVec3, f64)| match best {
            Some(known) if known.1 >= top.1 => Some(known),
            _ => Some(*top),
        };
        self.tops.iter().fold(None, higher)
    }

    /// Takes cells whose bound is above the limit (and the smallest radius).
    fn batch(&mut self, limit: f64) -> Vec<Cell> {
        let limit = limit.max(self.smallest);
        let mut batch = Vec::new();
        while batch.len() < BATCH && self.cells.peek().is_some_and(|cell| cell.bound > limit) {
            let Some(mut cell) = self.cells.pop() else {
                break;
            };
            if cell.seen < self.taken.len() {
                for ball in &self.taken[cell.seen..] {
                    cell.value = cell.value.min(distance(cell.centre, ball));
                }
                cell.seen = self.taken.len();
                cell.bound = cell.bound.min(cell.value + DIAGONAL * cell.half_edge);
                if cell.bound > self.smallest {
                    self.cells.push(cell);
                }
            } else {
                batch.push(cell);
            }
        }
        batch
    }

    /// Cuts cells into eight; climbs from the best centre if it promises more than what is known.
    fn refine(&mut self, batch: &[Cell], best: f64) {
        let field = self.field();
        let full = self.cells.len() + 8 * BATCH > MOST_CELLS;
        let children: Vec<(DVec3, f64, f64)> = batch
            .par_iter()
            .flat_map_iter(|cell| {
                let half_edge = if full { 0.0 } else { 0.5 * cell.half_edge };
                let corners = if full { 1 } else { 8u8 };
                (0..corners).map(move |k| {
                    let sign = |bit: u8| if k >> bit & 1 == 1 { 1.0 } else { -1.0 };
                    let corner = DVec3::new(sign(0), sign(1), sign(2));
                    (cell.centre + half_edge * corner, half_edge)
                })
            })
            .map(|(centre, half_edge)| (centre, half_edge, field.at(centre).0))
            .collect();
        let mut start: Option<(DVec3, f64, f64)> = None;
        for &(centre, half_edge, value) in &children {
            if value > best.max(start.map_or(0.0, |s| s.1)) {
                start = Some((centre, value, half_edge));
            }
        }
        if let Some((centre, value, half_edge)) = start {
            let top = ascend(&field, centre, half_edge.max(0.05 * value));
            if top.1 >= self.smallest {
                self.tops.push(top);
            }
        }
        if full {
            return;
        }
        for (centre, half_edge, value) in children {
            let bound = value + DIAGONAL * half_edge;
            if bound > self.smallest {
                self.cells.push(Cell {
                    bound,
                    centre,
                    half_edge,
                    value,
                    seen: self.taken.len(),
                    number: self.made,
                });
                self.made += 1;
            }
        }
    }
}

/// The distance to the surface and to the space that is taken.
struct Field<'a> {
    body: &'a Body,
    taken: &'a [Pebble],
}

impl DistanceField for Field<'_> {
    fn at(&self, x: DVec3) -> (f64, DVec3) {
        let surface = self.body.nearest(x);
        let mut nearest = None;
        let mut value = surface.depth;
        for ball in self.taken {
            let distance = distance(x, ball);
            if distance < value {
                value = distance;
                nearest = Some(ball);
            }
        }
        let slope = match nearest {
            Some(ball) => (x - ball.position).normalize_or(DVec3::X),
            None => surface.inward,
        };
        (value, slope)
    }

    /// The balls near x. Their distances are convex functions, so the linear model is on the safe side.
    fn known(&self, x: DVec3, value: f64, limit: f64) -> Vec<Cut> {
        let near = |ball: &Pebble| {
            let distance = distance(x, ball);
            (distance <= limit).then(|| Cut {
                excess: (distance - value).max(0.0),
                slope: (x - ball.position).normalize_or(DVec3::X),
            })
        };
        self.taken.iter().filter_map(near).collect()
    }
}

/// From a point to a ball.
fn distance(x: DVec3, ball: &Pebble) -> f64 {
    x.distance(ball.position) - ball.radius
}
