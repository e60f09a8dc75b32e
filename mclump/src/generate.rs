//! Generators of pebbles from a closed surface.
//!
//! | method | idea | for |
//! |---|---|---|
//! | [`Euclidean`] | the largest ball that fits beside those placed, again and again | compact bodies, few large pebbles |
//! | [`Tangent`] | largest empty balls tangent to the surface at many points; those that add most volume are taken | any body; least volume error for a number of pebbles |
//! | [`Method::Favier`] | one ball per slab along the longest axis | bodies of revolution |
//!
//! All work on exact distances to the triangles, in a frame of the body (origin at its centre, axes its principal axes, unit length
//! the radius of the ball of equal volume). So a moved, turned or scaled surface gives the moved, turned or scaled pebbles, up to round-off, as far
//! as the principal axes are unique. See `docs/theory/pebble-generators.md`.

pub(crate) mod ascent;
pub(crate) mod body;
mod columns;
mod cover;
mod error;
mod euclidean;
mod favier;
#[cfg(test)]
pub(crate) mod shapes;
mod tangent;
#[cfg(test)]
mod tests;

use mercury_common::formats::clump::Pebble;
use mercury_common::formats::mesh::TriangleMesh;

use body::Body;
pub use error::GenerateError;

/// The largest number of pebbles that a generator makes when only a fidelity is given.
pub const MOST_PEBBLES: usize = 100_000;

/// The request to a generator.
///
/// ```
/// use mclump::generate::{Method, Request, Stop, Tangent};
/// let request = Request {
///     method: Method::Tangent(Tangent::default()),
///     stop: Stop { pebbles: Some(100), volume_error: Some(0.02) },
///     ..Request::default()
/// };
/// assert_eq!(request.seed, 0);
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Request {
    /// The algorithm and its parameters.
    pub method: Method,
    /// When to stop.
    pub stop: Stop,
    /// No pebble has a smaller radius, in m. 0 stands for 1/1000 of the radius of the ball of equal volume.
    pub smallest_radius: f64,
    /// How far each pebble may stand out of the surface, in m: radii are those of inscribed balls plus this length.
    /// 0: all pebbles are inside.
    pub protrusion: f64,
    /// Seed of the random points of [`Tangent`]; the other methods draw nothing.
    pub seed: u64,
}

/// When a generator stops: at what comes first. At least one must be given.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Stop {
    /// Number of pebbles, at least 1. Fewer come out if no more fit (see [`Request::smallest_radius`]).
    pub pebbles: Option<usize>,
    /// Share by which the union may be lighter than the body, in (0, 1). [`Method::Favier`], whose union need not grow with its
    /// number, takes the difference in both directions.
    pub volume_error: Option<f64>,
}

/// An algorithm with its parameters.
#[derive(Debug, Clone, PartialEq)]
pub enum Method {
    /// Largest balls by the distance field.
    Euclidean(Euclidean),
    /// Largest empty tangent balls and a greedy cover.
    Tangent(Tangent),
    /// One ball per slab of the longest principal axis, as large as fits.
    Favier,
}

impl Default for Method {
    fn default() -> Self {
        Self::Tangent(Tangent::default())
    }
}

/// Inscribed balls by the distance field.
///
/// The field is `D(x) = min(distance to the surface, min_i |x - c_i| - (1 - overlap) r_i)`; the next ball has its centre where D
/// is largest and the radius D.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Euclidean {
    /// Share of the radius of a placed ball that others may enter, in [0, 1). 0: balls touch at most.
    pub overlap: f64,
    /// No radius is larger than this share of the largest inscribed one, in (0, 1].
    pub largest_radius_ratio: f64,
    /// A ball may be smaller than the largest that fits by this share, in [1e-4, 0.5]. It bounds the search, not the
    /// tangency.
    pub accuracy: f64,
}

impl Default for Euclidean {
    fn default() -> Self {
        Self {
            overlap: 0.6,
            largest_radius_ratio: 1.0,
            accuracy: 0.1,
        }
    }
}

/// Balls tangent to the surface, taken in the order of the volume that they add.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tangent {
    /// Surface points to start balls from, beside the incentres of the triangles; at least 1.
    pub surface_points: usize,
    /// Points inside the body that stand for its volume when balls are compared, about this many; at least 100.
    pub volume_points: usize,
}

impl Default for Tangent {
    fn default() -> Self {
        Self {
            surface_points: 20_000,
            volume_points: 200_000,
        }
    }
}

/// Makes pebbles for a closed surface with outward normals.
///
/// The pebbles come in the frame of the mesh with radii that do not increase, and depend on mesh and request only, not on the
/// number of threads. `progress` is called with the number of pebbles so far and the requested number (0 if there is none).
///
/// # Errors
/// If the surface is not closed or not oriented outward, a parameter is outside its range, no pebble fits, or the
/// requested volume error (without number of pebbles) cannot be reached.
pub fn generate(
    mesh: &TriangleMesh,
    request: &Request,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<Vec<Pebble>, GenerateError> {
    check(request)?;
    let body = Body::new(mesh)?;
    let limits = Limits {
        smallest: if request.smallest_radius > 0.0 {
            (request.smallest_radius - request.protrusion) / body.unit
        } else {
            1e-3
        }
        .max(1e-6),
        protrusion: request.protrusion / body.unit,
    };
    let total = request.stop.pebbles.unwrap_or(0);
    let mut pebbles = match &request.method {
        Method::Favier => favier::generate(&body, &request.stop, &limits, progress)?,
        Method::Euclidean(options) => {
            let mut balls = euclidean::Balls::new(&body, options, limits.smallest);
            let mut next = || balls.next();
            collect(&body, &request.stop, &limits, &mut next, &mut |done| {
                progress(done, total);
            })?
        }
        Method::Tangent(options) => {
            let mut balls = tangent::Balls::new(&body, options, limits, request.seed);
            let mut next = || balls.next();
            collect(&body, &request.stop, &limits, &mut next, &mut |done| {
                progress(done, total);
            })?
        }
    };
    // Stable: equal radii stay in the order of their making.
    pebbles.sort_by(|a, b| b.radius.total_cmp(&a.radius));
    Ok(pebbles
        .into_iter()
        .map(|pebble| body.to_mesh(&pebble))
        .collect())
}

/// Makes pebbles whose union has the volume of the body, to about 1e-4, by letting all stand out alike; returns this protrusion (m) as well.
///
/// The balls are chosen twice: inscribed, which gives about their protrusion, and for that protrusion. The radii are
/// then grown until the volume is right. The request's own protrusion is not used.
///
/// # Errors
/// As [`generate`].
pub fn generate_of_volume(
    mesh: &TriangleMesh,
    request: &Request,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<(Vec<Pebble>, f64), GenerateError> {
    let body = Body::new(mesh)?;
    let mut protrusion = 0.0;
    let mut pebbles = Vec::new();
    for _ in 0..2 {
        let request = Request {
            protrusion,
            // The smallest radius is that of the inscribed balls, which only grow.
            smallest_radius: match request.smallest_radius > 0.0 {
                true => request.smallest_radius + protrusion,
                false => 0.0,
            },
            ..request.clone()
        };
        let inscribed: Vec<Pebble> = generate(mesh, &request, progress)?
            .iter()
            .map(|pebble| grown(&body.to_body(pebble), -protrusion / body.unit))
            .collect();
        let growth = growth_to_volume(&body, &inscribed);
        protrusion = growth * body.unit;
        let balls = inscribed
            .iter()
            .map(|ball| body.to_mesh(&grown(ball, growth)));
        pebbles = balls.collect();
    }
    Ok((pebbles, protrusion))
}

fn grown(ball: &Pebble, by: f64) -> Pebble {
    Pebble {
        radius: ball.radius + by,
        ..*ball
    }
}

/// Growth of the radii of balls at which their union has the volume of the body, in its frame; 0 if it has more.
fn growth_to_volume(body: &Body, balls: &[Pebble]) -> f64 {
    let is_enough = |growth: f64| {
        let balls: Vec<Pebble> = balls.iter().map(|ball| grown(ball, growth)).collect();
        volume_error(body, &balls) >= 0.0
    };
    if is_enough(0.0) {
        return 0.0;
    }
    // A ball of radius 1 has the volume of the body; the volume itself is known to 1e-4.
    let (mut low, mut high) = (0.0, 1.0);
    while high - low > 1e-6 {
        let middle = 0.5 * (low + high);
        if is_enough(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

/// Lengths of a request in units of the body.
#[derive(Debug, Clone, Copy)]
struct Limits {
    /// Smallest radius of an inscribed ball.
    smallest: f64,
    protrusion: f64,
}

/// Takes balls until the request is met. The first n balls do not depend on how many follow.
fn collect(
    body: &Body,
    stop: &Stop,
    limits: &Limits,
    next: &mut dyn FnMut() -> Option<Pebble>,
    progress: &mut dyn FnMut(usize),
) -> Result<Vec<Pebble>, GenerateError> {
    let most = stop.pebbles.unwrap_or(MOST_PEBBLES);
    let mut pebbles: Vec<Pebble> = Vec::new();
    let mut looked_at = 0;
    loop {
        let exhausted = match next().filter(|_| pebbles.len() < most) {
            Some(mut pebble) => {
                pebble.radius += limits.protrusion;
                pebbles.push(pebble);
                progress(pebbles.len());
                pebbles.len() == most
            }
            None => true,
        };
        // The union is measured at n = 1, 2, 3, ..., 8, 10, 12, ..., so the cost stays a small multiple of the last.
        let due = pebbles.len() >= looked_at + 1 + looked_at / 8;
        if let Some(target) = stop.volume_error.filter(|_| due || exhausted) {
            // Lighter by no more than the target; with protrusion the union ends up a little heavier than the body.
            let enough = |n: usize| -volume_error(body, &pebbles[..n]) <= target;
            let n = pebbles.len();
            if n > 0 && enough(n) {
                // Between the last look and here: the union grows with each ball.
                let (mut low, mut high) = (looked_at, n);
                while high - low > 1 {
                    let middle = low.midpoint(high);
                    if enough(middle) {
                        high = middle;
                    } else {
                        low = middle;
                    }
                }
                pebbles.truncate(high);
                return Ok(pebbles);
            }
            looked_at = n;
        }
        if exhausted {
            if pebbles.is_empty() {
                return Err(GenerateError::NothingFits {
                    smallest: (limits.smallest + limits.protrusion) * body.unit,
                });
            }
            if let (Some(target), None) = (stop.volume_error, stop.pebbles) {
                return Err(GenerateError::TargetNotReached {
                    target,
                    reached: volume_error(body, &pebbles).abs(),
                    pebbles: pebbles.len(),
                });
            }
            return Ok(pebbles);
        }
    }
}

/// The largest inscribed ball in the frame of the body, smaller than the largest possible by at most the accuracy.
pub(crate) fn largest_inscribed(body: &Body, options: &Euclidean) -> Option<Pebble> {
    euclidean::Balls::new(body, options, 1e-6).next()
}

/// Volume of the union of balls in the frame of the body over that of the body, less 1.
fn volume_error(body: &Body, balls: &[Pebble]) -> f64 {
    let bounds = balls.iter().fold(body.bounds, |(low, high), ball| {
        let (position, radius) = (ball.position, ball.radius);
        (low.min(position - radius), high.max(position + radius))
    });
    columns::union_volume(balls, bounds) / body.volume - 1.0
}

fn check(request: &Request) -> Result<(), GenerateError> {
    let bad = |name, value: f64, expected| {
        Err(GenerateError::Parameter {
            name,
            value,
            expected,
        })
    };
    let length = "a finite length of at least 0 m";
    if !(request.smallest_radius >= 0.0 && request.smallest_radius.is_finite()) {
        return bad("smallest radius", request.smallest_radius, length);
    }
    if !(request.protrusion >= 0.0 && request.protrusion.is_finite()) {
        return bad("protrusion", request.protrusion, length);
    }
    match request.stop {
        Stop {
            pebbles: None,
            volume_error: None,
        } => return Err(GenerateError::NoStop),
        Stop {
            pebbles: Some(0), ..
        } => return bad("number of pebbles", 0.0, "at least 1"),
        Stop {
            volume_error: Some(error),
            ..
        } if !(error > 0.0 && error < 1.0) => {
            return bad("volume error", error, "a share above 0 and below 1");
        }
        _ => {}
    }
    match request.method {
        Method::Euclidean(Euclidean { overlap, .. }) if !(0.0..1.0).contains(&overlap) => {
            bad("overlap", overlap, "at least 0 and below 1")
        }
        Method::Euclidean(Euclidean {
            largest_radius_ratio: ratio,
            ..
        }) if !(ratio > 0.0 && ratio <= 1.0) => {
            bad("largest radius ratio", ratio, "above 0 and at most 1")
        }
        Method::Euclidean(Euclidean { accuracy, .. }) if !(1e-4..=0.5).contains(&accuracy) => {
            bad("accuracy", accuracy, "a share from 0.0001 to 0.5")
        }
        Method::Tangent(Tangent {
            surface_points: 0, ..
        }) => bad("number of surface points", 0.0, "at least 1"),
        Method::Tangent(Tangent { volume_points, .. }) if volume_points < 100 => bad(
            "number of volume points",
            volume_points as f64,
            "at least 100",
        ),
        _ => Ok(()),
    }
}
