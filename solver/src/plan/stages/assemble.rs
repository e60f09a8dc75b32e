//! The last stage: everything that was resolved, as one plan.

use std::sync::Arc;

use mercury_common::scene::{ClumpMass, ClumpsAs, Scene, SceneErrors, Switches, stem};

use super::laws::Laws;
use super::{Findings, Parts};
use crate::liquid::plan::{liquid, wall_films};
use crate::plan::closing;
use crate::plan::doubtful::{Finding, doubts};
use crate::plan::meshes;
use crate::plan::start_from_run::{Earlier, Here, carried};
use crate::plan::time_step::{StepPlan, steps};
use crate::plan::{Counted, FieldPlan, Material, Notes, OutputPlan, Outputs, Plan, cell_of};
use mercury_engine::guard::Guard;
use mercury_engine::physics::Inputs;

/// Links of the chain in a run, unless the scene says otherwise.
const LINKS: f64 = 100.0;
/// A link costs about as much as a step: so it stays below a hundredth.
const STEPS_OF_LINK: f64 = 200.0;

/// Results of the stages before.
pub(super) struct Resolved {
    pub(super) parts: Parts,
    pub(super) laws: Laws,
    pub(super) counted: Counted,
    /// s
    pub(super) time_step: f64,
    pub(super) step: StepPlan,
}

/// The plan of a scene in which nothing is wrong.
///
/// # Errors
/// If what was resolved is not consistent, which no scene should cause.
pub(super) fn assemble(
    scene: &Scene,
    resolved: Resolved,
    mut found: Findings,
) -> Result<Plan, SceneErrors> {
    let Resolved {
        parts,
        laws,
        counted,
        time_step,
        step: step_plan,
    } = resolved;
    let Parts {
        dimensions,
        walls,
        clumps,
        mut start,
        insertions,
        regions,
        deletions,
        fluxes,
        fields,
        mut plans,
        sizes,
        ..
    } = parts;
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
    let (laws, pairs) = laws.into_table(scene.materials.len());
    let mut wall_films = wall_films(scene, &walls);
    let here = Here {
        particles: start.particles.len(),
        bodies: &start.bodies,
        clumps: &clumps,
        walls: &walls,
        wall_films: &wall_films,
        laws: &laws,
    };
    let (remarks, warnings) = (&mut found.remarks, &mut found.warnings);
    let (carried, released) = carried(&start.earlier, &here, remarks, warnings);
    released.pour(&mut start, &mut wall_films);
    let started_from = start.earlier.iter().map(Earlier::started_from).collect();
    let domain = (*scene.domain.min, *scene.domain.max);
    meshes::remarks(
        scene,
        &walls,
        domain,
        sizes.smallest,
        &mut found.warnings,
        &mut found.remarks,
    );
    let triangle_loads =
        meshes::has_triangle_loads(&walls, &scene.output.switches, &mut found.warnings);
    ignored_keys(scene, &mut found.warnings);
    let mesh_files = meshes::files(scene, &walls);
    let liquid = liquid(
        scene,
        wall_films,
        &laws,
        plans.get(),
        &insertions,
        &start.values,
        time_step,
    );
    if liquid.is_none() {
        let needs = |one: &&FieldPlan| one.analysis.fields.iter().any(|field| field.needs_liquid());
        found
            .warnings
            .extend(fields.iter().filter(needs).map(|one| {
                format!(
                    "fields.{}: liquid_fraction is 0 everywhere, as the scene has no liquid",
                    one.name
                )
            }));
    }
    plans.all_mut().extend(liquid);
    let inputs = Inputs {
        seed: scene.seed,
        gravity: *scene.gravity,
        dimensions,
        time_step,
        steps: steps(*scene.time.end, time_step) as u64,
        until_at_rest: *scene.time.until_at_rest,
        cell: cell_of(&scene.domain),
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
        walls,
        plans,
        particles: start.particles,
        clumps,
        bodies: start.bodies,
        carried: carried.map(Arc::new),
        properties: Vec::new(),
        start_values: start.values,
        insertions,
        deletions,
        orientations: scene.output.switches.data
            || scene.output.switches.vtk
            || !scene.bonds.is_empty()
            || !track.is_empty()
            || !track_insertions.is_empty(),
        energy_budget: scene.output.energy_budget,
    };
    let physics = inputs.physics().map_err(|error| {
        let message = format!("the plan of this scene is not consistent ({error}), which is a fault of this program; please report it");
        SceneErrors(vec![scene.time.end.error(message)])
    })?;
    let closing = closing::closing_walls(&physics);
    let link_interval = (scene.output.link_interval.as_deref().copied())
        .unwrap_or_else(|| (*scene.time.end / LINKS).max(STEPS_OF_LINK * physics.time_step));
    let mut plan = Plan {
        physics: Arc::new(physics.with_closing_walls(closing)),
        outputs: Outputs {
            title: scene.title.clone(),
            prefix: stem(&scene.path),
            files: OutputPlan {
                switches: Switches {
                    triangle_loads,
                    ..scene.output.switches
                },
                interval: *scene.output.interval,
                rows_interval: *scene.output.rows_interval,
                fstat_interval: *scene.output.fstat_interval,
                vtk_interval: *scene.output.vtk_interval,
                restart_interval: scene.output.restart_interval.as_deref().copied(),
                link_interval,
                keep_checkpoints: scene.output.keep_checkpoints,
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
            mesh_files,
        },
        notes: Notes {
            counted,
            pairs,
            step: step_plan,
            warnings: found.warnings,
            remarks: found.remarks,
            started_from,
        },
    };
    note_doubts(&mut plan);
    Ok(plan)
}

/// Adds what is doubtful about a plan to its notes.
fn note_doubts(plan: &mut Plan) {
    let doubts: Vec<Finding> = doubts(plan).collect();
    for doubt in doubts {
        match doubt {
            Finding::Warning(text) => plan.notes.warnings.push(text),
            Finding::Remark(text) => plan.notes.remarks.push(text),
        }
    }
}

/// Warns of keys of `[output]` that change nothing.
fn ignored_keys(scene: &Scene, warnings: &mut Vec<String>) {
    let output = &scene.output;
    for (interval, is_written, what) in [
        (&output.fstat_interval, output.switches.fstat, "fstat"),
        (&output.vtk_interval, output.switches.vtk, "vtk"),
    ] {
        let key = format!("output.{what}_interval");
        // A default keeps the place of `interval`.
        if interval.place.key() == key && !is_written {
            warnings.push(format!(
                "{key}: nothing is written at these times, as output.{what} is false; set {what} = true or leave the key out"
            ));
        }
    }
    let place = &output.rows_interval.place;
    let counts = scene.regions.is_empty() && scene.fluxes.is_empty();
    if place.key() == "output.rows_interval"
        && !(output.switches.ene || output.switches.walls)
        && counts
    {
        warnings.push(
            "output.rows_interval: no table has rows at these times, as output.ene and output.walls are false and the scene has no [[regions]] and [[fluxes]]; set ene = true or leave the key out".to_owned(),
        );
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
