//! `[liquid]`: what holds for the liquid of the whole scene.

use super::cursor::Fields;
use super::settings::flag;
use super::source::Located;

/// `[liquid]`; the default where the table is absent.
#[derive(Debug, Clone, PartialEq)]
pub struct LiquidSettings {
    /// Whether the normal viscous force goes on at the gap `roughness` while two particles touch; default false.
    pub lubrication_in_contact: bool,
    /// Volume lost per area of the surface and second, m/s; default 0.
    pub evaporation: Located<f64>,
    /// Which bridges take the liquid of one that breaks; default all of that end.
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

/// Which bridges take the liquid of one that breaks.
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

/// What stands for the volume in the fit of Lian & Seville (2016).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum LianSevilleVolume {
    /// V/R_D^3, as the fit was made.
    #[default]
    Relative,
    /// V as a number in m^3 (MercuryDPM).
    CubicMetres,
}

pub(super) fn read(fields: &Fields<'_>) -> Option<LiquidSettings> {
    let evaporation = match fields.get("evaporation") {
        Some(item) => item.non_negative(),
        None => Some(fields.default("evaporation", 0.0)),
    };
    let neighbours = fields.get("neighbours").and_then(|item| {
        item.word(
            "choice of neighbours",
            &[
                ("bridges", LiquidNeighbours::Bridges),
                ("same-kind", LiquidNeighbours::SameKind),
            ],
        )
    });
    let bridges_form = fields.get("bridges_form").and_then(|item| {
        item.word(
            "place where bridges form",
            &[
                ("contact", BridgesForm::Contact),
                ("films", BridgesForm::Films),
            ],
        )
    });
    let settings = LiquidSettings {
        lubrication_in_contact: flag(fields, "lubrication_in_contact", false),
        evaporation: evaporation?,
        neighbours: neighbours.unwrap_or_default(),
        bridges_form: bridges_form.unwrap_or_default(),
    };
    fields.finish();
    Some(settings)
}

pub(super) fn lubrication(fields: &Fields<'_>) -> Lubrication {
    fields
        .get("lubrication")
        .and_then(|item| {
            item.word(
                "rule of lubrication",
                &[("clamped", Lubrication::Clamped), ("cut", Lubrication::Cut)],
            )
        })
        .unwrap_or_default()
}

pub(super) fn lian_seville_volume(fields: &Fields<'_>) -> LianSevilleVolume {
    fields
        .get("lian_seville_volume")
        .and_then(|item| {
            item.word(
                "volume of Lian & Seville's fit",
                &[
                    ("relative", LianSevilleVolume::Relative),
                    ("cubic-metres", LianSevilleVolume::CubicMetres),
                ],
            )
        })
        .unwrap_or_default()
}
