//! Regions of space, for insertion, counting and deletion.

use glam::DVec3;

use super::cursor::Fields;
use super::from_item::{FromItem, FromKey};
use super::item::Item;
use super::keys::{Kind, SceneKey, TableKeys, Variants, key, variant, vector};
use super::shapes::{
    CONE, CYLINDER, MESH_FILE, MeshSource, ORIGIN, PLACED, RADIUS, read_mesh, read_radii,
};
use super::source::{Located, SourceSpan};

/// A region of space. Lengths in m, directions of length 1.
#[derive(Debug, Clone, PartialEq)]
pub enum Region {
    /// A box along the axes.
    Box {
        /// Lowest corner.
        min: Located<DVec3>,
        /// Highest corner.
        max: Located<DVec3>,
    },
    /// The inside of a cylinder.
    Cylinder {
        /// Direction of the axis.
        axis: Located<DVec3>,
        /// A point on the axis.
        origin: Located<DVec3>,
        /// Its radius.
        radius: Located<f64>,
        /// Extent along the axis, from the origin; none: unbounded.
        along: Option<Located<[f64; 2]>>,
    },
    /// The inside of a sphere.
    Sphere {
        /// Its centre.
        origin: Located<DVec3>,
        /// Its radius.
        radius: Located<f64>,
    },
    /// The inside of a truncated cone.
    Cone {
        /// Direction of the axis.
        axis: Located<DVec3>,
        /// A point on the axis.
        origin: Located<DVec3>,
        /// Extent along the axis, from the origin.
        along: Located<[f64; 2]>,
        /// Radii at the two ends.
        radii: Located<[f64; 2]>,
    },
    /// The inside of a closed mesh.
    Mesh(MeshSource),
    /// The side of a plane to which its normal points.
    HalfSpace {
        /// A point on the plane.
        point: Located<DVec3>,
        /// Points into the region.
        normal: Located<DVec3>,
    },
    /// Points that lie in any of them.
    Union(Vec<Region>),
    /// Points that lie in all of them.
    Intersection(Vec<Region>),
    /// Points that lie in the first and in none of the others.
    Difference(Vec<Region>),
}

#[rustfmt::skip]
static PARTS: [SceneKey; 1] = [
    key("of", Kind::List("region", &Kind::Table(&REGION)), "[{ shape = \"sphere\", origin = [0, 0, 0], radius = 0.05 }]", "the regions"),
];

/// A region of space.
#[rustfmt::skip]
pub(super) static REGION: TableKeys = TableKeys::new(&[]).with_variants(Variants::Word {
    key: "shape",
    what: "shape of a region",
    example: "\"box\"   # or cylinder, sphere, cone, mesh, half-space, union, intersection, difference",
    text: "which further keys there are",
    absent: None,
    of: &[
        variant("box", &[&[
            key("min", vector("m"), "[0, 0, 0.1]", "lowest corner"),
            key("max", vector("m"), "[0.1, 0.1, 0.2]", "highest corner"),
        ]], "a box along the axes"),
        variant("cylinder", &[CYLINDER], "the inside of a cylinder"),
        variant("sphere", &[&[ORIGIN, RADIUS]], "the inside of a sphere"),
        variant("cone", &[CONE], "the inside of a truncated cone"),
        variant("mesh", &[&[MESH_FILE], PLACED], "the inside of a closed mesh: each edge has one triangle to either side, all turned alike"),
        variant("half-space", &[&[
            key("point", vector("m"), "[0, 0, 0]", "on the plane"),
            key("normal", Kind::Direction, "[0, 0, 1]", "points into the region"),
        ]], "the side of a plane to which its normal points"),
        variant("union", &[&PARTS], "what lies in any of them"),
        variant("intersection", &[&PARTS], "what lies in all of them"),
        variant("difference", &[&PARTS], "what lies in the first and in none of the others"),
    ],
});

impl FromItem for Region {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        let fields = item.fields(kind)?;
        Some(match fields.variant()? {
            "box" => {
                let (min, max) = read_corners(&fields);
                Region::Box { min, max }
            }
            "cylinder" => Region::Cylinder {
                axis: fields.read("axis"),
                origin: fields.read("origin"),
                radius: fields.read("radius"),
                along: fields.read("along"),
            },
            "sphere" => Region::Sphere {
                origin: fields.read("origin"),
                radius: fields.read("radius"),
            },
            "cone" => Region::Cone {
                axis: fields.read("axis"),
                origin: fields.read("origin"),
                along: fields.read("along"),
                radii: read_radii(&fields),
            },
            "mesh" => Region::Mesh(read_mesh(&fields)),
            "half-space" => Region::HalfSpace {
                point: fields.read("point"),
                normal: fields.read("normal"),
            },
            "union" => Region::Union(fields.read("of")),
            "intersection" => Region::Intersection(fields.read("of")),
            "difference" => Region::Difference(fields.read("of")),
            _ => return None,
        })
    }
}

impl FromKey for Region {
    fn placeholder(_: &SourceSpan) -> Self {
        Region::Union(Vec::new())
    }
}

/// `min` and `max`, of which no component of the second lies below that of the first.
pub(super) fn read_corners(fields: &Fields<'_>) -> (Located<DVec3>, Located<DVec3>) {
    let (min, max): (Located<DVec3>, Located<DVec3>) = (fields.read("min"), fields.read("max"));
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let (low, high) = (min[axis], max[axis]);
        if low > high {
            let message = format!("must not lie below min: in {name} min = {low} and max = {high}");
            fields.context.report(max.error(message));
        }
    }
    (min, max)
}
