//! How well pebbles stand for a surface.

use std::fmt;

use glam::DVec3;
use mercury_common::formats::clump::Pebble;
use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::random::Stream;
use rayon::prelude::*;
use serde::Serialize;

use crate::generate::GenerateError;
use crate::generate::body::Body;
use crate::inertia::union;

/// Relative accuracy of the volume and moments of the union.
const UNION_TOLERANCE: f64 = 1e-6;
/// Surface points at most, and tests of a point against a pebble at most (as long as there are 2000 points).
const MOST_POINTS: usize = 20_000;
const MOST_TESTS: usize = 40_000_000;

/// Pebbles against the body inside a surface. The body of the pebbles is their union.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Fidelity {
    /// Number of pebbles.
    pub pebbles: usize,
    /// Smallest radius in m.
    pub smallest_radius: f64,
    /// Largest radius in m.
    pub largest_radius: f64,
    /// Volume inside the surface in m3.
    pub surface_volume: f64,
    /// Volume of the union of the pebbles in m3.
    pub union_volume: f64,
    /// Union over surface volume, less 1.
    pub volume_error: f64,
    /// Diameter in m of the ball with the volume of the surface.
    pub equal_volume_diameter: f64,
    /// Distance in m from the centre of the surface's body to that of the union.
    pub centre_shift: f64,
    /// Principal moments of the surface's body about its centre, unit density, ascending, in m5.
    pub surface_moments: [f64; 3],
    /// Principal moments of the union about its centre, unit density, ascending, in m5.
    pub union_moments: [f64; 3],
    /// Union over surface moments, less 1.
    pub moment_errors: [f64; 3],
    /// Mean over the surface of the distance to the nearest pebble, in m; inside a pebble the depth in it.
    pub mean_distance: f64,
    /// The largest of these distances in m, at the points of the mean and at as many vertices.
    pub largest_distance: f64,
    /// The farthest that a pebble stands out of the surface, in m: radius less signed distance of its centre to the
    /// surface; 0 if all are inside. Exact for a convex body, else an upper bound.
    pub protrusion: f64,
}

/// Compares pebbles with the surface they stand for, in the same frame.
///
/// Surface points are 20 000, fewer from 2000 pebbles on, one per equal share of the area, always the same; everything
/// else is an integral or exact.
///
/// # Errors
/// If the surface is not closed and oriented outward, or there are no pebbles.
pub fn compare(mesh: &TriangleMesh, pebbles: &[Pebble]) -> Result<Fidelity, GenerateError> {
    let body = Body::new(mesh)?;
    let scaled: Vec<Pebble> = pebbles.iter().map(|p| body.to_body(p)).collect();
    let Some(estimate) = union::integrate(pebbles, UNION_TOLERANCE) else {
        return Err(GenerateError::NoPebbles);
    };
    let (surface, covered) = (body.properties, estimate.properties);
    let surface_moments = surface.principal_moments().to_array();
    let union_moments = covered.principal_moments().to_array();
    let count = (MOST_TESTS / pebbles.len()).clamp(2_000, MOST_POINTS);
    let mut stream = Stream::new(0, "fidelity", 0);
    let points = body.surface_points(count, &mut stream);
    let distance = |point: DVec3| {
        let gap = scaled
            .iter()
            .map(|p| point.distance(p.position) - p.radius)
            .fold(f64::INFINITY, f64::min);
        gap.abs()
    };
    let distances: Vec<f64> = points
        .par_iter()
        .map(|&(point, _)| distance(point))
        .collect();
    let vertices = mesh.vertices.len().div_ceil(count);
    let at_vertices = (0..mesh.vertices.len())
        .into_par_iter()
        .step_by(vertices)
        .map(|index| {
            let vertex = mesh.vertices[index];
            let vertex = Pebble {
                position: vertex,
                radius: 0.0,
            };
            distance(body.to_body(&vertex).position)
        })
        .reduce(|| 0.0, f64::max);
    let largest = distances.iter().copied().fold(at_vertices, f64::max);
    let protrusion = scaled
        .par_iter()
        .map(|p| p.radius - body.nearest(p.position).depth)
        .reduce(|| 0.0, f64::max);
    let radii = pebbles.iter().map(|p| p.radius);
    Ok(Fidelity {
        pebbles: pebbles.len(),
        smallest_radius: radii.clone().fold(f64::INFINITY, f64::min),
        largest_radius: radii.fold(0.0, f64::max),
        surface_volume: surface.volume,
        union_volume: covered.volume,
        volume_error: covered.volume / surface.volume - 1.0,
        equal_volume_diameter: 2.0 * body.unit,
        centre_shift: covered.centre.distance(surface.centre),
        surface_moments,
        union_moments,
        moment_errors: [0, 1, 2].map(|k| union_moments[k] / surface_moments[k] - 1.0),
        mean_distance: distances.iter().sum::<f64>() / distances.len() as f64 * body.unit,
        largest_distance: largest * body.unit,
        protrusion: protrusion * body.unit,
    })
}

/// A table with a line per quantity; lengths also in percent of the equal-volume diameter.
impl fmt::Display for Fidelity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |length: f64| 100.0 * length / self.equal_volume_diameter;
        let d = "% of the equal-volume diameter";
        writeln!(
            f,
            "pebbles            {}, radii {:.6e} to {:.6e} m",
            self.pebbles, self.smallest_radius, self.largest_radius
        )?;
        writeln!(
            f,
            "volume             union {:.8e} m3, surface {:.8e} m3: {:+.3} %",
            self.union_volume,
            self.surface_volume,
            100.0 * self.volume_error
        )?;
        writeln!(
            f,
            "centre             off by {:.3e} m = {:.3} {d}",
            self.centre_shift,
            percent(self.centre_shift)
        )?;
        let [a, b, c] = self.moment_errors.map(|error| 100.0 * error);
        writeln!(f, "principal moments  {a:+.3} %, {b:+.3} %, {c:+.3} %")?;
        writeln!(
            f,
            "surface distance   mean {:.3e} m = {:.3} {d}, largest {:.3e} m = {:.3} %",
            self.mean_distance,
            percent(self.mean_distance),
            self.largest_distance,
            percent(self.largest_distance)
        )?;
        write!(
            f,
            "protrusion         {:.3e} m = {:.3} %",
            self.protrusion,
            percent(self.protrusion)
        )
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::generate::shapes::{cuboid, octahedron};

    fn ball(position: DVec3, radius: f64) -> Pebble {
        Pebble { position, radius }
    }

    #[test]
    fn a_ball_in_a_cube() {
        let cube = cuboid(DVec3::ZERO, DVec3::splat(2.0));
        let found = compare(&cube, &[ball(DVec3::ONE, 1.0)]).unwrap();
        assert!((found.volume_error - (PI / 6.0 - 1.0)).abs() < 1e-6);
        assert!(found.centre_shift < 1e-9);
        // 2/5 M r² over M a²/6.
        for error in found.moment_errors {
            let exact = (0.4 * 4.0 / 3.0 * PI) / (8.0 * 4.0 / 6.0) - 1.0;
            assert!((error - exact).abs() < 2e-6, "{error} instead of {exact}");
        }
        assert!(found.protrusion.abs() < 1e-12);
        // The corners are farthest.
        assert!((found.largest_distance - (3.0f64.sqrt() - 1.0)).abs() < 1e-12);
        // Mean of sqrt(1 + x² + y²) - 1 over the face |x|, |y| < 1 by the midpoint rule; 20 000 stratified points with
        // a standard deviation of 0.18.
        let n = 400;
        let at = |k: usize| (k as f64 + 0.5) / n as f64;
        let mut mean = 0.0;
        for i in 0..n {
            for j in 0..n {
                mean += (1.0 + at(i).powi(2) + at(j).powi(2)).sqrt() - 1.0;
            }
        }
        mean /= (n * n) as f64;
        assert!((found.mean_distance - mean).abs() < 4.0 * 0.18 / 20_000f64.sqrt());
    }

    #[test]
    fn what_stands_out_and_what_is_off_centre() {
        let cube = cuboid(DVec3::ZERO, DVec3::splat(2.0));
        let found = compare(&cube, &[ball(DVec3::new(1.1, 1.0, 1.0), 1.0)]).unwrap();
        assert!((found.protrusion - 0.1).abs() < 1e-12);
        assert!((found.centre_shift - 0.1).abs() < 1e-9);
        let outside = compare(&cube, &[ball(DVec3::new(3.0, 1.0, 1.0), 0.5)]).unwrap();
        assert!((outside.protrusion - 1.5).abs() < 1e-12);
    }

    #[test]
    fn the_report_names_every_quantity() {
        let report = compare(&octahedron(), &[ball(DVec3::ZERO, 1.0 / 3.0f64.sqrt())])
            .unwrap()
            .to_string();
        // 4/3 pi 3^(-3/2) over 4/3.
        for part in [
            "pebbles            1, radii 5.773503e-1 to 5.773503e-1 m",
            "-39.540 %",
            "principal moments",
            "surface distance",
            "protrusion",
        ] {
            assert!(report.contains(part), "{part:?} is missing in\n{report}");
        }
    }

    #[test]
    fn nothing_to_compare_is_an_error() {
        assert_eq!(
            compare(&octahedron(), &[]).unwrap_err().to_string(),
            "there are no pebbles to compare with the surface"
        );
    }
}
