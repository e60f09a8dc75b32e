//! Shape descriptors of a body: elongation, flatness, sphericity, convexity, roundness.
//!
//! Each name has several definitions in the literature; [`Descriptors`] prints the one that is used with each number.

mod bounding_box;
#[cfg(test)]
mod tests;

use std::f64::consts::PI;
use std::fmt;

use glam::DVec3;
use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::random::Stream;
use parry3d_f64::transformation::try_convex_hull;
use rayon::prelude::*;
use serde::Serialize;

use crate::generate::ascent::ascend;
use crate::generate::body::{Body, from_parry, to_parry};
use crate::generate::{Euclidean, GenerateError, largest_inscribed};
use crate::inertia::surface;
use bounding_box::smallest_box;

/// The scale of [`Descriptors::roundness`]: what a corner may stand out of a ball, over the inscribed radius.
pub const ROUNDNESS_SCALE: f64 = 0.02;
/// Surface points of the roundness.
const ROUNDNESS_POINTS: usize = 2_000;

/// Three lengths of a body, in m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Dimensions {
    /// L, the longest.
    pub longest: f64,
    /// I, the one between.
    pub intermediate: f64,
    /// S, the shortest.
    pub shortest: f64,
}

impl Dimensions {
    fn sorted(mut lengths: [f64; 3]) -> Self {
        lengths.sort_by(|a, b| b.total_cmp(a));
        let [longest, intermediate, shortest] = lengths;
        Self {
            longest,
            intermediate,
            shortest,
        }
    }

    /// I/L (Zingg 1935).
    #[must_use]
    pub fn elongation(&self) -> f64 {
        self.intermediate / self.longest
    }

    /// S/I (Zingg 1935).
    #[must_use]
    pub fn flatness(&self) -> f64 {
        self.shortest / self.intermediate
    }

    /// S/L.
    #[must_use]
    pub fn compactness(&self) -> f64 {
        self.shortest / self.longest
    }

    /// Krumbein's intercept sphericity (I S/L²)^(1/3) (Krumbein 1941).
    #[must_use]
    pub fn krumbein_sphericity(&self) -> f64 {
        (self.elongation() * self.compactness()).cbrt()
    }

    /// Corey's shape factor S/sqrt(L I) (Corey 1949).
    #[must_use]
    pub fn corey_shape_factor(&self) -> f64 {
        self.shortest / (self.longest * self.intermediate).sqrt()
    }
}

/// Numbers that describe the shape of a body.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Descriptors {
    /// Volume in m3.
    pub volume: f64,
    /// Surface area in m2.
    pub area: f64,
    /// Diameter in m of the ball of equal volume, (6V/pi)^(1/3).
    pub equal_volume_diameter: f64,
    /// Edges of the smallest box among those that have a face in the plane of a face of the convex hull (of hulls with thousands of
    /// faces, a choice of directions) or across a principal axis.
    pub bounding_box: Dimensions,
    /// Axes (not half axes) of the ellipsoid with the volume and the ratios of the body's second moments: twice
    /// sqrt(5/2 (I2 + I3 - I1)/M) and so on round.
    pub inertia_ellipsoid: Dimensions,
    /// Wadell's sphericity pi^(1/3) (6V)^(2/3)/A: area of the ball of equal volume over area of the body (Wadell 1935).
    pub wadell_sphericity: f64,
    /// Volume over that of the convex hull.
    pub convexity: f64,
    /// Radius in m of the largest inscribed ball: that of a ball that is largest near its place, and no other is larger by more than 2 %.
    pub inscribed_radius: f64,
    /// Radius in m of the smallest ball around the body.
    pub circumscribed_radius: f64,
    /// Mean over the surface of the radius of the largest ball inside that touches the point and stands out of the surface by at most
    /// `ROUNDNESS_SCALE` (0.02) of the inscribed radius, over the inscribed radius and at most 1. 1 for a ball, about 1/3
    /// for a cube.
    ///
    /// Facets count as round if neighbours meet at less than about 2 x 0.02 rad.
    ///
    /// In the spirit of Wadell (1932), who compares the radii of curvature of corners with the inscribed radius; here
    /// every surface point counts, and roughness below the scale does not.
    pub roundness: f64,
}

/// Describes the body inside a closed, outward oriented surface.
///
/// # Errors
/// If the surface is not closed or not oriented outward, or is too thin for an inscribed ball.
pub fn describe(mesh: &TriangleMesh) -> Result<Descriptors, GenerateError> {
    let body = Body::new(mesh)?;
    let unit = body.unit;
    let volume = body.properties.volume;
    let area = surface::area(mesh);
    let hull = hull(&body)?;
    let moments = crate::alignment::eigen::symmetric(body.properties.second_moment).values;
    let options = Euclidean {
        accuracy: 0.02,
        ..Euclidean::default()
    };
    let inscribed = largest_inscribed(&body, &options).ok_or(GenerateError::NothingFits {
        smallest: 1e-6 * unit,
    })?;
    Ok(Descriptors {
        volume,
        area,
        equal_volume_diameter: 2.0 * unit,
        bounding_box: Dimensions::sorted(smallest_box(&hull).map(|edge| edge * unit)),
        inertia_ellipsoid: Dimensions::sorted(
            moments
                .to_array()
                .map(|moment| 2.0 * (5.0 * moment.max(0.0) / volume).sqrt()),
        ),
        wadell_sphericity: PI.cbrt() * (6.0 * volume).powf(2.0 / 3.0) / area,
        convexity: (body.volume / hull_volume(&hull)).min(1.0),
        inscribed_radius: inscribed.radius * unit,
        circumscribed_radius: circumscribed_radius(&hull.0) * unit,
        roundness: roundness(&body, inscribed.radius),
    })
}

/// Corners and triangles, outward.
type Hull = (Vec<DVec3>, Vec<[u32; 3]>);

fn hull(body: &Body) -> Result<Hull, GenerateError> {
    let mut points: Vec<DVec3> = body.faces.iter().flat_map(|face| face.corners).collect();
    // Equal corners of neighbouring triangles once.
    points.sort_by(|a, b| {
        a.x.total_cmp(&b.x)
            .then(a.y.total_cmp(&b.y))
            .then(a.z.total_cmp(&b.z))
    });
    points.dedup();
    let points: Vec<_> = points.into_iter().map(to_parry).collect();
    let (corners, triangles) =
        try_convex_hull(&points).map_err(|error| GenerateError::ConvexHull {
            reason: error.to_string(),
        })?;
    Ok((corners.into_iter().map(from_parry).collect(), triangles))
}

fn hull_volume((corners, triangles): &Hull) -> f64 {
    let [a, b, c] = [0, 1, 2];
    triangles
        .iter()
        .map(|t| t.map(|index| corners[index as usize]))
        .map(|t| t[a].dot(t[b].cross(t[c])) / 6.0)
        .sum()
}

/// Radius of the smallest ball around points: the largest distance is least at its centre.
fn circumscribed_radius(points: &[DVec3]) -> f64 {
    let field = |x: DVec3| {
        let mut far = (0.0, DVec3::X);
        for &point in points {
            let offset = point - x;
            let distance = offset.length();
            if distance > far.0 {
                far = (distance, offset / distance);
            }
        }
        (-far.0, far.1)
    };
    -ascend(&field, DVec3::ZERO, 1.0).1
}

fn roundness(body: &Body, inscribed: f64) -> f64 {
    let mut stream = Stream::new(0, "roundness", 0);
    let points = body.surface_points(ROUNDNESS_POINTS, &mut stream);
    let allowed = ROUNDNESS_SCALE * inscribed;
    let radii: Vec<f64> = points
        .par_iter()
        .map(|&(start, face)| {
            let inward = -body.faces[face].normal;
            // Shrinks as a tangent ball does (`generate::tangent`), but ends when it stands out by what is allowed.
            let mut radius = inscribed;
            for _ in 0..100 {
                let nearest = body.nearest(start + radius * inward);
                if radius - nearest.depth <= allowed * (1.0 + 1e-6) {
                    break;
                }
                let chord = nearest.point - start;
                let along = chord.dot(inward) - allowed;
                let next = 0.5 * (chord.length_squared() - allowed * allowed) / along;
                if !(along > 0.0 && next < radius) {
                    break;
                }
                // A ball with the allowed radius stands out by no more.
                radius = next.max(allowed);
            }
            radius
        })
        .collect();
    radii.iter().sum::<f64>() / (radii.len() as f64 * inscribed)
}

/// A line per number, each with its definition.
impl fmt::Display for Descriptors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "volume V                  {:.8e} m3", self.volume)?;
        writeln!(f, "area A                    {:.8e} m2", self.area)?;
        writeln!(
            f,
            "equal-volume diameter     {:.6e} m   (6V/pi)^(1/3)",
            self.equal_volume_diameter
        )?;
        for (name, d) in [
            (
                "smallest box with a face on the convex hull",
                &self.bounding_box,
            ),
            ("axes of the ellipsoid of inertia", &self.inertia_ellipsoid),
        ] {
            writeln!(
                f,
                "L, I, S                   {:.6e}, {:.6e}, {:.6e} m   {name}",
                d.longest, d.intermediate, d.shortest
            )?;
            for (name, value, definition) in [
                ("elongation", d.elongation(), "I/L"),
                ("flatness", d.flatness(), "S/I"),
                ("compactness", d.compactness(), "S/L"),
                (
                    "Krumbein's sphericity",
                    d.krumbein_sphericity(),
                    "(I S/L^2)^(1/3)",
                ),
                (
                    "Corey's shape factor",
                    d.corey_shape_factor(),
                    "S/sqrt(L I)",
                ),
            ] {
                writeln!(f, "  {name:<23} {value:.6}   {definition}")?;
            }
        }
        writeln!(
            f,
            "Wadell's sphericity       {:.6}   pi^(1/3) (6V)^(2/3)/A",
            self.wadell_sphericity
        )?;
        writeln!(
            f,
            "convexity                 {:.6}   V over the volume of the convex hull",
            self.convexity
        )?;
        writeln!(
            f,
            "inscribed/circumscribed   {:.6}   radii {:.6e} and {:.6e} m",
            self.inscribed_radius / self.circumscribed_radius,
            self.inscribed_radius,
            self.circumscribed_radius
        )?;
        write!(
            f,
            "roundness                 {:.6}   mean radius of tangent balls that stand out by at most {ROUNDNESS_SCALE} of the inscribed radius, over that radius",
            self.roundness
        )
    }
}
