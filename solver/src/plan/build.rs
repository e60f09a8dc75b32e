//! From a scene to its plan: every module of the plan in turn, all problems collected.

use std::sync::Arc;

use glam::DVec3;
use mercury_common::scene::{
    ClumpMass, ClumpsAs, Dimensions, Scene, SceneError, SceneErrors, TimeStep, stem,
};

use super::bridges;
use super::checks;
use super::closing;
use super::doubtful::{Doubt, doubts};
use super::fields::fields;
use super::fluxes::fluxes;
use super::insertions::{check_among_walls, deletions, insertions};
use super::magnitudes::magnitudes;
use super::membranes::{self, membranes};
use super::meshes;
use super::pair::PairPlan;
use super::particles::{StartingParticles, starting_particles};
use super::regions::regions;
use super::requests;
use super::sizes::Sizes;
use super::sleeping::sleeping;
use super::sprays::sprays;
use super::start_from_run::{Earlier, Here, carried};
use super::time_step::{
    Limit, Limits, REFUSED_PART, StepPlan, WARNED_PART, automatic, automatic_part, bearable_step,
    limits, steps,
};
use super::usage::{MaterialUse, material_uses, particles_meet, walls_meet};
use super::wall_films::wall_films;
use super::walls::{continue_cylinders, walls};
use super::wear::wear;
use super::{Counted, Guard, Material, Notes, OutputPlan, Outputs, Physics, Plan};
use crate::bodies::Clump;
use crate::boundaries::InsertionPlan;
use crate::contact::adhesion::liquid::Tables;
use crate::contact::mixing::{elastic_constants, resolve_pair};
use crate::contact::normal::rayleigh_time;
use crate::contact::parameter::short;
use crate::contact::registry::LawTable;
use crate::contact::{AdhesionLaw, AnyAdhesion};
use crate::liquid::{LiquidPlan, Weight};
use crate::state::MaterialIndex;
use crate::walls::Wall;

/// More steps than this cannot be counted in a double, by which times are computed.
const MOST_STEPS: f64 = 9e15;
/// The largest number of materials: a law is made and reported for each pair.
const MOST_MATERIALS: usize = 128;
/// Least reference speed, m/s.
const LEAST_SPEED: f64 = 0.1;
/// Resolves a scene: the laws of all pairs of materials, the time step, the particles of the start and of insertions, the parts
/// that are skipped.
///
/// # Errors
/// Everything that is wrong with the scene, and every part of it that this version cannot run, each with its place.
pub fn plan(scene: &Scene) -> Result<Plan, SceneErrors> {
    planned(scene, u64::MAX)
}

/// The plan of a scene with two sites of each lattice: cheap whatever their number, and sufficient for the memory of the whole.
/// What it leaves out is counted in [`Counted::left_out`](super::Counted::left_out).
///
/// # Errors As [`plan`], except for errors of other sites.
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
    let mut errors: Vec<SceneError> = Vec::new();
    let mut warnings = Vec::new();
    let dimensions = match scene.domain.dimensions {
        Dimensions::Two => 2,
        Dimensions::Three => 3,
    };

    let mut notes = Vec::new();
    let mut walls = walls(scene, &mut errors);
    let clumps = super::clumps::clumps(scene, &mut warnings, &mut notes, &mut errors);
    let mut start = starting_particles(
        scene,
        clumps.as_deref(),
        most_sites,
        &mut warnings,
        &mut errors,
    );
    notes.append(&mut start.remarks);
    let insertions = insertions(scene, clumps.as_deref(), dimensions, &mut errors);
    let clumps = clumps.unwrap_or_default();
    let sprays = sprays(scene, &walls, dimensions, &mut warnings, &mut errors);
    let regions = regions(scene, &start, &mut errors);
    let deletions = deletions(scene, &mut errors);
    let fluxes = fluxes(scene, &mut errors);
    let fields = fields(
        scene,
        &start,
        &clumps,
        &insertions,
        &mut warnings,
        &mut errors,
    );
    let sheets = membranes(scene, &walls, &mut warnings, &mut notes, &mut errors);
    let mut uses = material_uses(scene, &start, &clumps, &insertions, &walls);
    for (material, used) in uses.iter_mut().enumerate() {
        used.lightest_vertex = sheets.lightest_vertex(material);
    }
    let sizes = Sizes::of(
        &densities(scene),
        (&start.particles, &start.bodies),
        &clumps,
        &insertions,
        dimensions,
    );
    let mut pairs = plan_pairs(scene, &uses, &mut errors);
    warnings.extend(membranes::without_energy(&sheets, &pairs, &uses));
    let found = errors.len();
    magnitudes(scene, &start, &clumps, &insertions, dimensions, &mut errors);
    bridges::larger_than_grains(scene, &start, &clumps, &insertions, &mut errors);
    let tables = if errors.is_empty() {
        let radii = bridges::radii_of_materials(scene, &start, &clumps, &insertions);
        warnings.extend(bridges::wide_ratios(&pairs, &radii));
        bridges::tables(scene, &mut pairs, &radii, &mut notes, &mut errors)
    } else {
        Tables::default()
    };
    if sizes.smallest > 0.0 && sizes.smallest.is_finite() {
        for pair in &mut pairs {
            if let AnyAdhesion::Liquid(liquid) = &mut pair.law.adhesion {
                *liquid = liquid.reaching(sizes.smallest, &tables);
            }
        }
    }
    checks::inside_the_domain(scene, &start, &mut errors);
    checks::far_from_the_origin(scene, &start, sizes.smallest, &mut errors, &mut warnings);
    if sizes.largest > 0.0 {
        let ranges = pairs.iter().map(|pair| pair.law.adhesion.range());
        let range = ranges.fold(0.0, f64::max);
        checks::periodic_axes(scene, sizes.largest, sizes.largest_body, range, &mut errors);
    }
    if dimensions == 2 {
        checks::flat(scene, &start, &insertions, &mut errors);
    }
    continue_cylinders(&mut walls, &scene.domain, &mut notes);
    let reach =
        sizes.largest + (pairs.iter().map(|pair| pair.law.adhesion.range())).fold(0.0, f64::max);
    meshes::continue_periodically(&mut walls, &scene.domain, reach, &mut notes);
    // Overlaps are found with the engine's list, which needs a valid domain.
    let mut counted = Counted {
        left_out: start.left_out,
        ..Counted::default()
    };
    if errors.len() == found {
        let radii = [sizes.smallest, sizes.mean, sizes.largest];
        [counted.touching, counted.listed] = checks::overlaps(
            scene,
            &start,
            &clumps,
            &walls,
            radii,
            &mut errors,
            &mut warnings,
        );
        checks::through_sheets(scene, &start, &clumps, &sheets.surfaces, &mut warnings);
        counted.scale_up(&start, &clumps);
        check_among_walls(
            scene,
            &insertions,
            &clumps,
            &walls,
            dimensions,
            &mut errors,
            &mut warnings,
        );
        warnings.extend(requests::warnings(scene, &insertions, dimensions));
    }

    // A pair that could not be resolved could change the step.
    let step = if found == 0 {
        plan_step(
            scene,
            &pairs,
            &uses,
            &start,
            &clumps,
            &insertions,
            &walls,
            sheets.critical(),
            dimensions,
            &mut errors,
            &mut warnings,
        )
    } else {
        None
    };
    let sleeping = step
        .as_ref()
        .and_then(|(dt, _)| sleeping(scene, &sizes, *dt, &mut notes, &mut errors));
    let has_bridges = pairs
        .iter()
        .any(|pair| pair.law.adhesion.liquid().is_some());
    if let (Some(table), true) = (&scene.sleeping, has_bridges) {
        let message = "particles cannot sleep in a scene with liquid bridges, which change while nothing moves";
        let error = table.place.error(message);
        errors.push(error.with_help("leave [sleeping] out, or `liquid` at the materials"));
    }
    let Some((time_step, step_plan)) = step.filter(|_| errors.is_empty()) else {
        if errors.is_empty() {
            errors.push(scene.place.error("the scene has no plan"));
        }
        // In the order in which a reader meets them: file order, the command line last.
        errors.sort_by_key(|error| {
            let place = &error.place;
            (place.is_argument(), place.line(), place.column())
        });
        return Err(SceneErrors(errors));
    };
    let track: Vec<(String, u32)> = scene
        .output
        .track
        .iter()
        .filter_map(|name| start.named.iter().find(|(known, _)| *known == name.value))
        .cloned()
        .collect();
    let track_insertions: Vec<(String, usize)> = scene
        .output
        .track
        .iter()
        .filter_map(|name| {
            let mut insertions = scene.insertions.iter();
            let index = insertions.position(|insertion| insertion.name.value == name.value)?;
            Some((name.value.clone(), index))
        })
        .collect();
    let mut laws = LawTable {
        materials: scene.materials.len(),
        laws: vec![None; scene.materials.len() * scene.materials.len()],
        tables,
    };
    for pair in &pairs {
        let [a, b] = pair.materials.map(|material| material.index());
        laws.laws[a * laws.materials + b] = Some(pair.law);
        laws.laws[b * laws.materials + a] = Some(pair.law);
    }
    let here = Here {
        particles: start.particles.len(),
        bodies: &start.bodies,
        clumps: &clumps,
        walls: &walls,
        laws: &laws,
    };
    let carried = carried(&start.earlier, &here, &mut notes);
    let started_from = start.earlier.iter().map(Earlier::started_from).collect();
    let domain = (*scene.domain.min, *scene.domain.max);
    meshes::remarks(scene, &walls, domain, &mut warnings, &mut notes);
    let triangle_loads = meshes::has_triangle_loads(&walls, &scene.output, &mut warnings);
    ignored_keys(scene, &mut warnings);
    let wear = wear(scene, &walls);
    let wall_films = wall_films(scene, &walls);
    let has_liquid = !wall_films.is_empty()
        || laws.has_liquid()
        || sprays.is_some()
        || !start.films.is_empty()
        || !start.films_of_bodies.is_empty()
        || (insertions.iter().flat_map(|insertion| &insertion.mixture))
            .any(|part| part.film_volume > 0.0);
    let liquid = has_liquid.then(|| LiquidPlan {
        films: std::mem::take(&mut start.films),
        films_of_bodies: std::mem::take(&mut start.films_of_bodies),
        neighbours: scene.liquid.neighbours,
        bridges_form: scene.liquid.bridges_form,
        evaporation: *scene.liquid.evaporation,
        weight: (sprays.as_ref())
            .and_then(|sprays| sprays.nozzles.iter().find(|nozzle| nozzle.mass))
            .map(|nozzle| Weight {
                density: nozzle.liquid_density,
                gravity: *scene.gravity,
                lag: 0.5 * time_step,
            }),
        wall_films,
    });
    let mut plan = Plan {
        physics: Physics {
            seed: scene.seed,
            gravity: *scene.gravity,
            dimensions,
            time_step,
            steps: steps(*scene.time.end, time_step) as u64,
            until_at_rest: *scene.time.until_at_rest,
            domain_min: *scene.domain.min,
            domain_max: *scene.domain.max,
            periodic: scene.domain.periodic,
            materials: scene
                .materials
                .iter()
                .map(|material| Material {
                    name: material.name.value.clone(),
                    density: *material.density,
                })
                .collect(),
            laws,
            sliding_normal: scene.contact.sliding_normal,
            wall_curvature: scene.contact.wall_curvature,
            startup_increment: scene.contact.startup_increment,
            contact_point_mass: scene.contact.clump_mass == ClumpMass::ContactPoint,
            guard: Guard {
                policy: scene.guard.policy,
                overlap: *scene.guard.overlap,
                way: *scene.guard.way,
            },
            sleeping,
            liquid,
            sprays,
            walls,
            wear,
            surfaces: sheets.surfaces,
            membranes: sheets.membranes,
            particles: start.particles,
            clumps,
            bodies: start.bodies,
            carried: carried.map(Arc::new),
            insertions,
            deletions,
            smallest_radius: sizes.smallest,
            mean_radius: sizes.mean,
            largest_radius: sizes.largest,
            orientations: scene.output.data
                || *scene.output.vtk
                || !track.is_empty()
                || !track_insertions.is_empty(),
            energy_budget: scene.output.energy_budget,
        },
        outputs: Outputs {
            title: scene.title.clone(),
            prefix: stem(&scene.path),
            files: OutputPlan {
                interval: *scene.output.interval,
                fstat_interval: *scene.output.fstat_interval,
                vtk_interval: *scene.output.vtk_interval,
                restart_interval: scene.output.restart_interval.as_deref().copied(),
                data: scene.output.data,
                ene: scene.output.ene,
                fstat: scene.output.fstat,
                vtk: *scene.output.vtk,
                frames: scene.output.frames,
                walls: scene.output.walls,
                triangle_loads,
                liquid: scene.output.liquid,
                droplets: scene.output.droplets,
                pictures: scene.output.pictures,
                pebbles: scene.output.clumps_as == ClumpsAs::Pebbles,
                track,
                track_insertions,
                track_every: scene
                    .output
                    .track_every
                    .as_deref()
                    .map_or(1, |every| *every),
                track_interval: *scene.output.track_interval,
                fields,
                digits: scene.output.digits.as_ref().map(|digits| **digits as u8),
            },
            regions,
            fluxes,
        },
        notes: Notes {
            counted,
            pairs,
            step: step_plan,
            warnings,
            remarks: notes,
            started_from,
        },
    };
    let closing = closing::closing_walls(&plan);
    for (insertion, walls) in plan.physics.insertions.iter_mut().zip(closing) {
        insertion.closing = walls;
    }
    let doubts: Vec<Doubt> = doubts(&plan).collect();
    for doubt in doubts {
        match doubt {
            Doubt::Warning(text) => plan.notes.warnings.push(text),
            Doubt::Remark(text) => plan.notes.remarks.push(text),
        }
    }
    Ok(plan)
}

/// Warns of keys of `[output]` that change nothing.
fn ignored_keys(scene: &Scene, warnings: &mut Vec<String>) {
    let output = &scene.output;
    for (interval, is_written, what) in [
        (&output.fstat_interval, output.fstat, "fstat"),
        (&output.vtk_interval, *output.vtk, "vtk"),
    ] {
        let key = format!("output.{what}_interval");
        // A default keeps the place of `interval`.
        if interval.place.key() == key && !is_written {
            warnings.push(format!(
                "{key}: nothing is written at these times, as output.{what} is false; set {what} = true or leave the key out"
            ));
        }
    }
    let every = output.track_every.as_ref().map(|every| &every.place);
    for place in [Some(&output.track_interval.place), every]
        .into_iter()
        .flatten()
    {
        let key = place.key();
        if key.starts_with("output.track_") && output.track.is_empty() {
            warnings.push(format!(
                "{key}: nothing is followed, as output.track is empty; name particles or insertions in it, or leave the key out"
            ));
        }
    }
}

fn densities(scene: &Scene) -> Vec<f64> {
    scene
        .materials
        .iter()
        .map(|material| *material.density)
        .collect()
}

/// Resolves every pair of materials that can meet in the scene.
fn plan_pairs(scene: &Scene, uses: &[MaterialUse], errors: &mut Vec<SceneError>) -> Vec<PairPlan> {
    let mut pairs = Vec::new();
    for a in 0..uses.len() {
        for b in a..uses.len() {
            let between_particles = particles_meet(uses, a, b);
            let at_walls = walls_meet(uses, a, b);
            if !between_particles && !at_walls {
                continue;
            }
            if let Some((law, parameters)) = resolve_pair(scene, [a, b], errors) {
                pairs.push(PairPlan {
                    materials: [MaterialIndex::new(a as u32), MaterialIndex::new(b as u32)],
                    names: [a, b].map(|index| scene.materials[index].name.value.clone()),
                    between_particles,
                    at_walls,
                    law,
                    parameters,
                });
            }
        }
    }
    pairs
}

/// The reference speed (m/s) of the time step and where it comes from.
fn reference_speed(
    scene: &Scene,
    start: &StartingParticles,
    clumps: &[Clump],
    insertions: &[InsertionPlan],
    walls: &[Wall],
) -> (f64, String) {
    if let Some(speed) = &scene.time.v_ref {
        return (**speed, "time.v_ref".to_owned());
    }
    let initial = start
        .particles
        .iter()
        .map(|p| p.velocity.length())
        .chain(start.bodies.iter().map(|body| {
            // Its fastest point.
            let reach = clumps[body.clump as usize].radius * body.scale;
            body.velocity.length() + body.angular_velocity.length() * reach
        }))
        .fold(0.0, f64::max);
    let inserted = insertions
        .iter()
        .map(|plan| (plan.velocity_mean.abs() + plan.velocity_spread.abs()).length())
        .fold(0.0, f64::max);
    let (min, max) = (*scene.domain.min, *scene.domain.max);
    let reach = 0.5 * (max - min).length();
    let moving = walls
        .iter()
        .map(|wall| {
            wall.motion
                .max_speed(0.5 * (min + max), reach, *scene.time.end)
        })
        .fold(0.0, f64::max);
    // g h of a fall through the domain; along periodic axes it has no end and counts nothing.
    let fall: f64 = (0..3)
        .filter(|&axis| !scene.domain.periodic[axis])
        .map(|axis| scene.gravity[axis].abs() * (max[axis] - min[axis]))
        .sum();
    let launched = f64::max(initial, inserted);
    let has_free = !insertions.is_empty()
        || start.particles.iter().any(|particle| !particle.fixed)
        || start.bodies.iter().any(|body| !body.fixed);
    let fallen = if has_free && *scene.gravity != DVec3::ZERO {
        (launched * launched + 2.0 * fall).sqrt()
    } else {
        0.0
    };
    let (speed, reason) = [
        (initial, "the fastest initial velocity"),
        (inserted, "the fastest inserted particle"),
        (moving, "the fastest wall"),
        (fallen, "a fall through the domain"),
    ]
    .into_iter()
    .fold((LEAST_SPEED, "the least that is assumed"), |best, next| {
        if next.0 > best.0 { next } else { best }
    });
    (speed, reason.to_owned())
}

/// The time step (s) and its reasons.
#[allow(
    clippy::too_many_arguments,
    reason = "one call, of everything that the step depends on"
)]
fn plan_step(
    scene: &Scene,
    pairs: &[PairPlan],
    uses: &[MaterialUse],
    start: &StartingParticles,
    clumps: &[Clump],
    insertions: &[InsertionPlan],
    walls: &[Wall],
    sheet: Option<Limit>,
    dimensions: u8,
    errors: &mut Vec<SceneError>,
    warnings: &mut Vec<String>,
) -> Option<(f64, StepPlan)> {
    let (speed, speed_reason) = reference_speed(scene, start, clumps, insertions, walls);
    let Limits {
        contact,
        critical,
        unbounded,
    } = limits(pairs, uses, clumps, &densities(scene), dimensions, speed);
    let place = &scene.time.step.place;
    let would_be = match scene.time.step.value {
        TimeStep::Auto => None,
        TimeStep::Seconds(_) => contact.as_ref().zip(critical.as_ref()),
    };
    let would_be = would_be.map(|(contact, critical)| bearable_step(contact, critical));
    // What the sheets allow, in the form of a contact that allows the same.
    let by_sheet = sheet
        .as_ref()
        .map(|limit| limit.time / membranes::STEPS_PER_CRITICAL);
    let would_be = match (scene.time.step.value, by_sheet) {
        (TimeStep::Seconds(_), Some(time)) => Some(would_be.map_or(time, |other| other.min(time))),
        _ => would_be,
    };
    let (step, reason) = match (
        scene.time.step.value,
        contact.as_ref().zip(critical.as_ref()),
    ) {
        (TimeStep::Seconds(step), _) => (step, "as given".to_owned()),
        (TimeStep::Auto, contacts)
            if by_sheet.is_some_and(|time| {
                contacts.is_none_or(|(contact, critical)| time < bearable_step(contact, critical))
            }) =>
        {
            let limit = sheet.clone().unwrap_or_default();
            let interval = *scene.output.interval;
            let (step, reason, warning) = automatic_part(
                &limit,
                membranes::STEPS_PER_CRITICAL,
                "critical step",
                interval,
            );
            warnings.extend(warning);
            (step, reason)
        }
        (TimeStep::Auto, Some((contact, critical))) => {
            let (step, reason, warning) = automatic(contact, critical, *scene.output.interval);
            warnings.extend(warning);
            (step, reason)
        }
        (TimeStep::Auto, None) => {
            let message = "\"auto\" needs a contact to follow: nothing in this scene can touch";
            errors.push(place.error(message).with_help("give the step in seconds"));
            return None;
        }
    };
    let end = *scene.time.end;
    if step > end && scene.time.step.value != TimeStep::Auto {
        let message = format!("is longer than the run: time.end = {end} s");
        errors.push(place.error(message));
        return None;
    }
    if steps(end, step) > MOST_STEPS {
        let message = format!("{} steps cannot be counted", short(steps(end, step)));
        errors.push(place.error(message).with_help("lengthen the step"));
        return None;
    }
    if let Some(critical) = &unbounded
        && step > REFUSED_PART * critical.time
    {
        let message = format!(
            "{} s is above 0.9 of the critical step, {} s ({})",
            short(step),
            short(critical.time),
            critical.of
        );
        errors.push(place.error(message).with_help(
            "the integration would be unstable: shorten the step (or use \"auto\"), or soften the contact",
        ));
        return None;
    }
    if let Some(limit) = &sheet
        && step > REFUSED_PART * limit.time
    {
        let message = format!(
            "{} s is above 0.9 of the critical step of {}, {} s",
            short(step),
            limit.of,
            short(limit.time)
        );
        errors.push(place.error(message).with_help(
            "the integration would be unstable: shorten the step (or use \"auto\"), soften the sheet, or coarsen its mesh",
        ));
        return None;
    }
    if let Some(critical) = &critical
        && step > REFUSED_PART * critical.time
    {
        warnings.push(format!(
            "time.step = {} s is above 0.9 of the critical step, {} s ({}): in collisions as fast as {} m/s friction will rattle",
            short(step),
            short(critical.time),
            critical.of,
            short(speed)
        ));
    }
    if let Some(contact) = &contact
        && step > WARNED_PART * contact.time
    {
        warnings.push(format!(
            "time.step = {} s is {} of the shortest contact, {} s ({}): collisions will be inaccurate; 1/50 is usual",
            short(step),
            short(step / contact.time),
            short(contact.time),
            contact.of
        ));
    }
    let step_plan = StepPlan {
        is_automatic: scene.time.step.value == TimeStep::Auto,
        automatic: would_be,
        reason,
        reference_speed: speed,
        reference_speed_reason: speed_reason,
        contact,
        critical,
        rayleigh: rayleigh(scene, uses),
    };
    Some((step, step_plan))
}

/// Smallest Rayleigh time (s) of the free particles with E and nu.
fn rayleigh(scene: &Scene, uses: &[MaterialUse]) -> Option<f64> {
    scene
        .materials
        .iter()
        .zip(uses)
        .filter(|(_, used)| used.free > 0)
        .filter_map(|(material, used)| {
            let (e, nu) = elastic_constants(material)?;
            Some(rayleigh_time(used.smallest_free, *material.density, e, nu))
        })
        .reduce(f64::min)
}
