//! `[[walls]]`: surfaces that particles touch.

use super::MaterialIndex;
use super::cursor::Fields;
use super::item::Item;
use super::motion::{self, Motion};
use super::settings::{Domain, flag};
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
    /// Liquid on it; none: it holds none.
    pub film: Option<WallFilm>,
}

/// Liquid on a wall.
#[derive(Debug, Clone, PartialEq)]
pub struct WallFilm {
    /// Thickness at the start, m; default 0.
    pub thickness: Located<f64>,
    /// Share of a broken bridge's liquid that stays on the wall; default 0.
    pub keeps: Located<f64>,
}

/// Wear of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Wear {
    /// Where the table stands.
    pub place: Place,
    /// The law.
    pub law: WearLaw,
    /// Factor on the worn volume; default 1.
    pub acceleration: Located<f64>,
    /// Whether the surface follows; default true. Else its depths are summed up alone.
    pub moves: bool,
    /// The surface follows when a vertex would move by more than this part of its shortest edge; default 1e-3.
    pub step: Located<f64>,
    /// Part of a move that a vertex shares with its neighbours; default 0.
    pub smoothing: Located<f64>,
    /// The run ends when a vertex is so deep, m; none: never.
    pub until_depth: Option<Located<f64>>,
}

/// A law of wear.
#[derive(Debug, Clone, PartialEq)]
pub enum WearLaw {
    /// Reye-Archard-Khrushchov: the worn volume is `coefficient`/`hardness` times what `basis` says.
    Archard {
        /// Dimensionless wear coefficient.
        coefficient: Located<f64>,
        /// Hardness, Pa.
        hardness: Located<f64>,
        /// What wears.
        basis: WearBasis,
    },
    /// Finnie's law of erosion by impacts.
    Finnie {
        /// Worn volume over m v^2 f(angle), m^3/J.
        constant: Located<f64>,
    },
    /// Oka's law of erosion by impacts.
    Oka(Box<Oka>),
}

/// Numbers of Oka's law.
#[derive(Debug, Clone, PartialEq)]
pub struct Oka {
    /// Vickers hardness, Pa.
    pub hardness: Located<f64>,
    /// Worn volume per mass of the particles at normal impact at the reference, mm^3/kg.
    pub reference_erosion: Located<f64>,
    /// Speed of the reference, m/s.
    pub reference_speed: Located<f64>,
    /// Diameter of the particles of the reference, m.
    pub reference_diameter: Located<f64>,
    /// Exponent of the speed.
    pub speed_exponent: Located<f64>,
    /// Exponent of the diameter.
    pub diameter_exponent: Located<f64>,
    /// Exponent of sin(angle).
    pub n1: Located<f64>,
    /// Exponent of 1 + H (1 - sin(angle)), H in GPa.
    pub n2: Located<f64>,
}

/// What the worn volume of Archard's law is proportional to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum WearBasis {
    /// Normal force times the way of the particle's surface along the wall.
    NormalLoad,
    /// Normal force times the slip beyond what the friction spring takes up.
    Sliding,
    /// What sliding dissipates.
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
        ShapeName::Mesh => match fields.get("wear") {
            Some(item) => read_wear(&item).map(Some),
            None => Some(None),
        },
        _ => {
            if fields.has("wear")
                && let Some(item) = fields.get("wear")
            {
                let error = item.place.error("only a mesh can wear");
                let help =
                    "make the wall a mesh: shape = \"mesh\", file = \"...\"; or leave `wear` out";
                fields.context.report(error.with_help(help));
            }
            Some(None)
        }
    };
    let film = match fields.get("film") {
        Some(item) => read_film(&item).map(Some),
        None => Some(None),
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
        wear: wear?,
        film: film?,
    })
}

fn read_film(item: &Item<'_>) -> Option<WallFilm> {
    let fields = item.table()?;
    let thickness = match fields.get("thickness") {
        Some(item) => item.non_negative(),
        None => Some(fields.default("thickness", 0.0)),
    };
    let keeps = match fields.get("keeps") {
        Some(item) => item.fraction(),
        None => Some(fields.default("keeps", 0.0)),
    };
    fields.finish();
    Some(WallFilm {
        thickness: thickness?,
        keeps: keeps?,
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

const LAWS: [(&str, LawName); 3] = [
    ("archard", LawName::Archard),
    ("finnie", LawName::Finnie),
    ("oka", LawName::Oka),
];

#[derive(Debug, Clone, Copy)]
enum LawName {
    Archard,
    Finnie,
    Oka,
}

/// Largest part of its shortest edge by which a vertex may move at once.
const LARGEST_STEP: f64 = 0.1;

fn read_wear(item: &Item<'_>) -> Option<Wear> {
    let fields = item.table()?;
    let law = fields.need("law")?.word("wear law", &LAWS)?;
    let law = match law {
        LawName::Archard => read_archard(&fields),
        LawName::Finnie => {
            let constant = fields.need("constant").and_then(|item| item.non_negative());
            constant.map(|constant| WearLaw::Finnie { constant })
        }
        LawName::Oka => read_oka(&fields),
    };
    let acceleration = match fields.get("acceleration") {
        Some(item) => item.positive(),
        None => Some(fields.default("acceleration", 1.0)),
    };
    let moves = flag(&fields, "moves", true);
    let step = match fields.get("step") {
        Some(item) => item.above(0.0, LARGEST_STEP),
        None => Some(fields.default("step", 1e-3)),
    };
    let smoothing = match fields.get("smoothing") {
        Some(item) => item.fraction(),
        None => Some(fields.default("smoothing", 0.0)),
    };
    let until_depth = match fields.get("until_depth") {
        Some(item) => item.positive().map(Some),
        None => Some(None),
    };
    fields.finish();
    Some(Wear {
        place: item.place.clone(),
        law: law?,
        acceleration: acceleration?,
        moves,
        step: step?,
        smoothing: smoothing?,
        until_depth: until_depth?,
    })
}

fn read_archard(fields: &Fields<'_>) -> Option<WearLaw> {
    let coefficient = fields.need("coefficient");
    let coefficient = coefficient.and_then(|item| item.non_negative());
    let hardness = fields.need("hardness").and_then(|item| item.positive());
    let basis = read_basis(fields);
    Some(WearLaw::Archard {
        coefficient: coefficient?,
        hardness: hardness?,
        basis: basis?,
    })
}

/// The basis of Archard's law. It has no default, because the worn volumes differ by the coefficient of friction.
fn read_basis(fields: &Fields<'_>) -> Option<WearBasis> {
    let help = "basis = \"normal-load\" (|F_n| |v_t| dt), \"sliding\" (|F_n| times the slip beyond the friction spring) or \"friction-work\" (what sliding dissipates)";
    let item = fields.need_or_help("basis", Some(help))?;
    let words = [
        ("normal-load", WearBasis::NormalLoad),
        ("sliding", WearBasis::Sliding),
        ("friction-work", WearBasis::FrictionWork),
    ];
    item.word("basis of wear", &words)
}

fn read_oka(fields: &Fields<'_>) -> Option<WearLaw> {
    let positive = |key| fields.need(key).and_then(|item| item.positive());
    let non_negative = |key| fields.need(key).and_then(|item| item.non_negative());
    let hardness = positive("hardness");
    let reference_erosion = non_negative("reference_erosion");
    let reference_speed = positive("reference_speed");
    let reference_diameter = positive("reference_diameter");
    let speed_exponent = non_negative("speed_exponent");
    let diameter_exponent = non_negative("diameter_exponent");
    let (n1, n2) = (non_negative("n1"), non_negative("n2"));
    Some(WearLaw::Oka(Box::new(Oka {
        hardness: hardness?,
        reference_erosion: reference_erosion?,
        reference_speed: reference_speed?,
        reference_diameter: reference_diameter?,
        speed_exponent: speed_exponent?,
        diameter_exponent: diameter_exponent?,
        n1: n1?,
        n2: n2?,
    })))
}
