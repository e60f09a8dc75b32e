//! `[[bonds]]`: grains that are glued, to each other and to walls.

use super::MaterialIndex;
use super::boundaries::NAME;
use super::contacts::Pair;
use super::cursor::Fields;
use super::from_item::FromItem;
use super::item::Item;
use super::keys::{
    Absent, Kind, TableKeys, Variants, Word, key, non_negative, positive, variant, word,
};
use super::laws::Range;
use super::region::{REGION, Region};
use super::source::{Located, SourceSpan};
use super::walls::{INTERVAL, interval};

/// An entry of bonds.
#[derive(Debug, Clone, PartialEq)]
pub struct Bonds {
    /// Unique among bonds.
    pub name: Located<String>,
    /// Where the entry stands.
    pub place: SourceSpan,
    /// Materials that are glued, in either order; default any.
    pub between: Option<[Located<MaterialIndex>; 2]>,
    /// When pairs are glued; default [`BondTime::Start`].
    pub when: BondTime,
    /// Largest gap of pairs that are glued at the start, m; default a thousandth of the smaller radius.
    pub reach: Option<Located<f64>>,
    /// Both centres lie in it; default everywhere.
    pub within: Option<Located<Region>>,
    /// Names of walls to which particles are glued too; default none.
    pub walls: Vec<Located<String>>,
    /// Law of the bond.
    pub law: BondLaw,
    /// Radius of the section over the smaller of the two radii; default 1.
    pub radius_ratio: f64,
    /// Fraction of critical damping of each mode; default 0.
    pub damping: f64,
    /// Tension at which it breaks, Pa; default never.
    pub tensile_strength: Option<Located<f64>>,
    /// Shear stress at which it breaks, Pa; default never.
    pub shear_strength: Option<Located<f64>>,
    /// Coefficient of variation of both strengths; default 0.
    pub strength_spread: Located<f64>,
    /// Whether the contact law acts where a pair overlaps more than when it was glued; default true.
    pub contact: bool,
    /// Start of the time in which touches are glued, s; default 0.
    pub from: Located<f64>,
    /// Its end, s; none: never.
    pub until: Option<Located<f64>>,
}

/// When pairs are glued.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum BondTime {
    /// Those that are near each other at the start.
    #[default]
    Start,
    /// At their first touch.
    Contact,
}

impl Word for BondTime {
    const WHAT: &'static str = "time of gluing";
    const WORDS: &'static [(&'static str, Self)] =
        &[("start", Self::Start), ("contact", Self::Contact)];
}

/// Law of a bond.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BondLaw {
    /// Timoshenko's beam.
    Beam {
        /// Pa
        youngs_modulus: f64,
        /// Rigid in shear, or a number; default 0.25.
        poisson_ratio: BondPoisson,
    },
    /// Springs over the area of the section.
    Parallel {
        /// N/m3
        normal_stiffness: f64,
        /// N/m3
        shear_stiffness: f64,
    },
}

/// Poisson's ratio of a bond.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BondPoisson {
    /// A number.
    Number(f64),
    /// The beam of Euler and Bernoulli.
    RigidInShear,
}

/// Where no Poisson's ratio is given.
const POISSON_RATIO: f64 = 0.25;

/// `[[bonds]]`
#[rustfmt::skip]
pub(super) static BONDS: TableKeys = TableKeys::new(&[&[
    NAME,
    key("between", Kind::List("", &Kind::Material), "[\"glass\", \"glass\"]   # names of two materials", "materials of the pairs that are glued; walls are glued to particles of both").or_open("any"),
    key("when", word::<BondTime>(), "\"contact\"", "`\"start\"`: pairs of the start with a gap of at most `reach`; `\"contact\"`: each pair at its first touch between `from` and `until`").or_word("start"),
    key("reach", non_negative("m"), "1e-5", "largest gap of pairs that are glued at the start").or_open("1/1000 of the smaller radius"),
    key("within", Kind::Table(&REGION), "{ shape = \"box\", min = [0, 0, 0], max = [0.1, 0.1, 0.05] }   # m", "a [region](#regions) in which both centres lie when they are glued").or_open("everywhere"),
    key("walls", Kind::List("", &Kind::Text), "[\"plate\"]", "names of walls to which particles are glued too").absent(Absent::EmptyList),
    key("radius_ratio", positive(""), "0.8", "radius of the section, over the smaller radius of the pair").or(1.0),
    key("damping", non_negative(""), "0.05", "fraction of critical damping of each mode").or(0.0),
    key("tensile_strength", positive("Pa"), "1e6", "tension with bending, T/A + M r/I, at which the bond breaks").or_open("never"),
    key("shear_strength", positive("Pa"), "1e6", "shear with torsion, V/A + M_t r/J, at which the bond breaks").or_open("never"),
    key("strength_spread", non_negative(""), "0.2", "coefficient of variation of both strengths, which are lognormal by the seed and the pair").or(0.0),
    key("contact", Kind::Flag, "false", "`true`: the contact law acts where the pair overlaps more than when it was glued; `false`: not before the bond breaks").or_flag(true),
], INTERVAL]).with_variants(Variants::Word {
    key: "law",
    what: "law of bonds",
    example: "\"beam\"   # or parallel",
    text: "which further keys there are",
    absent: None,
    of: &[
        variant("beam", &[&[
            key("youngs_modulus", positive("Pa"), "1e8", "of the glue"),
            key("poisson_ratio", Kind::OneOf(&[Kind::Number("", Range::Above(-1.0, 0.5)), Kind::Keyword("rigid-in-shear")]), "\"rigid-in-shear\"   # or a number", "of the glue; `\"rigid-in-shear\"`: the beam of Euler and Bernoulli").or_open("0.25"),
        ]], "Timoshenko's beam from centre to centre, exact for a straight chain of any number of particles"),
        variant("parallel", &[&[
            key("normal_stiffness", positive("N/m3"), "1e12", "of tension and bending, per area"),
            key("shear_stiffness", positive("N/m3"), "5e11", "of shear and torsion, per area"),
        ]], "springs over the section at the middle (Potyondy & Cundall 2004)"),
    ],
});

/// Reads an entry of `[[bonds]]`.
pub(super) fn read(item: &Item<'_>) -> Option<Bonds> {
    let fields = item.open(&BONDS)?;
    let law = read_law(&fields);
    let when: BondTime = fields.read("when");
    let between: Option<Pair> = fields.read("between");
    let (from, until) = interval(&fields);
    let tensile_strength = fields.read("tensile_strength");
    let shear_strength: Option<Located<f64>> = fields.read("shear_strength");
    let strength_spread: Located<f64> = fields.read("strength_spread");
    Some(Bonds {
        name: fields.name_or_number(),
        place: item.place.clone(),
        between: between.map(|pair| pair.0),
        when,
        reach: fields.read("reach"),
        within: fields.read("within"),
        walls: fields.read("walls"),
        radius_ratio: fields.read("radius_ratio"),
        damping: fields.read("damping"),
        tensile_strength,
        shear_strength,
        strength_spread,
        contact: fields.read("contact"),
        from,
        until,
        law: law?,
    })
}

fn read_law(fields: &Fields<'_>) -> Option<BondLaw> {
    Some(match fields.variant()? {
        "beam" => {
            let ratio: Option<BondPoisson> = fields.read("poisson_ratio");
            BondLaw::Beam {
                youngs_modulus: fields.read("youngs_modulus"),
                poisson_ratio: ratio.unwrap_or(BondPoisson::Number(POISSON_RATIO)),
            }
        }
        _ => BondLaw::Parallel {
            normal_stiffness: fields.read("normal_stiffness"),
            shear_stiffness: fields.read("shear_stiffness"),
        },
    })
}

impl FromItem for BondPoisson {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        match item.is_text() {
            true => item.keyword("rigid-in-shear").map(|()| Self::RigidInShear),
            false => f64::from_item(item, kind).map(Self::Number),
        }
    }
}
