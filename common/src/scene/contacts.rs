//! `[[contacts]]`: what replaces the mixed parameters of a pair of materials, key by key.

use super::MaterialIndex;
use super::cursor::{Context, Fields};
use super::from_item::FromItem;
use super::item::Item;
use super::keys::{Kind, TableKeys, key};
use super::law_reader;
use super::laws::{LawKeys, LawOverride, LawPart};
use super::source::{Located, SourceSpan};

/// Parameters of the contacts between two materials (or of one with itself).
#[derive(Debug, Clone, PartialEq)]
pub struct ContactOverride {
    /// The two materials, as listed.
    pub between: [Located<MaterialIndex>; 2],
    /// Where the entry stands.
    pub place: SourceSpan,
    /// Override of the normal law.
    pub normal: Option<LawOverride>,
    /// Override of the law of sliding.
    pub tangential: Option<LawOverride>,
    /// Override of the law of rolling.
    pub rolling: Option<LawOverride>,
    /// Override of the law of torsion.
    pub torsion: Option<LawOverride>,
    /// Override of the liquid bridges.
    pub liquid: Option<LawOverride>,
    /// Override of dry cohesion.
    pub adhesion: Option<LawOverride>,
}

impl ContactOverride {
    /// Replacement for the law of a part.
    #[must_use]
    pub fn law(&self, part: LawPart) -> Option<&LawOverride> {
        match part {
            LawPart::Normal => self.normal.as_ref(),
            LawPart::Tangential => self.tangential.as_ref(),
            LawPart::Rolling => self.rolling.as_ref(),
            LawPart::Torsion => self.torsion.as_ref(),
            LawPart::Liquid => self.liquid.as_ref(),
            LawPart::Adhesion => self.adhesion.as_ref(),
        }
    }
}

/// The words under `law` of every material, in file order, as typed: an override without `law` follows them.
pub(super) type LawWords = Vec<[Option<String>; LawPart::ALL.len()]>;

/// Reads all overrides; no pair may be named twice.
pub(super) fn read_all(
    context: &Context,
    items: &[Item<'_>],
    words: &LawWords,
) -> Vec<ContactOverride> {
    let mut all: Vec<ContactOverride> = Vec::new();
    for item in items {
        let Some(new) = read(item, words) else {
            continue;
        };
        let pair = |contact: &ContactOverride| {
            let [a, b] = &contact.between;
            (a.value.min(b.value), a.value.max(b.value))
        };
        if all.iter().any(|other| pair(other) == pair(&new)) {
            let message = "the contacts of these two materials are given twice";
            context.report(
                new.between[0]
                    .error(message)
                    .with_help("put all keys into one entry"),
            );
        } else {
            all.push(new);
        }
    }
    all
}

/// `[[contacts]]`
#[rustfmt::skip]
pub(super) static CONTACTS: TableKeys = TableKeys::new(&[&[
    key("between", Kind::List("", &Kind::Material), "[\"glass\", \"steel\"]   # names of two materials", "two materials, or one twice"),
    key("normal", Kind::Law(LawPart::Normal, false), "{ restitution = 0.6 }", "keys of the law along the normal").or_open("mixed"),
    key("tangential", Kind::Law(LawPart::Tangential, false), "{ friction = 0.3 }", "keys of the law of sliding").or_open("mixed"),
    key("rolling", Kind::Law(LawPart::Rolling, false), "{ friction = 0.1 }", "keys of the law of rolling").or_open("mixed"),
    key("torsion", Kind::Law(LawPart::Torsion, false), "{ friction = 0.1 }", "keys of the law of twisting").or_open("mixed"),
    key("liquid", Kind::Law(LawPart::Liquid, false), "{ surface_tension = 0.05 }", "keys of the law of liquid bridges").or_open("mixed"),
    key("adhesion", Kind::Law(LawPart::Adhesion, false), "{ work_of_adhesion = 0.02 }", "keys of the law of dry cohesion").or_open("mixed"),
]]);

fn read(item: &Item<'_>, words: &LawWords) -> Option<ContactOverride> {
    let fields = item.open(&CONTACTS)?;
    let between: Option<Pair> = fields.read("between");
    let between = between.map(|pair| pair.0);
    let pair = between.as_ref().map(|[a, b]| [a.value, b.value]);
    let law = |part: LawPart| {
        let item = fields.get(part.word())?;
        read_law(&item.table()?, item.place, part, pair, words)
    };
    let (normal, tangential) = (law(LawPart::Normal), law(LawPart::Tangential));
    let (rolling, torsion) = (law(LawPart::Rolling), law(LawPart::Torsion));
    let (liquid, adhesion) = (law(LawPart::Liquid), law(LawPart::Adhesion));
    Some(ContactOverride {
        between: between?,
        place: item.place.clone(),
        normal,
        tangential,
        rolling,
        torsion,
        liquid,
        adhesion,
    })
}

pub(super) struct Pair(pub(super) [Located<MaterialIndex>; 2]);

impl FromItem for Pair {
    fn from_item(item: &Item<'_>, _: &'static Kind) -> Option<Self> {
        let items = item.list()?;
        let [first, second] = items.as_slice() else {
            let got = items.len();
            item.report(format!("expected the names of two materials, got {got}"));
            return None;
        };
        let (first, second) = (first.material(), second.material());
        Some(Self([first?, second?]))
    }
}

fn read_law(
    fields: &Fields<'_>,
    place: SourceSpan,
    part: LawPart,
    pair: Option<[MaterialIndex; 2]>,
    words: &LawWords,
) -> Option<LawOverride> {
    let law = fields.get("law");
    let name = |law: &Item<'_>| law.text();
    let Some(known) = law_reader::known(fields, part) else {
        return Some(LawOverride {
            name: law.as_ref().and_then(name),
            values: law_reader::unjudged(fields),
            place,
        });
    };
    let keys = match &law {
        Some(law) => law_reader::named(law, part, &known)?,
        None => law_in_force(fields, part, pair, words, &known)?,
    };
    let values = law_reader::values(fields, keys, false);
    fields.finish();
    Some(LawOverride {
        name: law.as_ref().and_then(name),
        values,
        place,
    })
}

/// The law whose keys may stand in an override that names none: that of both materials, of the only one that has one, or the
/// only law there is. `None` where there is none, which has been reported.
fn law_in_force(
    fields: &Fields<'_>,
    part: LawPart,
    pair: Option<[MaterialIndex; 2]>,
    words: &LawWords,
    known: &[(&str, &'static LawKeys)],
) -> Option<&'static LawKeys> {
    // Several names for one set of keys, or one law alone, need no name.
    if let Some(((_, first), rest)) = known.split_first()
        && rest.iter().all(|(_, other)| other.keys == first.keys)
    {
        return Some(first);
    }
    let [a, b] = pair?.map(|index| words.get(index.0)?[part as usize].as_deref());
    if a.is_some() && a == b {
        // An unknown word has been reported at the material.
        let law = known.iter().find(|(word, _)| Some(*word) == a);
        return law.map(|&(_, law)| law);
    }
    let name = |word: Option<&str>| word.map_or("none".to_owned(), |word| format!("`{word}`"));
    let message = format!(
        "the two materials have no law in common: {} and {}",
        name(a),
        name(b)
    );
    let error = fields.place().error(message);
    fields
        .context
        .report(error.with_help("name one here with `law`"));
    None
}
