//! One ball per slab along the longest axis (Favier, Abbaspour-Fard, Kremmer and Raji 1999, doi:10.1108/02644409910271894).

use glam::DVec3;
use mercury_common::formats::clump::Pebble;
use rayon::prelude::*;

use super::body::Body;
use super::{Favier, GenerateError, Limits, MOST_PEBBLES, SlabRadius, Stop, volume_error};

/// Balls in the frame of the body.
pub(super) fn generate(
    body: &Body,
    options: &Favier,
    stop: &Stop,
    limits: &Limits,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<Vec<Pebble>, GenerateError> {
    let most = stop.pebbles.unwrap_or(MOST_PEBBLES);
    let Some(target) = stop.volume_error else {
        let balls = slabs(body, options.rule, most, limits)?;
        progress(balls.len(), most);
        return Ok(balls);
    };
    // The union need not grow with the number of slabs, so numbers are tried from below: 1, 2, ..., 8, 10, 12, ...
    let mut n = 1;
    let mut best: Option<(f64, Vec<Pebble>)> = None;
    let mut without_gain = 0;
    loop {
        let balls = slabs(body, options.rule, n, limits)?;
        let error = volume_error(body, &balls).abs();
        progress(balls.len(), stop.pebbles.unwrap_or(0));
        let gained = best.as_ref().is_none_or(|best| error < 0.999 * best.0);
        if gained {
            best = Some((error, balls));
            without_gain = 0;
        } else {
            without_gain += 1;
        }
        let (reached, balls) = match &mut best {
            Some((error, balls)) => (*error, balls),
            None => continue,
        };
        if reached <= target || (n == most && stop.pebbles.is_some()) {
            return Ok(std::mem::take(balls));
        }
        // A body that is not round about its axis has an error that more slabs do not lower.
        if n == most || without_gain == 12 {
            if stop.pebbles.is_some() {
                return Ok(std::mem::take(balls));
            }
            return Err(GenerateError::TargetNotReached {
                target,
                reached,
                pebbles: balls.len(),
            });
        }
        n = (n + 1 + n / 8).min(most);
    }
}

/// One ball in each of n slabs of equal thickness, without those below the smallest radius.
fn slabs(
    body: &Body,
    rule: SlabRadius,
    n: usize,
    limits: &Limits,
) -> Result<Vec<Pebble>, GenerateError> {
    let (low, high) = (body.bounds.0.x, body.bounds.1.x);
    let thickness = (high - low) / n as f64;
    let balls: Vec<Result<Option<Pebble>, GenerateError>> = (0..n)
        .into_par_iter()
        .map(|k| {
            let share = (k as f64 + 0.5) / n as f64;
            let x = low + share * (high - low);
            let position = DVec3::new(x, 0.0, 0.0);
            let depth = body.nearest(position).depth;
            if depth <= 0.0 || body.winding_number(position) < 0.5 {
                return Err(GenerateError::AxisOutside { position: share });
            }
            let slab = (x - 0.5 * thickness, x + 0.5 * thickness);
            let radius = match rule {
                SlabRadius::Smallest => depth,
                SlabRadius::Mean => slab_distances(body, position, slab).0,
                SlabRadius::Largest => slab_distances(body, position, slab).1,
            };
            let radius = radius.min(x - low).min(high - x);
            Ok((radius >= limits.smallest).then_some(Pebble {
                position,
                radius: radius + limits.protrusion,
            }))
        })
        .collect();
    // One after another, so that the first error is the one that is reported.
    let balls: Vec<Option<Pebble>> = balls.into_iter().collect::<Result<_, _>>()?;
    let balls: Vec<Pebble> = balls.into_iter().flatten().collect();
    if balls.is_empty() {
        return Err(GenerateError::NothingFits {
            smallest: (limits.smallest + limits.protrusion) * body.unit,
        });
    }
    Ok(balls)
}

/// Mean over the area and maximum of the distance from a point to the part of the surface in a slab.
///
/// The distance is a convex function, so its maximum over a cut triangle is at a corner: exact. The mean takes Gauss's
/// rule of degree 2 on the triangles that the cut makes.
fn slab_distances(body: &Body, centre: DVec3, (from, to): (f64, f64)) -> (f64, f64) {
    let (mut area, mut sum, mut largest) = (0.0, 0.0, 0.0f64);
    for face in &body.faces {
        let corners = cut(&cut(&face.corners, from, 1.0), to, -1.0);
        for corner in &corners {
            largest = largest.max(corner.distance(centre));
        }
        for k in 2..corners.len() {
            let [a, b, c] = [corners[0], corners[k - 1], corners[k]];
            let share = 0.5 * (b - a).cross(c - a).length();
            let middle = (a + b + c) / 3.0;
            for corner in [a, b, c] {
                sum += share / 3.0 * (0.5 * (middle + corner)).distance(centre);
            }
            area += share;
        }
    }
    if area > 0.0 {
        (sum / area, largest)
    } else {
        (0.0, 0.0)
    }
}

/// The part of a convex polygon on one side of a plane of constant x (Sutherland and Hodgman 1974).
fn cut(polygon: &[DVec3], x: f64, side: f64) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (k, &to) in polygon.iter().enumerate() {
        let from = polygon[(k + polygon.len() - 1) % polygon.len()];
        let (a, b) = (side * (from.x - x), side * (to.x - x));
        if (a < 0.0) != (b < 0.0) {
            kept.push(from + (to - from) * (a / (a - b)));
        }
        if b >= 0.0 {
            kept.push(to);
        }
    }
    kept
}
