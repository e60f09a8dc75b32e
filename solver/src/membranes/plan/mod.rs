//! `[[membranes]]` as the engine's plans.

mod holds;
mod report;
mod shape;

use std::sync::Arc;

use glam::DVec3;
use mercury_common::curve::Curve;
use mercury_common::scene::{
    BendingStiffness, Dimensions, Membrane, MembraneElasticity, MembranePressure, MeshSide, Scene,
    SceneError,
};

pub(crate) use report::describe;

use crate::plan::PairPlan;
use crate::plan::usage::MaterialUse;
use crate::plan::walls::curve;
use holds::{check_twice, check_walls_of_holds, plan_hold};
use mercury_engine::contact::AnyAdhesion;
use mercury_engine::contact::parameter::short;
use mercury_engine::membrane::{
    Bending, Elasticity, HoldCourse, Law, Load, MembranePlan, Sheet, Topology,
};
use mercury_engine::physics::Plans;
use mercury_engine::state::MaterialIndex;
use mercury_engine::surface::{Faces, SurfacePlan};
use mercury_engine::walls::Wall;
use report::doubts;
use shape::{file_of, mesh_place, rest_of, shape};

/// Mass of the lightest vertex of the sheets of a material, kg; infinite if these are held all over.
pub(crate) fn lightest_vertex(plans: &Plans, material: usize) -> Option<f64> {
    let all = plans.all::<MembranePlan>().iter();
    let of_material = all.filter(|membrane| membrane.surface.material.index() == material);
    let masses = of_material.map(|membrane| {
        let masses = membrane.sheet.masses().iter().copied();
        if membrane.is_all_held() {
            f64::INFINITY
        } else {
            masses.fold(f64::INFINITY, f64::min)
        }
    });
    masses.reduce(f64::min)
}

/// Warnings of liquid bridges and of adhesion, which have no energy where contacts with a sheet join.
pub(crate) fn without_energy(
    plans: &Plans,
    pairs: &[PairPlan],
    uses: &[MaterialUse],
) -> Vec<String> {
    let mut warnings = Vec::new();
    for MembranePlan { surface, .. } in plans.all() {
        let own = pairs.iter().filter(|pair| {
            let [one, other] = pair.materials;
            let meets = |sheet, grain: MaterialIndex| {
                sheet == surface.material && uses[grain.index()].free > 0
            };
            meets(one, other) || meets(other, one)
        });
        for pair in own {
            let what = match &pair.law.adhesion {
                AnyAdhesion::None => None,
                AnyAdhesion::Liquid(_) => pair.law.adhesion.liquid().map(|_| "liquid bridges"),
                AnyAdhesion::Dry(_) => pair.law.adhesion.dry().map(|_| "adhesion"),
            };
            if let Some(what) = what {
                warnings.push(format!(
                    "membranes.{}: contacts of {} and {} have {what}; where the sheet bends around a grain, those beside the nearest one count by a part, and the energy budget closes to about 1 % only; momenta are kept",
                    surface.name, pair.names[0], pair.names[1]
                ));
            }
        }
    }
    warnings
}

/// Adds the plans of all sheets, in the order of the file.
pub(crate) fn membranes(
    scene: &Scene,
    walls: &[Wall],
    plans: &mut Plans,
    warnings: &mut Vec<String>,
    notes: &mut Vec<String>,
    errors: &mut Vec<SceneError>,
) {
    let Some(first) = scene.membranes.first() else {
        return;
    };
    if scene.domain.dimensions == Dimensions::Two {
        let message = "membranes need three dimensions";
        errors.push(first.name.place.error(message));
        return;
    }
    if let Some(spray) = scene.sprays.first() {
        let message = "droplets do not see membranes in this version";
        let error = spray.place.error(message);
        errors.push(error.with_help("leave out either [[sprays]] or [[membranes]]"));
    }
    let is_wet = scene
        .materials
        .iter()
        .any(|material| material.liquid.is_some());
    let is_sticky = scene
        .materials
        .iter()
        .any(|material| material.adhesion.is_some());
    for (is_there, what, key) in [
        (is_wet, "liquid bridges", "liquid"),
        (is_sticky, "adhesion", "adhesion"),
    ] {
        if let Some(membrane) = (scene.membranes.iter()).find(|one| is_there && one.walls) {
            let message = format!(
                "vertices of a membrane have no {what} to walls, so they do not touch walls in a scene with {key}"
            );
            let error = membrane.name.place.error(message);
            let help = format!("leave out `walls`, or `{key}` at the materials");
            errors.push(error.with_help(help));
        }
    }
    for membrane in &scene.membranes {
        if let Some(planned) = plan_one(scene, membrane, walls, warnings, errors) {
            let is_held_by = |wall: usize| {
                let mut holds = planned.holds.iter();
                holds.any(|hold| hold.ramp == HoldCourse::Wall(wall))
            };
            if !membrane.walls && !(0..walls.len()).all(is_held_by) {
                notes.push(format!(
                    "membranes.{}: it does not touch walls; with `walls = true` its vertices do",
                    planned.surface.name
                ));
            }
            plans.insert(planned);
        }
    }
    let others = if scene.membranes.len() > 1 {
        "they touch neither each other nor themselves"
    } else {
        "it does not touch itself"
    };
    notes.push(format!("membranes: {others} in this version"));
}

fn plan_one(
    scene: &Scene,
    membrane: &Membrane,
    walls: &[Wall],
    warnings: &mut Vec<String>,
    errors: &mut Vec<SceneError>,
) -> Option<MembranePlan> {
    let name = &membrane.name.value;
    let found = errors.len();
    let mut failed = |error: SceneError| errors.push(error);
    let mesh = match shape(&membrane.shape, warnings) {
        Ok(mesh) => mesh,
        Err(error) => {
            failed(error);
            return None;
        }
    };
    let place = mesh_place(&membrane.shape);
    let topology = Topology::new(mesh.vertices.len(), &mesh.triangles);
    let corners: Vec<[DVec3; 3]> = (0..mesh.triangles.len()).map(|k| mesh.corners(k)).collect();
    let topology = topology.and_then(|topology| {
        Topology::check_areas(&corners)?;
        Ok(topology)
    });
    let topology = match topology {
        Ok(topology) => topology,
        Err(error) => {
            let error = place.error(format!("{}{error}", file_of(&membrane.shape)));
            failed(error.with_help("triangles and vertices count from 0, in the order of the file; a sheet has two triangles at most at an edge, all turned alike"));
            return None;
        }
    };
    let rest = match rest_of(membrane, corners, warnings) {
        Ok(rest) => rest,
        Err(error) => {
            failed(error);
            return None;
        }
    };
    let law = law(scene, membrane);
    let sheet = match Sheet::new(topology, &rest, *membrane.prestrain, law) {
        Ok(sheet) => sheet,
        Err(error) => {
            let place = membrane.rest.as_ref().map_or(place, |rest| &rest.place);
            failed(place.error(format!("at rest {error}")));
            return None;
        }
    };
    let is_on_rim = sheet.topology().is_on_rim();
    let mut holds = Vec::new();
    for hold in &membrane.holds {
        let planned = plan_hold(hold, &mesh.vertices, &is_on_rim, walls, warnings, errors);
        holds.extend(planned);
    }
    check_twice(membrane, &holds, errors);
    check_walls_of_holds(name, &holds, walls, warnings);
    let first_volume = sheet.enclosed(&mesh.vertices).volume;
    let load = match load(&membrane.pressure) {
        Ok(load) => load,
        Err(error) => {
            errors.push(error);
            return None;
        }
    };
    if load.needs_volume() && first_volume <= 0.0 {
        let message = format!(
            "the sheet encloses {} m^3, and its pressure depends on that volume",
            short(first_volume)
        );
        let error = membrane.place.error(message);
        errors.push(error.with_help(
            "turn the triangles so that their normals point outwards; open rims are closed by fans",
        ));
    }
    for (k, &vertex) in mesh.vertices.iter().enumerate() {
        let (min, max) = (*scene.domain.min, *scene.domain.max);
        let is_out = |axis: usize| {
            let is_closed = !scene.domain.periodic[axis];
            is_closed && (vertex[axis] < min[axis] || vertex[axis] > max[axis])
        };
        if (0..3).any(is_out) {
            let [x, y, z] = vertex.to_array().map(short);
            let message = format!("vertex {k} at [{x}, {y}, {z}] m lies outside of the domain");
            let error = place.error(message);
            errors.push(error.with_help("lengths are in metres: does the file need `scale`? Or widen domain.min and domain.max"));
            break;
        }
    }
    if errors.len() > found {
        return None;
    }
    doubts(scene, membrane, &sheet, &mesh, warnings);
    let surface = SurfacePlan {
        name: name.clone(),
        material: MaterialIndex::new(membrane.material.value.0 as u32),
        thickness: *membrane.thickness,
        faces: match membrane.side {
            MeshSide::Both => Faces::Both,
            MeshSide::Front => Faces::Front,
        },
        touches_walls: membrane.walls,
        triangles: mesh.triangles,
        vertices: mesh.vertices,
        masses: sheet.masses().to_vec(),
    };
    Some(MembranePlan {
        surface: Arc::new(surface),
        sheet: Arc::new(sheet),
        load,
        first_volume,
        holds,
    })
}

fn law(scene: &Scene, membrane: &Membrane) -> Law {
    let mut law = Law {
        thickness: *membrane.thickness,
        youngs_modulus: *membrane.youngs_modulus,
        density: *scene.materials[membrane.material.value.0].density,
        elasticity: match membrane.elasticity {
            MembraneElasticity::Springs => Elasticity::Springs,
            MembraneElasticity::Continuum { poisson_ratio } => {
                Elasticity::Continuum { poisson_ratio }
            }
        },
        damping_ratio: *membrane.damping_ratio,
        drag: *membrane.drag,
        bending: None,
    };
    law.bending = membrane.bending.as_ref().map(|bending| Bending {
        stiffness: match &bending.stiffness {
            BendingStiffness::Plate => law.plate_stiffness(),
            BendingStiffness::Given(stiffness) => **stiffness,
        },
        damping: *bending.damping,
        rests_flat: membrane.rests_flat,
    });
    law
}

fn load(pressure: &MembranePressure) -> Result<Load, SceneError> {
    Ok(match pressure {
        MembranePressure::Given(None) => Load::Given(Curve::default()),
        MembranePressure::Given(Some(load)) => Load::Given(curve(load, "pressure")?),
        MembranePressure::Gas {
            gas,
            ambient,
            exponent,
        } => Load::Gas {
            gas: **gas,
            ambient: **ambient,
            exponent: **exponent,
        },
        MembranePressure::Fluid {
            fluid,
            bulk_modulus,
            ambient,
        } => Load::Fluid {
            fluid: **fluid,
            bulk_modulus: **bulk_modulus,
            ambient: **ambient,
        },
    })
}
