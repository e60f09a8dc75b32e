//! `[[insertions]]` and `[[deletions]]` as the engine's plans.

use std::path::Path;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use mercury_common::error::FormatError;
use mercury_common::formats::number::parse_number;
use mercury_common::scene::{
    Body, Component, Insertion, Located, Method, Psd, Quantity, Rate as SceneRate,
    Region as SceneRegion, Scene, SceneError, SizeLaw, Total,
};
use mercury_common::sizes::{SizeDistribution, SizeError, warning_of_shares};

use super::{Plan, meshes};
use crate::bodies::Clump;
use crate::boundaries::{
    Blocked, DeletionPlan, Ingredient, InsertionPlan, MOST_OF_QUOTA, PLACES_AMONG_WALLS, Rate,
    Region, Space, blocked, may_hold, volume_within,
};
use crate::contact::parameter::short;
use crate::neighbours::Images;
use crate::state::{MaterialIndex, volume};
use crate::walls::{Wall, WallNow};

/// All insertions that can be planned, in the order of the file. No `clumps`: they could not be read.
pub(super) fn insertions(
    scene: &Scene,
    clumps: Option<&[Clump]>,
    dimensions: u8,
    errors: &mut Vec<SceneError>,
) -> Vec<InsertionPlan> {
    scene
        .insertions
        .iter()
        .filter_map(|insertion| plan_one(scene, insertion, clumps, dimensions, errors))
        .collect()
}

/// All deletions, in the order of the file.
pub(super) fn deletions(scene: &Scene, errors: &mut Vec<SceneError>) -> Vec<DeletionPlan> {
    scene
        .deletions
        .iter()
        .filter_map(|deletion| {
            Some(DeletionPlan {
                name: deletion.name.value.clone(),
                region: region(&deletion.region, errors)?,
            })
        })
        .collect()
}

fn plan_one(
    scene: &Scene,
    insertion: &Insertion,
    clumps: Option<&[Clump]>,
    dimensions: u8,
    errors: &mut Vec<SceneError>,
) -> Option<InsertionPlan> {
    let before = errors.len();
    let mut mixture = Vec::new();
    for component in &insertion.mixture {
        let (material, clump) = match &component.body {
            Body::Sphere(material) => (material.value, None),
            // The scene is refused already.
            Body::Clump(_) if clumps.is_none() => return None,
            Body::Clump(clump) => {
                let template = scene.clumps.get(clump.value.0)?;
                (template.material.value, Some(clump.value.0 as u32))
            }
        };
        let own = clump.and_then(|index| clumps?.get(index as usize));
        let sizes = match sizes(component, own) {
            Ok(sizes) => sizes,
            Err(error) => {
                errors.push(error);
                continue;
            }
        };
        if component.share > 0.0
            && let Some(fines) = sizes.warning_of_fines()
        {
            let place = component
                .psd
                .as_ref()
                .map_or(&component.place, |psd| &psd.place);
            errors.push(
                place
                    .error("has no smallest particle, so that no time step is short enough")
                    .with_help(fines),
            );
            continue;
        }
        let mean_volume = mean_volume(&sizes, dimensions);
        // A share of mass or volume is turned into a number of particles by their mean size.
        let per_particle = match insertion.share_by {
            Quantity::Number => 1.0,
            Quantity::Volume => mean_volume,
            Quantity::Mass => mean_volume * *scene.materials.get(material.0)?.density,
        };
        mixture.push(Ingredient {
            material: MaterialIndex::new(material.0 as u32),
            clump,
            sizes,
            share: component.share / per_particle,
            film_volume: *component.film_volume,
        });
    }
    let sum: f64 = mixture.iter().map(|ingredient| ingredient.share).sum();
    for ingredient in &mut mixture {
        ingredient.share /= sum;
    }
    let total = insertion.total.as_ref().map(|total| total.value);
    let rate = insertion.rate.as_ref().and_then(|rate| {
        let steady = |quantity, per_second| {
            Some(Rate::Steady {
                quantity,
                per_second,
            })
        };
        match &rate.value {
            SceneRate::Number(per_second) => steady(Quantity::Number, *per_second),
            SceneRate::Mass(per_second) => steady(Quantity::Mass, *per_second),
            SceneRate::Volume(per_second) => steady(Quantity::Volume, *per_second),
            SceneRate::Table(file) => match read_rate_table(file) {
                // The table counts what the total counts.
                Ok(rows) => Some(Rate::Table {
                    quantity: match total {
                        Some(Total::Number(_)) => Quantity::Number,
                        Some(Total::Volume(_)) => Quantity::Volume,
                        _ => Quantity::Mass,
                    },
                    rows,
                }),
                Err(message) => {
                    errors.push(rate.error(message));
                    None
                }
            },
        }
    });
    let region = region(&insertion.region, errors)?;
    if errors.len() == before {
        let space = Space {
            domain: (*scene.domain.min, *scene.domain.max),
            periodic: scene.domain.periodic,
            dimensions,
        };
        let clumps = clumps.unwrap_or_default();
        let name = &insertion.name.value;
        let smallest = spheres(&mixture, clumps, SizeDistribution::smallest).fold(
            (f64::INFINITY, false),
            |least, next| {
                if next.0 < least.0 { next } else { least }
            },
        );
        let large = spheres(&mixture, clumps, |sizes| sizes.sample_diameter(ALMOST_ALL)).fold(
            (0.0, false),
            |most, next| if next.0 > most.0 { next } else { most },
        );
        let room = check_room(name, &region, smallest, space)
            .and_then(|()| check_large(name, &region, large, space));
        if let Err((message, help)) = room {
            errors.push(insertion.region.error(message).with_help(help));
        }
    }
    let by_quota = insertion.method.value == Method::Quota;
    if errors.len() == before && by_quota {
        errors.extend(wrong_quota(scene, insertion, &mixture, total, dimensions));
    }
    (errors.len() == before).then(|| InsertionPlan {
        name: insertion.name.value.clone(),
        region,
        mixture,
        by_quota,
        total,
        rate,
        velocity_mean: *insertion.velocity_mean,
        velocity_spread: *insertion.velocity_spread,
        from: *insertion.from,
        until: insertion.until.as_deref().copied().unwrap_or(f64::INFINITY),
        attempts: (*insertion.attempts).max(1),
        closing: Vec::new(),
    })
}

/// The share of the particles, by number, that must have a position: the rest is too rare to wait for at the start.
const ALMOST_ALL: f64 = 0.999;

/// Of each ingredient the radius (m) of the sphere of a `diameter` (m) of its sizes, of clumps of the largest pebble of a body of that size;
/// and whether it is a pebble.
fn spheres<'a>(
    mixture: &'a [Ingredient],
    clumps: &'a [Clump],
    diameter: impl Fn(&SizeDistribution) -> f64 + 'a,
) -> impl Iterator<Item = (f64, bool)> + 'a {
    let used = mixture.iter().filter(|part| part.share > 0.0);
    used.map(move |part| {
        let radius = 0.5 * diameter(&part.sizes);
        let clump = part.clump.and_then(|index| clumps.get(index as usize));
        clump.map_or((radius, false), |clump| {
            let scale = 2.0 * radius / clump.equal_volume_diameter();
            (scale * clump.pebble_radii().1, true)
        })
    })
}

/// Refuses a region in which large particles have no place: the first of them would be waited for until the end of the run.
fn check_large(
    name: &str,
    region: &Region,
    (radius, is_pebble): (f64, bool),
    space: Space,
) -> Result<(), (String, &'static str)> {
    if may_hold(region, radius, space) {
        return Ok(());
    }
    let what = match (is_pebble, space.dimensions) {
        (true, _) => "a pebble of its largest bodies",
        (false, 2) => "its largest discs",
        (false, _) => "its largest spheres",
    };
    Err((
        format!(
            "the region of \"{name}\" has no place for {what}, {} m in diameter: as no particle is exchanged for a smaller one, all would wait for the first of them",
            short(2.0 * radius)
        ),
        "what is inserted lies wholly inside: widen the region, or cut the sizes (cut = [0, 0.99]); are the units of the diameters right?",
    ))
}

/// Refuses a region in which nothing can ever be inserted: returns the reason, and advice.
fn check_room(
    name: &str,
    region: &Region,
    (radius, is_pebble): (f64, bool),
    space: Space,
) -> Result<(), (String, &'static str)> {
    if !may_hold(region, 0.0, space) {
        return Err((
            format!(
                "the region of \"{name}\" has no volume within the domain, so that nothing can ever be inserted"
            ),
            "move it into the box of domain.min and domain.max; lengths are in metres",
        ));
    }
    if radius.is_finite() && !may_hold(region, radius, space) {
        let what = match (is_pebble, space.dimensions) {
            (true, _) => "the largest pebble of the smallest body",
            (false, 2) => "the smallest disc",
            (false, _) => "the smallest sphere",
        };
        return Err((
            format!(
                "the region of \"{name}\" has no place for {what}, {} m in diameter, so that nothing can ever be inserted",
                short(2.0 * radius)
            ),
            "what is inserted lies wholly inside: widen the region or insert smaller particles; lengths are in metres",
        ));
    }
    Ok(())
}

/// Refuses regions in which walls that never move leave no place, and warns of shares that do not sum to the whole.
pub(super) fn check_among_walls(
    scene: &Scene,
    insertions: &[InsertionPlan],
    clumps: &[Clump],
    walls: &[Wall],
    dimensions: u8,
    errors: &mut Vec<SceneError>,
    warnings: &mut Vec<String>,
) {
    let space = Space {
        domain: (*scene.domain.min, *scene.domain.max),
        periodic: scene.domain.periodic,
        dimensions,
    };
    let images = Images::new(space.domain.0, space.domain.1, space.periodic);
    let stays =
        |wall: &&Wall| wall.motion.is_static() && wall.from <= 0.0 && wall.until == f64::INFINITY;
    let (walls, now): (Vec<&Wall>, Vec<WallNow>) = (walls.iter().filter(stays))
        .map(|wall| (wall, WallNow::new(wall, 0.0, &images)))
        .unzip();
    for planned in insertions {
        // Those with errors of their own are not planned.
        let is_it = |insertion: &&Insertion| insertion.name.value == planned.name;
        let Some(insertion) = scene.insertions.iter().find(is_it) else {
            continue;
        };
        let stated = insertion.mixture.iter().map(|part| part.stated_share);
        let stated: Vec<f64> = stated.collect();
        let whose = format!("\"{}\"", insertion.name.value);
        warnings.extend(warning_of_shares(&whose, &stated));
        let of_sizes = insertion
            .mixture
            .iter()
            .filter_map(|part| part.psd.as_ref());
        let of_sizes = of_sizes.filter_map(|psd| psd.value.warning_of_shares());
        warnings.extend(of_sizes.map(|warning| format!("insertion {whose}: {warning}")));
        let radius = spheres(&planned.mixture, clumps, SizeDistribution::smallest)
            .map(|(radius, _)| radius)
            .fold(f64::INFINITY, f64::min);
        if !radius.is_finite() {
            continue;
        }
        let Some(Blocked { wall, share }) = blocked(&planned.region, radius, space, &now) else {
            continue;
        };
        let wall = &walls[wall].name;
        let help = "move the region to the other side, or turn the wall round: a plane's normal points into the space of the particles, other shapes have a `side`";
        if share == 1.0 {
            let error = insertion.region.error(format!(
                "the region of {whose} lies behind or in walls, most of it `{wall}`: of {PLACES_AMONG_WALLS} random places in \
                it none has space for a sphere of {} m",
                short(2.0 * radius)
            ));
            errors.push(error.with_help(help));
        } else if share > 0.5 {
            let percent = (100.0 * share).round();
            warnings.push(format!(
                "insertion {whose}: {percent} % of its region lie behind or in walls, most of it `{wall}`, and get no grain; if that is not meant: {help}"
            ));
        }
    }
}

/// Points of the rule by which the mean area of discs is found; the quantile function is monotonic, so the error is at
/// most the range of areas over this number.
const AREA_POINTS: u32 = 4096;

/// Why numbers cannot be fixed in advance.
fn wrong_quota(
    scene: &Scene,
    insertion: &Insertion,
    mixture: &[Ingredient],
    total: Option<Total>,
    dimensions: u8,
) -> Option<SceneError> {
    let mean = |weight: &dyn Fn(&Ingredient) -> f64| -> f64 {
        let of =
            |part: &Ingredient| part.share * weight(part) * mean_volume(&part.sizes, dimensions);
        mixture.iter().map(of).sum()
    };
    let density = |part: &Ingredient| {
        let material = scene.materials.get(part.material.index());
        material.map_or(f64::NAN, |material| *material.density)
    };
    let number = match total {
        Some(Total::Number(number)) => number as f64,
        Some(Total::Volume(volume)) => volume / mean(&|_| 1.0),
        Some(Total::Mass(mass)) => mass / mean(&density),
        Some(Total::Full) | None => {
            let message = "needs a total: the number of each size is fixed before the first comes";
            let error = insertion.method.place.error(message);
            return Some(error.with_help(
                "give total = { number | mass | volume = ... }, or use method = \"random\"",
            ));
        }
    };
    (number > MOST_OF_QUOTA).then(|| {
        let message = format!(
            "{number:.3e} particles are expected, and a quota lists at most {MOST_OF_QUOTA:.0e}"
        );
        let error = insertion.method.place.error(message);
        error.with_help("are the units of the diameters right? Else use method = \"random\"")
    })
}

/// The sizes of a component; a clump without a distribution has its own size.
fn sizes(component: &Component, clump: Option<&Clump>) -> Result<SizeDistribution, SceneError> {
    let Some(psd) = &component.psd else {
        let own = clump.and_then(|clump| SizeDistribution::single(clump.equal_volume_diameter()));
        return own.ok_or_else(|| component.place.error("the size of the clump is not known"));
    };
    SizeDistribution::from_scene(psd).map_err(|error| match error {
        SizeError::Improper(error) => error,
        SizeError::File(error) => of_file(psd, error),
        error @ SizeError::Law(_) => psd.error(error.to_string()),
    })
}

/// The error in the table that a scene names, at the place of the name.
fn of_file(psd: &Located<Psd>, mut error: FormatError) -> SceneError {
    let help = error.help.take();
    let error = match &psd.law {
        SizeLaw::File { file } => file.error(error.to_string()),
        _ => psd.error(error.to_string()),
    };
    match help {
        Some(help) => error.with_help(help),
        None => error,
    }
}

/// Mean volume of the particles (m^3), or mean area of discs (m^2), by number.
#[must_use]
pub(crate) fn mean_volume(sizes: &SizeDistribution, dimensions: u8) -> f64 {
    if dimensions != 2 {
        return sizes.mean_volume();
    }
    let area = |i: u32| {
        let u = (f64::from(i) + 0.5) / f64::from(AREA_POINTS);
        volume(0.5 * sizes.sample_diameter(u), 2)
    };
    (0..AREA_POINTS).map(area).sum::<f64>() / f64::from(AREA_POINTS)
}

/// Solid fraction, in three and two dimensions, of spheres and discs that are placed at random until no more fit (Torquato 2002, Random
/// Heterogeneous Materials, table 3.1), and of those that are packed at random.
const PLACED: [f64; 2] = [0.38, 0.55];
const PACKED: [f64; 2] = [0.64, 0.84];

/// The particles that an insertion brings at most: limited by its total, its rate and the space.
#[must_use]
pub(super) fn expected_inserted(insertion: &InsertionPlan, plan: &Plan) -> f64 {
    let densities: Vec<f64> = plan
        .physics()
        .materials()
        .iter()
        .map(|m| m.density)
        .collect();
    let of_total = |total| {
        let only = InsertionPlan {
            total: Some(total),
            ..insertion.clone()
        };
        expected_number(&only, &densities, plan.physics().dimensions()).unwrap_or(f64::INFINITY)
    };
    let [placed, packed] =
        [PLACED, PACKED].map(|part| part[usize::from(plan.physics().dimensions() == 2)]);
    let (min, max) = (plan.physics().domain_min(), plan.physics().domain_max());
    let space = |low: DVec3, high: DVec3| match plan.physics().dimensions() {
        2 => (high - low).truncate().max(DVec2::ZERO).element_product(),
        _ => (high - low).max(DVec3::ZERO).element_product(),
    };
    let by_total = match insertion.total {
        Some(Total::Full) => {
            let (low, high) = insertion.region.bounds();
            let space = match plan.physics().dimensions() {
                2 => space(low.max(min), high.min(max)),
                _ => volume_within(&insertion.region, min, max),
            };
            of_total(Total::Volume(placed * space))
        }
        Some(total) => of_total(total),
        None => f64::INFINITY,
    };
    let end = insertion
        .until
        .min(plan.physics().steps() as f64 * plan.physics().time_step());
    let by_rate = match &insertion.rate {
        _ if end < insertion.from => 0.0,
        None => f64::INFINITY,
        Some(rate) => match rate.allowed(insertion.from, end) {
            // The last one may exceed what is allowed.
            (Quantity::Number, number) => number.ceil(),
            (Quantity::Mass, mass) => of_total(Total::Mass(mass)) + 1.0,
            (Quantity::Volume, volume) => of_total(Total::Volume(volume)) + 1.0,
        },
    };
    let by_space = of_total(Total::Volume(packed * space(min, max)));
    by_total.min(by_rate).min(by_space)
}

/// Grains per unit of a quantity of an insertion: per kg, per m^3, or 1.
pub(super) fn grains_per_unit(insertion: &InsertionPlan, quantity: Quantity, plan: &Plan) -> f64 {
    let physics = plan.physics();
    let materials = physics.materials().iter();
    let densities: Vec<f64> = materials.map(|material| material.density).collect();
    let unit = InsertionPlan {
        total: Some(match quantity {
            Quantity::Number => return 1.0,
            Quantity::Mass => Total::Mass(1.0),
            Quantity::Volume => Total::Volume(1.0),
        }),
        ..insertion.clone()
    };
    expected_number(&unit, &densities, physics.dimensions()).unwrap_or(0.0)
}

/// The particles that an insertion is expected to bring, where its total says so.
#[must_use]
pub fn expected_number(
    insertion: &InsertionPlan,
    densities: &[f64],
    dimensions: u8,
) -> Option<f64> {
    let mean = |weight: &dyn Fn(&Ingredient) -> f64| -> f64 {
        let parts = insertion.mixture.iter();
        parts
            .map(|part| part.share * weight(part) * mean_volume(&part.sizes, dimensions))
            .sum()
    };
    match insertion.total? {
        Total::Number(number) => Some(number as f64),
        Total::Volume(volume) => Some(volume / mean(&|_| 1.0)),
        Total::Mass(mass) => Some(mass / mean(&|part| densities[part.material.index()])),
        Total::Full => None,
    }
}

/// The engine's form of a region; none where a mesh in it is wrong.
pub(super) fn region(region: &SceneRegion, errors: &mut Vec<SceneError>) -> Option<Region> {
    let mut all = |parts: &[SceneRegion]| -> Option<Vec<Region>> {
        let parts = parts.iter().map(|part| self::region(part, errors));
        // All of them, so that every problem is reported.
        parts.collect::<Vec<_>>().into_iter().collect()
    };
    Some(match region {
        SceneRegion::Box { min, max } => Region::Box {
            min: **min,
            max: **max,
        },
        SceneRegion::Cylinder {
            axis,
            origin,
            radius,
            along,
        } => Region::Cylinder {
            axis: **axis,
            origin: **origin,
            radius: **radius,
            along: along
                .as_deref()
                .copied()
                .unwrap_or([f64::NEG_INFINITY, f64::INFINITY]),
        },
        SceneRegion::Sphere { origin, radius } => Region::Sphere {
            origin: **origin,
            radius: **radius,
        },
        SceneRegion::Cone {
            axis,
            origin,
            along,
            radii,
        } => Region::Cone {
            axis: **axis,
            origin: **origin,
            along: **along,
            radii: **radii,
        },
        SceneRegion::HalfSpace { point, normal } => Region::HalfSpace {
            point: **point,
            normal: **normal,
        },
        SceneRegion::Union(parts) => Region::Union(all(parts)?),
        SceneRegion::Intersection(parts) => Region::Intersection(all(parts)?),
        SceneRegion::Difference(parts) => Region::Difference(all(parts)?),
        SceneRegion::Mesh(source) => match meshes::solid(source) {
            Ok(solid) => Region::Mesh(Arc::new(solid)),
            Err(error) => {
                errors.push(error);
                return None;
            }
        },
    })
}

/// Reads a table `t,cumulative`: a header, then rows of ascending time and not decreasing amount.
fn read_rate_table(path: &Path) -> Result<Vec<[f64; 2]>, String> {
    let name = path.display();
    let text = std::fs::read_to_string(path).map_err(|e| format!("{name} cannot be read: {e}"))?;
    parse_rate_table(&text).map_err(|(line, message)| format!("{name}:{line}: {message}"))
}

fn parse_rate_table(text: &str) -> Result<Vec<[f64; 2]>, (usize, String)> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut lines = text.lines().enumerate().filter(|(_, line)| {
        let line = line.trim();
        !line.is_empty() && !line.starts_with('#')
    });
    let cells = |line: &str| -> Vec<String> {
        line.split(',').map(|cell| cell.trim().to_owned()).collect()
    };
    let Some((number, header)) = lines.next() else {
        return Err((
            1,
            "the table is empty, expected the header t,cumulative".to_owned(),
        ));
    };
    if cells(header) != ["t", "cumulative"] {
        let found = header.trim();
        return Err((
            number + 1,
            format!("expected the header t,cumulative, got {found}"),
        ));
    }
    let mut rows: Vec<[f64; 2]> = Vec::new();
    for (index, line) in lines {
        let fail = |message: String| Err((index + 1, message));
        let numbers: Vec<Option<f64>> = cells(line)
            .iter()
            .map(|cell| parse_number(cell).filter(|number| number.is_finite()))
            .collect();
        let &[Some(time), Some(amount)] = numbers.as_slice() else {
            return fail(format!("expected two numbers, got {}", line.trim()));
        };
        match rows.last() {
            Some(&[before, _]) if time <= before => {
                return fail(format!(
                    "t = {time} does not lie after {before}, the row before"
                ));
            }
            Some(&[_, before]) if amount < before => {
                return fail(format!(
                    "cumulative = {amount} lies below {before}, the row before"
                ));
            }
            None if amount < 0.0 => return fail(format!("cumulative = {amount} is negative")),
            _ => rows.push([time, amount]),
        }
    }
    if rows.is_empty() {
        return Err((number + 1, "no rows below the header".to_owned()));
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::parse_rate_table;

    #[test]
    fn rate_tables_are_read_and_their_mistakes_named() {
        let rows = parse_rate_table("# feed\nt,cumulative\n0, 0\n\n1.5,2\n");
        assert_eq!(rows, Ok(vec![[0.0, 0.0], [1.5, 2.0]]));
        for (text, line, message) in [
            (
                "",
                1,
                "the table is empty, expected the header t,cumulative",
            ),
            (
                "t,mass\n0,0\n",
                1,
                "expected the header t,cumulative, got t,mass",
            ),
            ("t,cumulative\n", 1, "no rows below the header"),
            ("t,cumulative\n0,x\n", 2, "expected two numbers, got 0,x"),
            (
                "t,cumulative\n0,1,2\n",
                2,
                "expected two numbers, got 0,1,2",
            ),
            (
                "t,cumulative\n0,inf\n",
                2,
                "expected two numbers, got 0,inf",
            ),
            ("t,cumulative\n0,-1\n", 2, "cumulative = -1 is negative"),
            (
                "t,cumulative\n0,1\n0,2\n",
                3,
                "t = 0 does not lie after 0, the row before",
            ),
            (
                "t,cumulative\n0,1\n1,0\n",
                3,
                "cumulative = 0 lies below 1, the row before",
            ),
        ] {
            assert_eq!(
                parse_rate_table(text),
                Err((line, message.to_owned())),
                "{text:?}"
            );
        }
    }
}
