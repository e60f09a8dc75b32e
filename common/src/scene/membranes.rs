//! `[[membranes]]`: elastic sheets.

use std::path::PathBuf;

use glam::DVec3;

use super::MaterialIndex;
use super::cursor::Fields;
use super::item::Item;
use super::motion::{self, Load, Motion, MotionKind};
use super::region::{self, Region};
use super::settings::flag;
use super::shapes::{MeshSide, MeshSource, read_mesh, read_side};
use super::source::{Located, Place};
use super::walls::interval;

/// An elastic sheet: a mesh whose vertices have mass.
#[derive(Debug, Clone, PartialEq)]
pub struct Membrane {
    /// Unique among membranes; default `membrane-1`, ...
    pub name: Located<String>,
    /// Where the entry stands.
    pub place: Place,
    /// Its triangles.
    pub shape: MembraneShape,
    /// The stress-free shape, triangle by triangle; none: the shape itself.
    pub rest: Option<Located<PathBuf>>,
    /// All rest lengths are those of the rest shape over 1 + prestrain; default 0, above -0.5.
    pub prestrain: Located<f64>,
    /// Material of its surface; its density is that of the sheet.
    pub material: Located<MaterialIndex>,
    /// Thickness, m.
    pub thickness: Located<f64>,
    /// Young's modulus, Pa.
    pub youngs_modulus: Located<f64>,
    /// Resistance to stretching; default springs.
    pub elasticity: MembraneElasticity,
    /// Damping along each edge as a fraction of critical; default 0.
    pub damping_ratio: Located<f64>,
    /// Drag on the vertices, 1/s; default 0.
    pub drag: Located<f64>,
    /// Resistance to bending; none: limp.
    pub bending: Option<Bending>,
    /// Whether hinges are free of moment where they are flat; default: as in the rest shape.
    pub rests_flat: bool,
    /// What is held; `fixed` is the first, of that name.
    pub holds: Vec<Hold>,
    /// On the back of the triangles.
    pub pressure: MembranePressure,
    /// Whether vertices touch walls; default false.
    pub walls: bool,
    /// Which sides act; default both.
    pub side: MeshSide,
}

/// Where the triangles of a membrane come from. Lengths in m, directions of length 1.
#[derive(Debug, Clone, PartialEq)]
pub enum MembraneShape {
    /// A file.
    File(MeshSource),
    /// Rows parallel to `along`.
    Rectangle {
        /// A corner.
        corner: Located<DVec3>,
        /// From it along the rows.
        along: Located<DVec3>,
        /// From it across the rows, at right angles to `along`.
        across: Located<DVec3>,
        /// About the length of the edges.
        edge: Located<f64>,
    },
    /// Rings about a centre.
    Disc {
        /// Normal.
        axis: Located<DVec3>,
        /// Centre.
        origin: Located<DVec3>,
        /// Radius.
        radius: Located<f64>,
        /// About the length of the edges.
        edge: Located<f64>,
    },
    /// A tube without ends, normals outwards.
    Cylinder {
        /// Direction of the axis.
        axis: Located<DVec3>,
        /// A point on the axis.
        origin: Located<DVec3>,
        /// Radius.
        radius: Located<f64>,
        /// Extent along the axis, from the origin.
        along: Located<[f64; 2]>,
        /// About the length of the edges.
        edge: Located<f64>,
    },
    /// A subdivided icosahedron, normals outwards.
    Sphere {
        /// Centre.
        origin: Located<DVec3>,
        /// Radius.
        radius: Located<f64>,
        /// About the length of the edges.
        edge: Located<f64>,
    },
}

/// How a membrane resists stretching.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MembraneElasticity {
    /// A spring along each edge; Poisson's ratio is 1/3.
    Springs,
    /// Uniformly strained triangles.
    Continuum {
        /// In (-1, 0.5]; default 1/3.
        poisson_ratio: f64,
    },
}

/// Resistance to bending by the elements of Bridson, Marino and Fedkiw (2003).
#[derive(Debug, Clone, PartialEq)]
pub struct Bending {
    /// How stiff.
    pub stiffness: BendingStiffness,
    /// Damping coefficient, N s; default 0.
    pub damping: Located<f64>,
}

/// The stiffness of the bending elements.
#[derive(Debug, Clone, PartialEq)]
pub enum BendingStiffness {
    /// `plate`: that of a plate of the same thickness and modulus.
    Plate,
    /// As given, N m.
    Given(Located<f64>),
}

/// Vertices that are held.
#[derive(Debug, Clone, PartialEq)]
pub struct Hold {
    /// Unique in the membrane; `fixed` for the key of that name, default `hold-1`, ...
    pub name: Located<String>,
    /// Where the entry stands.
    pub place: Place,
    /// Which vertices: those of any of these.
    pub picks: Vec<Pick>,
    /// How they move.
    pub motion: HoldMotion,
    /// Start, s; default 0.
    pub from: Located<f64>,
    /// End, s; none: never.
    pub until: Option<Located<f64>>,
}

/// A choice of vertices, by where they are at the start.
#[derive(Debug, Clone, PartialEq)]
pub struct Pick {
    /// On boundary edges only.
    pub is_rim: bool,
    /// Inside this only.
    pub region: Option<Box<Located<Region>>>,
}

/// How held vertices move.
#[derive(Debug, Clone, PartialEq)]
pub enum HoldMotion {
    /// Not at all.
    Still,
    /// With a velocity, m/s; components without one are free.
    Velocity(Located<[Option<f64>; 3]>),
    /// As a rigid body.
    Motions(Vec<Motion>),
    /// With a wall.
    Wall(Located<String>),
}

/// What sets the pressure on the back of a membrane.
#[derive(Debug, Clone, PartialEq)]
pub enum MembranePressure {
    /// None, a number, rows or a table, Pa.
    Given(Option<Load>),
    /// gas (V0/V)^exponent - ambient.
    Gas {
        /// Absolute pressure at the start, Pa.
        gas: Located<f64>,
        /// Pressure outside, Pa; default 0.
        ambient: Located<f64>,
        /// Default 1.
        exponent: Located<f64>,
    },
    /// fluid + `bulk_modulus` (V0 - V)/V0 - ambient.
    Fluid {
        /// Absolute pressure at the start, Pa.
        fluid: Located<f64>,
        /// Pa.
        bulk_modulus: Located<f64>,
        /// Pressure outside, Pa; default 0.
        ambient: Located<f64>,
    },
}

/// Reads an entry of `[[membranes]]`.
pub(super) fn read(item: &Item<'_>) -> Option<Membrane> {
    let fields = item.table()?;
    let name = fields.name_or_number();
    let shape = read_shape(&fields);
    let rest = fields.get("rest").map(|item| item.file());
    let prestrain = number_or(&fields, "prestrain", 0.0, |item| {
        let number = item.number()?;
        if *number <= -0.5 {
            item.report(format!("must be > -0.5, got {}", *number));
            return None;
        }
        Some(number)
    });
    let material = fields.need("material").and_then(|item| item.material());
    let positive = |key| fields.need(key).and_then(|item| item.positive());
    let (thickness, youngs_modulus) = (positive("thickness"), positive("youngs_modulus"));
    let elasticity = read_elasticity(&fields);
    let damping_ratio = number_or(&fields, "damping_ratio", 0.0, |item| item.non_negative());
    let drag = number_or(&fields, "drag", 0.0, |item| item.non_negative());
    let bending = fields.get("bending").map(|item| read_bending(&item));
    let rests_flat = fields.get("rest_angles").map(|item| {
        let words = [("shape", false), ("flat", true)];
        item.word("choice of rest angles", &words)
    });
    let fixed = fields.get("fixed").map(|item| read_fixed(&item));
    let holds = fields.get("holds").map(|item| {
        let items = item.list()?;
        fields.context.unique_names(&items);
        let holds = items.iter().map(read_hold).collect::<Vec<_>>();
        holds.into_iter().collect::<Option<Vec<Hold>>>()
    });
    let pressure = fields.get("pressure").map(|item| read_pressure(&item));
    let walls = flag(&fields, "walls", false);
    let side = read_side(&fields);
    fields.finish();
    let mut all = Vec::new();
    if let Some(fixed) = fixed {
        all.push(fixed?);
    }
    if let Some(holds) = holds {
        all.append(&mut holds?);
    }
    Some(Membrane {
        name: name?,
        place: item.place.clone(),
        shape: shape?,
        rest: rest.map_or(Some(None), |file| file.map(Some))?,
        prestrain: prestrain?,
        material: material?,
        thickness: thickness?,
        youngs_modulus: youngs_modulus?,
        elasticity: elasticity?,
        damping_ratio: damping_ratio?,
        drag: drag?,
        bending: bending.map_or(Some(None), |bending| bending.map(Some))?,
        rests_flat: rests_flat.unwrap_or(Some(false))?,
        holds: all,
        pressure: pressure.unwrap_or(Some(MembranePressure::Given(None)))?,
        walls,
        side,
    })
}

fn number_or(
    fields: &Fields<'_>,
    key: &'static str,
    default: f64,
    read: impl Fn(&Item<'_>) -> Option<Located<f64>>,
) -> Option<Located<f64>> {
    match fields.get(key) {
        Some(item) => read(&item),
        None => Some(fields.default(key, default)),
    }
}

#[derive(Clone, Copy)]
enum Kind {
    Rectangle,
    Disc,
    Cylinder,
    Sphere,
}

fn read_shape(fields: &Fields<'_>) -> Option<MembraneShape> {
    if !fields.has("shape") {
        let help = "file = \"sheet.stl\" or \"sheet.obj\"; or shape = \"rectangle\", \"disc\", \"cylinder\" or \"sphere\"";
        fields.need_or_help("file", Some(help))?;
        return read_mesh(fields).map(MembraneShape::File);
    }
    if fields.has("file") {
        fields.get("shape");
        fields.get("file");
        fields.excluded("file", "shape");
        return None;
    }
    let kind = fields.need("shape")?.word(
        "shape of a membrane",
        &[
            ("rectangle", Kind::Rectangle),
            ("disc", Kind::Disc),
            ("cylinder", Kind::Cylinder),
            ("sphere", Kind::Sphere),
        ],
    )?;
    let vector = |key| fields.need(key).and_then(|item| item.vector());
    let direction = |key| fields.need(key).and_then(|item| item.direction());
    let positive = |key| fields.need(key).and_then(|item| item.positive());
    let edge = positive("edge");
    match kind {
        Kind::Rectangle => {
            let (corner, along, across) = (vector("corner"), vector("along"), vector("across"));
            let (along, across) = (along?, across?);
            for side in [&along, &across] {
                if side.value == DVec3::ZERO {
                    let error = side.place.error("must not be of length 0");
                    fields.context.report(error);
                    return None;
                }
            }
            // Right angles to round-off.
            if along.normalize().dot(across.normalize()).abs() > 1e-9 {
                let error = across.place.error("must be at right angles to `along`");
                let help = "for other shapes make the mesh with a program of its own, and give it as `file`";
                fields.context.report(error.with_help(help));
                return None;
            }
            Some(MembraneShape::Rectangle {
                corner: corner?,
                along,
                across,
                edge: edge?,
            })
        }
        Kind::Disc => {
            let (axis, origin, radius) = (direction("axis"), vector("origin"), positive("radius"));
            Some(MembraneShape::Disc {
                axis: axis?,
                origin: origin?,
                radius: radius?,
                edge: edge?,
            })
        }
        Kind::Cylinder => {
            let (axis, origin, radius) = (direction("axis"), vector("origin"), positive("radius"));
            let along = fields.need("along").and_then(|item| item.range());
            Some(MembraneShape::Cylinder {
                axis: axis?,
                origin: origin?,
                radius: radius?,
                along: along?,
                edge: edge?,
            })
        }
        Kind::Sphere => {
            let (origin, radius) = (vector("origin"), positive("radius"));
            Some(MembraneShape::Sphere {
                origin: origin?,
                radius: radius?,
                edge: edge?,
            })
        }
    }
}

/// A third as it is written, and no other value.
fn is_a_third(value: f64) -> bool {
    (value - 1.0 / 3.0).abs() < 1e-3
}

fn read_elasticity(fields: &Fields<'_>) -> Option<MembraneElasticity> {
    let words = [("springs", true), ("continuum", false)];
    let is_springs = match fields.get("elasticity") {
        Some(item) => item.word("elasticity", &words),
        None => Some(true),
    };
    let poisson_ratio = number_or(fields, "poisson_ratio", 1.0 / 3.0, |item| {
        item.poisson_ratio()
    });
    let (is_springs, poisson_ratio) = (is_springs?, poisson_ratio?);
    if !is_springs {
        return Some(MembraneElasticity::Continuum {
            poisson_ratio: *poisson_ratio,
        });
    }
    if !is_a_third(*poisson_ratio) {
        let error = poisson_ratio
            .place
            .error("springs have a Poisson's ratio of 1/3, and no other");
        let help = "elasticity = \"continuum\" has any in (-1, 0.5]; or leave poisson_ratio out";
        fields.context.report(error.with_help(help));
        return None;
    }
    Some(MembraneElasticity::Springs)
}

fn read_bending(item: &Item<'_>) -> Option<Bending> {
    let fields = item.table()?;
    fields
        .need("law")?
        .word("bending law", &[("bridson", ())])?;
    let stiffness = fields.need("stiffness").and_then(|item| {
        if item.is_text() {
            return item.keyword("plate").map(|()| BendingStiffness::Plate);
        }
        item.non_negative().map(BendingStiffness::Given)
    });
    let damping = number_or(&fields, "damping", 0.0, |item| item.non_negative());
    fields.finish();
    Some(Bending {
        stiffness: stiffness?,
        damping: damping?,
    })
}

fn read_fixed(item: &Item<'_>) -> Option<Hold> {
    let picks = if item.is_list() {
        let picks: Vec<Option<Pick>> = item.list()?.iter().map(read_pick).collect();
        picks.into_iter().collect::<Option<Vec<Pick>>>()?
    } else {
        vec![read_pick(item)?]
    };
    Some(Hold {
        name: item.located("fixed".to_owned()),
        place: item.place.clone(),
        picks,
        motion: HoldMotion::Still,
        from: item.located(0.0),
        until: None,
    })
}

fn read_pick(item: &Item<'_>) -> Option<Pick> {
    if item.is_text() {
        item.word("choice of vertices", &[("rim", ())])?;
        return Some(Pick {
            is_rim: true,
            region: None,
        });
    }
    Some(Pick {
        is_rim: false,
        region: Some(Box::new(region::read(item)?)),
    })
}

fn read_hold(item: &Item<'_>) -> Option<Hold> {
    let fields = item.table()?;
    let name = fields.name_or_number();
    let is_rim = match fields.get("on") {
        Some(item) => item
            .word("choice of vertices", &[("rim", true)])
            .map(|_| true),
        None => Some(false),
    };
    let region = fields.get("region").map(|item| region::read(&item));
    let keys = ["wall", "velocity", "motion"];
    let is_still = !keys.iter().any(|key| fields.has(key));
    let is_one = is_still || fields.exactly_one(&keys, false);
    let motion = if let Some(item) = fields.get("wall") {
        item.name().map(HoldMotion::Wall)
    } else if let Some(item) = fields.get("velocity") {
        read_components(&item).map(HoldMotion::Velocity)
    } else if let Some(item) = fields.get("motion") {
        read_motions(&item).map(HoldMotion::Motions)
    } else {
        Some(HoldMotion::Still)
    };
    for key in keys {
        // Known, also where it is one too many.
        fields.get(key);
    }
    let (from, until) = interval(&fields);
    fields.finish();
    if name.as_ref().is_some_and(|name| name.value == "fixed") {
        let name = name?;
        let error = name
            .place
            .error("the name `fixed` is that of the key `fixed`");
        fields
            .context
            .report(error.with_help("give the hold another name"));
        return None;
    }
    let region = region.map_or(Some(None), |region| region.map(Some))?;
    Some(Hold {
        name: name?,
        place: item.place.clone(),
        picks: vec![Pick {
            is_rim: is_rim?,
            region: region.map(Box::new),
        }],
        motion: motion.filter(|_| is_one)?,
        from: from?,
        until,
    })
}

/// Three numbers, or `"free"` in the place of any.
fn read_components(item: &Item<'_>) -> Option<Located<[Option<f64>; 3]>> {
    let items = item.list()?;
    if items.len() != 3 {
        item.report(format!(
            "expected 3 components, numbers or \"free\", got {}",
            items.len()
        ));
        return None;
    }
    let mut components = [None; 3];
    for (component, item) in components.iter_mut().zip(&items) {
        if item.is_text() {
            item.keyword("free")?;
        } else {
            *component = Some(*item.number()?);
        }
    }
    if components == [None; 3] {
        item.report("holds nothing: all components are free");
        return None;
    }
    Some(item.located(components))
}

fn read_motions(item: &Item<'_>) -> Option<Vec<Motion>> {
    let motions = motion::read_all(item)?;
    for motion in &motions {
        if matches!(motion.kind, MotionKind::Servo { .. }) {
            let error = motion.place.error("a hold has no servo");
            let help =
                "give the servo to a wall, and hold the vertices by that wall: wall = \"...\"";
            item.context.report(error.with_help(help));
            return None;
        }
    }
    Some(motions)
}

fn read_pressure(item: &Item<'_>) -> Option<MembranePressure> {
    if !item.is_table() {
        return motion::read_load(item).map(|load| MembranePressure::Given(Some(load)));
    }
    let fields = item.table()?;
    if fields.has("gas") {
        let gas = fields.need("gas").and_then(|item| item.positive());
        let ambient = number_or(&fields, "ambient", 0.0, |item| item.non_negative());
        let exponent = number_or(&fields, "exponent", 1.0, |item| item.positive());
        fields.finish();
        return Some(MembranePressure::Gas {
            gas: gas?,
            ambient: ambient?,
            exponent: exponent?,
        });
    }
    if fields.has("fluid") {
        let fluid = fields.need("fluid").and_then(|item| item.number());
        let modulus = fields.need("bulk_modulus").and_then(|item| item.positive());
        let ambient = number_or(&fields, "ambient", 0.0, |item| item.non_negative());
        fields.finish();
        return Some(MembranePressure::Fluid {
            fluid: fluid?,
            bulk_modulus: modulus?,
            ambient: ambient?,
        });
    }
    if !fields.has("table") {
        item.report("expected one of `table`, `gas` and `fluid`");
        return None;
    }
    motion::read_load(item).map(|load| MembranePressure::Given(Some(load)))
}
