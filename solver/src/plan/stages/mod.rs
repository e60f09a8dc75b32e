//! From a scene to its plan, in stages, each of which is a value: the parts of the scene, the laws of its pairs, the checks of
//! their places, the time step, and all of it as one plan. Problems of all stages are collected.

mod assemble;
mod laws;
mod parts;
mod step;

use crate::membranes::plan::without_energy;
use mercury_common::scene::{Scene, SceneError, SceneErrors};

use super::checks;
use super::magnitudes::magnitudes;
use super::meshes;
use super::requests;
use super::walls::continue_cylinders;
use super::{Counted, Plan};
use crate::boundaries::plan::insertions::check_among_walls;
use assemble::{Resolved, assemble};
use laws::Laws;
use parts::Parts;
use step::plan_step;

/// The largest number of materials: a law is made and reported for each pair.
const MOST_MATERIALS: usize = 128;

/// Findings of the stages about a scene.
#[derive(Default)]
struct Findings {
    errors: Vec<SceneError>,
    warnings: Vec<String>,
    remarks: Vec<String>,
}

/// Resolves a scene: the laws of all pairs of materials, the time step, the particles of the start and of insertions, the parts
/// that are skipped.
///
/// # Errors
/// Everything that is wrong with the scene, and every part of it that this version cannot run, each with its place.
pub fn plan(scene: &Scene) -> Result<Plan, SceneErrors> {
    planned(scene, u64::MAX)
}

/// The plan of a scene with two sites of each lattice: cheap whatever their number, and sufficient for the memory of the whole.
/// Parts that it leaves out are counted in [`Counted::left_out`](super::Counted::left_out).
///
/// # Errors
/// As [`plan`], except for errors of other sites.
pub fn sketch(scene: &Scene) -> Result<Plan, SceneErrors> {
    // Two particles of a material need the law just as many do.
    planned(scene, 2)
}

fn planned(scene: &Scene, most_sites: u64) -> Result<Plan, SceneErrors> {
    if let Some(beyond) = scene.materials.get(MOST_MATERIALS) {
        let message = format!("there are {} materials", scene.materials.len());
        let error = beyond.name.error(message);
        let help = format!("at most {MOST_MATERIALS}: one material may have any number of sizes");
        return Err(SceneErrors(vec![error.with_help(help)]));
    }
    let mut found = Findings::default();
    let mut parts = Parts::of(scene, most_sites, &mut found);
    let laws = Laws::of(scene, &parts, &mut found);
    (found.warnings).extend(without_energy(&parts.plans, &laws.pairs, &parts.uses));
    // A pair that could not be resolved could change the step.
    let resolved = found.errors.len();
    let laws = check_sizes(scene, &parts, laws, &mut found);
    continue_walls(scene, &mut parts, &laws, &mut found);
    let mut counted = Counted {
        left_out: parts.start.left_out,
        ..Counted::default()
    };
    // Overlaps are found with the engine's list, which needs a valid domain.
    if found.errors.len() == resolved {
        check_places(scene, &parts, &mut counted, &mut found);
    }
    let step = (resolved == 0)
        .then(|| plan_step(scene, &parts, &laws.pairs, &mut found))
        .flatten();
    let Some((time_step, step)) = step.filter(|_| found.errors.is_empty()) else {
        return Err(in_order(scene, found.errors));
    };
    let resolved = Resolved {
        parts,
        laws,
        counted,
        time_step,
        step,
    };
    assemble(scene, resolved, found)
}

/// Whether sizes, densities and volumes of liquid fit each other and the domain. It completes the laws of bridges, which need the sizes.
fn check_sizes(scene: &Scene, parts: &Parts, laws: Laws, found: &mut Findings) -> Laws {
    let Parts {
        dimensions,
        clumps,
        start,
        insertions,
        sizes,
        ..
    } = parts;
    magnitudes(
        scene,
        start,
        clumps,
        insertions,
        *dimensions,
        &mut found.errors,
    );
    let laws = laws.with_bridges(scene, parts, found);
    let Findings {
        errors, warnings, ..
    } = found;
    checks::inside_the_domain(scene, start, errors);
    checks::far_from_the_origin(scene, start, sizes.smallest, errors, warnings);
    if sizes.largest > 0.0 {
        checks::periodic_axes(
            scene,
            sizes.largest,
            sizes.largest_body,
            laws.range(),
            errors,
        );
    }
    if *dimensions == 2 {
        checks::flat(scene, start, insertions, errors);
    }
    laws
}

/// Walls that go on along periodic axes, as far as any particle can feel them.
fn continue_walls(scene: &Scene, parts: &mut Parts, laws: &Laws, found: &mut Findings) {
    continue_cylinders(&mut parts.walls, &scene.domain, &mut found.remarks);
    let reach = parts.sizes.largest + laws.range();
    meshes::continue_periodically(&mut parts.walls, &scene.domain, reach, &mut found.remarks);
}

/// Checks the places of particles, walls, sheets and insertions: overlaps, particles behind walls, regions without space.
fn check_places(scene: &Scene, parts: &Parts, counted: &mut Counted, found: &mut Findings) {
    let Parts {
        dimensions,
        walls,
        clumps,
        start,
        insertions,
        plans,
        sizes,
        ..
    } = parts;
    let Findings {
        errors, warnings, ..
    } = found;
    let radii = [sizes.smallest, sizes.mean, sizes.largest];
    [counted.touching, counted.listed] =
        checks::overlaps(scene, start, clumps, walls, radii, errors, warnings);
    checks::through_sheets(scene, start, clumps, plans.all(), warnings);
    counted.scale_up(start, clumps);
    check_among_walls(
        scene,
        insertions,
        clumps,
        walls,
        *dimensions,
        errors,
        warnings,
    );
    warnings.extend(requests::warnings(scene, insertions, *dimensions));
}

/// Errors in the order in which a reader meets them: file order, the command line last.
fn in_order(scene: &Scene, mut errors: Vec<SceneError>) -> SceneErrors {
    if errors.is_empty() {
        errors.push(scene.place.error("the scene has no plan"));
    }
    errors.sort_by_key(|error| {
        let place = &error.place;
        (place.is_argument(), place.line(), place.column())
    });
    SceneErrors(errors)
}
