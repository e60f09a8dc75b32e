//! `[[walls]]`: surfaces that particles touch.

use super::MaterialIndex;
use super::cursor::Fields;
use super::item::Item;
use super::motion::{self, Motion};
use super::settings::Domain;
use super::shapes::{self, Shape, ShapeName};
use super::source::{Located, Place};

/// A wall.
#[derive(Debug, Clone, PartialEq)]
pub struct Wall {
    /// Unique among walls.
    pub name: Located<String>,
    /// Where the entry stands.
    pub place: Place,
    /// The surface.
    pub shape: Shape,
    /// Its material.
    pub material: Located<MaterialIndex>,
    /// When it appears, s; default 0.
    pub from: Located<f64>,
    /// When it is removed, s; none: never.
    pub until: Option<Located<f64>>,
    /// Motions, in the order in which they apply.
    pub motion: Vec<Motion>,
    /// How it wears; only meshes can.
    pub wear: Option<Wear>,
}

/// Wear of a mesh: Reye-Archard-Khrushchov.
#[derive(Debug, Clone, PartialEq)]
pub struct Wear {
    /// Where the table stands.
    pub place: Place,
    /// Dimensionless wear coefficient.
    pub coefficient: Located<f64>,
    /// Hardness, Pa.
    pub hardness: Located<f64>,
    /// Factor on the worn volume; default 1.
    pub acceleration: Located<f64>,
    /// What wears; default normal-load.
    pub basis: WearBasis,
}

/// What the worn volume is proportional to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum WearBasis {
    /// Normal force times sliding distance.
    NormalLoad,
    /// Work of friction.
    FrictionWork,
}

/// Reads a wall. `domain` is `None` when it is wrong itself: what depends on it is then not checked.
pub(super) fn read(item: &Item<'_>, domain: Option<&Domain>) -> Option<Wall> {
    let fields = item.table()?;
    let name = fields.name_or_number();
    let material = fields.need("material").and_then(|item| item.material());
    let (from, until) = interval(&fields);
    let motion = fields
        .get("motion")
        .map_or(Some(Vec::new()), |item| motion::read_all(&item));
    // Which keys are known depends on the shape: without it they are not judged.
    let shape_name = shapes::read_name(&fields)?;
    let shape = shapes::read(&fields, shape_name, domain);
    let wear = match shape_name {
        ShapeName::Mesh => fields.get("wear").and_then(|item| read_wear(&item)),
        _ => None,
    };
    fields.finish();
    Some(Wall {
        name: name?,
        place: item.place.clone(),
        shape: shape?,
        material: material?,
        from: from?,
        until,
        motion: motion?,
        wear,
    })
}

/// `from` (default 0) and `until` (default never), in this order.
pub(super) fn interval(fields: &Fields<'_>) -> (Option<Located<f64>>, Option<Located<f64>>) {
    let from = match fields.get("from") {
        Some(item) => item.number(),
        None => Some(fields.default("from", 0.0)),
    };
    let until = fields.get("until").and_then(|item| item.number());
    if let (Some(from), Some(until)) = (&from, &until)
        && **until < **from
    {
        let message = format!("lies before from = {}", **from);
        fields.context.report(until.error(message));
    }
    (from, until)
}

fn read_wear(item: &Item<'_>) -> Option<Wear> {
    let fields = item.table()?;
    fields.need("law")?.word("wear law", &[("archard", ())])?;
    let coefficient = fields
        .need("coefficient")
        .and_then(|item| item.non_negative());
    let hardness = fields.need("hardness").and_then(|item| item.positive());
    let acceleration = match fields.get("acceleration") {
        Some(item) => item.positive(),
        None => Some(fields.default("acceleration", 1.0)),
    };
    let basis = fields
        .get("basis")
        .and_then(|item| {
            item.word(
                "basis of wear",
                &[
                    ("normal-load", WearBasis::NormalLoad),
                    ("friction-work", WearBasis::FrictionWork),
                ],
            )
        })
        .unwrap_or(WearBasis::NormalLoad);
    fields.finish();
    Some(Wear {
        place: item.place.clone(),
        coefficient: coefficient?,
        hardness: hardness?,
        acceleration: acceleration?,
        basis,
    })
}
