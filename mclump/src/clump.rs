//! From inputs to a clump: every route, the chosen one, the frame, the clump file.

use glam::DVec3;
use mercury_common::formats::clump::{ClumpFile, ClumpProblem, Pebble, Remark};
use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::plausible;
use thiserror::Error;

use crate::alignment::{Alignment, Equal, align};
use crate::inertia::comparison::{Route, Row, Settings, row, warnings};
use crate::inertia::pebbles::bounds;
use crate::sizes::pebble_problem;
use crate::surface::Prepared;
use crate::table::number;

/// A surface longer than this (m), which may be that of a drum, is probably given in another unit.
const LARGE_SURFACE: f64 = 10.0;
/// So is one shorter than this (m): a tenth of a micrometre.
const SMALL_BODY: f64 = 1e-7;

/// Pebbles that cover less than this share of the surface's volume do not stand for the body.
pub const LEAST_COVERED: f64 = 0.01;

/// Input for a clump, in SI units, all in one frame.
#[derive(Debug, Clone)]
pub struct Input {
    /// Name of the clump.
    pub name: String,
    /// The surface, closed ([`crate::surface::prepare`]).
    pub surface: Option<Prepared>,
    /// The pebbles; at least one.
    pub pebbles: Vec<Pebble>,
}

/// The requested quantities.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Density in kg/m3; default 1.
    pub density: f64,
    /// The route for mass, centre and inertia; by default the surface where there is one, else the union where pebbles overlap, else
    /// the pebbles.
    pub route: Option<Route>,
    /// How to integrate.
    pub settings: Settings,
    /// Goes into the clump file as `[source]`.
    pub source: Vec<(String, Remark)>,
    /// Further entries of `[checks]`, put behind those found here.
    pub checks: Vec<(String, Remark)>,
    /// Whether the pebbles were [generated](crate::generate) from the surface: words about wrong frames and units make no sense then.
    pub generated: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            density: 1.0,
            route: None,
            settings: Settings::default(),
            source: Vec::new(),
            checks: Vec::new(),
            generated: false,
        }
    }
}

/// A clump with everything that was found on the way.
#[derive(Debug, Clone)]
pub struct Built {
    /// The clump file.
    pub file: ClumpFile,
    /// Result of each applicable route, for unit density, in the frame of the input.
    pub rows: Vec<Row>,
    /// The route that the clump took.
    pub route: Route,
    /// The frame and how it came about.
    pub alignment: Alignment,
    /// Warnings for the user, in words.
    pub warnings: Vec<String>,
    /// The surface in the clump's frame.
    pub surface: Option<TriangleMesh>,
}

/// Why there is no clump.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum BuildError {
    /// There are no pebbles.
    #[error("a clump needs at least one pebble: give a pebble list, or --generate with a surface")]
    NoPebbles,
    /// A pebble is not a sphere.
    #[error("pebble {index}: {problem}")]
    BadPebble {
        /// Index of the pebble, counted from 1.
        index: usize,
        /// Description of the problem.
        problem: String,
    },
    /// The chosen route does not apply.
    #[error("{0}")]
    NoRoute(String),
    /// The density is not a positive number.
    #[error("the density must be above 0 kg/m3, got {0}")]
    BadDensity(f64),
    /// Pebbles that have nothing to do with the surface.
    #[error(
        "{outside} of {pebbles} pebbles lie wholly outside the box around the surface, the first is pebble {first}: \
         the surface spans {}, the pebbles span {}\n\
         help: both must be in the same frame and unit (--scale goes for both): are they of the same body?",
        spans(surface_box),
        spans(pebbles_box)
    )]
    Apart {
        /// Number of pebbles that lie outside.
        outside: usize,
        /// Number of pebbles.
        pebbles: usize,
        /// The first that lies outside, counted from 1.
        first: usize,
        /// The axis-parallel box around the surface in m.
        surface_box: (DVec3, DVec3),
        /// The axis-parallel box around the pebbles in m.
        pebbles_box: (DVec3, DVec3),
    },
    /// Pebbles that do not stand for the surface.
    #[error(
        "the pebbles cover {} % of the volume that the surface encloses, expected at least {} %: they do not represent the body\nhelp: {}",
        rounded(100.0 * share),
        100.0 * LEAST_COVERED,
        if *generated {
            "the body is thin or hollow: make more pebbles (--pebbles), let them stand out (--protrusion), or take another surface"
        } else {
            "give more or larger pebbles, in the unit of the surface (--scale goes for both), or --generate tangent --pebbles 100"
        }
    )]
    TooLittle {
        /// Volume of the pebbles' union over that of the surface.
        share: f64,
        /// Whether the pebbles were made for the surface.
        generated: bool,
    },
    /// The result is no rigid body; this needs numbers at the edge of double precision.
    #[error("the result is not a rigid body: {0}\nhelp: check the unit (--scale) and the sizes")]
    NotRigid(#[from] ClumpProblem),
}

/// Makes a clump.
///
/// # Errors
/// Without pebbles, with a pebble or density that is not above 0 or not finite, with [lengths](crate::sizes) that cannot be computed with, with a route that does not apply,
/// with pebbles outside the surface's box or that cover less than [`LEAST_COVERED`] of its volume.
pub fn build(input: &Input, options: &Options) -> Result<Built, BuildError> {
    check(input, options)?;
    let mesh = input.surface.as_ref().map(|surface| &surface.mesh);
    if let Some(mesh) = mesh {
        check_place(mesh, &input.pebbles)?;
    }
    let all = [Route::Surface, Route::Union, Route::Voxels, Route::Pebbles];
    let rows: Vec<Row> = all
        .into_iter()
        .filter_map(|route| row(route, mesh, &input.pebbles, &options.settings))
        .collect();
    check_cover(&rows, options)?;
    let route = options.route.unwrap_or_else(|| default_route(&rows));
    let chosen = rows.iter().find(|row| row.route == route).ok_or_else(|| {
        BuildError::NoRoute(match route {
            Route::Surface => "--inertia surface needs a surface: give an STL or OBJ file beside the pebbles, or take \
                 --inertia union"
                .to_owned(),
            Route::Voxels => format!(
                "no voxel's centre lies in a pebble at {} voxels: take more (--voxels) or --inertia union",
                options.settings.voxels
            ),
            _ => format!("--inertia {route} does not apply to this input"),
        })
    })?;
    let of_surface = mesh.filter(|_| route == Route::Surface);
    let alignment = align(
        &chosen.properties,
        chosen.relative_error.unwrap_or(0.0),
        of_surface,
        &input.pebbles,
    );
    let pebbles = alignment.frame.align_pebbles(&input.pebbles);
    let mut words = input
        .surface
        .as_ref()
        .map_or(Vec::new(), |surface| surface.warnings.clone());
    words.extend(warnings(&rows, route, options.generated));
    words.extend(implausible(input, options));
    let mut file = ClumpFile {
        name: input.name.clone(),
        density: options.density,
        mass: options.density * chosen.properties.volume,
        volume: chosen.properties.volume,
        centre_of_mass: chosen.properties.centre,
        principal_moments: options.density * alignment.moments,
        rotation: alignment.frame.rotation,
        inertia_method: route.name().to_owned(),
        pebbles,
        surface: None,
        source: options.source.clone(),
        checks: Vec::new(),
    };
    file.checks = checks(input, options, &rows, &alignment, &words);
    if let Some(problem) = file.problems().into_iter().next() {
        return Err(problem.into());
    }
    Ok(Built {
        file,
        route,
        alignment,
        warnings: words,
        surface: mesh.map(|mesh| alignment.frame.align_mesh(mesh)),
        rows,
    })
}

fn check(input: &Input, options: &Options) -> Result<(), BuildError> {
    if input.pebbles.is_empty() {
        return Err(BuildError::NoPebbles);
    }
    if !(options.density > 0.0 && options.density.is_finite()) {
        return Err(BuildError::BadDensity(options.density));
    }
    for (index, pebble) in input.pebbles.iter().enumerate() {
        let problem = if !pebble.position.is_finite() {
            format!("its centre {} is not finite", pebble.position)
        } else if !(pebble.radius > 0.0 && pebble.radius.is_finite()) {
            format!("its radius must be above 0, got {}", pebble.radius)
        } else {
            continue;
        };
        return Err(BuildError::BadPebble {
            index: index + 1,
            problem,
        });
    }
    match pebble_problem(&input.pebbles) {
        Some(problem) => Err(BuildError::BadPebble {
            index: problem.pebble.unwrap_or(0) + 1,
            problem: format!(
                "{}, expected {}\nhelp: {}",
                problem.found, problem.expected, problem.help
            ),
        }),
        None => Ok(()),
    }
}

/// Refuses pebbles that are not where the surface is.
fn check_place(mesh: &TriangleMesh, pebbles: &[Pebble]) -> Result<(), BuildError> {
    let (Some(surface_box), Some(pebbles_box)) = (mesh.bounds(), bounds(pebbles)) else {
        return Ok(());
    };
    let (low, high) = surface_box;
    let is_outside = |pebble: &Pebble| {
        let radius = DVec3::splat(pebble.radius);
        (pebble.position + radius).cmplt(low).any() || (pebble.position - radius).cmpgt(high).any()
    };
    let outside: Vec<usize> = (0..pebbles.len())
        .filter(|&index| is_outside(&pebbles[index]))
        .collect();
    match outside.first() {
        None => Ok(()),
        Some(first) => Err(BuildError::Apart {
            outside: outside.len(),
            pebbles: pebbles.len(),
            first: first + 1,
            surface_box,
            pebbles_box,
        }),
    }
}

/// Refuses pebbles that cover next to nothing of the body.
fn check_cover(rows: &[Row], options: &Options) -> Result<(), BuildError> {
    let volume = |route: Route| {
        let row = rows.iter().find(|row| row.route == route);
        row.map(|row| row.properties.volume)
    };
    let (Some(union), Some(surface)) = (volume(Route::Union), volume(Route::Surface)) else {
        return Ok(());
    };
    let share = union / surface;
    if share < LEAST_COVERED {
        return Err(BuildError::TooLittle {
            share,
            generated: options.generated,
        });
    }
    Ok(())
}

/// The surface, else the closed form where nothing overlaps, else the union.
fn default_route(rows: &[Row]) -> Route {
    let find = |route: Route| rows.iter().find(|row| row.route == route);
    if find(Route::Surface).is_some() {
        return Route::Surface;
    }
    match (find(Route::Pebbles), find(Route::Union)) {
        (Some(sum), Some(union)) => {
            let error = union.relative_error.unwrap_or(0.0).max(1e-9);
            let excess = sum.properties.volume / union.properties.volume - 1.0;
            if excess <= 2.0 * error {
                Route::Pebbles
            } else {
                Route::Union
            }
        }
        _ => Route::Pebbles,
    }
}

/// Words about the length of a surface in m if it suggests a wrong unit.
#[must_use]
pub fn implausible_size(size: f64) -> Option<String> {
    implausible_beyond(LARGE_SURFACE, size)
}

/// Warning of a body that should be shorter than `most` (m).
fn implausible_beyond(most: f64, size: f64) -> Option<String> {
    if size > most {
        let length = if size < 1e6 {
            format!("{size:.3}")
        } else {
            format!("{size:.3e}")
        };
        Some(format!(
            "the body is {length} m long: if the file is in mm, add --scale 1e-3"
        ))
    } else if size < SMALL_BODY {
        Some(format!(
            "the body is only {size:.1e} m long: is --scale right?"
        ))
    } else {
        None
    }
}

/// Words about sizes and densities that suggest a wrong unit.
fn implausible(input: &Input, options: &Options) -> Vec<String> {
    let Some((low, high)) = bounds(&input.pebbles) else {
        return Vec::new();
    };
    let mut words: Vec<String> = implausible_beyond(plausible::LARGE, (high - low).max_element())
        .into_iter()
        .collect();
    if options.density < plausible::LIGHT {
        words.push(format!(
            "a density of {} kg/m3 is that of a light foam: if it is in g/cm3, multiply it by 1000",
            options.density
        ));
    } else if options.density > plausible::DENSE {
        words.push(format!(
            "no solid has a density of {} kg/m3: is it in another unit?",
            options.density
        ));
    }
    words
}

fn checks(
    input: &Input,
    options: &Options,
    rows: &[Row],
    alignment: &Alignment,
    words: &[String],
) -> Vec<(String, Remark)> {
    let mut checks: Vec<(String, Remark)> = Vec::new();
    for row in rows {
        let properties = &row.properties;
        let mut entries: Vec<(String, Remark)> = vec![
            ("mass".into(), (options.density * properties.volume).into()),
            ("centre_of_mass".into(), properties.centre.into()),
            (
                "principal_moments".into(),
                (options.density * properties.principal_moments()).into(),
            ),
        ];
        if let Some(error) = row.relative_error {
            entries.push(("relative_error".into(), error.into()));
        }
        checks.push((row.route.name().to_owned(), Remark::Table(entries)));
    }
    if let Some(surface) = &input.surface {
        let report = &surface.report;
        let whole = |n: usize| Remark::Whole(i64::try_from(n).unwrap_or(i64::MAX));
        checks.push((
            "closed_surface".into(),
            Remark::Table(vec![
                ("triangles".into(), whole(report.triangles)),
                ("vertices".into(), whole(report.vertices)),
                ("shells".into(), whole(report.shells.len())),
                ("cavities".into(), whole(report.cavities())),
                ("manifold".into(), report.is_manifold().into()),
            ]),
        ));
        if !surface.done.is_empty() {
            checks.push(("surface_changes".into(), texts(&surface.done)));
        }
    }
    let equal = match alignment.equal {
        Equal::None => "none",
        Equal::FirstTwo => "first two",
        Equal::LastTwo => "last two",
        Equal::All => "all",
    };
    checks.push(("equal_moments".into(), equal.into()));
    checks.extend(options.checks.iter().cloned());
    if !words.is_empty() {
        checks.push(("warnings".into(), texts(words)));
    }
    checks
}

/// A box for people, in m.
fn spans((low, high): &(DVec3, DVec3)) -> String {
    let axes = [
        ("x", low.x, high.x),
        ("y", low.y, high.y),
        ("z", low.z, high.z),
    ];
    axes.map(|(axis, from, to)| format!("{axis} {} to {} m", rounded(from), rounded(to)))
        .join(", ")
}

/// Four digits.
fn rounded(x: f64) -> String {
    number(format!("{x:.3e}").parse().unwrap_or(x))
}

fn texts(words: &[String]) -> Remark {
    Remark::List(words.iter().map(|word| word.as_str().into()).collect())
}

/// Inputs in another unit: the pebbles and vertices times `scale`.
#[must_use]
pub fn scaled_pebbles(pebbles: &[Pebble], scale: f64) -> Vec<Pebble> {
    let scaled = |pebble: &Pebble| Pebble {
        position: pebble.position * scale,
        radius: pebble.radius * scale,
    };
    pebbles.iter().map(scaled).collect()
}

/// The mesh with its vertices times `scale`.
#[must_use]
pub fn scaled_mesh(mesh: TriangleMesh, scale: f64) -> TriangleMesh {
    let vertices: Vec<DVec3> = mesh.vertices.iter().map(|v| *v * scale).collect();
    TriangleMesh { vertices, ..mesh }
}
