//! `[materials.NAME]`: density and contact laws of a material.

use super::from_item::FromItem;
use super::item::Item;
use super::keys::{Kind, TableKeys, key, positive};
use super::law_reader;
use super::laws::{Law, LawPart};
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
    /// The law of dry cohesion; none: it does not stick.
    pub adhesion: Option<Law>,
}

impl Material {
    /// The law of a part.
    #[must_use]
    pub fn law(&self, part: LawPart) -> Option<&Law> {
        match part {
            LawPart::Normal => Some(&self.normal),
            LawPart::Tangential => self.tangential.as_ref(),
            LawPart::Rolling => self.rolling.as_ref(),
            LawPart::Torsion => self.torsion.as_ref(),
            LawPart::Liquid => self.liquid.as_ref(),
            LawPart::Adhesion => self.adhesion.as_ref(),
        }
    }
}

/// `[materials.NAME]`
#[rustfmt::skip]
pub(super) static MATERIAL: TableKeys = TableKeys::new(&[&[
    key("density", positive("kg/m3"), "2500.0", "in two dimensions kg/m2"),
    key("normal", Kind::Law(LawPart::Normal, true), "{ law = \"hertz\", youngs_modulus = 1e7, poisson_ratio = 0.3, restitution = 0.8 }   # Pa", "the law along the normal"),
    key("tangential", Kind::Law(LawPart::Tangential, true), "{ law = \"mindlin\", friction = 0.5 }", "the law of sliding").or_open("none: frictionless"),
    key("rolling", Kind::Law(LawPart::Rolling, true), "{ law = \"luding\", friction = 0.1 }", "the law of rolling").or_open("none"),
    key("torsion", Kind::Law(LawPart::Torsion, true), "{ law = \"luding\", friction = 0.1 }", "the law of twisting about the normal").or_open("none"),
    key("liquid", Kind::Law(LawPart::Liquid, true), "{ law = \"bagheri\", surface_tension = 0.07, contact_angle_degrees = 20.0, max_bridge_volume = 1e-11 }", "the law of liquid bridges").or_open("none: dry"),
    key("adhesion", Kind::Law(LawPart::Adhesion, true), "{ law = \"jkr\", work_of_adhesion = 0.05 }   # J/m2", "the law of dry cohesion; a pair has `liquid` or `adhesion`, not both").or_open("none: it does not stick"),
]]);

/// Reads one material. A law that is wrong is reported; the material is then left out.
pub(super) fn read(name: Located<String>, item: &Item<'_>) -> Option<Material> {
    let fields = item.open(&MATERIAL)?;
    let density = fields.read("density");
    let normal: Option<Law> = fields.read("normal");
    Some(Material {
        name,
        density,
        tangential: fields.read("tangential"),
        rolling: fields.read("rolling"),
        torsion: fields.read("torsion"),
        liquid: fields.read("liquid"),
        adhesion: fields.read("adhesion"),
        normal: normal?,
    })
}

impl FromItem for Law {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        match kind {
            Kind::Law(part, _) => law_reader::read(item, *part),
            _ => None,
        }
    }
}
