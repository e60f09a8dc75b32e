//! The surfaces that a wall can have.

use std::path::PathBuf;

use glam::DVec3;

use super::cursor::Fields;
use super::from_item::FromItem;
use super::item::Item;
use super::keys::{
    Absent, Kind, SceneKey, TableKeys, Variants, Word, key, number, positive, variant, vector, word,
};
use super::laws::Range;
use super::settings::{Dimensions, Domain, Face};
use super::source::{Located, SourceSpan};

/// Where the particles are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Side {
    /// Towards the axis or centre.
    Inside,
    /// Away from it.
    Outside,
}

/// On which side a mesh acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MeshSide {
    /// On both.
    Both,
    /// Where the normals of the triangles point.
    Front,
}

/// The surface of a wall. Lengths in m, directions of length 1.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// Faces of the domain, each a wall of its own.
    Box {
        /// In the order of [`Face::ALL`]; by default all that are not periodic (and, in two
        /// dimensions, not those along z).
        sides: Vec<Face>,
    },
    /// A half-space is full, the other empty.
    Plane {
        /// A point on it.
        point: Located<DVec3>,
        /// Points into the space of the particles.
        normal: Located<DVec3>,
    },
    /// A flat disc, two-sided.
    Disc {
        /// Normal to the disc.
        axis: Located<DVec3>,
        /// Its centre.
        origin: Located<DVec3>,
        /// Its radius.
        radius: Located<f64>,
    },
    /// A circular cylinder without ends.
    Cylinder {
        /// Direction of the axis.
        axis: Located<DVec3>,
        /// A point on the axis.
        origin: Located<DVec3>,
        /// Its radius.
        radius: Located<f64>,
        /// Extent along the axis, from the origin; none: unbounded.
        along: Option<Located<[f64; 2]>>,
        /// Default inside.
        side: Side,
    },
    /// A truncated cone without ends.
    Cone {
        /// Direction of the axis.
        axis: Located<DVec3>,
        /// A point on the axis.
        origin: Located<DVec3>,
        /// Extent along the axis, from the origin.
        along: Located<[f64; 2]>,
        /// Radii at the two ends, at least 0, not both 0.
        radii: Located<[f64; 2]>,
        /// Default inside.
        side: Side,
    },
    /// A sphere.
    Sphere {
        /// Its centre.
        origin: Located<DVec3>,
        /// Its radius.
        radius: Located<f64>,
        /// Default inside.
        side: Side,
    },
    /// A polygon turned about an axis.
    Revolution {
        /// Direction of the axis.
        axis: Located<DVec3>,
        /// Where z = 0 on the axis.
        origin: Located<DVec3>,
        /// At least two corners [r, z].
        profile: Located<Vec<[f64; 2]>>,
        /// Default inside.
        side: Side,
    },
    /// Triangles from a file.
    Mesh {
        /// The triangles and where they go.
        mesh: MeshSource,
        /// Default both.
        side: MeshSide,
    },
}

/// A triangle file and its placement: scaled, then turned about the origin, then moved.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshSource {
    /// `.stl` (ASCII or binary) or `.obj`, resolved against the folder of the scene.
    pub file: Located<PathBuf>,
    /// Length of a unit of the file, m: the factor on all coordinates; default 1.
    pub scale: Located<f64>,
    /// Added at last, m; default 0.
    pub offset: Located<DVec3>,
    /// Turn about the origin of the file.
    pub rotate: Option<Turn>,
}

/// A turn about an axis through the origin, right-handed.
#[derive(Debug, Clone, PartialEq)]
pub struct Turn {
    /// Direction of the axis.
    pub axis: Located<DVec3>,
    /// Angle, degrees.
    pub degrees: Located<f64>,
}

impl Word for Side {
    const WHAT: &'static str = "side";
    const WORDS: &'static [(&'static str, Self)] =
        &[("inside", Self::Inside), ("outside", Self::Outside)];
}

impl Word for MeshSide {
    const WHAT: &'static str = "side";
    const WORDS: &'static [(&'static str, Self)] = &[("both", Self::Both), ("front", Self::Front)];
}

impl Word for Face {
    const WHAT: &'static str = "side";
    const WORDS: &'static [(&'static str, Self)] = &[
        ("-x", Self::ALL[0]),
        ("+x", Self::ALL[1]),
        ("-y", Self::ALL[2]),
        ("+y", Self::ALL[3]),
        ("-z", Self::ALL[4]),
        ("+z", Self::ALL[5]),
    ];
}

// Keys that shapes of walls, regions and membranes share.
#[rustfmt::skip]
pub(super) const AXIS: SceneKey = key("axis", Kind::Direction, "[0, 0, 1]   # of any length", "direction of the axis");
#[rustfmt::skip]
pub(super) const ORIGIN: SceneKey = key("origin", vector("m"), "[0, 0, 0]", "a point on the axis, or the centre");
pub(super) const RADIUS: SceneKey = key("radius", positive("m"), "0.05", "its radius");
#[rustfmt::skip]
pub(super) const ALONG: SceneKey = key("along", Kind::Interval("m"), "[0.0, 0.1]   # m from the origin along the axis", "extent along the axis, from the origin");
#[rustfmt::skip]
pub(super) const RADII: SceneKey = key("radii", Kind::Numbers("m", 2, Range::NonNegative), "[0.01, 0.05]   # m, at the two ends of `along`", "at the two ends of `along`, not both 0");
pub(super) const CYLINDER: &[SceneKey] = &[AXIS, ORIGIN, RADIUS, ALONG.or_open("unbounded")];
pub(super) const CONE: &[SceneKey] = &[AXIS, ORIGIN, ALONG, RADII];
#[rustfmt::skip]
const SIDE: SceneKey = key("side", word::<Side>(), "\"outside\"", "where the particles are").or_word("inside");
#[rustfmt::skip]
pub(super) const MESH_SIDE: SceneKey = key("side", word::<MeshSide>(), "\"front\"", "`\"front\"`: it acts only on the side where its triangles turn counter-clockwise").or_word("both");

#[rustfmt::skip]
static TURN: TableKeys = TableKeys::new(&[&[
    key("axis", Kind::Direction, "[0, 0, 1]", "through the origin of the file"),
    key("degrees", number("degrees"), "90.0", "right-handed about the axis"),
]]);

/// The file of a mesh.
#[rustfmt::skip]
pub(super) const MESH_FILE: SceneKey = key("file", Kind::File(""), "\"hopper.stl\"   # beside the scene", "`.stl` (ASCII or binary) or `.obj`");
/// Where a mesh goes.
#[rustfmt::skip]
pub(super) const PLACED: &[SceneKey] = &[
    key("scale", positive("m"), "\"1 mm\"", "length of a unit of the file: the factor on all coordinates").or(1.0),
    key("rotate", Kind::Table(&TURN), "{ axis = [0, 0, 1], degrees = 90.0 }", "a turn about the origin of the file, after scaling").or_open("none"),
    key("offset", vector("m"), "[0, 0, 0.1]", "added at last").absent(Absent::Zero),
];

/// The shapes of walls.
#[rustfmt::skip]
pub(super) const SHAPE: Variants = Variants::Word {
    key: "shape",
    what: "shape",
    example: "\"box\"   # or plane, disc, cylinder, cone, sphere, revolution, mesh",
    text: "which further keys there are",
    absent: None,
    of: &[
        variant("box", &[&[
            key("sides", Kind::List("face", &word::<Face>()), "[\"-z\", \"+z\"]", "faces of the domain; each is a wall of its own, named `box.-x` ...").or_open("all that are not periodic, and not those along z in two dimensions"),
        ]], "faces of the domain"),
        variant("plane", &[&[
            key("point", vector("m"), "[0, 0, 0]   # m, on the plane", "on the plane"),
            key("normal", Kind::Direction, "[0, 0, 1]   # towards the particles", "points to the particles; behind the plane is full"),
        ]], "a half-space that is full"),
        variant("disc", &[&[AXIS, ORIGIN, RADIUS]], "a flat disc, two-sided; `axis` is its normal"),
        variant("cylinder", &[CYLINDER, &[SIDE]], "a circular cylinder without ends"),
        variant("cone", &[CONE, &[SIDE]], "a truncated cone without ends"),
        variant("sphere", &[&[ORIGIN, RADIUS, SIDE]], "a sphere"),
        variant("revolution", &[&[
            AXIS, ORIGIN,
            key("profile", Kind::List("", &Kind::Numbers("m", 2, Range::Any)), "[[0.01, 0.0], [0.01, 0.02], [0.05, 0.1]]   # m, points [r, z]", "two corners `[r, z]` at least, r >= 0; z along the axis from the origin"),
            SIDE,
        ]], "a polygon turned about the axis"),
        variant("mesh", &[&[MESH_FILE], PLACED, &[MESH_SIDE]], "triangles from a file"),
    ],
};

/// Reads the keys of a shape. `domain` is `None` when it is wrong itself.
pub(super) fn read(fields: &Fields<'_>, domain: Option<&Domain>) -> Option<Shape> {
    Some(match fields.variant()? {
        "box" => Shape::Box {
            sides: read_sides(fields, domain)?,
        },
        "plane" => Shape::Plane {
            point: fields.read("point"),
            normal: fields.read("normal"),
        },
        "disc" => Shape::Disc {
            axis: fields.read("axis"),
            origin: fields.read("origin"),
            radius: fields.read("radius"),
        },
        "cylinder" => Shape::Cylinder {
            axis: fields.read("axis"),
            origin: fields.read("origin"),
            radius: fields.read("radius"),
            along: fields.read("along"),
            side: fields.read("side"),
        },
        "cone" => Shape::Cone {
            axis: fields.read("axis"),
            origin: fields.read("origin"),
            along: fields.read("along"),
            radii: read_radii(fields),
            side: fields.read("side"),
        },
        "sphere" => Shape::Sphere {
            origin: fields.read("origin"),
            radius: fields.read("radius"),
            side: fields.read("side"),
        },
        "revolution" => Shape::Revolution {
            axis: fields.read("axis"),
            origin: fields.read("origin"),
            profile: read_profile(fields)?,
            side: fields.read("side"),
        },
        "mesh" => Shape::Mesh {
            mesh: read_mesh(fields),
            side: fields.read("side"),
        },
        _ => return None,
    })
}

fn read_sides(fields: &Fields<'_>, domain: Option<&Domain>) -> Option<Vec<Face>> {
    if let Some(item) = fields.get("sides") {
        let mut sides = Vec::new();
        let items = item.list()?;
        if items.is_empty() {
            item.report("must list at least one face");
        }
        for item in items {
            let Some(face) = item.word(Face::WHAT, Face::WORDS) else {
                continue;
            };
            if domain.is_some_and(|domain| domain.periodic[face.axis]) {
                item.report("this face is periodic, no wall can be there");
            } else if sides.contains(&face) {
                item.report("this face is listed twice");
            }
            sides.push(face);
        }
        sides.sort();
        return Some(sides);
    }
    let domain = domain?;
    let is_flat = domain.dimensions == Dimensions::Two;
    let is_open = |face: &Face| !domain.periodic[face.axis] && (face.axis < 2 || !is_flat);
    let sides: Vec<Face> = Face::ALL.into_iter().filter(is_open).collect();
    if sides.is_empty() {
        let error = "every face of the domain is periodic, the box has no sides";
        fields.context.report(fields.place().error(error));
    }
    Some(sides)
}

/// Radii of a cone, not both 0.
pub(super) fn read_radii(fields: &Fields<'_>) -> Located<[f64; 2]> {
    let radii: Located<[f64; 2]> = fields.read("radii");
    if *radii == [0.0; 2] {
        let message = format!("must be >= 0 and not both 0, got {}", radii.place.text());
        fields.context.report(radii.error(message));
    }
    radii
}

fn read_profile(fields: &Fields<'_>) -> Option<Located<Vec<[f64; 2]>>> {
    let corners: Option<Located<Vec<Located<[f64; 2]>>>> = fields.read("profile");
    let corners = corners?;
    let wrong = |place: &SourceSpan, message: String| fields.context.report(place.error(message));
    if corners.len() < 2 {
        let got = corners.len();
        wrong(
            &corners.place,
            format!("needs at least 2 points [r, z], got {got}"),
        );
    }
    for corner in corners.iter().filter(|corner| corner[0] < 0.0) {
        let got = corner.place.text();
        wrong(&corner.place, format!("r must be >= 0, got {got}"));
    }
    for pair in corners.windows(2).filter(|pair| *pair[0] == *pair[1]) {
        let message = "is the same point as the one before";
        wrong(&pair[1].place, message.to_owned());
    }
    Some(corners.map(|corners| corners.iter().map(|corner| corner.value).collect()))
}

/// `file`, `scale`, `offset`, `rotate`.
pub(super) fn read_mesh(fields: &Fields<'_>) -> MeshSource {
    MeshSource {
        file: fields.read("file"),
        scale: fields.read("scale"),
        offset: fields.read("offset"),
        rotate: fields.read("rotate"),
    }
}

impl FromItem for Turn {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        let fields = item.fields(kind)?;
        Some(Turn {
            axis: fields.read("axis"),
            degrees: fields.read("degrees"),
        })
    }
}
