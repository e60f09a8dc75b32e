//! `[[membranes]]`: elastic sheets.

use super::MaterialIndex;
use super::item::Item;
use super::region::{self, Region};
use super::shapes::{MeshSource, read_mesh};
use super::source::{Located, Place};

/// An elastic sheet: a mesh whose vertices have masses and whose edges are springs.
#[derive(Debug, Clone, PartialEq)]
pub struct Membrane {
    /// Unique among membranes and walls.
    pub name: Located<String>,
    /// Where the entry stands.
    pub place: Place,
    /// Its triangles.
    pub mesh: MeshSource,
    /// Material of its surface; its density is that of the sheet.
    pub material: Located<MaterialIndex>,
    /// Thickness, m.
    pub thickness: Located<f64>,
    /// Young's modulus, Pa; Poisson's ratio of the spring network is 1/3.
    pub youngs_modulus: Located<f64>,
    /// Damping of each spring as a fraction of critical; default 0.
    pub damping_ratio: Located<f64>,
    /// Resistance to bending; none: limp.
    pub bending: Option<Bending>,
    /// Which vertices are held; none: free.
    pub fixed: Option<Fixed>,
}

/// Resistance to bending by the elements of Bridson, Marino and Fedkiw (2003).
#[derive(Debug, Clone, PartialEq)]
pub struct Bending {
    /// How stiff.
    pub stiffness: BendingStiffness,
    /// Damping coefficient; default 0.
    pub damping: Located<f64>,
}

/// The stiffness of the bending elements.
#[derive(Debug, Clone, PartialEq)]
pub enum BendingStiffness {
    /// `plate`: that of a plate of the same thickness and modulus.
    Plate,
    /// As given.
    Given(Located<f64>),
}

/// Which vertices of a membrane are held.
#[derive(Debug, Clone, PartialEq)]
pub enum Fixed {
    /// `rim`: all on boundary edges.
    Rim,
    /// All in a region.
    Region(Box<Located<Region>>),
}

/// Reads an entry of `[[membranes]]`.
pub(super) fn read(item: &Item<'_>) -> Option<Membrane> {
    let fields = item.table()?;
    let name = fields.need("name").and_then(|item| item.name());
    let mesh = read_mesh(&fields);
    let material = fields.need("material").and_then(|item| item.material());
    let thickness = fields.need("thickness").and_then(|item| item.positive());
    let youngs_modulus = fields
        .need("youngs_modulus")
        .and_then(|item| item.positive());
    let damping_ratio = match fields.get("damping_ratio") {
        Some(item) => item.non_negative(),
        None => Some(fields.default("damping_ratio", 0.0)),
    };
    let bending = fields.get("bending").and_then(|item| read_bending(&item));
    let fixed = fields.get("fixed").and_then(|item| {
        if item.is_text() {
            return item
                .word("choice of vertices", &[("rim", ())])
                .map(|()| Fixed::Rim);
        }
        region::read(&item).map(|region| Fixed::Region(Box::new(region)))
    });
    fields.finish();
    Some(Membrane {
        name: name?,
        place: item.place.clone(),
        mesh: mesh?,
        material: material?,
        thickness: thickness?,
        youngs_modulus: youngs_modulus?,
        damping_ratio: damping_ratio?,
        bending,
        fixed,
    })
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
    let damping = match fields.get("damping") {
        Some(item) => item.non_negative(),
        None => Some(fields.default("damping", 0.0)),
    };
    fields.finish();
    Some(Bending {
        stiffness: stiffness?,
        damping: damping?,
    })
}
