//! `[[membranes]]` as the engine's plans.

use std::sync::Arc;

use glam::DVec3;
use mercury_common::formats::mesh::{TriangleMesh, read_mesh, read_mesh_in_order};
use mercury_common::scene::{
    BendingStiffness, Dimensions, Hold, HoldMotion, Load as SceneLoad, Located, Membrane,
    MembraneElasticity, MembranePressure, MembraneShape, MeshSide, Pick, Scene, SceneError,
    SourceSpan,
};

use super::insertions::region;
use super::meshes::{placement, triangles};
use super::pair::PairPlan;
use super::usage::MaterialUse;
use super::walls::{component_about, ramp};
use mercury_engine::contact::AnyAdhesion;
use mercury_engine::contact::parameter::short;
use mercury_engine::membrane::{
    Bending, Elasticity, HoldCourse, HoldPlan, Law, Load, MembranePlan, Sheet, Topology,
    about_triangles, cylinder, disc, rectangle, sphere,
};
use mercury_engine::state::MaterialIndex;
use mercury_engine::surface::{Faces, SurfacePlan};
use mercury_engine::walls::{Motion, Wall};

/// Most triangles of a sheet that is built in.
const MOST_TRIANGLES: f64 = 4e6;
/// Springs whose triangles scatter by more than this are warned about.
const SCATTER: f64 = 0.05;
/// A sheet that its own weight stretches by more than this is warned about.
const OWN_WEIGHT: f64 = 0.5;
/// The automatic step is this part of the critical step of a sheet.
pub(super) const STEPS_PER_CRITICAL: f64 = 10.0;

/// All sheets, in the order of the file.
#[derive(Debug, Default)]
pub(super) struct Sheets {
    pub surfaces: Vec<SurfacePlan>,
    pub membranes: Vec<MembranePlan>,
}

impl Sheets {
    /// Mass of the lightest vertex of the sheets of a material, kg; infinite if these are held all over.
    pub(super) fn lightest_vertex(&self, material: usize) -> Option<f64> {
        let all = self.surfaces.iter().zip(&self.membranes);
        let of_material = all.filter(|(surface, _)| surface.material.index() == material);
        let masses = of_material.map(|(_, membrane)| {
            let masses = membrane.sheet.masses().iter().copied();
            if membrane.is_all_held() {
                f64::INFINITY
            } else {
                masses.fold(f64::INFINITY, f64::min)
            }
        });
        masses.reduce(f64::min)
    }
}

/// Warnings of liquid bridges and of adhesion, which have no energy where contacts with a sheet join.
pub(super) fn without_energy(
    planned: &Sheets,
    pairs: &[PairPlan],
    uses: &[MaterialUse],
) -> Vec<String> {
    let mut warnings = Vec::new();
    for surface in &planned.surfaces {
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

pub(super) fn membranes(
    scene: &Scene,
    walls: &[Wall],
    warnings: &mut Vec<String>,
    notes: &mut Vec<String>,
    errors: &mut Vec<SceneError>,
) -> Sheets {
    let mut planned = Sheets::default();
    let Some(first) = scene.membranes.first() else {
        return planned;
    };
    if scene.domain.dimensions == Dimensions::Two {
        let message = "membranes need three dimensions";
        errors.push(first.name.place.error(message));
        return planned;
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
        if let Some((surface, mechanics)) = plan_one(scene, membrane, walls, warnings, errors) {
            let is_held_by = |wall: usize| {
                let mut holds = mechanics.holds.iter();
                holds.any(|hold| hold.ramp == HoldCourse::Wall(wall))
            };
            if !membrane.walls && !(0..walls.len()).all(is_held_by) {
                notes.push(format!(
                    "membranes.{}: it does not touch walls; with `walls = true` its vertices do",
                    surface.name
                ));
            }
            planned.surfaces.push(surface);
            planned.membranes.push(mechanics);
        }
    }
    let others = if scene.membranes.len() > 1 {
        "they touch neither each other nor themselves"
    } else {
        "it does not touch itself"
    };
    notes.push(format!("membranes: {others} in this version"));
    planned
}

fn plan_one(
    scene: &Scene,
    membrane: &Membrane,
    walls: &[Wall],
    warnings: &mut Vec<String>,
    errors: &mut Vec<SceneError>,
) -> Option<(SurfacePlan, MembranePlan)> {
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
    let mechanics = MembranePlan {
        sheet: Arc::new(sheet),
        load,
        first_volume,
        holds,
    };
    Some((surface, mechanics))
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

/// Where the mesh is described.
fn mesh_place(shape: &MembraneShape) -> &SourceSpan {
    match shape {
        MembraneShape::File(source) => &source.file.place,
        MembraneShape::Rectangle { edge, .. }
        | MembraneShape::Disc { edge, .. }
        | MembraneShape::Cylinder { edge, .. }
        | MembraneShape::Sphere { edge, .. } => &edge.place,
    }
}

fn file_of(shape: &MembraneShape) -> String {
    match shape {
        MembraneShape::File(source) => format!("{}: ", source.file.value.display()),
        _ => String::new(),
    }
}

fn shape(shape: &MembraneShape, warnings: &mut Vec<String>) -> Result<TriangleMesh, SceneError> {
    use std::f64::consts::{PI, TAU};
    let few = |area: f64, edge: &Located<f64>| {
        let count = about_triangles(area, **edge);
        // Also where it is no number.
        let is_few = count <= MOST_TRIANGLES;
        if is_few {
            return Ok(());
        }
        let error = edge.error(format!(
            "makes about {count:.0} triangles; {MOST_TRIANGLES:.0} are the most"
        ));
        Err(error.with_help("lengths are in metres: make `edge` longer"))
    };
    Ok(match shape {
        MembraneShape::File(source) => {
            let mut mesh = triangles(&source.file, read_mesh_in_order, warnings)?;
            let place = placement(source);
            for vertex in &mut mesh.vertices {
                *vertex = place(*vertex);
            }
            mesh
        }
        MembraneShape::Rectangle {
            corner,
            along,
            across,
            edge,
        } => {
            few(along.length() * across.length(), edge)?;
            rectangle(**corner, **along, **across, **edge)
        }
        MembraneShape::Disc {
            axis,
            origin,
            radius,
            edge,
        } => {
            few(PI * **radius * **radius, edge)?;
            disc(**axis, **origin, **radius, **edge)
        }
        MembraneShape::Cylinder {
            axis,
            origin,
            radius,
            along,
            edge,
        } => {
            few(TAU * **radius * (along[1] - along[0]), edge)?;
            cylinder(**axis, **origin, **radius, **along, **edge)
        }
        MembraneShape::Sphere {
            origin,
            radius,
            edge,
        } => {
            few(2.0 * TAU * **radius * **radius, edge)?;
            sphere(**origin, **radius, **edge)
        }
    })
}

/// Corners of the stress-free triangles.
fn rest_of(
    membrane: &Membrane,
    own: Vec<[DVec3; 3]>,
    warnings: &mut Vec<String>,
) -> Result<Vec<[DVec3; 3]>, SceneError> {
    let Some(file) = &membrane.rest else {
        return Ok(own);
    };
    let mesh = triangles(file, read_mesh, warnings)?;
    if mesh.triangles.len() != own.len() {
        let error = file.error(format!(
            "{} has {} triangles, the sheet {}",
            file.value.display(),
            mesh.triangles.len(),
            own.len()
        ));
        return Err(error
            .with_help("the rest shape must have the triangles of the sheet, in the same order"));
    }
    let corners = |place: &dyn Fn(DVec3) -> DVec3| {
        (0..own.len())
            .map(|k| mesh.corners(k).map(place))
            .collect::<Vec<_>>()
    };
    Ok(match &membrane.shape {
        MembraneShape::File(source) => corners(&placement(source)),
        _ => corners(&|x| x),
    })
}

fn plan_hold(
    hold: &Hold,
    vertices: &[DVec3],
    is_on_rim: &[bool],
    walls: &[Wall],
    warnings: &mut Vec<String>,
    errors: &mut Vec<SceneError>,
) -> Option<HoldPlan> {
    let mut is_picked = vec![false; vertices.len()];
    for Pick { is_rim, region: of } in &hold.picks {
        let of = match of {
            Some(of) => Some(region(of, warnings, errors)?),
            None => None,
        };
        for (k, picked) in is_picked.iter_mut().enumerate() {
            let is_inside = of.as_ref().is_none_or(|of| of.contains(vertices[k]));
            *picked |= is_inside && (!is_rim || is_on_rim[k]);
        }
    }
    let picked = is_picked.iter().zip(0u32..);
    let held: Vec<u32> = picked
        .filter(|(picked, _)| **picked)
        .map(|(_, k)| k)
        .collect();
    if held.is_empty() {
        let error = hold
            .place
            .error(format!("the hold \"{}\" holds no vertex", hold.name.value));
        errors.push(error.with_help("a closed sheet has no rim; vertices are picked by where they are at the start, inside the region"));
        return None;
    }
    let ramp = match &hold.motion {
        HoldMotion::Still => HoldCourse::Velocity([Some(0.0); 3]),
        HoldMotion::Velocity(components) => HoldCourse::Velocity(**components),
        HoldMotion::Wall(wall) => {
            let index = walls.iter().position(|known| known.name == wall.value);
            let Some(index) = index else {
                let names: Vec<&str> = walls.iter().map(|wall| wall.name.as_str()).collect();
                let error = wall.error(format!("there is no wall \"{}\"", wall.value));
                errors.push(error.with_help(if names.is_empty() {
                    "the scene has no walls".to_owned()
                } else {
                    format!("there are: {}", names.join(", "))
                }));
                return None;
            };
            HoldCourse::Wall(index)
        }
        HoldMotion::Motions(motions) => {
            let mean = held.iter().map(|&k| vertices[k as usize]).sum::<DVec3>();
            let mean = mean / held.len() as f64;
            let mut components = Vec::new();
            for motion in motions {
                match component_about(mean, motion) {
                    Ok(component) => components.push(component),
                    Err(error) => {
                        errors.push(error);
                        return None;
                    }
                }
            }
            match Motion::new(components) {
                Ok(motion) => HoldCourse::Motion(Box::new(motion)),
                Err(error) => {
                    errors.push(hold.place.error(error.to_string()));
                    return None;
                }
            }
        }
    };
    Some(HoldPlan {
        name: hold.name.value.clone(),
        vertices: held,
        ramp,
        from: *hold.from,
        until: hold.until.as_deref().copied().unwrap_or(f64::INFINITY),
    })
}

/// A vertex has one hold at a time.
fn check_twice(membrane: &Membrane, holds: &[HoldPlan], errors: &mut Vec<SceneError>) {
    for (number, hold) in holds.iter().enumerate() {
        for other in &holds[..number] {
            if hold.from >= other.until || other.from >= hold.until {
                continue;
            }
            // Both are sorted.
            let twice = (hold.vertices.iter()).find(|k| other.vertices.binary_search(k).is_ok());
            let Some(vertex) = twice else { continue };
            let named = membrane.holds.iter().find(|of| of.name.value == hold.name);
            let place = named.map_or(&membrane.place, |of| &of.place);
            let error = place.error(format!(
                "vertex {vertex} is held by \"{}\" already, at the same time",
                other.name
            ));
            errors.push(error.with_help(
                "a vertex has one hold at a time: narrow one of the regions, or their times (from, until)",
            ));
        }
    }
}

/// Holds that go with a wall end with it, and begin with it.
fn check_walls_of_holds(
    name: &str,
    holds: &[HoldPlan],
    walls: &[Wall],
    warnings: &mut Vec<String>,
) {
    for hold in holds {
        let HoldCourse::Wall(wall) = hold.ramp else {
            continue;
        };
        let wall = &walls[wall];
        if wall.until < hold.until {
            warnings.push(format!(
                "membranes.{name}: the hold `{}` ends at {} s, when its wall `{}` is removed, and its vertices are free then; if this is meant, end the hold itself (`until`)",
                hold.name,
                short(wall.until),
                wall.name
            ));
        }
        if wall.from > hold.from.max(0.0) {
            warnings.push(format!(
                "membranes.{name}: the hold `{}` begins at {} s only, when its wall `{}` comes, and its vertices are free before; if this is meant, begin the hold itself then (`from`)",
                hold.name,
                short(wall.from),
                wall.name
            ));
        }
    }
}

fn load(pressure: &MembranePressure) -> Result<Load, SceneError> {
    Ok(match pressure {
        MembranePressure::Given(None) => Load::Given(Vec::new()),
        MembranePressure::Given(Some(SceneLoad::Constant(number))) if **number == 0.0 => {
            Load::Given(Vec::new())
        }
        MembranePressure::Given(Some(load)) => Load::Given(ramp(load, "pressure")?.rows().to_vec()),
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

/// Warnings of likely mistakes.
fn doubts(
    scene: &Scene,
    membrane: &Membrane,
    sheet: &Sheet,
    mesh: &TriangleMesh,
    warnings: &mut Vec<String>,
) {
    let name = &membrane.name.value;
    if let Some(scatter) = sheet
        .scatter()
        .filter(|scatter| scatter.deviation > SCATTER)
    {
        warnings.push(format!(
            "membranes.{name}: its triangles are far from equilateral, so that springs scatter their tensions by {} % (root of the mean square; {} % at the worst triangle): elasticity = \"continuum\" is exact on any mesh",
            short((1000.0 * scatter.deviation).round() / 10.0),
            short((1000.0 * scatter.worst).round() / 10.0)
        ));
    }
    let law = sheet.law();
    let low = mesh.vertices.iter().copied().reduce(DVec3::min);
    let high = mesh.vertices.iter().copied().reduce(DVec3::max);
    let extent = low
        .zip(high)
        .map_or(0.0, |(low, high)| (high - low).length());
    let stretch = law.density * scene.gravity.length() * extent / law.youngs_modulus;
    if stretch > OWN_WEIGHT {
        warnings.push(format!(
            "membranes.{name}: hung up, it would stretch by {} of its length under its own weight: is youngs_modulus = {} Pa what is meant?",
            short((100.0 * stretch).round() / 100.0),
            short(law.youngs_modulus)
        ));
    }
}

/// How far the springs are from a sheet, for the report.
pub(super) fn describe(surface: &SurfacePlan, membrane: &MembranePlan) -> Vec<String> {
    let sheet = &membrane.sheet;
    let topology = sheet.topology();
    let law = sheet.law();
    let mass: f64 = sheet.masses().iter().sum();
    let mut lines = vec![format!(
        "{} triangles, {} vertices, {} rims; {} m^2, {} kg, {} m thick",
        topology.triangles().len(),
        topology.vertices(),
        topology.rims().len(),
        short(sheet.rest_area()),
        short(mass),
        short(law.thickness)
    )];
    let stretching = match law.elasticity {
        Elasticity::Springs => {
            let far = sheet.scatter().map_or(String::new(), |scatter| {
                format!(
                    ", whose tensions scatter by {} % (root of the mean square), {} % at the worst triangle",
                    short((1000.0 * scatter.deviation).round() / 10.0),
                    short((1000.0 * scatter.worst).round() / 10.0)
                )
            });
            format!("springs{far}")
        }
        Elasticity::Continuum { poisson_ratio } => {
            format!("continuum, Poisson's ratio {}", short(poisson_ratio))
        }
    };
    let bending = law.bending.map_or("limp".to_owned(), |bending| {
        format!("bending stiffness {} N m", short(bending.stiffness))
    });
    lines.push(format!(
        "E t = {} N/m, {stretching}; {bending}",
        short(law.stiffness())
    ));
    for hold in &membrane.holds {
        let how = match &hold.ramp {
            HoldCourse::Velocity([Some(0.0), Some(0.0), Some(0.0)]) => "held".to_owned(),
            HoldCourse::Velocity(components) => {
                let words = components.map(|v| v.map_or("free".to_owned(), short));
                format!("move at [{}] m/s", words.join(", "))
            }
            HoldCourse::Motion(motion) => super::motions::lines(motion).join("; "),
            HoldCourse::Wall(_) => "go with a wall".to_owned(),
        };
        lines.push(format!(
            "hold `{}`, {} vertices: {how}",
            hold.name,
            hold.vertices.len()
        ));
    }
    let pressure = match &membrane.load {
        Load::Given(_) if membrane.load.is_none() => None,
        Load::Given(rows) => match rows[..] {
            [[_, pressure]] => Some(format!("pressure {} Pa", short(pressure))),
            _ => Some(format!("pressure by {} rows", rows.len())),
        },
        Load::Gas { gas, .. } => Some(format!(
            "gas of {} Pa in {} m^3",
            short(*gas),
            short(membrane.first_volume)
        )),
        Load::Fluid { bulk_modulus, .. } => Some(format!(
            "fluid of bulk modulus {} Pa in {} m^3",
            short(*bulk_modulus),
            short(membrane.first_volume)
        )),
    };
    lines.extend(pressure);
    lines.push(format!(
        "critical step {} s",
        short(membrane.rates(&surface.vertices).critical_step())
    ));
    lines
}
