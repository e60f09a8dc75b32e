//! From options to an analysis: the limits, grid, width and fields that the input suggests where no option is given.

use std::path::{Path, PathBuf};

use glam::DVec3;
use mercury_common::readable::shortened;

use crate::CgError;
use crate::analysis::{Analysis, Part, Reference, TIME_CUTOFF, TimeMode};
use crate::coordinates::{Coordinates, CylinderAxis, GridAxis, Place};
use crate::evaluate::{Evaluator, Mirrors};
use crate::fields::{FIELDS, Field, STANDARD};
use crate::input::{Given, Needs, Source};
use crate::kernel::{DEFAULT_CUTOFF, DEFAULT_TOLERANCE, KernelChoice, KernelShape, LineCut};
use crate::options::{Cells, Limits, Spacing, Width};
use crate::state::{Space, State};
use mercury_common::scene::nearest;

/// Options of an analysis, as far as they were given.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Wanted {
    /// Names of fields; `standard` and `all` stand for several. Empty: standard.
    pub fields: Vec<String>,
    /// Resolved coordinates; by default all that the input has.
    pub coordinates: Option<Coordinates>,
    /// Cells of each coordinate.
    pub grid: Option<Cells>,
    /// Or their sizes.
    pub spacing: Option<Spacing>,
    /// Limits of coordinates.
    pub limits: Limits,
    /// Or a file of points.
    pub points: Option<PathBuf>,
    /// The function.
    pub shape: KernelShape,
    /// Its width; one mean diameter by default.
    pub width: Option<Width>,
    /// Where a Gaussian is cut, in widths.
    pub cutoff: Option<f64>,
    /// Error of line integrals on grids.
    pub tolerance: Option<f64>,
    /// Whether to compute as MercuryCG does.
    pub compat: bool,
    /// Faces that mirror.
    pub mirrors: Mirrors,
    /// Direction of the axis of cylindrical coordinates.
    pub axis: Option<usize>,
    /// A point on it; the middle of the domain by default.
    pub through: Option<DVec3>,
    /// Names or indices of materials to be looked at one by one.
    pub materials: Vec<String>,
    /// All of them one by one.
    pub by_material: bool,
    /// How frames are put together.
    pub time: Option<TimeMode>,
    /// Whether means have standard errors.
    pub errors: bool,
    /// State from which displacements are counted.
    pub reference: Reference,
    /// Whether the sums of MercuryCG's files are requested.
    pub stat: bool,
}

/// The largest number of points of a default grid.
const MOST_POINTS: usize = 2_000_000;

/// Most images of a particle: a kernel that sees more is so wide that fields are means over the domain, which other coordinates give at once.
const MOST_IMAGES: f64 = 10_000.0;

/// Most smoothed means that are open at a time, each of which takes the memory of a frame.
const MOST_OPEN: f64 = 600.0;

/// Most materials that are looked at one by one unless each is named: all fields are computed for each.
const MOST_MATERIALS: usize = 256;

impl Wanted {
    /// The requested fields; of the standard ones and of `all` those that the input has.
    ///
    /// # Errors
    /// When a name is not known, or the kernel cannot have a field.
    pub fn chosen(&self, has_contacts: bool) -> Result<Vec<&'static Field>, CgError> {
        let mut fields: Vec<&'static Field> = Vec::new();
        let standard = ["standard".to_owned()];
        let names = if self.fields.is_empty() {
            &standard[..]
        } else {
            &self.fields
        };
        let mut push = |field: &'static Field| {
            if !fields.contains(&field) {
                fields.push(field);
            }
        };
        for name in names {
            match name.as_str() {
                "standard" => STANDARD
                    .iter()
                    .filter_map(|name| Field::by_name(name))
                    .filter(|field| has_contacts || !field.needs_contacts())
                    .for_each(&mut push),
                "all" => FIELDS
                    .iter()
                    .filter(|field| has_contacts || !field.needs_contacts())
                    .filter(|field| {
                        !(field.needs_couples()
                            || field.needs_displacement()
                            || field.needs_liquid())
                    })
                    .filter(|field| self.shape != KernelShape::Heaviside || !field.needs_gradient())
                    .for_each(&mut push),
                name => match Field::by_name(name) {
                    Some(field) => push(field),
                    None => {
                        let known: Vec<&str> = FIELDS.iter().map(|field| field.name).collect();
                        let found = format!("--fields: there is no field {name}");
                        let words = ["standard", "all"].into_iter().chain(known.iter().copied());
                        let near = nearest(name, words);
                        let near = near.map_or(String::new(), |near| {
                            format!("did you mean {near}? There are ")
                        });
                        return Err(CgError::Input(format!(
                            "{found}\nhelp: {near}standard, all, {}",
                            known.join(", ")
                        )));
                    }
                },
            }
        }
        if self.shape == KernelShape::Heaviside
            && let Some(field) = fields.iter().find(|field| field.needs_gradient())
        {
            let found = format!(
                "--fields {}: the kernel heaviside has a jump and no gradient",
                field.name
            );
            return Err(CgError::Input(format!("{found}\nhelp: gaussian or lucy")));
        }
        Ok(fields)
    }

    /// Opens the input for the requested fields.
    ///
    /// # Errors
    /// When it lacks what fields need, or cannot be read.
    pub fn open(
        &self,
        path: &Path,
        given: &Given,
    ) -> Result<(Source, Vec<&'static Field>), CgError> {
        // Fields of contacts that were not named are left out where there are none.
        let explicit =
            |fields: &[&'static Field]| fields.iter().any(|field| field.needs_contacts());
        let without = self.chosen(false)?;
        let needs = |fields: &[&'static Field]| Needs {
            mass: self.stat || fields.iter().any(|field| field.needs_mass()),
            contacts: self.stat || explicit(fields),
            couples: fields.iter().any(|field| field.needs_couples()),
            rotation: fields.iter().any(|field| field.needs_rotation())
                && !self.fields.iter().any(|name| name == "all"),
            liquid: fields.iter().any(|field| field.needs_liquid()),
            identity: fields.iter().any(|field| field.needs_displacement()),
        };
        let source = Source::open(path, given, needs(&without))?;
        if !source.has_contacts() {
            return Ok((source, without));
        }
        let with = self.chosen(true)?;
        Ok((Source::open(path, given, needs(&with))?, with))
    }

    /// The analysis for an input whose first state is this; `materials` are the names by index, as far as they are known.
    ///
    /// # Errors
    /// When choices do not fit to each other or to the input.
    pub fn analysis(
        &self,
        materials: &[String],
        state: &State,
        fields: Vec<&'static Field>,
    ) -> Result<Analysis, CgError> {
        let flat = state.space.dimensions == 2;
        let coordinates = self
            .coordinates
            .unwrap_or(Coordinates::Cartesian([true, true, !flat]));
        if flat && coordinates.kernel_axes()[2] {
            let found = format!("--coordinates {coordinates}: the input has two dimensions");
            return Err(CgError::Input(format!(
                "{found}\nhelp: O, X, Y, XY, R or Rphi"
            )));
        }
        if flat && self.axis.is_some_and(|axis| axis != 2) {
            let found = "--axis: in two dimensions only z, across the plane";
            return Err(CgError::Input(found.to_owned()));
        }
        let kernel = self.kernel(state)?;
        let axis = self.axis(state);
        if matches!(coordinates, Coordinates::Cylindrical { .. })
            && self.mirrors != Mirrors::default()
        {
            let found = "--mirror: only with coordinates of x, y and z";
            return Err(CgError::Input(found.to_owned()));
        }
        for (a, mirrors) in self.mirrors.iter().enumerate() {
            if mirrors.contains(&true) && state.space.periodic[a] {
                let name = ["x", "y", "z"][a];
                return Err(CgError::Input(format!(
                    "--mirror: the domain is periodic along {name}"
                )));
            }
        }
        for (a, mirrors) in self.mirrors.iter().enumerate() {
            if mirrors.contains(&true) && !coordinates.kernel_axes()[a] {
                let name = ["x", "y", "z"][a];
                return Err(CgError::Input(format!(
                    "--mirror: fields with the coordinates {coordinates} are means over {name}, along which there is nothing to mirror"
                )));
            }
            let length = state.space.max[a] - state.space.min[a];
            // Also where it is no number.
            if *mirrors == [true; 2] && (length.is_nan() || length <= 0.0) {
                let name = ["x", "y", "z"][a];
                return Err(CgError::Input(format!(
                    "--mirror: the domain has no length along {name}"
                )));
            }
        }
        if let Some(TimeMode::Smooth { width, step }) = self.time
            && 2.0 * TIME_CUTOFF * width / step > MOST_OPEN
        {
            return Err(CgError::Input(format!(
                "--smooth: the step must be at least {} of the width, got {step} s of {width} s",
                2.0 * TIME_CUTOFF / MOST_OPEN
            )));
        }
        for a in 0..3 {
            let length = extent(state, &coordinates, &axis, a);
            // Also where it is no number.
            if !coordinates.kernel_axes()[a] && (length.is_nan() || length <= 0.0) {
                let name = ["x", "y", "z"][a];
                let found = format!(
                    "the domain has no length along {name}, over which fields would be averaged"
                );
                return Err(CgError::Input(format!(
                    "{found}\nhelp: another choice of --coordinates"
                )));
            }
        }
        let place = self.place(&coordinates, &axis, state, &kernel)?;
        let parts = self.parts(materials, state)?;
        let evaluator = Evaluator {
            axis,
            mirrors: self.mirrors,
            images: !self.compat,
            ..Evaluator::new(coordinates, place, kernel)
        };
        refuse_many_images(&evaluator, &state.space)?;
        Ok(Analysis {
            evaluator,
            fields,
            parts,
            time: self.time.unwrap_or(TimeMode::Frames),
            errors: self.errors,
            reference: self.reference,
            keep_sums: self.stat,
            running: false,
        })
    }

    fn kernel(&self, state: &State) -> Result<KernelChoice, CgError> {
        let width = self.width.unwrap_or(Width::Diameters(1.0));
        let diameter = match width {
            Width::Metres(_) => 1.0,
            Width::Diameters(_) => mean_diameter(state)?,
        };
        let (cutoff, tolerance, line_cut) = if self.compat {
            (3.0, 1e-12, LineCut::Cylinder)
        } else {
            (DEFAULT_CUTOFF, DEFAULT_TOLERANCE, LineCut::Ellipsoid)
        };
        if self.shape != KernelShape::Gaussian && self.cutoff.is_some() {
            return Err(CgError::Input(format!(
                "--cutoff: the kernel {} ends at its width",
                self.shape.name()
            )));
        }
        Ok(KernelChoice {
            cutoff: self.cutoff.unwrap_or(cutoff),
            tolerance: self.tolerance.unwrap_or(tolerance),
            line_cut,
            ..KernelChoice::new(self.shape, width.metres(diameter))
        })
    }

    fn axis(&self, state: &State) -> CylinderAxis {
        let middle = 0.5 * (state.space.min + state.space.max);
        CylinderAxis {
            along: self.axis.unwrap_or(2),
            through: self.through.unwrap_or(middle),
        }
    }

    fn place(
        &self,
        coordinates: &Coordinates,
        axis: &CylinderAxis,
        state: &State,
        kernel: &KernelChoice,
    ) -> Result<Place, CgError> {
        let names = coordinates.names();
        if let Some((name, ..)) = self
            .limits
            .0
            .iter()
            .find(|(name, ..)| !names.contains(&name.as_str()))
        {
            return Err(CgError::Input(format!(
                "--limits: {name} is not among the coordinates {coordinates}"
            )));
        }
        if let Some(path) = &self.points {
            if self.grid.is_some() || self.spacing.is_some() || !self.limits.0.is_empty() {
                return Err(CgError::Input(
                    "--points: no --grid, --spacing or --limits beside it".to_owned(),
                ));
            }
            return points(path, names.len());
        }
        if self.grid.is_some() && self.spacing.is_some() {
            return Err(CgError::Input(
                "--grid and --spacing: one of them".to_owned(),
            ));
        }
        if names.is_empty() {
            return Ok(Place::Points(vec![Vec::new()]));
        }
        let limits: Vec<(f64, f64)> = names
            .iter()
            .map(|name| {
                self.limits
                    .of(name)
                    .map_or_else(|| usual_limits(name, axis, coordinates, state), Ok)
            })
            .collect::<Result<_, _>>()?;
        let counts = match (&self.grid, &self.spacing) {
            (Some(Cells(cells)), _) => {
                // Three numbers may stand for x, y, z, with 1 where a direction is not resolved.
                let three = match *coordinates {
                    Coordinates::Cartesian(resolved) if cells.len() == 3 && names.len() < 3 => {
                        let idle = (0..3).all(|a| resolved[a] || cells[a] == 1);
                        idle.then(|| {
                            (0..3)
                                .filter(|&a| resolved[a])
                                .map(|a| cells[a])
                                .collect::<Vec<usize>>()
                        })
                    }
                    _ => None,
                };
                let cells = three.unwrap_or_else(|| cells.clone());
                if cells.len() != names.len() {
                    let found = format!(
                        "--grid: {} numbers for the coordinates {coordinates}",
                        cells.len()
                    );
                    return Err(CgError::Input(format!(
                        "{found}\nhelp: one number for each of {}",
                        names.join(", ")
                    )));
                }
                cells
            }
            (None, spacing) => {
                let width = [kernel.width];
                let lengths: &[f64] = match spacing {
                    Some(Spacing(lengths)) => lengths,
                    None => &width,
                };
                if lengths.len() != 1 && lengths.len() != names.len() {
                    let found = format!(
                        "--spacing: {} lengths for the coordinates {coordinates}",
                        lengths.len()
                    );
                    return Err(CgError::Input(format!(
                        "{found}\nhelp: one for all, or one for each of {}",
                        names.join(", ")
                    )));
                }
                let outer = limits[0].1;
                let count = |k: usize| {
                    let (low, high) = limits[k];
                    let length = lengths[k.min(lengths.len() - 1)];
                    // A length along the arc of the largest circle, where only one is given for all.
                    let length = if names[k] == "phi" && lengths.len() == 1 {
                        length / outer
                    } else {
                        length
                    };
                    ((high - low) / length * (1.0 - 1e-9))
                        .ceil()
                        .clamp(1.0, 1e9) as usize
                };
                (0..names.len()).map(count).collect()
            }
        };
        let total = counts
            .iter()
            .fold(1.0, |product, &count| product * count as f64);
        if total > MOST_POINTS as f64 && self.grid.is_none() {
            let found = format!("a grid of {total:.0} points");
            return Err(CgError::Input(format!(
                "{found}\nhelp: a larger --spacing, or --grid, which has no limit"
            )));
        }
        if total > u32::MAX as f64 {
            return Err(CgError::Input(format!(
                "--grid: {total:.0} points are more than can be counted"
            )));
        }
        let axes = limits
            .into_iter()
            .zip(counts)
            .map(|((min, max), count)| GridAxis { min, max, count });
        Ok(Place::Grid(axes.collect()))
    }

    fn parts(&self, names: &[String], state: &State) -> Result<Vec<Part>, CgError> {
        let mut parts = vec![Part::everything()];
        let name_of = |index: u32| {
            names
                .get(index as usize)
                .cloned()
                .unwrap_or_else(|| format!("material_{index}"))
        };
        if self.by_material {
            // Those that the input names, and those that are there: indices may be any numbers.
            let mut present: Vec<u32> = state.particles.material.clone();
            present.extend(0..names.len() as u32);
            present.sort_unstable();
            present.dedup();
            if present.len() > MOST_MATERIALS {
                let found = format!("--by-material: the input has {} materials", present.len());
                let help = "--material NAME for those that are wanted";
                return Err(CgError::Input(format!("{found}\nhelp: {help}")));
            }
            parts.extend(present.into_iter().map(|index| Part {
                name: Some(name_of(index)),
                material: Some(index),
            }));
        }
        for wanted in &self.materials {
            let named = names
                .iter()
                .position(|name| name == wanted)
                .map(|k| k as u32);
            let index = named.or_else(|| {
                wanted
                    .parse()
                    .ok()
                    .filter(|&k: &u32| names.is_empty() || (k as usize) < names.len())
            });
            let Some(index) = index else {
                let known = if names.is_empty() {
                    "indices only".to_owned()
                } else {
                    names.join(", ")
                };
                return Err(CgError::Input(format!(
                    "--material: there is no material {wanted}; the input has {known}"
                )));
            };
            let part = Part {
                name: Some(name_of(index)),
                material: Some(index),
            };
            if !parts.contains(&part) {
                parts.push(part);
            }
        }
        Ok(parts)
    }
}

/// Refuses kernels that see so many periodic and mirror images that the analysis would not end in a reasonable time.
///
/// # Errors
/// Where there are more than 10,000 of each particle.
pub fn refuse_many_images(evaluator: &Evaluator, space: &Space) -> Result<(), CgError> {
    let images = evaluator.images_of_each(space);
    // Also where it is no number.
    if images <= MOST_IMAGES {
        return Ok(());
    }
    let width = evaluator.kernel.width;
    let found = format!(
        "--width: a kernel of {width} m sees {images:.3e} periodic and mirror images of each particle"
    );
    let help = "a smaller width, or coordinates over which fields are means";
    Err(CgError::Input(format!("{found}\nhelp: {help}")))
}

fn extent(state: &State, coordinates: &Coordinates, axis: &CylinderAxis, a: usize) -> f64 {
    match coordinates {
        Coordinates::Cartesian(_) => state.space.extent(a),
        Coordinates::Cylindrical { .. } => state.space.extent((axis.along + 1 + a) % 3),
    }
}

/// Mean diameter of the flowing particles, m.
///
/// # Errors
/// When there are none.
pub fn mean_diameter(state: &State) -> Result<f64, CgError> {
    let particles = &state.particles;
    let flowing = || (0..particles.len()).filter(|&k| particles.flowing[k]);
    let count = flowing().count();
    let sum: f64 = flowing().map(|k| 2.0 * particles.radius[k]).sum();
    if sum > 0.0 {
        Ok(sum / count as f64)
    } else {
        let found = format!(
            "no flowing particles at t = {}, so that no width in diameters can be found",
            state.time
        );
        Err(CgError::Input(format!(
            "{found}\nhelp: --width 0.002 gives it in m"
        )))
    }
}

/// The limits of a coordinate: those of the domain, or around all particles where it has no size.
fn usual_limits(
    name: &str,
    axis: &CylinderAxis,
    coordinates: &Coordinates,
    state: &State,
) -> Result<(f64, f64), CgError> {
    let bounds = |a: usize| {
        let (low, high) = (state.space.min[a], state.space.max[a]);
        if low < high {
            return Some((low, high));
        }
        let p = &state.particles;
        let low = p
            .position
            .iter()
            .zip(&p.radius)
            .fold(f64::INFINITY, |low, (x, r)| low.min(x[a] - r));
        let high = p
            .position
            .iter()
            .zip(&p.radius)
            .fold(f64::NEG_INFINITY, |high, (x, r)| high.max(x[a] + r));
        (low < high).then_some((low, high))
    };
    let cylindrical = matches!(coordinates, Coordinates::Cylindrical { .. });
    let found = match name {
        "phi" => Some((-std::f64::consts::PI, std::f64::consts::PI)),
        "r" => {
            // As far as the nearest face.
            let across = [1, 2].map(|k| {
                let a = (axis.along + k) % 3;
                bounds(a).map(|(low, high)| (axis.through[a] - low).min(high - axis.through[a]))
            });
            across[0]
                .zip(across[1])
                .map(|(a, b)| (0.0, a.min(b)))
                .filter(|(_, r)| *r > 0.0)
        }
        "z" if cylindrical => bounds(axis.along),
        name => bounds(
            ["x", "y", "z"]
                .iter()
                .position(|other| *other == name)
                .unwrap_or(0),
        ),
    };
    found.ok_or_else(|| {
        CgError::Input(format!(
            "no limits of {name} can be found in the input\nhelp: --limits {name}=FROM..TO"
        ))
    })
}

/// Points of a table: one line each, separated by blanks or commas; `#` and a line of names are passed over.
fn points(path: &Path, count: usize) -> Result<Place, CgError> {
    use mercury_common::error::FormatError;
    let text = std::fs::read_to_string(path)
        .map_err(|error| FormatError::of_file(path, format!("the file cannot be read: {error}")))?;
    let mut points = Vec::new();
    let mut named = false;
    for (k, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let words: Vec<&str> = line
            .split([',', ' ', '\t'])
            .filter(|word| !word.is_empty())
            .collect();
        let numbers: Option<Vec<f64>> = words
            .iter()
            .map(|word| word.parse().ok().filter(|value: &f64| value.is_finite()))
            .collect();
        match numbers {
            Some(numbers) if numbers.len() == count => points.push(numbers),
            Some(numbers) => {
                let expected = format!("{count}, one for each resolved coordinate");
                return Err(FormatError::at(
                    path,
                    k + 1,
                    None,
                    format!("{} numbers", numbers.len()),
                    expected,
                )
                .into());
            }
            None if points.is_empty() && !named => named = true,
            None => {
                return Err(FormatError::at(
                    path,
                    k + 1,
                    None,
                    format!("\"{}\"", shortened(line, 100)),
                    "finite numbers",
                )
                .into());
            }
        }
    }
    if points.is_empty() {
        return Err(FormatError::of_file(path, "no points in this file").into());
    }
    Ok(Place::Points(points))
}
