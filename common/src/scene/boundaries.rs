//! `[[regions]]`, `[[deletions]]`, `[[fluxes]]`: where particles are counted or taken out.

use glam::DVec3;

use super::item::Item;
use super::region::{self, Region};
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

/// Reads an entry of `[[regions]]` or `[[deletions]]`.
pub(super) fn read_region(item: &Item<'_>) -> Option<NamedRegion> {
    let fields = item.table()?;
    let name = fields.name_or_number();
    let region = fields.need("region").and_then(|item| region::read(&item));
    fields.finish();
    Some(NamedRegion {
        name: name?,
        region: region?,
    })
}

/// Reads an entry of `[[fluxes]]`.
pub(super) fn read_flux(item: &Item<'_>) -> Option<Flux> {
    let fields = item.table()?;
    let name = fields.name_or_number();
    let plane = fields.need("plane").and_then(|item| item.table());
    fields.finish();
    let plane = plane?;
    let point = plane.need("point").and_then(|item| item.vector());
    let normal = plane.need("normal").and_then(|item| item.direction());
    let radius = plane.get("radius").and_then(|item| item.positive());
    plane.finish();
    Some(Flux {
        name: name?,
        point: point?,
        normal: normal?,
        radius,
    })
}
