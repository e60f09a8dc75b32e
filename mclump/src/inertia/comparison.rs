//! All routes side by side, and what their differences mean.

use std::fmt;

use mercury_common::formats::clump::Pebble;
use mercury_common::formats::mesh::TriangleMesh;

use super::{Estimate, MassProperties, pebbles, surface, union, voxels};

/// Pebbles overlap if their sum is larger than their union by this fraction (MercuryDPM's MClump gives no warning; a
/// tenth of a per cent is the accuracy to which a density is known).
pub const OVERLAP_LIMIT: f64 = 1e-3;
/// Pebbles stand badly for the surface if volume or a principal moment differ by more than this fraction.
pub const FIT_LIMIT: f64 = 0.05;

/// A way to mass, centre and inertia.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Route {
    /// Signed tetrahedra of the closed surface.
    Surface,
    /// The space that the pebbles cover, by sections.
    Union,
    /// The space that the pebbles cover, by voxels.
    Voxels,
    /// Every pebble for itself.
    Pebbles,
}

impl Route {
    /// The word in the clump file and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Surface => "surface",
            Self::Union => "union",
            Self::Voxels => "voxels",
            Self::Pebbles => "pebbles",
        }
    }
}

impl fmt::Display for Route {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Result of one route, for unit density.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Route to the mass properties.
    pub route: Route,
    /// Mass properties that it found.
    pub properties: MassProperties,
    /// Estimated relative error; `None` for a closed form.
    pub relative_error: Option<f64>,
}

/// How to integrate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Voxels along the longest edge.
    pub voxels: u32,
    /// Refine the voxels until their estimated relative error is below this.
    pub voxel_tolerance: Option<f64>,
    /// Relative accuracy of the union.
    pub union_tolerance: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            voxels: voxels::DEFAULT_VOXELS,
            voxel_tolerance: None,
            union_tolerance: union::DEFAULT_TOLERANCE,
        }
    }
}

/// Integrates by one route; `None` where it does not apply: no surface, no pebbles, or nothing inside. The surface must be
/// closed and turned outward ([`crate::surface::prepare`]).
#[must_use]
pub fn row(
    route: Route,
    surface: Option<&TriangleMesh>,
    pebbles: &[Pebble],
    settings: &Settings,
) -> Option<Row> {
    let exact = |properties: MassProperties| (properties, None);
    let estimated = |e: Estimate| (e.properties, Some(e.relative_error));
    let (properties, relative_error) = match route {
        Route::Surface => exact(surface::integrate(surface?)?),
        Route::Pebbles => exact(pebbles::integrate(pebbles)?),
        Route::Union => estimated(union::integrate(pebbles, settings.union_tolerance)?),
        Route::Voxels => estimated(match settings.voxel_tolerance {
            Some(tolerance) => voxels::integrate_to(pebbles, settings.voxels, tolerance)?.0,
            None => voxels::integrate(pebbles, settings.voxels)?,
        }),
    };
    Some(Row {
        route,
        properties,
        relative_error,
    })
}

/// Warnings of differences between routes, in words; empty where they agree. `chosen` is the route that the clump takes; pebbles
/// `generated` from the surface are in its frame and unit.
#[must_use]
pub fn warnings(rows: &[Row], chosen: Route, generated: bool) -> Vec<String> {
    let find = |route: Route| rows.iter().find(|row| row.route == route);
    let mut warnings = Vec::new();
    let covered = find(Route::Union).or_else(|| find(Route::Voxels));
    if let (Some(sum), Some(union)) = (find(Route::Pebbles), covered) {
        let excess = sum.properties.volume / union.properties.volume - 1.0;
        let known = union.relative_error.unwrap_or(0.0);
        if chosen == Route::Pebbles && excess > OVERLAP_LIMIT.max(2.0 * known) {
            warnings.push(format!(
                "the pebbles overlap: counted one by one they have {:.3} times the volume that they cover; \
                 --inertia union counts each point once",
                excess + 1.0
            ));
        }
    }
    if let (Some(surface), Some(union)) = (find(Route::Surface), covered) {
        let volume = union.properties.volume / surface.properties.volume - 1.0;
        if volume.abs() > FIT_LIMIT {
            warnings.push(format!(
                "the pebbles cover {:.1} % {} than the surface encloses",
                100.0 * volume.abs(),
                if volume > 0.0 { "more" } else { "less" }
            ));
        }
        let (a, b) = (
            union.properties.principal_moments(),
            surface.properties.principal_moments(),
        );
        let ratio = (a / b - 1.0).abs().max_element();
        if ratio > FIT_LIMIT {
            warnings.push(format!(
                "a principal moment of the pebbles' union differs by {:.1} % from that of the surface",
                100.0 * ratio
            ));
        }
        let size = surface.properties.volume.cbrt();
        let shift = union.properties.centre.distance(surface.properties.centre) / size;
        if shift > FIT_LIMIT {
            warnings.push(format!(
                "the centre of the pebbles' union is {:.1} % of the body's size away from that of the surface{}",
                100.0 * shift,
                if generated {
                    ""
                } else {
                    ": are both in the same frame and unit?"
                }
            ));
        }
    }
    warnings
}
