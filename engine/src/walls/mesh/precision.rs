//! How exactly the places of a mesh are known.

use std::fmt;

use glam::DVec3;
use mercury_common::formats::mesh::TriangleMesh;

use crate::contact::parameter::short;

/// Places of a mesh whose distance is less than this part of its size are the same.
const SAME_PLACE: f64 = 1e-9;
/// Units of round-off by which equal coordinates may differ.
const UNITS: f64 = 4.0;
/// A value above this many medians is that of a stray corner, which does not describe the others.
const STRAY: f64 = 100.0;

/// How exactly the places of a mesh are known, and what limits it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Precision {
    /// Places nearer to each other than this are the same, and triangles that are thinner have no area, m.
    pub tolerance: f64,
    cause: Cause,
    /// Largest coordinate in the scene, strays left out, m.
    pub(super) largest: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Cause {
    /// Round-off of this coordinate of the file.
    Coordinate { value: f64, is_single: bool },
    /// The size of the mesh, m.
    Size(f64),
}

impl Precision {
    /// Precision of triangles whose corners come to stand at `placed` (m) by `place`, a similarity.
    pub(super) fn of(
        triangles: &TriangleMesh,
        placed: &[DVec3],
        place: impl Fn(DVec3) -> DVec3,
    ) -> Self {
        let scale = place(DVec3::X).distance(place(DVec3::ZERO));
        let unit = match triangles.is_single_precision {
            true => f64::from(f32::EPSILON),
            false => f64::EPSILON,
        };
        let coordinates = |corners: &[DVec3]| {
            let largest = corners.iter().map(|x| x.abs().max_element());
            without_strays(largest.collect())
        };
        let value = coordinates(&triangles.vertices);
        let of_coordinate = UNITS * unit * value * scale;
        let size = size(placed);
        let of_size = SAME_PLACE * size;
        let is_single = triangles.is_single_precision;
        let (tolerance, cause) = if of_coordinate > of_size {
            (of_coordinate, Cause::Coordinate { value, is_single })
        } else {
            (of_size, Cause::Size(size))
        };
        Self {
            tolerance,
            cause,
            largest: coordinates(placed),
        }
    }
}

impl fmt::Display for Precision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} m, ", short(self.tolerance))?;
        match self.cause {
            Cause::Coordinate { value, is_single } => write!(
                f,
                "{UNITS} units of {} precision of the coordinate {} of the file",
                if is_single { "single" } else { "double" },
                short(value)
            ),
            Cause::Size(size) => {
                let size = short(size);
                write!(f, "{SAME_PLACE:e} of the mesh's size of {size} m")
            }
        }
    }
}

/// Diagonal of the box around all corners, m; where some are far away from most, a multiple of the usual distance from the middle.
fn size(corners: &[DVec3]) -> f64 {
    let low = corners.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = (corners.iter().copied()).fold(DVec3::NEG_INFINITY, DVec3::max);
    let middle = DVec3::from_array(
        [0, 1, 2].map(|axis| median(&mut corners.iter().map(|x| x[axis]).collect::<Vec<_>>())),
    );
    let mut ways: Vec<f64> = corners.iter().map(|x| x.distance(middle)).collect();
    high.distance(low).min(STRAY * median(&mut ways))
}

/// The largest value, of strays [`STRAY`] times the median.
fn without_strays(mut values: Vec<f64>) -> f64 {
    let largest = values.iter().copied().fold(0.0, f64::max);
    largest.min(STRAY * median(&mut values))
}

/// The middle one, of an even number the upper of the two; 0 of none.
fn median(values: &mut [f64]) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() {
        return 0.0;
    }
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
