//! The space that at least one pebble covers, each point counted once.
//!
//! A plane x = const cuts the union of balls in a union of discs. Area, first and second moments of that are known in closed form
//! (`union/discs.rs`), so only one integral over x remains. It is smooth but at planes where a ball, or the circle in which
//! two balls meet, begins or ends on the surface of the union; these are the borders of the panels. Where three balls meet in a
//! point it has a jump in the second derivative, which bisection takes care of. Pebbles that do not overlap are
//! integrated exactly, for the integrand is then a polynomial of degree 4 in each panel.

mod discs;

use glam::DVec3;
use mercury_common::formats::clump::Pebble;
use rayon::prelude::*;

use super::pebbles::{integrate as every_pebble, middle};
use super::{DMat3Sum, Estimate, RawMoments, pairwise_sum};
use discs::{Disc, Section, union_of_discs};

/// Default relative accuracy.
pub const DEFAULT_TOLERANCE: f64 = 1e-6;
/// A panel is bisected at most so often: 2^-40 of a pebble is far below every tolerance.
const MOST_BISECTIONS: u32 = 40;
/// Nodes and weights of Gauss and Legendre's rule with three points on [-1, 1], exact up to degree 5.
const GAUSS: [(f64, f64); 3] = [
    (-0.774_596_669_241_483_4, 5.0 / 9.0),
    (0.0, 8.0 / 9.0),
    (0.774_596_669_241_483_4, 5.0 / 9.0),
];

/// Volume, centre and second moments of the union, to the relative accuracy `tolerance` (clamped to 1e-12 and
/// 0.1), with an error estimate; `None` without pebbles.
///
/// The estimate is twice the sum over panels of the differences between one and two panels of Gauss's rule: twice, because where
/// an intersection of balls begins within a panel both may be off. The true error is usually far smaller. The result is the same at any number of threads.
#[must_use]
pub fn integrate(pebbles: &[Pebble], tolerance: f64) -> Option<Estimate> {
    let origin = middle(pebbles)?;
    let tolerance = tolerance.clamp(1e-12, 0.1);
    let balls = without_hidden(pebbles, origin);
    let slices = Slices::new(&balls);
    // Scale of the tolerance: the union is at least as large as its largest ball, and not larger than the sum.
    let scale = slices.scale(every_pebble(&balls)?.volume);
    let length: f64 = slices
        .panels
        .iter()
        .map(|panel| panel.to - panel.from)
        .sum();
    let parts: Vec<(RawMoments, RawMoments)> = slices
        .panels
        .par_iter()
        .map(|panel| {
            let allowed = scale.map(|s| tolerance * s / length);
            slices.integrate(panel, &allowed)
        })
        .collect();
    let values: Vec<RawMoments> = parts.iter().map(|part| part.0).collect();
    let errors: Vec<RawMoments> = parts.iter().map(|part| part.1).collect();
    let sum = pairwise_sum(&values);
    let error = pairwise_sum(&errors);
    let properties = sum.central(origin);
    let trace = properties.second_moment.diagonal_trace();
    let second = error.second.diagonal.max_element() + error.second.mixed.max_element();
    Some(Estimate {
        properties,
        relative_error: 2.0 * (error.volume / sum.volume).max(second / trace),
    })
}

trait Trace {
    fn diagonal_trace(&self) -> f64;
}

impl Trace for glam::DMat3 {
    fn diagonal_trace(&self) -> f64 {
        self.x_axis.x + self.y_axis.y + self.z_axis.z
    }
}

/// The balls about `origin`, without those that lie wholly in another one.
fn without_hidden(pebbles: &[Pebble], origin: DVec3) -> Vec<Pebble> {
    let balls: Vec<Pebble> = pebbles
        .iter()
        .map(|pebble| Pebble {
            position: pebble.position - origin,
            radius: pebble.radius,
        })
        .collect();
    let is_hidden = |i: usize| {
        let ball = &balls[i];
        balls.iter().enumerate().any(|(j, other)| {
            let gap = other.radius - ball.radius;
            // Of equal balls the first stays.
            let inside = gap >= 0.0 && ball.position.distance(other.position) <= gap;
            inside && j != i && (*other != *ball || j < i)
        })
    };
    let hidden: Vec<bool> = (0..balls.len()).into_par_iter().map(is_hidden).collect();
    let mut keep = hidden.iter().map(|hidden| !hidden);
    let mut balls = balls;
    balls.retain(|_| keep.next().unwrap_or(true));
    balls
}

/// Where the circles in which two balls meet begin and end along x, if that is on the surface of the union. Gauss's points stay
/// away from the ends of a panel: a circle that begins near one would be missed, and no difference would tell.
fn circle_ends(balls: &[Pebble]) -> Vec<f64> {
    let of_one = |i: usize| {
        let ball = &balls[i];
        let meets = |j: &usize| {
            let (other, reach) = (&balls[*j], balls[*j].radius + ball.radius);
            *j != i && ball.position.distance_squared(other.position) < reach * reach
        };
        let neighbours: Vec<usize> = (0..balls.len()).filter(meets).collect();
        let mut ends = Vec::new();
        for &j in neighbours.iter().filter(|&&j| j > i) {
            let other = &balls[j];
            let between = other.position - ball.position;
            let distance = between.length();
            let normal = between / distance;
            // The plane of the circle, from the ball's centre: law of cosines.
            let (a, b) = (ball.radius, other.radius);
            let offset = 0.5 * (distance + (a - b) * (a + b) / distance);
            let square = (a - offset) * (a + offset);
            if square.is_nan() || square <= 0.0 {
                continue;
            }
            let centre = ball.position + offset * normal;
            // The direction in the plane that goes along x the most.
            let along = DVec3::X - normal * normal.x;
            let Some(along) = along.try_normalize() else {
                continue;
            };
            for point in [1.0, -1.0].map(|sign| centre + sign * square.sqrt() * along) {
                let hides = |k: usize| {
                    k != j
                        && point.distance_squared(balls[k].position)
                            < balls[k].radius.powi(2) * (1.0 - 1e-9)
                };
                if !neighbours.iter().any(|&k| hides(k)) {
                    ends.push(point.x);
                }
            }
        }
        ends
    };
    let all: Vec<Vec<f64>> = (0..balls.len()).into_par_iter().map(of_one).collect();
    all.concat()
}

/// Planes between which no ball begins or ends, and the balls they cut.
struct Slices<'a> {
    balls: &'a [Pebble],
    panels: Vec<Panel>,
}

struct Panel {
    from: f64,
    to: f64,
    /// Balls that are cut by every plane of the panel.
    balls: Vec<u32>,
}

impl<'a> Slices<'a> {
    fn new(balls: &'a [Pebble]) -> Self {
        let mut borders: Vec<f64> = balls
            .iter()
            .flat_map(|ball| [ball.position.x - ball.radius, ball.position.x + ball.radius])
            .collect();
        borders.extend(circle_ends(balls));
        borders.sort_by(f64::total_cmp);
        borders.dedup();
        let panels = borders
            .windows(2)
            .map(|pair| {
                let (from, to) = (pair[0], pair[1]);
                let middle = 0.5 * (from + to);
                let cut = |ball: &Pebble| (middle - ball.position.x).abs() < ball.radius;
                let balls = balls.iter().zip(0u32..).filter(|(ball, _)| cut(ball));
                Panel {
                    from,
                    to,
                    balls: balls.map(|(_, index)| index).collect(),
                }
            })
            .filter(|panel| !panel.balls.is_empty())
            .collect();
        Self { balls, panels }
    }

    /// Sizes of the ten integrals, for tolerances: volume times powers of the extent.
    fn scale(&self, sum: f64) -> [f64; 10] {
        let extent = self
            .balls
            .iter()
            .map(|ball| ball.position.length() + ball.radius)
            .fold(0.0, f64::max);
        let largest = self
            .balls
            .iter()
            .map(|ball| super::pebbles::volume(ball.radius))
            .fold(0.0, f64::max);
        // A crude integral over the panels gives the share of the sum that is left after overlaps.
        let crude: f64 = self
            .panels
            .iter()
            .map(|panel| self.gauss(panel, panel.from, panel.to).volume)
            .sum();
        let volume = crude.clamp(largest, sum.max(largest));
        let second = volume * extent * extent * 0.1;
        let first = volume * extent;
        [
            volume, first, first, first, second, second, second, second, second, second,
        ]
    }

    /// The integral over a panel and its estimated error.
    fn integrate(&self, panel: &Panel, allowed: &[f64; 10]) -> (RawMoments, RawMoments) {
        let whole = self.gauss(panel, panel.from, panel.to);
        self.bisect(panel, panel.from, panel.to, &whole, allowed, 0)
    }

    /// Halves an interval until one and two panels agree to `allowed` per length.
    fn bisect(
        &self,
        panel: &Panel,
        from: f64,
        to: f64,
        whole: &RawMoments,
        allowed: &[f64; 10],
        depth: u32,
    ) -> (RawMoments, RawMoments) {
        let middle = 0.5 * (from + to);
        let left = self.gauss(panel, from, middle);
        let right = self.gauss(panel, middle, to);
        let mut both = left;
        both.add(&right);
        let (a, b) = (both.to_array(), whole.to_array());
        let mut differences = [0.0; 10];
        let mut good = true;
        for k in 0..10 {
            differences[k] = (a[k] - b[k]).abs();
            good &= differences[k] <= allowed[k] * (to - from);
        }
        if good || depth >= MOST_BISECTIONS || middle <= from || middle >= to {
            return (both, RawMoments::from_array(differences));
        }
        let (mut sum, mut error) = self.bisect(panel, from, middle, &left, allowed, depth + 1);
        let (right, right_error) = self.bisect(panel, middle, to, &right, allowed, depth + 1);
        sum.add(&right);
        error.add(&right_error);
        (sum, error)
    }

    /// Three points of Gauss's rule on an interval.
    fn gauss(&self, panel: &Panel, from: f64, to: f64) -> RawMoments {
        let (centre, half) = (0.5 * (from + to), 0.5 * (to - from));
        let mut sum = RawMoments::default();
        for (node, weight) in GAUSS {
            let x = centre + half * node;
            let section = self.section(panel, x);
            let w = weight * half;
            let [u, v] = section.first;
            let [uu, uv, vv] = section.second;
            sum.add(&RawMoments {
                volume: w * section.area,
                first: w * DVec3::new(x * section.area, u, v),
                second: DMat3Sum {
                    diagonal: w * DVec3::new(x * x * section.area, uu, vv),
                    mixed: w * DVec3::new(x * u, x * v, uv),
                },
            });
        }
        sum
    }

    /// The cut of the union with the plane at x.
    fn section(&self, panel: &Panel, x: f64) -> Section {
        let discs: Vec<Disc> = panel
            .balls
            .iter()
            .filter_map(|&index| {
                let ball = &self.balls[index as usize];
                let dx = x - ball.position.x;
                let square = (ball.radius - dx) * (ball.radius + dx);
                (square > 0.0).then(|| Disc {
                    u: ball.position.y,
                    v: ball.position.z,
                    radius: square.sqrt(),
                })
            })
            .collect();
        union_of_discs(&discs)
    }
}
