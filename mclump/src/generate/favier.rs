//! One ball per slab along the longest axis (Favier, Abbaspour-Fard, Kremmer and Raji 1999, doi:10.1108/02644409910271894).

use glam::DVec3;
use mercury_common::formats::clump::Pebble;
use rayon::prelude::*;

use super::body::Body;
use super::{GenerateError, Limits, MOST_PEBBLES, Stop, volume_error};

/// Balls in the frame of the body.
pub(super) fn generate(
    body: &Body,
    stop: &Stop,
    limits: &Limits,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<Vec<Pebble>, GenerateError> {
    let most = stop.pebbles.unwrap_or(MOST_PEBBLES);
    let Some(target) = stop.volume_error else {
        let balls = slabs(body, most, limits)?;
        progress(balls.len(), most);
        return Ok(balls);
    };
    // The union need not grow with the number of slabs, so numbers are tried from below: 1, 2, ..., 8, 10, 12, ...
    let mut n = 1;
    let mut best: Option<(f64, Vec<Pebble>)> = None;
    let mut without_gain = 0;
    loop {
        let balls = slabs(body, n, limits)?;
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
fn slabs(body: &Body, n: usize, limits: &Limits) -> Result<Vec<Pebble>, GenerateError> {
    let (low, high) = (body.bounds.0.x, body.bounds.1.x);
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
            let radius = depth.min(x - low).min(high - x);
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
