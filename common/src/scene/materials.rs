//! `[materials.NAME]`: density and contact laws of a material.

use super::item::Item;
use super::law_reader;
use super::laws::{Law, Part};
use super::source::Located;

/// A material. Contacts between two materials take mixed parameters, see
/// [`ContactOverride`](super::ContactOverride) for what replaces them.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// The name, from the head of the table.
    pub name: Located<String>,
    /// Density, kg/m3 (in two dimensions kg/m2: mass per unit length of a disc's area).
    pub density: Located<f64>,
    /// The law along the normal.
    pub normal: Law,
    /// The law of sliding; none: frictionless.
    pub tangential: Option<Law>,
    /// The law of rolling; none: no rolling resistance.
    pub rolling: Option<Law>,
    /// The law of twisting about the normal; none: no torsional resistance.
    pub torsion: Option<Law>,
    /// The law of liquid bridges; none: dry.
    pub liquid: Option<Law>,
}

impl Material {
    /// The law of a part.
    #[must_use]
    pub fn law(&self, part: Part) -> Option<&Law> {
        match part {
            Part::Normal => Some(&self.normal),
            Part::Tangential => self.tangential.as_ref(),
            Part::Rolling => self.rolling.as_ref(),
            Part::Torsion => self.torsion.as_ref(),
            Part::Liquid => self.liquid.as_ref(),
        }
    }
}

/// Reads one material. A law that is wrong is reported; the material is then left out.
pub(super) fn read(name: Located<String>, item: &Item<'_>) -> Option<Material> {
    let fields = item.table()?;
    let density = fields.need("density").and_then(|item| item.positive());
    let normal = fields
        .need("normal")
        .and_then(|item| law_reader::read(&item, Part::Normal));
    let law = |part: Part| {
        let item = fields.get(part.word())?;
        law_reader::read(&item, part)
    };
    let (tangential, rolling) = (law(Part::Tangential), law(Part::Rolling));
    let (torsion, liquid) = (law(Part::Torsion), law(Part::Liquid));
    fields.finish();
    Some(Material {
        name,
        density: density?,
        normal: normal?,
        tangential,
        rolling,
        torsion,
        liquid,
    })
}
