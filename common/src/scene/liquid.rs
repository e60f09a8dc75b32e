//! `[liquid]`: what holds for the liquid of the whole scene.

use super::cursor::Fields;
use super::keys::{Kind, TableKeys, Word, key, non_negative, word};
use super::source::Located;

/// `[liquid]`; the default where the table is absent.
#[derive(Debug, Clone, PartialEq)]
pub struct LiquidSettings {
    /// Whether the normal viscous force goes on at the gap `roughness` while two particles touch; default false.
    pub lubrication_in_contact: bool,
    /// Volume lost per area of the surface and second, m/s; default 0.
    pub evaporation: Located<f64>,
    /// Bridges that take the liquid of one that breaks; default all of that end.
    pub neighbours: LiquidNeighbours,
    /// Where bridges form; default at the touch.
    pub bridges_form: BridgesForm,
}

/// Where bridges form.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum BridgesForm {
    /// Where two surfaces touch (MercuryDPM).
    #[default]
    Contact,
    /// Where their films meet.
    Films,
}

/// Bridges that take the liquid of one that breaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum LiquidNeighbours {
    /// All other bridges of that end.
    #[default]
    Bridges,
    /// A bridge between two particles feeds such bridges only (MercuryDPM).
    SameKind,
}

/// How the viscous force of a bridge behaves at small gaps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Lubrication {
    /// The gap counts as at least the roughness.
    #[default]
    Clamped,
    /// Below a limiting gap there is no viscous force (MercuryDPM).
    Cut,
}

/// Measure of the volume in the fit of Lian & Seville (2016).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum LianSevilleVolume {
    /// V/R_D^3, as the fit was made.
    #[default]
    Relative,
    /// V as a number in m^3 (MercuryDPM).
    CubicMetres,
}

impl Word for BridgesForm {
    const WHAT: &'static str = "place where bridges form";
    const WORDS: &'static [(&'static str, Self)] =
        &[("contact", Self::Contact), ("films", Self::Films)];
}

impl Word for LiquidNeighbours {
    const WHAT: &'static str = "choice of neighbours";
    const WORDS: &'static [(&'static str, Self)] =
        &[("bridges", Self::Bridges), ("same-kind", Self::SameKind)];
}

impl Word for Lubrication {
    const WHAT: &'static str = "rule of lubrication";
    const WORDS: &'static [(&'static str, Self)] =
        &[("clamped", Self::Clamped), ("cut", Self::Cut)];
}

impl Word for LianSevilleVolume {
    const WHAT: &'static str = "volume of Lian & Seville's fit";
    const WORDS: &'static [(&'static str, Self)] = &[
        ("relative", Self::Relative),
        ("cubic-metres", Self::CubicMetres),
    ];
}

/// `[liquid]`
#[rustfmt::skip]
pub(super) static LIQUID: TableKeys = TableKeys::new(&[&[
    key("lubrication_in_contact", Kind::Flag, "true", "true: the normal viscous force goes on at the gap `roughness` while two particles touch").or_flag(false),
    key("bridges_form", word::<BridgesForm>(), "\"films\"", "`\"films\"`: bridges form as soon as the films meet, at a gap of the sum of their thicknesses (at walls that of the grain alone), so that viscous forces slow the approach, too ([how](../theory/liquid.md#migration))").or_word("contact"),
    key("neighbours", word::<LiquidNeighbours>(), "\"same-kind\"", "which bridges take the liquid of one that breaks: all others of that end; `\"same-kind\"`: a bridge of two particles feeds such bridges only, as in MercuryDPM").or_word("bridges"),
    key("evaporation", non_negative("m/s"), "1e-7", "volume lost per area and second, by films, bridges and films of walls ([how](../theory/liquid.md#evaporation))").or(0.0),
]]);

pub(super) fn read(fields: &Fields<'_>) -> LiquidSettings {
    LiquidSettings {
        lubrication_in_contact: fields.read("lubrication_in_contact"),
        evaporation: fields.read("evaporation"),
        neighbours: fields.read("neighbours"),
        bridges_form: fields.read("bridges_form"),
    }
}
