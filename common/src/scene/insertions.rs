//! `[[insertions]]`: particles that come during the run.

use std::path::PathBuf;

use glam::DVec3;

use super::boundaries::NAME;
use super::cursor::Fields;
use super::from_item::FromItem;
use super::item::Item;
use super::keys::{
    Absent, Choice, Kind, SceneKey, TableKeys, Variants, Word, key, non_negative, positive,
    variant, vector, word,
};
use super::laws::Range;
use super::properties::{self, PROPERTIES, PROPERTIES_IN_MIXTURE};
use super::psd::{PSD, Psd};
use super::region::{REGION, Region};
use super::source::{Located, SourceSpan};
use super::walls::{INTERVAL, interval};
use super::{ClumpIndex, MaterialIndex};
use crate::particle_properties::PropertyValue;

/// A source of particles.
#[derive(Debug, Clone, PartialEq)]
pub struct Insertion {
    /// Unique among insertions; random choices follow from it and the seed.
    pub name: Located<String>,
    /// Where the entry stands.
    pub place: SourceSpan,
    /// Where particles appear; they lie wholly inside.
    pub region: Located<Region>,
    /// Components that are inserted; at least one.
    pub mixture: Vec<Component>,
    /// Quantity that the shares of the mixture divide; default mass.
    pub share_by: Quantity,
    /// How sizes follow the distributions; default random.
    pub method: Located<Method>,
    /// When it is done; none: only `until` ends it (a rate is then given).
    pub total: Option<Located<Target>>,
    /// How fast; none: as fast as they fit.
    pub rate: Option<Located<Rate>>,
    /// Mean velocity, m/s; default 0.
    pub velocity_mean: Located<DVec3>,
    /// Uniform deviation of each component, +-, m/s; default 0.
    pub velocity_spread: Located<DVec3>,
    /// Start, s; default 0.
    pub from: Located<f64>,
    /// End, s; none: never.
    pub until: Option<Located<f64>>,
    /// Consecutive failed placements per step before it waits for the next step; default 1000.
    pub attempts: Located<u64>,
}

/// One ingredient of a mixture.
#[derive(Debug, Clone, PartialEq)]
pub struct Component {
    /// Where the entry stands.
    pub place: SourceSpan,
    /// Kind of body.
    pub body: Body,
    /// Its sizes; a clump's size is the diameter of a sphere of equal volume. None: a clump comes in its own size.
    pub psd: Option<Located<Psd>>,
    /// Its share, scaled such that all shares of the mixture sum to 1.
    pub share: f64,
    /// Its share as it is written.
    pub stated_share: f64,
    /// Properties that differ from the default, SI; in a mixture those of the insertion hold for entries without the key.
    pub properties: Vec<PropertyValue>,
}

/// Kind of an inserted body.
#[derive(Debug, Clone, PartialEq)]
pub enum Body {
    /// Spheres of a material.
    Sphere(Located<MaterialIndex>),
    /// Copies of a clump.
    Clump(Located<ClumpIndex>),
}

/// Measure of an amount of particles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Particles.
    Number,
    /// kg
    Mass,
    /// m3
    Volume,
}

/// How sizes follow a distribution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Method {
    /// Class by class.
    Quota,
    /// Drawn independently.
    Random,
}

/// When an insertion is done, as typed.
#[derive(Debug, Clone, PartialEq)]
pub enum Target {
    /// After an amount that is given.
    Of(Total),
    /// When the particles have this fraction of a region's volume.
    Fill {
        /// Volume of the particles over that of the region within the domain.
        fraction: f64,
        /// An entry of `[[regions]]`; none: the insertion's own region.
        of: Option<Located<String>>,
    },
}

/// When an insertion is done.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Total {
    /// After so many particles.
    Number(u64),
    /// After so much mass, kg.
    Mass(f64),
    /// After so much volume of particles, m3.
    Volume(f64),
    /// When nothing fits any more.
    Full,
}

/// How fast particles come.
#[derive(Debug, Clone, PartialEq)]
pub enum Rate {
    /// Particles per second.
    Number(f64),
    /// kg/s
    Mass(f64),
    /// m3/s
    Volume(f64),
    /// A table `t,cumulative`, resolved against the folder of the scene.
    Table(PathBuf),
}

impl Word for Quantity {
    const WHAT: &'static str = "quantity";
    const WORDS: &'static [(&'static str, Self)] = &[
        ("number", Self::Number),
        ("mass", Self::Mass),
        ("volume", Self::Volume),
    ];
}

impl Word for Method {
    const WHAT: &'static str = "method";
    const WORDS: &'static [(&'static str, Self)] =
        &[("quota", Self::Quota), ("random", Self::Random)];
}

#[rustfmt::skip]
const SIZES: SceneKey = key("psd", Kind::Table(&PSD), "{ kind = \"monodisperse\", diameter = 2e-3 }   # m", "a [size distribution](#size-distributions); a clump's size is the diameter of a sphere of equal volume");
#[rustfmt::skip]
const SPHERES: &[SceneKey] = &[
    key("material", Kind::Material, "\"glass\"   # the name of a table [materials.glass]", "of spheres"),
    SIZES,
];
#[rustfmt::skip]
const CLUMPS: &[SceneKey] = &[
    key("clump", Kind::Clump, "\"rod\"   # the name of a table [clumps.rod]", "copies of a clump, in random orientations"),
    SIZES.or_open("the clump's own size"),
];

/// `[[insertions]]`
#[rustfmt::skip]
pub(super) static INSERTION: TableKeys = TableKeys::new(&[&[
    NAME,
    key("region", Kind::Table(&REGION), "{ shape = \"box\", min = [0, 0, 0.1], max = [0.1, 0.1, 0.2] }   # m", "a [region](#regions); bodies lie wholly inside"),
], PROPERTIES, &[
    key("share_by", word::<Quantity>(), "\"number\"", "what the shares of a mixture are shares of").or_word("mass"),
    key("method", word::<Method>(), "\"quota\"", "`\"quota\"`: numbers of all sizes are fixed in advance (below); needs a `total` of `number`, `mass` or `volume`").or_word("random"),
    key("total", Kind::Table(&TOTAL), "{ number = 1000 }   # or mass in kg, volume in m3, full = true", "when it is done").needed("without a `rate`; else only `until` ends it"),
    key("rate", Kind::Table(&RATE), "{ number = 1000.0 }   # 1/s; or mass in kg/s, volume in m3/s, table = \"rate.csv\"", "how fast").or_open("as fast as they fit"),
    key("velocity", Kind::Table(&VELOCITY), "{ mean = [0, 0, -0.5], spread = [0.1, 0.1, 0.1] }   # m/s", "at the start").absent(Absent::EmptyTable),
    key("attempts", Kind::Whole(1, u64::MAX), "1000", "failed placements in a row after which its region counts as full").or(1000.0),
], INTERVAL]).with_variants(Variants::Key {
    of: &[
        variant("material", &[SPHERES], "spheres"),
        variant("clump", &[CLUMPS], "copies of a clump, in random orientations"),
        variant("mixture", &[&[
            key("mixture", Kind::List("component", &Kind::Table(&COMPONENT)), "[{ material = \"glass\", psd = { kind = \"monodisperse\", diameter = 2e-3 }, share = 1.0 }]", "what comes, as a list"),
        ]], "several ingredients"),
    ],
    alone: true,
});

/// An ingredient of a mixture.
#[rustfmt::skip]
pub(super) static COMPONENT: TableKeys = TableKeys::new(&[&[
    key("share", non_negative(""), "0.5   # of the mass, unless share_by says otherwise", "its part of the mixture; all are scaled to the sum 1"),
], PROPERTIES_IN_MIXTURE]).with_variants(Variants::Key {
    of: &[
        variant("material", &[SPHERES], "spheres"),
        variant("clump", &[CLUMPS], "copies of a clump, in random orientations"),
    ],
    alone: true,
});

#[rustfmt::skip]
static TOTAL: TableKeys = TableKeys::new(&[]).with_variants(Variants::Key {
    of: &[
        variant("number", &[&[key("number", Kind::Whole(1, u64::MAX), "1000", "particles")]], "so many particles"),
        variant("mass", &[&[key("mass", positive("kg"), "0.5", "of particles")]], "so much mass"),
        variant("volume", &[&[key("volume", positive("m3"), "1e-4", "of particles")]], "so much volume of the particles themselves"),
        variant("fill", &[&[
            key("fill", Kind::Number("", Range::Above(0.0, 1.0)), "0.4", "volume of the particles themselves over that of a region within the domain; a loose heap of equal spheres is 0.6 solid"),
            key("of", Kind::Name, "\"drum\"   # the name of an entry of [[regions]]", "the region").or_open("the insertion's own region"),
        ]], "a fraction of a region's volume"),
        variant("full", &[&[key("full", Kind::Flag, "true", "until nothing fits any more")]], "all that fits"),
    ],
    alone: true,
});

const RATES: &[Choice] = &[Choice {
    keys: &["number", "mass", "volume", "table"],
    needed: true,
}];
#[rustfmt::skip]
static RATE: TableKeys = TableKeys::new(&[&[
    key("number", positive("1/s"), "1000.0", "particles per second").or_open(""),
    key("mass", positive("kg/s"), "0.1", "of particles per second").or_open(""),
    key("volume", positive("m3/s"), "1e-5", "of particles per second").or_open(""),
    key("table", Kind::File(""), "\"rate.csv\"", "columns `t,cumulative`: what `total` counts; without a `number` or `volume` there, kg").or_open(""),
]]).with_choices(RATES);

#[rustfmt::skip]
static VELOCITY: TableKeys = TableKeys::new(&[&[
    key("mean", vector("m/s"), "[0, 0, -0.5]", "mean velocity").absent(Absent::Zero),
    key("spread", Kind::Numbers("m/s", 3, Range::NonNegative), "[0.1, 0.1, 0.1]", "uniform +- for each component").absent(Absent::Zero),
]]);

/// Reads an entry of `[[insertions]]`.
pub(super) fn read(item: &Item<'_>) -> Option<Insertion> {
    let fields = item.open(&INSERTION)?;
    let mixture = read_mixture(&fields);
    let velocity = fields.section("velocity");
    let total = match fields.has("rate") {
        true => fields.read("total"),
        false => fields.require("total"),
    };
    let (from, until) = interval(&fields);
    Some(Insertion {
        name: fields.name_or_number(),
        place: item.place.clone(),
        region: fields.read("region"),
        share_by: fields.read("share_by"),
        method: fields.read("method"),
        total,
        rate: fields.read("rate"),
        from,
        until,
        attempts: fields.read("attempts"),
        velocity_mean: velocity.as_ref()?.read("mean"),
        velocity_spread: velocity?.read("spread"),
        mixture: mixture?,
    })
}

fn read_mixture(fields: &Fields<'_>) -> Option<Vec<Component>> {
    let of_all = properties::read(fields);
    if fields.variant()? != "mixture" {
        let psd = fields.read("psd");
        return Some(vec![Component {
            place: fields.place().clone(),
            body: read_body(fields)?,
            psd,
            share: 1.0,
            stated_share: 1.0,
            properties: properties::not_default(of_all),
        }]);
    }
    let mixture: Option<Located<Vec<Component>>> = fields.read("mixture");
    let mixture = mixture?;
    let place = mixture.place.clone();
    let mut components = mixture.value;
    let sum: f64 = components.iter().map(|component| component.share).sum();
    if sum <= 0.0 || sum.is_infinite() {
        let message = format!("the shares must have a sum > 0, it is {sum}");
        fields.context.report(place.error(message));
    }
    for component in &mut components {
        component.share /= sum;
        let mut given = std::mem::take(&mut component.properties);
        for (property, value) in &of_all {
            if given.iter().all(|(known, _)| known.name != property.name) {
                given.push((*property, *value));
            }
        }
        component.properties = properties::not_default(given);
    }
    Some(components)
}

impl FromItem for Component {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        let fields = item.fields(kind)?;
        let share = fields.read("share");
        let properties = properties::read(&fields);
        fields.variant()?;
        let psd = fields.read("psd");
        Some(Component {
            place: item.place.clone(),
            body: read_body(&fields)?,
            psd,
            share,
            stated_share: share,
            properties,
        })
    }
}

fn read_body(fields: &Fields<'_>) -> Option<Body> {
    match fields.variant()? {
        "clump" => Some(Body::Clump(fields.read("clump"))),
        _ => Some(Body::Sphere(fields.read("material"))),
    }
}

impl FromItem for Target {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        let fields = item.fields(kind)?;
        Some(match fields.variant()? {
            "number" => Self::Of(Total::Number(fields.require("number"))),
            "mass" => Self::Of(Total::Mass(fields.require("mass"))),
            "volume" => Self::Of(Total::Volume(fields.require("volume"))),
            "fill" => Self::Fill {
                fraction: fields.require("fill"),
                of: fields.read("of"),
            },
            _ => {
                let full: Located<bool> = fields.require("full");
                if !*full {
                    let message =
                        "can only be true; for another end give number, mass, volume or fill";
                    fields.context.report(full.error(message));
                }
                Self::Of(Total::Full)
            }
        })
    }
}

impl FromItem for Rate {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        let fields = item.fields(kind)?;
        Some(match fields.chosen(0)? {
            "number" => Rate::Number(fields.require("number")),
            "mass" => Rate::Mass(fields.require("mass")),
            "volume" => Rate::Volume(fields.require("volume")),
            _ => Rate::Table(fields.require("table")),
        })
    }
}
