//! `[[membranes]]`: elastic sheets.

use std::path::PathBuf;

use glam::DVec3;

use super::MaterialIndex;
use super::boundaries::NAME;
use super::cursor::Fields;
use super::from_item::FromItem;
use super::item::Item;
use super::keys::{
    Absent, Choice, Kind, SceneKey, TableKeys, Variant, Variants, Word, key, non_negative, number,
    positive, variant, vector, word,
};
use super::laws::Range;
use super::motion::{Load, MOTION, Motion, MotionKind};
use super::region::{REGION, Region};
use super::shapes::{
    ALONG, AXIS, MESH_SIDE, MeshSide, MeshSource, ORIGIN, PLACED, RADIUS, read_mesh,
};
use super::source::{Located, SourceSpan};
use super::walls::{INTERVAL, interval};

/// An elastic sheet: a mesh whose vertices have mass.
#[derive(Debug, Clone, PartialEq)]
pub struct Membrane {
    /// Unique among membranes; default `membrane-1`, ...
    pub name: Located<String>,
    /// Where the entry stands.
    pub place: SourceSpan,
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
    /// Holds of vertices; `fixed` is the first, of that name.
    pub holds: Vec<Hold>,
    /// On the back of the triangles.
    pub pressure: MembranePressure,
    /// Whether vertices touch walls; default false.
    pub walls: bool,
    /// Sides that act; default both.
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
    /// Stiffness as given, N m.
    Given(Located<f64>),
}

/// Vertices that are held.
#[derive(Debug, Clone, PartialEq)]
pub struct Hold {
    /// Unique in the membrane; `fixed` for the key of that name, default `hold-1`, ...
    pub name: Located<String>,
    /// Where the entry stands.
    pub place: SourceSpan,
    /// Vertices that are held: those of any of these.
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
    /// No motion.
    Still,
    /// With a velocity, m/s; components without one are free.
    Velocity(Located<[Option<f64>; 3]>),
    /// Motion as a rigid body.
    Motions(Vec<Motion>),
    /// With a wall.
    Wall(Located<String>),
}

/// Source of the pressure on the back of a membrane.
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

/// How hinges are free of moment.
#[derive(Clone, Copy, PartialEq)]
enum RestAngles {
    Shape,
    Flat,
}

impl Word for RestAngles {
    const WHAT: &'static str = "choice of rest angles";
    const WORDS: &'static [(&'static str, Self)] = &[("shape", Self::Shape), ("flat", Self::Flat)];
}

#[derive(Clone, Copy, PartialEq)]
enum Elasticity {
    Springs,
    Continuum,
}

impl Word for Elasticity {
    const WHAT: &'static str = "elasticity";
    const WORDS: &'static [(&'static str, Self)] =
        &[("springs", Self::Springs), ("continuum", Self::Continuum)];
}

/// Vertices on boundary edges.
#[derive(Clone, Copy)]
struct Rim;

impl Word for Rim {
    const WHAT: &'static str = "choice of vertices";
    const WORDS: &'static [(&'static str, Self)] = &[("rim", Self)];
}

#[rustfmt::skip]
const EDGE: SceneKey = key("edge", positive("m"), "2e-3", "the length near which edges are");
const RIM: Kind = word::<Rim>();
#[rustfmt::skip]
const FROM_FILE: Variant = variant("file", &[&[
    key("file", Kind::File(""), "\"sheet.stl\"   # or \"sheet.obj\"; or shape = \"rectangle\", \"disc\", \"cylinder\", \"sphere\"", "`.stl` or `.obj`. Vertices count from 0 in the order of the file; of an STL, in the order in which they appear. Two triangles at an edge at most, all turned alike"),
], PLACED], "in place of `shape`: triangles from a file");

/// `[[membranes]]`
#[rustfmt::skip]
pub(super) static MEMBRANE: TableKeys = TableKeys::new(&[&[
    NAME,
    key("rest", Kind::File(""), "\"unloaded.stl\"", "the stress-free triangles, as many and in the same order; `scale`, `rotate` and `offset` apply to it too").or_open("the shape itself"),
    key("prestrain", Kind::Number("", Range::Over(-0.5)), "0.05", "all rest lengths are taken over 1 + `prestrain`, so that the sheet starts in tension").or(0.0),
    key("material", Kind::Material, "\"glass\"   # the name of a table [materials.glass]", "its density is that of the sheet, its laws are those of contacts"),
    key("thickness", positive("m"), "3e-4", "of the sheet; half of it on each side of the triangles in contacts"),
    key("youngs_modulus", positive("Pa"), "1.25e6", "Young's modulus"),
    key("elasticity", word::<Elasticity>(), "\"continuum\"", "a spring along each edge; or `\"continuum\"`, uniformly strained triangles, exact on any mesh").or_word("springs"),
    key("poisson_ratio", Kind::Number("", Range::PoissonRatio), "0.3333", "of `\"continuum\"`; springs have 1/3 and no other").or(1.0 / 3.0),
    key("damping_ratio", non_negative(""), "0.15", "of dashpots along the edges, as a fraction of critical").or(0.0),
    key("drag", non_negative("1/s"), "1.0", "a force -drag m v on each vertex").or(0.0),
    key("bending", Kind::Table(&BENDING), "{ law = \"bridson\", stiffness = \"plate\" }", "resistance to bending").or_open("none"),
    key("rest_angles", word::<RestAngles>(), "\"flat\"", "hinges are free of moment as in the rest shape; or `\"flat\"`").or_word("shape"),
    key("fixed", Kind::OneOf(&[RIM, Kind::Table(&REGION), Kind::List("", &Kind::OneOf(&[RIM, Kind::Table(&REGION)]))]), "\"rim\"", "`\"rim\"`, a region, or a list of both: a hold of the name `fixed`").or_open("none"),
    key("holds", Kind::List("", &Kind::Table(&HOLD)), "[{ on = \"rim\", wall = \"lid\" }]", "a list of holds").absent(Absent::EmptyList),
    key("pressure", Kind::OneOf(&[number("Pa"), Kind::List("", &Kind::Row(&["s", "Pa"])), Kind::Table(&PRESSURE)]), "100.0", "along the normals: a number, rows `[[t, p], ...]`, or a table").or_open("0"),
    key("walls", Kind::Flag, "true", "vertices touch walls, as spheres of half the thickness without spin").or_flag(false),
    MESH_SIDE,
]]).with_variants(Variants::Word {
    key: "shape",
    what: "shape of a membrane",
    example: "\"rectangle\"   # or disc, cylinder, sphere; or file = \"sheet.stl\"",
    text: "which further keys there are",
    absent: Some(&FROM_FILE),
    of: &[
        variant("rectangle", &[&[
            key("corner", vector("m"), "[0.1, 0.1, 0.1]", "a corner"),
            key("along", vector("m"), "[0.1, 0, 0]", "from the corner along the rows; half triangles at their ends"),
            key("across", vector("m"), "[0, 0.1, 0]", "from the corner across the rows, at right angles to `along`"),
            EDGE,
        ]], "rows of triangles"),
        variant("disc", &[&[AXIS, ORIGIN, RADIUS, EDGE]], "rings about the centre"),
        variant("cylinder", &[&[AXIS, ORIGIN, RADIUS, ALONG, EDGE]], "without ends, normals outwards"),
        variant("sphere", &[&[ORIGIN, RADIUS, EDGE]], "normals outwards"),
    ],
}).with_choices(&[Choice { keys: &["shape", "file"], needed: false }]);

#[rustfmt::skip]
static BENDING: TableKeys = TableKeys::new(&[]).with_variants(Variants::Word {
    key: "law",
    what: "bending law",
    example: "\"bridson\"",
    text: "the law",
    absent: None,
    of: &[variant("bridson", &[&[
        key("stiffness", Kind::OneOf(&[non_negative("N m"), Kind::Keyword("plate")]), "\"plate\"", "a number, or `\"plate\"`: that of a plate of the same thickness and modulus"),
        key("damping", non_negative("N s"), "1e-6", "damping coefficient").or(0.0),
    ]], "Bridson, Marino & Fedkiw (2003)")],
});

#[rustfmt::skip]
static PRESSURE: TableKeys = TableKeys::new(&[]).with_variants(Variants::Key {
    of: &[
        variant("table", &[&[
            key("table", Kind::File(""), "\"pressure.csv\"   # t,pressure", "columns `t,pressure`"),
        ]], "from a file"),
        variant("gas", &[&[
            key("gas", positive("Pa"), "1e5", "absolute pressure at the start"),
            AMBIENT,
            key("exponent", positive(""), "1.4", "1.4 for air without heat exchange").or(1.0),
        ]], "p = gas (V0/V)^exponent - ambient, V the enclosed volume, open rims closed by fans"),
        variant("fluid", &[&[
            key("fluid", number("Pa"), "1e4", "absolute pressure at the start"),
            key("bulk_modulus", positive("Pa"), "2.2e9", "of the fluid"),
            AMBIENT,
        ]], "p = fluid + bulk_modulus (V0 - V)/V0 - ambient"),
    ],
    alone: true,
});
#[rustfmt::skip]
const AMBIENT: SceneKey = key("ambient", non_negative("Pa"), "1e5", "pressure outside").or(0.0);

/// Vertices that are held.
#[rustfmt::skip]
pub(super) static HOLD: TableKeys = TableKeys::new(&[&[
    NAME,
    key("on", RIM, "\"rim\"", "only vertices on boundary edges").or_open("all vertices"),
    key("region", Kind::Table(&REGION), "{ shape = \"half-space\", point = [0, 0, 0.1], normal = [0, 0, 1] }   # m", "of those the ones that are inside at the start").or_open("everywhere"),
    key("wall", Kind::Name, "\"lid\"", "they go with a wall, whose force and torque then include theirs").or_open("they stay"),
    key("velocity", Kind::Components("m/s"), "[1e-3, \"free\", 0.0]", "components are prescribed, `\"free\"` leaves one free").or_open("they stay"),
    key("motion", Kind::List("", &Kind::Table(&MOTION)), "[{ kind = \"translation\", velocity = [0, 0, 0.1] }]", "a list as of walls, without servos").or_open("they stay"),
], INTERVAL]).with_choices(&[Choice { keys: &["wall", "velocity", "motion"], needed: false }]);

/// Reads an entry of `[[membranes]]`.
pub(super) fn read(item: &Item<'_>) -> Option<Membrane> {
    let fields = item.open(&MEMBRANE)?;
    let shape = read_shape(&fields);
    let rest_angles: RestAngles = fields.read("rest_angles");
    let fixed: Option<Fixed> = fields.read("fixed");
    let mut holds = fixed.map_or_else(Vec::new, |Fixed(hold)| vec![hold]);
    if let Some(items) = fields.get("holds").filter(Item::is_list) {
        fields.context.unique_names(&items.list()?);
    }
    let more: Vec<Hold> = fields.read("holds");
    holds.extend(more);
    let pressure: Option<MembranePressure> = fields.read("pressure");
    Some(Membrane {
        name: fields.name_or_number(),
        place: item.place.clone(),
        rest: fields.read("rest"),
        prestrain: fields.read("prestrain"),
        material: fields.read("material"),
        thickness: fields.read("thickness"),
        youngs_modulus: fields.read("youngs_modulus"),
        elasticity: read_elasticity(&fields),
        damping_ratio: fields.read("damping_ratio"),
        drag: fields.read("drag"),
        bending: fields.read("bending"),
        rests_flat: rest_angles == RestAngles::Flat,
        holds,
        pressure: pressure.unwrap_or(MembranePressure::Given(None)),
        walls: fields.read("walls"),
        side: fields.read("side"),
        // At last, so that all else has been read.
        shape: shape?,
    })
}

fn read_shape(fields: &Fields<'_>) -> Option<MembraneShape> {
    Some(match fields.variant()? {
        "rectangle" => read_rectangle(fields)?,
        "disc" => MembraneShape::Disc {
            axis: fields.read("axis"),
            origin: fields.read("origin"),
            radius: fields.read("radius"),
            edge: fields.read("edge"),
        },
        "cylinder" => MembraneShape::Cylinder {
            axis: fields.read("axis"),
            origin: fields.read("origin"),
            radius: fields.read("radius"),
            along: fields.read("along"),
            edge: fields.read("edge"),
        },
        "sphere" => MembraneShape::Sphere {
            origin: fields.read("origin"),
            radius: fields.read("radius"),
            edge: fields.read("edge"),
        },
        _ => MembraneShape::File(read_mesh(fields)),
    })
}

fn read_rectangle(fields: &Fields<'_>) -> Option<MembraneShape> {
    let (corner, edge) = (fields.read("corner"), fields.read("edge"));
    let along: Located<DVec3> = fields.read("along");
    let across: Located<DVec3> = fields.read("across");
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
        let help =
            "for other shapes make the mesh with a program of its own, and give it as `file`";
        fields.context.report(error.with_help(help));
    }
    Some(MembraneShape::Rectangle {
        corner,
        along,
        across,
        edge,
    })
}

/// Whether a number is a third as it is written, and no other value.
fn is_a_third(value: f64) -> bool {
    (value - 1.0 / 3.0).abs() < 1e-3
}

fn read_elasticity(fields: &Fields<'_>) -> MembraneElasticity {
    let elasticity: Elasticity = fields.read("elasticity");
    let poisson_ratio: Located<f64> = fields.read("poisson_ratio");
    if elasticity == Elasticity::Continuum {
        return MembraneElasticity::Continuum {
            poisson_ratio: *poisson_ratio,
        };
    }
    if !is_a_third(*poisson_ratio) && !poisson_ratio.is_nan() {
        let error = poisson_ratio
            .place
            .error("springs have a Poisson's ratio of 1/3, and no other");
        let help = "elasticity = \"continuum\" has any in (-1, 0.5]; or leave poisson_ratio out";
        fields.context.report(error.with_help(help));
    }
    MembraneElasticity::Springs
}

impl FromItem for Bending {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        let fields = item.fields(kind)?;
        fields.variant()?;
        let stiffness: Option<BendingStiffness> = fields.read("stiffness");
        Some(Bending {
            damping: fields.read("damping"),
            stiffness: stiffness?,
        })
    }
}

impl FromItem for BendingStiffness {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        match item.is_text() {
            true => item.keyword("plate").map(|()| Self::Plate),
            false => Located::from_item(item, kind).map(Self::Given),
        }
    }
}

/// The hold that `fixed` stands for.
struct Fixed(Hold);

impl FromItem for Fixed {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        let picks = match item.is_list() {
            true => Vec::from_item(item, kind)?,
            false => vec![Pick::from_item(item, kind)?],
        };
        Some(Self(Hold {
            name: item.located("fixed".to_owned()),
            place: item.place.clone(),
            picks,
            motion: HoldMotion::Still,
            from: item.located(0.0),
            until: None,
        }))
    }
}

impl FromItem for Pick {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        let region = match item.is_text() {
            true => {
                Rim::from_item(item, kind)?;
                None
            }
            false => Some(Box::new(Located::from_item(item, kind)?)),
        };
        Some(Pick {
            is_rim: region.is_none(),
            region,
        })
    }
}

impl FromItem for Hold {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        let fields = item.fields(kind)?;
        let name = fields.name_or_number();
        if *name == "fixed" {
            let error = name.error("the name `fixed` is that of the key `fixed`");
            let error = error.with_help("give the hold another name");
            fields.context.report(error);
        }
        let rim: Option<Rim> = fields.read("on");
        let region: Option<Located<Region>> = fields.read("region");
        let (from, until) = interval(&fields);
        let motion = match fields.chosen(0) {
            Some("wall") => fields.read::<Option<_>>("wall").map(HoldMotion::Wall),
            Some("velocity") => read_components(&fields).map(HoldMotion::Velocity),
            Some(_) => read_motions(&fields).map(HoldMotion::Motions),
            None => Some(HoldMotion::Still),
        };
        Some(Hold {
            name,
            place: item.place.clone(),
            picks: vec![Pick {
                is_rim: rim.is_some(),
                region: region.map(Box::new),
            }],
            motion: motion?,
            from,
            until,
        })
    }
}

/// Velocities of components, not all of them free.
fn read_components(fields: &Fields<'_>) -> Option<Located<[Option<f64>; 3]>> {
    let components: Option<Located<[Option<f64>; 3]>> = fields.read("velocity");
    let components = components?;
    if components.value == [None; 3] {
        let error = components.error("holds nothing: all components are free");
        fields.context.report(error);
    }
    Some(components)
}

fn read_motions(fields: &Fields<'_>) -> Option<Vec<Motion>> {
    let motions: Option<Vec<Motion>> = fields.read("motion");
    let motions = motions?;
    let mut servos = motions
        .iter()
        .filter(|motion| matches!(motion.kind, MotionKind::Servo { .. }));
    if let Some(servo) = servos.next() {
        let error = servo.place.error("a hold has no servo");
        let help = "give the servo to a wall, and hold the vertices by that wall: wall = \"...\"";
        fields.context.report(error.with_help(help));
    }
    Some(motions)
}

impl FromItem for MembranePressure {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        if !item.is_table() {
            return Load::from_item(item, kind).map(|load| Self::Given(Some(load)));
        }
        let fields = item.fields(kind)?;
        Some(match fields.variant()? {
            "gas" => Self::Gas {
                gas: fields.read("gas"),
                ambient: fields.read("ambient"),
                exponent: fields.read("exponent"),
            },
            "fluid" => Self::Fluid {
                fluid: fields.read("fluid"),
                bulk_modulus: fields.read("bulk_modulus"),
                ambient: fields.read("ambient"),
            },
            _ => Self::Given(Some(Load::Table(fields.read("table")))),
        })
    }
}
