//! `[[regions]]`, `[[deletions]]`, `[[fluxes]]`: where particles are counted or taken out.

use glam::DVec3;

use super::item::Item;
use super::keys::{Kind, SceneKey, TableKeys, key, positive, vector};
use super::region::{REGION, Region};
use super::source::Located;

/// A region with a name: its content is counted (`[[regions]]`) or deleted (`[[deletions]]`).
#[derive(Debug, Clone, PartialEq)]
pub struct NamedRegion {
    /// Unique among its kind.
    pub name: Located<String>,
    /// By particle centre.
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
    /// Only within this distance of the point, m; none: everywhere.
    pub radius: Option<Located<f64>>,
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
    Some(Flux {
        name: fields.name_or_number(),
        point: plane.read("point"),
        normal: plane.read("normal"),
        radius: plane.read("radius"),
    })
}
