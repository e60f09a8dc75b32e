//! `[[regions]]`, `[[deletions]]`, `[[fluxes]]`: where particles are counted or taken out.

use glam::DVec3;

use super::cursor::Fields;
use super::error::SceneError;
use super::item::Item;
use super::keys::{Kind, SceneKey, TableKeys, key, positive, vector};
use super::region::{REGION, Region};
use super::source::Located;

/// A region with a name: its content is counted (`[[regions]]`) or deleted (`[[deletions]]`).
#[derive(Debug, Clone, PartialEq)]
pub struct NamedRegion {
    /// Unique among its kind.
    pub name: Located<String>,
    /// Region; a particle is in it by its centre.
    pub region: Located<Region>,
}

/// A plane through which particles are counted.
#[derive(Debug, Clone, PartialEq)]
pub struct Flux {
    /// Unique among fluxes.
    pub name: Located<String>,
    /// A point on the plane, m.
    pub point: Located<DVec3>,
    /// Length 1; a particle that crosses along it counts positive.
    pub normal: Located<DVec3>,
    /// The part of it that counts.
    pub part: FluxPart,
}

/// The part of a plane that counts.
#[derive(Debug, Clone, PartialEq)]
pub enum FluxPart {
    /// All of it.
    All,
    /// Within this distance of the point, m.
    Disc(Located<f64>),
    /// A rectangle with its middle at the point: its sides, m.
    Rectangle([Located<DVec3>; 2]),
}

/// The name of an entry of a list that has one where none is given.
#[rustfmt::skip]
pub(super) const NAME: SceneKey = key("name", Kind::Name, "\"upper half\"", "unique in the list").or_open("by the number of the entry, as in `wall-1`");

/// `[[regions]]` and `[[deletions]]`
#[rustfmt::skip]
pub(super) static NAMED_REGION: TableKeys = TableKeys::new(&[&[
    NAME,
    key("region", Kind::Table(&REGION), "{ shape = \"box\", min = [0, 0, 0], max = [0.1, 0.1, 0.05] }   # m", "a [region](#regions); particles count by their centre"),
]]);

/// `[[fluxes]]`
#[rustfmt::skip]
pub(super) static FLUX: TableKeys = TableKeys::new(&[&[
    NAME,
    key("plane", Kind::Table(&FLUX_PLANE), "{ point = [0.05, 0.05, 0.02], normal = [0, 0, -1] }   # m; counted along the normal", "a plane that passes through the domain"),
]]);

#[rustfmt::skip]
static FLUX_PLANE: TableKeys = TableKeys::new(&[&[
    key("point", vector("m"), "[0.05, 0.05, 0.02]   # m, on the plane", "on the plane"),
    key("normal", Kind::Direction, "[0, 0, -1]   # the direction that counts", "what crosses along it counts positive"),
    key("radius", positive("m"), "0.05", "only what crosses so near to the point counts").or_open("unbounded"),
    key("rectangle", Kind::Table(&FLUX_RECTANGLE), "{ along = [0.2, 0, 0], across = [0, 0.1, 0] }   # m", "only what crosses within it counts: its two sides, its middle is the point; instead of `radius`").or_open("unbounded"),
]]);

#[rustfmt::skip]
static FLUX_RECTANGLE: TableKeys = TableKeys::new(&[&[
    key("along", vector("m"), "[0.2, 0, 0]", "a side, at right angles to the normal"),
    key("across", vector("m"), "[0, 0.1, 0]", "the other side, at right angles to both"),
]]);

/// Reads an entry of `[[regions]]` or `[[deletions]]`.
pub(super) fn read_region(item: &Item<'_>) -> Option<NamedRegion> {
    let fields = item.open(&NAMED_REGION)?;
    Some(NamedRegion {
        name: fields.name_or_number(),
        region: fields.read("region"),
    })
}

/// Reads an entry of `[[fluxes]]`.
pub(super) fn read_flux(item: &Item<'_>) -> Option<Flux> {
    let fields = item.open(&FLUX)?;
    let plane = fields.section("plane")?;
    let normal = plane.read("normal");
    Some(Flux {
        name: fields.name_or_number(),
        point: plane.read("point"),
        part: read_part(&plane, &normal)?,
        normal,
    })
}

fn read_part(plane: &Fields<'_>, normal: &Located<DVec3>) -> Option<FluxPart> {
    let radius: Option<Located<f64>> = plane.read("radius");
    if !plane.has("rectangle") {
        return Some(radius.map_or(FluxPart::All, FluxPart::Disc));
    }
    let refuse = |error: SceneError| {
        plane.context.report(error);
        None
    };
    let rectangle = plane.section("rectangle")?;
    if let Some(radius) = radius {
        let error = (radius.place).error("a plane has a disc or a rectangle, not both");
        return refuse(error.with_help("leave out `radius` or `rectangle`"));
    }
    let along: Located<DVec3> = rectangle.read("along");
    let across: Located<DVec3> = rectangle.read("across");
    for side in [&along, &across] {
        if side.value == DVec3::ZERO {
            return refuse(side.place.error("must not be of length 0"));
        }
    }
    // Right angles to round-off; what is no number was reported.
    let is_oblique = |a: &DVec3, b: &DVec3| a.normalize().dot(b.normalize()).abs() > 1e-9;
    for side in [&along, &across] {
        if is_oblique(side, normal) {
            return refuse(side.place.error("must be at right angles to `normal`"));
        }
    }
    if is_oblique(&along, &across) {
        return refuse(across.place.error("must be at right angles to `along`"));
    }
    Some(FluxPart::Rectangle([along, across]))
}
