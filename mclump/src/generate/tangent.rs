//! Largest empty balls tangent to the surface, taken in the order of the volume that they add.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;
use mercury_common::formats::clump::Pebble;
use mercury_common::random::Stream;
use rayon::prelude::*;

use super::ascent::ascend;
use super::body::{Body, Face};
use super::cover::Lattice;
use super::{Limits, Tangent};

/// Number of the largest tangent balls that are also moved to a local maximum of the distance to the surface.
const CLIMBERS: usize = 16;

/// Balls in order of their making: each adds, of all tangent balls, the most volume to those before.
///
/// Volume gains only fall as balls are added, so a ball whose gain was reckoned anew and is still the largest of all is the
/// best one, although the others' gains are old (Minoux 1978, doi:10.1007/BFb0006528).
pub(super) struct Balls {
    lattice: Lattice,
    candidates: Vec<Pebble>,
    /// Length that is added to each radius when gains are counted.
    protrusion: f64,
    /// Gain at the time `made`, index of the candidate.
    queue: BinaryHeap<(u32, Reverse<usize>, usize)>,
    made: usize,
}

impl Balls {
    pub(super) fn new(body: &Body, options: &Tangent, limits: Limits, seed: u64) -> Self {
        let mut candidates = tangent_balls(body, options.surface_points, limits.smallest, seed);
        // Facets of a round body let no tangent ball grow to its full size: the largest ones climb to where they fit best.
        let field = |x: DVec3| {
            let nearest = body.nearest(x);
            (nearest.depth, nearest.inward)
        };
        let best: Vec<Pebble> = candidates
            .par_iter()
            .take(CLIMBERS)
            .map(|ball| {
                let (position, radius) = ascend(&field, ball.position, 0.3 * ball.radius);
                Pebble { position, radius }
            })
            .collect();
        candidates.extend(best);
        let lattice = Lattice::new(body, options.volume_points);
        let mut balls = Self {
            lattice,
            candidates,
            protrusion: limits.protrusion,
            queue: BinaryHeap::new(),
            made: 0,
        };
        let gains: Vec<u32> = (0..balls.candidates.len())
            .into_par_iter()
            .map(|index| balls.gain(index))
            .collect();
        balls.queue = gains
            .into_iter()
            .enumerate()
            .map(|(index, gain)| (gain, Reverse(index), 0))
            .collect();
        balls
    }

    /// The next ball, unless none covers a point of the lattice that is still open.
    pub(super) fn next(&mut self) -> Option<Pebble> {
        while let Some((gain, Reverse(index), at)) = self.queue.pop() {
            if gain == 0 {
                break;
            }
            if at < self.made {
                self.queue
                    .push((self.gain(index), Reverse(index), self.made));
                continue;
            }
            self.made += 1;
            self.lattice.cover(&self.inflated(index));
            return Some(self.candidates[index]);
        }
        None
    }

    fn inflated(&self, index: usize) -> Pebble {
        let ball = self.candidates[index];
        Pebble {
            radius: ball.radius + self.protrusion,
            ..ball
        }
    }

    fn gain(&self, index: usize) -> u32 {
        self.lattice.gain(&self.inflated(index))
    }
}

/// Balls from the incentre of each triangle (as far as there are not more of them than requested points) and from random points,
/// uniform on the surface, largest first.
fn tangent_balls(body: &Body, points: usize, smallest: f64, seed: u64) -> Vec<Pebble> {
    let mut starts: Vec<(DVec3, usize)> = Vec::with_capacity(2 * points);
    if body.faces.len() <= points {
        let incentres = body.faces.iter().enumerate();
        starts.extend(incentres.map(|(index, face)| (incentre(face), index)));
    }
    let mut stream = Stream::new(seed, "tangent spheres", 0);
    starts.extend(body.surface_points(points, &mut stream));
    let mut balls: Vec<Pebble> = starts
        .into_par_iter()
        .filter_map(|(start, face)| tangent_ball(body, start, face, smallest))
        .collect();
    balls.sort_by(|a, b| b.radius.total_cmp(&a.radius));
    balls
}

/// Where the inscribed circle of a triangle has its centre: a ball tangent there keeps the largest distance to the edges.
fn incentre(face: &Face) -> DVec3 {
    let [a, b, c] = face.corners;
    let (la, lb, lc) = (b.distance(c), c.distance(a), a.distance(b));
    (la * a + lb * b + lc * c) / (la + lb + lc)
}

/// The largest ball inside that touches the surface at a point of a face.
///
/// A ball with radius r that touches the start p with the inward normal n passes through a point b at
/// `r = |b - p|² / (2 (b - p)·n)`; the largest empty ball is the least of these over all surface points with
/// (b - p)·n > 0. Shrinking to the radius of the point nearest to the centre, again and again, comes down to that least
/// radius (Ma, Bae and Choi 2012, doi:10.1007/s00371-011-0594-7, for point sets; here the nearest point is that of the
/// triangles). Where the ball with `r = (b - p)·m / (1 + m·n)` touches the plane of the nearest triangle
/// (outward normal m) inside that triangle, it is taken, which saves most of the steps.
fn tangent_ball(body: &Body, start: DVec3, face: usize, smallest: f64) -> Option<Pebble> {
    let inward = -body.faces[face].normal;
    let (low, high) = body.bounds;
    let mut radius = 0.5 * high.distance(low);
    for _ in 0..200 {
        let centre = start + radius * inward;
        let nearest = body.nearest(centre);
        let distance = nearest.depth.abs();
        if distance >= radius * (1.0 - 1e-10) || nearest.face == face {
            break;
        }
        let chord = nearest.point - start;
        let mut next = chord.length_squared() / (2.0 * chord.dot(inward));
        let below = chord.dot(nearest.normal);
        let tilt = 1.0 + nearest.normal.dot(inward);
        if below > 0.0 && tilt > 1e-9 {
            let planar = below / tilt;
            let touch = start + planar * (inward + nearest.normal);
            if planar < next && body.faces[nearest.face].contains(touch) {
                next = planar;
            }
        }
        if !(next < radius && next >= smallest) {
            // No progress is round-off at tangency; a NaN or less than the smallest radius ends the ball.
            if next >= radius {
                break;
            }
            return None;
        }
        radius = next;
    }
    // Tangency is reached up to round-off; being inside is not left to it.
    let position = start + radius * inward;
    let depth = body.nearest(position).depth;
    (depth >= smallest).then_some(Pebble {
        position,
        radius: radius.min(depth),
    })
}
