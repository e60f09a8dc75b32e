//! The plan as `plan.toml`: the content of the report for programs.

use std::collections::BTreeMap;

use glam::DVec3;
use mercury_common::scene::Total;
use mercury_common::surfaces::Surface;
use serde::Serialize;

use super::passes::passes;
use super::{Disk, Limit, Memory, PairPlan, Plan, Value, expected};
use mercury_engine::boundaries::expected_number;
use mercury_engine::walls::{Shape as WallShape, Wall as PlannedWall};

/// The plan as a TOML document, with the memory that its run is expected to take.
///
/// # Errors
/// If the document cannot be written as TOML, which no plan of a scene causes.
pub fn document(plan: &Plan, memory: &Memory) -> Result<String, toml::ser::Error> {
    toml::to_string(&Document::of(plan, memory))
}

/// The document as JSON, in which whole numbers have no end.
///
/// # Errors
/// If the document cannot be written as JSON, which no plan of a scene causes.
pub fn document_as_json(
    plan: &Plan,
    memory: &Memory,
) -> Result<serde_json::Value, serde_json::Error> {
    let mut document = serde_json::to_value(Document::of(plan, memory))?;
    document["seed"] = plan.physics().seed.into();
    Ok(document)
}

#[derive(Serialize)]
struct Document<'a> {
    /// Version of this program.
    version: &'static str,
    title: &'a str,
    prefix: &'a str,
    /// Seed as text: TOML's integers end at 2^63.
    seed: String,
    gravity: [f64; 3],
    warnings: &'a [String],
    notes: &'a [String],
    memory_bytes: f64,
    memory: MemoryBytes,
    disk: DiskBytes,
    domain: Domain,
    time: Time<'a>,
    particles: Particles,
    materials: Vec<Material<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    clumps: Vec<Clump<'a>>,
    walls: Vec<Wall<'a>>,
    insertions: Vec<Insertion<'a>>,
    contacts: Vec<Contact<'a>>,
    passes: Vec<Pass>,
}

/// Bytes; see [`Memory`].
#[derive(Serialize)]
struct MemoryBytes {
    time_loop: f64,
    at_most: f64,
    at_start: f64,
    checkpoint: f64,
}

/// See [`Disk`].
#[derive(Serialize)]
struct DiskBytes {
    frames: f64,
    contact_frames: f64,
    vtk_frames: f64,
    bytes: f64,
}

#[derive(Serialize)]
struct Domain {
    min: [f64; 3],
    max: [f64; 3],
    periodic: Vec<&'static str>,
    dimensions: u8,
}

#[derive(Serialize)]
struct Time<'a> {
    step: f64,
    steps: u64,
    automatic: bool,
    reason: &'a str,
    reference_speed: f64,
    reference_speed_reason: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    rayleigh_time: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    shortest_contact: Option<Bound<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    critical_step: Option<Bound<'a>>,
}

#[derive(Serialize)]
struct Bound<'a> {
    time: f64,
    of: &'a str,
    /// The step over `time`.
    ratio: f64,
}

#[derive(Serialize)]
struct Particles {
    at_start: usize,
    #[serde(skip_serializing_if = "is_zero")]
    bodies_at_start: usize,
    #[serde(skip_serializing_if = "is_zero")]
    pebbles_at_start: usize,
    fixed: usize,
    expected: f64,
    smallest_radius: f64,
    mean_radius: f64,
    largest_radius: f64,
}

#[derive(Serialize)]
struct Material<'a> {
    name: &'a str,
    density: f64,
}

#[derive(Serialize)]
struct Clump<'a> {
    name: &'a str,
    material: &'a str,
    pebbles: usize,
    mass: f64,
    volume: f64,
    principal_moments: [f64; 3],
    equal_volume_diameter: f64,
    circumscribed_radius: f64,
}

#[derive(Serialize)]
struct Wall<'a> {
    name: &'a str,
    material: &'a str,
    moves: bool,
    from: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    until: Option<f64>,
    shape: SurfaceDocument,
    pose: Pose,
    /// File of a mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<File>,
}

/// The file of a mesh, and how the scene places it: scaled, then turned about the origin of the file, then moved.
#[derive(Serialize)]
struct File {
    path: String,
    scale: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    rotate: Option<Turn>,
    offset: [f64; 3],
}

#[derive(Serialize)]
struct Turn {
    axis: [f64; 3],
    degrees: f64,
}

/// A surface in the frame in which the scene describes it, in the words of `.walls.arrow`.
#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum SurfaceDocument {
    Plane {
        point: [f64; 3],
        normal: [f64; 3],
    },
    Sphere {
        centre: [f64; 3],
        radius: f64,
    },
    Turned {
        origin: [f64; 3],
        direction: [f64; 3],
        across: [f64; 3],
        beside: [f64; 3],
        endless: bool,
        profile: Vec<[f64; 2]>,
    },
    Mesh {
        triangles: usize,
        min: [f64; 3],
        max: [f64; 3],
    },
}

/// Where that frame stands at the start.
#[derive(Serialize)]
struct Pose {
    x: [f64; 3],
    /// w first.
    q: [f64; 4],
}

#[derive(Serialize)]
struct Insertion<'a> {
    name: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    expected_number: Option<f64>,
    from: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    until: Option<f64>,
    /// `quota`; random else.
    #[serde(skip_serializing_if = "Option::is_none")]
    method: Option<&'static str>,
    /// Total as in the scene: `number`, `mass` or `volume`.
    #[serde(skip_serializing_if = "Option::is_none")]
    total: Option<BTreeMap<&'static str, f64>>,
    mixture: Vec<Ingredient<'a>>,
}

#[derive(Serialize)]
struct Ingredient<'a> {
    material: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    clump: Option<&'a str>,
    number_share: f64,
    smallest_diameter: f64,
    largest_diameter: f64,
    /// The sizes as a scene states them, tables written out: what `mercury-psd check` tests the run against.
    psd: toml::Table,
}

#[derive(Serialize)]
struct Contact<'a> {
    between: [&'a str; 2],
    particles: bool,
    walls: bool,
    parameters: BTreeMap<&'a str, Parameter>,
}

#[derive(Serialize)]
struct Parameter {
    value: toml::Value,
    #[serde(skip_serializing_if = "str::is_empty")]
    unit: &'static str,
    from: String,
}

#[derive(Serialize)]
struct Pass {
    name: &'static str,
    done: bool,
    reason: String,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde needs a reference")]
fn is_zero(count: &usize) -> bool {
    *count == 0
}

impl<'a> Document<'a> {
    fn of(plan: &'a Plan, memory: &Memory) -> Self {
        let disk = Disk::of(plan);
        let finite = |number: f64| number.is_finite().then_some(number);
        let material = |index: u32| plan.physics().materials[index as usize].name.as_str();
        let densities: Vec<f64> = plan.physics().materials.iter().map(|m| m.density).collect();
        let expected = expected(plan);
        let bound = |limit: &'a Option<Limit>| {
            limit.as_ref().map(|limit| Bound {
                time: limit.time,
                of: &limit.of,
                ratio: plan.physics().time_step / limit.time,
            })
        };
        Self {
            version: env!("CARGO_PKG_VERSION"),
            title: plan.outputs().title(),
            prefix: plan.outputs().prefix(),
            seed: plan.physics().seed.to_string(),
            gravity: plan.physics().gravity.to_array(),
            warnings: plan.notes().warnings(),
            notes: plan.notes().remarks(),
            memory_bytes: memory.peak().round(),
            memory: MemoryBytes {
                time_loop: memory.steps.round(),
                at_most: memory.most.round(),
                at_start: memory.start.round(),
                checkpoint: memory.checkpoint.round(),
            },
            disk: DiskBytes {
                frames: disk.frames,
                contact_frames: disk.contact_frames,
                vtk_frames: disk.vtk_frames,
                bytes: disk.bytes.round(),
            },
            domain: Domain {
                min: plan.physics().cell.low().to_array(),
                max: plan.physics().cell.high().to_array(),
                periodic: (0..3)
                    .filter(|&axis| plan.physics().cell.is_periodic(axis))
                    .map(|axis| ["x", "y", "z"][axis])
                    .collect(),
                dimensions: plan.physics().dimensions,
            },
            time: Time {
                step: plan.physics().time_step,
                steps: plan.physics().steps,
                automatic: plan.notes().step().is_automatic,
                reason: &plan.notes().step().reason,
                reference_speed: plan.notes().step().reference_speed,
                reference_speed_reason: &plan.notes().step().reference_speed_reason,
                rayleigh_time: plan.notes().step().rayleigh,
                shortest_contact: bound(&plan.notes().step().contact),
                critical_step: bound(&plan.notes().step().critical),
            },
            particles: Particles {
                at_start: plan.physics().particles.len(),
                bodies_at_start: plan.physics().bodies.len(),
                pebbles_at_start: (plan.physics().bodies.iter())
                    .map(|body| body.clump(&plan.physics().clumps).pebbles.len())
                    .sum(),
                fixed: plan.physics().particles.iter().filter(|p| p.fixed).count(),
                expected: expected.particles + expected.bodies,
                smallest_radius: plan.physics().smallest_radius(),
                mean_radius: plan.physics().mean_radius(),
                largest_radius: plan.physics().largest_radius(),
            },
            materials: plan
                .physics()
                .materials
                .iter()
                .map(|m| Material {
                    name: &m.name,
                    density: m.density,
                })
                .collect(),
            clumps: plan
                .physics()
                .clumps
                .iter()
                .map(|clump| Clump {
                    name: &clump.name,
                    material: material(clump.material.number()),
                    pebbles: clump.pebbles.len(),
                    mass: clump.mass,
                    volume: clump.volume,
                    principal_moments: clump.moments.to_array(),
                    equal_volume_diameter: clump.equal_volume_diameter(),
                    circumscribed_radius: clump.radius,
                })
                .collect(),
            walls: plan
                .physics()
                .walls
                .iter()
                .enumerate()
                .map(|(index, wall)| Wall {
                    name: &wall.name,
                    material: material(wall.material.number()),
                    moves: !wall.motion.is_static(),
                    from: wall.from,
                    until: finite(wall.until),
                    shape: shape(&wall.shape),
                    pose: pose(wall, plan.physics().time_step),
                    file: file(plan, index),
                })
                .collect(),
            insertions: plan
                .physics()
                .insertions
                .iter()
                .map(|insertion| Insertion {
                    name: &insertion.name,
                    expected_number: expected_number(
                        insertion,
                        &densities,
                        plan.physics().dimensions,
                    ),
                    from: insertion.from,
                    until: finite(insertion.until),
                    method: insertion.by_quota.then_some("quota"),
                    total: insertion.total.and_then(total),
                    mixture: insertion
                        .mixture
                        .iter()
                        .map(|part| Ingredient {
                            material: material(part.material.number()),
                            clump: part
                                .clump
                                .map(|index| plan.physics().clumps[index as usize].name.as_str()),
                            number_share: part.share,
                            smallest_diameter: part.sizes.smallest(),
                            largest_diameter: part.sizes.largest(),
                            psd: part.sizes.statement(),
                        })
                        .collect(),
                })
                .collect(),
            contacts: plan.notes().pairs().iter().map(contact).collect(),
            passes: passes(plan)
                .into_iter()
                .map(|pass| Pass {
                    name: pass.name,
                    done: pass.is_done,
                    reason: pass.reason,
                })
                .collect(),
        }
    }
}

fn shape(shape: &WallShape) -> SurfaceDocument {
    match shape.outline() {
        Surface::Plane { point, normal } => SurfaceDocument::Plane {
            point: point.to_array(),
            normal: normal.to_array(),
        },
        Surface::Sphere { centre, radius } => SurfaceDocument::Sphere {
            centre: centre.to_array(),
            radius,
        },
        Surface::Turned {
            origin,
            direction,
            across: [across, beside],
            profile,
            endless,
        } => SurfaceDocument::Turned {
            origin: origin.to_array(),
            direction: direction.to_array(),
            across: across.to_array(),
            beside: beside.to_array(),
            endless,
            profile: profile.iter().map(|corner| corner.to_array()).collect(),
        },
        Surface::Mesh(triangles) => {
            let (min, max) = shape.bounds();
            SurfaceDocument::Mesh {
                triangles: triangles.triangles.len(),
                min: min.to_array(),
                max: max.to_array(),
            }
        }
    }
}

fn file(plan: &Plan, wall: usize) -> Option<File> {
    let mut files = plan.outputs().mesh_files().iter();
    let found = files.find(|file| file.wall == wall)?;
    let turn = |(axis, degrees): (DVec3, f64)| Turn {
        axis: axis.to_array(),
        degrees,
    };
    Some(File {
        path: found.path.display().to_string(),
        scale: found.scale,
        rotate: found.rotate.map(turn),
        offset: found.offset.to_array(),
    })
}

fn pose(wall: &PlannedWall, time_step: f64) -> Pose {
    let pose = wall.state(0.0, time_step).pose;
    let q = pose.rotation;
    Pose {
        x: pose.translation.to_array(),
        q: [q.w, q.x, q.y, q.z],
    }
}

fn total(total: Total) -> Option<BTreeMap<&'static str, f64>> {
    let (key, value) = match total {
        Total::Number(number) => ("number", number as f64),
        Total::Mass(mass) => ("mass", mass),
        Total::Volume(volume) => ("volume", volume),
        Total::Full => return None,
    };
    Some(BTreeMap::from([(key, value)]))
}

fn contact(pair: &PairPlan) -> Contact<'_> {
    let parameters = pair.parameters.iter().map(|parameter| {
        let value = match parameter.value {
            Value::Number(number) => toml::Value::Float(number),
            Value::Word(word) => toml::Value::String(word.to_owned()),
        };
        let parameter_of_pair = Parameter {
            value,
            unit: parameter.unit,
            from: parameter.origin.to_string(),
        };
        (parameter.name.as_str(), parameter_of_pair)
    });
    Contact {
        between: [&pair.names[0], &pair.names[1]],
        particles: pair.between_particles,
        walls: pair.at_walls,
        parameters: parameters.collect(),
    }
}
