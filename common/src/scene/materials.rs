//! `[materials.NAME]`: density and contact laws of a material.

use super::cursor::Fields;
use super::item::Item;
use super::law_reader;
use super::laws::{LiquidLaw, NormalLaw, RollingLaw, TangentialLaw, TorsionLaw};
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
    pub normal: Located<NormalLaw>,
    /// The law of sliding; none: frictionless.
    pub tangential: Option<Located<TangentialLaw>>,
    /// The law of rolling; none: no rolling resistance.
    pub rolling: Option<Located<RollingLaw>>,
    /// The law of twisting about the normal; none: no torsional resistance.
    pub torsion: Option<Located<TorsionLaw>>,
    /// The law of liquid bridges; none: dry.
    pub liquid: Option<Located<LiquidLaw>>,
}

/// Reads one material. A law that is wrong is reported; the material is then left out.
pub(super) fn read(name: Located<String>, item: &Item<'_>) -> Option<Material> {
    let fields = item.table()?;
    let density = fields.need("density").and_then(|item| item.positive());
    let normal = read_law(&fields, "normal", law_reader::read_normal, true);
    let tangential = read_law(&fields, "tangential", law_reader::read_tangential, false);
    let rolling = read_law(&fields, "rolling", law_reader::read_rolling, false);
    let torsion = read_law(&fields, "torsion", law_reader::read_torsion, false);
    let liquid = read_law(&fields, "liquid", law_reader::read_liquid, false);
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

fn read_law<T>(
    fields: &Fields<'_>,
    key: &'static str,
    read: impl Fn(&Fields<'_>) -> Option<T>,
    needed: bool,
) -> Option<Located<T>> {
    let item = if needed {
        fields.need(key)?
    } else {
        fields.get(key)?
    };
    let value = read(&item.table()?)?;
    Some(Located {
        value,
        place: item.place,
    })
}
