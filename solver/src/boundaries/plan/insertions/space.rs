//! Whether a region has space for what is inserted in it.

use mercury_common::scene::{Insertion, Scene, SceneError};
use mercury_common::sizes::{SizeDistribution, warning_of_shares};

use crate::plan::cell_of;
use mercury_engine::bodies::Clump;
use mercury_engine::boundaries::{
    Blocked, Ingredient, InsertionPlan, PLACES_AMONG_WALLS, Region, Space, blocked, may_hold,
};
use mercury_engine::contact::parameter::short;
use mercury_engine::walls::{Wall, WallNow};

/// The share of the particles, by number, that must have a position: the rest is too rare to wait for at the start.
pub(super) const ALMOST_ALL: f64 = 0.999;

/// Radius (m) of the sphere of a `diameter` (m) of each ingredient's sizes, of clumps of the largest pebble of a body of that
/// size; and whether it is a pebble.
pub(super) fn spheres<'a>(
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
pub(super) fn check_large(
    name: &str,
    region: &Region,
    (radius, is_pebble): (f64, bool),
    space: Space<'_>,
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
pub(super) fn check_room(
    name: &str,
    region: &Region,
    (radius, is_pebble): (f64, bool),
    space: Space<'_>,
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
pub(crate) fn check_among_walls(
    scene: &Scene,
    insertions: &[InsertionPlan],
    clumps: &[Clump],
    walls: &[Wall],
    dimensions: u8,
    errors: &mut Vec<SceneError>,
    warnings: &mut Vec<String>,
) {
    let cell = &cell_of(&scene.domain);
    let space = Space { cell, dimensions };
    let stays =
        |wall: &&Wall| wall.motion.is_static() && wall.from <= 0.0 && wall.until == f64::INFINITY;
    let (walls, now): (Vec<&Wall>, Vec<WallNow>) = (walls.iter().filter(stays))
        .map(|wall| (wall, WallNow::new(wall, 0.0, cell)))
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
