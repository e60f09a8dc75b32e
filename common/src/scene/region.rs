//! Regions of space, for insertion, counting and deletion.

use glam::DVec3;

use super::cursor::Fields;
use super::item::Item;
use super::shapes::{MeshSource, read_mesh, read_radii};
use super::source::Located;

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
    /// What lies in any of them.
    Union(Vec<Region>),
    /// What lies in all of them.
    Intersection(Vec<Region>),
    /// What lies in the first and in none of the others.
    Difference(Vec<Region>),
}

#[derive(Clone, Copy)]
enum Kind {
    Box,
    Cylinder,
    Sphere,
    Cone,
    Mesh,
    HalfSpace,
    Union,
    Intersection,
    Difference,
}

const SHAPES: [(&str, Kind); 9] = [
    ("box", Kind::Box),
    ("cylinder", Kind::Cylinder),
    ("sphere", Kind::Sphere),
    ("cone", Kind::Cone),
    ("mesh", Kind::Mesh),
    ("half-space", Kind::HalfSpace),
    ("union", Kind::Union),
    ("intersection", Kind::Intersection),
    ("difference", Kind::Difference),
];

/// Reads a region.
pub(super) fn read(item: &Item<'_>) -> Option<Located<Region>> {
    let fields = item.table()?;
    let kind = fields.need("shape")?.word("shape of a region", &SHAPES)?;
    let region = read_kind(&fields, kind);
    fields.finish();
    Some(Located {
        value: region?,
        place: item.place.clone(),
    })
}

fn read_kind(fields: &Fields<'_>, kind: Kind) -> Option<Region> {
    let direction = |key| fields.need(key).and_then(|item| item.direction());
    let point = |key| fields.need(key).and_then(|item| item.vector());
    let radius = || fields.need("radius").and_then(|item| item.positive());
    match kind {
        Kind::Box => {
            let (min, max) = point("min").zip(point("max"))?;
            for axis in 0..3 {
                if min[axis] > max[axis] {
                    let name = ["x", "y", "z"][axis];
                    let (low, high) = (min[axis], max[axis]);
                    fields.context.report(max.error(format!(
                        "must not lie below min: in {name} min = {low} and max = {high}"
                    )));
                }
            }
            Some(Region::Box { min, max })
        }
        Kind::Cylinder => {
            let (axis, origin, radius) = (direction("axis"), point("origin"), radius());
            let along = fields.get("along").and_then(|item| item.range());
            Some(Region::Cylinder {
                axis: axis?,
                origin: origin?,
                radius: radius?,
                along,
            })
        }
        Kind::Sphere => {
            let (origin, radius) = (point("origin"), radius());
            Some(Region::Sphere {
                origin: origin?,
                radius: radius?,
            })
        }
        Kind::Cone => {
            let (axis, origin) = (direction("axis"), point("origin"));
            let along = fields.need("along").and_then(|item| item.range());
            let radii = fields.need("radii").and_then(|item| read_radii(&item));
            Some(Region::Cone {
                axis: axis?,
                origin: origin?,
                along: along?,
                radii: radii?,
            })
        }
        Kind::Mesh => read_mesh(fields).map(Region::Mesh),
        Kind::HalfSpace => {
            let (point, normal) = (point("point"), direction("normal"));
            Some(Region::HalfSpace {
                point: point?,
                normal: normal?,
            })
        }
        Kind::Union => parts(fields).map(Region::Union),
        Kind::Intersection => parts(fields).map(Region::Intersection),
        Kind::Difference => parts(fields).map(Region::Difference),
    }
}

fn parts(fields: &Fields<'_>) -> Option<Vec<Region>> {
    let item = fields.need("of")?;
    let items = item.list()?;
    if items.is_empty() {
        item.report("must list at least one region");
        return None;
    }
    let read: Vec<Option<Region>> = items.iter().map(|item| Some(read(item)?.value)).collect();
    read.into_iter().collect()
}
