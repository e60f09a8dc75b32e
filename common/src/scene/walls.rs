//! `[[walls]]`: surfaces that particles touch.

use super::MaterialIndex;
use super::boundaries::NAME;
use super::cursor::Fields;
use super::from_item::FromItem;
use super::item::Item;
use super::keys::{
    Absent, Kind, SceneKey, TableKeys, Variants, Word, key, non_negative, number, positive,
    variant, word,
};
use super::laws::Range;
use super::motion::{MOTION, Motion};
use super::settings::Domain;
use super::shapes::{self, SHAPE, Shape};
use super::source::{Located, SourceSpan};

/// A wall.
#[derive(Debug, Clone, PartialEq)]
pub struct Wall {
    /// Unique among walls.
    pub name: Located<String>,
    /// Where the entry stands.
    pub place: SourceSpan,
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
    pub place: SourceSpan,
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
    /// Reye-Archard-Khrushchov: the worn volume is `coefficient`/`hardness` times the quantity of `basis`.
    Archard {
        /// Dimensionless wear coefficient.
        coefficient: Located<f64>,
        /// Hardness, Pa.
        hardness: Located<f64>,
        /// Quantity that the wear is proportional to.
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

/// Quantity that the worn volume of Archard's law is proportional to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum WearBasis {
    /// Normal force times the way of the particle's surface along the wall.
    NormalLoad,
    /// Normal force times the slip beyond what the friction spring takes up.
    Sliding,
    /// Energy that sliding dissipates.
    FrictionWork,
}

impl Word for WearBasis {
    const WHAT: &'static str = "basis of wear";
    const WORDS: &'static [(&'static str, Self)] = &[
        ("normal-load", Self::NormalLoad),
        ("sliding", Self::Sliding),
        ("friction-work", Self::FrictionWork),
    ];
}

/// `from` and `until`.
#[rustfmt::skip]
pub(super) const INTERVAL: &[SceneKey] = &[
    key("from", number("s"), "0.1", "start").or(0.0),
    key("until", number("s"), "0.5", "end").or_open("never"),
];

/// `[[walls]]`
#[rustfmt::skip]
pub(super) static WALL: TableKeys = TableKeys::new(&[&[
    NAME,
    key("material", Kind::Material, "\"glass\"   # the name of a table [materials.glass]", "its material"),
], INTERVAL, &[
    key("motion", Kind::OneOf(&[Kind::List("", &Kind::Table(&MOTION)), Kind::Keyword("external")]), "[{ kind = \"translation\", velocity = [0, 0, -0.1] }]", "a list of motions, which apply in its order; later ones carry earlier origins along. `\"external\"`: [another program](../how-to/couple-a-program.md) drives the wall").absent(Absent::EmptyList),
    key("film", Kind::Table(&FILM), "{ thickness = 1e-6, keeps = 0.5 }", "lets liquid stay on it; a mesh holds it by triangle").or_open("none"),
    key("wear", Kind::Table(&WEAR), "{ law = \"finnie\", constant = 1e-12 }", "wear of a mesh").or_open("none"),
]]).with_variants(SHAPE);

#[rustfmt::skip]
static FILM: TableKeys = TableKeys::new(&[&[
    key("thickness", non_negative("m"), "1e-6", "at the start").or(0.0),
    key("keeps", Kind::Number("", Range::Fraction), "0.5", "share of a broken bridge's liquid that stays on the wall").or(0.0),
]]);

/// Wear of a mesh.
#[rustfmt::skip]
pub(super) static WEAR: TableKeys = TableKeys::new(&[&[
    key("acceleration", positive(""), "1e6", "factor on the worn volume").or(1.0),
    key("moves", Kind::Flag, "false", "false: depths are summed up, the surface stays").or_flag(true),
    key("step", Kind::Number("", Range::Above(0.0, LARGEST_STEP)), "1e-2", "the surface follows when a vertex would move by more than this part of its shortest edge, and at the end").or(1e-3),
    key("smoothing", Kind::Number("", Range::Fraction), "0.1", "part of a vertex's volume that is shared with its neighbours at each move").or(0.0),
    key("until_depth", positive("m"), "1e-3", "the run ends when a vertex is so deep, with the reason `worn`").or_open("never"),
]]).with_variants(Variants::Word {
    key: "law",
    what: "wear law",
    example: "\"archard\"   # or finnie, oka",
    text: "which further keys there are",
    absent: None,
    of: &[
        variant("archard", &[&[
            key("coefficient", non_negative(""), "1e-3", "K; the worn volume is K/H times what `basis` says"),
            HARDNESS,
            // It has no default, because the worn volumes differ by the coefficient of friction.
            key("basis", word::<WearBasis>(), "\"sliding\"   # |F_n| times the slip beyond the friction spring; or \"normal-load\" (|F_n| |v_t| dt), \"friction-work\" (what sliding dissipates)", "`\"normal-load\"`: normal force times the way of the particle's surface along the wall; `\"sliding\"`: times the slip beyond what the friction spring takes up; `\"friction-work\"`: what sliding dissipates"),
        ]], "Reye-Archard-Khrushchov"),
        variant("finnie", &[&[
            key("constant", non_negative("m3/J"), "1e-12", "each impact removes constant m v^2 f(angle)"),
        ]], "Finnie: erosion by impacts"),
        variant("oka", &[&[
            HARDNESS,
            key("reference_erosion", non_negative(""), "65.0   # mm3/kg", "worn volume per mass of the particles at normal impact at the reference, mm3/kg"),
            key("reference_speed", positive("m/s"), "104.0", "speed of the reference"),
            key("reference_diameter", positive("m"), "326e-6", "diameter of the particles of the reference"),
            key("speed_exponent", non_negative(""), "2.35", "exponent of the speed"),
            key("diameter_exponent", non_negative(""), "0.19", "exponent of the diameter"),
            key("n1", non_negative(""), "0.8", "exponent of sin(angle)"),
            key("n2", non_negative(""), "1.3", "exponent of 1 + H (1 - sin(angle)), H in GPa"),
        ]], "Oka: erosion by impacts"),
    ],
});

const HARDNESS: SceneKey = key("hardness", positive("Pa"), "1.2e9", "H");

/// Largest part of its shortest edge by which a vertex may move at once.
const LARGEST_STEP: f64 = 0.1;

/// Reads a wall. `domain` is `None` when it is wrong itself: what depends on it is then not checked.
pub(super) fn read(item: &Item<'_>, domain: Option<&Domain>) -> Option<Wall> {
    let fields = item.open(&WALL)?;
    let shape = shapes::read(&fields, domain);
    let wear = match (fields.variant(), fields.get("wear")) {
        (None | Some("mesh"), _) | (_, None) => fields.read("wear"),
        (_, Some(item)) => {
            let error = item.place.error("only a mesh can wear");
            let help =
                "make the wall a mesh: shape = \"mesh\", file = \"...\"; or leave `wear` out";
            fields.context.report(error.with_help(help));
            None
        }
    };
    let (from, until) = interval(&fields);
    Some(Wall {
        name: fields.name_or_number(),
        place: item.place.clone(),
        material: fields.read("material"),
        from,
        until,
        motion: match fields.get("motion").filter(Item::is_text) {
            Some(item) => (item.keyword("external").into_iter())
                .map(|()| Motion::external(&item))
                .collect(),
            None => fields.read("motion"),
        },
        wear,
        film: fields.read("film"),
        // At last, so that all else has been read.
        shape: shape?,
    })
}

impl FromItem for WallFilm {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        let fields = item.fields(kind)?;
        Some(WallFilm {
            thickness: fields.read("thickness"),
            keeps: fields.read("keeps"),
        })
    }
}

/// `from` (default 0) and `until` (default never), in this order.
pub(super) fn interval(fields: &Fields<'_>) -> (Located<f64>, Option<Located<f64>>) {
    let from: Located<f64> = fields.read("from");
    let until: Option<Located<f64>> = fields.read("until");
    if let Some(until) = &until
        && **until < *from
    {
        let message = format!("lies before from = {}", *from);
        fields.context.report(until.error(message));
    }
    (from, until)
}

impl FromItem for Wear {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        let fields = item.fields(kind)?;
        let law = match fields.variant()? {
            "archard" => WearLaw::Archard {
                coefficient: fields.read("coefficient"),
                hardness: fields.read("hardness"),
                basis: fields.read("basis"),
            },
            "finnie" => WearLaw::Finnie {
                constant: fields.read("constant"),
            },
            "oka" => WearLaw::Oka(Box::new(Oka {
                hardness: fields.read("hardness"),
                reference_erosion: fields.read("reference_erosion"),
                reference_speed: fields.read("reference_speed"),
                reference_diameter: fields.read("reference_diameter"),
                speed_exponent: fields.read("speed_exponent"),
                diameter_exponent: fields.read("diameter_exponent"),
                n1: fields.read("n1"),
                n2: fields.read("n2"),
            })),
            _ => return None,
        };
        Some(Wear {
            place: item.place.clone(),
            law,
            acceleration: fields.read("acceleration"),
            moves: fields.read("moves"),
            step: fields.read("step"),
            smoothing: fields.read("smoothing"),
            until_depth: fields.read("until_depth"),
        })
    }
}
