//! The surfaces that a wall can have.

use std::path::PathBuf;

use glam::DVec3;

use super::cursor::Fields;
use super::item::Item;
use super::settings::{Dimensions, Domain, Face};
use super::source::Located;

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
    /// Factor on all coordinates; default 1.
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

/// The shapes by name.
#[derive(Clone, Copy)]
pub(super) enum ShapeName {
    Box,
    Plane,
    Disc,
    Cylinder,
    Cone,
    Sphere,
    Revolution,
    Mesh,
}

const SHAPES: [(&str, ShapeName); 8] = [
    ("box", ShapeName::Box),
    ("plane", ShapeName::Plane),
    ("disc", ShapeName::Disc),
    ("cylinder", ShapeName::Cylinder),
    ("cone", ShapeName::Cone),
    ("sphere", ShapeName::Sphere),
    ("revolution", ShapeName::Revolution),
    ("mesh", ShapeName::Mesh),
];

/// The word under `shape`.
pub(super) fn read_name(fields: &Fields<'_>) -> Option<ShapeName> {
    fields.need("shape")?.word("shape", &SHAPES)
}

/// Reads the keys of a shape. `domain` is `None` when it is wrong itself.
pub(super) fn read(fields: &Fields<'_>, name: ShapeName, domain: Option<&Domain>) -> Option<Shape> {
    match name {
        ShapeName::Mesh => read_mesh_wall(fields),
        ShapeName::Box => read_box(fields, domain),
        other => read_surface(fields, other),
    }
}

fn read_box(fields: &Fields<'_>, domain: Option<&Domain>) -> Option<Shape> {
    let faces = Face::ALL.map(|face| (face.name(), face));
    let given = match fields.get("sides") {
        None => None,
        Some(item) => {
            let mut sides = Vec::new();
            for item in item.list()? {
                let face = item.word("side", &faces)?;
                if domain.is_some_and(|domain| domain.periodic[face.axis]) {
                    item.report("this face is periodic, no wall can be there");
                } else if sides.contains(&face) {
                    item.report("this face is listed twice");
                }
                sides.push(face);
            }
            if sides.is_empty() {
                item.report("must list at least one face");
            }
            sides.sort();
            Some(sides)
        }
    };
    let sides = given.or_else(|| {
        let domain = domain?;
        let is_flat = domain.dimensions == Dimensions::Two;
        let is_open = |face: &Face| !domain.periodic[face.axis] && (face.axis < 2 || !is_flat);
        let sides: Vec<Face> = Face::ALL.into_iter().filter(is_open).collect();
        if sides.is_empty() {
            fields.context.report(
                fields
                    .place()
                    .error("every face of the domain is periodic, the box has no sides"),
            );
        }
        Some(sides)
    })?;
    Some(Shape::Box { sides })
}

fn read_surface(fields: &Fields<'_>, name: ShapeName) -> Option<Shape> {
    let direction = |key| fields.need(key).and_then(|item| item.direction());
    let point = |key| fields.need(key).and_then(|item| item.vector());
    let radius = || fields.need("radius").and_then(|item| item.positive());
    let side = || {
        fields
            .get("side")
            .and_then(|item| {
                item.word(
                    "side",
                    &[("inside", Side::Inside), ("outside", Side::Outside)],
                )
            })
            .unwrap_or(Side::Inside)
    };
    match name {
        ShapeName::Plane => {
            let (point, normal) = (point("point"), direction("normal"));
            Some(Shape::Plane {
                point: point?,
                normal: normal?,
            })
        }
        ShapeName::Disc => {
            let (axis, origin, radius) = (direction("axis"), point("origin"), radius());
            Some(Shape::Disc {
                axis: axis?,
                origin: origin?,
                radius: radius?,
            })
        }
        ShapeName::Cylinder => {
            let (axis, origin, radius) = (direction("axis"), point("origin"), radius());
            let along = fields.get("along").and_then(|item| item.range());
            let side = side();
            Some(Shape::Cylinder {
                axis: axis?,
                origin: origin?,
                radius: radius?,
                along,
                side,
            })
        }
        ShapeName::Cone => {
            let (axis, origin) = (direction("axis"), point("origin"));
            let along = fields.need("along").and_then(|item| item.range());
            let radii = fields.need("radii").and_then(|item| read_radii(&item));
            let side = side();
            Some(Shape::Cone {
                axis: axis?,
                origin: origin?,
                along: along?,
                radii: radii?,
                side,
            })
        }
        ShapeName::Sphere => {
            let (origin, radius, side) = (point("origin"), radius(), side());
            Some(Shape::Sphere {
                origin: origin?,
                radius: radius?,
                side,
            })
        }
        ShapeName::Revolution => {
            let (axis, origin) = (direction("axis"), point("origin"));
            let profile = fields.need("profile").and_then(|item| read_profile(&item));
            let side = side();
            Some(Shape::Revolution {
                axis: axis?,
                origin: origin?,
                profile: profile?,
                side,
            })
        }
        ShapeName::Box | ShapeName::Mesh => None,
    }
}

/// Radii of a cone: at least 0, not both 0.
pub(super) fn read_radii(item: &Item<'_>) -> Option<Located<[f64; 2]>> {
    let radii = item.numbers::<2>()?;
    if radii.iter().any(|&radius| radius < 0.0) || radii.iter().all(|&radius| radius == 0.0) {
        item.report(format!(
            "must be >= 0 and not both 0, got {}",
            item.place.text()
        ));
        return None;
    }
    Some(radii)
}

fn read_profile(item: &Item<'_>) -> Option<Located<Vec<[f64; 2]>>> {
    let corners = item.list()?;
    if corners.len() < 2 {
        item.report(format!(
            "needs at least 2 points [r, z], got {}",
            corners.len()
        ));
        return None;
    }
    let mut profile: Vec<[f64; 2]> = Vec::with_capacity(corners.len());
    for corner in corners {
        let point = corner.numbers::<2>()?.value;
        if point[0] < 0.0 {
            corner.report(format!("r must be >= 0, got {}", corner.place.text()));
            return None;
        }
        if profile.last() == Some(&point) {
            corner.report("is the same point as the one before");
            return None;
        }
        profile.push(point);
    }
    Some(Located {
        value: profile,
        place: item.place.clone(),
    })
}

fn read_mesh_wall(fields: &Fields<'_>) -> Option<Shape> {
    let mesh = read_mesh(fields);
    let side = read_side(fields);
    Some(Shape::Mesh { mesh: mesh?, side })
}

/// `side`, default both.
pub(super) fn read_side(fields: &Fields<'_>) -> MeshSide {
    fields
        .get("side")
        .and_then(|item| {
            item.word(
                "side",
                &[("both", MeshSide::Both), ("front", MeshSide::Front)],
            )
        })
        .unwrap_or(MeshSide::Both)
}

/// `file`, `scale`, `offset`, `rotate`.
pub(super) fn read_mesh(fields: &Fields<'_>) -> Option<MeshSource> {
    let file = fields.need("file").and_then(|item| item.file());
    let scale = match fields.get("scale") {
        Some(item) => item.positive(),
        None => Some(fields.default("scale", 1.0)),
    };
    let offset = match fields.get("offset") {
        Some(item) => item.vector(),
        None => Some(fields.default("offset", DVec3::ZERO)),
    };
    let rotate = fields.get("rotate").and_then(|item| {
        let fields = item.table()?;
        let axis = fields.need("axis").and_then(|item| item.direction());
        let degrees = fields.need("degrees").and_then(|item| item.number());
        fields.finish();
        Some(Turn {
            axis: axis?,
            degrees: degrees?,
        })
    });
    Some(MeshSource {
        file: file?,
        scale: scale?,
        offset: offset?,
        rotate,
    })
}
