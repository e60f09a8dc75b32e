//! The plan as `plan.toml`: the content of the report for programs.

use std::collections::BTreeMap;

use mercury_common::scene::Total;
use mercury_common::surfaces::Surface;
use toml::ser::Error;
use toml::{Table, Value as Toml};

use super::passes::passes;
use super::{Disk, Limit, Memory, PairPlan, Plan, Value, expected};
use mercury_engine::boundaries::{InsertionPlan, expected_number};
use mercury_engine::walls::{Shape, Wall};

/// A table of keys and values; those after `?` are options, and left out where they are none.
macro_rules! table {
    ($($key:ident $mark:tt $value:expr),* $(,)?) => {{
        let mut table = Table::new();
        $(if let Some(value) = table!($mark $value) {
            table.insert(stringify!($key).to_owned(), Toml::try_from(value)?);
        })*
        table
    }};
    (: $value:expr) => { Some($value) };
    (? $value:expr) => { $value };
}

/// The plan as a TOML document, with the memory that its run is expected to take.
///
/// # Errors
/// If the document cannot be written as TOML, which no plan of a scene causes.
pub fn document(plan: &Plan, memory: &Memory) -> Result<String, Error> {
    toml::to_string(&tables(plan, memory)?)
}

/// The document as JSON, in which whole numbers have no end.
///
/// # Errors
/// If the document cannot be written as TOML, which no plan of a scene causes.
pub fn document_as_json(plan: &Plan, memory: &Memory) -> Result<serde_json::Value, Error> {
    let tables = tables(plan, memory)?;
    let mut document =
        serde_json::to_value(tables).map_err(<Error as serde::ser::Error>::custom)?;
    document["seed"] = plan.physics().seed.into();
    Ok(document)
}

fn tables(plan: &Plan, memory: &Memory) -> Result<Table, Error> {
    let (physics, step, disk) = (plan.physics(), plan.notes().step(), Disk::of(plan));
    let material = |index: u32| physics.materials[index as usize].name.as_str();
    let expected = expected(plan);
    let counted = |count: usize| (count > 0).then_some(count);
    let pebbles = (physics.bodies.iter()).map(|body| body.clump(&physics.clumps).pebbles.len());
    let bound = |limit: &Option<Limit>| -> Result<Option<Table>, Error> {
        let Some(limit) = limit else { return Ok(None) };
        Ok(Some(table! {
            time: limit.time,
            of: &limit.of,
            // The step over the time.
            ratio: physics.time_step / limit.time,
        }))
    };
    let mut materials = Vec::new();
    for material in &physics.materials {
        materials.push(table! { name: &material.name, density: material.density });
    }
    let mut clumps = Vec::new();
    for clump in &physics.clumps {
        clumps.push(table! {
            name: &clump.name,
            material: material(clump.material.number()),
            pebbles: clump.pebbles.len(),
            mass: clump.mass,
            volume: clump.volume,
            principal_moments: clump.moments.to_array(),
            equal_volume_diameter: clump.equal_volume_diameter(),
            circumscribed_radius: clump.radius,
        });
    }
    let mut walls = Vec::new();
    for (index, wall) in physics.walls.iter().enumerate() {
        walls.push(table! {
            name: &wall.name,
            material: material(wall.material.number()),
            moves: !wall.motion.is_static(),
            from: wall.from,
            until ? finite(wall.until),
            shape: shape(&wall.shape)?,
            pose: pose(wall, physics.time_step)?,
            file ? file(plan, index)?,
        });
    }
    let insertions: Result<Vec<_>, Error> = (physics.insertions.iter())
        .map(|planned| insertion(plan, planned))
        .collect();
    let contacts: Result<Vec<_>, Error> = plan.notes().pairs().iter().map(contact).collect();
    let mut passes_of_plan = Vec::new();
    for pass in passes(plan) {
        passes_of_plan.push(table! { name: pass.name, done: pass.is_done, reason: pass.reason });
    }
    Ok(table! {
        version: env!("CARGO_PKG_VERSION"),
        title: plan.outputs().title(),
        prefix: plan.outputs().prefix(),
        // As text: integers of TOML end at 2^63.
        seed: physics.seed.to_string(),
        gravity: physics.gravity.to_array(),
        warnings: plan.notes().warnings(),
        notes: plan.notes().remarks(),
        memory_bytes: memory.peak().round(),
        memory: table! {
            time_loop: memory.steps.round(),
            at_most: memory.most.round(),
            at_start: memory.start.round(),
            checkpoint: memory.checkpoint.round(),
        },
        disk: table! {
            frames: disk.frames,
            contact_frames: disk.contact_frames,
            vtk_frames: disk.vtk_frames,
            bytes: disk.bytes.round(),
        },
        domain: table! {
            min: physics.cell.low().to_array(),
            max: physics.cell.high().to_array(),
            periodic: (0..3)
                .filter(|&axis| physics.cell.is_periodic(axis))
                .map(|axis| ["x", "y", "z"][axis])
                .collect::<Vec<_>>(),
            dimensions: physics.dimensions,
        },
        time: table! {
            step: physics.time_step,
            steps: physics.steps,
            automatic: step.is_automatic,
            reason: &step.reason,
            reference_speed: step.reference_speed,
            reference_speed_reason: &step.reference_speed_reason,
            rayleigh_time ? step.rayleigh,
            shortest_contact ? bound(&step.contact)?,
            critical_step ? bound(&step.critical)?,
        },
        particles: table! {
            at_start: physics.particles.len(),
            bodies_at_start ? counted(physics.bodies.len()),
            pebbles_at_start ? counted(pebbles.sum()),
            fixed: physics.particles.iter().filter(|p| p.fixed).count(),
            expected: expected.particles + expected.bodies,
            smallest_radius: physics.smallest_radius(),
            mean_radius: physics.mean_radius(),
            largest_radius: physics.largest_radius(),
        },
        materials: materials,
        clumps ? Some(clumps).filter(|clumps| !clumps.is_empty()),
        walls: walls,
        insertions: insertions?,
        contacts: contacts?,
        passes: passes_of_plan,
    })
}

fn finite(number: f64) -> Option<f64> {
    number.is_finite().then_some(number)
}

/// A surface in the frame in which the scene describes it, in the words of `.walls.arrow`.
fn shape(shape: &Shape) -> Result<Table, Error> {
    Ok(match shape.outline() {
        Surface::Plane { point, normal } => table! {
            kind: "plane",
            point: point.to_array(),
            normal: normal.to_array(),
        },
        Surface::Sphere { centre, radius } => table! {
            kind: "sphere",
            centre: centre.to_array(),
            radius: radius,
        },
        Surface::Turned {
            origin,
            direction,
            across: [across, beside],
            profile,
            endless,
        } => table! {
            kind: "turned",
            origin: origin.to_array(),
            direction: direction.to_array(),
            across: across.to_array(),
            beside: beside.to_array(),
            endless: endless,
            profile: profile.iter().map(|corner| corner.to_array()).collect::<Vec<_>>(),
        },
        Surface::Mesh(triangles) => {
            let (min, max) = shape.bounds();
            table! {
                kind: "mesh",
                triangles: triangles.triangles.len(),
                min: min.to_array(),
                max: max.to_array(),
            }
        }
    })
}

/// The file of a mesh, and how the scene places it: scaled, then turned about the origin of the file, then moved.
fn file(plan: &Plan, wall: usize) -> Result<Option<Table>, Error> {
    let mut files = plan.outputs().mesh_files().iter();
    let Some(file) = files.find(|file| file.wall == wall) else {
        return Ok(None);
    };
    let rotate = match file.rotate {
        Some((axis, degrees)) => Some(table! { axis: axis.to_array(), degrees: degrees }),
        None => None,
    };
    Ok(Some(table! {
        path: file.path.display().to_string(),
        scale: file.scale,
        rotate ? rotate,
        offset: file.offset.to_array(),
    }))
}

/// Pose of the frame of a wall at the start; of the quaternion w first.
fn pose(wall: &Wall, time_step: f64) -> Result<Table, Error> {
    let pose = wall.state(0.0, time_step).pose;
    let q = pose.rotation;
    Ok(table! { x: pose.translation.to_array(), q: [q.w, q.x, q.y, q.z] })
}

fn insertion(plan: &Plan, insertion: &InsertionPlan) -> Result<Table, Error> {
    let physics = plan.physics();
    let densities: Vec<f64> = physics.materials.iter().map(|m| m.density).collect();
    let clump = |index: u32| physics.clumps[index as usize].name.as_str();
    let mut mixture = Vec::new();
    for part in &insertion.mixture {
        mixture.push(table! {
            material: &physics.materials[part.material.index()].name,
            clump ? part.clump.map(clump),
            number_share: part.share,
            smallest_diameter: part.sizes.smallest(),
            largest_diameter: part.sizes.largest(),
            // The sizes as a scene states them, tables written out: what `mercury-psd check` tests the run against.
            psd: part.sizes.statement(),
        });
    }
    let total = match insertion.total {
        Some(Total::Number(number)) => Some(table! { number: number as f64 }),
        Some(Total::Mass(mass)) => Some(table! { mass: mass }),
        Some(Total::Volume(volume)) => Some(table! { volume: volume }),
        Some(Total::Full) | None => None,
    };
    Ok(table! {
        name: &insertion.name,
        expected_number ? expected_number(insertion, &densities, physics.dimensions),
        from: insertion.from,
        until ? finite(insertion.until),
        // Random without it.
        method ? insertion.by_quota.then_some("quota"),
        total ? total,
        mixture: mixture,
    })
}

fn contact(pair: &PairPlan) -> Result<Table, Error> {
    let mut parameters = BTreeMap::new();
    for parameter in &pair.parameters {
        let value = match parameter.value {
            Value::Number(number) => Toml::Float(number),
            Value::Word(word) => Toml::String(word.to_owned()),
        };
        let entry = table! {
            value: value,
            unit ? Some(parameter.unit).filter(|unit| !unit.is_empty()),
            from: parameter.origin.to_string(),
        };
        parameters.insert(parameter.name.as_str(), entry);
    }
    Ok(table! {
        between: &pair.names,
        particles: pair.between_particles,
        walls: pair.at_walls,
        parameters: parameters,
    })
}
